//! Trackers that see parts of a body, through the pipeline: what is seen is found, what is not is said.

use enact::motion::{Estimate, MotionPart, Undetermined, Verdict};
use enact_tools::apart::{apart, apart_from_another};
use enact_tools::case::{Case, estimated};
use enact_tools::parts::{LATE_S, Part};
use enact_tools::perform::{Acting, Style, bounces};

/// A thrown cube that bounces twice, with physical stamps.
fn cube(seed: u64) -> Case {
    let truth = bounces::bounces(2, seed).expect("a throw");
    Case::new(&truth, &Acting::timing_known(), seed)
}

/// Distance of centres of mass from the truth \[m\], and of orientations \[rad\].
fn off(case: &Case, part: Part) -> (Estimate, f64, f64) {
    let (scene, events) = part.seen(case);
    let outcome = estimated(&scene, &events, &mut ()).expect("an estimate");
    let until_s = case.performance.truth.duration_s;
    let off = apart(case, &outcome.scene, &outcome.estimate, until_s).expect("finite");
    (outcome.estimate, off.position_m, off.orientation_rad)
}

fn opens(estimate: &Estimate, wanted: MotionPart) -> bool {
    let mut open = estimate.undetermined.iter();
    open.any(|of| matches!(of, Undetermined::Motion { part, .. } if *part == wanted))
}

#[test]
fn covariances_of_messages_weigh_samples() {
    for seed in 8000..8004 {
        let case = cube(seed);
        let (estimate, by_messages_m, _) = off(&case, Part::Covariances);
        let (_, by_scene_m, _) = off(&case, Part::Pose);
        assert_eq!(estimate.verdict, Verdict::Physical, "{seed}");
        assert!(
            by_messages_m < 1.5 * by_scene_m,
            "{seed}: {by_messages_m} {by_scene_m}"
        );
        // One axis counts nine times as much: the objective is another.
        assert!((by_messages_m - by_scene_m).abs() > 1e-6, "{seed}");
    }
}

#[test]
fn a_second_tracker_tells_how_late_its_clock_is() {
    for seed in 8000..8004 {
        let case = Case::pencil(Style::Tip, &Acting::timing_known(), seed);
        let (estimate, off_m, _) = off(&case, Part::LateCentre);
        assert_eq!(estimate.verdict, Verdict::Physical, "{seed}");
        assert!(off_m < 0.05, "{seed}: {off_m}");
        let late = estimate.parameters.iter().find(|of| of.name == "late");
        let late = late.expect("it is free");
        let sd_s = late.sd.expect("it is determined");
        assert!((late.value + LATE_S).abs() < 4.0 * sd_s, "{seed}: {late:?}");
        assert!(sd_s < 0.03, "{seed}: {late:?}");
    }
}

#[test]
fn an_orientation_alone_is_found_and_the_path_is_said_to_be_open() {
    for seed in 8000..8004 {
        let case = Case::pencil(Style::Tip, &Acting::timing_known(), seed);
        let (estimate, _, off_rad) = off(&case, Part::Orientation);
        let (_, _, whole_rad) = off(&case, Part::Pose);
        assert!(off_rad < 3.0 * whole_rad, "{seed}: {off_rad} {whole_rad}");
        assert!(opens(&estimate, MotionPart::Position), "{seed}");
    }
}

/// A centre alone is enough for a motion, and the turn that nobody saw is said to be open. The motion is as near
/// to what was seen as that of whole poses whose orientations weigh nothing, and where it is as near it is the
/// same path; poses begin with the turns that were acted, so that either may end in an optimum that the other
/// misses.
#[test]
fn a_centre_alone_is_enough_for_the_path_and_its_turn_is_said_to_be_open() {
    let mut nearer = 0;
    for seed in 8000..8008 {
        let timing = Acting::timing_known();
        for case in [cube(seed), Case::pencil(Style::Eraser, &timing, seed)] {
            let case = case.one_by_one();
            let [of_centre, of_unweighed] = [Part::Centre, Part::Unweighed].map(|part| {
                let (scene, events) = part.seen(&case);
                estimated(&scene, &events, &mut ()).expect("an estimate")
            });
            let estimate = &of_centre.estimate;
            assert_eq!(estimate.verdict, Verdict::Physical, "{seed}");
            assert!(opens(estimate, MotionPart::Orientation), "{seed}");
            assert!(opens(estimate, MotionPart::Spin), "{seed}");
            let other = &of_unweighed.estimate;
            let ratio = estimate.objective / other.objective;
            nearer += usize::from(ratio < 1.01);
            let of_other = (&of_unweighed.scene, other);
            let apart = apart_from_another(&case, (&of_centre.scene, estimate), of_other);
            let apart_m = apart.expect("finite").position_m;
            let is_same = (ratio - 1.0).abs() > 1e-5 || apart_m < 1e-3;
            assert!(is_same, "{seed}: {ratio} {apart_m}");
            // What weighs nothing leaves no residual, not an infinite one.
            for of in &other.residuals {
                assert!(of.position_rms_m.is_some_and(f64::is_finite), "{seed}");
                assert_eq!(of.orientation_rms_rad, None, "{seed}");
            }
        }
    }
    assert!(nearer >= 15, "{nearer} of 16");
}

/// A least motion is not all that there is: this pencil's ends in an optimum seventeen times as high.
#[test]
fn rebounds_tell_of_twirls() {
    let case = Case::pencil(Style::Eraser, &Acting::timing_known(), 7002);
    let (estimate, off_m, _) = off(&case, Part::Centre);
    assert_eq!(estimate.verdict, Verdict::Physical);
    assert!(estimate.objective < 500.0, "{}", estimate.objective);
    assert!(off_m < 0.05, "{off_m}");
}

/// About a thin body's own axis nothing turns what is seen: the least roll is chosen, and found.
#[test]
fn an_axis_seen_alone_is_enough_for_a_thin_body() {
    for seed in 8000..8002 {
        let case = Case::pencil(Style::Tip, &Acting::timing_known(), seed);
        for part in [Part::Ends, Part::Axis] {
            let (estimate, off_m, _) = off(&case, part);
            assert_eq!(estimate.verdict, Verdict::Physical, "{seed} {part:?}");
            assert!(off_m < 0.05, "{seed} {part:?}: {off_m}");
        }
    }
}

/// Of a cube one axis that is seen tells, with what touches, how it is turned about it: as near to what was seen
/// as from the truth, and near the truth.
#[test]
fn an_axis_seen_alone_is_enough_for_a_cube_that_bounces() {
    let mut near = 0;
    for seed in [8000, 8001, 8002, 8004, 8006, 8008] {
        let case = cube(seed).one_by_one();
        let (_, whole_m, _) = off(&case, Part::Pose);
        for (part, most) in [(Part::Ends, 1600.0), (Part::Axis, 400.0)] {
            let (estimate, off_m, off_rad) = off(&case, part);
            assert_eq!(estimate.verdict, Verdict::Physical, "{seed} {part:?}");
            let objective = estimate.objective;
            assert!(objective < most, "{seed} {part:?}: {objective}");
            assert!(off_m < whole_m + 0.005, "{seed} {part:?}: {off_m}");
            near += usize::from(off_rad < 0.3);
        }
    }
    assert!(near >= 11, "{near} of 12");
}
