//! The objective (paper eq. 1, 6): half the sum of squares of samples, tempo, marks and priors of
//! parameters, with gradient and Gauss–Newton Hessian:
//!
//! ```text
//! f = ½ Σ |r|²,   g = Σ Jᵀ r,   H = Σ JᵀJ
//! ```

use nalgebra::{DVector, Matrix3, Vector3};

use super::context::{Guidance, SolveContext};
use super::levered::StateTerms;
use super::observed::SampleObserver;
use super::samples::{self, ArcTerms, TimeTerms};
use super::tempo;
use crate::estimate::problem::View;
use crate::estimate::unknowns::point::Point;
use crate::optimise::System;
use crate::optimise::envelope::{Envelope, Pattern};
use crate::physics::state::{StateTangent, part};

/// The objective while its terms are being added: value, gradient and Gauss–Newton Hessian.
pub(in crate::estimate) struct Objective<'a> {
    pub(in crate::estimate) context: &'a SolveContext<'a>,
    pub(in crate::estimate) guidance: &'a Guidance,
    pub(in crate::estimate) point: &'a Point,
    pattern: &'a Pattern,
    cost: &'a mut f64,
    pub(in crate::estimate) gradient: &'a mut DVector<f64>,
    hessian: &'a mut Envelope,
}

impl<'a> Objective<'a> {
    /// An objective without terms.
    pub(in crate::estimate) fn new(
        context: &'a SolveContext,
        guidance: &'a Guidance,
        point: &'a Point,
        system: &'a mut System,
    ) -> Self {
        system.cost = 0.0;
        system.gradient.fill(0.0);
        system.hessian.clear();
        Self {
            context,
            guidance,
            point,
            pattern: &context.layout.structure.pattern,
            cost: &mut system.cost,
            gradient: &mut system.gradient,
            hessian: &mut system.hessian,
        }
    }

    /// Adds the residuals of the samples (paper eq. 1).
    pub(in crate::estimate) fn add_samples(&mut self) {
        let (problem, layout) = (self.context.problem, self.context.layout);
        if let Some(weave) = &problem.weave {
            self.add_woven(weave);
            return;
        }
        let gravity = problem.gravity(&self.point.parameters);
        for (number, (index, view)) in problem.views().enumerate() {
            let body = problem.body_of(index);
            let flight = (&self.point.arcs[index], self.context.epochs_s[index]);
            if let Some(Some(sums)) = self.context.sums.get(number) {
                let times_s = &self.point.node_times_s;
                let stride = (view.samples.len() / self.guidance.orientations_per_arc).max(1);
                let sums = (sums, stride);
                let kept = &self.point.kept;
                let omega = &flight.0.angular_velocity_rad_s;
                let spin = &mut kept.spin(body, omega).spin;
                let terms = samples::known_times(view, sums, flight, spin, &gravity, times_s);
                self.add_arc(layout.arcs[index], &terms);
            } else if problem.is_short(index, view) {
                self.add_short(index, view, body, &gravity);
            } else {
                self.add_general(index, view, &gravity);
            }
        }
    }

