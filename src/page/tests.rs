//! Pages of whatever a report says are well made, and pictures of whatever moves.

use nalgebra::Vector3;
use proptest::prelude::*;

use super::html::PLAYER_HASH;
use super::*;
use crate::fixture::{FIRST_NS, counts, estimate, scene, sketch};
use crate::motion::PoseSample;
use crate::motion::{LinkIndex, Scene, Stamp};
use crate::report::{EstimateMessage, ExportProvenance, Reported, json};
use crate::sampling::{SampledMotion, stamp};
use crate::write::export::WrittenMotion;

/// The motion of the sample scene as it would be read back.
fn motion() -> (Scene, WrittenMotion) {
    let (scene, sketch, counts, estimate) = (scene(), sketch(), counts(), estimate());
    let of = Reported {
        scene: &scene,
        inferred: &[0],
        sketch: &sketch,
        counts: &counts,
        estimate: &estimate,
        verification: None,
        settled: None,
        diagnoses: &[],
        seen: &[],
        freed: &[],
        rest: None,
    };
    let zero = Stamp(FIRST_NS);
    let report = json(&EstimateMessage::new(&of, zero, None));
    let sampled = SampledMotion::new(&scene, &sketch, &estimate, None, 240.0).expect("frames");
    let events = estimate.events.iter().map(|event| {
        let name = scene.events[event.event].name.clone();
        (stamp(zero, event.time_s), name)
    });
    let motion = WrittenMotion {
        verdict: "physical".to_owned(),
        provenance: None,
        report,
        zero,
        events: events.collect(),
        simulated_from: None,
        parameters: Vec::new(),
        estimates: sampled.estimates,
        deviations: Default::default(),
        sketches: sampled.sketches,
    };
    (scene, motion)
}

fn provenance() -> ExportProvenance {
    ExportProvenance {
        program: "enact 1".to_owned(),
        command: "enact report 'a < b.mcap'".to_owned(),
        recording: "a < b.mcap".to_owned(),
        recording_sha256: "00".repeat(32),
        scene: "a scene".to_owned(),
        scene_sha256: "11".repeat(32),
        verdict: "physical".to_owned(),
        estimate: None,
    }
}

/// Does something with what a page is made of.
fn with_page<T>(scene: &Scene, motion: &WrittenMotion, does: impl FnOnce(&Page) -> T) -> T {
    does(&Page {
        scene,
        motion,
        readings: &[],
        provenance: &provenance(),
        lost: &["a < part".to_owned()],
    })
}

fn page_of(scene: &Scene, motion: &WrittenMotion) -> Result<String, PageError> {
    with_page(scene, motion, html)
}

/// Every drawing is XML, and every element of the page that was begun is ended in its turn.
fn assert_well_made(page: &str) {
    let mut rest = page;
    while let Some(begin) = rest.find("<svg") {
        let end = begin + rest[begin..].find("</svg>").expect("an end") + "</svg>".len();
        let parsed = roxmltree::Document::parse(&rest[begin..end]);
        assert!(parsed.is_ok(), "{parsed:?}: {}", &rest[begin..end]);
        rest = &rest[end..];
    }
    // As XML but for the elements that HTML leaves open.
    let body = page.split_once("<body>").expect("a body").1;
    let body = body.replace("<br>", "<br/>").replace("</html>", "");
    let body = format!("<body>{body}");
    let parsed = roxmltree::Document::parse(&body);
    assert!(parsed.is_ok(), "{parsed:?}");
}

#[test]
fn a_page_has_all_its_parts() {
    let (scene, motion) = motion();
    let page = page_of(&scene, &motion).expect("a page");
    assert_well_made(&page);
    for part in [
        "What to try next",
        "The motion",
        "Does it fit, and what is to blame",
        "Events",
        "Distance from the samples",
        "Acted time and physical time",
        "Parameters",
        "Checks and samples",
        "bounce.restitution",
        "a &lt; part",
        "a &lt; b.mcap",
        "not said in the file",
        "inferred",
    ] {
        assert!(page.contains(part), "{part}");
    }
}

