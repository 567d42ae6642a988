//! What a tree in the hand hangs from: a body whose motion is given.
//!
//! The frame of such a tree is, at each instant, the one that does not turn, flies as fast as the first joint's anchor
//! and has the held body's axes `R`. There the hand has its angular velocity `ω` and acceleration `ω̇`, no velocity at the
//! anchor `p` (Galilei), and its acceleration less gravity,
//!
//! ```text
//! Rᵀ (a − g) + ω̇ × p + ω × (ω × p)
//! ```

use std::fmt::Debug;
use std::sync::Arc;

use nalgebra::{Matrix3, Vector3};

use crate::math::so3;
use crate::physics::driven::Driven;

/// A body's motion that is given for all times.
pub trait Carrier: Debug + Send + Sync {
    /// Its state at a time \[s\], with accelerations.
    fn at(&self, time_s: f64) -> Driven;

    /// The first time beyond one, later or earlier \[s\], at which the accelerations go on, but not smoothly: a step of an
    /// integrator must end there. None of a motion that is smooth.
    fn next_kink_s(&self, _from_s: f64, _is_later: bool) -> Option<f64> {
        None
    }
}

/// Kinks that are nearer than this are one \[s\].
const APART_S: f64 = 1e-9;

/// The held body from which a tree hangs.
#[derive(Clone, Debug)]
pub struct Hand(pub(super) Arc<dyn Carrier>);

impl Hand {
    /// One that moves so.
    pub fn new(carrier: impl Carrier + 'static) -> Self {
        Self(Arc::new(carrier))
    }

    /// The step from a time towards an end \[s\]: one of equal ones, not longer than `most_s`, to the next kink or to the end.
    pub(super) fn step_s(&self, from_s: f64, end_s: f64, most_s: f64) -> f64 {
        let is_later = most_s >= 0.0;
        let beyond_s = from_s + APART_S.copysign(most_s);
        let kink_s = self.0.next_kink_s(beyond_s, is_later);
        let until_s = kink_s.map_or(end_s, |kink_s| match is_later {
            true => kink_s.min(end_s),
            false => kink_s.max(end_s),
        });
        let left_s = until_s - from_s;
        match left_s.is_finite() {
            // What rounding adds is no further step.
            true => left_s / (left_s / most_s - 1e-6).ceil().max(1.0),
            false => most_s,
        }
    }

    /// How long it moves smoothly about a time \[s\].
    pub(super) fn smooth_s(&self, time_s: f64) -> f64 {
        let next_s = |from_s: f64| self.0.next_kink_s(from_s + APART_S, true);
        let first_s = next_s(time_s);
        let second_s = first_s.and_then(next_s);
        first_s.zip(second_s).map_or(f64::INFINITY, |(a, b)| b - a)
    }

    /// How it moves where a tree's first joint is [m, held body].
    pub(super) fn anchor(&self, arm_m: &Vector3<f64>, time_s: f64) -> Anchor {
        let Driven {
            state,
            acceleration_m_s2,
            angular_acceleration_rad_s2: spin_rate,
        } = self.0.at(time_s);
        let turn = so3::matrix(&state.orientation);
        let spin = state.angular_velocity_rad_s;
        let swing = spin.cross(arm_m);
        let lever = spin_rate.cross(arm_m) + spin.cross(&swing);
        Anchor {
            turn,
            position_m: state.position_m + turn * arm_m,
            velocity_m_s: state.velocity_m_s + turn * swing,
            acceleration_m_s2: acceleration_m_s2 + turn * lever,
            spin_rad_s: spin,
            spin_rate_rad_s2: spin_rate,
        }
    }
}

/// Of the same motion, not of one that is alike.
impl PartialEq for Hand {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

/// How the held body moves where the first joint is, at one instant.
#[derive(Clone, Debug)]
pub(super) struct Anchor {
    /// World from the held body.
    pub turn: Matrix3<f64>,
    /// In the world.
    pub position_m: Vector3<f64>,
    pub velocity_m_s: Vector3<f64>,
    pub acceleration_m_s2: Vector3<f64>,
    /// In the held body's axes.
    pub spin_rad_s: Vector3<f64>,
    pub spin_rate_rad_s2: Vector3<f64>,
}