    /// Adds the residuals of a view in general; infinitely many where no body has such moments.
    fn add_general(&mut self, index: usize, view: &View, gravity_m_s2: &Vector3<f64>) {
        let (problem, layout) = (self.context.problem, self.context.layout);
        let arc = &problem.arcs[index];
        let Some(body) = problem.body_at(index, &self.point.parameters) else {
            *self.cost = f64::INFINITY;
            return;
        };
        let epoch_s = self.context.epochs_s[index];
        let of = (index, view);
        let mut observer =
            SampleObserver::new(problem, of, (&body, gravity_m_s2), epoch_s, self.point);
        let stride = self.guidance.stride(view);
        let samples = (0..view.samples.len()).skip(stride / 2).step_by(stride);
        let weight = view.samples.len() as f64 / samples.len().max(1) as f64;
        let state = layout.state(index);
        let acting = arc.acting.iter().map(|a| layout.parameters[a.parameter]);
        let own: Vec<usize> = state.chain(acting).collect();
        // What all samples have in common is summed before it goes to its places.
        let mut gradient = vec![0.0; own.len()];
        let mut squares = vec![0.0; own.len() * own.len()];
        let dot = |a: &[f64; 6], b: &[f64; 6]| -> f64 {
            a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>() * weight
        };
        let mut memory = Vec::with_capacity(arc.acting.len());
        for index in samples {
            let sample = &view.samples[index];
            let times_s = &self.point.node_times_s;
            let observed = observer.observed_in(index, times_s, std::mem::take(&mut memory));
            let columns = || observed.by_state.iter().chain(&observed.by_acting);
            *self.cost += 0.5 * dot(&observed.residual, &observed.residual);
            for (i, a) in columns().enumerate() {
                gradient[i] += dot(a, &observed.residual);
                let row = &mut squares[i * own.len()..][..=i];
                for (square, b) in row.iter_mut().zip(columns()) {
                    *square += dot(a, b);
                }
            }
            let nodes = sample.shares().filter_map(|(node, share)| {
                let at = layout.nodes[node]?;
                Some((at, observed.by_time.map(|by| by * share)))
            });
            let nodes: Vec<(usize, [f64; 6])> = nodes.collect();
            for (i, (at, a)) in nodes.iter().enumerate() {
                self.gradient[*at] += dot(a, &observed.residual);
                let pairs = own.iter().zip(columns());
                let earlier = nodes.iter().take(i + 1);
                for (other, b) in pairs.chain(earlier.map(|(other, b)| (other, b))) {
                    let (row, column) = (*at.max(other), *at.min(other));
                    self.hessian.add(self.pattern, row, column, dot(a, b));
                }
            }
            memory = observed.by_acting;
        }
        for (i, at) in own.iter().enumerate() {
            self.gradient[*at] += gradient[i];
            for (j, other) in own[..=i].iter().enumerate() {
                let (row, column) = (*at.max(other), *at.min(other));
                let square = squares[i * own.len() + j];
                self.hessian.add(self.pattern, row, column, square);
            }
        }
    }

    /// Adds the terms of a node's time, and of it with the next node's.
    #[inline]
    pub(in crate::estimate) fn add_node(&mut self, arc: usize, node: usize, terms: &TimeTerms) {
        let layout = self.context.layout;
        if let Some(at) = layout.nodes[node] {
            self.add_time(arc, at, terms);
            if terms.with_next != 0.0
                && let Some(next) = layout.nodes[node + 1]
            {
                self.hessian.add(self.pattern, next, at, terms.with_next);
            }
        }
    }

    /// Adds to the cost.
    pub(in crate::estimate) fn add_cost(&mut self, cost: f64) {
        *self.cost += cost;
    }

    /// Adds to the Hessian's entry of two unknowns.
    #[inline]
    pub(in crate::estimate) fn add_pair(&mut self, one: usize, other: usize, value: f64) {
        let (row, column) = (one.max(other), one.min(other));
        self.hessian.add(self.pattern, row, column, value);
    }

    /// Adds terms of a flight by an unknown time.
    #[inline]
    pub(in crate::estimate) fn add_time(&mut self, arc: usize, at: usize, terms: &TimeTerms) {
        let layout = self.context.layout;
        self.gradient[at] += terms.gradient;
        self.hessian.add(self.pattern, at, at, terms.square);
        let state = layout.arcs[arc];
        for (block, cross) in terms.cross[..4].iter().enumerate() {
            for axis in 0..3 {
                self.add_pair(state + 3 * block + axis, at, cross[axis]);
            }
        }
        for axis in 0..3 {
            if let Some(parameter) = self.context.problem.gravity_parameters[axis] {
                let row = layout.parameters[parameter];
                self.add_pair(row, at, terms.cross[4][axis]);
            }
        }
    }