/// Bytes as browsers write hashes.
fn base64(bytes: &[u8]) -> String {
    const SIGNS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::new();
    for part in bytes.chunks(3) {
        let word = part
            .iter()
            .fold(0_u32, |word, byte| word << 8 | u32::from(*byte));
        let word = word << (8 * (3 - part.len()));
        for place in 0..4 {
            let sign = SIGNS[(word >> (18 - 6 * place)) as usize & 63];
            text.push(if place <= part.len() {
                char::from(sign)
            } else {
                '='
            });
        }
    }
    text
}

#[test]
fn the_one_script_of_a_page_is_the_one_that_it_allows() {
    use sha2::Digest;
    assert_eq!(base64(b"any carnal pleas"), "YW55IGNhcm5hbCBwbGVhcw==");
    assert_eq!(base64(&sha2::Sha256::digest(PLAYER)), PLAYER_HASH);
    let (scene, motion) = motion();
    let page = page_of(&scene, &motion).expect("a page");
    assert!(page.contains(&format!("script-src 'sha256-{PLAYER_HASH}'")));
    let (_, script) = page
        .split_once("<script class=\"player\">")
        .expect("a script");
    let (script, rest) = script.split_once("</script>").expect("its end");
    assert!(script == PLAYER && !rest.contains("<script"));
}

#[test]
fn a_motion_is_there_to_be_played_with_its_ghost() {
    let (scene, motion) = motion();
    let page = page_of(&scene, &motion).expect("a page");
    let (_, played) = page.split_once("<g class=\"played\"").expect("a motion");
    let (head, rest) = played.split_once('>').expect("attributes");
    let number = |name: &str| -> f64 {
        let (_, value) = head.split_once(&format!("data-{name}=\"")).expect("there");
        value
            .split('"')
            .next()
            .expect("an end")
            .parse()
            .expect("a number")
    };
    let (count, step_s) = (number("count"), number("step"));
    let samples = &motion.estimates[LinkIndex(0)];
    let span_s = samples[samples.len() - 1]
        .stamp
        .seconds_since(samples[0].stamp);
    assert!(
        (step_s * (count - 1.0) - span_s).abs() < 1e-3,
        "{step_s} {count} {span_s}"
    );
    // The ghost, the body and its edges: each as often as there are times.
    let (rest, _) = rest.split_once("</g>").expect("its end");
    let paths: Vec<&str> = rest.split("data-d=\"").skip(1).collect();
    assert_eq!(paths.len(), 3, "{rest}");
    for path in paths {
        let frames = path.split('"').next().expect("an end").split('|').count();
        assert_eq!(frames as f64, count);
    }
}

#[test]
fn a_motion_that_is_not_there_is_said() {
    let (scene, mut motion) = motion();
    for samples in motion.estimates.iter_mut() {
        samples.clear();
    }
    let is_none = |page: &Page| matches!(strobe_of(page), Ok(None));
    assert!(with_page(&scene, &motion, is_none));
    let page = page_of(&scene, &motion).expect("a page");
    assert_well_made(&page);
    assert!(page.contains("There is no motion to be seen"));
    motion.report = b"{}".to_vec();
    assert_well_made(&page_of(&scene, &motion).expect("a page"));
    motion.report = b"no report".to_vec();
    let error = page_of(&scene, &motion).expect_err("no report");
    assert!(
        error
            .to_string()
            .contains("expected what `enact replay` writes"),
        "{error}"
    );
}

#[test]
fn many_flights_and_events_are_not_left_out_in_silence() {
    let (scene, mut motion) = motion();
    let mut report: serde_json::Value = serde_json::from_slice(&motion.report).expect("JSON");
    let flight = report["segments"][0].clone();
    report["segments"] = vec![flight; 300].into();
    motion.report = serde_json::to_vec(&report).expect("JSON");
    let bounce = motion.events[0].clone();
    motion.events = vec![bounce; 300];
    let page = page_of(&scene, &motion).expect("a page");
    assert!(page.contains("Of 300 flights the 24 with the largest residuals"));
    assert!(page.contains("marked without their names, for there are 300"));
    assert_eq!(page.matches("class=\"card\"").count(), 24);
}

/// What would end its place in any markup that does not escape it.
const HOSTILE: &str = "<script>\"&'</svg>";

