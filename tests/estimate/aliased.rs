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

/// How many dice that are thrown with such a spin, that turn so far from one sample to the next, come out right, of how many.
fn followed(spin_rad_s: f64, [least_rad, most_rad]: [f64; 2]) -> [usize; 2] {
    let acting = Acting {
        rate_hz: RATE_HZ,
        distortion: 0.1,
        kink_s: 0.008,
        mark_error_s: 0.2 / RATE_HZ,
        ..Acting::timing_known()
    };
    let (mut count, mut right) = (0, 0);
    for seed in 100..180 {
        let throw = Throw::sized(0.02, spin_rad_s);
        let Ok(truth) = thrown(Polyhedron::Cube, &throw, 2, seed) else {
            continue;
        };
        if !(least_rad..most_rad).contains(&most_per_sample_rad(&truth)) {
            continue;
        }
        count += 1;
        let case = Case::new(&truth, &acting, seed);
        let Ok(outcome) = case.estimated(&mut ()) else {
            continue;
        };
        let is_near = Errors::of(&case, &outcome).orientation < 0.2;
        right += usize::from(is_near && outcome.estimate.verdict == Verdict::Physical);
    }
    [right, count]
}

#[test]
fn a_die_that_turns_by_more_than_half_a_turn_between_samples_is_followed() {
    let [right, count] = followed(150.0, [3.5, 5.8]);
    assert!(count > 10 && 10 * right >= 9 * count, "{right} of {count}");
}

/// What turns so slowly that a faster turn would show the same is not taken for that.
#[test]
fn a_die_that_turns_by_less_is_not_taken_for_one_that_turns_by_more() {
    let [right, count] = followed(30.0, [0.4, 2.5]);
    assert!(count > 10 && 10 * right >= 9 * count, "{right} of {count}");
}
