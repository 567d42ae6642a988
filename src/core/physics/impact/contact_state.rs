//! One contact in given poses: its points in both bodies' axes and its tilted normal.

use nalgebra::{Matrix3, SMatrix, Vector3};

use super::law::{Law, Velocities};
use super::rows::Change;
use crate::math::so3;
use crate::physics::contact::{Contact, Touch, TouchDerivative};

/// A contact with its points and the tilted normal of the impact.
pub(super) struct ContactState<'a> {
    pub(super) contact: &'a Contact,
    pub(super) touch: Touch,
    /// World from body.
    rotations: [Matrix3<f64>; 2],
    /// The tilted normal [world].
    pub(super) normal: Vector3<f64>,
    /// Derivatives of the tilted normal by the tilts; `None` where it cannot be tilted.
    pub(super) normal_by_tilt: Option<[Vector3<f64>; 2]>,
}

/// Changes of a contact's geometry with the poses.
pub(super) struct PoseChange<const C: usize> {
    /// Change of the untilted normal [world].
    pub(super) normal: Change<C>,
    /// Changes of the points [m, body].
    pub(super) points: [Change<C>; 2],
    /// The body that moves, and its rotation [rad, body].
    pub(super) turn: Option<(usize, Change<C>)>,
}

impl PoseChange<6> {
    /// Changes by position and orientation of one body.
    pub(super) fn of_body(body: usize, rates: &TouchDerivative) -> Self {
        let columns = |rate: &SMatrix<f64, 3, 12>| -> Change<6> {
            rate.fixed_columns::<6>(6 * body).into_owned()
        };
        let mut turn = Change::<6>::zeros();
        turn.fixed_columns_mut::<3>(3).fill_diagonal(1.0);
        Self {
            normal: columns(&rates.normal),
            points: [columns(&rates.on_a), columns(&rates.on_b)],
            turn: Some((body, turn)),
        }
    }
}

impl PoseChange<3> {
    /// Changes by a shift of one body's feature [m, its axes]. Gap and normal change as if the whole
    /// body were displaced; but its centre of mass stays, so that its point moves with the feature.
    pub(super) fn of_shift(body: usize, rates: &TouchDerivative, rotation: &Matrix3<f64>) -> Self {
        let columns = |rate: &SMatrix<f64, 3, 12>| -> Change<3> {
            rate.fixed_columns::<3>(6 * body) * rotation
        };
        let mut points = [columns(&rates.on_a), columns(&rates.on_b)];
        points[body] += Matrix3::identity();
        Self {
            normal: columns(&rates.normal),
            points,
            turn: None,
        }
    }
}

impl<const C: usize> PoseChange<C> {
    /// No change.
    pub(super) fn none() -> Self {
        Self {
            normal: Change::zeros(),
            points: [Change::zeros(); 2],
            turn: None,
        }
    }
}

impl<'a> ContactState<'a> {
    pub(super) fn new(
        contact: &'a Contact,
        touch: Touch,
        rotations: [Matrix3<f64>; 2],
        law: &Law,
    ) -> Self {
        let (normal, normal_by_tilt) = match contact.tilt_axes() {
            Some(axes) => {
                let axes = axes.map(|axis| rotations[1] * axis);
                let (normal, by_tilt) = tilted(&touch.normal, &axes, law);
                (normal, Some(by_tilt))
            }
            None => (touch.normal, None),
        };
        Self {
            contact,
            touch,
            rotations,
            normal,
            normal_by_tilt,
        }
    }

    fn point(&self, body: usize) -> &Vector3<f64> {
        [&self.touch.on_a_m, &self.touch.on_b_m][body]
    }

    /// Speed along the untilted normal [m/s].
    pub(super) fn speed(&self, motion: &[Velocities; 2]) -> f64 {
        let normal = &self.touch.normal;
        let levers = self.levers(normal);
        normal.dot(&(motion[0].velocity_m_s - motion[1].velocity_m_s))
            + levers[0].dot(&motion[0].angular_velocity_rad_s)
            - levers[1].dot(&motion[1].angular_velocity_rad_s)
    }

    /// Levers `p × Rᵀd` of a direction `d` [world] about both centres of mass [m, body].
    pub(super) fn levers(&self, direction: &Vector3<f64>) -> [Vector3<f64>; 2] {
        [0, 1].map(|body| {
            self.point(body)
                .cross(&self.rotations[body].tr_mul(direction))
        })
    }

    /// Change of the lever of a direction about `body`; the direction changes too where its change
    /// is given.
    pub(super) fn lever_change<const C: usize>(
        &self,
        body: usize,
        direction: &Vector3<f64>,
        direction_change: Option<&Change<C>>,
        by: &PoseChange<C>,
    ) -> Change<C> {
        let in_body = self.rotations[body].tr_mul(direction);
        let arm = so3::hat(self.point(body));
        let across = so3::hat(&in_body);
        let mut result = -across * by.points[body];
        if let Some(change) = direction_change {
            result += arm * self.rotations[body].transpose() * change;
        }
        if let Some((_, turn)) = by.turn.as_ref().filter(|(moved, _)| *moved == body) {
            result += arm * across * turn;
        }
        result
    }

    /// Change of the tilted normal, which rotates with B's face.
    pub(super) fn normal_change<const C: usize>(&self, by: &PoseChange<C>) -> Change<C> {
        match (&self.normal_by_tilt, &by.turn) {
            (Some(_), Some((1, turn))) => -so3::hat(&self.normal) * self.rotations[1] * turn,
            (Some(_), _) => Change::zeros(),
            (None, _) => by.normal,
        }
    }
}

/// The normal rotated by the law's tilt about these axes [world], with its derivatives by the
/// tilts.
pub(crate) fn tilted(
    normal: &Vector3<f64>,
    axes: &[Vector3<f64>; 2],
    law: &Law,
) -> (Vector3<f64>, [Vector3<f64>; 2]) {
    if law.tilt_rad == [0.0; 2] {
        return (*normal, axes.map(|axis| axis.cross(normal)));
    }
    let tilt = axes[0] * law.tilt_rad[0] + axes[1] * law.tilt_rad[1];
    let (turn, left) = so3::exp_and_left_jacobian(&tilt);
    let tilted = turn * normal;
    (tilted, axes.map(|axis| (left * axis).cross(&tilted)))
}
