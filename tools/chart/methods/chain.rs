//! Derivatives of what follows by what is held.

use enact::estimate::constraint::Block;
use enact::estimate::layout::STATE;
use enact::estimate::problem::Collision;
use enact::estimate::system::{Frame, System};
use enact::math::envelope::{Envelope, Pattern};
use nalgebra::{DMatrix, DVector};

use super::columns::{Columns, GAP, Part, gravity, of_collision};
use super::split::{Grid, Split};

/// Derivatives of every piece's state and every event's time by the unknowns that
/// [`Columns::of_part`] names; `None` where they are those unknowns.
pub struct Chains<'a> {
    split: &'a Split,
    columns: &'a Columns,
    pieces: Vec<Option<DMatrix<f64>>>,
    events: Vec<Option<DMatrix<f64>>>,
}

/// Some rows of a block, by all of its lifted columns.
pub fn rows_of(block: &Block, rows: &[usize]) -> DMatrix<f64> {
    let count = block.values.len();
    let columns = block.jacobian.len().checked_div(count).unwrap_or(0);
    DMatrix::from_fn(rows.len(), columns, |row, column| {
        block.jacobian[column * count + rows[row]]
    })
}

/// Some rows of a lifted block with other derivatives.
pub fn fill_block(lifted: &Block, rows: &[usize], by: &DMatrix<f64>, out: &mut Block) {
    out.values.clear();
    out.values
        .extend(rows.iter().map(|row| lifted.values[*row]));
    out.bounds.clear();
    out.bounds
        .extend(rows.iter().map(|row| lifted.bounds[*row]));
    out.jacobian.clear();
    out.jacobian.extend_from_slice(by.as_slice());
    out.approach = 0..0;
    out.curvature = 0.0;
}

/// Where columns are among others; both in order.
fn places(of: &[usize], among: &[usize]) -> impl Iterator<Item = usize> {
    let mut at = 0;
    of.iter().map(move |column| {
        while among[at] < *column {
            at += 1;
        }
        debug_assert_eq!(among[at], *column);
        at
    })
}

impl<'a> Chains<'a> {
    /// At the place where the lifted system was evaluated.
    pub fn new(split: &'a Split, columns: &'a Columns, grid: Grid, system: &System) -> Self {
        let mut chains = Self {
            split,
            columns,
            pieces: vec![None; split.problem.arcs.len()],
            events: vec![None; split.problem.event_is_free.len()],
        };
        for (index, collision) in split.problem.collisions.iter().enumerate() {
            if columns.times_follow[index] {
                chains.add_time(index, collision, system);
            }
            if grid.shoots() {
                chains.add_states(index, collision, system);
            }
        }
        chains
    }

    fn of_part(&self, part: Part) -> Option<&DMatrix<f64>> {
        match part {
            Part::Piece(piece) => self.pieces[piece].as_ref(),
            Part::Event(event) => self.events[event].as_ref(),
            Part::Parameter(_) => None,
        }
    }

    /// Rows by all of some groups of lifted columns, chained to the unknowns `target`.
    pub fn chained(&self, rows: &DMatrix<f64>, parts: &[Part], target: &[usize]) -> DMatrix<f64> {
        let mut at = 0;
        let placed = parts.iter().map(|part| {
            at += part.width();
            (at - part.width(), *part)
        });
        self.chained_from(rows, &placed.collect::<Vec<_>>(), target)
    }

    /// The same with the first column of each group.
    pub fn chained_from(
        &self,
        rows: &DMatrix<f64>,
        parts: &[(usize, Part)],
        target: &[usize],
    ) -> DMatrix<f64> {
        let mut result = DMatrix::zeros(rows.nrows(), target.len());
        for (at, part) in parts {
            let by = rows.columns(*at, part.width());
            let own = self.columns.of_part(*part);
            let Some(chain) = self.of_part(*part) else {
                for (index, place) in places(own, target).enumerate() {
                    let mut column = result.column_mut(place);
                    column += by.column(index);
                }
                continue;
            };
            for (index, place) in places(own, target).enumerate() {
                let mut column = result.column_mut(place);
                column.gemv(1.0, &by, &chain.column(index), 1.0);
            }
        }
        result
    }

