//! Corners that hit in quick succession: flights of a few samples, or none, between impacts that are
//! marked. The impacts hand the state on.

use enact::motion::{
    Estimate, FreeParameter, Quantity, Stamp, TakeEvent, TrackIndex, Undetermined, Verdict,
};
use enact::pipeline::{Outcome, Pipeline};
use enact_tools::case::Case;
use enact_tools::perform::{Acting, Truth, clatter};

/// A tracker's noise, no hand, and marks that are exact.
fn tracked() -> Acting {
    Acting {
        distortion: 0.0,
        mark_error_s: 0.0,
        ..Acting::timing_known()
    }
}

fn finished(case: &Case, seed: u64) -> Outcome {
    let outcome = case.pipeline().finish(&mut ());
    outcome.unwrap_or_else(|error| panic!("seed {seed}: {error}"))
}

/// Errors of the collisions' times, each with the reported deviation [s].
fn errors_s(case: &Case, outcome: &Outcome) -> Vec<(f64, f64)> {
    let estimate = &outcome.estimate;
    let first = &estimate.sample_times[0];
    let offset_s = first.time_s - case.hidden_s(TrackIndex(0), first.stamp);
    let times_s = &case.performance.truth.event_times_s;
    let is_collision = |event: usize| outcome.scene.events[event].kind.collision().is_some();
    let events = estimate
        .events
        .iter()
        .filter(|event| is_collision(event.event));
    events
        .map(|event| {
            let sd_s = event.sd_s.expect("a deviation");
            (event.time_s - offset_s - times_s[event.event], sd_s)
        })
        .collect()
}

fn samples(estimate: &Estimate) -> Vec<usize> {
    estimate
        .residuals
        .iter()
        .map(|flight| flight.samples)
        .collect()
}

#[test]
fn two_corners_four_milliseconds_apart_come_out_within_their_deviations() {
    let (mut within, mut all) = (0, 0);
    for seed in 5000..5020 {
        let case = Case::new(&clatter(2, 0.004, seed).unwrap(), &tracked(), seed);
        let outcome = finished(&case, seed);
        let estimate = &outcome.estimate;
        assert_eq!(
            estimate.verdict,
            Verdict::Physical,
            "seed {seed}: {:?}",
            estimate.doubts
        );
        assert_eq!(samples(estimate)[1], 0, "seed {seed}");
        let flight = &estimate.residuals[2];
        assert!(
            flight.position_rms_m.unwrap() < 2e-3,
            "seed {seed}: {flight:?}"
        );
        for (error_s, sd_s) in errors_s(&case, &outcome) {
            assert!(error_s.abs() < 1e-3, "seed {seed}: {error_s}");
            within += usize::from(error_s.abs() <= 2.0 * sd_s);
            all += 1;
        }
    }
    assert!(10 * within >= 9 * all, "{within} of {all}");
}

#[test]
fn three_corners_in_a_row_leave_two_flights_without_samples() {
    for seed in 5000..5006 {
        let case = Case::new(&clatter(3, 0.004, seed).unwrap(), &tracked(), seed);
        let outcome = finished(&case, seed);
        let estimate = &outcome.estimate;
        assert_eq!(
            estimate.verdict,
            Verdict::Physical,
            "seed {seed}: {:?}",
            estimate.doubts
        );
        assert_eq!(samples(estimate)[1..3], [0, 0], "seed {seed}");
        assert!(estimate.arcs.iter().all(|arc| arc.end_s > arc.start_s));
        for (error_s, _) in errors_s(&case, &outcome) {
            assert!(error_s.abs() < 1e-3, "seed {seed}: {error_s}");
        }
    }
}

#[test]
fn a_flight_of_one_sample_is_compared_with_it() {
    let mut single = 0;
    for seed in 5000..5016 {
        let case = Case::new(&clatter(2, 0.02, seed).unwrap(), &tracked(), seed);
        let outcome = finished(&case, seed);
        let estimate = &outcome.estimate;
        assert_eq!(
            estimate.verdict,
            Verdict::Physical,
            "seed {seed}: {:?}",
            estimate.doubts
        );
        single += usize::from(samples(estimate)[1] == 1);
        for (error_s, _) in errors_s(&case, &outcome) {
            assert!(error_s.abs() < 1e-3, "seed {seed}: {error_s}");
        }
    }
    assert!(single > 4, "{single}");
}

