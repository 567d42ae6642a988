//! The point of a body that touches, with its derivatives.

use nalgebra::{SMatrix, Vector3};

use crate::physics::State;
use crate::physics::contact::{Contact, Feature, Frame, Touch, TouchDerivative};

/// A touch with its derivatives, as to the body that is meant.
pub(in crate::estimate) struct TouchedPoint {
    /// [m, body axes].
    pub(in crate::estimate) point_m: Vector3<f64>,
    /// Derivative by the pose of the body, and of what it touches.
    pub(in crate::estimate) by: [SMatrix<f64, 3, 6>; 2],
    /// The point of the face that is touched [m, axes of what it touches].
    pub(super) face_m: Vector3<f64>,
}

impl TouchedPoint {
    /// Where a contact is at states of the body, which is on this side of it, and of what it touches, if that is a body;
    /// `None` where it is degenerate.
    pub(in crate::estimate) fn new(
        contact: &Contact,
        own: usize,
        states: &[State],
    ) -> Option<Self> {
        let frame = |index: usize| states.get(index).map_or_else(Frame::world, Frame::of);
        let other = 1 - own;
        let [a, b] = if own == 0 {
            [frame(0), frame(1)]
        } else {
            [frame(1), frame(0)]
        };
        let (touch, derivative): (Touch, TouchDerivative) =
            contact.touch_derivative(&a, &b).ok()?;
        let (point_m, by) = if own == 0 {
            (touch.on_a_m, derivative.on_a)
        } else {
            (touch.on_b_m, derivative.on_b)
        };
        let side = |side: usize| by.fixed_columns::<6>(6 * side).into_owned();
        let face_m = match contact.b() {
            Feature::Face { point_m, .. } => *point_m,
            _ => Vector3::zeros(),
        };
        Some(Self {
            point_m,
            by: [side(own), side(other)],
            face_m,
        })
    }
}
