//! Edited sketches: every segment by itself on a stream of its own, joined on one time line.

use std::path::Path;

use enact::ingest::{IngestError, Recording};
use enact::motion::{Mark, Sample, Scene, Sketch, Stamp, TakeEvent, Timing, TrackIndex};
use enact::pipeline::{Pipeline, PipelineError};
use enact::segment::{SegmentError, clean::clean, cut, refine};
use enact_tools::perform::{Acting, Performance, bounces, die, hat_box, perform};
use proptest::prelude::*;

fn kept_die() -> Recording {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    Recording::open(&root.join("recordings/die.mcap")).unwrap()
}

fn die_scene() -> Scene {
    enact::config::scene_from_toml(die::SCENE_TOML).unwrap()
}

/// A cube with that many bounces, edited.
fn edited_bounces(count: usize) -> Performance {
    let mut truth = bounces(count, 3).unwrap();
    truth.scene.timing = Timing::Edited;
    perform(&truth, &Acting::edited(), 5)
}

/// Median interval of a track's stream \[ns\], from the events.
fn interval_ns(events: &[TakeEvent], of: TrackIndex) -> i64 {
    let mut last = std::collections::BTreeMap::new();
    let mut intervals: Vec<i64> = events
        .iter()
        .filter_map(|event| match event {
            TakeEvent::Pose {
                track,
                stream,
                sample,
            } if *track == of => {
                let before = last.insert(*stream, sample.stamp.0)?;
                Some(sample.stamp.0 - before)
            }
            _ => None,
        })
        .collect();
    intervals.sort_unstable();
    intervals[intervals.len() / 2]
}

fn lengths(events: &[TakeEvent], scene: &Scene, of: TrackIndex) -> Vec<usize> {
    let count = |number: usize| {
        let is_of = |event: &&TakeEvent| matches!(event, TakeEvent::Pose { track, stream, .. } if (*track, *stream) == (of, number));
        events.iter().filter(is_of).count()
    };
    (0..scene.streams(of)).map(count).collect()
}

#[test]
fn segments_follow_one_another_with_their_marks_in_the_middle() {
    let scene = die_scene();
    let take = kept_die().take(&scene).unwrap();
    assert_eq!(
        take.report.topics.len(),
        7,
        "one per segment, none for marks"
    );
    let (sketch, counts) = clean(&scene, &take.events).unwrap();
    assert_eq!(
        (counts.used, counts.read),
        (take.events.len(), take.events.len())
    );
    let lengths = lengths(&take.events, &scene, TrackIndex(0));
    let samples = &sketch.tracks[TrackIndex(0)].samples;
    let interval = interval_ns(&take.events, TrackIndex(0));
    let mut end = 0;
    for (length, mark_s) in lengths.iter().zip(&sketch.marks_s) {
        end += length;
        let (last, first) = (&samples[end - 1], &samples[end]);
        assert_eq!(first.stamp.0 - last.stamp.0, interval);
        let middle_s = 0.5 * (last.acted_s + first.acted_s);
        assert!((mark_s - middle_s).abs() < 1e-9);
    }
    assert!(samples.windows(2).all(|pair| pair[0].stamp < pair[1].stamp));
    assert_eq!(counts.gaps, 0);

    // What is cut is what was recorded, to the last sample.
    let segments = cut(&scene, &sketch).unwrap();
    let cut_lengths: Vec<usize> = segments.iter().map(|s| s.sample_count()).collect();
    assert_eq!(cut_lengths, lengths);
    let mut same = sketch.clone();
    assert_eq!((refine(&scene, &mut same), same), (0, sketch));
}

fn place_m(sample: &Sample) -> nalgebra::Vector3<f64> {
    sample.seen.position_m().expect("a pose")
}

fn turn(sample: &Sample) -> nalgebra::UnitQuaternion<f64> {
    sample.seen.orientation().expect("a pose")
}

