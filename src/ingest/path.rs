//! What the readings of a topic are like, one after the other.

use nalgebra::Vector3;

use crate::motion::{Holds, PoseSample};

/// Paths of two publishers are told apart from this distance on \[m\].
const APART_M: f64 = 2e-3;
/// A reading is away from its neighbours when it is so many times as far from them as they are from each other.
const AWAY: f64 = 3.0;
/// So many of the readings must be away for it to be no outliers.
const SHARE: f64 = 0.2;
/// At least.
const LEAST: u64 = 10;

/// Greatest deviation of a quaternion's norm from 1 that nobody asks about.
const NORM_SAID: f64 = 0.01;

/// What the readings of a topic were like so far.
#[derive(Clone, Debug, Default)]
pub(super) struct PathSeen {
    last_m: [Option<Vector3<f64>>; 2],
    readings: u64,
    away: u64,
    apart_m: f64,
    norms: Option<[f64; 2]>,
    odd_norms: u64,
}

impl PathSeen {
    /// Notes the next reading.
    pub(super) fn note(&mut self, sample: &PoseSample) {
        self.readings += 1;
        if matches!(sample.holds, Holds::Pose | Holds::Orientation) {
            self.note_norm(sample.quaternion_xyzw);
        }
        let at_m = sample.position_m;
        if !matches!(sample.holds, Holds::Pose | Holds::Position)
            || !at_m.iter().all(|of| of.is_finite())
        {
            return;
        }
        if let [Some(before_m), Some(last_m)] = self.last_m {
            let (step_m, over_m) = ((at_m - last_m).norm(), (at_m - before_m).norm());
            if step_m > APART_M && step_m > AWAY * over_m {
                self.away += 1;
                self.apart_m = self.apart_m.max(step_m);
            }
        }
        self.last_m = [self.last_m[1], Some(at_m)];
    }

    fn note_norm(&mut self, quaternion_xyzw: [f64; 4]) {
        let norm = quaternion_xyzw.iter().map(|of| of * of).sum::<f64>().sqrt();
        // A quaternion of zeros says that nothing was seen.
        if !norm.is_finite() || norm == 0.0 {
            return;
        }
        self.odd_norms += u64::from((norm - 1.0).abs() > NORM_SAID);
        let [least, greatest] = self.norms.unwrap_or([norm; 2]);
        self.norms = Some([least.min(norm), greatest.max(norm)]);
    }

    /// Whether it is two paths, of which the readings come in turn, in words.
    pub(super) fn mixed(&self, topic: &str) -> Option<String> {
        let share = self.away as f64 / self.readings.max(1) as f64;
        (self.away >= LEAST && share >= SHARE).then(|| {
            format!(
                "readings on {topic} go back and forth between two paths, {} of {} by up to {:.3} m: two publishers \
                 seem to share the topic; expected one, or topics of their own",
                self.away, self.readings, self.apart_m
            )
        })
    }

    /// Whether quaternions have other norms than 1, in words.
    pub(super) fn norms(&self, topic: &str) -> Option<String> {
        let [least, greatest] = self.norms.filter(|_| self.odd_norms > 0)?;
        Some(format!(
            "{} of {} quaternions on {topic} have a norm other than 1, in all {least:.3} to {greatest:.3}: those off by \
             a tenth or less are normalised, others are left out",
            self.odd_norms, self.readings
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::Stamp;

    fn seen(points: impl IntoIterator<Item = Vector3<f64>>) -> PathSeen {
        let mut path = PathSeen::default();
        for point in points {
            path.note(&PoseSample::new(Stamp(0), point, [0.0, 0.0, 0.0, 1.0]));
        }
        path
    }

    fn toss(index: usize) -> Vector3<f64> {
        let time_s = index as f64 / 120.0;
        Vector3::new(1.5 * time_s, 0.0, 3.0 * time_s - 4.9 * time_s * time_s)
    }

    #[test]
    fn two_publishers_in_turn_are_two_paths() {
        let beside = Vector3::new(0.5, 0.5, 0.5);
        let in_turn = (0..200).map(|at| toss(at / 2) + beside * (at % 2) as f64);
        assert!(seen(in_turn).mixed("/t").is_some());
        let still = (0..200).map(|at| match at % 2 {
            0 => toss(at / 2),
            _ => Vector3::new(1.0, 1.0, 1.0),
        });
        assert!(seen(still).mixed("/t").is_some());
        // One that sends half as often as the other.
        let third = (0..200).map(|at| toss(at) + beside * f64::from(u8::from(at % 3 == 2)));
        assert!(seen(third).mixed("/t").is_some());
    }

    #[test]
    fn one_path_is_one_whatever_it_does() {
        assert_eq!(seen((0..200).map(toss)).mixed("/t"), None);
        // Noise at rest, an outlier in ten, a hand that shakes.
        let noise = |at: usize| (at as f64 * 12.9898).sin() * 43_758.547 % 1.0;
        let rest =
            (0..300).map(|at| Vector3::new(noise(at), noise(at + 7), noise(at + 13)) * 0.004);
        assert_eq!(seen(rest).mixed("/t"), None);
        let outliers =
            (0..200).map(|at| toss(at) + Vector3::x() * f64::from(u8::from(at % 10 == 0)));
        assert_eq!(seen(outliers).mixed("/t"), None);
        let shakes = (0..400)
            .map(|at| Vector3::x() * (at as f64 / 10.0 * std::f64::consts::TAU).sin() * 0.05);
        assert_eq!(seen(shakes).mixed("/t"), None);
    }
}
