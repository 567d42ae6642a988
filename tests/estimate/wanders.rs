//! Errors of a hand as a process in time: motions come nearer to the truth, intervals hold it, and right scenes stay right.

use enact::motion::{Fits, Performer, Quantity, Verdict, Weights};
use enact::pipeline::Outcome;
use enact_tools::case::{Case, Posed};
use enact_tools::nonsense::wrong::Wrong;
use enact_tools::perform::{Acting, Style, bounces};
use enact_tools::trees::{self, Jointed, Kind, TreeActing};

const SEEDS: std::ops::Range<u64> = 9700..9710;

/// A usual hand in real time, which rounds its kinks.
fn hand() -> Acting {
    Acting {
        wander_pace: 1.0,
        kink_s: 0.008,
        ..Acting::timing_known()
    }
}

/// Errors of the events' times \[s\], in their deviations too, and of the flights' turns \[rad\].
#[derive(Default)]
struct Off {
    times_s: Vec<f64>,
    deviations: Vec<f64>,
    turns_rad: Vec<f64>,
}

fn off(performer: Performer) -> Off {
    let mut off = Off::default();
    for seed in SEEDS {
        let truth = bounces(2, seed).expect("a throw");
        let mut case = Case::new(&truth, &hand(), seed);
        case.performance.truth.scene.performer = performer;
        let outcome = case.pipeline().finish(&mut ()).expect("an estimate");
        let estimate = &outcome.estimate;
        if performer == Performer::Hand {
            assert_eq!(estimate.fits(), Fits::Yes, "{seed}");
            assert!(estimate.suspects.is_empty(), "{seed}");
        }
        let posed = Posed::new(case.scene(), &outcome.sketch);
        let offset_s = case.offset_s(&posed, &outcome.sketch);
        let free = |event: usize| posed.problem.event_is_free[event];
        for event in estimate.events.iter().filter(|of| free(of.event)) {
            let off_s = event.time_s - offset_s - truth.event_times_s[event.event];
            off.times_s.push(off_s);
            off.deviations
                .push(off_s / event.sd_s.expect("a deviation"));
        }
        for (index, arc) in estimate.arcs.iter().enumerate() {
            let there = case.true_state(index, arc.epoch_s, offset_s);
            off.turns_rad
                .push(arc.state.minus(&there).fixed_rows::<3>(3).norm());
        }
    }
    off
}

fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|of| of * of).sum::<f64>() / values.len() as f64).sqrt()
}

/// By how much a pencil's bounce is off \[s\], and the same in its deviations.
fn bounce_off(case: &Case, outcome: &Outcome) -> [f64; 2] {
    let posed = Posed::new(case.scene(), &outcome.sketch);
    let offset_s = case.offset_s(&posed, &outcome.sketch);
    let bounce = outcome.estimate.events.iter().find(|of| of.sd_s.is_some());
    let bounce = bounce.expect("a bounce");
    let true_s = case.performance.truth.event_times_s[bounce.event];
    let off_s = bounce.time_s - offset_s - true_s;
    [off_s, off_s / bounce.sd_s.expect("a deviation")]
}

/// Bounces are four times as near to their true times, and turns nearer by half, with kinks that no hand makes sharp.
#[test]
fn a_throw_is_nearer_to_the_truth() {
    let [one_by_one, in_time] = [Performer::Nobody, Performer::Hand].map(off);
    let times_s = [&one_by_one, &in_time].map(|of| rms(&of.times_s));
    assert!(times_s[1] < 0.25 * times_s[0], "{times_s:?}");
    let turns_rad = [&one_by_one, &in_time].map(|of| rms(&of.turns_rad));
    assert!(turns_rad[1] < 0.7 * turns_rad[0], "{turns_rad:?}");
    // Deviations are those of the errors: neither much too wide nor too narrow.
    let spread = rms(&in_time.deviations);
    assert!((0.4..1.5).contains(&spread), "{spread}");
}

/// The tip of a pencil and a goal that must hold: it does, and intervals of the bounce hold at any rate.
#[test]
fn goals_hold_and_intervals_do_at_any_rate() {
    for rate_hz in [60.0, 480.0] {
        let mut deviations = Vec::new();
        for seed in SEEDS {
            // Marks are annotated among the samples.
            let acting = Acting {
                rate_hz,
                mark_error_s: 0.5 / rate_hz,
                ..hand()
            };
            let mut case = Case::pencil(Style::Tip, &acting, seed);
            case.performance.truth.scene.performer = Performer::Hand;
            let outcome = case.pipeline().finish(&mut ()).expect("an estimate");
            let estimate = &outcome.estimate;
            assert_eq!(estimate.verdict, Verdict::Physical, "{seed}");
            let (miss_m, turn_rad) = enact_tools::errors::goal_gap(&case, estimate);
            assert!(miss_m < 1e-8 && turn_rad < 1e-8, "{seed}: {miss_m}");
            let [off_s, deviation] = bounce_off(&case, &outcome);
            assert!(off_s.abs() < 0.002, "{seed}: {off_s}");
            deviations.push(deviation);
        }
        let spread = rms(&deviations);
        assert!((0.4..1.6).contains(&spread), "{rate_hz}: {spread}");
    }
}