/// The pointers to all that has nothing below it.
fn leaves(value: &serde_json::Value, pointer: String, all: &mut Vec<String>) {
    let mut below = |name: &str, value| leaves(value, format!("{pointer}/{name}"), all);
    match value {
        serde_json::Value::Object(fields) => {
            for (name, value) in fields {
                below(name, value);
            }
        }
        serde_json::Value::Array(items) => {
            for (at, value) in items.iter().enumerate() {
                below(&at.to_string(), value);
            }
        }
        _ => all.push(pointer),
    }
}

#[test]
fn every_word_of_a_report_is_escaped() {
    let (scene, mut motion) = motion();
    let report: serde_json::Value = serde_json::from_slice(&motion.report).expect("JSON");
    let mut all = Vec::new();
    leaves(&report, String::new(), &mut all);
    let mut shown = 0;
    for pointer in &all {
        let mut report = report.clone();
        *report.pointer_mut(pointer).expect("it is there") = HOSTILE.into();
        motion.report = serde_json::to_vec(&report).expect("JSON");
        // A word where a number is asked for is refused.
        let Ok(page) = page_of(&scene, &motion) else {
            continue;
        };
        assert_well_made(&page);
        assert!(!page.contains("<script>"), "{pointer}");
        shown += usize::from(page.contains("&lt;script&gt;"));
    }
    assert!(shown >= 15, "{shown} of {} are on the page", all.len());
}

/// A tree of JSON with all kinds of leaves in the places of a report.
fn leaf() -> impl Strategy<Value = serde_json::Value> {
    prop_oneof![
        Just(serde_json::Value::Null),
        any::<f64>().prop_map(|number| serde_json::json!(number)),
        any::<i64>().prop_map(|number| serde_json::json!(number)),
        "\\PC{0,12}".prop_map(serde_json::Value::String),
        Just(serde_json::json!([])),
        Just(serde_json::json!(HOSTILE)),
    ]
}

/// Puts a value in the place that the numbers lead to.
fn put(value: &mut serde_json::Value, way: &[usize], new: serde_json::Value) {
    let Some((first, rest)) = way.split_first() else {
        *value = new;
        return;
    };
    match value {
        serde_json::Value::Array(items) if !items.is_empty() => {
            let at = first % items.len();
            put(&mut items[at], rest, new);
        }
        serde_json::Value::Object(fields) if !fields.is_empty() => {
            let at = first % fields.len();
            if let Some((_, field)) = fields.iter_mut().nth(at) {
                put(field, rest, new);
            }
        }
        other => *other = new,
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn whatever_a_report_says_its_page_is_well_made(
        changes in prop::collection::vec((prop::collection::vec(0..64usize, 1..5), leaf()), 1..6),
    ) {
        let (scene, mut motion) = motion();
        let mut report: serde_json::Value = serde_json::from_slice(&motion.report).expect("JSON");
        for (way, new) in changes {
            put(&mut report, &way, new);
        }
        motion.report = serde_json::to_vec(&report).expect("JSON");
        // What has other types than it should is refused; everything else is shown.
        if let Ok(page) = page_of(&scene, &motion) {
            assert_well_made(&page);
            prop_assert!(!page.contains("<script>"));
        }
    }

    #[test]
    fn wherever_bodies_are_a_picture_is_well_made(
        places in prop::collection::vec(prop::array::uniform3(-1e6..1e6f64), 1..12),
        scale in prop::sample::select(vec![0.0, 1e-9, 1e-3, 1.0]),
        view in prop::sample::select(View::ALL.to_vec()),
    ) {
        let (scene, mut motion) = motion();
        let samples = places.iter().enumerate().map(|(step, place)| {
            let at = stamp(motion.zero, 0.01 * step as f64);
            PoseSample::new(at, Vector3::from(*place) * scale, [0.0, 0.6, 0.0, 0.8])
        });
        motion.estimates[LinkIndex(0)] = samples.collect();
        let picture = with_page(&scene, &motion, |page| {
            let strobe = strobe_of(page).expect("a report");
            strobe.expect("a motion").file(view)
        });
        let document = roxmltree::Document::parse(&picture);
        prop_assert!(document.is_ok(), "{:?}", document);
        prop_assert!(!picture.contains("NaN") && !picture.contains("inf"), "numbers");
    }
}
