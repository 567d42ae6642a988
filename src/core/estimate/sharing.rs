//! A motion that is asked what it says of quantities which several takes share: at values from outside, all else of the take
//! at its own optimum.

use nalgebra::{DMatrix, DVector};

use crate::motion::{Cone, FreeParameter, Observer, TakeShare};
use crate::optimise::reduced::Reduced;

/// A solved motion of which some parameters are held at values that are given from outside.
pub trait Holdable: Clone {
    /// What is free in it.
    fn parameters(&self) -> &[FreeParameter];

    /// The same, to be held.
    fn parameters_mut(&mut self) -> &mut [FreeParameter];

    /// Where it is: the values of what is free.
    fn values(&self) -> &[f64];

    /// The optimum from a step away, or from where it is, on, with some parameters at their bounds, which are one value; `None`
    /// where none is found.
    fn solved(
        self,
        step: Option<&DVector<f64>>,
        held: &[usize],
        observer: &mut dyn Observer,
    ) -> Option<Self>;

    /// How the optimum, which is brought to rounding first, follows the rows that hold these parameters; `None` where its system
    /// cannot be factorised.
    fn reduced(&mut self, held: &[usize]) -> Option<Reduced>;

    /// `f`: half the sum of squared residuals, with priors.
    fn cost(&self) -> f64;

    /// Root mean square residuals per axis of positions \[m\] and orientations \[rad\], and how many samples show each.
    fn residual(&self) -> ([f64; 2], [usize; 2]);
}

/// A motion with parameters that are given from outside. Flights, contacts, and the errors of samples are those with
/// which it was found.
#[derive(Clone, Debug)]
pub struct SharedMotion<M> {
    motion: M,
    /// The given parameters, among all that are free.
    parameters: Vec<usize>,
    /// How all unknowns follow each of them, once that was told.
    responses: Vec<DVector<f64>>,
}

impl<M: Holdable> SharedMotion<M> {
    /// Of a motion without what is [left](leave) to whoever gives these parameters.
    pub(super) fn new(motion: M, parameters: &[usize]) -> Self {
        Self {
            motion,
            parameters: parameters.to_vec(),
            responses: Vec::new(),
        }
    }

    /// The values at which it is.
    pub fn values(&self) -> DVector<f64> {
        let values = self.motion.values();
        let of = self.parameters.iter().map(|parameter| values[*parameter]);
        DVector::from_iterator(self.parameters.len(), of)
    }

    /// What the take says at other values; `None` where it has no motion there. It stays where it was then.
    pub fn at(&mut self, values: &DVector<f64>, observer: &mut dyn Observer) -> Option<TakeShare> {
        let change = values - self.values();
        let mut there = self.motion.clone();
        let free = there.parameters_mut();
        for (parameter, value) in self.parameters.iter().zip(values.iter()) {
            (free[*parameter].lower, free[*parameter].upper) = (*value, *value);
        }
        let step = (change.amax() > 0.0).then(|| self.step(&change)).flatten();
        let mut found = there.solved(step.as_ref(), &self.parameters, observer)?;
        let reduced = found.reduced(&self.parameters)?;
        self.motion = found;
        let share = self.share(&reduced, values);
        self.responses = reduced.responses;
        Some(share)
    }

    /// The step of all unknowns that follows a change of the values; none before it was told how they follow.
    fn step(&self, change: &DVector<f64>) -> Option<DVector<f64>> {
        let units = self.units();
        let parts = self.responses.iter().zip(change.iter().zip(&units));
        let parts = parts.map(|(response, (change, unit))| response * (change / unit));
        parts.reduce(|sum, part| sum + part)
    }

    /// The share, from the derivatives by the rows that hold the parameters, whose units are other than the parameters'.
    fn share(&self, reduced: &Reduced, values: &DVector<f64>) -> TakeShare {
        let units = self.units();
        let count = units.len();
        let curvature = &reduced.curvature;
        let (residual, samples) = self.motion.residual();
        TakeShare {
            values: values.clone(),
            cost: self.motion.cost(),
            gradient: reduced.gradient.component_div(&units),
            curvature: DMatrix::from_fn(count, count, |a, b| {
                curvature[(a, b)] / (units[a] * units[b])
            }),
            residual,
            samples,
        }
    }

    /// One unit of the row that holds each parameter.
    fn units(&self) -> DVector<f64> {
        let free = self.motion.parameters();
        let of = self.parameters.iter();
        let units = of.map(|parameter| free[*parameter].length());
        DVector::from_iterator(self.parameters.len(), units)
    }
}

/// Root mean square, per axis, of squares of residuals by kinds.
pub(super) fn rms(squares: [f64; 2], samples: [usize; 2]) -> [f64; 2] {
    [0, 1].map(|kind| (squares[kind] / (3 * samples[kind].max(1)) as f64).sqrt())
}

/// Leaves priors and cones of parameters to whoever gives their values.
pub(super) fn leave(free: &mut [FreeParameter], cones: &mut Vec<Cone>, parameters: &[usize]) {
    for parameter in parameters {
        free[*parameter].prior_sd = None;
    }
    cones.retain(|cone| !cone.parameters.iter().any(|of| parameters.contains(of)));
}

/// Puts a point's parameters where bounds of one value hold them.
pub(super) fn put(values: &mut [f64], free: &[FreeParameter], held: &[usize]) {
    for parameter in held {
        values[*parameter] = free[*parameter].lower;
    }
}
