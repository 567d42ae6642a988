//! The curvature of residuals that have no short form, `Σ_i u_i ∇²r_i` of the views whose residuals are
//! [`SampleObserver`]'s and of the pulls on states: with `u = r`, and `u = V⁻¹ r` where samples err in time.
//!
//! It is the derivative of `Jᵀr` less `JᵀJ`, or of `Jᵀu` with `u` as it is, by central differences of exact derivatives: where
//! nothing but the constraints' curvature tells how a body turns, that of the residuals counts as much.

use nalgebra::{DMatrix, DVector};

use super::nudged::{Nudged, TIME_STEP_S};
use crate::estimate::problem::View;
use crate::estimate::problem::influence::{Acting, drag_is_free, lift_is_free};
use crate::estimate::terms::context::SolveContext;
use crate::estimate::terms::observed::SampleObserver;
use crate::estimate::terms::woven;
use crate::estimate::unknowns::point::Point;
use crate::optimise::envelope::Envelope;
use crate::physics::state::part;

/// Adds it.
pub fn add(nudged: &mut Nudged, matrix: &mut Envelope) {
    let (context, point) = (nudged.context, nudged.origin);
    let problem = context.problem;
    // Where no body has such moments there are none, and no view bends.
    let woven = problem.weave.as_ref();
    let woven = woven.and_then(|weave| woven::pulls(context, point, weave));
    for (number, (arc, view)) in problem.views().enumerate() {
        let pulls = woven.as_ref().map(|pulls| pulls[number].as_slice());
        if !view.is_plain || pulls.is_some() {
            let _ = General::new(context, arc, view, pulls).add(nudged, matrix);
        }
    }
    for pull in problem.pulls.iter().chain(&problem.regulariser) {
        let (_, by_state) = pull.term(&point.arcs[pull.arc]);
        let own: Vec<usize> = context.layout.state(pull.arc).collect();
        let slopes = nudged.slopes(&own, |point| {
            let (residuals, by_state) = pull.term(&point.arcs[pull.arc]);
            by_state.tr_mul(&residuals)
        });
        let lacks = slopes - by_state.tr_mul(&by_state);
        add_own(context, &own, &lacks, matrix);
    }
}

/// A view with the unknowns that its samples depend on, but for their times.
struct General<'a> {
    context: &'a SolveContext<'a>,
    arc: usize,
    view: &'a View,
    own: Vec<usize>,
    /// Parameters that act on it.
    acting: &'a [Acting],
    /// Its samples that count.
    samples: Vec<usize>,
    /// `u`, sample by sample, where it is not the residual.
    pulls: Option<&'a [[f64; 6]]>,
}

impl<'a> General<'a> {
    fn new(
        context: &'a SolveContext<'a>,
        arc: usize,
        view: &'a View,
        pulls: Option<&'a [[f64; 6]]>,
    ) -> Self {
        let (problem, layout) = (context.problem, context.layout);
        let acting = match &problem.weave {
            Some(weave) => weave.acting_on(arc),
            None => &problem.arcs[arc].acting,
        };
        let parameters = acting.iter().map(|of| layout.parameters[of.parameter]);
        let counts = |at: &usize| pulls.is_none_or(|pulls| pulls[*at] != [0.0; 6]);
        Self {
            context,
            arc,
            view,
            own: layout.state(arc).chain(parameters).collect(),
            acting,
            samples: (0..view.samples.len()).filter(counts).collect(),
            pulls,
        }
    }

    /// Adds what the Hessian lacks; `None` where no body has such moments.
    fn add(&self, nudged: &mut Nudged, matrix: &mut Envelope) -> Option<()> {
        let (layout, point) = (self.context.layout, nudged.origin);
        let own = self.own.len();
        let is_straight = |at: &usize| self.is_straight(*at);
        let (straight, bent): (Vec<usize>, Vec<usize>) = (0..own).partition(is_straight);
        let [mut lacks, mut by_time] = self.slopes(nudged, &bent)?;
        let pulls = match self.pulls {
            Some(pulls) => self.samples.iter().map(|at| pulls[*at]).collect(),
            None => self.less_squares(point, &bent, &mut lacks, &mut by_time)?,
        };
        // Of what is straight only the time bends: `∂²r/∂t ∂v = 1`.
        for (at, pull) in pulls.iter().enumerate().filter(|_| !straight.is_empty()) {
            for axis in 0..3 {
                lacks[(own + at, part::VELOCITY + axis)] = pull[axis] / self.view.units[0];
            }
        }
        for i in &bent {
            for j in &straight {
                lacks[(*i, *j)] = lacks[(*j, *i)];
            }
        }
        add_own(self.context, &self.own, &lacks, matrix);
        for (at, index) in self.samples.iter().enumerate() {
            let nodes = self.view.samples[*index].shares();
            let nodes = nodes.filter_map(|(node, share)| Some((layout.nodes[node]?, share)));
            for (node, share) in nodes.clone() {
                for (other, lacks) in self.own.iter().zip(&lacks.row(own + at)) {
                    self.add_entry(node, *other, share * lacks, matrix);
                }
                for (other, other_share) in nodes.clone().filter(|(other, _)| *other <= node) {
                    self.add_entry(node, other, share * other_share * by_time[at], matrix);
                }
            }
        }
        Some(())
    }

