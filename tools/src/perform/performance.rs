//! A performance: what the tracker delivered, and what only its maker knows.

use enact::motion::{BodySketch, Sample, Sketch, Stamp, TakeEvent, Timing};
use nalgebra::{Quaternion, UnitQuaternion};

use super::acting::Acting;
use super::tempo::Tempo;
use super::truth::Truth;

/// An acted motion and its hidden truth.
#[derive(Clone, Debug)]
pub struct Performance {
    /// The motion that was acted; its scene says what the stamps mean.
    pub truth: Truth,
    /// How it was acted.
    pub acting: Acting,
    /// Of the random numbers.
    pub seed: u64,
    /// The hidden tempo.
    pub tempo: Tempo,
    /// What was delivered, in order of arrival.
    pub events: Vec<TakeEvent>,
    /// When each of them arrived.
    pub arrivals: Vec<Stamp>,
    /// Hidden physical time of every sample [s since the start of the motion], body by body, in
    /// the order of the samples.
    pub sample_times_s: Vec<Vec<f64>>,
}

impl Performance {
    /// The sketch that a perfect reader of the recording would make: mount undone, signs made
    /// continuous, every mark at its event, nothing dropped. Not for edited sketches.
    pub fn sketch(&self) -> Sketch {
        assert_ne!(self.truth.scene.timing, Timing::Edited, "it has no marks");
        let stamps = self.events.iter().filter_map(|event| match event {
            TakeEvent::Pose { sample, .. } => Some(sample.stamp),
            TakeEvent::Mark(_) => None,
        });
        let origin = stamps.min().unwrap_or(self.acting.start);
        let mut bodies = vec![BodySketch::default(); self.truth.scene.bodies.len()];
        let mut marks_s = Vec::new();
        for event in &self.events {
            match event {
                TakeEvent::Mark(mark) => marks_s.push(mark.stamp.seconds_since(origin)),
                TakeEvent::Pose { body, sample, .. } => {
                    let [x, y, z, w] = sample.quaternion_xyzw;
                    let world_from_tracker = enact::math::Pose::from_parts(
                        sample.position_m.into(),
                        UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z)),
                    );
                    let tracker_from_body =
                        self.truth.scene.bodies[*body].body_from_tracker.inverse();
                    let world_from_body = world_from_tracker * tracker_from_body;
                    let samples = &mut bodies[*body].samples;
                    samples.push(Sample {
                        stamp: sample.stamp,
                        acted_s: sample.stamp.seconds_since(origin),
                        position_m: world_from_body.translation.vector,
                        orientation: nearer(
                            world_from_body.rotation,
                            samples.last().map(|last: &Sample| last.orientation),
                        ),
                    });
                }
            }
        }
        Sketch {
            origin,
            bodies,
            marks: vec![None; marks_s.len()],
            marks_s,
        }
    }
}

/// Of `q` and `−q`, one rotation, the nearer to the one before.
fn nearer(q: UnitQuaternion<f64>, last: Option<UnitQuaternion<f64>>) -> UnitQuaternion<f64> {
    match last {
        Some(last) if last.coords.dot(&q.coords) < 0.0 => {
            UnitQuaternion::new_unchecked(-q.into_inner())
        }
        _ => q,
    }
}
