//! Units of lengths: of the streams, which should be metres, and of the scene, whose keys say
//! millimetres.
//!
//! Flights in a unit of `l` metres fall with `g/l`; in acted time `c` times slower with `g/(l c²)`.

use super::facts::Facts;
use super::fall::SeenFall;
use crate::motion::{LengthUnit, Remedy};

/// Units in which trackers deliver positions.
const OF_STREAMS: [LengthUnit; 4] = [
    LengthUnit::Foot,
    LengthUnit::Inch,
    LengthUnit::Centimetre,
    LengthUnit::Millimetre,
];
/// Units in which scenes are written.
const OF_SCENES: [LengthUnit; 3] = [LengthUnit::Metre, LengthUnit::Inch, LengthUnit::Centimetre];
/// How far the acceleration in a unit may be from gravity, as a ratio, where stamps are physical.
const NEAR: f64 = 1.6;
/// Greatest square of acted over physical duration.
const SLOW: f64 = 150.0;
/// Largest body that a hand throws \[m\], as a radius.
const LARGEST_M: f64 = 1.5;

/// Other units of the streams.
pub(super) fn of_streams(facts: &Facts, fall: &SeenFall) -> Vec<Remedy> {
    let Some(pull) = facts.pull(fall) else {
        return Vec::new();
    };
    let is_possible = |unit: &LengthUnit| {
        let left = pull * unit.length_m();
        let least = if facts.is_timed() {
            1.0 / NEAR
        } else {
            1.0 / SLOW
        };
        left >= least && left <= NEAR
    };
    let possible = OF_STREAMS.into_iter().filter(is_possible);
    possible.map(Remedy::PositionUnit).collect()
}

/// Other units of the scene.
pub(super) fn of_scenes(facts: &Facts) -> Vec<Remedy> {
    let radii_m = facts.scene.links.iter().map(|link| link.shape.radius_m());
    let radius_m = radii_m.fold(0.0, f64::max);
    let is_possible = |unit: &LengthUnit| {
        let factor = unit.length_m() / LengthUnit::Millimetre.length_m();
        radius_m * factor <= LARGEST_M
    };
    let possible = OF_SCENES.into_iter().filter(is_possible);
    possible.map(Remedy::SceneUnit).collect()
}
