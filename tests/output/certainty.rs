//! How certain the motion is along its flights, as files say it: finite and positive, the same in all, and less where there
//! is less noise.

use std::fs;
use std::path::Path;

use enact::wire::Container;
use enact_tools::perform::{Acting, Style, perform, recording};
use enact_tools::replay::Program;
use serde_json::Value;
use tempfile::TempDir;

use crate::program::enact;

const ENACT: Program = Program(env!("CARGO_BIN_EXE_enact"));

/// What files say of one performance.
struct Said {
    /// The line of `replay`.
    line: Value,
    /// Messages of `/estimate/pencil/deviation`.
    messages: Vec<Value>,
    /// Rows of the table, cell by cell, the header first.
    rows: Vec<Vec<String>>,
    page: String,
}

/// A pencil acted with such a share of the usual wander and noise.
fn said(share: f64) -> Said {
    let usual = Acting::default();
    let acting = Acting {
        distortion: share,
        noise_position_m: share * usual.noise_position_m,
        noise_orientation_rad: share * usual.noise_orientation_rad,
        ..usual
    };
    let folder = TempDir::new().expect("folder");
    let path = folder.path().join("x.mcap");
    let performance = perform(&Style::Tip.truth(), &acting, 5);
    recording::write(&performance, Style::Tip.scene_toml(), &path).expect("a recording");
    let replayed = ENACT.report(&path, &[]);
    let output = replayed.output.to_str().expect("UTF-8");
    assert_eq!(replayed.said["verdict"], "physical", "{}", replayed.said);
    let made = |arguments: &[&str], name: &str| {
        let ran = enact(folder.path(), arguments);
        assert!(ran.status.success(), "{ran:?}");
        fs::read_to_string(folder.path().join(name)).expect("a file")
    };
    let table = made(
        &["export", output, "--to", "csv", "--ghost", "-o", "x.csv"],
        "x.csv",
    );
    let rows = table.lines().filter(|line| !line.starts_with('#'));
    let rows = rows.map(|line| line.split(',').map(str::to_owned).collect());
    Said {
        line: replayed.said,
        messages: messages(&replayed.output),
        rows: rows.collect(),
        page: made(&["report", output, "-o", "x.html"], "x.html"),
    }
}

fn messages(path: &Path) -> Vec<Value> {
    let container = Container::new(fs::read(path).expect("read")).expect("MCAP");
    let mut all = Vec::new();
    let mut walk = container.walk();
    while let Some(message) = walk.next_message() {
        let channel = &container.channels()[&message.channel_id];
        if channel.topic == "/estimate/pencil/deviation" {
            let schema = container.schema_of(channel).expect("a schema");
            assert_eq!(schema.name, "enact.Deviation");
            let schema: Value = serde_json::from_slice(&schema.data).expect("JSON");
            let message: Value = serde_json::from_slice(message.data).expect("JSON");
            let names = |of: &Value| -> Vec<String> {
                let object = of.as_object().expect("an object");
                object.keys().cloned().collect()
            };
            assert_eq!(names(&schema["properties"]), names(&message));
            all.push(message);
        }
    }
    all
}

const LINES: [&str; 4] = [
    "position_sd_mm",
    "orientation_sd_deg",
    "velocity_sd_mm_s",
    "angular_velocity_sd_rad_s",
];
const PARTS: [&str; 4] = [
    "position_sd_m",
    "orientation_sd_rad",
    "velocity_sd_m_s",
    "angular_velocity_sd_rad_s",
];

fn number(of: &Value) -> f64 {
    let number = of.as_f64().unwrap_or_else(|| panic!("{of} is no number"));
    assert!(number.is_finite() && number > 0.0, "{number}");
    number
}

/// The root of the sum of the squares of a message's three numbers, in the unit of lines.
fn total(message: &Value, part: usize) -> f64 {
    let three = message[PARTS[part]].as_array().expect("three numbers");
    let square: f64 = three.iter().map(|sd| number(sd).powi(2)).sum();
    square.sqrt() * [1e3, 1f64.to_degrees(), 1e3, 1.0][part]
}

#[test]
fn files_agree_and_less_noise_makes_smaller_deviations() {
    let (coarse, fine) = (said(1.0), said(0.25));
    for said in [&coarse, &fine] {
        let flights = said.line["certainty"].as_array().expect("lines");
        assert_eq!(flights.len(), 2, "{}", said.line["certainty"]);
        assert!(said.messages.len() > 50, "{}", said.messages.len());
        for (part, name) in LINES.iter().enumerate() {
            let largest = flights
                .iter()
                .map(|flight| number(&flight[name]["largest"]));
            let largest = largest.fold(0.0, f64::max);
            let along = said.messages.iter().map(|message| total(message, part));
            let along = along.fold(0.0, f64::max);
            // Lines look at 21 instants of a flight, messages at all poses.
            assert!(
                (along / largest - 1.0).abs() < 0.03,
                "{name}: {along}, {largest}"
            );
            for flight in flights {
                let median = number(&flight[name]["median"]);
                assert!(median <= number(&flight[name]["largest"]));
                number(&flight[name]["at_start"]);
                number(&flight[name]["at_end"]);
            }
        }
        assert!(said.page.contains("How certain the motion is"));
        assert!(!said.page.contains("not determined"));
        assert_table(said);
    }
    let flights = |said: &Said| said.line["certainty"].as_array().expect("lines").clone();
    for (coarse, fine) in flights(&coarse).iter().zip(flights(&fine)) {
        for name in LINES {
            let ratio = number(&coarse[name]["median"]) / number(&fine[name]["median"]);
            assert!((1.5..12.0).contains(&ratio), "{name}: {ratio}");
        }
    }
}

/// Rows of the motion have the deviations of the messages, others none.
fn assert_table(said: &Said) {
    let header = &said.rows[0];
    let first = header.iter().position(|name| name == "sd_x_m");
    let first = first.expect("a column");
    assert_eq!(header.len(), first + 12);
    let motion = header.iter().position(|name| name == "motion");
    let motion = motion.expect("a column");
    let (mut told, mut same) = (0, 0);
    for row in &said.rows[1..] {
        assert_eq!(row.len(), header.len(), "{row:?}");
        let cells = &row[first..];
        if row[motion] != "estimate" {
            assert!(cells.iter().all(String::is_empty), "{row:?}");
            continue;
        }
        told += 1;
        let sds = cells.iter().map(|cell| cell.parse().expect("a number"));
        let sds: Vec<f64> = sds.collect();
        assert!(sds.iter().all(|sd| sd.is_finite() && *sd > 0.0), "{row:?}");
        let stamp: i64 = row[1].parse().expect("a stamp");
        let is_it = |message: &&Value| {
            let at = &message["timestamp"];
            let whole = at["sec"].as_i64().expect("seconds") * 1_000_000_000;
            whole + at["nsec"].as_i64().expect("nanoseconds") == stamp
        };
        if let Some(message) = said.messages.iter().find(is_it) {
            same += 1;
            let all = PARTS
                .iter()
                .flat_map(|part| message[part].as_array().expect("three"));
            let all: Vec<f64> = all.map(number).collect();
            assert_eq!(all, sds);
        }
    }
    assert!(told > 10 && same > 10, "{told} {same}");
}
