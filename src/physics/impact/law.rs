//! What an impact takes, the law and the sides, and what it does.

use nalgebra::Vector3;

use crate::physics::body::Body;
use crate::physics::state::State;

/// Most contacts at once.
pub(super) const MOST_CONTACTS: usize = 3;

/// How an impact goes.
///
/// At one contact: the algebraic law of Chatterjee and Ruina ("A new algebraic rigid-body
/// collision law based on impulse space considerations", Journal of Applied Mechanics 65, 1998)
/// without tangential restitution. With the contact points' relative velocity `v`, the normal
/// `n`, `u = n·v` and Delassus' operator `W` (relative velocity per impulse), the impulse on A is
///
/// ```text
/// P = (1 + e) P_I + κ (P_II − P_I),   P_I = −u/(n·W n) n,   P_II = −W⁻¹ v
/// ```
///
/// with `κ = 1` where that lies in the friction cone `|P − (n·P) n| ≤ μ n·P` (the contact
/// sticks), else the `κ` in `[0, 1)` that puts it on the cone (it slides). What holds, for
/// approaching contacts, `0 ≤ e ≤ 1` and `μ ≥ 0`: Newton's rule `u⁺ = −e u` exactly, with
/// friction as without, since `n·W (P_II − P_I) = 0`; energy lost is
/// `½(1 − e²) P_I·W P_I + ½κ(2 − κ) D·W D ≥ 0` with `D = P_II − P_I`; the impulse is in the
/// cone and pushes; `μ = 0` is the frictionless bounce. A contact that sticks keeps
/// `v⁺ = e W P_I`: nothing at `e = 0`, and along the normal only where `W n` is (a ball, a body
/// that lands above its centre of mass); elsewhere the rebound itself swings it sideways.
/// Where sticking turns to sliding the velocities are continuous.
///
/// At several contacts, without friction: every normal speed is reversed and scaled at once,
/// `u⁺ = −e u`. With `J` from velocities to normal speeds the impulses along the normals are
/// `−(1 + e)(J M⁻¹ Jᵀ)⁻¹ J V`; energy lost is `½(1 − e²)` of the quadratic form of `u`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Law {
    /// Restitution `e`, from 0 to 1.
    pub restitution: f64,
    /// Coefficient of friction `μ`, zero or more.
    pub friction: f64,
    /// Tilt `t` of the normal that the impact sees: `n' = R_B·Exp(t0 a0 + t1 a1)·n_B`, with
    /// [`Contact::tilt_axes`](crate::physics::contact::Contact::tilt_axes). Gap and approach speed keep
    /// the face's own normal.
    pub tilt_rad: [f64; 2],
}

impl Law {
    /// Restitution alone.
    pub fn frictionless(restitution: f64) -> Self {
        Self {
            restitution,
            friction: 0.0,
            tilt_rad: [0.0; 2],
        }
    }
}

/// A body that takes part, and its state just before.
#[derive(Clone, Copy, Debug)]
pub struct Side<'a> {
    /// Mass and moments.
    pub body: &'a Body,
    /// State.
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
    /// A state's.
    pub fn of(state: &State) -> Self {
        Self {
            velocity_m_s: state.velocity_m_s,
            angular_velocity_rad_s: state.angular_velocity_rad_s,
        }
    }
}

/// What an impact does. Entries beyond the number of contacts or bodies are zero.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Impact {
    /// Gap of each contact \[m\].
    pub gaps_m: [f64; MOST_CONTACTS],
    /// Speed of each contact along its untilted normal before [m/s]: the rate of the gap,
    /// negative approaching.
    pub speeds_m_s: [f64; MOST_CONTACTS],
    /// Impulse on A along each contact's normal, as tilted [N s]. A negative one would have to
    /// pull: a contact that recedes, or one of several that the others lift off. The rule above
    /// is applied to it all the same.
    pub normal_impulses_n_s: [f64; MOST_CONTACTS],
    /// Velocities after: A's, B's.
    pub after: [Velocities; 2],
    /// Whether friction stops the sliding; never without friction.
    pub sticks: bool,
}

impl Impact {
    /// Whether a contact would have to pull.
    pub fn pulls(&self) -> bool {
        self.normal_impulses_n_s
            .iter()
            .any(|impulse| *impulse < 0.0)
    }
}
