//! What turns by more than half a turn from one sample to the next is followed, where bounces tell which way it turns.

use enact::motion::{LinkIndex, Verdict};
use enact_tools::case::Case;
use enact_tools::errors::Errors;
use enact_tools::perform::{Acting, Polyhedron, Throw, Truth, thrown};

const RATE_HZ: f64 = 40.0;

/// How far it turns from one sample to the next, at most \[rad\].
fn most_per_sample_rad(truth: &Truth) -> f64 {
    const STEP_S: f64 = 1e-4;
    let turned = |time_s: f64| truth.world_from_body(LinkIndex(0), time_s).rotation;
    let spin_rad_s = |time_s: f64| turned(time_s).angle_to(&turned(time_s + STEP_S)) / STEP_S;
    let spins = (0..200).map(|at| spin_rad_s(truth.duration_s * f64::from(at) / 200.0));
    spins.fold(0.0, f64::max) / RATE_HZ
}

#[test]
fn a_die_that_turns_by_more_than_half_a_turn_between_samples_is_followed() {
    let acting = Acting {
        rate_hz: RATE_HZ,
        distortion: 0.1,
        kink_s: 0.008,
        mark_error_s: 0.2 / RATE_HZ,
        ..Acting::timing_known()
    };
    let (mut fast, mut right) = (0, 0);
    for seed in 100..180 {
        let throw = Throw::sized(0.02, 150.0);
        let Ok(truth) = thrown(Polyhedron::Cube, &throw, 2, seed) else {
            continue;
        };
        if most_per_sample_rad(&truth) < 3.5 {
            continue;
        }
        fast += 1;
        let case = Case::new(&truth, &acting, seed);
        let Ok(outcome) = case.estimated(&mut ()) else {
            continue;
        };
        let is_near = Errors::of(&case, &outcome).orientation < 0.2;
        right += usize::from(is_near && outcome.estimate.verdict == Verdict::Physical);
    }
    assert!(fast > 10 && 10 * right >= 9 * fast, "{right} of {fast}");
}
