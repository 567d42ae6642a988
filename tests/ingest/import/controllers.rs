//! Logs of controllers and phones: their buttons become marks, and what trackers do to them is said by name.

use std::fmt::Write as _;
use std::path::Path;

use enact::config::scene_from_toml;
use enact::ingest::Recording;
use enact::motion::TakeEvent;
use nalgebra::{Isometry3, UnitQuaternion, Vector3};

use super::{BOUNCE_S, Bench, RATE_HZ, SCENE, truth};
use crate::skip::skip;

/// The truth in a world that is y up, time after time [s].
fn y_up() -> Vec<(f64, Isometry3<f64>)> {
    let back = UnitQuaternion::from_scaled_axis(Vector3::x() * -std::f64::consts::FRAC_PI_2);
    let poses = truth().into_iter().map(|of| {
        let [a, b, c, d] = of.quaternion_xyzw;
        let turn = UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(d, a, b, c));
        let pose = Isometry3::from_parts((back * of.position_m).into(), back * turn);
        (of.stamp.0 as f64 * 1e-9, pose)
    });
    poses.collect()
}

/// How far a trigger is down, as it is pressed at the bounce: slowly, as an analogue one.
fn trigger(time_s: f64) -> f64 {
    (1.0 - (time_s - BOUNCE_S - 0.02).abs() / 0.04).clamp(0.0, 1.0)
}

/// A log of OpenVR: matrices, row by row, valid or not, and a trigger.
fn openvr_csv(lost: std::ops::Range<usize>) -> String {
    let mut text = "time_s,device,bPoseIsValid,m[0][0],m[0][1],m[0][2],m[0][3],m[1][0],m[1][1],m[1][2],m[1][3],\
                    m[2][0],m[2][1],m[2][2],m[2][3],trigger,grip\n"
        .to_owned();
    for (index, (time_s, pose)) in y_up().into_iter().enumerate() {
        let is_valid = u8::from(!lost.contains(&index));
        write!(text, "{time_s:.4},ball,{is_valid}").unwrap();
        let matrix = pose.to_homogeneous();
        for row in 0..3 {
            for column in 0..4 {
                write!(text, ",{}", matrix[(row, column)]).unwrap();
            }
        }
        writeln!(text, ",{:.2},0", trigger(time_s)).unwrap();
    }
    text
}

/// A table of a headset at 90 Hz, two hands in turn, rounded to a millimetre, with buttons as words.
fn quest_csv() -> String {
    let mut text = "time_ms,body,x,y,z,qx,qy,qz,qw,index_trigger\n".to_owned();
    for frame in 0..200 {
        let time_s = f64::from(frame) / 90.0;
        for (hand, pressed_s) in [("left", 9.0), ("right", 1.0)] {
            // It goes half a millimetre a frame, and is found elsewhere once.
            let mut x = 0.0005 * f64::from(frame);
            if hand == "right" && frame >= 150 {
                x += 0.2;
            }
            let pressed = (pressed_s..pressed_s + 0.1).contains(&time_s);
            let is_lost = hand == "left" && (100..120).contains(&frame);
            if !is_lost {
                writeln!(
                    text,
                    "{:.1},{hand},{x:.3},1.2,-0.3,0,0,0,1,{pressed}",
                    1e3 * time_s
                )
                .unwrap();
            }
        }
    }
    text
}

fn marks_s(bench: &Bench, name: &str) -> Vec<f64> {
    let recording = Recording::open(&bench.path(name)).unwrap();
    let take = recording.take(&scene_from_toml(SCENE).unwrap()).unwrap();
    let first = take.events.iter().find_map(|event| match event {
        TakeEvent::Pose { sample, .. } => Some(sample.stamp),
        TakeEvent::Mark(_) => None,
    });
    let marks = take.events.iter().filter_map(|event| match event {
        TakeEvent::Mark(mark) => Some(mark.stamp.seconds_since(first.unwrap())),
        TakeEvent::Pose { .. } => None,
    });
    marks.collect()
}

#[test]
fn a_trigger_of_a_log_of_matrices_marks_the_bounce() {
    let bench = Bench::new(&[("vive.csv", &openvr_csv(20..26))]);
    let arguments = [
        "import",
        "vive.csv",
        "--from",
        "openvr",
        "--scene",
        "scene.toml",
        "-o",
    ];
    let ran = bench.enact(&[&arguments[..], &["plain.mcap"]].concat());
    assert_eq!(ran.code, Some(0), "{}{}", ran.stdout, ran.stderr);
    let offers = "--mark-column makes marks of trigger, grip, such as --mark-column \"trigger\"";
    for part in [
        offers,
        "rows without a pose: 6 that a column says are not tracked",
    ] {
        assert!(ran.stdout.contains(part), "{part}: {}", ran.stdout);
    }
    assert!(marks_s(&bench, "plain.mcap").is_empty());
    let with = ["marked.mcap", "--mark-column", "Trigger"];
    let ran = bench.enact(&[&arguments[..], &with].concat());
    assert_eq!(ran.code, Some(0), "{}{}", ran.stdout, ran.stderr);
    assert!(
        ran.stdout.contains("Trigger goes above 0.5 1 times"),
        "{}",
        ran.stdout
    );
    let half_s = marks_s(&bench, "marked.mcap");
    assert_eq!(half_s.len(), 1);
    assert!((half_s[0] - BOUNCE_S).abs() < 0.01, "{half_s:?}");
    // At another level it is pressed later.
    let with = ["late.mcap", "--mark-column", "trigger=0.9"];
    let ran = bench.enact(&[&arguments[..], &with].concat());
    assert_eq!(ran.code, Some(0), "{}{}", ran.stdout, ran.stderr);
    let late_s = marks_s(&bench, "late.mcap");
    assert!(
        late_s[0] > half_s[0] + 1.0 / RATE_HZ,
        "{late_s:?} {half_s:?}"
    );
    // The mark is enough for the estimate, six readings less or not.
    let report = bench.json(&["replay", "marked.mcap", "-o", "out.mcap"]);
    assert_eq!(report["verdict"], "physical", "{report}");
}

