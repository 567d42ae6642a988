//! Input and result of an impact: the law, the bodies that take part, velocities and impulses.

use nalgebra::Vector3;

use crate::physics::body::Body;
use crate::physics::state::State;

/// Greatest number of simultaneous contacts.
pub(super) const MOST_CONTACTS: usize = 3;

/// The law of an impact and its parameters.
///
/// At one contact: the algebraic law of Chatterjee and Ruina ("A new algebraic rigid-body
/// collision law based on impulse space considerations", Journal of Applied Mechanics 65, 1998)
/// with its tangential restitution `e_t` where it would stick. With the contact points' relative velocity `v`, the normal
/// `n`, `u = n·v` and Delassus' operator `W` (relative velocity per impulse), the impulse on A is
///
/// ```text
/// P = (1 + e) P_I + κ (P_II − P_I),   P_I = −u/(n·W n) n,   P_II = −W⁻¹ v
/// ```
///
/// with `κ = 1 + e_t` where that lies in the friction cone `|P − (n·P) n| ≤ μ n·P` (the contact
/// sticks), else the `κ` in `[0, 1 + e_t)` that puts it on the cone (it slides). For approaching
/// contacts, `0 ≤ e ≤ 1`, `0 ≤ e_t ≤ 1` and `μ ≥ 0`, the following holds:
///
/// - Newton's rule `u⁺ = −e u` exactly, with or without friction, since `n·W (P_II − P_I) = 0`;
/// - the energy lost is `½(1 − e²) P_I·W P_I + ½κ(2 − κ) D·W D ≥ 0` with `D = P_II − P_I`, whatever the
///   bodies, for `P_I·W D = 0` and `κ ≤ 2`; at `e = e_t = 1` nothing is lost where it sticks;
/// - the impulse is in the cone and pushes; `μ = 0` is the frictionless bounce;
/// - a contact that sticks has the relative velocity `v⁺ = e W P_I + e_t W D` afterwards, of `v = −W P_I − W D`
///   before, where `W D` is along the surface. Of a ball, whose `W n` is along the normal, that is `−e_t` times
///   the tangential velocity before (Garwin, "Kinematics of an ultraelastic rough ball", American Journal of
///   Physics 37, 1969; Cross, "Grip-slip behavior of a bouncing ball", American Journal of Physics 70, 2002), and at
///   `e_t = 0` none; elsewhere the rebound has a tangential part of its own;
/// - velocities are continuous where sticking changes to sliding.
///
/// With `e > 1`, of a bumper, all of it holds but that energy is lost: the impact gains up to
/// `½(e² − 1) P_I·W P_I`.
///
/// At several contacts, without friction, every normal speed is reversed and scaled at once,
/// `u⁺ = −e u`. With `J` from velocities `V` to normal speeds, `u = J V`, the impulses along the
/// normals are `−(1 + e)(J M⁻¹ Jᵀ)⁻¹ u`; the energy lost is `½(1 − e²) uᵀ(J M⁻¹ Jᵀ)⁻¹ u`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Law {
    /// Restitution `e`, from 0 to 1; of a bumper more.
    pub restitution: f64,
    /// Coefficient of friction `μ`, zero or more.
    pub friction: f64,
    /// Tangential restitution `e_t`, from 0 to 1; zero without friction and at several contacts.
    pub tangential_restitution: f64,
    /// Tilt `t` of the normal that the impact sees: `n' = R_B·Exp(t0 a0 + t1 a1)·n_B`, with
    /// [`Contact::tilt_axes`](crate::physics::contact::Contact::tilt_axes). Gap and approach speed keep
    /// the face's own normal.
    pub tilt_rad: [f64; 2],
}

impl Law {
    /// A law with restitution only: no friction, no tilt.
    pub fn frictionless(restitution: f64) -> Self {
        Self {
            restitution,
            friction: 0.0,
            tangential_restitution: 0.0,
            tilt_rad: [0.0; 2],
        }
    }
}

/// A body that takes part, and its state just before.
#[derive(Clone, Copy, Debug)]
pub struct Side<'a> {
    /// Mass and moments.
    pub body: &'a Body,
    /// Its state before the impact.
    pub state: &'a State,
}

/// Velocities of a body.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Velocities {
    /// `v` [m/s, world].
    pub velocity_m_s: Vector3<f64>,
    /// `ω` [rad/s, body].
    pub angular_velocity_rad_s: Vector3<f64>,
}

impl Velocities {
    /// The velocities of a state.
    pub fn of(state: &State) -> Self {
        Self {
            velocity_m_s: state.velocity_m_s,
            angular_velocity_rad_s: state.angular_velocity_rad_s,
        }
    }

    /// A state in the pose of another one, with these velocities.
    pub fn in_pose_of(&self, state: &State) -> State {
        State {
            velocity_m_s: self.velocity_m_s,
            angular_velocity_rad_s: self.angular_velocity_rad_s,
            ..*state
        }
    }
}

/// The result of an impact. Entries beyond the number of contacts or bodies are zero.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Impact {
    /// Gap of each contact \[m\].
    pub gaps_m: [f64; MOST_CONTACTS],
    /// Speed of each contact along its untilted normal before [m/s]: the rate of the gap,
    /// negative approaching.
    pub speeds_m_s: [f64; MOST_CONTACTS],
    /// Impulse on A along each contact's tilted normal [N s]. A negative one pulls, which no
    /// contact can: the contact recedes, or others of several lift it off. The law is applied to it
    /// nevertheless.
    pub normal_impulses_n_s: [f64; MOST_CONTACTS],
    /// Velocities after the impact: of A, of B.
    pub after: [Velocities; 2],
    /// Whether the contact sticks (`κ = 1`); false without friction.
    pub sticks: bool,
}

impl Impact {
    /// Whether an impulse along a normal is negative, which no contact can exert.
    pub fn pulls(&self) -> bool {
        self.normal_impulses_n_s
            .iter()
            .any(|impulse| *impulse < 0.0)
    }
}
