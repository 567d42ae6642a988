//! What is written is read back, whatever is not finite in it or lacks.

use proptest::prelude::*;
use serde_json::{Value, json};

use crate::fixture::{FIRST_NS, counts, estimate, scene, sketch};
use crate::motion::Stamp;
use crate::report::motion::{LeaningLine, RivalLine};
use crate::report::*;

/// The message of the sample scene, with a line of every kind.
fn message() -> EstimateMessage {
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
    let provenance = Provenance::default();
    let mut message = EstimateMessage::new(&of, Stamp(FIRST_NS), Some(&provenance));
    let report = &mut message.report;
    let event = &mut report.events[0];
    event.time_leans_on = Some(LeaningLine::default());
    event.contact_rivals = vec![RivalLine::default()];
    event.gap_m = f64::NAN;
    report.objective = f64::NAN;
    report.duration.physical_s = f64::NAN;
    report.suspects = vec![SuspectLine {
        unit: "m".to_owned(),
        quantities: vec![("height".to_owned(), 0.5), ("width".to_owned(), f64::NAN)],
        ..SuspectLine::default()
    }];
    report.freed = vec![SuspectLine::default()];
    report.termination.measured = vec![MeasuredLine::default()];
    report.doubts = vec![DoubtLine::default()];
    report.diagnoses = vec![DiagnosisLine::default()];
    report.goals = vec![GoalLine::default()];
    report.segments.push(SegmentLine {
        normal_n: Some(AlongLine::default()),
        friction_n: Some(AlongLine::default()),
        pivot_n: Some(AlongLine::default()),
        ..SegmentLine::default()
    });
    assert_eq!(report.events[0].impacts.len(), 1);
    report.held = vec![HeldLine::default()];
    report.verification = Some(CheckLine {
        deepest: Some(OverlapLine::default()),
        touches: vec![TouchLine::default()],
        single_shot: Some(ShotLine {
            velocity_m_s: f64::NAN,
            ..ShotLine::default()
        }),
        deviations: vec![DeviationLine::default()],
        ..CheckLine::default()
    });
    let body = BodySpreadLine {
        up: vec![UpLine::default()],
        likely_wxyz: [f64::NAN, 0.0, 0.0, 1.0],
        ..BodySpreadLine::default()
    };
    report.settled = Some(SettledLine {
        spread: Some(SpreadLine {
            bodies: vec![body],
            ..SpreadLine::default()
        }),
        ..SettledLine::default()
    });
    report.rest = Some(RestLine {
        goals: vec![LieLine {
            labels_wxyz: Some([1.0, 0.0, 0.0, f64::NAN]),
            ..LieLine::default()
        }],
        ..RestLine::default()
    });
    message
}

fn value() -> Value {
    serde_json::from_slice(&super::json(&message())).expect("JSON")
}

fn read(value: &Value) -> Result<EstimateMessage, serde_json::Error> {
    EstimateMessage::read(value.to_string().as_bytes())
}

/// The pointers to all values in a tree.
fn places(value: &Value, pointer: String, all: &mut Vec<String>) {
    let mut below = |name: &str, value| places(value, format!("{pointer}/{name}"), all);
    match value {
        Value::Object(fields) => fields.iter().for_each(|(name, value)| below(name, value)),
        Value::Array(items) => {
            for (at, value) in items.iter().enumerate() {
                below(&at.to_string(), value);
            }
        }
        _ => {}
    }
    all.push(pointer);
}

fn all_places(value: &Value) -> Vec<String> {
    let mut all = Vec::new();
    places(value, String::new(), &mut all);
    all
}

#[test]
fn what_is_written_is_read() {
    let written = message();
    let bytes = super::json(&written);
    let read = EstimateMessage::read(&bytes).expect("a message");
    // As text: NaN equals NaN there.
    assert_eq!(format!("{read:?}"), format!("{written:?}"));
    assert_eq!(super::json(&read), bytes);
    let report = EstimateReport::read(&bytes).expect("a report");
    assert_eq!(super::json(&report), super::json(&written.report));
    // A bound that does not bind is null.
    assert_eq!(
        value()["parameters"]["bounce.restitution"]["bounds"][1],
        Value::Null
    );
    assert_eq!(report.parameters.0[0].1.bounds, [0.0, f64::INFINITY]);
    assert!(!read.time_map.bodies[0].physical_s.is_empty());
}

