//! What the samples see of a step of the unknowns: the residuals' derivative along it, bin by bin.

use nalgebra::{DVector, Vector3};

use super::bins::Bins;
use crate::estimate::point::Point;
use crate::estimate::system::Frame;
use crate::physics::flow::Spin;
use crate::physics::state::part;

/// A residual, position then orientation in body axes, in the problem's units; or its change.
pub type Six = [f64; 6];

/// What the samples see of one step.
#[derive(Clone, Debug)]
pub struct Trace {
    /// Sum over the samples of each bin.
    pub sums: Vec<Six>,
    /// Sum of the squares over all samples, of positions and of orientations.
    pub squares: [f64; 2],
}

impl Trace {
    fn zeros(bins: &Bins) -> Self {
        Self {
            sums: vec![[0.0; 6]; bins.count()],
            squares: [0.0; 2],
        }
    }

    fn add(&mut self, bin: usize, change: &Six) {
        for (axis, (sum, change)) in self.sums[bin].iter_mut().zip(change).enumerate() {
            *sum += change;
            self.squares[axis / 3] += change * change;
        }
    }
}

/// What the samples see of each of some steps from `point`; and, last, of their own times all going
/// on by a second. The flow is evaluated once for all of them.
pub fn traces(frame: &Frame, point: &Point, bins: &Bins, steps: &[DVector<f64>]) -> Vec<Trace> {
    let (problem, layout) = (frame.problem, frame.layout);
    let gravity_m_s2 = problem.gravity(&point.parameters);
    let mut traces = vec![Trace::zeros(bins); steps.len() + 1];
    let per_m = problem.position_unit_m.recip();
    let per_rad = problem.orientation_unit_rad.recip();
    let six = |shift: Vector3<f64>, turn: Vector3<f64>| -> Six {
        let (shift, turn) = (shift * per_m, turn * per_rad);
        [shift.x, shift.y, shift.z, turn.x, turn.y, turn.z]
    };
    let pull = |step: &DVector<f64>| {
        let parameters = problem.gravity_parameters;
        let of_axis = |axis: usize| Some(step[layout.parameters[parameters[axis]?]]);
        Vector3::from_fn(|axis, _| of_axis(axis).unwrap_or(0.0))
    };
    let pulls: Vec<Vector3<f64>> = steps.iter().map(pull).collect();
    let mut bin_of_sample = bins.of_samples.iter();
    for (index, arc) in problem.arcs.iter().enumerate() {
        let state = &point.arcs[index];
        let omega = &state.angular_velocity_rad_s;
        let mut spin = Spin::new(&problem.bodies[arc.body], omega);
        let parts: Vec<[Vector3<f64>; 5]> = steps
            .iter()
            .zip(&pulls)
            .map(|(step, pull)| {
                let three = |part: usize| -> Vector3<f64> {
                    step.fixed_rows::<3>(layout.arcs[index] + part).into()
                };
                [
                    three(part::POSITION),
                    three(part::VELOCITY),
                    pull * 0.5,
                    three(part::ORIENTATION),
                    three(part::ANGULAR_VELOCITY),
                ]
            })
            .collect();
        for (sample, bin) in arc.samples.iter().zip(&mut bin_of_sample) {
            let s = sample.time_s(&point.node_times_s) - frame.epochs_s[index];
            let (turn, k) = spin.turn_and_derivative(s);
            let to_body = turn.inverse().to_rotation_matrix();
            let rate = six(state.velocity_m_s + gravity_m_s2 * s, to_body * (k * omega));
            traces[steps.len()].add(*bin, &rate);
            let turn_by_spin = to_body * (k * s);
            let each = steps.iter().zip(&parts).zip(&mut traces);
            for ((step, [x, v, half_pull, r, w]), trace) in each {
                let shift = x + (v + half_pull * s) * s;
                let mut change = six(shift, to_body * r + turn_by_spin * w);
                let moved_s = |node: usize| {
                    let at = layout.nodes.get(node).copied().flatten();
                    at.map_or(0.0, |at| step[at])
                };
                let later_s = (1.0 - sample.share) * moved_s(sample.node)
                    + sample.share * moved_s(sample.node + 1);
                for (change, rate) in change.iter_mut().zip(&rate) {
                    *change += rate * later_s;
                }
                trace.add(*bin, &change);
            }
        }
    }
    traces
}
