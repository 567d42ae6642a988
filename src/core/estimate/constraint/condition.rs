//! A condition of the scene: a quantity of one or two bodies' states, or of times, in a set
//! (paper §3.1, any function of state and parameters).
//!
//! ```text
//! y = y(Φ(q_a, τ), Φ(q_b, τ), u),   a row c(y) for each bound of the set (`within`)
//! c_q = c_y y_q Φ_q,   c_τ = c_y y_q q̇,   c_u = c_y (y_q Φ_u + y_u)
//! ```
//!
//! Rows of a hard condition are constraints; rows of one with a weight are priced: half the square of
//! their violation in standard deviations is part of the objective. Where a row hardly changes with
//! time (a height near an apex), its second derivative by the event's time is given: nothing else
//! says where it is.

use std::ops::Range;

use nalgebra::Vector3;

use super::kind::{At, Constraint, Filled};
use super::quantity::{self, ByState, Valued};
use super::reached::Reached;
use super::touched::TouchedPoint;
use super::within::WithinRow;
use crate::estimate::problem::arc_condition::ArcCondition;
use crate::estimate::problem::influence::Influence;
use crate::estimate::problem::{Problem, unit};
use crate::estimate::terms::modelled::TouchedPair;
use crate::estimate::unknowns::layout::Layout;
use crate::math::so3;
use crate::motion::{BodyPoint, Gap, GoalQuantity, GoalUnit};
use crate::optimise::block::{Block, BlockPattern, SecondDerivative};
use crate::physics::State;
use crate::physics::state::{StateTangent, part};

/// A row is nearly stationary where its slope changes sign within this time \[s\].
const STATIONARY_S: f64 = 0.02;
/// Step of the difference that gives second derivatives by the time \[s\].
const STEP_S: f64 = 1e-5;

/// Numbers of unknowns of a state.
const STATE: usize = 12;

impl Constraint for ArcCondition {
    /// Columns: the states of its arcs, the time of the event and that since which a time is counted,
    /// where they are free; parameters.
    fn patterns(&self, _: &Problem, layout: &Layout) -> [BlockPattern; 2] {
        let states = self.arcs.iter().flat_map(|arc| layout.state(*arc));
        let times = self.events().filter_map(|event| layout.events[event]);
        let parameters = self.acting.iter().map(|of| layout.parameters[of.parameter]);
        let columns = states.chain(times).chain(parameters).collect();
        let rows = BlockPattern::dense(self.rows.count(), columns);
        if self.is_soft() {
            [BlockPattern::default(), rows]
        } else {
            [rows, BlockPattern::default()]
        }
    }

    /// Where what touches is undetermined the rows are NaN.
    fn fill(&self, at: &mut At, [(hard_pattern, hard), (soft_pattern, soft)]: [Filled; 2]) {
        hard.reset(hard_pattern);
        soft.reset(soft_pattern);
        let (pattern, block) = if self.is_soft() {
            (soft_pattern, soft)
        } else {
            (hard_pattern, hard)
        };
        if self.filled(at, (pattern, &mut *block)).is_none() {
            block.spoil();
        }
    }

    fn event(&self) -> Option<usize> {
        Some(self.event)
    }

    fn gap(&self, _: &Problem, [block, _]: [&Block; 2]) -> Gap {
        let largest = block.largest(0..block.values.len()) * self.unit();
        let mut gap = Gap::default();
        match self.condition.quantity.unit() {
            GoalUnit::Metre => gap.position_m = largest,
            GoalUnit::Radian => gap.orientation_rad = largest,
            GoalUnit::MetrePerSecond => gap.velocity_m_s = largest,
            GoalUnit::RadianPerSecond => gap.angular_velocity_rad_s = largest,
            GoalUnit::Second => {}
        }
        gap
    }

    fn places(&self, rows: &Block) -> Vec<Range<usize>> {
        if self.condition.quantity.is_of_pose() {
            std::iter::once(0..rows.values.len()).collect()
        } else {
            Vec::new()
        }
    }

    fn is_curved(&self) -> bool {
        !matches!(self.condition.quantity, GoalQuantity::Time { .. })
    }

    fn time_gap_s(&self, rows: &Block) -> f64 {
        match self.condition.quantity.unit() {
            GoalUnit::Second => rows.largest(0..rows.values.len()) * unit::TIME_S,
            _ => 0.0,
        }
    }

    fn is_soft_goal(&self) -> bool {
        self.is_soft()
    }

