//! A body that lands flat, with friction: a face meets a plane at three contacts at once.
//!
//! Contacts by themselves do not tell how friction is shared among them. The face as a whole does: friction acts
//! against its slip as it does in sliding ([`crate::physics::flow`]), where velocity along the plane and turning about
//! the normal are one, `u = v_t + a ω_n n`, with the gyration radius `a` about the normal. With the part `w` of the
//! turning that normal impulses cannot change,
//!
//! ```text
//! w = n·I ω⁻ / (n·I n),   a² = (n·I n)/m
//! v_n⁺ = −e v_n⁻,   ω⁺ = −e ω⁻ + (1 + e) w n + ...         as without friction, to which is added
//! u⁺ = max(0, |u| − μ (1 + e)(−v_n⁻)) u/|u|                 u of the velocities without friction
//! ```
//!
//! The first line is the projection of the velocities on those that normal impulses leave, in the metric of the
//! kinetic energy, and `m |u|²/2` is the energy of what is left: neither is ever raised. Where the plane presses, from
//! the changes of momentum and angular momentum `L`, at the height `h` of the centre of mass,
//!
//! ```text
//! c = n × (δL + h n × m δv)/(m δv·n)        along the plane, from below the centre of mass
//! ```

use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

use super::law::{Law, Side, Velocities};
use crate::math::jet::{Jet, Jet3};
use crate::math::so3;
use crate::physics::state::part;

/// Variables of the derivatives: orientation, velocity and angular velocity before, restitution, friction,
/// logarithms of the mass and of the moments, the normal.
const VARIABLES: usize = 18;
const ORIENTATION: usize = 0;
const VELOCITY: usize = 3;
const ANGULAR_VELOCITY: usize = 6;
const RESTITUTION: usize = 9;
const FRICTION: usize = 10;
const MASS: usize = 11;
const MOMENTS: usize = 12;
const NORMAL: usize = 15;

/// Least slip of which a direction is told [m/s].
const LEAST_M_S: f64 = 1e-12;

/// The velocities after a flat landing, with their derivatives.
pub(super) struct Landing {
    /// [m/s, world]
    velocity_m_s: Jet3<VARIABLES>,
    /// [rad/s, body]
    angular_velocity_rad_s: Jet3<VARIABLES>,
    /// Whether friction ends the slip.
    pub(super) sticks: bool,
}

impl Landing {
    /// Of a body onto a plane with a unit normal \[world\].
    pub(super) fn new(side: &Side, normal: &Vector3<f64>, law: &Law) -> Self {
        let state = side.state;
        let to_world = so3::matrix(&state.orientation);
        let turn = Jet3::variable(Vector3::zeros(), ORIENTATION);
        let velocity = Jet3::variable(state.velocity_m_s, VELOCITY);
        let omega = Jet3::variable(state.angular_velocity_rad_s, ANGULAR_VELOCITY);
        let restitution = Jet::variable(law.restitution, RESTITUTION);
        let friction = Jet::variable(law.friction, FRICTION);
        let normal = Jet3::variable(*normal, NORMAL);
        let mass = Jet::<VARIABLES>::variable(0.0, MASS);
        let mass_kg = Jet {
            value: side.body.mass_kg(),
            by: mass.by * side.body.mass_kg(),
        };
        let moments = side.body.moments_kg_m2();
        let moments_kg_m2 = Jet3 {
            value: moments,
            by: Matrix3::from_diagonal(&moments)
                * Jet3::<VARIABLES>::variable(Vector3::zeros(), MOMENTS).by,
        };
        // In body axes, (R Exp(δ))ᵀ n = Rᵀ n − δ × Rᵀ n.
        let up = normal.through(&to_world.transpose());
        let up = up - turn.cross(up);
        let about_kg_m2 = up.dot(moments_kg_m2.times(up));
        let kept = omega.dot(moments_kg_m2.times(up)) * about_kg_m2.recip();
        let gyration_m = (about_kg_m2 * mass_kg.recip()).sqrt();
        let along = velocity.dot(normal);
        let both = restitution + Jet::constant(1.0);
        let spin = kept * both - omega.dot(up) * restitution;
        let slip = velocity - normal * along + normal * (spin * gyration_m);
        let pressed = friction * both * -along;
        let slip_m_s = slip.norm(LEAST_M_S);
        let sticks = slip_m_s.value <= pressed.value;
        let left = match sticks {
            true => Jet::constant(0.0),
            false => Jet::constant(1.0) - pressed * slip_m_s.recip(),
        };
        let left = if along.value < 0.0 {
            left
        } else {
            Jet::constant(1.0)
        };
        Self {
            velocity_m_s: (velocity - normal * along) * left - normal * (along * restitution),
            angular_velocity_rad_s: up * (spin * left + omega.dot(up) * restitution)
                - omega * restitution,
            sticks: sticks && along.value < 0.0,
        }
    }

