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

use super::kinematics::Root;
use super::model::Tree;
use super::spatial::Motion;
use crate::math::so3;
use crate::physics::driven::Driven;

/// A body's motion that is given for all times.
pub trait Carrier: Debug + Send + Sync {
    /// Its state at a time \[s\], with accelerations.
    fn at(&self, time_s: f64) -> Driven;
}

/// The held body from which a tree hangs.
#[derive(Clone, Debug)]
pub struct Hand(pub(super) Arc<dyn Carrier>);

impl Hand {
    /// One that moves so.
    pub fn new(carrier: impl Carrier + 'static) -> Self {
        Self(Arc::new(carrier))
    }

    /// How it moves where a tree's first joint is.
    pub(super) fn anchor(&self, tree: &Tree, time_s: f64) -> Anchor {
        let Driven {
            state,
            acceleration_m_s2,
            angular_acceleration_rad_s2: spin_rate,
        } = self.0.at(time_s);
        let turn = so3::matrix(&state.orientation);
        let (arm_m, spin) = (&tree.anchor_m, state.angular_velocity_rad_s);
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

impl Anchor {
    /// How it moves in the tree's frame, in a field of gravity [m/s²].
    pub(super) fn root(&self, gravity_m_s2: &Vector3<f64>) -> Root {
        let linear = self.turn.tr_mul(&(self.acceleration_m_s2 - gravity_m_s2));
        Root {
            velocity: Motion {
                angular: self.spin_rad_s,
                linear: Vector3::zeros(),
            },
            acceleration: Motion {
                angular: self.spin_rate_rad_s2,
                linear,
            },
        }
    }
}
