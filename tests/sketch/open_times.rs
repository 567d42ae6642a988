//! Sketches of keyframes whose times are known, known within an interval, or unknown, and of parts of poses.

use enact::motion::{
    About, AtBound, Holds, OpenTime, PoseSample, Stamp, TakeEvent, Timing, Verdict,
};
use enact::pipeline::{Outcome, Pipeline};
use enact_tools::perform::{Keyframed, Keyframing, Off, Style, Truth};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Greatest error of what is given back [m, rad, s].
const EXACT: f64 = 1e-9;
const SEEDS: [u64; 2] = [8001, 8004];

/// What is said of the time of the keyframe at a place in its flight.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Told {
    Known,
    Within,
    Unknown,
}

/// Keyframes with what is said of their times, and their true stamps.
struct Sketched {
    events: Vec<TakeEvent>,
    truth: Vec<(PoseSample, Stamp)>,
}

/// Half the width of intervals \[ns\].
const HALF_NS: i64 = 30_000_000;

/// Exact keyframes of which `told` says, by their place in their flight, what is known of their
/// times. Stamps of the others are anywhere between their neighbours.
fn told(truth: &Truth, per_flight: usize, seed: u64, told: impl Fn(usize) -> Told) -> Sketched {
    let events = Keyframing::exact(per_flight).of(truth, seed);
    let mut random = ChaCha8Rng::seed_from_u64(seed ^ 0xa11);
    let mut keyframes: Vec<(PoseSample, Stamp)> = Vec::new();
    let poses: Vec<PoseSample> = events
        .iter()
        .filter_map(|event| match event {
            TakeEvent::Pose { sample, .. } => Some(*sample),
            TakeEvent::Mark(_) => None,
        })
        .collect();
    let mut last = 0;
    for (number, pose) in poses.iter().enumerate() {
        let place = number % per_flight;
        let at = pose.stamp.0;
        // Between the one before, where it was put, and the one after, within the flight.
        let before = if place > 0 { last } else { at - 1_000_000 };
        let is_last = place + 1 == per_flight;
        let after = match poses.get(number + 1).filter(|_| !is_last) {
            Some(next) => next.stamp.0,
            None => at + 1_000_000,
        };
        let mut sample = *pose;
        match told(place) {
            Told::Known => {}
            Told::Unknown => {
                let share: f64 = 0.2 + 0.6 * random.random::<f64>();
                sample.stamp = Stamp(before + ((after - before) as f64 * share) as i64);
                sample.open = Some(OpenTime {
                    before_ns: None,
                    after_ns: None,
                });
            }
            Told::Within => {
                let shift = ((2.0 * random.random::<f64>() - 1.0) * 0.9 * HALF_NS as f64) as i64;
                let [from, to] = [at + shift - HALF_NS, at + shift + HALF_NS];
                sample.stamp = Stamp((at + shift).clamp(before + 1, after - 1));
                sample.open = Some(OpenTime {
                    before_ns: Some(sample.stamp.0 - from),
                    after_ns: Some(to - sample.stamp.0),
                });
            }
        }
        last = sample.stamp.0;
        keyframes.push((sample, pose.stamp));
    }
    let mut changed = keyframes.iter();
    let events = events.into_iter().map(|event| match event {
        TakeEvent::Pose { track, stream, .. } => TakeEvent::Pose {
            track,
            stream,
            sample: changed.next().expect("as many").0,
        },
        mark => mark,
    });
    let events = events.collect();
    Sketched {
        events,
        truth: keyframes,
    }
}

fn finished(truth: &Truth, events: &[TakeEvent]) -> (Outcome, Off) {
    let pipeline = Pipeline::of(truth.scene.clone(), events.to_vec());
    let outcome = pipeline.finish(&mut ()).expect("an estimate");
    let off = Off::of(truth, events, &outcome.estimate);
    (outcome, off)
}

/// Greatest error of the times of keyframes \[s\]; time zero is the first.
fn times_off_s(of: &Sketched, outcome: &Outcome) -> f64 {
    let zero = of.truth[0].1;
    let times = outcome.estimate.sample_times.iter();
    let errors = times.map(|found| {
        let mut all = of.truth.iter();
        let (_, at) = all
            .find(|(sample, _)| sample.stamp == found.stamp)
            .expect("one of them");
        (found.time_s - at.seconds_since(zero)).abs()
    });
    errors.fold(0.0, f64::max)
}

fn truth(subject: Keyframed, timing: Timing, seed: u64) -> Truth {
    let mut truth = subject.truth(seed).expect("a motion");
    truth.scene.timing = timing;
    truth
}

