//! A take estimated for a diagnosis: how far its motion is from the samples, and whether that can be
//! what was acted.

use nalgebra::UnitQuaternion;

use super::budget::Budget;
use crate::motion::{
    Distance, Estimate, Remedy, Sample, Scene, Sketch, TakeEvent, Timing, TrackIndex, VelocityGaps,
    Verdict,
};
use crate::pipeline::perform::Prepared;
use crate::verify::credible;

/// How much less a motion may leave than its flights as they are guessed one by one, in
/// physical stamps and where times are unknown.
const TIMED: f64 = 1.05;
const UNTIMED: f64 = 2.0;

/// A motion of the take as it is said to be, or with a remedy.
pub(super) struct TriedMotion {
    pub(super) scene: Scene,
    pub(super) sketch: Sketch,
    pub(super) estimate: Estimate,
    /// Whether its gaps are closed, or as closed as the scene lets them be, and nothing speaks
    /// against it.
    pub(super) is_credible: bool,
    /// What its flights leave one by one, in the scene's weights; no motion leaves much less.
    pub(super) alone: f64,
}

/// Samples of a flight with their physical times \[s\].
#[derive(Clone)]
pub(super) struct TriedFlight {
    pub(super) track: TrackIndex,
    pub(super) readings: Vec<(f64, Sample)>,
    /// The orientation that the scene asks where it ends.
    pub(super) goal: Option<UnitQuaternion<f64>>,
}

/// The flights of a take by its stamps; none where it cannot be cut.
pub(super) fn flights_by_stamps(
    scene: &Scene,
    events: &[TakeEvent],
    budget: &mut Budget,
) -> Vec<TriedFlight> {
    budget.prepare();
    let prepared = Prepared::new(scene, events, &mut ());
    let Ok(prepared) = prepared else {
        return Vec::new();
    };
    let flights = prepared.flights().map(|(track, samples, end)| TriedFlight {
        track,
        readings: samples.iter().map(|s| (s.acted_s, *s)).collect(),
        goal: end.and_then(|event| prepared.asked(track, event)),
    });
    flights.collect()
}

impl TriedMotion {
    /// Estimates a take; `None` where no motion closes its gaps, or where its flights are further than
    /// `farthest` from their samples even one by one, in the scene's weights.
    pub(super) fn of(
        scene: &Scene,
        events: &[TakeEvent],
        farthest: f64,
        budget: &mut Budget,
    ) -> Option<Self> {
        if budget.is_over() {
            return None;
        }
        budget.prepare();
        let mut scene = scene.clone();
        if scene.velocity_gaps == VelocityGaps::WhenNeeded {
            scene.velocity_gaps = VelocityGaps::Never;
        }
        let prepared = Prepared::new(&scene, events, &mut ()).ok()?;
        let slack = match scene.timing {
            // Guessed times are not yet those that fit best.
            Timing::Unknown { .. } => UNTIMED,
            Timing::Known | Timing::Edited => TIMED,
        };
        let alone = prepared.alone(&mut budget.of_one()) / slack;
        if !(alone <= farthest) {
            return None;
        }
        let performed = prepared.one_by_one(&mut budget.of_one()).ok()?;
        let (given, estimate) = (performed.inferred.scene, performed.inferred.solved.estimate);
        if estimate.verdict == Verdict::Failed {
            return None;
        }
        let scene = given.as_estimated(&estimate);
        let sketch = performed.sketch.seen_in(&given, &scene);
        let doubts = credible::doubts(&scene, &given, &sketch, &performed.marks_made_s, &estimate);
        let best = match scene.velocity_gaps {
            VelocityGaps::Always => Verdict::Plausible,
            VelocityGaps::WhenNeeded | VelocityGaps::Never => Verdict::Physical,
        };
        let is_grave = doubts
            .iter()
            .any(|doubt| doubt.about.best() != Verdict::Physical);
        Some(Self {
            is_credible: estimate.verdict <= best && !is_grave,
            alone,
            scene,
            sketch,
            estimate,
        })
    }

    /// Its flights at its own times.
    pub(super) fn flights(&self) -> Vec<TriedFlight> {
        let mut times = self.estimate.sample_times.iter();
        let residuals = self.estimate.residuals.iter();
        residuals
            .map(|residual| {
                let samples = &self.sketch.tracks[residual.track].samples;
                let times = times.by_ref().take(residual.samples);
                let readings = times.filter_map(|time| {
                    let at = samples.binary_search_by_key(&time.stamp, |sample| sample.stamp);
                    Some((time.time_s, samples[at.ok()?]))
                });
                TriedFlight {
                    track: residual.track,
                    readings: readings.collect(),
                    goal: None,
                }
            })
            .collect()
    }

    /// Its distance from the samples.
    pub(super) fn distance(&self) -> Distance {
        distance(&self.estimate)
    }

    /// See [`misfit`].
    pub(super) fn misfit(&self) -> f64 {
        misfit(&self.scene, &self.distance())
    }
}

/// Root mean square distance of an estimate from all samples.
pub(in crate::pipeline) fn distance(estimate: &Estimate) -> Distance {
    let (position_m, orientation_rad) = estimate.residual_rms();
    Distance {
        position_m,
        orientation_rad,
    }
}

/// A distance from the samples in the scene's weights.
pub(in crate::pipeline) fn misfit(scene: &Scene, distance: &Distance) -> f64 {
    let position = distance.position_m / scene.weights.position_m;
    position.hypot(distance.orientation_rad / scene.weights.orientation_rad)
}

/// The distance in the units in which the streams came, so that shrinking them gains nothing.
pub(super) fn as_delivered(remedy: &Remedy, distance: &Distance) -> Distance {
    match remedy {
        Remedy::PositionUnit(unit) => Distance {
            position_m: distance.position_m / unit.length_m(),
            ..*distance
        },
        _ => *distance,
    }
}