#[test]
fn any_number_may_be_null_and_anything_may_lack() {
    let whole = value();
    let mut numbers = 0;
    for place in all_places(&whole) {
        let mut changed = whole.clone();
        let at = changed.pointer_mut(&place).expect("it is there");
        if at.is_f64() {
            *at = Value::Null;
            let read = read(&changed);
            assert!(read.is_ok(), "{place}: {read:?}");
            numbers += 1;
        }
        let Some((above, name)) = place.rsplit_once('/') else {
            continue;
        };
        let mut changed = whole.clone();
        let above = changed.pointer_mut(above).expect("it is there");
        // Of a stamp nothing may lack.
        let lacks = |fields: &mut serde_json::Map<String, Value>| fields.remove(name).is_some();
        let is_stamp = matches!(name, "sec" | "nsec");
        if above.as_object_mut().is_some_and(lacks) {
            assert_eq!(read(&changed).is_ok(), !is_stamp, "{place}");
        }
    }
    assert!(numbers > 100, "{numbers}");
}

#[test]
fn what_lacks_is_empty_or_not_known() {
    let silent = EstimateMessage::read(b"{}").expect("an object");
    let report = &silent.report;
    assert!(report.verdict.is_empty() && report.events.is_empty() && !report.is_good());
    assert!(report.objective.is_nan());
    assert_eq!(silent.time_map, TimeMapMessage::default());
    let few = json!({"events": [{"name": "a"}], "parameters": {"b": {}}});
    let report = read(&few).expect("an object").report;
    assert!(report.events[0].gap_m.is_nan() && report.events[0].time_s.is_nan());
    let bounds = report.parameters.0[0].1.bounds;
    assert_eq!(bounds, [f64::NEG_INFINITY, f64::INFINITY]);
    // Names are in the file's order.
    let report = EstimateReport::read(br#"{"parameters": {"b": {}, "a": {}}}"#);
    assert_eq!(report.expect("an object").parameters.0[0].0, "b");
    for none in ["7", "null", "[]", "{} {}", "", r#"{"events": null}"#] {
        assert!(EstimateMessage::read(none.as_bytes()).is_err(), "{none}");
    }
}

/// Something that may be in the place of anything.
fn leaf() -> impl Strategy<Value = Value> {
    prop_oneof![
        Just(Value::Null),
        any::<f64>().prop_map(|number| json!(number)),
        any::<i64>().prop_map(|number| json!(number)),
        any::<bool>().prop_map(Value::Bool),
        any::<String>().prop_map(Value::String),
        Just(json!([])),
        Just(json!({})),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn whatever_is_read_is_read_again_as_it_is_written(
        changes in prop::collection::vec((any::<prop::sample::Index>(), leaf()), 1..4),
        end in any::<prop::sample::Index>(),
    ) {
        let mut value = value();
        for (place, new) in changes {
            let all = all_places(&value);
            let place = &all[place.index(all.len())];
            *value.pointer_mut(place).expect("it is there") = new;
        }
        if let Ok(first) = read(&value) {
            let again = EstimateMessage::read(&super::json(&first)).expect("what is written");
            prop_assert_eq!(format!("{again:?}"), format!("{first:?}"));
        }
        let bytes = value.to_string().into_bytes();
        prop_assert!(EstimateMessage::read(&bytes[..end.index(bytes.len())]).is_err());
    }

    #[test]
    fn no_bytes_make_reading_panic(bytes in prop::collection::vec(any::<u8>(), 0..64)) {
        let _ = EstimateMessage::read(&bytes);
        let _ = EstimateReport::read(&bytes);
    }
}
