//! An event at which a motion on a support or in a hand ends or begins without an impact: the body goes on from the state in
//! which it arrives, and where friction ends the slip, that is zero:
//!
//! ```text
//! q⁺ ⊟ q⁻ = 0,   ρ⁻ = 0
//! ```
//!
//! The state of what is in a hand is an unknown of its own ([`held`](crate::estimate::terms::held)). Where a hand takes a body, or
//! puts it down, place and orientation go on alone.
//!
//! Where a pivot catches it, place and orientation go on, and by the impulse of the pivot alone, of which there is no
//! moment about it, the velocities are (`r`, `J` and what else there is: `physics/flow/supported/pivoting.rs`)
//!
//! ```text
//! ω⁺ = M (I ω⁻ + m r × R⁻ᵀ v⁻),   v⁺ = R⁺ (ω⁺ × r)
//! ```
//!
//! with `M = J⁻¹`, `a aᵀ/(aᵀJa)` about an axis, zero where it is held still.

use nalgebra::{Matrix3, Vector3};

use super::kind::{At, Constraint, Filled};
use super::rows::STATE;
use crate::estimate::problem::influence::Influence;
use crate::estimate::problem::{ArcChange, MovedBy, Problem, unit};
use crate::estimate::reach::arrival::{ByStates, GeneralArrival};
use crate::estimate::unknowns::layout::Layout;
use crate::math::so3;
use crate::motion::Gap;
use crate::optimise::block::{Block, BlockPattern};
use crate::physics::State;
use crate::physics::state::{StateTangent, part};
use crate::physics::support::Caught;

/// One unit of each part of a state.
const UNITS: [f64; 4] = [
    unit::POSITION_M,
    unit::ORIENTATION_RAD,
    unit::VELOCITY_M_S,
    unit::ANGULAR_VELOCITY_RAD_S,
];

impl Constraint for ArcChange {
    /// The state before, the event's time, the state after, acting parameters.
    fn patterns(&self, _: &Problem, layout: &Layout) -> [BlockPattern; 2] {
        let acting = self.acting.iter();
        let acting = acting.map(|acting| layout.parameters[acting.parameter]);
        let [before, after] = self.sides.map(|side| match side {
            MovedBy::Arc(arc) => layout.state(arc),
            MovedBy::Hand(held) => layout.held[held]..layout.held[held] + STATE,
        });
        let columns = before.chain(layout.events[self.event]);
        let columns = columns.chain(after).chain(acting);
        let mut pattern = BlockPattern::default();
        pattern.push(self.rows(), columns.collect::<Vec<_>>());
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
        let of = |part: usize| match part < self.kept() {
            true => block.largest(part..part + 3) * UNITS[part / 3],
            false => 0.0,
        };
        let slip_m_s = block.largest(self.kept()..self.rows()) * unit::VELOCITY_M_S;
        Gap {
            position_m: of(part::POSITION),
            orientation_rad: of(part::ORIENTATION),
            velocity_m_s: of(part::VELOCITY).max(slip_m_s),
            angular_velocity_rad_s: of(part::ANGULAR_VELOCITY),
        }
    }

    fn places(&self, _: &Block) -> Vec<std::ops::Range<usize>> {
        std::iter::once(0..part::VELOCITY).collect()
    }

    fn is_curved(&self) -> bool {
        true
    }
}

impl ArcChange {
    /// Number of rows of what goes on.
    fn kept(&self) -> usize {
        match self.keeps_velocities {
            true => STATE,
            false => part::VELOCITY,
        }
    }

    fn rows(&self) -> usize {
        self.kept() + usize::from(self.slip_ends)
    }

