//! A state on a support with all that the estimation asks of it.

use nalgebra::{RowSVector, SMatrix, UnitQuaternion, Vector3};

use crate::math::jet::{Jet, Jet3};
use crate::math::so3;
use crate::physics::state::{ByStates, State, StateTangent, part};

/// Variables of the derivatives: the state at the epoch, the pull, the coefficient of friction.
pub(super) const VARIABLES: usize = 16;
pub(super) const PULL: usize = 12;
pub(super) const FRICTION: usize = 15;

/// A state on a support with its derivatives from the start.
#[derive(Clone, Copy, Debug)]
pub struct Carried {
    /// The state.
    pub state: State,
    /// Its derivative by time.
    pub rate: StateTangent,
    /// Its derivatives by the state at the start.
    pub by_state: ByStates,
    /// By the pull, an axis each.
    pub by_pull: [StateTangent; 3],
    /// By the coefficient of friction.
    pub by_friction: StateTangent,
    /// The slip, negative after it has passed zero [m/s].
    pub slip_m_s: f64,
    /// Its derivative by time [m/s²].
    pub slip_rate_m_s2: f64,
    /// By the state at the start.
    pub slip_by_state: RowSVector<f64, PULL>,
    /// By the pull \[s\].
    pub slip_by_pull: [f64; 3],
    /// By the coefficient of friction.
    pub slip_by_friction: f64,
}

/// A state with its derivatives, and its rates.
pub(super) struct Seen<const N: usize> {
    pub(super) orientation: UnitQuaternion<f64>,
    /// Its changes as left perturbations.
    pub(super) turned: SMatrix<f64, 3, N>,
    pub(super) slip_m_s: Jet<N>,
    pub(super) position_m: Jet3<N>,
    pub(super) velocity_m_s: Jet3<N>,
    pub(super) spin_rad_s: Jet3<N>,
    /// Rates of position and orientation \[world\]: what is carried along moves nothing that lies.
    pub(super) moving_m_s: Vector3<f64>,
    pub(super) turning_rad_s: Vector3<f64>,
    pub(super) acceleration_m_s2: Vector3<f64>,
    pub(super) angular_acceleration_rad_s2: Vector3<f64>,
    pub(super) slip_rate_m_s2: f64,
}

impl<const N: usize> Seen<N> {
    pub(super) fn state(&self) -> State {
        State {
            position_m: self.position_m.value,
            orientation: self.orientation,
            velocity_m_s: self.velocity_m_s.value,
            angular_velocity_rad_s: self.orientation.inverse() * self.spin_rad_s.value,
        }
    }
}

impl Seen<VARIABLES> {
    pub(super) fn carried(&self) -> Carried {
        let state = self.state();
        let to_body = so3::matrix(&state.orientation).transpose();
        let mut by = SMatrix::<f64, 12, VARIABLES>::zeros();
        let mut set = |row: usize, block: SMatrix<f64, 3, VARIABLES>| {
            by.fixed_view_mut::<3, VARIABLES>(row, 0).copy_from(&block);
        };
        set(part::POSITION, self.position_m.by);
        set(part::ORIENTATION, to_body * self.turned);
        set(part::VELOCITY, self.velocity_m_s.by);
        // (Exp(δ) R)ᵀ ω = Rᵀ (ω − δ × ω).
        let spun = self.spin_rad_s.by + so3::hat(&self.spin_rad_s.value) * self.turned;
        set(part::ANGULAR_VELOCITY, to_body * spun);
        let mut rate = StateTangent::zeros();
        let mut put = |row: usize, of: Vector3<f64>| rate.fixed_rows_mut::<3>(row).copy_from(&of);
        put(part::VELOCITY, self.acceleration_m_s2);
        // What turns by less than its angular velocity sees that of the world turn: (Rᵀ ω)˙ = Rᵀ (ω̇ − Ω × ω).
        let apparent = self.turning_rad_s.cross(&self.spin_rad_s.value);
        put(
            part::ANGULAR_VELOCITY,
            to_body * (self.angular_acceleration_rad_s2 - apparent),
        );
        put(part::POSITION, self.moving_m_s);
        put(part::ORIENTATION, to_body * self.turning_rad_s);
        let column = |at: usize| by.column(at).into_owned();
        Carried {
            state,
            rate,
            by_state: by.fixed_columns::<12>(0).into_owned(),
            by_pull: [0, 1, 2].map(|axis| column(PULL + axis)),
            by_friction: column(FRICTION),
            slip_m_s: self.slip_m_s.value,
            slip_rate_m_s2: self.slip_rate_m_s2,
            slip_by_state: self.slip_m_s.by.fixed_columns::<12>(0).into_owned(),
            slip_by_pull: [0, 1, 2].map(|axis| self.slip_m_s.by[PULL + axis]),
            slip_by_friction: self.slip_m_s.by[FRICTION],
        }
    }
}
