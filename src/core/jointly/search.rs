//! A search for the joint optimum: where each take is asked, and what is known so far.

mod rounds;

use nalgebra::{DMatrix, DVector};

use super::begin::JointBegin;
use super::parameter::{JointParameter, lengths};
use super::part::{MeanPart, PlainPart, Total};
use super::weak::{WeakDirection, weak};
use crate::motion::TakeShare;

/// What a round leads to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SearchTurn {
    /// The takes are to be asked again.
    Again,
    /// The optimum is found.
    Found,
    /// It was not found in as many rounds as there may be, or the takes have none.
    Lost,
}

/// A search for the joint optimum.
#[derive(Clone, Debug)]
pub struct JointSearch {
    parameters: Vec<JointParameter>,
    /// In lengths, like all that follows: the joint values, the variances of what is drawn,
    mean: DVector<f64>,
    variances: DVector<f64>,
    /// and where each take is asked.
    asked: Vec<DVector<f64>>,
    /// Which takes take part.
    taking: Vec<bool>,
    /// Directions that are not determined, once that is known.
    held: Option<DMatrix<f64>>,
    weak: Vec<WeakDirection>,
    best: Option<BestSoFar>,
    halvings: usize,
    rounds: usize,
    /// Rounds in a row in which no take was asked elsewhere.
    still: usize,
    /// How far the last step goes, in lengths.
    moved: f64,
    /// Whether it ended near the optimum only.
    is_near_only: bool,
}

/// The best place so far.
#[derive(Clone, Debug)]
struct BestSoFar {
    mean: DVector<f64>,
    asked: Vec<DVector<f64>>,
    objective: f64,
}

impl JointSearch {
    /// A search among takes from what each of them says at its own optimum: from the medians of their own values, each with
    /// the weight of its information. `None`: takes no part until it says something.
    pub fn new(parameters: Vec<JointParameter>, own: &[Option<TakeShare>]) -> Self {
        let JointBegin {
            mean,
            variances,
            asked,
        } = JointBegin::of(&parameters, own);
        Self {
            variances,
            asked,
            taking: own.iter().map(Option::is_some).collect(),
            parameters,
            mean,
            held: None,
            weak: Vec::new(),
            best: None,
            halvings: 0,
            rounds: 0,
            still: 0,
            moved: f64::INFINITY,
            is_near_only: false,
        }
    }

    /// What is asked for.
    pub fn parameters(&self) -> &[JointParameter] {
        &self.parameters
    }

    /// The values at which a take is to be asked, SI.
    pub fn asked(&self, take: usize) -> DVector<f64> {
        self.asked[take].component_mul(&lengths(&self.parameters))
    }

    /// The joint values, SI.
    pub fn values(&self) -> DVector<f64> {
        self.mean.component_mul(&lengths(&self.parameters))
    }

    /// Whether a take takes part.
    pub fn is_taking_part(&self, take: usize) -> bool {
        self.taking[take]
    }

    /// Takes a take in that has a share at values, SI: the joint ones, and its own of what is drawn.
    pub fn take_in(&mut self, take: usize, values: &DVector<f64>) {
        self.taking[take] = true;
        self.asked[take] = values.component_div(&lengths(&self.parameters));
        (self.best, self.halvings, self.rounds) = (None, 0, 0);
    }

    /// Looks what the takes together tell where they are asked, before anything is solved.
    pub fn look(&mut self, shares: &[Option<TakeShare>]) {
        let parts = self.of_means(&self.parts(shares));
        self.hold_weak(&self.total(&parts));
    }

    /// Holds the directions that are not determined.
    fn hold_weak(&mut self, total: &Total) {
        let (held, weak) = weak(&self.parameters, &total.information);
        (self.held, self.weak) = (Some(held), weak);
    }

    /// What is left of parts about the means.
    pub(super) fn of_means(&self, parts: &[PlainPart]) -> Vec<MeanPart> {
        let parts = parts.iter();
        parts.map(|of| of.of_means(&self.variances)).collect()
    }

    /// The sum of parts, with the priors.
    pub(super) fn total(&self, parts: &[MeanPart]) -> Total {
        Total::of(&self.parameters, &self.mean, parts.iter())
    }

    /// Number of rounds so far.
    pub fn rounds(&self) -> usize {
        self.rounds
    }

    /// Whether it ended near the optimum only, and how far its last step went, in lengths.
    pub fn near_only(&self) -> Option<f64> {
        self.is_near_only.then_some(self.moved)
    }

    /// What the takes do not determine.
    pub fn weak(&self) -> &[WeakDirection] {
        &self.weak
    }

    pub(super) fn mean(&self) -> &DVector<f64> {
        &self.mean
    }

    pub(super) fn variances(&self) -> &DVector<f64> {
        &self.variances
    }

    pub(super) fn held(&self) -> DMatrix<f64> {
        let none = || DMatrix::zeros(self.parameters.len(), 0);
        self.held.clone().unwrap_or_else(none)
    }

    /// The takes that take part, with what each says about the joint values.
    pub(super) fn parts(&self, shares: &[Option<TakeShare>]) -> Vec<PlainPart> {
        let taking = shares.iter().zip(&self.taking);
        let taking = taking.filter_map(|(share, taking)| share.as_ref().filter(|_| *taking));
        taking
            .map(|share| PlainPart::new(&self.parameters, share, &self.mean))
            .collect()
    }

    /// Parameters that are at a bound of theirs.
    pub(super) fn bounded(&self) -> Vec<bool> {
        let near = 1e-9;
        let each = self.parameters.iter().zip(&self.mean).map(|(of, mean)| {
            let [lower, upper] = of.bounds();
            mean - lower <= near || upper - mean <= near
        });
        each.collect()
    }
}
