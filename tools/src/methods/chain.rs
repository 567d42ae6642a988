//! Derivatives of what follows by what is held.

use enact::estimate::problem::ArcCollision;
use enact::estimate::unknowns::layout::Layout;
use enact::optimise::System;
use enact::physics::state::DIMENSION as STATE;
use nalgebra::DMatrix;

use super::columns::{Columns, GAP};
use super::parts::{Part, gravity, of_collision};
use super::rows::{continuity, rows_of, unknowns};
use super::split::{Grid, Split};

/// Derivatives of every piece's state and every event's time by the unknowns that
/// [`Columns::of_part`] names; `None` where they are those unknowns.
pub struct Chains<'a> {
    split: &'a Split,
    pub(super) columns: &'a Columns,
    pub(super) pieces: Vec<Option<DMatrix<f64>>>,
    pub(super) events: Vec<Option<DMatrix<f64>>>,
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
    pub fn new(
        split: &'a Split,
        columns: &'a Columns,
        grid: Grid,
        lifted: (&Layout, &System),
    ) -> Self {
        let mut chains = Self {
            split,
            columns,
            pieces: vec![None; split.problem.arcs.len()],
            events: vec![None; split.problem.event_is_free.len()],
        };
        for (index, collision) in split.problem.collisions.iter().enumerate() {
            if columns.times_follow[index] {
                chains.add_time(index, collision, lifted);
            }
            if grid.shoots() {
                chains.add_states(index, collision, lifted);
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
    fn add_time(
        &mut self,
        index: usize,
        collision: &ArcCollision,
        (layout, system): (&Layout, &System),
    ) {
        let problem = &self.split.problem;
        let parts = of_collision(problem, index);
        let block = (&system.blocks[index], &layout.structure.blocks[index]);
        let rows = rows_of(block, &[0], &unknowns(layout, &parts));
        let (mut at, mut kept, mut by_time) = (0, Vec::new(), 0.0);
        for part in parts {
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
    fn add_states(
        &mut self,
        index: usize,
        collision: &ArcCollision,
        (layout, system): (&Layout, &System),
    ) {
        let problem = &self.split.problem;
        let block = (&system.blocks[index], &layout.structure.blocks[index]);
        let gaps = (&system.priced[index], &layout.structure.priced[index]);
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
            let rows = continuity(block, gaps, body, &unknowns(layout, &parts));
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
}
