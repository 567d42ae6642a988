//! All of a motion as frames.

use super::error::SamplingError;
use super::frames::{append_settled, estimate_frames, sketch_frames, zero};
use crate::motion::{Estimate, PoseSample, Scene, Settled, Sketch, Stamp};

/// A motion as stamped poses, body by body as in `Scene::bodies`: world from body, stamps strictly
/// increasing, quaternions continuous in sign.
#[derive(Clone, Debug, PartialEq)]
pub struct SampledMotion {
    /// The stamp of physical time zero.
    pub zero: Stamp,
    /// The estimated motion, and after its end what is simulated; empty of a body without flights.
    pub estimates: Vec<Vec<PoseSample>>,
    /// The performance, at its physical times.
    pub sketches: Vec<Vec<PoseSample>>,
}

impl SampledMotion {
    /// Samples an estimate at a rate; see [`estimate_frames`]. What was simulated after it has an
    /// interval of its own. Fails where the rate is no such rate, or the motion too long for it.
    pub fn new(
        (scene, sketch): (&Scene, &Sketch),
        estimate: &Estimate,
        settled: Option<&Settled>,
        frame_rate_hz: f64,
    ) -> Result<Self, SamplingError> {
        let zero = zero(estimate, sketch);
        let bodies = 0..scene.bodies.len();
        let estimates = bodies.clone().map(|body| {
            let mut samples = estimate_frames(scene, estimate, body, zero, frame_rate_hz)?;
            if let Some(settled) = settled {
                append_settled(&mut samples, settled, body, zero);
            }
            Ok(samples)
        });
        Ok(Self {
            zero,
            estimates: estimates.collect::<Result<_, _>>()?,
            sketches: bodies
                .map(|body| sketch_frames(estimate, sketch, body, zero))
                .collect(),
        })
    }
}
