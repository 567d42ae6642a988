//! The motion of a body about a point that stays, a pendulum's or a top's: with the centre of mass at `r` from that
//! point, in body axes,
//!
//! ```text
//! J ω̇ = (J ω) × ω + m r × Rᵀ p − d ω,   J = I + m (|r|² − r rᵀ)          freely
//! ω = q̇ a,   aᵀJa q̈ = a·(m r × Rᵀ p) − d q̇                              about an axis a
//! x = x₀ + (R − R₀) r,   v = R (ω × r)
//! ```
//!
//! with the pull `p` and the damping `d`. The rows `γ_i = Rᵀ e_i` of the rotation follow `γ̇_i = γ_i × ω`: all right
//! sides are sums of products of two series, so that every coefficient of their Taylor series follows from earlier ones
//! (as in Hairer, Nørsett and Wanner, "Solving Ordinary Differential Equations I", I.8).

use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};

use super::seen::{PULL, Seen};
use crate::math::jet::{Jet, Jet3};
use crate::math::so3;
use crate::physics::body::Body;
use crate::physics::state::{State, part};
use crate::physics::support::Pivot;

/// Length of a step \[s\] up to this spin [rad/s], at which the rotation is 1e-9 rad off after a second; what turns faster has
/// steps of half that length, or of a quarter, and so on.
const STEP_S: f64 = 1.0 / 32.0;
const SLOW_RAD_S: f64 = 30.0;
/// Greatest number of halvings.
const HALVINGS_MOST: f64 = 12.0;

/// Order of the series.
const ORDER: usize = 12;

/// What is constant on the way.
#[derive(Clone, Debug)]
pub(super) struct Pivoting<const N: usize> {
    /// `r`.
    lever_m: Jet3<N>,
    /// `J/m`.
    inertia_m2: Matrix3<f64>,
    /// Angular acceleration of a moment per mass.
    mobility_per_m2: Matrix3<f64>,
    /// `d/m`.
    damping_m2_s: f64,
    pull_m_s2: Jet3<N>,
    position_m: Jet3<N>,
    /// `R₀ r`.
    arm_m: Jet3<N>,
    /// What the pivot takes of the velocity, and of the angular velocity \[body\].
    carried_m_s: Jet3<N>,
    carried_rad_s: Jet3<N>,
    /// `γ` and `ω` at the start.
    start: [Jet3<N>; 4],
    /// Length of a step \[s\].
    pub(super) step_s: f64,
}

/// The series of the rotation and of the angular velocity about a moment.
#[derive(Clone, Debug)]
pub(super) struct TurnSeries<const N: usize> {
    /// Coefficients of `γ_x`, `γ_y`, `γ_z` and `ω`.
    terms: Box<[[Jet3<N>; 4]; ORDER + 1]>,
}

impl<const N: usize> Pivoting<N> {
    pub(super) fn new(
        body: &Body,
        pivot: &Pivot,
        gravity_m_s2: &Vector3<f64>,
        state: &State,
    ) -> Self {
        let turn = Jet3::variable(Vector3::zeros(), part::ORIENTATION);
        let velocity_m_s = Jet3::variable(state.velocity_m_s, part::VELOCITY);
        let spin = Jet3::variable(state.angular_velocity_rad_s, part::ANGULAR_VELOCITY);
        let to_world = so3::matrix(&state.orientation);
        let lever_m = Jet3::constant(-pivot.at_m);
        let inertia_m2 = pivot.inertia_m2(&body.gyration_m2());
        let omega = spin.through(&pivot.axes.allowed());
        // R Exp(δ) a = R (a + δ × a), and its rows are γ − δ × γ.
        let placed = |of: Jet3<N>| (of + turn.cross(of)).through(&to_world);
        let row = |axis: usize| {
            let of = Jet3::constant(to_world.row(axis).transpose());
            of - turn.cross(of)
        };
        let pull_m_s2 = body.pull_m_s2(gravity_m_s2);
        Self {
            step_s: step_s(body, pivot, &pull_m_s2, state),
            lever_m,
            inertia_m2,
            mobility_per_m2: pivot.axes.mobility(&inertia_m2),
            damping_m2_s: pivot.damping_n_m_s / body.mass_kg(),
            pull_m_s2: Jet3::variable(pull_m_s2, PULL),
            position_m: Jet3::variable(state.position_m, part::POSITION),
            arm_m: placed(lever_m),
            carried_m_s: velocity_m_s - placed(omega.cross(lever_m)),
            carried_rad_s: spin - omega,
            start: [row(0), row(1), row(2), omega],
        }
    }

    /// The series at the start.
    pub(super) fn start(&self) -> TurnSeries<N> {
        self.series(self.start)
    }

    /// The series a step after another.
    pub(super) fn after(&self, node: &TurnSeries<N>, step_s: f64) -> TurnSeries<N> {
        self.series(node.at(step_s))
    }

