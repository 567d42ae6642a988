//! A tracker's poses in order of time.

use nalgebra::{Quaternion, UnitQuaternion};

use super::error::CalibrateError;
use crate::math::Pose;
use crate::motion::{Holds, PoseSample, Stamp};

/// Greatest deviation of a quaternion's length from 1: more is no rounding.
const NOT_UNIT: f64 = 0.01;

/// One pose of a tracker.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    /// Since the stream's origin \[s\].
    pub time_s: f64,
    /// Pose of the tracker's frame.
    pub world_from_tracker: Pose,
}

/// The usable poses of a tracker.
#[derive(Clone, Debug, PartialEq)]
pub struct Stream {
    /// Where times count from.
    pub origin: Stamp,
    /// In order of time, each at a time of its own.
    pub readings: Vec<Reading>,
    /// Readings that are no poses: not finite, not unit, without place or orientation.
    pub unusable: usize,
    /// Readings left out because another has the same stamp.
    pub repeated: usize,
}

impl Stream {
    /// Sorts readings and leaves out what is no pose. Times count from `origin`, or from the first
    /// sample. Fails where fewer than `least` are left.
    pub fn of(
        samples: &[PoseSample],
        origin: Option<Stamp>,
        least: usize,
    ) -> Result<Self, CalibrateError> {
        let mut usable: Vec<(Stamp, Pose)> = samples
            .iter()
            .filter_map(|sample| Some((sample.stamp, pose(sample)?)))
            .collect();
        let unusable = samples.len() - usable.len();
        usable.sort_by_key(|(stamp, _)| *stamp);
        let before = usable.len();
        usable.dedup_by_key(|(stamp, _)| *stamp);
        let repeated = before - usable.len();
        if usable.len() < least {
            return Err(CalibrateError::TooFew {
                usable: usable.len(),
                least,
            });
        }
        let origin = origin.or(usable.first().map(|(stamp, _)| *stamp));
        let origin = origin.unwrap_or(Stamp(0));
        let readings = usable
            .into_iter()
            .map(|(stamp, world_from_tracker)| Reading {
                time_s: (i128::from(stamp.0) - i128::from(origin.0)) as f64 * 1e-9,
                world_from_tracker,
            });
        Ok(Self {
            origin,
            readings: readings.collect(),
            unusable,
            repeated,
        })
    }

    /// The readings from one time to another \[s\]. Fails where fewer than `least` are left.
    pub fn between(
        mut self,
        from_s: Option<f64>,
        to_s: Option<f64>,
        least: usize,
    ) -> Result<Self, CalibrateError> {
        let (from_s, to_s) = (
            from_s.unwrap_or(f64::NEG_INFINITY),
            to_s.unwrap_or(f64::INFINITY),
        );
        self.readings
            .retain(|reading| reading.time_s >= from_s && reading.time_s <= to_s);
        if self.readings.len() < least {
            return Err(CalibrateError::TooFew {
                usable: self.readings.len(),
                least,
            });
        }
        Ok(self)
    }

    /// First and last time \[s\]; zeros of an empty stream.
    pub fn extent_s(&self) -> [f64; 2] {
        let time_s = |reading: Option<&Reading>| reading.map_or(0.0, |of| of.time_s);
        [time_s(self.readings.first()), time_s(self.readings.last())]
    }

    /// The median interval between readings \[s\]; `None` of fewer than two.
    pub fn interval_s(&self) -> Option<f64> {
        let pairs = self.readings.windows(2);
        let mut intervals: Vec<f64> = pairs.map(|of| of[1].time_s - of[0].time_s).collect();
        intervals.sort_by(f64::total_cmp);
        intervals.get(intervals.len() / 2).copied()
    }
}

fn pose(sample: &PoseSample) -> Option<Pose> {
    let [x, y, z, w] = sample.quaternion_xyzw;
    let quaternion = Quaternion::new(w, x, y, z);
    let is_pose = sample.holds == Holds::Pose
        && sample.position_m.iter().all(|x| x.is_finite())
        && (quaternion.norm() - 1.0).abs() <= NOT_UNIT;
    is_pose.then(|| {
        Pose::from_parts(
            sample.position_m.into(),
            UnitQuaternion::from_quaternion(quaternion),
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    fn sample(stamp: i64, x: f64, w: f64) -> PoseSample {
        PoseSample::new(Stamp(stamp), Vector3::new(x, 0.0, 0.0), [0.0, 0.0, 0.0, w])
    }

    #[test]
    fn readings_are_sorted_and_what_is_no_pose_is_counted() {
        let samples = [
            sample(3_000_000_000, 3.0, 1.0),
            sample(1_000_000_000, 1.0, -1.0),
            sample(2_000_000_000, f64::NAN, 1.0),
            sample(2_500_000_000, 2.0, 0.5),
            sample(1_000_000_000, 9.0, 1.0),
        ];
        let stream = Stream::of(&samples, None, 2).unwrap();
        let times: Vec<f64> = stream.readings.iter().map(|of| of.time_s).collect();
        assert_eq!(times, [0.0, 2.0]);
        assert_eq!((stream.unusable, stream.repeated), (2, 1));
        let few = Stream::of(&samples, None, 3).unwrap_err();
        assert_eq!(
            few,
            CalibrateError::TooFew {
                usable: 2,
                least: 3
            }
        );
        assert!(stream.clone().between(Some(1.0), None, 2).is_err());
        assert_eq!(stream.interval_s(), Some(2.0));
    }
}
