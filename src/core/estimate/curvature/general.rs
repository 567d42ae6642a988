//! The curvature of residuals that have no short form, `Σ_i u_i ∇²r_i` of the views whose residuals are
//! [`SampleObserver`]'s and of the pulls on states: with `u = r`, and `u = V⁻¹ r` where samples err in time.
//!
//! It is the derivative of `Jᵀr` less `JᵀJ`, or of `Jᵀu` with `u` as it is, by central differences of exact derivatives: where
//! nothing but the constraints' curvature tells how a body turns, that of the residuals counts as much.

use nalgebra::{DMatrix, DVector};

use super::nudged::{Nudged, TIME_STEP_S};
use crate::estimate::problem::View;
use crate::estimate::problem::influence::Acting;
use crate::estimate::terms::context::SolveContext;
use crate::estimate::terms::observed::{Observed, SampleObserver};
use crate::estimate::terms::woven;
use crate::estimate::unknowns::point::Point;
use crate::optimise::envelope::Envelope;

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
        Self {
            context,
            arc,
            view,
            own: layout.state(arc).chain(parameters).collect(),
            acting,
            pulls,
        }
    }

    /// Adds what the Hessian lacks; `None` where no body has such moments.
    fn add(&self, nudged: &mut Nudged, matrix: &mut Envelope) -> Option<()> {
        let (layout, point) = (self.context.layout, nudged.origin);
        let here = self.observed(point, 0.0)?;
        let own = self.own.len();
        let slopes = nudged.slopes(&self.own, |point| match self.observed(point, 0.0) {
            Some(there) => self.gradient(&there),
            None => DVector::zeros(own + here.len()),
        });
        let mut lacks = slopes.rows(0, own).into_owned();
        if self.pulls.is_none() {
            for of in &here {
                let columns: Vec<&[f64; 6]> = columns(of).collect();
                lacks -= DMatrix::from_fn(own, own, |i, j| dot(columns[i], columns[j]));
            }
        }
        add_own(self.context, &self.own, &lacks, matrix);

        let [after, before] = [1.0, -1.0].map(|sign| self.observed(point, sign * TIME_STEP_S));
        let (after, before) = (after?, before?);
        // What the Hessian has of a product with a sample's derivative by its time.
        let has = |of: &Observed, column: &[f64; 6]| match self.pulls {
            Some(_) => 0.0,
            None => dot(column, &of.by_time),
        };
        for (index, sample) in self.view.samples.iter().enumerate() {
            let nodes = sample.shares();
            let nodes: Vec<(usize, f64)> = nodes
                .filter_map(|(node, share)| Some((layout.nodes[node]?, share)))
                .collect();
            let of = &here[index];
            let [later, earlier] = [&after[index], &before[index]]
                .map(|then| dot(&then.by_time, self.pull(index, then)));
            let by_time = (later - earlier) / (2.0 * TIME_STEP_S) - has(of, &of.by_time);
            for (at, share) in &nodes {
                let own_slopes = slopes.row(own + index);
                let unknowns = self.own.iter().zip(columns(of));
                for ((other, column), slope) in unknowns.zip(own_slopes.iter()) {
                    let lacks = slope - has(of, column);
                    self.add_entry(*at, *other, share * lacks, matrix);
                }
                for (other, other_share) in nodes.iter().filter(|(other, _)| other <= at) {
                    self.add_entry(*at, *other, share * other_share * by_time, matrix);
                }
            }
        }
        Some(())
    }

    fn add_entry(&self, i: usize, j: usize, value: f64, matrix: &mut Envelope) {
        let pattern = &self.context.layout.structure.pattern;
        matrix.add(pattern, i.max(j), i.min(j), value);
    }

    /// Its samples at a point, with all times later; `None` where no body has such moments.
    fn observed(&self, point: &Point, later_s: f64) -> Option<Vec<Observed>> {
        let problem = self.context.problem;
        let bodies = problem.bodies_at(&point.parameters)?;
        let body = &bodies[problem.arcs[self.arc].mechanism];
        let gravity_m_s2 = problem.gravity(&point.parameters);
        let times_s = point.node_times_s.iter().map(|time_s| time_s + later_s);
        let times_s: Vec<f64> = times_s.collect();
        let mut observer = SampleObserver::new(
            problem,
            (self.arc, self.view),
            (body, &gravity_m_s2),
            (&point.arcs[self.arc], self.context.epochs_s[self.arc]),
            &point.parameters,
        );
        if self.pulls.is_some() {
            observer = observer.in_body_axes(self.acting);
        }
        let samples = 0..self.view.samples.len();
        Some(
            samples
                .map(|index| observer.observed(index, &times_s))
                .collect(),
        )
    }

    /// What a sample pulls with: its residual, or the given `u`.
    fn pull<'o>(&'o self, index: usize, of: &'o Observed) -> &'o [f64; 6] {
        self.pulls.map_or(&of.residual, |pulls| &pulls[index])
    }

    /// `Jᵀu` by its own unknowns, and sample by sample by the time.
    fn gradient(&self, seen: &[Observed]) -> DVector<f64> {
        let mut gradient = vec![0.0; self.own.len()];
        let each = || seen.iter().enumerate();
        for (index, of) in each() {
            for (sum, column) in gradient.iter_mut().zip(columns(of)) {
                *sum += dot(column, self.pull(index, of));
            }
        }
        gradient.extend(each().map(|(index, of)| dot(&of.by_time, self.pull(index, of))));
        DVector::from_vec(gradient)
    }
}

/// Derivatives of a residual by the unknowns of its view.
fn columns(of: &Observed) -> impl Iterator<Item = &[f64; 6]> {
    of.by_state.iter().chain(&of.by_acting)
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
