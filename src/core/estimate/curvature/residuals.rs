//! The curvature of the residuals of samples and marks, `Σ_i r_i ∇²r_i`.
//!
//! With a sample's time `t` an unknown, position residual `r` and orientation residual
//! `e = Log(R_iᵀ R(t))` in units, the derivative of its cost by the time is `r·v + e·ω` (for
//! `eᵀ J_r⁻¹(e) = eᵀ`), and with what `objective` has of it already,
//!
//! ```text
//! by time and time         r·v̇ + e·ω̇ + ωᵀ(J_r⁻¹(e) − 1) ω
//! by time and velocity     r
//! by time and orientation  ωᵀ(J_r⁻¹(e) − 1) ∂R/∂R₀
//! by time and spin         ωᵀ(J_r⁻¹(e) − 1) ∂R/∂ω₀ + eᵀ ∂ω/∂ω₀
//! ```
//!
//! Near an apex, where `v` is small, `r·v̇` is the larger part of the curvature by the time.
//!
//! Nodes move by `e^{asinh(δ/d)} = 1 + δ/d + δ²/2d² + …` of their intervals `d`
//! ([`Point::retract_from`]): an interval adds the derivative of the Lagrangian by all later times,
//! over `d`. The tempo's residuals are linear along that motion and have no curvature.

use nalgebra::{DVector, Matrix3, SMatrix, SVector, Vector3};

use crate::estimate::problem::{ArcSample, View};
use crate::estimate::reach::arc_end::ArcEnd;
use crate::estimate::terms::context::SolveContext;
use crate::estimate::terms::tempo;
use crate::estimate::unknowns::point::Point;
use crate::math::so3;
use crate::optimise::System;
use crate::optimise::envelope::{Envelope, Pattern};
use crate::physics::flow::Turns;
use crate::physics::observe::TurnTerms;
use crate::physics::state::part;
use crate::physics::{Body, State};

/// Steps of the differences by orientation \[rad\] and angular velocity [rad/s].
const STEPS: [f64; 2] = [1e-5, 5e-5];

/// Adds it, with `multipliers` of the constraints, row by row.
pub fn add(
    context: &SolveContext,
    system: &System,
    point: &Point,
    multipliers: &[f64],
    matrix: &mut Envelope,
) {
    let (problem, layout) = (context.problem, context.layout);
    let mut sum = Sum {
        pattern: &layout.structure.pattern,
        matrix,
    };
    for (index, view) in problem.views() {
        // The short form of the residuals is meant; that of others is in `general`.
        if !view.is_plain || problem.weave.is_some() {
            continue;
        }
        let body = problem.body_of(index);
        let flight = FlightTerms {
            context,
            point,
            arc: index,
            view,
            body,
        };
        if view.units[1].is_finite() {
            flight.add_turn(&mut sum);
        }
        if problem.times_are_unknown() {
            point.kept.with_turns(body, &point.arcs[index], |turns| {
                for sample in &view.samples {
                    flight.add_time(sample, turns, &mut sum);
                }
            });
        }
    }
    if problem.times_are_unknown() {
        add_marks(context, point, &mut sum);
        add_intervals(context, system, point, multipliers, &mut sum);
    }
}

/// The matrix that is added to.
struct Sum<'a> {
    pattern: &'a Pattern,
    matrix: &'a mut Envelope,
}

impl Sum<'_> {
    /// Adds an entry and its mirror.
    fn add(&mut self, i: usize, j: usize, value: f64) {
        self.matrix.add(self.pattern, i.max(j), i.min(j), value);
    }
}

/// An arc at a point, as a view sees it.
struct FlightTerms<'a> {
    context: &'a SolveContext<'a>,
    point: &'a Point,
    arc: usize,
    view: &'a View,
    body: &'a Body,
}