    /// Adds terms of a flight by its state.
    pub(in crate::estimate) fn add_state(&mut self, at: usize, terms: &StateTerms) {
        *self.cost += terms.cost;
        let [x, r, v, w] = [
            part::POSITION,
            part::ORIENTATION,
            part::VELOCITY,
            part::ANGULAR_VELOCITY,
        ]
        .map(|part| at + part);
        for (at, gradient) in [x, r, v, w].into_iter().zip(&terms.gradient) {
            for axis in 0..3 {
                self.gradient[at + axis] += gradient[axis];
            }
        }
        let pattern = self.pattern;
        let mut add = |row: usize, column: usize, block: &Matrix3<f64>| {
            for i in 0..3 {
                for j in (0..3).filter(|j| column + j <= row + i) {
                    self.hessian
                        .add(pattern, row + i, column + j, block[(i, j)]);
                }
            }
        };
        let [place, place_velocity, velocity] = &terms.places;
        add(x, x, place);
        add(v, x, place_velocity);
        add(v, v, velocity);
        let [turn, turn_spin, spin] = &terms.turns;
        add(r, r, turn);
        add(w, r, &turn_spin.transpose());
        add(w, w, spin);
        let [x_turn, v_turn] = &terms.by_turn;
        let [x_spin, v_spin] = &terms.by_spin;
        add(r, x, &x_turn.transpose());
        add(v, r, v_turn);
        add(w, x, &x_spin.transpose());
        add(w, v, &v_spin.transpose());
    }

    #[inline]
    pub(in crate::estimate) fn add_arc(&mut self, at: usize, terms: &ArcTerms) {
        let pattern = self.pattern;
        let [p0, p1, p2, p3, p4] = terms.powers;
        *self.cost += terms.cost + terms.turn.cost;
        let [x, v, r, w] = [
            part::POSITION,
            part::VELOCITY,
            part::ORIENTATION,
            part::ANGULAR_VELOCITY,
        ]
        .map(|part| at + part);
        for axis in 0..3 {
            self.gradient[x + axis] += terms.position_gradient[0][axis];
            self.gradient[v + axis] += terms.position_gradient[1][axis];
            self.gradient[r + axis] += terms.turn.gradient_orientation[axis];
            self.gradient[w + axis] += terms.turn.gradient_spin[axis];
            self.hessian.add(pattern, x + axis, x + axis, p0);
            self.hessian.add(pattern, v + axis, x + axis, p1);
            self.hessian.add(pattern, v + axis, v + axis, p2);
            self.hessian
                .add(pattern, r + axis, r + axis, terms.turn.count);
            for other in 0..3 {
                self.hessian.add(
                    pattern,
                    w + axis,
                    r + other,
                    terms.turn.cross[(other, axis)],
                );
                if other <= axis {
                    let square = terms.turn.square[(axis, other)];
                    self.hessian.add(pattern, w + axis, w + other, square);
                }
            }
            if let Some(parameter) = self.context.problem.gravity_parameters[axis] {
                let g = self.context.layout.parameters[parameter];
                self.gradient[g] += terms.position_gradient[2][axis];
                self.hessian.add(pattern, g, x + axis, 0.5 * p2);
                self.hessian.add(pattern, g, v + axis, 0.5 * p3);
                self.hessian.add(pattern, g, g, 0.25 * p4);
            }
        }
    }

    /// Adds the priors of tempo, marks and parameters, and the guidance.
    pub(in crate::estimate) fn add_priors(&mut self) {
        let (problem, layout) = (self.context.problem, self.context.layout);
        if let Some(sd) = problem.counted_tempo_sd() {
            for first in 0..problem.nodes_acted_s.len().saturating_sub(2) {
                self.add_tempo(first, sd);
            }
        }
        for mark in &problem.marks {
            let term = mark.term(problem, self.point);
            self.add_residual(layout.of_mark(mark), term.residual, term.jacobian);
        }
        for (index, free) in problem.parameters.iter().enumerate() {
            if let Some(sd) = free.prior_sd {
                let offset = self.point.parameters[index] - free.initial;
                self.add_pull(layout.parameters[index], offset, sd);
            }
        }
        if let Some(sd_s) = self.guidance.event_sd_s {
            for (event, at) in layout.events.iter().enumerate() {
                if let Some(at) = *at {
                    let offset =
                        self.point.event_times_s[event] - self.guidance.event_times_s[event];
                    self.add_pull(at, offset, sd_s);
                }
            }
        }
    }

