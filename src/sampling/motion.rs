//! All of a motion as frames.

use typed_index_collections::TiVec;

use super::error::SamplingError;
use super::frames::{append_settled, estimate_frames, sketch_frames, zero};
use super::joints::{SampledJoints, append_settled_joints, joint_frames};
use crate::motion::{Estimate, LinkIndex, PoseSample, Scene, Settled, Sketch, Stamp};

/// A motion as stamped poses, link by link: world from the frame in which the scene gives it, stamps strictly
/// increasing, quaternions continuous in sign.
#[derive(Clone, Debug, PartialEq)]
pub struct SampledMotion {
    /// The stamp of physical time zero.
    pub zero: Stamp,
    /// The estimated motion, and after its end what is simulated; empty of a link without flights.
    pub estimates: TiVec<LinkIndex, Vec<PoseSample>>,
    /// The joints of each tree of the scene, at the stamps of its links' poses.
    pub joints: Vec<SampledJoints>,
    /// The performance, at its physical times.
    pub sketches: TiVec<LinkIndex, Vec<PoseSample>>,
}

impl SampledMotion {
    /// Samples an estimate at a rate; see [`estimate_frames`]. What was simulated after it has an
    /// interval of its own. Fails where the rate is no such rate, or the motion too long for it.
    pub fn new(
        scene: &Scene,
        sketch: &Sketch,
        estimate: &Estimate,
        settled: Option<&Settled>,
        frame_rate_hz: f64,
    ) -> Result<Self, SamplingError> {
        let zero = zero(estimate, sketch);
        let links = scene.links.keys();
        let estimates = links.clone().map(|link| {
            let mut samples = estimate_frames(scene, estimate, link, zero, frame_rate_hz)?;
            if let Some(settled) = settled {
                append_settled(&mut samples, settled, scene, link, zero);
            }
            Ok(samples)
        });
        let joints = scene.joint_trees().map(|(mechanism, joined)| {
            let mut samples =
                joint_frames(scene, estimate, mechanism, joined, zero, frame_rate_hz)?;
            if let Some(settled) = settled {
                append_settled_joints(&mut samples, settled, joined, zero);
            }
            Ok(SampledJoints { mechanism, samples })
        });
        Ok(Self {
            zero,
            estimates: estimates.collect::<Result<_, _>>()?,
            joints: joints.collect::<Result<_, _>>()?,
            sketches: links
                .map(|link| sketch_frames(scene, estimate, sketch, link, zero))
                .collect(),
        })
    }
}
