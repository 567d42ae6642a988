//! A keyframe as somebody writes it down: what of a body is known, and when.

use nalgebra::{Matrix6, Quaternion, UnitQuaternion, Vector3, Vector6};

use super::index::TrackIndex;
use super::scene::{Scene, Timing, Track};
use super::take::{Covariance, Holds, Mark, OpenTime, PoseSample, SampleSource, Stamp};
use crate::math::Pose;

/// What of a body is known at one instant: of the frame in which its scene gives it.
#[derive(Clone, Debug, PartialEq)]
pub struct Keyframe {
    /// When.
    pub time: KeyframeTime,
    /// Where the frame's origin is [m, world], if it is known.
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

impl Scene {
    /// Whether single samples of a track may have times that are not known: those of a body that
    /// flies, among samples with physical times. In an unknown tempo none are known.
    pub fn may_have_open_times(&self, track: TrackIndex) -> bool {
        matches!(self.timing, Timing::Known | Timing::Edited) && !self.sees_held(track)
    }
}

/// How a tracker is mounted on its link, and the frame of which keyframes of that are poses.
#[derive(Clone, Debug, PartialEq)]
pub struct Mount {
    track: Track,
    link_from_given: Pose,
}

impl Scene {
    /// How a track's tracker is mounted.
    pub fn mount(&self, track: TrackIndex) -> Mount {
        Mount {
            track: self.tracks[track].clone(),
            link_from_given: self.link_seen_by(track).link_from_given,
        }
    }
}

impl Mount {
    /// What the tracker reads of a keyframe. Where its time is not known, `near` says where
    /// among others it is, and where the search for its time begins; `may_be_open` is
    /// [`Scene::may_have_open_times`]. Fails, in words and with what to do instead, where the keyframe
    /// cannot be estimated.
    pub fn reading_of(
        &self,
        keyframe: &Keyframe,
        near: Stamp,
        may_be_open: bool,
    ) -> Result<PoseSample, &'static str> {
        let is_off_centre = [&self.track.link_from_tracker, &self.link_from_given]
            .iter()
            .any(|of| of.translation.vector != Vector3::zeros());
        let holds = match (&keyframe.position_m, &keyframe.orientation_wxyz) {
            (Some(_), Some(_)) => Holds::Pose,
            // Where the tracker is, off the centre of mass, depends on the orientation.
            (Some(_), None) if is_off_centre => {
                return Err(
                    "has no orientation, and the scene has its tracker or its origin off the centre of \
                     mass; write qw, qx, qy and qz, or a `tracker` without a position",
                );
            }
            (Some(_), None) => Holds::Position,
            (None, _) => Holds::Orientation,
        };
        let sds = (keyframe.position_sd_m, keyframe.orientation_sd_deg);
        if holds == Holds::Pose && sds.0.is_some() != sds.1.is_some() {
            return Err("has one standard deviation; write both, or neither");
        }
        let [w, x, y, z] = keyframe.orientation_wxyz.unwrap_or([1.0, 0.0, 0.0, 0.0]);
        let orientation = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z));
        let position_m = keyframe.position_m.unwrap_or_default();
        let world_from_given = Pose::from_parts(position_m.into(), orientation);
        let world_from_link = world_from_given * self.link_from_given.inverse();
        let world_from_tracker = world_from_link * self.track.link_from_tracker;
        let (stamp, open) = keyframe.time.about(near);
        if open.is_some() && !may_be_open {
            return Err(
                "has no known time, which takes `stamps = \"physical\"` or `\"edited\"` and a body \
                 that flies; write `t`",
            );
        }
        let mut sample = PoseSample::from_pose(stamp, &world_from_tracker);
        (sample.holds, sample.open) = (holds, open);
        sample.from = SampleSource::Keyframe;
        let seen = match (holds, sds) {
            (Holds::Pose, (Some(sd_m), Some(sd_deg))) => Some((sd_m, sd_deg)),
            // The other block is not looked at.
            (Holds::Position, (Some(sd_m), _)) => Some((sd_m, 1.0)),
            (Holds::Orientation, (_, Some(sd_deg))) => Some((1.0, sd_deg)),
            _ => None,
        };
        if let Some((sd_m, sd_deg)) = seen {
            let lever_m = world_from_tracker.translation.vector - position_m;
            sample.covariance = Some(covariance(sd_m, sd_deg.to_radians(), &lever_m));
        }
        Ok(sample)
    }

    /// The keyframe that a tracker's reading shows; `None` where that is no pose or part of one.
    pub fn keyframe_of(&self, sample: &PoseSample) -> Option<Keyframe> {
        let [x, y, z, w] = sample.quaternion_xyzw;
        let quaternion = Quaternion::new(w, x, y, z);
        let rotation = UnitQuaternion::try_new(quaternion, 0.5)?;
        let world_from_tracker = Pose::from_parts(sample.position_m.into(), rotation);
        let world_from_link = world_from_tracker * self.track.link_from_tracker.inverse();
        let world_from_given = world_from_link * self.link_from_given;
        let mut keyframe = Keyframe::of_pose(sample.stamp, &world_from_given);
        keyframe.time = KeyframeTime::of(sample);
        match sample.holds {
            Holds::Pose => {}
            Holds::Position => keyframe.orientation_wxyz = None,
            Holds::Orientation => keyframe.position_m = None,
            Holds::Direction => return None,
        }
        Some(keyframe).filter(Keyframe::is_finite)
    }
}

impl KeyframeTime {
    /// A stamp, near another where the time is not known, and how far the time may be from it.
    fn about(self, near: Stamp) -> (Stamp, Option<OpenTime>) {
        let open = |before_ns, after_ns| OpenTime {
            before_ns,
            after_ns,
        };
        match self {
            Self::Known(stamp) => (stamp, None),
            Self::Within(earliest, latest) => {
                let at = near.clamp(earliest, latest.max(earliest));
                let [before_ns, after_ns] = [at.0 - earliest.0, latest.0 - at.0].map(Some);
                (at, Some(open(before_ns, after_ns)))
            }
            Self::Unknown => (near, Some(open(None, None))),
        }
    }

    /// The time on a clock whose zero is elsewhere, and that has nothing before its zero.
    pub fn since(self, zero: Stamp) -> Self {
        let since = |stamp: Stamp| Stamp((stamp.0 - zero.0).max(0));
        match self {
            Self::Known(stamp) => Self::Known(since(stamp)),
            Self::Within(earliest, latest) => Self::Within(since(earliest), since(latest)),
            Self::Unknown => Self::Unknown,
        }
    }

    /// What a reading's stamp says of its time.
    fn of(sample: &PoseSample) -> Self {
        let at = sample.stamp.0;
        match sample.open {
            None => Self::Known(sample.stamp),
            Some(OpenTime {
                before_ns: Some(before_ns),
                after_ns: Some(after_ns),
            }) => Self::Within(Stamp(at - before_ns), Stamp(at + after_ns)),
            Some(_) => Self::Unknown,
        }
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