    /// `dτ = −(∂φ/∂x dx)/φ̇`.
    fn add_time(&mut self, index: usize, collision: &Collision, system: &System) {
        let problem = &self.split.problem;
        let rows = rows_of(&system.blocks[index], &[0]);
        let (mut at, mut kept, mut by_time) = (0, Vec::new(), 0.0);
        for part in of_collision(problem, index) {
            let is_before = collision
                .sides
                .iter()
                .any(|s| part == Part::Piece(s.before));
            if part == Part::Event(collision.event) {
                by_time = rows[at];
            } else if is_before || gravity(problem).any(|g| g == part) {
                kept.push((at, part));
            }
            at += part.width();
        }
        let target = &self.columns.events[collision.event];
        let by = self.chained_from(&rows, &kept, target) / -by_time;
        self.events[collision.event] = Some(by);
    }

    /// The states after, from the rows that say that they continue through the impact.
    fn add_states(&mut self, index: usize, collision: &Collision, system: &System) {
        let problem = &self.split.problem;
        let (block, gaps) = (&system.blocks[index], &system.velocity_gaps[index]);
        let parts = of_collision(problem, index);
        let mut at = 0;
        let mut placed: Vec<(usize, Part)> = Vec::new();
        for part in &parts {
            placed.push((at, *part));
            at += part.width();
        }
        let is_after = |part: &Part| {
            collision
                .sides
                .iter()
                .any(|s| *part == Part::Piece(s.after))
        };
        let others: Vec<(usize, Part)> =
            placed.iter().copied().filter(|p| !is_after(&p.1)).collect();
        for (body, side) in collision.sides.iter().enumerate() {
            let rows = continuity(block, gaps, body);
            let own = placed
                .iter()
                .find(|(_, part)| *part == Part::Piece(side.after));
            let own = rows
                .columns(own.expect("a state after").0, STATE)
                .into_owned();
            let target = &self.columns.pieces[side.after];
            let mut by = -self.chained_from(&rows, &others, target);
            if let Some(first) = self.columns.gaps[index] {
                let first = first + GAP * body;
                let gaps: Vec<usize> = (first..first + GAP).collect();
                for (row, place) in places(&gaps, target).enumerate() {
                    by[(GAP + row, place)] += 1.0;
                }
            }
            let is_regular = own.lu().solve_mut(&mut by);
            if !is_regular {
                by.fill(f64::NAN);
            }
            self.pieces[side.after] = Some(by);
        }
    }

    /// Adds gradient and Hessian of samples, priors and pulls.
    pub fn add_objective(&self, frame: &Frame, lifted: &System, out: &mut System) {
        let problem = frame.problem;
        let from = frame.layout;
        let pattern = &self.columns.layout.pattern;
        for (piece, arc) in problem.arcs.iter().enumerate() {
            let (at, own) = (from.arcs[piece], &self.columns.pieces[piece]);
            let chain = self.pieces[piece].as_ref();
            let gradient = lifted.gradient.rows(at, STATE).into_owned();
            let square =
                DMatrix::from_fn(STATE, STATE, |i, j| entry(frame, lifted, at + i, at + j));
            add_gradient(own, &pulled(chain, gradient), out);
            let square = match chain {
                Some(chain) => chain.tr_mul(&(square * chain)),
                None => square,
            };
            add_square(pattern, own, &square, &mut out.hessian);
            let mut cross = |with: usize, column: usize| {
                let by = DVector::from_fn(STATE, |i, _| entry(frame, lifted, at + i, with));
                let by = pulled(chain, by);
                for (entry, row) in by.iter().zip(own) {
                    add_symmetric(pattern, *row, column, *entry, &mut out.hessian);
                }
            };
            for sample in &arc.samples {
                if let (Some(with), Some(column)) =
                    (from.nodes[sample.node], self.columns.nodes[sample.node])
                {
                    cross(with, column);
                }
            }
            for part in gravity(problem) {
                if let Part::Parameter(p) = part {
                    cross(from.parameters[p], self.columns.parameters[p]);
                }
            }
        }
        self.add_others(frame, lifted, out);
    }

