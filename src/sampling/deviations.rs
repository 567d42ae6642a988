//! How certain the motion is at its frames.

use crate::motion::{ArcEstimate, Estimate, LinkIndex, PoseSample, Scene, Stamp, StateDeviation};

/// How far a stamp may be after the end of a flight of which it is the end \[s\]: it is rounded to nanoseconds.
const ROUNDED_S: f64 = 1e-9;

/// How certain a link is at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeviationSample {
    /// When.
    pub stamp: Stamp,
    /// Of the frame in which the scene gives the link.
    pub deviation: StateDeviation,
}

/// How certain a link is at those of its poses that are of flights of which that is known; at an impact before it. None
/// where the link is in the hand, joined to others, or simulated.
pub fn deviation_frames(
    scene: &Scene,
    estimate: &Estimate,
    link: LinkIndex,
    poses: &[PoseSample],
    zero: Stamp,
) -> Vec<DeviationSample> {
    let mechanism = scene.mechanism_of(link);
    let is_own = |arc: &&ArcEstimate| arc.mechanism == mechanism && arc.end_s >= arc.start_s;
    let flights: Vec<&ArcEstimate> = estimate.arcs.iter().filter(is_own).collect();
    let samples = poses.iter().filter_map(|pose| {
        let time_s = pose.stamp.seconds_since(zero);
        let mut flights = flights.iter();
        let flight = flights.find(|arc| time_s <= arc.end_s + ROUNDED_S)?;
        // Before it the link is in a hand.
        let flight = (time_s >= flight.start_s - ROUNDED_S).then_some(flight)?;
        Some(DeviationSample {
            stamp: pose.stamp,
            deviation: flight.deviation(scene, &estimate.gravity_m_s2, time_s)?,
        })
    });
    samples.collect()
}
