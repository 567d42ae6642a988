//! The derivatives of a flight from its start, of centre of mass and rotation together.
//!
//! In blocks of position, orientation, velocity and angular velocity those by the state are
//!
//! ```text
//! I  L  X L
//! 0  R  0 T
//! 0  M  V M
//! 0  0  0 S
//! ```
//!
//! with `L` and `M` of lift alone.

use nalgebra::{Matrix3, Vector3};

use super::fall::{Fall, Fallen};
use super::turn::turn;
use super::turned::Turn;
use super::{TurnByMoments, turn_by_moments};
use crate::physics::body::Body;
use crate::physics::state::{ByStates, State, StateTangent, part};

/// A state after a flight, with derivatives by the state at its start and by what acts on the way.
#[derive(Clone, Copy, Debug)]
pub struct FreeFlown {
    /// The centre of mass.
    pub fallen: Fallen,
    /// The rotation.
    pub turn: Turn,
    /// Derivatives of the rotation by the logarithms of the moments, where they are wanted.
    pub by_moments: Option<TurnByMoments>,
}

impl FreeFlown {
    /// After `duration_s` from a state (negative: before it). Derivatives by drag and by moments are zero where they are
    /// not wanted.
    pub(in crate::physics::flow) fn new(
        body: &Body,
        gravity_m_s2: &Vector3<f64>,
        state: &State,
        duration_s: f64,
        is_wanted: WantedDerivatives,
    ) -> Self {
        let omega = &state.angular_velocity_rad_s;
        let by_moments = is_wanted.by_moments;
        Self {
            fallen: Fall::new(body, gravity_m_s2, state)
                .with_drag_free(is_wanted.by_drag)
                .with_lift_free(is_wanted.by_lift)
                .fallen(duration_s),
            turn: turn(body, &state.orientation, omega, duration_s),
            by_moments: by_moments.then(|| turn_by_moments(body, omega, duration_s)),
        }
    }

    /// The state.
    pub(in crate::physics::flow) fn state(&self) -> State {
        State {
            position_m: self.fallen.position_m,
            orientation: self.turn.orientation,
            velocity_m_s: self.fallen.velocity_m_s,
            angular_velocity_rad_s: self.turn.angular_velocity_rad_s,
        }
    }

    /// Derivatives by the state at the start.
    pub(in crate::physics::flow) fn by_state(&self) -> ByStates {
        let (fallen, turn) = (&self.fallen, &self.turn);
        let mut by = ByStates::identity();
        let mut set = |row: usize, column: usize, block: &Matrix3<f64>| {
            by.fixed_view_mut::<3, 3>(row, column).copy_from(block);
        };
        let [x, r, v, w] = [
            part::POSITION,
            part::ORIENTATION,
            part::VELOCITY,
            part::ANGULAR_VELOCITY,
        ];
        set(x, v, &fallen.position_by_velocity);
        set(v, v, &fallen.velocity_by_velocity);
        set(r, r, &turn.orientation_by_orientation);
        set(r, w, &turn.orientation_by_angular_velocity);
        set(w, w, &turn.angular_velocity_by_angular_velocity);
        if let Some(spinning) = &fallen.by_spinning {
            for (row, at) in [x, v].into_iter().enumerate() {
                set(at, r, &spinning.by_orientation[row]);
                set(at, w, &spinning.by_angular_velocity[row]);
            }
        }
        by
    }

    /// Derivative by a component of the pull, gravity's or a force's per mass \[s²/m\].
    pub(in crate::physics::flow) fn by_pull(&self, axis: usize) -> StateTangent {
        let fallen = &self.fallen;
        let mut by = StateTangent::zeros();
        by.fixed_rows_mut::<3>(part::POSITION)
            .copy_from(&fallen.position_by_pull.column(axis));
        by.fixed_rows_mut::<3>(part::VELOCITY)
            .copy_from(&fallen.velocity_by_pull.column(axis));
        by
    }

    /// Derivative by the linear drag (0) or the quadratic one (1).
    pub(in crate::physics::flow) fn by_drag(&self, order: usize) -> StateTangent {
        let fallen = &self.fallen;
        let mut by = StateTangent::zeros();
        by.fixed_rows_mut::<3>(part::POSITION)
            .copy_from(&fallen.position_by_drag.column(order));
        by.fixed_rows_mut::<3>(part::VELOCITY)
            .copy_from(&fallen.velocity_by_drag.column(order));
        by
    }

    /// Derivative by the lift.
    pub(in crate::physics::flow) fn by_lift(&self) -> StateTangent {
        let mut by = StateTangent::zeros();
        if let Some(spinning) = &self.fallen.by_spinning {
            let [position, velocity] = &spinning.by_lift;
            by.fixed_rows_mut::<3>(part::POSITION).copy_from(position);
            by.fixed_rows_mut::<3>(part::VELOCITY).copy_from(velocity);
        }
        by
    }

    /// Derivative by the logarithm of a principal moment.
    pub(in crate::physics::flow) fn by_log_moment(&self, axis: usize) -> StateTangent {
        let mut by = StateTangent::zeros();
        if let Some(of) = &self.by_moments {
            by.fixed_rows_mut::<3>(part::ORIENTATION)
                .copy_from(&of.orientation.column(axis));
            by.fixed_rows_mut::<3>(part::ANGULAR_VELOCITY)
                .copy_from(&of.angular_velocity.column(axis));
        }
        by
    }
}

/// Which derivatives of a flight are wanted beside those by its state and by the pull.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WantedDerivatives {
    /// Those by drag.
    pub by_drag: bool,
    /// Those by lift.
    pub by_lift: bool,
    /// Those by the moments.
    pub by_moments: bool,
}