    /// `None` where no body has such moments.
    fn fill_rows(&self, at: &mut At, rows: Filled) -> Option<()> {
        let (pattern, block) = rows;
        let (problem, parameters) = (at.problem, &at.point.parameters);
        let time_s = at.point.event_times_s[self.event];
        let reach = |side: MovedBy| match side {
            MovedBy::Arc(arc) => {
                GeneralArrival::new(problem, at.point, arc, at.epochs_s[arc], time_s)
            }
            MovedBy::Hand(held) => Some(GeneralArrival::given(&at.point.held[held])),
        };
        let (before, after) = (reach(self.sides[0])?, reach(self.sides[1])?);
        let mut gap = after.end.state.minus(&before.end.state);
        let turn: Vector3<f64> = gap.fixed_rows::<3>(part::ORIENTATION).into();
        let right = so3::right_jacobian_inverse(&turn);
        let with_turn = |block: Matrix3<f64>| {
            let mut by = ByStates::identity();
            by.fixed_view_mut::<3, 3>(part::ORIENTATION, part::ORIENTATION)
                .copy_from(&block);
            by
        };
        let [mut by_before, mut by_after] = [-with_turn(right.transpose()), with_turn(right)];
        if let Some(caught) = &self.caught {
            let ends = [&before.end.state, &after.end.state];
            caught.set(ends, &mut gap, [&mut by_before, &mut by_after]);
        }
        let mut columns: Vec<StateTangent> = Vec::new();
        let push = |columns: &mut Vec<StateTangent>, by: ByStates| {
            columns.extend(by.column_iter().map(|column| column.into_owned()));
        };
        push(&mut columns, by_before * before.by_state());
        let is_free = problem.event_is_free[self.event];
        if is_free {
            columns.push(by_before * before.end.rate + by_after * after.end.rate);
        }
        push(&mut columns, by_after * after.by_state());
        columns.extend(self.acting.iter().map(|acting| {
            let value = parameters[acting.parameter];
            let sides = [(&before, by_before), (&after, by_after)].into_iter();
            let arcs = sides
                .zip(self.sides)
                .filter(|(_, side)| matches!(side, MovedBy::Arc(_)));
            arcs.map(|((arrival, by), _)| by * arrival.by_acting(acting, value))
                .sum::<StateTangent>()
        }));
        for row in 0..self.kept() {
            let unit = UNITS[row / 3];
            block.values[row] = gap[row] / unit;
            let to = block.derivatives_mut(pattern, row);
            for (entry, column) in to.iter_mut().zip(&columns) {
                *entry = column[row] / unit;
            }
        }
        if let Some(slip) = before.carried().filter(|_| self.slip_ends) {
            block.values[self.kept()] = slip.slip_m_s / unit::VELOCITY_M_S;
            let by_state = slip.slip_by_state.iter().copied();
            let by_time = is_free.then_some(slip.slip_rate_m_s2);
            let by_acting = self.acting.iter().map(|acting| match acting.influence {
                Influence::Pull(axis) => slip.slip_by_pull[axis],
                Influence::SupportFriction if before.is_slowed_by(acting) => slip.slip_by_friction,
                _ => 0.0,
            });
            let all = by_state.chain(by_time).chain([0.0; STATE]).chain(by_acting);
            let to = block.derivatives_mut(pattern, self.kept());
            for (entry, by) in to.iter_mut().zip(all) {
                *entry = by / unit::VELOCITY_M_S;
            }
        }
        Some(())
    }
}

impl Caught {
    /// Sets the rows of the velocities.
    fn set(
        &self,
        [before, after]: [&State; 2],
        gap: &mut StateTangent,
        [by_before, by_after]: [&mut ByStates; 2],
    ) {
        let (r, of) = (so3::hat(&self.lever_m), self.mobility_per_m2);
        let inertia = Matrix3::from_diagonal(&self.inertia_m2);
        let [from_before, to_world] = [
            so3::matrix(&before.orientation).transpose(),
            so3::matrix(&after.orientation),
        ];
        let velocity = from_before * before.velocity_m_s;
        let momentum = inertia * before.angular_velocity_rad_s + r * velocity;
        let moving = after.angular_velocity_rad_s.cross(&self.lever_m);
        let slip = after.velocity_m_s - to_world * moving;
        let turning = after.angular_velocity_rad_s - of * momentum;
        gap.fixed_rows_mut::<3>(part::VELOCITY).copy_from(&slip);
        gap.fixed_rows_mut::<3>(part::ANGULAR_VELOCITY)
            .copy_from(&turning);
        let put = |to: &mut ByStates, row: usize, column: usize, block: Matrix3<f64>| {
            to.fixed_view_mut::<3, 3>(row, column).copy_from(&block);
        };
        put(by_before, part::VELOCITY, part::VELOCITY, Matrix3::zeros());
        put(
            by_after,
            part::VELOCITY,
            part::ORIENTATION,
            to_world * so3::hat(&moving),
        );
        put(
            by_after,
            part::VELOCITY,
            part::ANGULAR_VELOCITY,
            to_world * r,
        );
        let (row, turned) = (part::ANGULAR_VELOCITY, -of * r);
        put(
            by_before,
            row,
            part::ORIENTATION,
            turned * so3::hat(&velocity),
        );
        put(by_before, row, part::VELOCITY, turned * from_before);
        put(by_before, row, part::ANGULAR_VELOCITY, -of * inertia);
    }
}

#[cfg(test)]
mod tests;
