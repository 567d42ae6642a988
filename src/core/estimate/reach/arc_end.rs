//! An arc's state at an event, and derivatives by it chained back to the arc's epoch.
//!
//! With the duration `s` from the epoch the flow's derivative is, in blocks of position,
//! orientation, velocity and angular velocity,
//!
//! ```text
//! I  0  sI 0
//! 0  R  0  T
//! 0  0  I  0
//! 0  0  0  S
//! ```

use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

use crate::estimate::unknowns::point::Point;
use crate::physics::flow::{Carried, Supported, Turns};
use crate::physics::state::{StateTangent, part};
use crate::physics::{Body, State, flow};

/// An arc's state at an event, with the blocks of the flow's derivative.
pub(in crate::estimate) struct ArcEnd {
    pub(in crate::estimate) state: State,
    pub(in crate::estimate) duration_s: f64,
    /// `R`.
    pub(in crate::estimate) by_orientation: Matrix3<f64>,
    /// `T`.
    pub(in crate::estimate) turn_by_spin: Matrix3<f64>,
    /// `S`.
    pub(in crate::estimate) spin_by_spin: Matrix3<f64>,
    /// Derivative of the state by the event's time.
    pub(in crate::estimate) rate: StateTangent,
}

/// Derivatives of some rows by a state, part by part.
pub(in crate::estimate) struct ByState<const R: usize> {
    pub(in crate::estimate) position: SMatrix<f64, R, 3>,
    pub(in crate::estimate) orientation: SMatrix<f64, R, 3>,
    pub(in crate::estimate) velocity: SMatrix<f64, R, 3>,
    pub(in crate::estimate) spin: SMatrix<f64, R, 3>,
}

impl<const R: usize> ByState<R> {
    /// `R` rows, from the row `first` on, of a matrix of derivatives by whole states.
    pub(in crate::estimate) fn of<const N: usize>(
        rows: &SMatrix<f64, N, 12>,
        first: usize,
    ) -> Self {
        let part = |at: usize| rows.fixed_view::<R, 3>(first, at).into_owned();
        Self {
            position: part(part::POSITION),
            orientation: part(part::ORIENTATION),
            velocity: part(part::VELOCITY),
            spin: part(part::ANGULAR_VELOCITY),
        }
    }

    /// Sets a row's derivatives, scaled, from the part that begins at `from` on.
    pub(in crate::estimate) fn put(&self, row: usize, scale: f64, from: usize, to: &mut [f64]) {
        let parts = [
            &self.position,
            &self.orientation,
            &self.velocity,
            &self.spin,
        ];
        for (part, to) in parts[from / 3..].iter().zip(to.chunks_exact_mut(3)) {
            for axis in 0..3 {
                to[axis] = part[(row, axis)] * scale;
            }
        }
    }
}

impl ArcEnd {
    pub(in crate::estimate) fn new(
        body: &Body,
        gravity_m_s2: &Vector3<f64>,
        point: &Point,
        arc: usize,
        [epoch_s, time_s]: [f64; 2],
    ) -> Self {
        let state = &point.arcs[arc];
        if let Some(mut supported) = Supported::new(body, gravity_m_s2, state) {
            let duration_s = time_s - epoch_s;
            return Self::carried(&supported.carried(duration_s), duration_s);
        }
        point.kept.with_turns(body, state, |turns| {
            Self::after(turns, gravity_m_s2, state, time_s - epoch_s)
        })
    }

    /// After a duration, by the turns of the same state.
    pub(in crate::estimate) fn after(
        turns: &mut Turns,
        gravity_m_s2: &Vector3<f64>,
        state: &State,
        duration_s: f64,
    ) -> Self {
        let body = turns.body();
        let turn = turns.after(duration_s);
        let state_then = State {
            position_m: flow::position(body, gravity_m_s2, state, duration_s),
            orientation: turn.orientation,
            velocity_m_s: flow::velocity(body, gravity_m_s2, state, duration_s),
            angular_velocity_rad_s: turn.angular_velocity_rad_s,
        };
        Self {
            rate: flow::rate(body, gravity_m_s2, &state_then),
            state: state_then,
            duration_s,
            by_orientation: turn.orientation_by_orientation,
            turn_by_spin: turn.orientation_by_angular_velocity,
            spin_by_spin: turn.angular_velocity_by_angular_velocity,
        }
    }

    /// On a support after a duration: its derivatives are [`Carried`]'s, of which the blocks here are a part.
    pub(in crate::estimate) fn carried(carried: &Carried, duration_s: f64) -> Self {
        let block = |row: usize, column: usize| {
            carried
                .by_state
                .fixed_view::<3, 3>(row, column)
                .into_owned()
        };
        Self {
            state: carried.state,
            duration_s,
            by_orientation: block(part::ORIENTATION, part::ORIENTATION),
            turn_by_spin: block(part::ORIENTATION, part::ANGULAR_VELOCITY),
            spin_by_spin: block(part::ANGULAR_VELOCITY, part::ANGULAR_VELOCITY),
            rate: carried.rate,
        }
    }

    /// A state that is itself the unknown, whatever the time: of a held body.
    pub(in crate::estimate) fn given(state: &State) -> Self {
        Self {
            state: *state,
            duration_s: 0.0,
            by_orientation: Matrix3::identity(),
            turn_by_spin: Matrix3::zeros(),
            spin_by_spin: Matrix3::identity(),
            rate: StateTangent::zeros(),
        }
    }

    /// Chains derivatives by the arriving state to those by the state at the epoch.
    pub(in crate::estimate) fn chain<const R: usize>(&self, rows: &ByState<R>) -> ByState<R> {
        ByState {
            position: rows.position,
            orientation: rows.orientation * self.by_orientation,
            velocity: rows.velocity + rows.position * self.duration_s,
            spin: rows.orientation * self.turn_by_spin + rows.spin * self.spin_by_spin,
        }
    }

    /// Chains derivatives by the arriving state to those by the event's time.
    pub(in crate::estimate) fn by_time<const R: usize>(
        &self,
        rows: &ByState<R>,
    ) -> SVector<f64, R> {
        let rate = |at: usize| self.rate.fixed_rows::<3>(at);
        rows.position * rate(part::POSITION)
            + rows.orientation * rate(part::ORIENTATION)
            + rows.velocity * rate(part::VELOCITY)
            + rows.spin * rate(part::ANGULAR_VELOCITY)
    }

    /// Chains derivatives by the arriving state to those by a component of gravity.
    pub(in crate::estimate) fn by_gravity<const R: usize>(
        &self,
        rows: &ByState<R>,
        axis: usize,
    ) -> SVector<f64, R> {
        let s = self.duration_s;
        rows.position.column(axis) * (0.5 * s * s) + rows.velocity.column(axis) * s
    }
}