#[test]
fn a_column_of_marks_that_is_none_is_refused() {
    let bench = Bench::new(&[("vive.csv", &openvr_csv(0..0))]);
    for (more, part) in [
        (
            &["--mark-column", "button"][..],
            "no column \"button\" among time_s, device",
        ),
        (
            &["--mark-column", "device"],
            "column 2: \"ball\" is no number",
        ),
        (
            &["--mark-column", "trigger=far"],
            "expected the name of a column",
        ),
        (
            &["--mark-column", "trigger", "--mark", "0.3"],
            "cannot be used with",
        ),
    ] {
        let arguments = [
            &["import", "vive.csv", "--from", "openvr", "-o", "x.mcap"],
            more,
        ]
        .concat();
        let ran = bench.enact(&arguments);
        assert!(matches!(ran.code, Some(1 | 2)), "{}", ran.stdout);
        let said = ran.stdout + &ran.stderr;
        assert!(said.contains(part), "{part}: {said}");
        assert!(!bench.path("x.mcap").exists());
    }
}

#[test]
fn gaps_jumps_and_repeats_of_a_headset_are_said_by_name() {
    let bench = Bench::new(&[("quest.csv", &quest_csv())]);
    let arguments = [
        "import",
        "quest.csv",
        "--from",
        "y-up",
        "--mark-column",
        "index_trigger",
        "-o",
        "x.mcap",
    ];
    let ran = bench.enact(&arguments);
    assert_eq!(ran.code, Some(3), "{}{}", ran.stdout, ran.stderr);
    for part in [
        "note: left: some 20 readings are missing, in 1 gaps, the longest of 0.233 s (from 1.100 s)",
        "against: right: jumps 1 times, by up to 201 mm at 18.1 m/s (at 1.656 s)",
        "positions are rounded to 1 mm, and a hand that moves by less repeats",
        "index_trigger goes above 0.5 1 times: a mark each",
        "marks     1",
    ] {
        assert!(ran.stdout.contains(part), "{part}: {}", ran.stdout);
    }
    assert!(!ran.stdout.contains("left: jumps"), "{}", ran.stdout);
}

#[test]
fn rows_of_a_phone_are_matrices_with_a_time() {
    let mut text = String::new();
    for (time_s, pose) in y_up() {
        let matrix = pose.to_homogeneous();
        write!(text, "{}", 71_234.5 + time_s).unwrap();
        for row in 0..3 {
            for column in 0..4 {
                write!(text, " {}", matrix[(row, column)]).unwrap();
            }
        }
        text.push('\n');
    }
    let bench = Bench::new(&[("arkit.txt", &text)]);
    let arguments = [
        "import",
        "arkit.txt",
        "--from",
        "y-up",
        "--scene",
        "scene.toml",
        "-o",
        "x.mcap",
    ];
    let ran = bench.enact(&arguments);
    assert_eq!(ran.code, Some(0), "{}{}", ran.stdout, ran.stderr);
    let (found, truth) = (bench.poses("x.mcap"), truth());
    assert_eq!(found.len(), truth.len());
    for (found, truth) in found.iter().zip(&truth) {
        assert!(
            (found.position_m - truth.position_m).norm() < 1e-9,
            "{found:?}"
        );
        let parts = found.quaternion_xyzw.iter().zip(truth.quaternion_xyzw);
        let cosine: f64 = parts.map(|(a, b)| a * b).sum();
        assert!(1.0 - cosine.abs() < 1e-12, "{found:?}");
    }
}

#[test]
fn real_controllers_of_a_headset_repeat_by_rounding_until_they_are_put_down() {
    let real = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../shared/real/controllers/quest_touch_plus.csv");
    if !real.exists() {
        return skip(
            "real_controllers_of_a_headset_repeat_by_rounding_until_they_are_put_down",
            "no recording of real controllers",
        );
    }
    let bench = Bench::new(&[]);
    let real = real.to_str().expect("UTF-8");
    let ran = bench.enact(&["import", real, "--from", "y-up", "-o", "x.mcap"]);
    assert_eq!(ran.code, Some(3), "{}{}", ran.stdout, ran.stderr);
    for hand in ["left", "right"] {
        let of_hand = format!("against: {hand}: ");
        let line = ran.stdout.lines().find(|line| line.contains(&of_hand));
        let line = line.unwrap_or_else(|| panic!("{hand}: {}", ran.stdout));
        assert!(
            line.contains("rounded to 1 mm") && line.contains("put down"),
            "{line}"
        );
    }
    // Without its end it is a hand's.
    let part = [
        "import", real, "--from", "y-up", "--end", "8", "-o", "y.mcap",
    ];
    let ran = bench.enact(&part);
    assert_eq!(ran.code, Some(0), "{}{}", ran.stdout, ran.stderr);
    assert!(
        ran.stdout.contains("a hand that moves by less repeats"),
        "{}",
        ran.stdout
    );
}