    fn price(&self, _: &Problem, most: f64) -> f64 {
        let sd = self.condition.sd.unwrap_or(f64::INFINITY);
        (self.unit() / sd).powi(2).min(most)
    }
}

impl ArcCondition {
    /// Sets values, bounds and derivatives; `None` where there is no such flight or touch.
    fn filled(&self, at: &At, (pattern, block): Filled) -> Option<()> {
        let (problem, point) = (at.problem, at.point);
        let free_times = || self.events().map(|event| problem.event_is_free[event]);
        if let GoalQuantity::Time { since } = self.condition.quantity {
            let since_s = since.map_or(0.0, |event| at.event_time_s(event));
            let value = Vector3::new(at.event_time_s(self.event) - since_s, 0.0, 0.0);
            for (row, of) in self.rows_of(&value).into_iter().enumerate() {
                self.put(&of, row, block);
                let signs = [1.0, -1.0].into_iter().zip(free_times());
                let signs = signs.filter_map(|(sign, is_free)| is_free.then_some(sign));
                let entries = block.derivatives_mut(pattern, row);
                for (entry, sign) in entries.iter_mut().zip(signs) {
                    *entry = sign * of.by.x / self.unit();
                }
            }
            return Some(());
        }
        let gravity_m_s2 = problem.gravity(&point.parameters);
        let time_s = at.event_time_s(self.event);
        let reached = self.arcs.iter();
        let reached = reached.map(|arc| Reached::new(at, *arc, &gravity_m_s2, time_s));
        let reached: Vec<Reached> = reached.collect::<Option<_>>()?;
        let touching = match &self.touched {
            Some(touched) => Some(
                problem.touching_at(&problem.collisions[touched.collision], &point.parameters)?,
            ),
            None => None,
        };
        let states: Vec<State> = reached.iter().map(|of| of.end().state).collect();
        let shifts_m = self.centres_m(&point.parameters);
        let measured = self.measured(&states, &shifts_m, touching.as_ref())?;
        let valued = &measured.valued;

        let by_states: Vec<ByState> = reached
            .iter()
            .zip(&valued.by)
            .map(|(reached, by)| reached.chain(by))
            .collect();
        let by_time = rate_of(valued, reached.iter().map(|of| of.end().rate));
        let is_free = problem.event_is_free[self.event];
        let by_parameters = self.acting.iter().map(|of| {
            let value = point.parameters[of.parameter];
            let each = of.on.iter().map(|(side, influence)| match side {
                Some(side) => {
                    let flown = reached[*side].by(&valued.by[*side], *influence, value);
                    flown + self.by_centre(&measured, &states, *side, *influence)
                }
                None => self.by_surface(&measured, touching.as_ref(), *influence),
            });
            each.sum::<Vector3<f64>>()
        });
        let by_parameters: Vec<Vector3<f64>> = by_parameters.collect();

        // The change of the quantity's rate along the flight.
        let bend = is_free.then(|| {
            let rate_at = |by_s: f64| {
                let states: Vec<State> = reached.iter().map(|of| of.moved(by_s)).collect();
                let there = self.measured(&states, &shifts_m, touching.as_ref())?;
                let rates = reached
                    .iter()
                    .zip(&states)
                    .map(|(of, state)| of.rate(state));
                Some(rate_of(&there.valued, rates))
            };
            Some((rate_at(STEP_S)? - rate_at(-STEP_S)?) / (2.0 * STEP_S))
        });
        let bend = bend.flatten().unwrap_or_default();

        let unit = self.unit();
        for (row, of) in self.rows_of(&valued.value).into_iter().enumerate() {
            self.put(&of, row, block);
            let entries = block.derivatives_mut(pattern, row);
            let (by_state, rest) = entries.split_at_mut(STATE * reached.len());
            for (entries, by) in by_state.chunks_exact_mut(STATE).zip(&by_states) {
                let chained = of.by.tr_mul(by) / unit;
                entries.copy_from_slice(chained.as_slice());
            }
            let slope = of.by.dot(&by_time);
            let times = is_free.then_some(slope).into_iter();
            let parameters = by_parameters.iter().map(|by| of.by.dot(by));
            for (entry, by) in rest.iter_mut().zip(times.chain(parameters)) {
                *entry = by / unit;
            }
            let second = of.by.dot(&bend) + by_time.dot(&(of.second * by_time));
            if is_free && second.abs() * STATIONARY_S > slope.abs() {
                let time = STATE * reached.len();
                block.second.push(SecondDerivative {
                    row,
                    by: [time, time],
                    value: second / unit,
                });
            }
        }
        Some(())
    }

