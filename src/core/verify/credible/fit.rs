//! Checks residuals: against the weights, against those of flights fitted alone ([`FlightsAlone`]), and
//! against those of flights with a free acceleration.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_6};

use super::alone::FlightsAlone;
use super::flights::CredibleFlight;
use super::kink::kinks;
use crate::motion::{
    About, Doubt, Estimate, Fits, Performer, Place, Scene, SegmentResidual, Sketch, Timing,
};

/// Greatest residual of a flight, in weights.
const RESIDUAL: f64 = 30.0;
/// Greatest rms angle between estimated and acted orientations of a flight \[rad\].
const ORIENTATION_RAD: f64 = FRAC_PI_2;
/// Greatest rms residual of free flights alone, in weights.
const ALONE: f64 = 8.0;
/// Greatest residual of the whole motion, in weights: beyond it, several motions fit.
const AMBIGUITY: f64 = 8.0;
/// Greatest residual of all keyframes, in weights.
const KEYFRAMES: f64 = 2.2;
/// Greatest ratio of the joint residual to that of flights alone, where the residuals of these are
/// white noise and where they are a hand's wander.
const MISFIT: [f64; 2] = [1.5, 12.0];
/// Below this joint residual, in weights, the bound for a wander is used.
const MISFIT_LEAST: f64 = 2.0;
/// Correlations of successive residuals of flights alone between which the bound is interpolated.
const WANDER: [f64; 2] = [0.15, 0.4];
/// Least acted duration of flights whose residuals show a hand's wander \[s\].
const SHORT_S: f64 = 0.15;
/// Greatest residual of the whole motion that a hand usually leaves, in weights.
const HAND: f64 = 4.0;
/// For shorter flights with smaller residuals: least ratio of the change of the residuals' slope at
/// collisions to that in flight which rules out a wander.
const KINKS: f64 = 3.0;
/// Greatest ratio of the residual of free flights to that with a free acceleration.
const FALL: f64 = 4.0;
/// Greatest angle of that acceleration from gravity \[rad\], checked where the ratio is above
/// [`DIRECTION_FALL`].
const DIRECTION_RAD: f64 = FRAC_PI_6;
const DIRECTION_FALL: f64 = 1.1;
/// Residuals below this are not checked \[m\].
const NOTHING_M: f64 = 1e-4;
/// Gravity below this has no checked direction [m/s²].
const WEIGHTLESS_M_S2: f64 = 0.1;

pub(super) fn doubts(
    scene: &Scene,
    sketch: &Sketch,
    estimate: &Estimate,
    flights: &[CredibleFlight],
) -> Vec<Doubt> {
    let in_weights = |residual: &SegmentResidual| {
        let position = residual.position_rms_m.unwrap_or(0.0) / scene.weights.position_m;
        let turn = residual.orientation_rms_rad.unwrap_or(0.0);
        position.max(turn / scene.weights.orientation_rad)
    };
    let mut doubts = Vec::new();
    let (mut squares, mut samples) = (0.0, 0);
    for flight in flights {
        let value = in_weights(flight.residual);
        squares += value * value * flight.residual.samples as f64;
        samples += flight.residual.samples;
        doubts.extend(Doubt::beyond(
            About::Residual,
            flight.place(),
            value,
            RESIDUAL,
        ));
        let angle_rad = flight.residual.orientation_rms_rad.unwrap_or(0.0);
        let place = flight.place();
        doubts.extend(Doubt::beyond(
            About::Orientation,
            place,
            angle_rad,
            ORIENTATION_RAD,
        ));
    }
    let whole = (squares / samples.max(1) as f64).sqrt();
    doubts.extend(Doubt::beyond(
        About::Ambiguity,
        Place::Motion,
        whole,
        AMBIGUITY,
    ));
    if scene.is_keyframed(sketch) {
        let about = About::Keyframes;
        doubts.extend(Doubt::beyond(about, Place::Motion, whole, KEYFRAMES));
    }
    let alone = FlightsAlone::new(scene, estimate, flights);
    if alone.samples > 0.0 {
        let rms_m = (alone.alone_m2 / alone.samples).sqrt();
        let value = rms_m / scene.weights.position_m;
        doubts.extend(Doubt::beyond(About::Alone, Place::Motion, value, ALONE));
    }
    let is_no_hand = whole > HAND || is_no_hand(flights);
    // Where noise and a hand were looked at one by one, that answer counts.
    let is_explained = estimate.fit.as_ref().is_ok_and(|fit| fit.fits == Fits::Yes);
    doubts.extend(misfit(scene, &alone).filter(|_| is_no_hand && !is_explained));
    let least_m = match scene.performer {
        // What a tracker leaves by its slow errors tells nothing of the fall.
        Performer::Nobody => scene.weights.position_m,
        Performer::Hand | Performer::Unsaid => NOTHING_M,
    };
    doubts.extend(fall(&alone, least_m));
    // The errors of a hand were told with gravity free, too.
    let is_of_hand = (estimate.fit.as_ref()).is_ok_and(|fit| fit.is_of_hand);
    let direction = direction(estimate, &alone, least_m);
    doubts.extend(direction.filter(|_| !(is_of_hand && is_explained)));
    doubts
}