    /// The velocities.
    pub(super) fn velocities(&self) -> Velocities {
        Velocities {
            velocity_m_s: self.velocity_m_s.value,
            angular_velocity_rad_s: self.angular_velocity_rad_s.value,
        }
    }

    fn columns<const C: usize>(&self, at: usize) -> SMatrix<f64, 6, C> {
        let mut by = SMatrix::<f64, 6, C>::zeros();
        by.fixed_view_mut::<3, C>(0, 0)
            .copy_from(&self.velocity_m_s.by.fixed_columns::<C>(at));
        by.fixed_view_mut::<3, C>(3, 0)
            .copy_from(&self.angular_velocity_rad_s.by.fixed_columns::<C>(at));
        by
    }

    /// By the state before.
    pub(super) fn by_state(&self) -> SMatrix<f64, 6, 12> {
        let mut by = SMatrix::<f64, 6, 12>::zeros();
        let parts = [
            (part::ORIENTATION, ORIENTATION),
            (part::VELOCITY, VELOCITY),
            (part::ANGULAR_VELOCITY, ANGULAR_VELOCITY),
        ];
        for (to, from) in parts {
            by.fixed_columns_mut::<3>(to)
                .copy_from(&self.columns::<3>(from));
        }
        by
    }

    pub(super) fn by_restitution(&self) -> SVector<f64, 6> {
        self.columns::<1>(RESTITUTION)
    }

    pub(super) fn by_friction(&self) -> SVector<f64, 6> {
        self.columns::<1>(FRICTION)
    }

    pub(super) fn by_mass(&self) -> SVector<f64, 6> {
        self.columns::<1>(MASS)
    }

    pub(super) fn by_moments(&self) -> SMatrix<f64, 6, 3> {
        self.columns::<3>(MOMENTS)
    }

    /// By the normal's change \[world\].
    pub(super) fn by_normal(&self) -> SMatrix<f64, 6, 3> {
        self.columns::<3>(NORMAL)
    }
}

/// Impulses along the normal at three points \[N s\] that press as the changes of momentum and of angular momentum
/// about the centre of mass say \[N s, N m s, world\]; the points are from the centre of mass \[m, world\].
pub(super) fn pressing(
    points_m: &[Vector3<f64>; 3],
    normal: &Vector3<f64>,
    momentum: &Vector3<f64>,
    angular_momentum: &Vector3<f64>,
) -> Vector3<f64> {
    let height_m = -points_m[0].dot(normal);
    let pushed = momentum.dot(normal);
    let along = angular_momentum + normal.cross(momentum) * height_m;
    let centre_m = normal.cross(&along) / pushed;
    // Shares of the three points in the centre of pressure, as areas.
    let area =
        |a: &Vector3<f64>, b: &Vector3<f64>, c: &Vector3<f64>| normal.dot(&(b - a).cross(&(c - a)));
    let [a, b, c] = points_m;
    let whole = area(a, b, c);
    Vector3::new(
        area(&centre_m, b, c),
        area(a, &centre_m, c),
        area(a, b, &centre_m),
    ) * (pushed / whole)
}
