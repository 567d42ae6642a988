//! Marks that are late or early find their collision, and cuts leave out what lies beside it.

use enact::motion::{MarkTime, TrackIndex};
use enact::segment::{SegmentError, clean, cut, refine, relocate_marks};
use enact_tools::perform::{
    Acting, Performance, Polyhedron, Style, Throw, bounces, clatter, perform, thrown,
};

/// The samples' interval [s].
const INTERVAL_S: f64 = 1.0 / 120.0;

fn exact(seed: u64) -> Performance {
    perform(&bounces(3, seed).unwrap(), &Acting::exact(), seed)
}

#[test]
fn marks_off_by_some_samples_come_back_to_their_collisions() {
    for style in Style::ALL {
        let performance = perform(&style.truth(), &Acting::timing_known(), 3);
        let truth = &performance.truth;
        for samples_off in [-6.0, -2.0, 0.0, 3.0, 6.0] {
            let mut sketch = performance.sketch();
            sketch.marks_s[0] = truth.event_times_s[0] + samples_off * INTERVAL_S;
            refine(&truth.scene, &mut sketch);
            let error_s = sketch.marks_s[0] - truth.event_times_s[0];
            assert!(
                error_s.abs() < 2.0 * INTERVAL_S,
                "{style:?} {samples_off} {error_s}"
            );
        }
    }
}

/// The wander of a hand is no kink because a fast tracker sees more of it: good marks stay.
#[test]
fn good_marks_of_small_dice_stay_at_any_rate() {
    for rate_hz in [120.0, 360.0, 1000.0] {
        let (mut near, mut all) = (0, 0);
        for seed in 40..60 {
            let truth = thrown(Polyhedron::Cube, &Throw::sized(0.01, 100.0), 3, seed);
            let acting = Acting {
                rate_hz,
                distortion: 0.1,
                kink_s: 0.01,
                ..Acting::timing_known()
            };
            let performance = perform(&truth.expect("a die that bounces"), &acting, seed);
            let scene = &performance.truth.scene;
            let (mut sketch, _) = clean::clean(scene, &performance.events).expect("a take");
            let true_s = &performance.truth.event_times_s;
            sketch.marks_s[..4].copy_from_slice(&true_s[..4]);
            refine(scene, &mut sketch);
            let off_s = (0..4).map(|of| (sketch.marks_s[of] - true_s[of]).abs());
            near += off_s.filter(|off_s| *off_s < 0.01).count();
            all += 4;
        }
        assert!(20 * near >= 19 * all, "{rate_hz}: {near} of {all}");
    }
}

/// Nothing in a stream shows where an end is; and nobody sees a bounce better for a faster tracker.
#[test]
fn marks_are_believed_as_far_as_people_are() {
    for rate_hz in [60.0, 120.0, 1000.0] {
        let acting = Acting {
            rate_hz,
            ..Acting::timing_known()
        };
        let performance = perform(&Style::Tip.truth(), &acting, 4);
        let cleaned = clean::clean(&performance.truth.scene, &performance.events);
        let (sketch, _) = cleaned.expect("a clean take");
        let sd_s = |event: usize| sketch.marks[event].expect("a mark").sd_s;
        assert!((sd_s(0) - f64::max(0.5 / rate_hz, 0.5 / 120.0)).abs() < 1e-4);
        assert_eq!(sd_s(1), 0.05);
    }
}

#[test]
fn marks_of_exact_motions_stay_within_a_sample() {
    for seed in 0..10 {
        let performance = exact(seed);
        let mut sketch = performance.sketch();
        refine(&performance.truth.scene, &mut sketch);
        for (mark_s, event_s) in sketch.marks_s.iter().zip(&performance.truth.event_times_s) {
            assert!(
                (mark_s - event_s).abs() < INTERVAL_S,
                "{seed}: {mark_s} {event_s}"
            );
        }
    }
}

#[test]
fn segments_follow_each_other_and_keep_away_from_collisions() {
    let performance = exact(1);
    let sketch = performance.sketch();
    let segments = cut(&performance.truth.scene, &sketch).unwrap();
    assert_eq!(segments.len(), 4);
    let samples = &sketch.tracks[TrackIndex(0)].samples;
    for pair in segments.windows(2) {
        assert_eq!(pair[0].end_event, pair[1].start_event);
        assert!(pair[0].views[0].samples.end <= pair[1].views[0].samples.start);
        let mark_s = sketch.marks_s[pair[0].end_event.unwrap()];
        let before_s = samples[pair[0].views[0].samples.end - 1].acted_s;
        let after_s = samples[pair[1].views[0].samples.start].acted_s;
        assert!(before_s <= mark_s - 0.99 * INTERVAL_S);
        assert!(after_s >= mark_s + 0.99 * INTERVAL_S);
        assert!(pair[1].views[0].samples.start - pair[0].views[0].samples.end <= 2);
    }
}

#[test]
fn a_flight_that_a_collision_begins_needs_no_samples_and_the_first_does() {
    let performance = exact(1);
    let scene = &performance.truth.scene;
    for (intervals, samples) in [(1.5, 0), (2.5, 1)] {
        let mut sketch = performance.sketch();
        sketch.marks_s[1] = sketch.marks_s[0] + intervals * INTERVAL_S;
        let segments = cut(scene, &sketch).unwrap();
        let counts: Vec<usize> = segments.iter().map(|s| s.sample_count()).collect();
        assert_eq!((counts.len(), counts[1]), (4, samples), "{counts:?}");
        assert!(
            segments
                .windows(2)
                .all(|pair| pair[0].views[0].samples.end <= pair[1].views[0].samples.start)
        );
    }
    let mut sketch = performance.sketch();
    sketch.marks_s[0] = 2.5 * INTERVAL_S;
    let error = cut(scene, &sketch).unwrap_err();
    let SegmentError::TooFewSamples {
        samples, from, to, ..
    } = &error
    else {
        panic!("{error}");
    };
    assert!(*samples < 3 && from != to, "{error}");
    assert!(error.to_string().contains(&scene.events[0].name), "{error}");
}

#[test]
fn marks_about_a_flight_with_few_samples_stay_or_move_together() {
    for seed in 0..12 {
        let truth = clatter(2, 0.004, seed).unwrap();
        let acting = Acting {
            distortion: 0.0,
            mark_error_s: 0.0,
            ..Acting::timing_known()
        };
        let performance = perform(&truth, &acting, seed);
        let mut exact = performance.sketch();
        let marks = exact.marks_s.iter().map(|mark_s| {
            Some(MarkTime {
                acted_s: *mark_s,
                sd_s: 0.5 * INTERVAL_S,
                counted: 1.0,
            })
        });
        exact.marks = marks.collect();
        let mut refined = exact.clone();
        refine(&performance.truth.scene, &mut refined);
        relocate_marks(&performance.truth.scene, &mut refined);
        for (refined_s, exact_s) in refined.marks_s.iter().zip(&exact.marks_s).take(2) {
            assert!(
                (refined_s - exact_s).abs() < 0.5 * INTERVAL_S,
                "{seed}: {refined_s} {exact_s}"
            );
        }
        let mut late = performance.sketch();
        late.marks_s[..2]
            .iter_mut()
            .for_each(|mark_s| *mark_s += 5.0 * INTERVAL_S);
        refine(&performance.truth.scene, &mut late);
        for (late_s, exact_s) in late.marks_s.iter().zip(&exact.marks_s).take(2) {
            assert!(
                (late_s - exact_s).abs() < 2.0 * INTERVAL_S,
                "{seed}: {late_s} {exact_s}"
            );
        }
    }
}
