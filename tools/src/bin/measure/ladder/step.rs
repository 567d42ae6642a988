//! What one rung makes of many takes: errors where samples were held out, and how often intervals
//! hold.

use std::collections::BTreeMap;

use enact::estimate::outcome::PHYSICAL;
use enact::math::Pose;
use enact::motion::{PoseSample, Stamp};
use enact::pipeline::{Outcome, PipelineError};
use enact_tools::errors::has_converged;
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
    /// Takes without a motion.
    pub failed: usize,
    /// Rms over the held samples of each take, if it has a motion [m, rad]: to the truth, where it is
    /// known,
    pub to_truth: Vec<Option<[f64; 2]>>,
    /// and to the samples.
    pub to_samples: Vec<Option<[f64; 2]>>,
    /// Of the components of poses that have an interval: whether it holds the truth,
    pub truth: Held,
    /// whether that of white noise alone does, of the size that the weights say,
    pub stated: Held,
    /// and whether it holds the sample, white noise included.
    pub samples: Held,
    /// Components with an interval, and without.
    pub intervals: usize,
    pub undetermined: usize,
    /// What is set free though the scene does not free it, and in how many takes.
    pub set_free: BTreeMap<String, usize>,
}

/// Errors in their intervals.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Held {
    /// Within 95 %.
    pub within: usize,
    /// Sum of the squares of errors over deviations.
    pub squares: f64,
}

impl Held {
    fn add(&mut self, error: f64, sd: f64) {
        self.within += usize::from(error.abs() <= INTERVALS[2].1 * sd);
        self.squares += (error / sd).powi(2);
    }
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
        let Some(outcome) = closed(found) else {
            self.failed += 1;
            self.to_samples.push(None);
            self.to_truth.extend(truth.map(|_| None));
            return;
        };
        if !outcome.freed.is_empty() {
            let first = outcome.freed.iter().flat_map(|freed| freed.values.first());
            let names = first.map(|(quantity, _)| outcome.given.name_of_quantity(*quantity));
            let names = names.collect::<Vec<_>>().join(" and ");
            *self.set_free.entry(names).or_default() += 1;
        }
        let stamps: Vec<Stamp> = split.held.iter().map(|sample| sample.stamp).collect();
        let predicted = poses(outcome, &stamps);
        let errors = |against: &dyn Fn(&PoseSample) -> Pose| -> Vec<Six> {
            let pairs = predicted.iter().zip(&split.held);
            pairs
                .map(|(pose, sample)| difference(pose, &against(sample)))
                .collect()
        };
        let from_samples = errors(&pose_of);
        self.to_samples.push(Some(rms_of(&from_samples)));
        let from_truth = truth.map(|truth| errors(&|sample| truth(sample.stamp)));
        let to_truth = from_truth.as_deref().map(rms_of);
        self.to_truth.extend(to_truth.map(Some));
        let Some(deviations) = deviations(outcome, &stamps) else {
            self.undetermined += 6 * stamps.len();
            return;
        };
        for (index, sds) in deviations.sds.iter().enumerate() {
            for (component, sd) in sds.iter().enumerate() {
                let stated = deviations.stated[index][component];
                let (Some(sd), Some(stated)) = (*sd, stated) else {
                    self.undetermined += 1;
                    continue;
                };
                self.intervals += 1;
                let with_noise = sd.hypot(deviations.noise[component / 3]);
                self.samples.add(from_samples[index][component], with_noise);
                if let Some(from_truth) = &from_truth {
                    self.truth.add(from_truth[index][component], sd);
                    self.stated.add(from_truth[index][component], stated);
                }
            }
        }
    }

    fn of(&self, against: Against) -> &[Option<[f64; 2]>] {
        match against {
            Against::Truth => &self.to_truth,
            Against::Samples => &self.to_samples,
        }
    }

    /// Whether each take has a motion.
    pub fn has_motion(&self) -> impl Iterator<Item = bool> {
        self.to_samples.iter().map(Option::is_some)
    }

    /// The errors of some of the takes alone, and nothing else.
    pub fn of_takes(&self, are_in: &[bool]) -> Self {
        let some = |errors: &[Option<[f64; 2]>]| {
            let pairs = errors.iter().zip(are_in).filter(|(_, is_in)| **is_in);
            pairs.map(|(error, _)| *error).collect()
        };
        Self {
            to_truth: some(&self.to_truth),
            to_samples: some(&self.to_samples),
            ..Self::new(&self.wrong, &self.freed)
        }
    }

    /// The same under another name in a figure.
    pub fn named(self, wrong: &str) -> Self {
        Self {
            wrong: wrong.to_owned(),
            ..self
        }
    }

    /// Errors of position, take by take \[mm\].
    pub fn positions_mm(&self, against: Against) -> Vec<f64> {
        let errors = self.of(against).iter().flatten();
        errors.map(|error| 1e3 * error[0]).collect()
    }

    /// Errors of orientation, take by take \[°\].
    pub fn orientations_deg(&self, against: Against) -> Vec<f64> {
        let errors = self.of(against).iter().flatten();
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
    pub fn coverage(&self, held: &Held) -> String {
        percent(held.within, self.intervals)
    }

    /// The same as a number.
    pub fn covered(&self, held: &Held) -> f64 {
        100.0 * held.within as f64 / self.intervals as f64
    }

    /// `97.8 % (0.81)`: the same, and the rms error over its deviation.
    pub fn widths(&self, held: &Held) -> String {
        let ratio = (held.squares / self.intervals as f64).sqrt();
        format!("{} ({})", self.coverage(held), number(ratio))
    }
}

/// A motion without gaps, whatever checks say of it.
pub fn closed(found: &Result<Outcome, PipelineError>) -> Option<&Outcome> {
    let found = found.as_ref().ok();
    found.filter(|outcome| {
        let mut events = outcome.estimate.events.iter();
        has_converged(&outcome.estimate) && events.all(|of| of.gap.max(&PHYSICAL) == PHYSICAL)
    })
}

/// Where a sample has the tracker \[world\].
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