    fn series(&self, start: [Jet3<N>; 4]) -> TurnSeries<N> {
        let zero = Jet3::constant(Vector3::zeros());
        let mut terms = Box::new([[zero; 4]; ORDER + 1]);
        // `J ω` in step with it.
        let mut momenta = [zero; ORDER + 1];
        terms[0] = start;
        for order in 0..ORDER {
            momenta[order] = terms[order][3].through(&self.inertia_m2);
            let mut next = [zero; 4];
            for (one, other) in (0..=order).zip((0..=order).rev()) {
                let omega = terms[other][3];
                for (axis, to) in next.iter_mut().take(3).enumerate() {
                    *to = *to + terms[one][axis].cross(omega);
                }
                next[3] = next[3] + momenta[one].cross(omega);
            }
            let [x, y, z, omega] = terms[order];
            let pull = x * self.pull(0) + y * self.pull(1) + z * self.pull(2);
            let moment = next[3] + self.lever_m.cross(pull) - omega * self.damping_m2_s;
            next[3] = moment.through(&self.mobility_per_m2);
            terms[order + 1] = next.map(|of| of * (1.0 / (order + 1) as f64));
        }
        TurnSeries { terms }
    }

    /// A component of the pull.
    fn pull(&self, axis: usize) -> Jet<N> {
        self.pull_m_s2.component(axis)
    }

    /// The state so long after a moment.
    pub(super) fn told(&self, node: &TurnSeries<N>, since_s: f64) -> Seen<N> {
        let [x, y, z, omega] = node.at(since_s);
        let to_world = Matrix3::from_rows(&[x, y, z].map(|row| row.value.transpose()));
        let orientation = Rotation3::from_matrix_unchecked(to_world);
        let orientation = UnitQuaternion::from_rotation_matrix(&orientation);
        // dγ = −Rᵀ (δ × e), of which these are the parts across.
        let rows = [x, y, z].map(|row| row.by);
        let part = |row: usize, along: usize| -(to_world.row(along) * rows[row]);
        let turned = nalgebra::SMatrix::from_rows(&[part(1, 2), part(2, 0), part(0, 1)]);
        // The same of a vector in body axes that the body carries.
        let placed = |of: Jet3<N>| Jet3 {
            value: to_world * of.value,
            by: to_world * of.by - so3::hat(&(to_world * of.value)) * turned,
        };
        let moving = omega.cross(self.lever_m);
        let velocity_m_s = placed(moving);
        let spin_rad_s = placed(omega + self.carried_rad_s);
        let turning_rad_s = to_world * omega.value;
        let rate = node.rate(since_s);
        let r = self.lever_m.value;
        let acceleration = rate.cross(&r) + omega.value.cross(&moving.value);
        Seen {
            orientation,
            turned,
            slip_m_s: Jet::constant(0.0),
            position_m: self.position_m + placed(self.lever_m) - self.arm_m,
            velocity_m_s: velocity_m_s + self.carried_m_s,
            spin_rad_s,
            moving_m_s: velocity_m_s.value,
            turning_rad_s,
            acceleration_m_s2: to_world * acceleration,
            angular_acceleration_rad_s2: to_world * rate + turning_rad_s.cross(&spin_rad_s.value),
            slip_rate_m_s2: 0.0,
        }
    }
}

/// The length of steps by how fast it may turn: as at the start, and by what falling from the highest to the lowest place adds,
/// `2 √(p r/(r² + k²))` with the least gyration radius `k` \[s\].
fn step_s(body: &Body, pivot: &Pivot, pull_m_s2: &Vector3<f64>, state: &State) -> f64 {
    let lever_m = pivot.at_m.norm();
    let about_m2 = lever_m * lever_m + body.gyration_m2().min();
    let fallen_rad_s = 2.0 * (pull_m_s2.norm() * lever_m / about_m2).sqrt();
    let fastest_rad_s = state.angular_velocity_rad_s.norm() + fallen_rad_s;
    let halvings = (fastest_rad_s / SLOW_RAD_S).log2().ceil();
    STEP_S * (-halvings.clamp(0.0, HALVINGS_MOST)).exp2()
}

impl<const N: usize> TurnSeries<N> {
    /// The sums so long after.
    fn at(&self, since_s: f64) -> [Jet3<N>; 4] {
        let mut sums = self.terms[ORDER];
        for terms in self.terms[..ORDER].iter().rev() {
            for (sum, term) in sums.iter_mut().zip(terms) {
                *sum = *sum * since_s + *term;
            }
        }
        sums
    }

    /// `ω̇`.
    fn rate(&self, since_s: f64) -> Vector3<f64> {
        let terms = self.terms.iter().enumerate().skip(1).rev();
        terms.fold(Vector3::zeros(), |sum, (order, term)| {
            sum * since_s + term[3].value * order as f64
        })
    }
}
