//! Checks estimated free parameters.

use crate::motion::{About, Doubt, Estimate, Place, Quantity, Scene};

/// Greatest deviation of estimated gravity from the scene's, relative to it.
const GRAVITY: f64 = 0.08;
/// Greatest standard deviation of estimated gravity, relative to the scene's.
const SPREAD: f64 = 0.05;
/// A parameter is at an end of its range if it is nearer to it than this share of the range.
const NEAR: f64 = 1e-6;

pub(super) fn doubts(scene: &Scene, estimate: &Estimate) -> Vec<Doubt> {
    let mut doubts = gravity(scene, estimate);
    for (index, parameter) in estimate.parameters.iter().enumerate() {
        let slack = NEAR * (parameter.upper - parameter.lower).min(1.0);
        let place = || Place::Parameter(index);
        // The end nearer to the value; a range of one value is no range.
        let ends = [parameter.lower, parameter.upper];
        let is_free = parameter.upper > parameter.lower;
        let end = ends
            .into_iter()
            .find(|end| (parameter.value - end).abs() <= slack);
        doubts.extend(end.filter(|_| is_free).map(|end| Doubt {
            about: About::AtBound,
            place: place(),
            value: parameter.value,
            bound: end,
        }));
    }
    for cone in &scene.cones {
        let [a, b] = cone
            .parameters
            .map(|index| estimate.parameters[index].value);
        let tilt = a.hypot(b);
        let is_at_end = tilt >= cone.limit * (1.0 - NEAR);
        doubts.extend(is_at_end.then(|| Doubt {
            about: About::AtBound,
            place: Place::Parameter(cone.parameters[0]),
            value: tilt,
            bound: cone.limit,
        }));
    }
    doubts
}

/// Doubts about a free gravity that is far from the scene's, or undetermined.
fn gravity(scene: &Scene, estimate: &Estimate) -> Vec<Doubt> {
    let is_gravity = |index: &usize| {
        let quantity = scene.parameters[*index].quantity;
        matches!(quantity, Quantity::Gravity { .. })
    };
    let freed: Vec<usize> = (0..scene.parameters.len()).filter(is_gravity).collect();
    let expected_m_s2 = scene.gravity_m_s2.norm();
    let Some(first) = freed.first().filter(|_| expected_m_s2 > 0.0) else {
        return Vec::new();
    };
    let far = (estimate.gravity_m_s2 - scene.gravity_m_s2).norm() / expected_m_s2;
    let variances = freed.iter().map(|index| {
        let sd = estimate.parameters[*index].sd;
        sd.map_or(f64::INFINITY, |sd| sd * sd)
    });
    let spread = variances.sum::<f64>().sqrt() / expected_m_s2;
    let place = || Place::Parameter(*first);
    let far = Doubt::beyond(About::Gravity, place(), far, GRAVITY);
    let spread = Doubt::beyond(About::GravitySpread, place(), spread, SPREAD);
    far.into_iter().chain(spread).collect()
}
