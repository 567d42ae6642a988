//! A take estimated for a diagnosis: how far its motion is from the samples, and whether that can be
//! what was acted.

use crate::motion::{
    Distance, Estimate, Observer, Remedy, Scene, Sketch, TakeEvent, VelocityGaps, Verdict,
};
use crate::pipeline::perform::perform;
use crate::verify::credible;

/// A motion of the take as it is said to be, or with a remedy.
pub(super) struct Motion {
    pub(super) scene: Scene,
    pub(super) sketch: Sketch,
    pub(super) estimate: Estimate,
    /// Whether its gaps are closed, or as closed as the scene lets them be, and nothing speaks
    /// against it.
    pub(super) is_credible: bool,
}

impl Motion {
    /// Estimates a take; `None` where no motion closes its gaps.
    pub(super) fn of(
        scene: &Scene,
        events: &[TakeEvent],
        observer: &mut dyn Observer,
    ) -> Option<Self> {
        let performed = perform(scene, events, observer).ok()?;
        let (scene, estimate) = (performed.inferred.scene, performed.inferred.solved.estimate);
        if estimate.verdict == Verdict::Failed {
            return None;
        }
        let doubts = credible::doubts(
            &scene,
            &performed.sketch,
            &performed.marks_made_s,
            &estimate,
        );
        let best = match scene.velocity_gaps {
            VelocityGaps::Always => Verdict::Plausible,
            VelocityGaps::WhenNeeded | VelocityGaps::Never => Verdict::Physical,
        };
        let is_grave = doubts
            .iter()
            .any(|doubt| doubt.about.best() != Verdict::Physical);
        Some(Self {
            is_credible: estimate.verdict <= best && !is_grave,
            scene,
            sketch: performed.sketch,
            estimate,
        })
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
pub(super) fn distance(estimate: &Estimate) -> Distance {
    let count: usize = estimate.residuals.iter().map(|r| r.samples).sum();
    let (mut position_m2, mut orientation_rad2) = (0.0, 0.0);
    for residual in &estimate.residuals {
        let samples = residual.samples as f64;
        position_m2 += samples * residual.position_rms_m.powi(2);
        orientation_rad2 += samples * residual.orientation_rms_rad.powi(2);
    }
    let mean = |sum: f64| (sum / count.max(1) as f64).sqrt();
    Distance {
        position_m: mean(position_m2),
        orientation_rad: mean(orientation_rad2),
    }
}

/// A distance from the samples in the scene's weights.
pub(super) fn misfit(scene: &Scene, distance: &Distance) -> f64 {
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
