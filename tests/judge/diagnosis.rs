//! Mistakes in what is said of a performance, through the program: each row of `docs/diagnosis.md` is
//! named with its key, and exit codes say that something is wrong.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use enact::motion::{LengthUnit, QuaternionSlip, TrackIndex};
use enact_tools::nonsense::Asked;
use enact_tools::nonsense::slips::Slip;
use enact_tools::perform::{Acting, Performance, Style, bounces, perform, recording};
use enact_tools::replay::Program;
use nalgebra::{Quaternion, UnitQuaternion};
use serde_json::Value;
use tempfile::TempDir;

const ENACT: Program = Program(env!("CARGO_BIN_EXE_enact"));

/// What is performed.
#[derive(Clone, Copy, PartialEq)]
enum Motion {
    /// A cube that bounces once.
    Cube,
    /// A cube that bounces twice, of which the scene knows once.
    CubeTwice,
    /// A pencil that bounces and lands in a mug.
    Pencil,
}

use Motion::{Cube, CubeTwice, Pencil};

/// A mistake, and what is said of it.
struct Row {
    cause: &'static str,
    key: &'static str,
    motion: Motion,
    is_timed: bool,
    /// Done to the stream.
    slip: Slip,
    /// Texts of the scene file that are replaced.
    edits: &'static [(&'static str, &'static str)],
    /// Whether all of the scene's lengths are typed in metres.
    is_in_metres: bool,
    /// What the value of the key holds.
    value: &'static str,
}

impl Row {
    const fn new(cause: &'static str, key: &'static str, motion: Motion, is_timed: bool) -> Self {
        Self {
            cause,
            key,
            motion,
            is_timed,
            slip: Slip::None,
            edits: &[],
            is_in_metres: false,
            value: "",
        }
    }

    const fn slip(self, slip: Slip, value: &'static str) -> Self {
        Self {
            slip,
            value,
            ..self
        }
    }

    const fn edits(
        self,
        edits: &'static [(&'static str, &'static str)],
        value: &'static str,
    ) -> Self {
        Self {
            edits,
            value,
            ..self
        }
    }
}

/// A scene file with its lengths divided by 1000. Moments come from the shape: those of a body in
/// millimetres are refused for a smaller one.
fn in_metres(toml: &str) -> String {
    let lines = toml.lines().filter(|line| !line.starts_with("moments_"));
    let of_shape: String = lines.flat_map(|line| [line, "\n"]).collect();
    let (mut text, mut rest) = (String::new(), of_shape.as_str());
    while let Some(at) = rest.find(" = [") {
        let (head, tail) = rest.split_at(at + 4);
        let key = head[..at].rsplit([' ', '\n']).next().unwrap_or_default();
        let end = tail.find(']').expect("a list ends");
        text += head;
        if key.ends_with("_mm") || key.starts_with("corner_") {
            let numbers = tail[..end].split(',');
            let metres = numbers.map(|mm| mm.trim().parse::<f64>().expect("a number") / 1e3);
            let metres: Vec<String> = metres.map(|m| format!("{m:?}")).collect();
            text += &metres.join(", ");
        } else {
            text += &tail[..end];
        }
        rest = &tail[end..];
    }
    text + rest
}

const OFFSET: &str = "position_mm = [20.0, -30.0, 150.0]";
const TURNED: &str = "orientation_wxyz = [0.8, 0.6, 0.0, 0.0]";
const PENCIL_TRACKER: &str =
    "tracker = { position_mm = [12, -5, 40], orientation_wxyz = [0.5, 0.5, 0.5, 0.5] }";
const LANDED: &str = "orientation_wxyz = [0.944, 0.016, 0.032, 0.328]";
const LEVEL: &str = "point_mm = [0.0, 0.0, 0.0]";