    /// Times and parameters among themselves.
    fn add_others(&self, frame: &Frame, lifted: &System, out: &mut System) {
        let (from, to) = (frame.layout, self.columns);
        let pattern = &to.layout.pattern;
        let nodes = from.nodes.iter().zip(&to.nodes);
        let nodes = nodes.filter_map(|(from, to)| Some(((*from)?, (*to)?)));
        let nodes: Vec<(usize, usize)> = nodes.collect();
        let parameters = from
            .parameters
            .iter()
            .copied()
            .zip(to.parameters.iter().copied());
        let parameters: Vec<(usize, usize)> = parameters.collect();
        for (index, (with, column)) in nodes.iter().enumerate() {
            out.gradient[*column] += lifted.gradient[*with];
            for (other, other_column) in &nodes[index.saturating_sub(2)..=index] {
                let value = entry(frame, lifted, *with, *other);
                add_once(pattern, *column, *other_column, value, &mut out.hessian);
            }
        }
        for (index, (with, column)) in parameters.iter().enumerate() {
            out.gradient[*column] += lifted.gradient[*with];
            for (other, other_column) in &parameters[..=index] {
                let value = entry(frame, lifted, *with, *other);
                add_once(pattern, *column, *other_column, value, &mut out.hessian);
            }
            if gravity(frame.problem).any(|g| from.parameters[part_index(g)] == *with) {
                for (other, other_column) in &nodes {
                    let value = entry(frame, lifted, *with, *other);
                    add_once(pattern, *column, *other_column, value, &mut out.hessian);
                }
            }
        }
        for (event, at) in from.events.iter().enumerate() {
            let Some(at) = at else { continue };
            let own = &to.events[event];
            let chain = self.events[event].as_ref();
            let gradient = DVector::repeat(1, lifted.gradient[*at]);
            let weight = entry(frame, lifted, *at, *at);
            add_gradient(own, &pulled(chain, gradient), out);
            if weight != 0.0 {
                let by = pulled(chain, DVector::repeat(1, 1.0));
                add_square(
                    pattern,
                    own,
                    &(&by * by.transpose() * weight),
                    &mut out.hessian,
                );
            }
        }
    }
}

fn part_index(part: Part) -> usize {
    match part {
        Part::Piece(index) | Part::Event(index) | Part::Parameter(index) => index,
    }
}

/// Rows of a body's continuity: closed ones, then those that have a price.
fn continuity(block: &Block, gaps: &Block, body: usize) -> DMatrix<f64> {
    let bodies_gaps = gaps.values.len();
    let first = block.approach.end;
    if bodies_gaps == 0 {
        let rows: Vec<usize> = (0..STATE).map(|row| first + STATE * body + row).collect();
        return rows_of(block, &rows);
    }
    let half = |from: usize| {
        (0..GAP)
            .map(|row| from + GAP * body + row)
            .collect::<Vec<_>>()
    };
    let (poses, velocities) = (rows_of(block, &half(first)), rows_of(gaps, &half(0)));
    let columns = poses.ncols();
    DMatrix::from_fn(STATE, columns, |row, column| {
        if row < GAP {
            poses[(row, column)]
        } else {
            velocities[(row - GAP, column)]
        }
    })
}

fn entry(frame: &Frame, lifted: &System, i: usize, j: usize) -> f64 {
    lifted
        .hessian
        .get(&frame.layout.pattern, i.max(j), i.min(j))
}

fn pulled(chain: Option<&DMatrix<f64>>, gradient: DVector<f64>) -> DVector<f64> {
    match chain {
        Some(chain) => chain.tr_mul(&gradient),
        None => gradient,
    }
}

fn add_gradient(own: &[usize], gradient: &DVector<f64>, out: &mut System) {
    for (at, value) in own.iter().zip(gradient.iter()) {
        out.gradient[*at] += value;
    }
}

fn add_square(pattern: &Pattern, own: &[usize], square: &DMatrix<f64>, matrix: &mut Envelope) {
    for (i, row) in own.iter().enumerate() {
        for (j, column) in own[..=i].iter().enumerate() {
            matrix.add(pattern, *row, *column, square[(i, j)]);
        }
    }
}

fn add_once(pattern: &Pattern, i: usize, j: usize, value: f64, matrix: &mut Envelope) {
    if value != 0.0 {
        matrix.add(pattern, i.max(j), i.min(j), value);
    }
}

/// An entry and its mirror: both where they are one place.
fn add_symmetric(pattern: &Pattern, i: usize, j: usize, value: f64, matrix: &mut Envelope) {
    let twice = if i == j { 2.0 } else { 1.0 };
    add_once(pattern, i, j, twice * value, matrix);
}
