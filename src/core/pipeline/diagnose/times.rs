//! Times: what stamps mean.
//!
//! Flights stamped `k` times too far apart fall with `g/k²`.

use super::facts::Facts;
use super::fall::SeenFall;
use super::frames::is_upright;
use crate::motion::Remedy;

/// Stamped over meant intervals where one unit is taken for another.
const FACTORS: [f64; 4] = [1e3, 1e-3, 1e6, 1e-6];
/// How far the factor seen may be from one of these, as a ratio, where stamps are physical.
const NEAR: f64 = 1.6;
/// Greatest slowness of a performance, and least.
const SLOW: [f64; 2] = [0.6, 15.0];
/// Least slowness that is taken for an acted tempo in physical stamps.
const ACTED: f64 = 1.15;
/// Usual slowness of a performance.
const USUAL: f64 = 2.5;
/// Usual rates of cameras and trackers [1/s].
const RATES_HZ: [f64; 18] = [
    24.0, 25.0, 30.0, 48.0, 50.0, 60.0, 72.0, 75.0, 90.0, 100.0, 120.0, 144.0, 180.0, 200.0, 240.0,
    250.0, 300.0, 500.0,
];

/// Other meanings of the stamps.
pub(super) fn remedies(facts: &Facts, fall: &SeenFall) -> Vec<Remedy> {
    let Some(pull) = facts.pull(fall).filter(|_| is_upright(facts, fall)) else {
        return Vec::new();
    };
    let slowness = 1.0 / pull.sqrt();
    let within = |left: f64| match facts.is_timed() {
        true => (1.0 / NEAR..=NEAR).contains(&left),
        false => (SLOW[0]..=SLOW[1]).contains(&left),
    };
    if fall.is_whole_seconds {
        let usual = if facts.is_timed() { 1.0 } else { USUAL };
        let wanted_hz = slowness / usual;
        let apart = |rate_hz: &f64| (rate_hz / wanted_hz).ln().abs();
        let nearest = RATES_HZ
            .into_iter()
            .min_by(|a, b| apart(a).total_cmp(&apart(b)));
        let nearest = nearest.filter(|rate_hz| within(slowness / rate_hz));
        return nearest
            .map(|rate_hz| Remedy::FrameNumbers { rate_hz })
            .into_iter()
            .collect();
    }
    let units = FACTORS
        .into_iter()
        .filter(|factor| within(slowness / factor));
    let units = units.map(|factor| Remedy::StampUnit { factor });
    let is_acted = facts.is_timed() && (ACTED..=SLOW[1]).contains(&slowness);
    let acted = is_acted.then_some(Remedy::Tempo { slowness });
    units.chain(acted).collect()
}