fn rows() -> Vec<Row> {
    let stream = |slip| Slip::StreamQuaternions(slip);
    vec![
        Row::new("up_axis", "gravity_m_s2", Cube, true).slip(Slip::YUp, "[0, -9.80665, 0]"),
        Row::new("up_axis", "gravity_m_s2", Pencil, false).slip(Slip::YUp, "[0, -9.80665, 0]"),
        Row::new("gravity_direction", "gravity_m_s2", Cube, true).edits(
            &[("[0.0, 0.0, -9.80665]", "[0, 0, 9.80665]")],
            "[0, 0, -9.80665]",
        ),
        Row::new("position_unit", "stream.position", Cube, true)
            .slip(Slip::Positions(LengthUnit::Inch), "0.0254"),
        Row::new("position_unit", "stream.position", Cube, true)
            .slip(Slip::Positions(LengthUnit::Millimetre), "0.001"),
        Row {
            is_in_metres: true,
            value: "× 1000",
            ..Row::new("scene_unit", "*_mm", Cube, true)
        },
        Row::new("stamp_unit", "stream.stamp", Cube, true).slip(Slip::Stamps(1e3), "1000"),
        Row::new("stamp_unit", "stream.stamp", Pencil, false).slip(Slip::Stamps(1e3), "1000"),
        Row::new("frame_numbers", "stream.stamp", Cube, true).slip(Slip::Frames(120.0), "120"),
        Row::new("acted_tempo", "timing.stamps", Cube, true).slip(Slip::Slow(2.5), "\"tempo\""),
        Row::new("acted_tempo", "timing.stamps", Pencil, false)
            .edits(&[("\"tempo\"", "\"physical\"")], "\"tempo\""),
        Row::new("tracker_sign", "body.tracker.position_mm", Cube, true).edits(
            &[(OFFSET, "position_mm = [-20.0, 30.0, -150.0]")],
            "[20, -30, 150]",
        ),
        Row::new("tracker_missing", "body.tracker.position_mm", Cube, true)
            .edits(&[(OFFSET, "position_mm = [0, 0, 0]")], ""),
        Row::new("tracker_offset", "body.tracker.position_mm", Cube, true)
            .edits(&[(OFFSET, "position_mm = [150.0, -30.0, 20.0]")], ""),
        Row::new("tracker_inverse", "body.tracker", Pencil, true).edits(
            &[(
                PENCIL_TRACKER,
                "tracker = { position_mm = [5, -40, -12], orientation_wxyz = [0.5, -0.5, -0.5, -0.5] }",
            )],
            "position_mm = [12, -5, 40]",
        ),
        Row::new("tracker_quaternion", "body.tracker.orientation_wxyz", Cube, true).edits(
            &[(TURNED, "orientation_wxyz = [0.6, 0.0, 0.0, 0.8]")],
            "[0.8, 0.6, 0, 0]",
        ),
        // By any rotation, as of a rigid body whose axes are its own.
        Row::new(
            "tracker_turned",
            "body.tracker.orientation_wxyz",
            Pencil,
            true,
        )
        .edits(
            &[(
                PENCIL_TRACKER,
                "tracker = { position_mm = [12, -5, 40], orientation_wxyz = [0.8, -0.36, 0.1, 0.4691] }",
            )],
            "",
        ),
        Row::new("tracker_elsewhere", "body.tracker", Pencil, true)
            .edits(&[(PENCIL_TRACKER, "")], "position_mm"),
        Row::new("goal_inverse", "goal.orientation_wxyz", Pencil, true).edits(
            &[(LANDED, "orientation_wxyz = [0.944, -0.016, -0.032, -0.328]")],
            "world from body",
        ),
        Row::new("origin", "surface.point_mm", Pencil, true).slip(Slip::Origin(0.73), ""),
        Row::new("stream_quaternion", "stream.orientation", Pencil, true)
            .slip(stream(QuaternionSlip::ScalarFirst), "x, y, z, w"),
        Row::new("stream_quaternion", "stream.orientation", Cube, true)
            .slip(stream(QuaternionSlip::ScalarLast), "x, y, z, w"),
        Row::new("stream_inverse", "stream.orientation", Cube, true)
            .slip(stream(QuaternionSlip::Inverse), "world from body"),
        Row::new("goal_quaternion", "goal.orientation_wxyz", Pencil, true).edits(
            &[(LANDED, "orientation_wxyz = [0.016, 0.032, 0.328, 0.944]")],
            "[w, x, y, z]",
        ),
        Row::new("missed_collision", "event", CubeTwice, true)
            .slip(Slip::Unmarked, "surface = \"table\""),
        Row::new("missed_collision", "event", CubeTwice, false)
            .slip(Slip::Unmarked, "surface = \"table\""),
        Row::new("surface_height", "surface.point_mm", Cube, true)
            .edits(&[(LEVEL, "point_mm = [0, 0, -730]")], ""),
        Row::new("surface_height", "surface.point_mm", Cube, false)
            .edits(&[(LEVEL, "point_mm = [0, 0, 730]")], ""),
    ]
}

fn performance(row: &Row) -> (Performance, String) {
    let acting = if row.is_timed {
        Acting::timing_known()
    } else {
        Acting::default()
    };
    let (truth, toml) = match row.motion {
        Cube => {
            let mut truth = bounces(1, 7).expect("a motion");
            let mount = &mut truth.scene.tracks[TrackIndex(0)].link_from_tracker;
            mount.rotation = UnitQuaternion::new_unchecked(Quaternion::new(0.8, 0.6, 0.0, 0.0));
            let toml = bounces::scene_toml(&truth.scene);
            (truth, toml)
        }
        CubeTwice => {
            let truth = bounces(2, 7).expect("a motion");
            let mut scene = truth.scene.clone();
            scene.events.remove(1);
            let toml = bounces::scene_toml(&scene);
            (truth, toml)
        }
        Pencil => (Style::Tip.truth(), Style::Tip.scene_toml().to_owned()),
    };
    let stamps = if row.is_timed {
        "\"physical\""
    } else {
        "\"tempo\""
    };
    (
        perform(&truth, &acting, 7),
        toml.replace("\"tempo\"", stamps),
    )
}