#[test]
fn segments_of_the_die_join_badly() {
    let scene = die_scene();
    let take = kept_die().take(&scene).unwrap();
    let (sketch, _) = clean(&scene, &take.events).unwrap();
    let segments = cut(&scene, &sketch).unwrap();
    let samples = &sketch.tracks[TrackIndex(0)].samples;
    let (mut shift_m, mut turn_rad) = (0.0_f64, 0.0_f64);
    for pair in segments.windows(2) {
        let (last, first) = (
            &samples[pair[0].views[0].samples.end - 1],
            &samples[pair[1].views[0].samples.start],
        );
        shift_m = shift_m.max((place_m(first) - place_m(last)).norm());
        turn_rad = turn_rad.max(turn(last).angle_to(&turn(first)));
    }
    assert!((0.02..0.15).contains(&shift_m), "{shift_m} m");
    assert!(
        (5.0..60.0).contains(&turn_rad.to_degrees()),
        "{turn_rad} rad"
    );
}

#[test]
fn bodies_that_meet_share_the_mark() {
    let mut truth = hat_box::truth();
    truth.scene.timing = Timing::Edited;
    // Each takes its own time for each flight.
    let acting = Acting {
        tempo_variation: 0.3,
        ..Acting::edited()
    };
    let performance = perform(&truth, &acting, 2);
    let (scene, events) = (&performance.truth.scene, &performance.events);
    assert!(
        events
            .iter()
            .all(|event| matches!(event, TakeEvent::Pose { .. }))
    );
    let (sketch, _) = clean(scene, events).unwrap();
    let segments = cut(scene, &sketch).unwrap();
    assert_eq!(segments.len(), 5);
    for (event, mark_s) in sketch.marks_s.iter().enumerate() {
        let of = |end: bool| {
            let of = segments
                .iter()
                .filter(move |s| if end { s.end_event } else { s.start_event } == Some(event));
            let sketch = &sketch;
            of.map(move |s| {
                let samples = &sketch.tracks[s.views[0].track].samples;
                let at = if end {
                    s.views[0].samples.end - 1
                } else {
                    s.views[0].samples.start
                };
                (s.views[0].track, (samples[at].acted_s - mark_s) * 1e9)
            })
        };
        let half_ns = |track| 0.5 * interval_ns(events, track) as f64;
        for (track, after_ns) in of(false) {
            assert!((after_ns - half_ns(track)).abs() < 1.5, "{after_ns}");
        }
        // The longer one ends at the mark, another before it.
        let late = of(true)
            .map(|(track, ns)| ns + half_ns(track))
            .fold(f64::NEG_INFINITY, f64::max);
        if event < 2 {
            assert!(late.abs() < 1.5, "{late}");
        } else {
            assert!(
                (late - half_ns(TrackIndex(1))).abs() < 1.5,
                "the end is at the last sample"
            );
        }
    }
    for track in [TrackIndex(0), TrackIndex(1)] {
        let lengths = lengths(events, scene, track);
        let cut = segments
            .iter()
            .filter(|s| s.views[0].track == track)
            .map(|s| s.sample_count());
        assert_eq!(cut.collect::<Vec<_>>(), lengths);
    }
}

#[test]
fn as_many_segments_as_the_events_make_are_asked_for() {
    let (recording, scene) = (kept_die(), die_scene());
    let refused = |scene: &Scene| recording.take(scene).unwrap_err();
    let mut fewer = scene.clone();
    fewer.events.pop();
    let error = refused(&fewer);
    assert!(
        matches!(&error, IngestError::SegmentCount { expected: 6, found, .. } if found.len() == 7)
    );
    let text = error.to_string();
    for part in [
        "7 segments of body \"die\"",
        "expected 6",
        "/edited/die/1 to /edited/die/6",
        "/edited/die/7",
    ] {
        assert!(text.contains(part), "{text}");
    }
    let mut more = scene.clone();
    let mut again = more.events[5].clone();
    again.name = "bounce 7".into();
    more.events.push(again);
    assert!(matches!(
        refused(&more),
        IngestError::SegmentCount { expected: 8, .. }
    ));
    let mut elsewhere = scene.clone();
    elsewhere.tracks[TrackIndex(0)].topic = "/edited/dice".into();
    let text = refused(&elsewhere).to_string();
    assert!(
        text.contains("0 segments") && text.contains("none"),
        "{text}"
    );
    // A frame on a topic of all segments is only missed in the end.
    let mut frames = scene.clone();
    frames.tracks[TrackIndex(0)].topic = "/edited/die/1#die".into();
    assert!(matches!(refused(&frames), IngestError::ChildAbsent { .. }));
}