/// Doubt where flights fit alone and not together: `√(joint/alone)` of the sums of squares is above
/// its bound.
fn misfit(scene: &Scene, alone: &FlightsAlone) -> Option<Doubt> {
    if !is_something(alone.joint_m2, alone, NOTHING_M) {
        return None;
    }
    let joint_m = (alone.joint_m2 / alone.samples).sqrt();
    // Free times distort the residuals, so that their correlation is not informative.
    let wander = match scene.timing {
        Timing::Unknown { .. } => 1.0,
        _ if joint_m < MISFIT_LEAST * scene.weights.position_m => 1.0,
        Timing::Known | Timing::Edited => {
            let along = (alone.correlation() - WANDER[0]) / (WANDER[1] - WANDER[0]);
            along.clamp(0.0, 1.0)
        }
    };
    let bound = MISFIT[0] + wander * (MISFIT[1] - MISFIT[0]);
    let value = (alone.joint_m2 / alone.alone_m2).sqrt();
    Doubt::beyond(About::Misfit, Place::Motion, value, bound)
}

/// Whether the residuals cannot be a hand's wander that is too slow to be visible in short flights.
fn is_no_hand(flights: &[CredibleFlight]) -> bool {
    let seen = flights
        .iter()
        .filter_map(|flight| match flight.readings.as_slice() {
            [first, .., last] => Some(last.acted_s - first.acted_s),
            _ => None,
        });
    let acted_s: Vec<f64> = seen.collect();
    let mean_s = acted_s.iter().sum::<f64>() / acted_s.len() as f64;
    mean_s >= SHORT_S || kinks(flights).is_some_and(|kinks| kinks > KINKS)
}

/// Doubt where the flights do not fall with the estimate's gravity.
fn fall(alone: &FlightsAlone, least_m: f64) -> Option<Doubt> {
    let value = over_pulled(alone, least_m)?;
    Doubt::beyond(About::Fall, Place::Motion, value, FALL)
}

/// Doubt where the flights fall in another direction than gravity's.
fn direction(estimate: &Estimate, alone: &FlightsAlone, least_m: f64) -> Option<Doubt> {
    let is_telling = over_pulled(alone, least_m)? > DIRECTION_FALL;
    let gravity_m_s2 = &estimate.gravity_m_s2;
    if !is_telling || gravity_m_s2.norm() < WEIGHTLESS_M_S2 {
        return None;
    }
    let angle_rad = gravity_m_s2.angle(&alone.pull_m_s2());
    Doubt::beyond(
        About::FallDirection,
        Place::Motion,
        angle_rad,
        DIRECTION_RAD,
    )
}

/// Ratio of the residual of free flights to that with a free acceleration: the root of the ratio of
/// mean squares per degree of freedom. `None` where residuals are less than `least_m`.
fn over_pulled(alone: &FlightsAlone, least_m: f64) -> Option<f64> {
    let per_freedom = |squares_m2: f64, freedom: f64| squares_m2 / freedom;
    is_something(alone.alone_m2, alone, least_m).then(|| {
        let free = per_freedom(alone.alone_m2, alone.alone_freedom);
        let pulled = per_freedom(alone.pulled_m2, alone.pulled_freedom);
        (free / pulled).sqrt()
    })
}

fn is_something(squares_m2: f64, alone: &FlightsAlone, least_m: f64) -> bool {
    squares_m2 > least_m * least_m * alone.samples && alone.samples > 0.0
}
