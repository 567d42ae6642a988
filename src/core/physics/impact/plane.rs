//! The most common impact in closed form: one point of a body on a face of the static world,
//! without friction.
//!
//! With the contact point `p = c − r Rᵀn` in body axes (centre `c` and radius `r` of the feature)
//! and the lever `a = p × Rᵀn'` of the tilted normal `n'`,
//!
//! ```text
//! u' = n'·v + a·ω,   j = −(1 + e) u' / (1/m + aᵀ I⁻¹ a),   v⁺ = v + (j/m) n',   ω⁺ = ω + I⁻¹ a j
//! ```

use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

use super::contact_state::tilted;
use super::derivative::ImpactDerivative;
use super::inertia::InverseInertia;
use super::law::{Impact, Law, Side, Velocities};
use crate::math::so3;
use crate::physics::contact::{Contact, Feature};
use crate::physics::state::part;

/// A point of a body on a face of the world.
pub(super) struct PointOnPlane<'a> {
    centre: Vector3<f64>,
    radius: f64,
    face_point: Vector3<f64>,
    normal: Vector3<f64>,
    tilt_axes: &'a [Vector3<f64>; 2],
}

impl<'a> PointOnPlane<'a> {
    pub(super) fn of(contact: &'a Contact) -> Option<Self> {
        match (*contact.a(), *contact.b(), contact.tilt_axes()) {
            (
                Feature::Point { point_m, radius_m },
                Feature::Face {
                    point_m: face_point,
                    normal,
                },
                Some(tilt_axes),
            ) => Some(Self {
                centre: point_m,
                radius: radius_m,
                face_point,
                normal,
                tilt_axes,
            }),
            _ => None,
        }
    }

    /// The impact and those derivatives that belong to one body and one contact.
    pub(super) fn derivative(
        &self,
        side: &Side,
        law: &Law,
        derivative: &mut ImpactDerivative,
    ) -> Impact {
        let mut impact = Impact::default();
        self.approach(side, &mut impact, derivative);
        self.bounce(side, law, &mut impact, derivative);
        impact
    }

    /// Gap and speed along the face's own normal. The radius has no lever about it.
    fn approach(&self, side: &Side, impact: &mut Impact, derivative: &mut ImpactDerivative) {
        let state = side.state;
        let normal = &self.normal;
        let in_body = state.orientation.inverse_transform_vector(normal);
        let arm = self.centre.cross(&in_body);
        let omega = &state.angular_velocity_rad_s;
        let centre = state.position_m + state.orientation * self.centre;
        impact.gaps_m[0] = normal.dot(&(centre - self.face_point)) - self.radius;
        impact.speeds_m_s[0] = normal.dot(&state.velocity_m_s) + arm.dot(omega);

        let gap = &mut derivative.gap[0][0];
        gap.fill(0.0);
        gap.fixed_columns_mut::<3>(part::POSITION)
            .tr_copy_from(normal);
        gap.fixed_columns_mut::<3>(part::ORIENTATION)
            .tr_copy_from(&arm);
        // δa = c × (Rᵀn × δθ), dotted with ω.
        let by_turn = omega.cross(&self.centre).cross(&in_body);
        let speed = &mut derivative.speed[0][0];
        speed.fixed_columns_mut::<3>(part::POSITION).fill(0.0);
        speed
            .fixed_columns_mut::<3>(part::ORIENTATION)
            .tr_copy_from(&by_turn);
        speed
            .fixed_columns_mut::<3>(part::VELOCITY)
            .tr_copy_from(normal);
        speed
            .fixed_columns_mut::<3>(part::ANGULAR_VELOCITY)
            .tr_copy_from(&arm);
    }

    fn bounce(
        &self,
        side: &Side,
        law: &Law,
        impact: &mut Impact,
        derivative: &mut ImpactDerivative,
    ) {
        let state = side.state;
        let (normal, by_tilt) = tilted(&self.normal, self.tilt_axes, law);
        let InverseInertia {
            mass_per_kg: inverse_mass,
            moments_per_kg_m2: inverse_moments,
        } = InverseInertia::of(side);
        let in_body = state.orientation.inverse_transform_vector(&normal);
        let rounding = state.orientation.inverse_transform_vector(&self.normal) * self.radius;
        let point = self.centre - rounding;
        let arm = point.cross(&in_body);
        let turned = arm.component_mul(&inverse_moments);
        let omega = &state.angular_velocity_rad_s;
        let speed = normal.dot(&state.velocity_m_s) + arm.dot(omega);
        let inertia = inverse_mass + arm.dot(&turned);
        let factor = -(1.0 + law.restitution) / inertia;
        let impulse = factor * speed;
        impact.normal_impulses_n_s[0] = impulse;
        impact.after[0] = Velocities {
            velocity_m_s: state.velocity_m_s + normal * (impulse * inverse_mass),
            angular_velocity_rad_s: omega + turned * impulse,
        };

        // δa by δθ and by a tilt, then δj through δu' and through the effective inertia.
        let across = so3::hat(&in_body);
        let mut arm_by_turn = so3::hat(&point) * across;
        if self.radius != 0.0 {
            arm_by_turn += across * so3::hat(&rounding);
        }
        let impulse_by_arm = (omega - turned * (2.0 * speed / inertia)) * factor;
        let impulse_by_turn = arm_by_turn.tr_mul(&impulse_by_arm);

        let after = &mut derivative.after[0][0];
        after.fixed_columns_mut::<3>(part::POSITION).fill(0.0);
        let mut set = |row, column, block: Matrix3<f64>| {
            after.fixed_view_mut::<3, 3>(row, column).copy_from(&block);
        };
        let pushed = normal * inverse_mass;
        set(0, part::ORIENTATION, pushed * impulse_by_turn.transpose());
        set(
            0,
            part::VELOCITY,
            Matrix3::identity() + pushed * normal.transpose() * factor,
        );
        set(
            0,
            part::ANGULAR_VELOCITY,
            pushed * (arm * factor).transpose(),
        );
        set(
            3,
            part::ORIENTATION,
            Matrix3::from_diagonal(&(inverse_moments * impulse)) * arm_by_turn
                + turned * impulse_by_turn.transpose(),
        );
        set(3, part::VELOCITY, turned * (normal * factor).transpose());
        set(
            3,
            part::ANGULAR_VELOCITY,
            Matrix3::identity() + turned * (arm * factor).transpose(),
        );

        let velocity_change = |impulse: f64| stacked(&(pushed * impulse), &(turned * impulse));
        derivative.after_by_restitution[0] = velocity_change(-speed / inertia);
        derivative.after_by_friction[0].fill(0.0);
        derivative.after_by_tangential_restitution[0].fill(0.0);
        for (tilt, normal_change) in by_tilt.iter().enumerate() {
            let arm_change =
                point.cross(&state.orientation.inverse_transform_vector(normal_change));
            let change =
                factor * normal_change.dot(&state.velocity_m_s) + impulse_by_arm.dot(&arm_change);
            let redirected = stacked(
                &(normal_change * (impulse * inverse_mass)),
                &(arm_change.component_mul(&inverse_moments) * impulse),
            );
            derivative.after_by_tilt[0].set_column(tilt, &(velocity_change(change) + redirected));
        }
    }
}

fn stacked(velocity: &Vector3<f64>, spin: &Vector3<f64>) -> SVector<f64, 6> {
    SMatrix::from_row_slice(&[velocity.x, velocity.y, velocity.z, spin.x, spin.y, spin.z])
}