/// A restitution that is wrong is named in most throws, though a whole hand strays.
#[test]
fn a_wrong_restitution_is_named() {
    let mut named = 0;
    for seed in SEEDS {
        let mut asked = Wrong::Restitution.asked(&hand(), seed).expect("a throw");
        asked.scene.performer = Performer::Hand;
        asked.scene.weights = Weights {
            position_m: 0.01,
            orientation_rad: 0.1,
        };
        let outcome = asked.answered().expect("an estimate");
        let is_restitution = |of: &(Quantity, f64)| matches!(of.0, Quantity::Restitution { .. });
        let mut suspects = outcome.estimate.suspects.iter();
        named += usize::from(suspects.any(|of| of.values.iter().any(is_restitution)));
    }
    assert!(named >= 5, "{named}");
}

/// A pendulum of which one point is seen, too, also where its tempo is not known.
#[test]
fn a_pendulum_is_nearer_to_the_truth() {
    let kind = Kind::pendulum(2, Jointed::Universal);
    let off = |performer: Performer, seed: u64| {
        let performance = trees::perform(&kind, &TreeActing::of(1.0), seed);
        let mut scene = performance.scene.clone();
        scene.performer = performer;
        let events = performance.events.iter().cloned();
        let outcome = enact::pipeline::Pipeline::of(scene, events).finish(&mut ());
        let estimate = outcome.expect("an estimate").estimate;
        if performer == Performer::Hand {
            assert_eq!(estimate.verdict, Verdict::Physical, "{seed}");
            assert!(estimate.suspects.is_empty(), "{seed}");
        }
        let found = &estimate.trees[0].knots[0].state;
        let off = performance.tree().minus(found, &performance.truth);
        rms(&off)
    };
    let [one_by_one, in_time] = [Performer::Nobody, Performer::Hand].map(|performer| {
        let each: Vec<f64> = SEEDS.map(|seed| off(performer, seed)).collect();
        rms(&each)
    });
    assert!(in_time < 0.5 * one_by_one, "{in_time} {one_by_one}");
    let slowly = trees::perform(&kind, &TreeActing::of(1.0).slowly(), 9700);
    let mut scene = slowly.scene.clone();
    scene.performer = Performer::Hand;
    let events = slowly.events.iter().cloned();
    let outcome = enact::pipeline::Pipeline::of(scene, events).finish(&mut ());
    let estimate = outcome.expect("an estimate").estimate;
    assert_eq!(estimate.verdict, Verdict::Physical);
}

/// In an unknown tempo the bounce of a pencil is nearer, too, and its interval holds.
#[test]
fn a_slow_performance_is_nearer_to_the_truth() {
    let [one_by_one, in_time] = [Performer::Nobody, Performer::Unsaid].map(|performer| {
        let mut deviations = Vec::new();
        let errors = SEEDS.map(|seed| {
            let slow = Acting {
                kink_s: 0.008,
                ..Acting::default()
            };
            let mut case = Case::pencil(Style::Tip, &slow, seed);
            case.performance.truth.scene.performer = performer;
            let outcome = case.pipeline().finish(&mut ()).expect("an estimate");
            assert_eq!(outcome.estimate.verdict, Verdict::Physical, "{seed}");
            let [off_s, deviation] = bounce_off(&case, &outcome);
            deviations.push(deviation);
            off_s
        });
        (rms(&errors.collect::<Vec<_>>()), rms(&deviations))
    });
    assert!(in_time.0 < 0.7 * one_by_one.0, "{in_time:?} {one_by_one:?}");
    assert!((0.3..1.6).contains(&in_time.1), "{in_time:?}");
}

/// Where the scene does not say whether there was a hand, the flights do: of noise alone the answer is that of nobody's hand to
/// the last bit, and of a hand that of one.
#[test]
fn flights_show_whether_a_hand_was_there() {
    for (distortion, performer) in [(0.0, Performer::Nobody), (1.0, Performer::Hand)] {
        for seed in SEEDS {
            let acting = Acting {
                distortion,
                ..Acting::timing_known()
            };
            let [unsaid, said] = [Performer::Unsaid, performer].map(|performer| {
                let truth = bounces(2, seed).expect("a throw");
                let mut case = Case::new(&truth, &acting, seed);
                case.performance.truth.scene.performer = performer;
                case.estimated(&mut ()).expect("an estimate").estimate
            });
            assert_eq!(unsaid, said, "{distortion}, {seed}");
        }
    }
}
