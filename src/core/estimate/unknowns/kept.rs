//! Free rotations of bodies with three different moments, whose steps serve samples, collisions and curvature at one point.

use std::cell::RefCell;

use nalgebra::Vector3;

use crate::physics::flow::{Spin, Steps, Turns};
use crate::physics::{Body, State};

/// How many are kept: of each flight of a usual take one, and of one that is displaced.
const MOST: usize = 32;

/// Steps of free rotations, kept from one use to the next. They depend on nothing but body and spin: who asks first does not
/// matter, and what is cloned or compared has none.
#[derive(Debug, Default)]
pub struct KeptSteps(RefCell<Vec<Steps>>);

impl KeptSteps {
    /// The steps of a body with an angular velocity [rad/s, body], those that are kept or new ones; none where two or three
    /// moments are equal.
    fn take(&self, body: &Body, angular_velocity_rad_s: &Vector3<f64>) -> Option<Steps> {
        let mut kept = self.0.borrow_mut();
        let place = kept
            .iter()
            .position(|of| of.are_of(body, angular_velocity_rad_s));
        match place {
            Some(place) => Some(kept.remove(place)),
            None => Steps::needed(body, angular_velocity_rad_s),
        }
    }

    /// What is told by the turns of a state, whose steps are kept for the next use.
    pub(in crate::estimate) fn with_turns<T>(
        &self,
        body: &Body,
        state: &State,
        tell: impl FnOnce(&mut Turns) -> T,
    ) -> T {
        let omega = &state.angular_velocity_rad_s;
        let steps = self.take(body, omega);
        let mut turns = Turns::with_steps(body, &state.orientation, omega, steps);
        let told = tell(&mut turns);
        self.keep(turns.into_steps());
        told
    }

    /// A spin, whose steps are kept for the next use.
    pub(in crate::estimate) fn spin(
        &self,
        body: &Body,
        angular_velocity_rad_s: &Vector3<f64>,
    ) -> KeptSpin<'_> {
        let steps = self.take(body, angular_velocity_rad_s);
        KeptSpin {
            kept: self,
            spin: Spin::with_steps(body, angular_velocity_rad_s, steps),
        }
    }

    /// Keeps them, in place of those that nobody asked for the longest if there are too many.
    fn keep(&self, steps: Option<Steps>) {
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

/// A spin whose steps are kept when it is no longer used.
pub(in crate::estimate) struct KeptSpin<'k> {
    kept: &'k KeptSteps,
    pub(in crate::estimate) spin: Spin,
}

impl Drop for KeptSpin<'_> {
    fn drop(&mut self) {
        self.kept.keep(self.spin.take_steps());
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
