//! Sketches of a few poses: exact keyframes give back the motion, and what they leave open is said.

use enact::motion::{About, MotionPart, Timing, Undetermined, Verdict};
use enact::pipeline::{Outcome, Pipeline};
use enact_tools::perform::{Keyframed, Keyframing, Off, Style, Truth};

/// Greatest error of what is given back [m, rad, s].
const EXACT: f64 = 1e-9;

const SUBJECTS: [Keyframed; 5] = [
    Keyframed::Pencil(Style::Tip),
    Keyframed::Pencil(Style::Eraser),
    Keyframed::Box(1),
    Keyframed::Box(3),
    Keyframed::Die(3),
];

fn finished(truth: &Truth, per_flight: usize, seed: u64) -> (Outcome, Off) {
    let events = Keyframing::exact(per_flight).of(truth, seed);
    let pipeline = Pipeline::of(truth.scene.clone(), events.clone());
    let outcome = pipeline.finish(&mut ()).expect("an estimate");
    let off = Off::of(truth, &events, &outcome.estimate);
    (outcome, off)
}

fn truth(subject: Keyframed, timing: Timing, seed: u64) -> Truth {
    let mut truth = subject.truth(seed).expect("a motion");
    truth.scene.timing = timing;
    truth
}

fn are_given_back(timing: Timing) {
    for subject in SUBJECTS {
        for per_flight in [2, 3, 6] {
            for seed in [7001, 7003] {
                let (outcome, off) = finished(&truth(subject, timing, seed), per_flight, seed);
                let estimate = &outcome.estimate;
                let what = format!("{timing:?} {subject:?} {per_flight} {seed}: {off:?}");
                assert!(off.greatest() < EXACT, "{what}");
                assert_eq!(estimate.verdict, Verdict::Physical, "{what}");
                assert_eq!(estimate.undetermined, [], "{what}");
            }
        }
    }
}

#[test]
fn two_poses_a_flight_and_more_give_back_the_motion_with_physical_times() {
    are_given_back(Timing::Known);
}

#[test]
fn two_poses_a_flight_and_more_give_back_the_motion_with_a_clock_for_each_flight() {
    are_given_back(Timing::Edited);
}

#[test]
fn one_pose_a_flight_gives_back_a_motion_of_several_flights() {
    for timing in [Timing::Known, Timing::Edited] {
        for subject in [Keyframed::Box(2), Keyframed::Die(3)] {
            let (outcome, off) = finished(&truth(subject, timing, 7002), 1, 7002);
            let verdict = outcome.estimate.verdict;
            assert!(off.greatest() < EXACT, "{timing:?} {subject:?}: {off:?}");
            assert_eq!(verdict, Verdict::Physical, "{timing:?} {subject:?}");
        }
    }
}

#[test]
fn of_two_poses_that_leave_turns_open_the_others_are_counted() {
    let truth = truth(Keyframed::Pencil(Style::Eraser), Timing::Known, 7001);
    let (outcome, _) = finished(&truth, 1, 7001);
    let estimate = &outcome.estimate;
    let doubts = estimate.doubts.iter().map(|doubt| doubt.about);
    assert!(
        doubts.clone().any(|about| about == About::Rivals),
        "{:?}",
        estimate.doubts
    );
    assert!(estimate.rivals > 0);
    assert_ne!(estimate.verdict, Verdict::Physical);
}

#[test]
fn of_too_few_poses_what_is_open_is_said() {
    // Twelve numbers for a state and a clock.
    let (outcome, off) = finished(&truth(Keyframed::Box(1), Timing::Edited, 7001), 1, 7001);
    let undetermined = &outcome.estimate.undetermined;
    assert!(off.greatest() > EXACT);
    let is_of_motion = |of: &Undetermined| {
        matches!(
            of,
            Undetermined::Motion {
                part: MotionPart::Velocity | MotionPart::Spin,
                ..
            }
        )
    };
    assert!(undetermined.iter().any(is_of_motion), "{undetermined:?}");
}

/// Rough keyframes of a small die leave room for motions far from the one that was meant: none that is
/// far off is called physical without a word of what is open.
#[test]
fn of_rough_poses_no_other_motion_is_called_physical_without_a_word() {
    let rough = |per_flight| Keyframing {
        per_flight,
        position_sd_m: 0.01,
        orientation_sd_rad: 5_f64.to_radians(),
    };
    let mut found = [0; 2];
    for seed in 8000..8012 {
        let truth = truth(Keyframed::Die(3), Timing::Edited, seed);
        let events = rough(3).of(&truth, seed);
        let pipeline = Pipeline::of(truth.scene.clone(), events.clone());
        let Ok(Outcome { estimate, .. }) = pipeline.finish(&mut ()) else {
            continue;
        };
        let is_said = !estimate.undetermined.is_empty();
        if estimate.verdict != Verdict::Physical || is_said {
            let about = |about: About| estimate.doubts.iter().any(|doubt| doubt.about == about);
            found[0] += usize::from(about(About::Keyframes));
            continue;
        }
        found[1] += 1;
        let off = Off::of(&truth, &events, &estimate);
        assert!(off.position_m < 0.05, "{seed}: {off:?}");
    }
    let [misfits, physical] = found;
    assert!(misfits >= 2 && physical >= 3, "{found:?}");
}