    /// Adds the pulls on states, to others and to rest.
    pub(in crate::estimate) fn add_pulls(&mut self) {
        let (problem, states) = (self.context.problem, &self.point.arcs);
        for pull in problem.pulls.iter().chain(&problem.regulariser) {
            let (residuals, by_state) = pull.term(&states[pull.arc]);
            let at = self.context.layout.arcs[pull.arc];
            *self.cost += 0.5 * residuals.norm_squared();
            let gradient = by_state.tr_mul(&residuals);
            let square = by_state.tr_mul(&by_state);
            for row in 0..gradient.len() {
                self.gradient[at + row] += gradient[row];
                for column in 0..=row {
                    let value = square[(row, column)];
                    self.hessian.add(self.pattern, at + row, at + column, value);
                }
            }
        }
    }

    /// Adds the residuals of held bodies.
    pub(in crate::estimate) fn add_held(&mut self) {
        let (problem, layout) = (self.context.problem, self.context.layout);
        for ((of, at), state) in problem.held.iter().zip(&layout.held).zip(&self.point.held) {
            let term = of.term(problem, self.point, state);
            *self.cost += 0.5 * term.residual.norm_squared();
            let by_state = term.by_state.column_iter().map(|by| by.into_owned());
            let by_state = by_state.enumerate().map(|(entry, by)| (at + entry, by));
            let others = of.others(layout).into_iter().zip(term.by_others);
            let others = others.filter_map(|(unknown, by)| Some((unknown?, by)));
            let columns: Vec<(usize, StateTangent)> = by_state.chain(others).collect();
            for (i, (row, by)) in columns.iter().enumerate() {
                self.gradient[*row] += by.dot(&term.residual);
                for (column, other) in &columns[..=i] {
                    let (row, column) = (*row.max(column), *row.min(column));
                    self.hessian.add(self.pattern, row, column, by.dot(other));
                }
            }
        }
    }

    /// Adds half the square of `offset/sd`, for one unknown.
    fn add_pull(&mut self, at: usize, offset: f64, sd: f64) {
        let weight = 1.0 / (sd * sd);
        *self.cost += 0.5 * weight * offset * offset;
        self.gradient[at] += weight * offset;
        self.hessian.add(self.pattern, at, at, weight);
    }

    fn add_tempo(&mut self, first: usize, sd: f64) {
        let three = |values: &[f64]| [values[first], values[first + 1], values[first + 2]];
        let term = tempo::term(
            &three(&self.point.node_times_s),
            &three(&self.context.problem.nodes_acted_s),
            sd,
        );
        let unknowns = [0, 1, 2].map(|node| self.context.layout.nodes[first + node]);
        self.add_residual(unknowns, term.residual, term.jacobian);
    }

    /// Adds half the square of a residual of three unknowns, some of which may be fixed.
    #[inline]
    fn add_residual(&mut self, unknowns: [Option<usize>; 3], residual: f64, jacobian: [f64; 3]) {
        *self.cost += 0.5 * residual * residual;
        for (i, row) in unknowns.into_iter().enumerate() {
            let Some(row) = row else { continue };
            self.gradient[row] += residual * jacobian[i];
            for (j, column) in unknowns.into_iter().enumerate() {
                if let Some(column) = column.filter(|column| *column <= row) {
                    let value = jacobian[i] * jacobian[j];
                    self.hessian.add(self.pattern, row, column, value);
                }
            }
        }
    }
}
