//! Lists of marks as text: JSON, CSV, and single ones as people type them.

use std::path::Path;

use serde_json::Value;

use super::error::IngestError;
use super::table::nanoseconds;

/// When a mark is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MarkTime {
    /// Since the first pose of the recording \[ns\].
    SinceFirst(i64),
    /// On the clock of the samples \[ns\].
    Stamp(i64),
}

/// A mark of a list: when, and of which event.
pub type ListedMark = (MarkTime, Option<String>);

/// Names of a time with the power of ten that makes nanoseconds of it, and whether it is a stamp.
const TIMES: [(&str, i32, bool); 10] = [
    ("stamp_ns", 0, true),
    ("stamp_s", 9, true),
    ("stamp", 0, true),
    ("time_s", 9, false),
    ("t_s", 9, false),
    ("t_ms", 6, false),
    ("time_ms", 6, false),
    ("t", 9, false),
    ("time", 9, false),
    ("seconds", 9, false),
];
const EVENTS: [&str; 4] = ["event", "name", "label", "mark"];

fn time(text: &str, power: i32, is_stamp: bool) -> Option<MarkTime> {
    let ns = nanoseconds(text, power)?;
    Some(if is_stamp {
        MarkTime::Stamp(ns)
    } else {
        MarkTime::SinceFirst(ns)
    })
}

impl MarkTime {
    /// `0.41`, seconds since the first pose, or `1700000000410000000ns`, on the clock of the samples.
    pub fn parse(text: &str) -> Option<Self> {
        match text.strip_suffix("ns") {
            Some(stamp) => time(stamp, 0, true),
            None => time(text, 9, false),
        }
    }
}

/// The marks of a file: JSON where its name ends so, otherwise CSV. Fails where one has no time.
pub fn marks_of_file(path: &Path, text: &str) -> Result<Vec<ListedMark>, IngestError> {
    let is_json = path
        .extension()
        .is_some_and(|of| of.eq_ignore_ascii_case("json"))
        || text.trim_start().starts_with(['[', '{']);
    let marks = if is_json { of_json(text) } else { of_csv(text) };
    marks.map_err(|(line, message)| IngestError::Table {
        path: path.to_owned(),
        line,
        message,
    })
}

type Fault = (usize, String);

fn of_json(text: &str) -> Result<Vec<ListedMark>, Fault> {
    // `enact … --format ndjson` prints one object and a line's end.
    let value: Value =
        serde_json::from_str(text).map_err(|error| (error.line(), format!("no JSON: {error}")))?;
    let listed = match &value {
        Value::Array(all) => Some(all),
        Value::Object(of) => ["marks", "proposals"]
            .iter()
            .filter_map(|key| of.get(*key)?.as_array())
            .find(|all| !all.is_empty()),
        _ => None,
    };
    let Some(listed) = listed else {
        let expected = "no list of marks, expected [{\"t_s\": 0.41, \"event\": \"bounce\"}, …], or such a \
                        list as \"marks\"";
        return Err((0, expected.to_owned()));
    };
    let mark = |(index, value): (usize, &Value)| -> Result<ListedMark, Fault> {
        let failed = || {
            let names: Vec<&str> = TIMES.iter().map(|(name, ..)| *name).collect();
            let message = format!(
                "mark {} is {value}, expected a time under one of {}",
                index + 1,
                names.join(", ")
            );
            (0, message)
        };
        if let Value::Number(number) = value {
            return Ok((
                time(&number.to_string(), 9, false).ok_or_else(failed)?,
                None,
            ));
        }
        let found = TIMES.iter().find_map(|(name, power, is_stamp)| {
            let text = match value.get(*name)? {
                Value::String(text) => text.clone(),
                Value::Number(number) => number.to_string(),
                _ => return None,
            };
            Some(time(&text, *power, *is_stamp))
        });
        let event = EVENTS.iter().find_map(|name| value.get(*name)?.as_str());
        Ok((
            found.flatten().ok_or_else(failed)?,
            event.map(str::to_owned),
        ))
    };
    listed.iter().enumerate().map(mark).collect()
}