/// The recording of a row.
fn record(row: &Row, path: &Path) {
    let (mut performance, mut toml) = performance(row);
    for (from, to) in row.edits {
        assert!(toml.contains(from), "{from} is not in the scene");
        toml = toml.replacen(from, to, 1);
    }
    if row.is_in_metres {
        toml = in_metres(&toml);
    }
    let asked = Asked {
        scene: performance.truth.scene.clone(),
        events: performance.events.clone(),
    };
    performance.events = row.slip.put_into(asked).expect("it is there").events;
    recording::write(&performance, &toml, path).expect("written");
}

/// Replays each row: the likeliest mistake is its cause, with its key and value.
fn assert_named(rows: impl Iterator<Item = Row>) {
    let folder = TempDir::new().expect("a folder");
    let path = folder.path().join("take.mcap");
    let mut wrong = Vec::new();
    for row in rows {
        record(&row, &path);
        let replayed = ENACT.report(&path, &[]);
        let first = &replayed.said["diagnoses"][0];
        let value = first["value"].as_str().unwrap_or_default();
        let is_named = first["cause"] == row.cause
            && first["key"] == row.key
            && value.contains(row.value)
            && replayed.code == Some(exit_code(&replayed.said));
        if !is_named {
            let Row { cause, slip, .. } = row;
            wrong.push(format!("{cause} ({slip:?}): {first}; {replayed:?}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Of a wrong answer, or of none.
fn exit_code(report: &Value) -> i32 {
    if report["error"].is_null() { 3 } else { 1 }
}

#[test]
fn mistakes_in_streams_are_named_with_the_field_to_change() {
    assert_named(rows().into_iter().filter(|row| row.slip != Slip::None));
}

#[test]
fn mistakes_in_scenes_are_named_with_the_key_to_change() {
    assert_named(rows().into_iter().filter(|row| row.slip == Slip::None));
}

#[test]
fn mistakes_stand_under_the_first_line_or_after_the_error() {
    let folder = TempDir::new().expect("a folder");
    let path = folder.path().join("take.mcap");
    let mut codes = BTreeSet::new();
    for slip in [Slip::YUp, Slip::Positions(LengthUnit::Millimetre)] {
        record(&Row::new("", "", Cube, true).slip(slip, ""), &path);
        let (report, account) = (ENACT.report(&path, &[]).said, ENACT.account(&path, &[]));
        let sentence = report["diagnoses"][0]["sentence"].as_str();
        let sentence = sentence.expect("a sentence");
        if report["error"].is_null() {
            let second = account.said.lines().nth(1).expect("a second line");
            assert_eq!(second, format!("  likely: {sentence}"));
        } else {
            let after = format!("; likely: {sentence}");
            assert!(account.errors.contains(&after), "{account:?}");
        }
        assert_eq!(account.code, Some(exit_code(&report)));
        codes.extend(account.code);
    }
    assert_eq!(codes, BTreeSet::from([1, 3]));
}

#[test]
fn right_performances_are_not_corrected() {
    let folder = TempDir::new().expect("a folder");
    let path = folder.path().join("take.mcap");
    for (motion, is_timed) in [(Cube, true), (Cube, false), (Pencil, true), (Pencil, false)] {
        record(&Row::new("", "", motion, is_timed), &path);
        let replayed = ENACT.report(&path, &[]);
        assert_eq!(replayed.said["diagnoses"], serde_json::json!([]));
        assert_eq!(replayed.code, Some(0), "{:?}", replayed.said["doubts"]);
        // That a corner would go into the table if nothing kept it out is no mistake of the scene.
        let doubts = replayed.said["doubts"].as_array().expect("doubts");
        assert!(doubts.iter().all(|doubt| doubt["quantity"] == "kept_out"));
        assert_eq!(replayed.said["suspects"], serde_json::json!([]));
    }
}

/// Every cause in the documents is one that the program says.
#[test]
fn the_documents_list_every_cause() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let page = fs::read_to_string(root.join("docs/diagnosis.md")).expect("the page");
    let rows = page.lines().filter(|line| line.starts_with("| "));
    let listed: BTreeSet<String> = rows
        .filter_map(|row| {
            row.split('|')
                .nth(3)?
                .trim()
                .strip_prefix('`')?
                .strip_suffix('`')
        })
        .filter(|cause| *cause != "cause")
        .map(str::to_owned)
        .collect();
    let schema: Value = serde_json::from_str(enact::report::REPORT_SCHEMA).expect("JSON");
    let causes = &schema["properties"]["diagnoses"]["items"]["properties"]["cause"]["enum"];
    let causes = causes.as_array().expect("causes");
    let causes = causes.iter().filter_map(Value::as_str).map(str::to_owned);
    assert_eq!(listed, causes.collect());
    // Labels are offered where a die comes to rest: `tests/estimate/rest.rs`; two bodies stick together in
    // `tests/command/sticking.rs`.
    let tested = self::rows().into_iter().map(|row| row.cause);
    let elsewhere = ["goal_labels", "stuck_together"];
    let tested: BTreeSet<String> = tested.chain(elsewhere).map(str::to_owned).collect();
    assert_eq!(tested, listed);
}
