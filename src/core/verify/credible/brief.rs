//! Checks the fall of flights with few samples, by the laws of few degrees of freedom.
//!
//! The acceleration beyond gravity that fits a flight best lowers its sum of squares by `G`, and `P` is
//! left of all flights together, with `n` degrees of freedom. Under white noise of standard deviation
//! `σ` and free flight
//!
//! ```text
//! G/σ² ~ χ²₃            (G/3) / (P/n) ~ F(3, n)
//! ```
//!
//! The second needs no `σ`, but with few degrees of freedom it is wide; the first takes the scene's
//! weight for `σ`. A hand's wander bends a flight smoothly, and leaves nothing like white noise:
//! what the weights explain is never doubted.

use statrs::distribution::{ChiSquared, ContinuousCDF, FisherSnedecor};

use super::alone::{LEAST as ENOUGH, fitted};
use super::flights::CredibleFlight;
use crate::motion::{About, Doubt, Estimate, Scene, Sketch, Timing};

/// Least number of readings of a flight: one less has as many numbers as its acceleration has.
const LEAST: usize = 4;
/// Directions of an acceleration.
const DIRECTIONS: f64 = 3.0;
/// Share of right motions that the law without the weights doubts,
const BY_RESIDUALS: f64 = 1e-3;
/// unless the weights explain the fall at this probability.
const EXPLAINED: f64 = 0.05;
/// The same of the law with the weights.
const BY_WEIGHTS: f64 = 1e-6;
/// What is left of exact samples \[m\].
const ROUNDING_M: f64 = 1e-6;

/// A flight with few samples, and by how much an acceleration of its own lowers its sum of squares \[m²\].
struct Brief<'a> {
    flight: &'a CredibleFlight<'a>,
    gain_m2: f64,
}

/// Doubts about flights that have fewer samples than are needed for the test of all together.
pub(super) fn doubts(
    scene: &Scene,
    sketch: &Sketch,
    estimate: &Estimate,
    flights: &[CredibleFlight],
) -> Vec<Doubt> {
    // Free times follow any fall.
    let is_open =
        |flight: &CredibleFlight| !sketch.tracks[flight.residual.track].open_times_s.is_empty();
    let is_brief = |flight: &CredibleFlight| {
        (LEAST..ENOUGH).contains(&flight.readings.len()) && !is_open(flight)
    };
    let is_unknown = matches!(scene.timing, Timing::Unknown { .. });
    if is_unknown || !flights.iter().any(is_brief) {
        return Vec::new();
    }
    let (mut left_m2, mut freedom, mut briefs) = (0.0, 0.0, Vec::new());
    let are_many = |flight: &&CredibleFlight| flight.readings.len() >= LEAST && !is_open(flight);
    for flight in flights.iter().filter(are_many) {
        let Some(fit) = fitted(scene, estimate, flight) else {
            continue;
        };
        let alone_m2: f64 = fit.left.iter().map(|left| left.norm_squared()).sum();
        let count = flight.readings.len();
        left_m2 += (alone_m2 - fit.gain_m2).max(count as f64 * ROUNDING_M * ROUNDING_M);
        freedom += DIRECTIONS * (count - 3) as f64;
        if is_brief(flight) {
            let gain_m2 = fit.gain_m2;
            briefs.push(Brief { flight, gain_m2 });
        }
    }
    let Some(bound_m2) = bound_m2(scene, left_m2 / freedom, freedom, briefs.len()) else {
        return Vec::new();
    };
    // The root of the ratio of mean squares per degree of freedom, as of the flights with many samples.
    let ratio = |gain_m2: f64| {
        let free = (left_m2 + gain_m2) / (freedom + DIRECTIONS);
        (free / (left_m2 / freedom)).sqrt()
    };
    let doubts = briefs.iter().filter_map(|brief| {
        let place = brief.flight.place();
        Doubt::beyond(About::Fall, place, ratio(brief.gain_m2), ratio(bound_m2))
    });
    doubts.collect()
}

/// Greatest decrease of the sum of squares of a right flight by an acceleration of its own \[m²\], where
/// the noise has this variance \[m²\] by so many degrees of freedom, and so many flights are tested.
fn bound_m2(scene: &Scene, noise_m2: f64, freedom: f64, flights: usize) -> Option<f64> {
    let shared = |probability: f64| 1.0 - probability / flights.max(1) as f64;
    let weight_m2 = scene.weights.position_m.powi(2);
    let by_weights = ChiSquared::new(DIRECTIONS).ok()?;
    let by_residuals = FisherSnedecor::new(DIRECTIONS, freedom).ok()?;
    let unlikely_m2 = DIRECTIONS * noise_m2 * by_residuals.inverse_cdf(shared(BY_RESIDUALS));
    let explained_m2 = weight_m2 * by_weights.inverse_cdf(1.0 - EXPLAINED);
    let most_m2 = weight_m2 * by_weights.inverse_cdf(shared(BY_WEIGHTS));
    Some(unlikely_m2.max(explained_m2).min(most_m2))
}
