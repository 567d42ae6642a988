//! Bodies that meet: the law of their impact and what follows from it.

use nalgebra::Vector3;

use super::derivative::ImpactDerivative;
use super::error::{ContactSetError, ImpactError};
use super::plane;
use super::solution::Solution;
use crate::physics::body::Body;
use crate::physics::contact::Contact;
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
    /// [`Contact::tilt_axes`]. Gap and approach speed keep the face's own normal.
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

/// One to three contacts at which a body A meets a body B or the static world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactSet {
    contacts: [Contact; MOST_CONTACTS],
    count: usize,
    has_friction: bool,
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

impl ContactSet {
    /// One to three contacts without friction.
    pub fn frictionless(contacts: &[Contact]) -> Result<Self, ContactSetError> {
        let count = contacts.len();
        let Some(first) = contacts.first().filter(|_| count <= MOST_CONTACTS) else {
            return Err(ContactSetError::Count { count });
        };
        let mut all = [*first; MOST_CONTACTS];
        all[..count].copy_from_slice(contacts);
        Ok(Self {
            contacts: all,
            count,
            has_friction: false,
        })
    }

    /// One contact with friction, whose coefficient may be zero. More are refused.
    pub fn with_friction(contacts: &[Contact]) -> Result<Self, ContactSetError> {
        let meeting = Self::frictionless(contacts)?;
        if meeting.count > 1 {
            return Err(ContactSetError::FrictionAtSeveral {
                count: meeting.count,
            });
        }
        Ok(Self {
            has_friction: true,
            ..meeting
        })
    }

    /// Its contacts.
    pub fn contacts(&self) -> &[Contact] {
        &self.contacts[..self.count]
    }

    /// Whether friction is part of it.
    pub fn has_friction(&self) -> bool {
        self.has_friction
    }

    /// Whether its normals may be tilted: only where each touches a face of B.
    pub fn check_tilt(&self) -> Result<(), ContactSetError> {
        for (contact, pair) in self.contacts().iter().enumerate() {
            if pair.tilt_axes().is_none() {
                let kind = pair.b().kind();
                return Err(ContactSetError::Tilt { contact, kind });
            }
        }
        Ok(())
    }

    /// The impact of A with B, or with the static world.
    ///
    /// Fails where a contact is degenerate or the contacts depend on each other. A contact that
    /// recedes is treated by the same formulas without friction, so that a solver's iterates
    /// have an answer. Panics where the law has friction or tilt that the meeting has not.
    pub fn impact(&self, a: &Side, b: Option<&Side>, law: &Law) -> Result<Impact, ImpactError> {
        self.check_law(law);
        Ok(Solution::new(self, a, b, law)?.impact())
    }

    /// [`ContactSet::impact`] and its derivatives, into `derivative`: its entries for the contacts
    /// and bodies that there are, all others stay as they were.
    pub fn derivative(
        &self,
        a: &Side,
        b: Option<&Side>,
        law: &Law,
        derivative: &mut ImpactDerivative,
    ) -> Result<Impact, ImpactError> {
        self.check_law(law);
        if b.is_none()
            && !self.has_friction
            && let [contact] = self.contacts()
            && let Some(point) = plane::PointOnPlane::of(contact)
        {
            return Ok(point.derivative(a, law, derivative));
        }
        let solution = Solution::new(self, a, b, law)?;
        solution.derivative(derivative)?;
        Ok(solution.impact())
    }

    fn check_law(&self, law: &Law) {
        assert!(
            self.has_friction || law.friction == 0.0,
            "friction in a meeting without"
        );
        assert!(
            law.tilt_rad == [0.0; 2] || self.check_tilt().is_ok(),
            "a tilt where no face is touched"
        );
    }
}