fn of_csv(text: &str) -> Result<Vec<ListedMark>, Fault> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let first = text.lines().next().unwrap_or_default();
    let delimiter = [b';', b'\t', b','];
    let delimiter = delimiter
        .into_iter()
        .find(|of| first.contains(char::from(*of)));
    let mut reader = csv::ReaderBuilder::new()
        .delimiter(delimiter.unwrap_or(b','))
        .has_headers(false)
        .flexible(true)
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .from_reader(text.as_bytes());
    // Without a head: a time, and perhaps a name.
    let mut columns = (0, 9, false, Some(1));
    let mut marks = Vec::new();
    for (index, record) in reader.records().enumerate() {
        let record = record.map_err(|error| (0, format!("no CSV: {error}")))?;
        let line = record.position().map_or(0, |at| at.line() as usize);
        let find = |name: &str| record.iter().position(|of| of.eq_ignore_ascii_case(name));
        let head = TIMES
            .iter()
            .find_map(|(name, power, is_stamp)| Some((find(name)?, *power, *is_stamp)));
        if let (0, Some((column, power, is_stamp))) = (index, head) {
            let event = EVENTS.iter().find_map(|name| find(name));
            columns = (column, power, is_stamp, event);
            continue;
        }
        let (column, power, is_stamp, event) = columns;
        let cell = record.get(column).unwrap_or_default();
        let Some(time) = time(cell, power, is_stamp) else {
            let message = format!(
                "{cell:?} is no time, expected seconds since the first pose, or a head with one of {}",
                TIMES.map(|(name, ..)| name).join(", ")
            );
            return Err((line, message));
        };
        let event = event.and_then(|column| record.get(column));
        let event = event.filter(|event| !event.is_empty());
        marks.push((time, event.map(str::to_owned)));
    }
    if marks.is_empty() {
        return Err((
            0,
            "no marks, expected rows with a time and the name of an event".to_owned(),
        ));
    }
    Ok(marks)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn of(name: &str, text: &str) -> Result<Vec<ListedMark>, String> {
        marks_of_file(Path::new(name), text).map_err(|error| error.to_string())
    }

    #[test]
    fn lists_of_several_forms_are_the_same_marks() {
        let expected = vec![
            (MarkTime::SinceFirst(410_000_000), Some("bounce".to_owned())),
            (MarkTime::SinceFirst(1_500_000_000), None),
        ];
        for (name, text) in [
            ("a.json", r#"[{"t_s": 0.41, "event": "bounce"}, 1.5]"#),
            (
                "a.json",
                r#"{"marks": [{"time_s": "0.41", "name": "bounce"}, {"t_ms": 1500}]}"#,
            ),
            (
                "a.txt",
                "{\"proposals\": [{\"t\": 0.41, \"event\": \"bounce\", \"score\": 3}, {\"t\": 1.5}]}\n",
            ),
            ("a.csv", "0.41,bounce\n1.5\n"),
            ("a.csv", "event;t_ms\nbounce;410\n;1500\n"),
            (
                "a.csv",
                "\u{feff}# by hand\nt_s,event\n 0.41, bounce \n1.5,\n",
            ),
        ] {
            assert_eq!(of(name, text).as_ref(), Ok(&expected), "{text}");
        }
        let stamps = of("a.csv", "stamp_ns\n1700000000410000001\n").unwrap();
        assert_eq!(stamps, [(MarkTime::Stamp(1_700_000_000_410_000_001), None)]);
    }

    #[test]
    fn what_is_no_mark_is_said_with_its_place() {
        for (name, text, message) in [
            ("a.json", "[{\"event\": \"bounce\"}]", "mark 1 is"),
            ("a.json", "[", "a.json:1: no JSON"),
            ("a.json", "3", "no list of marks"),
            (
                "a.csv",
                "0.41\nsoon,bounce\n",
                "a.csv:2: \"soon\" is no time",
            ),
            ("a.csv", "t_s,event\n", "no marks"),
        ] {
            let error = of(name, text).unwrap_err();
            assert!(error.contains(message), "{error}");
        }
    }

    proptest! {
        #[test]
        fn any_text_is_answered(text in "[\\[\\]{}\":,;#0-9a-z_.\n -]{0,80}") {
            for name in ["a.json", "a.csv"] {
                let _ = of(name, &text);
            }
        }
    }
}
