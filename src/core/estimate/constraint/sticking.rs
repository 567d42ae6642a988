//! An event from which on two bodies are one: what both keep there, and that they move as one from then on,
//!
//! ```text
//! P⁺ = P⁻,   L⁺ = L⁻,   v₁⁺ − v₀⁺ = ω₀⁺ × (x₁⁺ − x₀⁺),   ω₁⁺ = ω₀⁺
//! ```
//!
//! with `P` and `L` of both together about their centre of mass (`physics/stuck.rs`). That places and orientations of each go on
//! are rows of their [changes](crate::estimate::problem::ArcChange). Where one sticks to the other is no number of these rows:
//! it is where both arrive.

use nalgebra::SMatrix;

use super::kind::{At, Constraint, Filled};
use crate::estimate::problem::{ArcSticking, Problem, unit};
use crate::estimate::reach::arrival::GeneralArrival;
use crate::estimate::unknowns::layout::Layout;
use crate::motion::Gap;
use crate::optimise::block::{Block, BlockPattern};
use crate::physics::state::StateTangent;
use crate::physics::stuck::PairRows;

/// Rows: the momenta, then the slip.
const ROWS: usize = 12;

impl Constraint for ArcSticking {
    /// The states before, the event's time, the states after, acting parameters.
    fn patterns(&self, _: &Problem, layout: &Layout) -> [BlockPattern; 2] {
        let acting = self.acting.iter();
        let acting = acting.map(|acting| layout.parameters[acting.parameter]);
        let [before, after] = self.arcs();
        let states = |arcs: [usize; 2]| arcs.into_iter().flat_map(|arc| layout.state(arc));
        let columns = states(before).chain(layout.events[self.event]);
        let columns = columns.chain(states(after)).chain(acting);
        let mut pattern = BlockPattern::default();
        pattern.push(ROWS, columns.collect::<Vec<_>>());
        [pattern, BlockPattern::default()]
    }

    fn fill(&self, at: &mut At, [(pattern, block), _]: [Filled; 2]) {
        block.reset(pattern);
        if self.fill_rows(at, (pattern, &mut *block)).is_none() {
            block.spoil();
        }
    }

    fn event(&self) -> Option<usize> {
        Some(self.event)
    }

    fn gap(&self, _: &Problem, [block, _]: [&Block; 2]) -> Gap {
        let largest = |at: usize| block.largest(at..at + 3).max(block.largest(6 + at..9 + at));
        Gap {
            velocity_m_s: largest(0) * unit::VELOCITY_M_S,
            angular_velocity_rad_s: largest(3) * unit::ANGULAR_VELOCITY_RAD_S,
            ..Gap::default()
        }
    }

    fn places(&self, _: &Block) -> Vec<std::ops::Range<usize>> {
        Vec::new()
    }

    fn is_curved(&self) -> bool {
        true
    }
}

impl ArcSticking {
    /// The arcs before, and those after.
    fn arcs(&self) -> [[usize; 2]; 2] {
        let sides = &self.sides;
        [sides.map(|side| side.before), sides.map(|side| side.after)]
    }

    /// `None` where no body has such moments.
    fn fill_rows(&self, at: &mut At, rows: Filled) -> Option<()> {
        let (pattern, block) = rows;
        let (problem, parameters) = (at.problem, &at.point.parameters);
        let time_s = at.point.event_times_s[self.event];
        let reach =
            |arc: usize| GeneralArrival::new(problem, at.point, arc, at.epochs_s[arc], time_s);
        let [before, after] = self.arcs();
        let bodies = before.map(|arc| problem.body_of(arc));
        let before = [reach(before[0])?, reach(before[1])?];
        let after = [reach(after[0])?, reach(after[1])?];
        let momenta = |of: &[GeneralArrival; 2]| {
            let states = [&of[0].end.state, &of[1].end.state];
            PairRows::momenta(bodies, states, self.per_kg_m2)
        };
        let (was, is) = (momenta(&before), momenta(&after));
        let slip = PairRows::slip([&after[0].end.state, &after[1].end.state]);
        // Derivatives of all rows by each of the states at the event.
        let stacked = |above: SMatrix<f64, 6, 12>, below: SMatrix<f64, 6, 12>| {
            let mut by = SMatrix::<f64, ROWS, 12>::zeros();
            by.fixed_rows_mut::<6>(0).copy_from(&above);
            by.fixed_rows_mut::<6>(6).copy_from(&below);
            by
        };
        let sides = [0, 1];
        let before = sides.map(|side| (&before[side], stacked(-was.by[side], SMatrix::zeros())));
        let after = sides.map(|side| (&after[side], stacked(is.by[side], slip.by[side])));
        let mut columns: Vec<StateTangent> = Vec::new();
        let by_states = |columns: &mut Vec<StateTangent>, of: &[(&GeneralArrival, _); 2]| {
            for (arrival, by) in of {
                let chained: SMatrix<f64, ROWS, 12> = by * arrival.by_state();
                columns.extend(chained.column_iter().map(|column| column.into_owned()));
            }
        };
        by_states(&mut columns, &before);
        let all = || before.iter().chain(&after);
        if problem.event_is_free[self.event] {
            columns.push(all().map(|(arrival, by)| by * arrival.end.rate).sum());
        }
        by_states(&mut columns, &after);
        columns.extend(self.acting.iter().map(|acting| {
            let value = parameters[acting.parameter];
            let each = all().map(|(arrival, by)| by * arrival.by_acting(acting, value));
            each.sum::<StateTangent>()
        }));
        for row in 0..ROWS {
            let value = match row {
                0..6 => is.values[row] - was.values[row],
                _ => slip.values[row - 6],
            };
            let unit = match row % 6 {
                0..3 => unit::VELOCITY_M_S,
                _ => unit::ANGULAR_VELOCITY_RAD_S,
            };
            block.values[row] = value / unit;
            let to = block.derivatives_mut(pattern, row);
            for (entry, column) in to.iter_mut().zip(&columns) {
                *entry = column[row] / unit;
            }
        }
        Some(())
    }
}
