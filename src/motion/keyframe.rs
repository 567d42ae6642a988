//! A keyframe as somebody writes it down: what of a body is known, and when.

use nalgebra::{Matrix6, Quaternion, UnitQuaternion, Vector3, Vector6};

use super::index::TrackIndex;
use super::scene::Track;
use super::take::{Covariance, Mark, PoseSample, Stamp};
use crate::math::Pose;

/// What of a body is known at one instant, in the body's own axes at its centre of mass.
#[derive(Clone, Debug, PartialEq)]
pub struct Keyframe {
    /// When.
    pub time: KeyframeTime,
    /// Centre of mass [m, world], if it is known.
    pub position_m: Option<Vector3<f64>>,
    /// World from body, `[w, x, y, z]`, if it is known.
    pub orientation_wxyz: Option<[f64; 4]>,
    /// Standard deviation of the position per axis \[m\]; `None`: as the scene weighs it.
    pub position_sd_m: Option<f64>,
    /// Standard deviation of the orientation per axis \[°\]; `None`: as the scene weighs it.
    pub orientation_sd_deg: Option<f64>,
}

/// When a keyframe is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum KeyframeTime {
    /// At a time.
    Known(Stamp),
    /// From an earliest time to a latest.
    Within(Stamp, Stamp),
    /// At any time between its neighbours.
    Unknown,
}

/// One row of a written sketch.
#[derive(Clone, Debug, PartialEq)]
pub enum SketchRow {
    /// A keyframe of a body.
    Keyframe {
        /// The body's track.
        track: TrackIndex,
        /// Its flight, counted from 0; 0 where the sketch is not edited.
        flight: usize,
        /// What is known.
        keyframe: Keyframe,
    },
    /// When an event happens.
    Mark(Mark),
}

impl Keyframe {
    /// What of it cannot be estimated, in words, with what to do instead; `None` where it is a full
    /// pose at a known time, with both standard deviations or neither.
    pub fn unsupported(&self) -> Option<&'static str> {
        match self {
            Self {
                time: KeyframeTime::Unknown | KeyframeTime::Within(..),
                ..
            } => Some("has no known time; write `t`"),
            Self {
                position_m: None, ..
            } => Some("has no position; write x, y and z"),
            Self {
                orientation_wxyz: None,
                ..
            } => Some("has no orientation; write qw, qx, qy and qz"),
            _ if self.position_sd_m.is_some() != self.orientation_sd_deg.is_some() => {
                Some("has one standard deviation; write both, or neither")
            }
            _ => None,
        }
    }
}

impl Track {
    /// What the track's tracker reads of a keyframe; `None` where that has no full pose or no known
    /// time.
    pub fn reading_of(&self, keyframe: &Keyframe) -> Option<PoseSample> {
        let KeyframeTime::Known(stamp) = keyframe.time else {
            return None;
        };
        let [w, x, y, z] = keyframe.orientation_wxyz?;
        let orientation = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z));
        let world_from_link = Pose::from_parts(keyframe.position_m?.into(), orientation);
        let world_from_tracker = world_from_link * self.link_from_tracker;
        let mut sample = PoseSample::from_pose(stamp, &world_from_tracker);
        if let (Some(sd_m), Some(sd_deg)) = (keyframe.position_sd_m, keyframe.orientation_sd_deg) {
            let lever_m = world_from_link.rotation * self.link_from_tracker.translation.vector;
            sample.covariance = Some(covariance(sd_m, sd_deg.to_radians(), &lever_m));
        }
        Some(sample)
    }

    /// The keyframe that a tracker's reading shows; `None` where that is no pose.
    pub fn keyframe_of(&self, sample: &PoseSample) -> Option<Keyframe> {
        let [x, y, z, w] = sample.quaternion_xyzw;
        let quaternion = Quaternion::new(w, x, y, z);
        let rotation = UnitQuaternion::try_new(quaternion, 0.5)?;
        let world_from_tracker = Pose::from_parts(sample.position_m.into(), rotation);
        let world_from_link = world_from_tracker * self.link_from_tracker.inverse();
        Some(Keyframe::of_pose(sample.stamp, &world_from_link)).filter(Keyframe::is_finite)
    }
}

impl Keyframe {
    /// A full pose at a time.
    pub fn of_pose(stamp: Stamp, world_from_body: &Pose) -> Self {
        let q = world_from_body.rotation.quaternion();
        Self {
            time: KeyframeTime::Known(stamp),
            position_m: Some(world_from_body.translation.vector),
            orientation_wxyz: Some([q.w, q.i, q.j, q.k]),
            position_sd_m: None,
            orientation_sd_deg: None,
        }
    }

    fn is_finite(&self) -> bool {
        let place = self.position_m.iter().flat_map(|p| p.iter());
        let turn = self.orientation_wxyz.iter().flatten();
        place.chain(turn).all(|number| number.is_finite())
    }
}

/// The covariance of a tracker's pose on a body whose position and orientation are uncertain by so
/// much per axis: the tracker, on its lever from the centre of mass, moves as the body turns.
fn covariance(sd_m: f64, sd_rad: f64, lever_m: &Vector3<f64>) -> Covariance {
    let mut by_body = Matrix6::<f64>::identity();
    let by_turn = -lever_m.cross_matrix();
    by_body.fixed_view_mut::<3, 3>(0, 3).copy_from(&by_turn);
    let sds = Vector6::new(sd_m, sd_m, sd_m, sd_rad, sd_rad, sd_rad);
    let variances = Matrix6::from_diagonal(&sds.component_mul(&sds));
    let of_tracker = by_body * variances * by_body.transpose();
    let mut rows = [0.0; 36];
    for (at, entry) in rows.iter_mut().enumerate() {
        *entry = of_tracker[(at / 6, at % 6)];
    }
    Covariance::of_rows(&rows)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tracker_on_a_lever_is_as_uncertain_as_the_turn_makes_it() {
        let of = covariance(0.001, 0.02, &Vector3::new(0.0, 0.0, 0.1)).matrix();
        // One millimetre, and a tenth of a metre times 0.02 rad across the lever.
        for (axis, expected) in [(0, 5e-6), (1, 5e-6), (2, 1e-6), (3, 4e-4)] {
            let variance: f64 = of[(axis, axis)];
            assert!(
                (variance - expected).abs() < 1e-5 * expected,
                "{axis}: {variance}"
            );
        }
        // A turn about y moves it along x.
        assert!((of[(0, 4)] - 0.1 * 4e-4).abs() < 1e-9);
    }
}