impl FlightTerms<'_> {
    fn time_s(&self, sample: &ArcSample) -> f64 {
        sample.time_s(&self.point.node_times_s)
    }

    /// Weight of a squared radian.
    fn turn_weight(&self) -> f64 {
        self.view.units[1].powi(-2)
    }

    /// Adds the curvature by orientation and angular velocity, with all times fixed.
    fn add_turn(&self, sum: &mut Sum) {
        let at = &self.point.arcs[self.arc];
        let here = self.turn_terms(at);
        let gauss_newton = |i: usize, j: usize| match (i / 3, j / 3) {
            (0, 0) => f64::from(u8::from(i == j)) * here.count,
            (0, _) => here.cross[(i, j - 3)],
            (_, 0) => here.cross[(j, i - 3)],
            _ => here.square[(i - 3, j - 3)],
        };
        let mut slope = SMatrix::<f64, 6, 6>::zeros();
        for k in 0..6 {
            let step = STEPS[k / 3];
            let gradient = |by: f64| self.turn_gradient(&nudged(at, k, by));
            slope.set_column(k, &((gradient(step) - gradient(-step)) / (2.0 * step)));
        }
        let first = self.context.layout.arcs[self.arc];
        let [r, w] = [part::ORIENTATION, part::ANGULAR_VELOCITY].map(|part| first + part);
        let unknown = |k: usize| if k < 3 { r + k } else { w + k - 3 };
        for i in 0..6 {
            for j in 0..=i {
                let exact = 0.5 * (slope[(i, j)] + slope[(j, i)]);
                sum.add(unknown(i), unknown(j), exact - gauss_newton(i, j));
            }
        }
    }

    fn turn_terms(&self, state: &State) -> TurnTerms {
        let epoch_s = self.context.epochs_s[self.arc];
        let readings = self.view.samples.iter();
        let readings = readings.map(|s| (self.time_s(s) - epoch_s, &s.orientation));
        let (kept, omega) = (&self.point.kept, &state.angular_velocity_rad_s);
        let spin = &mut kept.spin(self.body, omega).spin;
        let terms = TurnTerms::of(spin, &state.orientation, readings);
        terms.weighed(self.turn_weight())
    }

    fn turn_gradient(&self, state: &State) -> SVector<f64, 6> {
        let terms = self.turn_terms(state);
        let (r, w) = (terms.gradient_orientation, terms.gradient_spin);
        SVector::from_iterator(r.iter().chain(w.iter()).copied())
    }

    /// Adds the curvature by the time of a sample and whatever else it depends on.
    fn add_time(&self, sample: &ArcSample, turns: &mut Turns, sum: &mut Sum) {
        let (problem, layout) = (self.context.problem, self.context.layout);
        let gravity = problem.gravity(&self.point.parameters);
        let duration_s = self.time_s(sample) - self.context.epochs_s[self.arc];
        let then = ArcEnd::after(turns, &gravity, &self.point.arcs[self.arc], duration_s);
        let pull = (then.state.position_m - sample.position_m) * self.view.units[0].powi(-2);
        let error = so3::log(&(sample.orientation.inverse() * then.state.orientation));
        let weight = self.turn_weight();
        let omega = then.state.angular_velocity_rad_s * weight;
        let beyond = (so3::right_jacobian_inverse(&error) - Matrix3::identity()).tr_mul(&omega);
        let spinning: Vector3<f64> = then.rate.fixed_rows::<3>(part::ANGULAR_VELOCITY).into();
        let speeding: Vector3<f64> = then.rate.fixed_rows::<3>(part::VELOCITY).into();
        let by_time = pull.dot(&speeding)
            + weight * error.dot(&spinning)
            + beyond.dot(&then.state.angular_velocity_rad_s);
        let by_spin = then.turn_by_spin.tr_mul(&beyond) + then.spin_by_spin.tr_mul(&error) * weight;
        let by_state = [
            (part::VELOCITY, pull),
            (part::ORIENTATION, then.by_orientation.tr_mul(&beyond)),
            (part::ANGULAR_VELOCITY, by_spin),
        ];
        let first = layout.arcs[self.arc];
        let nodes = sample.shares();
        let nodes = nodes.filter_map(|(node, share)| Some((layout.nodes[node]?, share)));
        for (at, share) in nodes.clone() {
            for (part, cross) in &by_state {
                for axis in 0..3 {
                    sum.add(first + part + axis, at, share * cross[axis]);
                }
            }
            for axis in problem.free_gravity() {
                let parameter = problem.gravity_parameters[axis].expect("it is free");
                let value = share * pull[axis] * then.duration_s;
                sum.add(layout.parameters[parameter], at, value);
            }
            for (other, other_share) in nodes.clone().filter(|(other, _)| *other <= at) {
                sum.add(at, other, share * other_share * by_time);
            }
        }
    }
}

/// A state with one of its rotational unknowns displaced.
fn nudged(state: &State, unknown: usize, by: f64) -> State {
    let mut step = Vector3::zeros();
    step[unknown % 3] = by;
    let mut nudged = *state;
    if unknown < 3 {
        nudged.orientation *= so3::exp(&step);
    } else {
        nudged.angular_velocity_rad_s += step;
    }
    nudged
}

/// Adds the curvature of marks ([`crate::estimate::problem::EventMark::term`]): with the share `s` of the interval `Δ` between
/// the nodes at which the event lies, and the slope `m` of acted time there,
///
/// ```text
/// r/σ · m/Δ · [0, 1, −1; ·, 2(s − 1), 1 − 2s; ·, ·, 2s]      by the event, both nodes
/// ```
fn add_marks(context: &SolveContext, point: &Point, sum: &mut Sum) {
    let problem = context.problem;
    for mark in &problem.marks {
        let Some(nodes) = mark.nodes else { continue };
        let [from_s, to_s] = nodes.map(|node| point.node_times_s[node]);
        let term = mark.term(problem, point);
        let share = (point.event_times_s[mark.event] - from_s) / (to_s - from_s);
        let scale = term.residual * term.jacobian[0] / (to_s - from_s);
        let second = [
            [0.0, 1.0, -1.0],
            [1.0, 2.0 * (share - 1.0), 1.0 - 2.0 * share],
            [-1.0, 1.0 - 2.0 * share, 2.0 * share],
        ];
        let unknowns = context.layout.of_mark(mark);
        for (i, row) in unknowns.into_iter().enumerate() {
            for (j, column) in unknowns.into_iter().enumerate().take(i + 1) {
                if let (Some(row), Some(column)) = (row, column) {
                    sum.add(row, column, scale * second[i][j]);
                }
            }
        }
    }
}

