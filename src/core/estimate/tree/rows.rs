//! Rows of goals of trees, of its events, and of how an interval of their motion joins the next.

use nalgebra::{DMatrix, Matrix3xX, Vector3};

use super::goal::TreeGoal;
use super::problem::TreeProblem;
use super::time_line::TimeLine;
use crate::estimate::constraint::within::WithinRow;
use crate::estimate::problem::unit;
use crate::optimise::block::{Block, BlockPattern};
use crate::physics::tree::{TreeImpact, TreeImpactDerivative, TreeState};

impl TreeGoal {
    /// Its rows at a value of its quantity.
    pub(super) fn rows(&self, value: &Vector3<f64>) -> Vec<WithinRow> {
        self.rows.at(&self.condition.set, value)
    }
}

/// A goal's row, `by` the unknowns of the interval.
pub(super) fn put(
    goal: &TreeGoal,
    row: usize,
    of: &WithinRow,
    by: &Matrix3xX<f64>,
    pattern: &BlockPattern,
    block: &mut Block,
) {
    let unit = goal.unit();
    block.values[row] = of.value / unit;
    block.bounds[row] = (of.bounds.0 / unit, of.bounds.1 / unit);
    let chained = by.tr_mul(&of.by) / unit;
    let entries = block.derivatives_mut(pattern, row);
    entries.copy_from_slice(chained.as_slice());
}

/// What does not count yet: it holds, whatever moves.
pub(super) fn silence(pattern: &BlockPattern, block: &mut Block) {
    block.reset(pattern);
    block.values.fill(0.0);
    for row in 0..block.values.len() {
        block.derivatives_mut(pattern, row).fill(0.0);
    }
}

/// Approach of an impact's contacts, and their gaps where those have rows: they come nearer, and touch. Its time is that of one
/// of the interval's events.
pub(super) fn touch(
    impact: &TreeImpact,
    derivative: &TreeImpactDerivative,
    count: usize,
    event: usize,
    jacobian: &DMatrix<f64>,
    pattern: &BlockPattern,
    block: &mut Block,
) {
    let speeds = impact.speeds_m_s.iter().zip(&derivative.speeds);
    let speeds = speeds.map(|(value, by)| (value, by, unit::VELOCITY_M_S));
    let gaps = impact.gaps_m.iter().zip(&derivative.gaps);
    let gaps = gaps.map(|(value, by)| (value, by, unit::POSITION_M));
    block.bounds[..speeds.len()].fill((f64::NEG_INFINITY, 0.0));
    let carried = derivative.carried.iter();
    let carried: Vec<f64> = carried
        .flat_map(|of| of.speeds.iter().chain(&of.gaps).copied())
        .collect();
    for (row, (value, by, unit)) in speeds.chain(gaps).enumerate().take(count) {
        block.values[row] = value / unit;
        let mut chained = jacobian.tr_mul(by) / unit;
        if let Some(carried) = carried.get(row) {
            chained[jacobian.nrows() + event] += carried / unit;
        }
        let entries = block.derivatives_mut(pattern, row);
        entries.copy_from_slice(chained.as_slice());
    }
}

/// Unknowns that the rows of an event's order and of its window are about.
pub(super) fn order_unknowns(problem: &TreeProblem, event: usize) -> Vec<Vec<usize>> {
    let time = |event: usize| problem.unknown_of_event(event);
    let after = event.checked_sub(1).into_iter().chain([event]).map(time);
    let mut rows = vec![after.collect()];
    let paces = (0..problem.pace_count()).map(|piece| problem.unknown_of_pace(piece));
    let with_paces: Vec<usize> = [time(event)].into_iter().chain(paces).collect();
    if event + 1 == problem.events.len() {
        rows.push(with_paces.clone());
    }
    if problem.events[event].window_s.is_some() {
        rows.push(with_paces);
    }
    rows
}

/// Order of events: each is after the one before it, the last before the end; and the window of its acted time, if it has
/// one. These rows end the event's block.
pub(super) fn order(
    problem: &TreeProblem,
    event: usize,
    line: &TimeLine,
    times_s: &[f64],
    pattern: &BlockPattern,
    block: &mut Block,
) {
    let here_s = times_s[event];
    let mut row = problem.events[event].touch_row_count();
    let later = [0.0, f64::INFINITY];
    let mut put = |value_s: f64, bounds_s: [f64; 2], by: &[f64]| {
        block.values[row] = value_s / unit::TIME_S;
        let [lower, upper] = bounds_s.map(|bound_s| bound_s / unit::TIME_S);
        block.bounds[row] = (lower, upper);
        let entries = block.derivatives_mut(pattern, row);
        // Paces later than an event do not move it.
        entries.fill(0.0);
        for (entry, by) in entries.iter_mut().zip(by) {
            *entry = by / unit::TIME_S;
        }
        row += 1;
    };
    let [from_s, to_s] = line.physical_span_s();
    match event.checked_sub(1) {
        Some(before) => put(here_s - times_s[before], later, &[-1.0, 1.0]),
        None => put(here_s - from_s, later, &[1.0]),
    }
    if event + 1 == times_s.len() {
        let by_paces = line.by_log_paces(problem.span_s[1]);
        let by: Vec<f64> = [-1.0].into_iter().chain(by_paces).collect();
        put(to_s - here_s, later, &by);
    }
    if let Some([earliest_s, latest_s]) = problem.events[event].window_s {
        let (acted_s, by) = line.acted_by(problem, event, here_s);
        let by: Vec<f64> = by.into_iter().map(|(_, by)| by).collect();
        put(acted_s - earliest_s, [0.0, latest_s - earliest_s], &by);
    }
}

/// `x(t) ⊟ x_next`, with its derivatives by the interval's unknowns and by the next node.
pub(super) fn join(
    problem: &TreeProblem,
    reached: &TreeState,
    next: &TreeState,
    jacobian: &DMatrix<f64>,
    pattern: &BlockPattern,
    block: &mut Block,
) {
    let (forest, width) = (&problem.forest, problem.width());
    let off = forest.minus(reached, next);
    let turned = forest.minus_jacobians(reached, next);
    for row in 0..width {
        let unit = problem.unit_of(row);
        block.values[row] = off[row] / unit;
        let entries = block.derivatives_mut(pattern, row);
        let (before, after) = entries.split_at_mut(jacobian.ncols());
        let along = turned[0].row(row).transpose();
        for (column, entry) in before.iter_mut().enumerate() {
            *entry = along.dot(&jacobian.column(column)) / unit;
        }
        for (column, entry) in after.iter_mut().enumerate() {
            *entry = turned[1][(row, column)] / unit;
        }
    }
}
