//! What one rung makes of many takes: errors where samples were held out, and how often intervals
//! hold.

use enact::math::Pose;
use enact::motion::{PoseSample, Stamp, Verdict};
use enact::pipeline::{Outcome, PipelineError};
use nalgebra::{Quaternion, UnitQuaternion};
use serde::Serialize;

use super::predict::{Six, deviations, difference, poses};
use super::split::Split;
use crate::statistics::{INTERVALS, median, quantile, rms};
use crate::table::{number, percent};

/// Of one rung in one kind of scene.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Step {
    pub wrong: String,
    pub freed: String,
    pub takes: usize,
    /// Takes without a physical motion.
    pub failed: usize,
    /// Rms over the held samples of a take [m, rad]: to the truth, where it is known,
    pub to_truth: Vec<[f64; 2]>,
    /// and to the samples.
    pub to_samples: Vec<[f64; 2]>,
    /// Components of poses whose 95 % interval holds the truth, or the sample.
    pub truth_within: usize,
    pub sample_within: usize,
    /// Components with an interval, and without.
    pub intervals: usize,
    pub undetermined: usize,
}

/// Which error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Against {
    Truth,
    Samples,
}

impl Step {
    pub fn new(wrong: &str, freed: &str) -> Self {
        Self {
            wrong: wrong.to_owned(),
            freed: freed.to_owned(),
            ..Self::default()
        }
    }

    /// Adds a take, with the true pose of its tracker at a stamp, where it is known.
    pub fn add(
        &mut self,
        split: &Split,
        found: &Result<Outcome, PipelineError>,
        truth: Option<&dyn Fn(Stamp) -> Pose>,
    ) {
        self.takes += 1;
        let Some(outcome) = physical(found) else {
            self.failed += 1;
            return;
        };
        let stamps: Vec<Stamp> = split.held.iter().map(|sample| sample.stamp).collect();
        let predicted = poses(outcome, &stamps);
        let errors = |against: &dyn Fn(&PoseSample) -> Pose| -> Vec<Six> {
            let pairs = predicted.iter().zip(&split.held);
            pairs
                .map(|(pose, sample)| difference(pose, &against(sample)))
                .collect()
        };
        let from_samples = errors(&pose_of);
        self.to_samples.push(rms_of(&from_samples));
        let from_truth = truth.map(|truth| errors(&|sample| truth(sample.stamp)));
        self.to_truth.extend(from_truth.as_deref().map(rms_of));
        let Some(deviations) = deviations(outcome, &stamps) else {
            self.undetermined += 6 * stamps.len();
            return;
        };
        let width = INTERVALS[2].1;
        for (index, sds) in deviations.sds.iter().enumerate() {
            for (component, sd) in sds.iter().enumerate() {
                let Some(sd) = sd else {
                    self.undetermined += 1;
                    continue;
                };
                self.intervals += 1;
                let with_noise = sd.hypot(deviations.noise[component / 3]);
                let is_within =
                    |errors: &[Six], sd: f64| errors[index][component].abs() <= width * sd;
                let truth = from_truth.as_deref();
                self.truth_within += usize::from(truth.is_some_and(|of| is_within(of, *sd)));
                self.sample_within += usize::from(is_within(&from_samples, with_noise));
            }
        }
    }

    fn of(&self, against: Against) -> &[[f64; 2]] {
        match against {
            Against::Truth => &self.to_truth,
            Against::Samples => &self.to_samples,
        }
    }

    /// Errors of position, take by take \[mm\].
    pub fn positions_mm(&self, against: Against) -> Vec<f64> {
        self.of(against)
            .iter()
            .map(|error| 1e3 * error[0])
            .collect()
    }

    /// Errors of orientation, take by take \[°\].
    pub fn orientations_deg(&self, against: Against) -> Vec<f64> {
        let errors = self.of(against).iter();
        errors.map(|error| error[1].to_degrees()).collect()
    }

    /// `0.71 mm (1.6), 0.30° (0.8)`: median and ninth decile.
    pub fn errors(&self, against: Against) -> String {
        let of = |values: Vec<f64>, unit: &str| {
            let [middle, high] = [median(&values), quantile(&values, 0.9)];
            format!("{}{unit} ({})", number(middle), number(high))
        };
        let position = of(self.positions_mm(against), " mm");
        let orientation = of(self.orientations_deg(against), "°");
        format!("{position}, {orientation}")
    }

    /// Share of the intervals that hold.
    pub fn coverage(&self, against: Against) -> String {
        percent(self.within(against), self.intervals)
    }

    fn within(&self, against: Against) -> usize {
        match against {
            Against::Truth => self.truth_within,
            Against::Samples => self.sample_within,
        }
    }

    /// The same as a number.
    pub fn covered(&self, against: Against) -> f64 {
        100.0 * self.within(against) as f64 / self.intervals as f64
    }
}

/// A physical motion.
pub fn physical(found: &Result<Outcome, PipelineError>) -> Option<&Outcome> {
    let found = found.as_ref().ok();
    found.filter(|outcome| outcome.estimate.verdict == Verdict::Physical)
}

/// Where a sample has the tracker [world].
pub fn pose_of(sample: &PoseSample) -> Pose {
    let [x, y, z, w] = sample.quaternion_xyzw;
    let orientation = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z));
    Pose::from_parts(sample.position_m.into(), orientation)
}

/// Root mean squares of distances \[m\] and angles \[rad\].
fn rms_of(errors: &[Six]) -> [f64; 2] {
    [0, 3].map(|first| {
        let norms = errors.iter().map(|six| {
            let squares = six[first..first + 3].iter().map(|x| x * x);
            squares.sum::<f64>().sqrt()
        });
        rms(&norms.collect::<Vec<f64>>())
    })
}