    /// Takes `JᵀJ` away; returns the residuals.
    fn less_squares(
        &self,
        point: &Point,
        bent: &[usize],
        lacks: &mut DMatrix<f64>,
        by_time: &mut DMatrix<f64>,
    ) -> Option<Vec<[f64; 6]>> {
        let own = self.own.len();
        let mut observer = self.observer(point)?;
        let each = self.samples.iter().enumerate().map(|(at, index)| {
            let of = observer.observed(*index, &point.node_times_s);
            let columns: Vec<&[f64; 6]> = of.by_state.iter().chain(&of.by_acting).collect();
            for j in bent {
                for (i, row) in columns.iter().enumerate() {
                    lacks[(i, *j)] -= dot(row, columns[*j]);
                }
                lacks[(own + at, *j)] -= dot(columns[*j], &of.by_time);
            }
            by_time[at] -= dot(&of.by_time, &of.by_time);
            of.residual
        });
        Some(each.collect())
    }

    /// Derivatives of the gradient by its own unknowns that bend, and by the times of samples.
    fn slopes(&self, nudged: &mut Nudged, bent: &[usize]) -> Option<[DMatrix<f64>; 2]> {
        let (own, count) = (self.own.len(), self.samples.len());
        let unknowns: Vec<usize> = bent.iter().map(|at| self.own[*at]).collect();
        let none = || DVector::zeros(own + count);
        let of_bent = nudged.slopes(&unknowns, |point| {
            self.gradient(point, 0.0).unwrap_or_else(none)
        });
        let mut slopes = DMatrix::zeros(own + count, own);
        for (at, column) in bent.iter().zip(of_bent.column_iter()) {
            slopes.set_column(*at, &column);
        }
        let mut by_time = DMatrix::zeros(count, 1);
        if self.context.problem.times_are_unknown() {
            let sides = [1.0, -1.0].map(|sign| self.gradient(nudged.origin, sign * TIME_STEP_S));
            let [after, before] = sides;
            let change = (after? - before?) / (2.0 * TIME_STEP_S);
            by_time.copy_from(&change.rows(own, count));
        }
        Some([slopes, by_time])
    }

    /// Whether what is seen follows one of its own unknowns as in a fall without drag or lift: place and velocity, of which
    /// no other bends it.
    fn is_straight(&self, at: usize) -> bool {
        let of = [part::POSITION, part::VELOCITY].map(|part| part..part + 3);
        let has_drag = drag_is_free(self.acting) || lift_is_free(self.acting);
        let body = self.context.problem.body_of(self.arc);
        let falls = body.is_ballistic() && !has_drag && self.view.whitenings.is_empty();
        falls && of.iter().any(|of| of.contains(&at))
    }

    fn add_entry(&self, i: usize, j: usize, value: f64, matrix: &mut Envelope) {
        let pattern = &self.context.layout.structure.pattern;
        matrix.add(pattern, i.max(j), i.min(j), value);
    }

    /// The flight at a point; `None` where no body has such moments.
    fn observer<'p>(&'p self, point: &'p Point) -> Option<SampleObserver<'p>> {
        let problem = self.context.problem;
        let body = problem.body_at(self.arc, &point.parameters)?;
        let gravity_m_s2 = problem.gravity(&point.parameters);
        let epoch_s = self.context.epochs_s[self.arc];
        let seen = (self.arc, self.view);
        Some(SampleObserver::new(
            problem,
            seen,
            (&body, &gravity_m_s2),
            epoch_s,
            point,
        ))
    }

    /// `Jᵀu` by its own unknowns, and sample by sample by the time, with all times later; `None` where no body has such
    /// moments.
    fn gradient(&self, point: &Point, later_s: f64) -> Option<DVector<f64>> {
        let own = self.own.len();
        let mut gradient = DVector::zeros(own + self.samples.len());
        let times_s = point.node_times_s.iter().map(|time_s| time_s + later_s);
        let times_s: Vec<f64> = times_s.collect();
        let mut observer = self.observer(point)?;
        if self.pulls.is_some() {
            observer = observer.in_body_axes(self.acting);
        }
        let mut memory = Vec::new();
        for (at, index) in self.samples.iter().enumerate() {
            let pull = self.pulls.map(|pulls| &pulls[*index]);
            let of = observer.pulled_in(*index, &times_s, memory, pull);
            let columns = of.by_state.iter().chain(&of.by_acting);
            for (sum, column) in gradient.iter_mut().zip(columns) {
                *sum += column;
            }
            gradient[own + at] = of.by_time;
            memory = of.by_acting;
        }
        Some(gradient)
    }
}

fn dot(a: &[f64; 6], b: &[f64; 6]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Adds the symmetric part of a matrix over some unknowns.
fn add_own(context: &SolveContext, own: &[usize], lacks: &DMatrix<f64>, matrix: &mut Envelope) {
    for (i, at) in own.iter().enumerate() {
        for (j, other) in own[..=i].iter().enumerate() {
            let value = 0.5 * (lacks[(i, j)] + lacks[(j, i)]);
            let (row, column) = (*at.max(other), *at.min(other));
            matrix.add(&context.layout.structure.pattern, row, column, value);
        }
    }
}