/// Nothing is seen after the last impact, whose restitution may be free.
fn unseen_after(mut truth: Truth, is_free: bool, seed: u64) -> (Case, Outcome) {
    let last = truth.event_times_s.len() - 2;
    if is_free {
        let collision = truth.scene.events[last].kind.collision();
        let law = collision.expect("an impact").law;
        truth.scene.parameters.push(FreeParameter {
            name: "last".into(),
            quantity: Quantity::Restitution { law },
            initial: 0.5,
            lower: 0.0,
            upper: 1.0,
            prior_sd: None,
        });
    }
    let case = Case::new(&truth, &tracked(), seed);
    let mut scene = case.scene().clone();
    scene.events.pop();
    let events = || case.performance.events.iter();
    let mark_of = |event: &TakeEvent| match event {
        TakeEvent::Mark(mark) => Some(mark.stamp),
        TakeEvent::Pose { .. } => None,
    };
    let mut marks: Vec<Stamp> = events().filter_map(mark_of).collect();
    marks.sort();
    // One sample beyond, so that the mark is within the data.
    let interval_ns = (1e9 / case.performance.acting.rate_hz) as i64;
    let until = Stamp(marks[last].0 + interval_ns);
    let seen = events().filter(|event| match event {
        TakeEvent::Mark(mark) => mark.stamp < until,
        TakeEvent::Pose { sample, .. } => sample.stamp < until,
    });
    let pipeline = Pipeline::of(scene, seen.cloned());
    let outcome = pipeline.finish(&mut ()).unwrap();
    (case, outcome)
}

#[test]
fn a_last_flight_without_samples_follows_from_its_impact() {
    for seed in 5000..5006 {
        let (case, outcome) = unseen_after(clatter(2, 0.03, seed).unwrap(), false, seed);
        let estimate = &outcome.estimate;
        assert_eq!(
            estimate.verdict,
            Verdict::Physical,
            "seed {seed}: {:?}",
            estimate.doubts
        );
        assert_eq!(samples(estimate)[2], 0);
        assert!(
            estimate.undetermined.is_empty(),
            "{:?}",
            estimate.undetermined
        );
        for (error_s, _) in errors_s(&case, &outcome) {
            assert!(error_s.abs() < 2e-3, "seed {seed}: {error_s}");
        }
    }
}

#[test]
fn of_an_impact_after_which_nothing_is_seen_no_restitution_is_found() {
    for seed in 5000..5006 {
        let (_, outcome) = unseen_after(clatter(2, 0.03, seed).unwrap(), true, seed);
        let estimate = &outcome.estimate;
        let undetermined = &estimate.undetermined;
        assert!(
            undetermined.contains(&Undetermined::Parameter(0)),
            "seed {seed}: {undetermined:?}"
        );
        assert_eq!(estimate.parameters[0].sd, None);
    }
}

#[test]
fn in_unknown_timing_physics_says_how_long_a_flight_without_samples_lasts() {
    let (mut physical, mut all) = (0, 0);
    for seed in 5000..5010 {
        let acting = Acting {
            distortion: 0.0,
            mark_error_s: 0.0,
            ..Acting::default()
        };
        let truth = clatter(2, 0.004, seed).unwrap();
        let case = Case::new(&truth, &acting, seed);
        let outcome = finished(&case, seed);
        let estimate = &outcome.estimate;
        all += 1;
        if estimate.verdict != Verdict::Physical {
            continue;
        }
        physical += 1;
        let [first, second] = [0, 1].map(|event: usize| estimate.events[event].time_s);
        let lasts_s = truth.event_times_s[1] - truth.event_times_s[0];
        assert!(
            (second - first - lasts_s).abs() < 1e-3,
            "seed {seed}: {}",
            second - first
        );
    }
    assert!(10 * physical >= 8 * all, "{physical} of {all}");
}