/// All motions with physical times, and with a clock for each flight.
fn each() -> impl Iterator<Item = (Keyframed, Timing)> {
    let timings = [Timing::Known, Timing::Edited].into_iter();
    timings.flat_map(|timing| SUBJECTS.map(|subject| (subject, timing)))
}

const SUBJECTS: [Keyframed; 4] = [
    Keyframed::Pencil(Style::Tip),
    Keyframed::Pencil(Style::Eraser),
    Keyframed::Box(1),
    Keyframed::Die(3),
];

#[test]
fn known_unknown_and_bounded_times_in_one_sketch_are_given_back() {
    let kinds = [Told::Known, Told::Unknown, Told::Within];
    for (subject, timing) in each() {
        for seed in SEEDS {
            let truth = truth(subject, timing, seed);
            let of = told(&truth, 6, seed, |place| kinds[place % 3]);
            let (outcome, off) = finished(&truth, &of.events);
            let estimate = &outcome.estimate;
            let what = format!("{timing:?} {subject:?} {seed}: {off:?}");
            assert!(off.greatest() < EXACT, "{what}");
            // An edited sketch's stamps are on other clocks.
            if timing == Timing::Known {
                let times_off_s = times_off_s(&of, &outcome);
                assert!(times_off_s < EXACT, "{what}, times {times_off_s} s");
            }
            assert_eq!(estimate.verdict, Verdict::Physical, "{what}");
            assert_eq!(estimate.undetermined, [], "{what}");
            let open = estimate.sample_times.iter().filter(|time| time.is_open);
            assert_eq!(open.count(), 2 * of.truth.len() / 3);
        }
    }
}

#[test]
fn an_interval_without_the_truth_is_left_at_its_end_and_that_is_said() {
    let truth = truth(Keyframed::Box(1), Timing::Known, 8001);
    let mut of = told(&truth, 4, 8001, |_| Told::Known);
    // The second keyframe is said to be 5 ms later than it is, or more.
    let mut poses = of.events.iter_mut().filter_map(|event| match event {
        TakeEvent::Pose { sample, .. } => Some(sample),
        TakeEvent::Mark(_) => None,
    });
    let second = poses.nth(1).expect("eight keyframes");
    second.stamp.0 += 6_000_000;
    second.open = Some(OpenTime {
        before_ns: Some(1_000_000),
        after_ns: Some(1_000_000),
    });
    let (outcome, _) = finished(&truth, &of.events);
    let [time] = outcome.estimate.parameters.as_slice() else {
        panic!("one time is free: {:?}", outcome.estimate.parameters)
    };
    assert_eq!(time.at_bound, Some(AtBound::Lower), "{time:?}");
    assert!((time.value + 1e-3).abs() < 1e-9, "{time:?}");
    assert!(time.name.ends_with(".keyframe.2.time"), "{time:?}");
}

/// Of exact keyframes with one known time a flight other motions pass through all of them: none is
/// called physical.
#[test]
fn with_one_known_time_a_flight_nothing_is_called_physical() {
    let kinds = [Told::Known, Told::Unknown, Told::Within];
    let mut others = 0;
    for (subject, timing) in each() {
        let truth = truth(subject, timing, SEEDS[0]);
        let of = told(&truth, 3, SEEDS[0], |place| kinds[place]);
        let (outcome, off) = finished(&truth, &of.events);
        let estimate = &outcome.estimate;
        assert_ne!(
            estimate.verdict,
            Verdict::Physical,
            "{timing:?} {subject:?}"
        );
        let mut doubts = estimate.doubts.iter().map(|doubt| doubt.about);
        let is_said = doubts.any(|about| about == About::OpenTimes);
        assert!(is_said || estimate.verdict == Verdict::Failed);
        others += usize::from(off.greatest() > EXACT);
    }
    assert!(others > 0, "then there is nothing to doubt");
}

#[test]
fn positions_and_orientations_alone_among_whole_poses_give_back_the_motion() {
    for (subject, timing) in each() {
        for seed in SEEDS {
            let truth = truth(subject, timing, seed);
            let mut events = Keyframing::exact(6).of(&truth, seed);
            let poses = events.iter_mut().filter_map(|event| match event {
                TakeEvent::Pose { sample, .. } => Some(sample),
                TakeEvent::Mark(_) => None,
            });
            for (place, sample) in poses.enumerate() {
                sample.holds = [Holds::Pose, Holds::Position, Holds::Orientation][place % 3];
            }
            let (outcome, off) = finished(&truth, &events);
            let what = format!("{timing:?} {subject:?} {seed}: {off:?}");
            assert!(off.greatest() < EXACT, "{what}");
            assert_eq!(outcome.estimate.verdict, Verdict::Physical, "{what}");
        }
    }
}
