//! Axes: which way is up.

use super::facts::Facts;
use super::fall::SeenFall;
use super::remedied::upright;
use crate::motion::{Remedy, SignedAxis};

/// Least angle between the flights' acceleration and gravity that is looked into: 45° in cosine.
const ALIGNED: f64 = 0.707;

/// Whether the flights fall about as gravity points.
pub(super) fn is_upright(facts: &Facts, fall: &SeenFall) -> bool {
    let gravity_m_s2 = &facts.scene.gravity_m_s2;
    let along = fall.acceleration_m_s2.dot(gravity_m_s2);
    along >= ALIGNED * fall.acceleration_m_s2.norm() * gravity_m_s2.norm()
}

/// Another axis up, in the streams or in the scene's gravity.
pub(super) fn remedies(facts: &Facts, fall: &SeenFall) -> Vec<Remedy> {
    let gravity_m_s2 = &facts.scene.gravity_m_s2;
    let up = SignedAxis::along(&-fall.acceleration_m_s2);
    let (Some(axis), false) = (up, is_upright(facts, fall)) else {
        return Vec::new();
    };
    let down_m_s2 = -axis.vector() * gravity_m_s2.norm();
    let turned = upright(axis, gravity_m_s2).map(|turn| Remedy::Up {
        axis,
        gravity_m_s2: turn.inverse() * gravity_m_s2,
    });
    let gravity = Remedy::Gravity {
        gravity_m_s2: down_m_s2,
    };
    [gravity].into_iter().chain(turned).collect()
}
