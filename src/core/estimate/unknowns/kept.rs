//! Free rotations of bodies with three different moments, whose steps serve samples, collisions and curvature at one point.

use std::cell::RefCell;

use nalgebra::Vector3;

use crate::physics::Body;
use crate::physics::flow::{Spin, Steps};

/// How many are kept: of each flight of a usual take one, and of one that is displaced.
const MOST: usize = 32;

/// Steps of free rotations, kept from one use to the next. They depend on nothing but body and spin: who asks first does not
/// matter, and what is cloned or compared has none.
#[derive(Debug, Default)]
pub struct KeptSteps(RefCell<Vec<Steps>>);

impl KeptSteps {
    /// The steps of a body with an angular velocity [rad/s, body], those that are kept or new ones; none where two or three
    /// moments are equal.
    pub(in crate::estimate) fn take(
        &self,
        body: &Body,
        angular_velocity_rad_s: &Vector3<f64>,
    ) -> Option<Steps> {
        let mut kept = self.0.borrow_mut();
        let place = kept
            .iter()
            .position(|of| of.are_of(body, angular_velocity_rad_s));
        match place {
            Some(place) => Some(kept.remove(place)),
            None => Steps::needed(body, angular_velocity_rad_s),
        }
    }

    /// The same as a spin.
    pub(in crate::estimate) fn spin(
        &self,
        body: &Body,
        angular_velocity_rad_s: &Vector3<f64>,
    ) -> Spin {
        let steps = self.take(body, angular_velocity_rad_s);
        Spin::with_steps(body, angular_velocity_rad_s, steps)
    }

    /// Keeps them, in place of those that nobody asked for the longest if there are too many.
    pub(in crate::estimate) fn keep(&self, steps: Option<Steps>) {
        let mut kept = self.0.borrow_mut();
        kept.extend(steps);
        if kept.len() > MOST {
            kept.remove(0);
        }
    }

    /// Forgets all: the spins are others.
    pub(super) fn clear(&mut self) {
        self.0.get_mut().clear();
    }
}

impl Clone for KeptSteps {
    fn clone(&self) -> Self {
        Self::default()
    }
}

impl PartialEq for KeptSteps {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}