#[test]
fn a_stream_too_many_is_refused_by_name() {
    let performance = edited_bounces(1);
    let mut events = performance.events.clone();
    if let Some(TakeEvent::Pose { stream, .. }) = events.last_mut() {
        *stream = 2;
    }
    let error = clean(&performance.truth.scene, &events).unwrap_err();
    let expected = SegmentError::NoSuchStream {
        body: "cube".into(),
        stream: 3,
        streams: 2,
    };
    assert_eq!(error, expected);
}

fn finished(scene: &Scene, events: &[TakeEvent]) -> Result<Sketch, PipelineError> {
    let pipeline = Pipeline::of(scene.clone(), events.to_vec());
    pipeline.finish(&mut ()).map(|outcome| outcome.sketch)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn any_segments_in_any_order_give_an_estimate_or_an_error(
        count in 0_usize..3,
        lost in prop::collection::vec(0_usize..12, 3),
        swaps in prop::collection::vec(any::<prop::sample::Index>(), 60),
        marks in 0_usize..3,
    ) {
        let performance = edited_bounces(count);
        let scene = &performance.truth.scene;
        // Of ten streams about two are lost, one whole and one but for two samples.
        let is_kept = |event: &TakeEvent| match event {
            TakeEvent::Pose { stream, sample, .. } => match lost[*stream] {
                0 => false,
                1 => sample.stamp.seconds_since(performance.acting.start) < 0.012,
                _ => true,
            },
            TakeEvent::Mark(_) => true,
        };
        let mut events: Vec<TakeEvent> = performance.events.iter().filter(|e| is_kept(e)).cloned().collect();
        let straight = finished(scene, &events);
        // What an impact hands on tells a flight of few samples; the first needs its own.
        // Keyframes, six and fewer of a flight, tell one another.
        let are_keyframes = events.len() <= 6 * (count + 1);
        let first = if are_keyframes { 0 } else { 1 };
        let is_told = lost[0] > first && lost[1..=count].iter().all(|&lost| lost > 0);
        prop_assert_eq!(straight.is_ok(), is_told);
        // Marks say nothing, and neither does the order of arrival.
        for number in 0..marks {
            let stamp = Stamp(performance.acting.start.0 + number as i64);
            events.push(TakeEvent::Mark(Mark { stamp, event: None }));
        }
        if !events.is_empty() {
            for pair in swaps.chunks(2) {
                let length = events.len();
                events.swap(pair[0].index(length), pair[1].index(length));
            }
        }
        prop_assert_eq!(finished(scene, &events), straight);
    }

    #[test]
    fn any_zeros_give_the_same_segments_or_an_error(
        zeros in prop::collection::vec(prop_oneof![Just(i64::MIN), Just(i64::MAX - 2_000_000_000), any::<i64>(), -9_i64..9], 3),
        stretch in prop_oneof![9 => Just(1_i64), 1 => Just(100_000_000)],
    ) {
        let performance = edited_bounces(2);
        let scene = &performance.truth.scene;
        let start = performance.acting.start.0;
        let mut events = performance.events.clone();
        for event in &mut events {
            if let TakeEvent::Pose { stream, sample, .. } = event {
                let since = (sample.stamp.0 - start) * stretch;
                // Stamps that no clock can show are no sketch.
                let stamp = zeros[*stream].checked_add(since);
                prop_assume!(stamp.is_some());
                sample.stamp = Stamp(stamp.unwrap_or_default());
            }
        }
        let plain = clean(scene, &performance.events).unwrap().0;
        match clean(scene, &events) {
            Ok((sketch, _)) => {
                prop_assert_eq!(&sketch.marks_s, &plain.marks_s);
                for (a, b) in sketch.tracks[TrackIndex(0)].samples.iter().zip(&plain.tracks[TrackIndex(0)].samples) {
                    prop_assert_eq!((a.acted_s, a.seen), (b.acted_s, b.seen));
                }
            }
            Err(error) => {
                prop_assert!(stretch > 1);
                prop_assert!(matches!(error, SegmentError::Span { .. }), "{}", error);
            }
        }
    }
}