    fn put(&self, of: &WithinRow, row: usize, block: &mut Block) {
        let unit = self.unit();
        block.values[row] = of.value / unit;
        block.bounds[row] = (of.bounds.0 / unit, of.bounds.1 / unit);
    }

    /// The rows for a value of the quantity.
    fn rows_of(&self, value: &Vector3<f64>) -> Vec<WithinRow> {
        self.rows.at(&self.condition.set, value)
    }

    /// Where the centres of mass of its bodies are, from the origins of the axes in which the scene gives
    /// points \[m\].
    fn centres_m(&self, parameters: &[f64]) -> [Vector3<f64>; 2] {
        let mut centres_m = [Vector3::zeros(); 2];
        for of in &self.acting {
            for on in &of.on {
                if let (Some(side), Influence::Centre(axis)) = on {
                    centres_m[*side][*axis] += parameters[of.parameter];
                }
            }
        }
        centres_m
    }

    /// The quantity at states, with what is touched.
    fn measured(
        &self,
        states: &[State],
        centres_m: &[Vector3<f64>; 2],
        touching: Option<&TouchedPair>,
    ) -> Option<MeasuredState> {
        let quantity = &self.condition.quantity;
        let seen_from = quantity.seen_from().and(states.get(1));
        let touched = match (&self.touched, touching) {
            (Some(touched), Some(touching)) => {
                let contact = touching.contacts.as_slice().get(touched.contact)?;
                Some(TouchedPoint::new(contact, touched.side, states)?)
            }
            _ => None,
        };
        let point_m = match (quantity.point(), &touched) {
            (_, Some(touched)) => touched.point_m,
            (Some(BodyPoint::Fixed(point_m)), _) => point_m - centres_m[0],
            _ => Vector3::zeros(),
        };
        let mut valued = quantity::valued(quantity, &states[0], seen_from, &point_m);
        if seen_from.is_some() && matches!(quantity, GoalQuantity::Position { .. }) {
            valued.value += centres_m[1];
        }
        if let Some(touched) = &touched {
            valued.follow(&touched.by[..states.len()]);
        }
        Some(MeasuredState { valued, touched })
    }

    /// Derivative by where a body's centre of mass is: a shift of it is one of all of its points the
    /// other way.
    fn by_centre(
        &self,
        measured: &MeasuredState,
        states: &[State],
        side: usize,
        influence: Influence,
    ) -> Vector3<f64> {
        let Influence::Centre(axis) = influence else {
            return Vector3::zeros();
        };
        let valued = &measured.valued;
        match (
            &self.condition.quantity,
            self.condition.quantity.point(),
            side,
        ) {
            (_, Some(BodyPoint::Centre), 0) => Vector3::zeros(),
            (GoalQuantity::Position { .. }, ..) => {
                let by_place = valued.by[side].fixed_columns::<3>(part::POSITION);
                let turned = states[side].orientation * Vector3::ith(axis, 1.0);
                -(by_place * turned)
            }
            (GoalQuantity::Velocity { .. }, ..) => -valued.by_point.column(axis),
            _ => Vector3::zeros(),
        }
    }

    /// Derivative by height or tilt of the surface that is touched.
    fn by_surface(
        &self,
        measured: &MeasuredState,
        touching: Option<&TouchedPair>,
        influence: Influence,
    ) -> Vector3<f64> {
        let (Some(touched), Some(of), Some(touching)) =
            (&measured.touched, &self.touched, touching)
        else {
            return Vector3::zeros();
        };
        let column = match influence {
            Influence::SurfaceHeight => 0,
            Influence::SurfaceTilt(tangent) => 1 + tangent,
            _ => return Vector3::zeros(),
        };
        let motion = touching.motions[of.contact].column(column);
        let turn: Vector3<f64> = motion.fixed_rows::<3>(3).into();
        // The surface turns about its own point.
        let shift = motion.fixed_rows::<3>(0) + so3::hat(&touched.face_m) * turn;
        let by_shift = touched.by[1].fixed_columns::<3>(0) * shift;
        let by_turn = touched.by[1].fixed_columns::<3>(3) * turn;
        measured.valued.by_point * (by_shift + by_turn)
    }
}

/// A quantity with the touch that it is about.
struct MeasuredState {
    valued: Valued,
    touched: Option<TouchedPoint>,
}

/// The quantity's rate where its states have these rates.
fn rate_of(valued: &Valued, rates: impl Iterator<Item = StateTangent>) -> Vector3<f64> {
    let each = valued.by.iter().zip(rates);
    each.map(|(by, rate)| by * rate).sum()
}
