//! Takes that stand out, and what each does to the answer.

use nalgebra::{DMatrix, DVector};

use super::interval::{JointInterval, Optimum};
use super::parameter::{NORMAL_MEDIAN, lengths};
use super::part::PlainPart;
use super::search::JointSearch;
use crate::motion::TakeShare;

/// A take whose own value is so many times as far off as takes are differs from the others.
const FAR: f64 = 5.0;
/// A take whose residual is so many times that of the others is worse.
const WORSE: f64 = 3.0;
/// So many takes tell how far takes are off.
const ENOUGH: usize = 5;
/// A take by itself tells a parameter that it knows to so much of its length.
const TOLD: f64 = 0.5;

/// What is said of a take among others.
#[derive(Clone, Debug, PartialEq)]
pub struct TakeJudged {
    /// By how much each joint value would change without it, SI.
    pub influence: DVector<f64>,
    /// The greatest of these, in standard deviations of the joint value, and of which parameter.
    pub most: Option<(usize, f64)>,
    /// Its own value of each parameter with its standard deviation, SI, where it tells one by itself.
    pub own: Vec<Option<[f64; 2]>>,
    /// How far its own value that is farthest off is, in robust standard deviations of how far takes are.
    pub score: f64,
    /// Why it stands out; none where it does not.
    pub standout: Vec<Standout>,
}

/// Why a take stands out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Standout {
    /// Its own value of a parameter is far from those of others: how many robust standard deviations.
    Differs {
        /// The parameter, by its index.
        parameter: usize,
        /// How far.
        times: f64,
    },
    /// Its residual is that many times the median of all takes: positions (0) or orientations (1).
    Worse {
        /// Of what.
        kind: usize,
        /// How many times.
        times: f64,
    },
}

impl JointSearch {
    /// What is said of each take at the optimum, of which the intervals are known; none of those that take no part.
    pub fn judged(
        &self,
        shares: &[Option<TakeShare>],
        intervals: &[JointInterval],
    ) -> Vec<Option<TakeJudged>> {
        let parts = self.parts(shares);
        let optimum = Optimum::of(self, &self.of_means(&parts));
        let own: Vec<Vec<Option<[f64; 2]>>> = parts.iter().map(|of| self.own(of)).collect();
        let offs = self.offs(&own);
        let taking: Vec<&TakeShare> = shares
            .iter()
            .enumerate()
            .filter_map(|(at, share)| share.as_ref().filter(|_| self.is_taking_part(at)))
            .collect();
        let usual = [0, 1]
            .map(|kind| median(taking.iter().map(|of| of.residual[kind]).collect()).unwrap_or(0.0));
        let lengths = lengths(self.parameters());
        let mut next = 0..parts.len();
        let each = shares.iter().enumerate().map(|(at, share)| {
            let share = share.as_ref().filter(|_| self.is_taking_part(at))?;
            let take = next.next()?;
            let influence = optimum.as_ref().map_or_else(
                || DVector::zeros(lengths.len()),
                |of| of.influence(take).component_mul(&lengths),
            );
            let times = influence.iter().zip(intervals).enumerate();
            let times = times.filter_map(|(at, (by, of))| Some((at, by.abs() / of.sd?)));
            let most = times.max_by(|a, b| a.1.total_cmp(&b.1));
            let farthest = offs[take].iter().copied().enumerate();
            let farthest = farthest.filter_map(|(at, off)| Some((at, off?)));
            let farthest = farthest.max_by(|a, b| a.1.total_cmp(&b.1));
            let score = farthest.map_or(0.0, |(_, off)| off);
            let is_enough = parts.len() >= ENOUGH;
            let differs = farthest.filter(|(_, off)| is_enough && *off > FAR);
            let differs = differs.map(|(parameter, times)| Standout::Differs { parameter, times });
            let worse = (0..2).filter_map(|kind| {
                let times = share.residual[kind] / usual[kind];
                (is_enough && times > WORSE).then_some(Standout::Worse { kind, times })
            });
            let own = own[take].iter().zip(&lengths);
            Some(TakeJudged {
                influence,
                most,
                own: own
                    .map(|(own, length)| own.map(|of| of.map(|x| x * length)))
                    .collect(),
                score,
                standout: differs.into_iter().chain(worse).collect(),
            })
        });
        each.collect()
    }

    /// The values that a take by itself tells, with their deviations, in lengths.
    fn own(&self, part: &PlainPart) -> Vec<Option<[f64; 2]>> {
        let count = self.parameters().len();
        let Some(covariance) = part.alone() else {
            return vec![None; count];
        };
        let off = -(&covariance * &part.gradient);
        let each = (0..count).map(|at| {
            let sd = covariance[(at, at)].max(0.0).sqrt();
            (sd < TOLD).then(|| [self.mean()[at] + off[at], sd])
        });
        each.collect()
    }

    /// How far own values are off their median, which a few that differ do not move, in robust deviations of how far those of
    /// all takes are.
    fn offs(&self, own: &[Vec<Option<[f64; 2]>>]) -> Vec<Vec<Option<f64>>> {
        let usual = (0..self.parameters().len()).map(|at| {
            let values = || {
                own.iter()
                    .filter_map(|take| take[at])
                    .map(|[value, _]| value)
            };
            let middle = median(values().collect()).unwrap_or(0.0);
            let offs = values().map(|value| (value - middle).abs());
            [
                middle,
                median(offs.collect()).unwrap_or(0.0) / NORMAL_MEDIAN,
            ]
        });
        let usual: Vec<[f64; 2]> = usual.collect();
        let each = own.iter().map(|take| {
            let of_take = take.iter().zip(&usual).map(|(own, [middle, usual])| {
                let [value, sd] = (*own)?;
                Some((value - middle).abs() / sd.hypot(*usual))
            });
            of_take.collect()
        });
        each.collect()
    }
}

impl Optimum {
    /// By how much the joint values, in lengths, would change without a take, to first order.
    fn influence(&self, take: usize) -> DVector<f64> {
        let information = &self.informations[take];
        let count = information.nrows();
        let left = DMatrix::identity(count, count) - information;
        let change = left.lu().solve(&self.gradients[take]);
        let change = change.unwrap_or_else(|| self.gradients[take].clone());
        &self.frame * change
    }
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.retain(|value| value.is_finite());
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}