/// Adds the curvature of the nodes' motion along a step.
fn add_intervals(
    context: &SolveContext,
    system: &System,
    point: &Point,
    multipliers: &[f64],
    sum: &mut Sum,
) {
    let nodes = &context.layout.nodes;
    let slopes = slopes_without_tempo(context, system, point, multipliers);
    let mut later = 0.0;
    for node in (1..nodes.len()).rev() {
        let slope = |at: Option<usize>| at.map_or(0.0, |at| slopes[at]);
        later += slope(nodes[node]);
        let value = later / (point.node_times_s[node] - point.node_times_s[node - 1]);
        if let Some(at) = nodes[node] {
            sum.add(at, at, value);
            if let Some(before) = nodes[node - 1] {
                sum.add(at, before, -value);
            }
        }
        if let Some(before) = nodes[node - 1] {
            sum.add(before, before, value);
        }
    }
}

/// The Lagrangian's gradient without the tempo prior's part.
fn slopes_without_tempo(
    context: &SolveContext,
    system: &System,
    point: &Point,
    multipliers: &[f64],
) -> DVector<f64> {
    let problem = context.problem;
    let mut slopes = system.gradient.clone();
    system.add_pull(
        &context.layout.structure,
        |row| multipliers[row],
        &mut slopes,
    );
    let windows = point.node_times_s.windows(3);
    let windows = windows.zip(problem.nodes_acted_s.windows(3));
    for (first, (times_s, acted_s)) in windows.enumerate() {
        let three = |of: &[f64]| [of[0], of[1], of[2]];
        let sd = problem.counted_tempo_sd().expect("times are unknown");
        let term = tempo::term(&three(times_s), &three(acted_s), sd);
        for (node, by) in term.jacobian.into_iter().enumerate() {
            if let Some(at) = context.layout.nodes[first + node] {
                slopes[at] -= term.residual * by;
            }
        }
    }
    slopes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::curvature::general;
    use crate::estimate::curvature::nudged::Nudged;
    use crate::estimate::terms::context::Guidance;
    use crate::estimate::tests::each_case;
    use crate::estimate::tests::woven::each_woven;
    use crate::optimise::Program;

    /// With the objective's own Hessian, against its second differences along the retraction.
    #[test]
    fn it_is_what_the_hessian_of_the_objective_lacks() {
        each_case(1.0, |context, _, point, _| check(context, point));
    }

    #[test]
    fn it_is_so_where_samples_err_in_time() {
        each_woven(|context, point, _| check(context, point));
    }

    fn check(context: &SolveContext, point: &Point) {
        {
            // The price of velocity gaps has its curvature elsewhere.
            if context.problem.velocity_gap_weight.is_some() {
                return;
            }
            let mut problem = context.problem.clone();
            // A tempo so weak that differences show the rest.
            problem.tempo_sd_per_sqrt_s = problem.tempo_sd_per_sqrt_s.map(|_| 50.0);
            let context = SolveContext {
                problem: &problem,
                ..context.clone()
            };
            // Held bodies make do with them too, which lack nothing where no residual is left.
            let mut point = point.clone();
            problem.hold(&mut point, None);
            let point = &point;
            let size = context.layout.size();
            let guidance = Guidance::none();
            let system = context.evaluated(&guidance, point);
            let pattern = &context.layout.structure.pattern;
            let mut matrix = system.hessian.clone();
            let pulls = vec![0.0; system.row_count()];
            add(&context, &system, point, &pulls, &mut matrix);
            general::add(&mut Nudged::new(&context, point), &mut matrix);
            let damping = context.damping();
            let cost = |delta: &DVector<f64>| {
                let mut there = point.clone();
                context.retract(point, delta, &mut there);
                context.evaluated(&guidance, &there).cost
            };
            for i in (0..size).step_by(2) {
                for j in (0..=i).step_by(3) {
                    let steps = [i, j].map(|k| 3e-3 / damping[k].sqrt());
                    let value = |signs: [f64; 2]| {
                        let mut delta = DVector::zeros(size);
                        delta[i] += signs[0] * steps[0];
                        delta[j] += signs[1] * steps[1];
                        cost(&delta)
                    };
                    let second = value([1.0, 1.0]) - value([1.0, -1.0]) - value([-1.0, 1.0])
                        + value([-1.0, -1.0]);
                    let expected = second / (4.0 * steps[0] * steps[1]);
                    let got = matrix.get(pattern, i, j);
                    let scale = (damping[i] * damping[j]).sqrt();
                    assert!(
                        (got - expected).abs() < 1e-2 * (scale + expected.abs()),
                        "{i} {j}: {got} {expected} scale {scale}"
                    );
                }
            }
        }
    }
}
