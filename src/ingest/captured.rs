//! Sessions that pages in browsers captured, as JSON: A-Frame's motion capture, and recordings of WebXR by iwer.
//!
//! Both are y up, in metres and milliseconds. Their poses are written as a table, which is read as any other; a trigger
//! that is pressed is a mark.

mod aframe;
mod iwer;

use std::collections::BTreeMap;
use std::fmt::Write;

use serde_json::Value;

/// A session.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CapturedSession {
    /// What wrote it, in words.
    pub kind: String,
    /// A table of its poses: `time_ms`, `body`, `x` … `qw`.
    pub table: String,
    /// Buttons that were pressed, in order.
    pub presses: Vec<CapturedPress>,
    /// What was read how, and what is left aside.
    pub notes: Vec<String>,
}

/// A button went down.
#[derive(Clone, Debug, PartialEq)]
pub struct CapturedPress {
    /// On the clock of the table.
    pub time_ms: f64,
    /// Which one: `trigger`, `grip` and so on, or `button 4`.
    pub button: String,
}

/// A pose of a session.
#[derive(Clone, Copy, Debug, PartialEq)]
struct CapturedPose {
    time_ms: f64,
    position_m: [f64; 3],
    quaternion_xyzw: [f64; 4],
}

/// The button that marks where nobody says another.
const TRIGGER: &str = "trigger";

/// The columns of the table.
const HEAD: &str = "time_ms,body,x,y,z,qx,qy,qz,qw\n";

impl CapturedSession {
    /// The session in a JSON text; `None` of another JSON. Fails, in words, where it is one and cannot be read.
    pub fn of_json(text: &str) -> Result<Option<Self>, String> {
        let value: Value =
            serde_json::from_str(text).map_err(|error| format!("is no whole JSON: {error}"))?;
        if let Some(session) = iwer::session(&value) {
            return session.map(Some);
        }
        aframe::session(&value).transpose()
    }

    fn new(kind: &str) -> Self {
        Self {
            kind: kind.to_owned(),
            table: HEAD.to_owned(),
            ..Self::default()
        }
    }

    /// Adds a body; of one without poses nothing is known.
    fn add(&mut self, name: &str, poses: &[CapturedPose]) {
        // A name is one cell.
        let name: String = name
            .chars()
            .map(|c| match c {
                ',' | '"' | '\n' | '\r' | ';' | '\t' => '_',
                c => c,
            })
            .collect();
        for pose in poses {
            let _ = write!(self.table, "{},{name}", pose.time_ms);
            for number in pose.position_m.iter().chain(&pose.quaternion_xyzw) {
                let _ = write!(self.table, ",{number}");
            }
            self.table.push('\n');
        }
    }

    /// A button goes down.
    fn press(&mut self, time_ms: f64, button: impl Into<String>) {
        let button = button.into();
        self.presses.push(CapturedPress { time_ms, button });
    }

    /// With the presses in order.
    fn sort(mut self) -> Self {
        self.presses
            .sort_by(|one, other| one.time_ms.total_cmp(&other.time_ms));
        self
    }

    /// When buttons of these names went down \[ms\], by default triggers; says how often, and which others did. Fails, in
    /// words, where none of a name did.
    pub fn presses_of(&mut self, names: &[&str]) -> Result<Vec<f64>, String> {
        let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
        for press in &self.presses {
            *counts.entry(&press.button).or_default() += 1;
        }
        let is_wanted = |button: &str| match names {
            [] => button == TRIGGER,
            names => names.iter().any(|name| name.eq_ignore_ascii_case(button)),
        };
        let known = || counts.keys().copied().collect::<Vec<_>>().join(", ");
        let is_known = |name: &&&str| counts.keys().any(|of| of.eq_ignore_ascii_case(name));
        if let Some(name) = names.iter().find(|name| !is_known(name)) {
            return Err(match counts.is_empty() {
                true => format!("no button was pressed, {name:?} neither"),
                false => format!(
                    "no button {name:?} was pressed, expected one of {}",
                    known()
                ),
            });
        }
        let times = self.presses.iter().filter(|of| is_wanted(&of.button));
        let times = times.map(|of| of.time_ms).collect();
        let mut notes = Vec::new();
        for (button, count) in &counts {
            notes.push(match is_wanted(button) {
                true => format!("a {button} was pressed {count} times: a mark each"),
                false => format!(
                    "a {button} was pressed {count} times: no marks (--mark-column {button:?} makes some)"
                ),
            });
        }
        self.notes.extend(notes);
        Ok(times)
    }
}

/// A number of an object.
fn number(of: &Value, name: &str) -> Option<f64> {
    of.get(name)?.as_f64()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn other_json_is_none_and_broken_json_is_said() {
        for other in [
            "{}",
            "[]",
            "3",
            r#"{"a": 1}"#,
            r#"{"poses": 3}"#,
            r#"[{"t": 1}]"#,
        ] {
            assert_eq!(CapturedSession::of_json(other), Ok(None), "{other}");
        }
        let broken = CapturedSession::of_json(r#"{"camera": {"poses": ["#);
        assert!(broken.expect_err("broken").contains("line 1"));
    }

    #[test]
    fn a_name_stays_one_cell() {
        let mut session = CapturedSession::new("x");
        let pose = CapturedPose {
            time_ms: 1.0,
            position_m: [0.0; 3],
            quaternion_xyzw: [0.0, 0.0, 0.0, 1.0],
        };
        session.add("a,b\"c\nd", &[pose]);
        assert_eq!(session.table, format!("{HEAD}1,a_b_c_d,0,0,0,0,0,0,1\n"));
    }

    proptest! {
        /// Whatever a JSON says, it is a session, none, or refused.
        #[test]
        fn any_session_is_answered(text in "\\{\"(schema|camera|poses|frames)\":[\\[\\]{}\"a-z0-9:,. ]{0,60}\\}") {
            let _ = CapturedSession::of_json(&text);
        }
    }
}
