//! How a body bounces: one point contact, restitution, no friction; with its derivatives.
//!
//! With the contact point `p` in body axes, the unit normal `n` out of the surface and
//! `c = p × Rᵀn`, the normal speed of the contact point is `u = n·v + c·ω`, and
//!
//! ```text
//! j = −(1 + e) u / (1/m + cᵀ I⁻¹ c),   v⁺ = v + (j/m) n,   ω⁺ = ω + I⁻¹ c j
//! ```
//!
//! so that `u⁺ = −e u`. With `e > 0` the map inverts: bounce again with `1/e`.

use nalgebra::{Matrix3, SMatrix, Vector3};

use crate::math::so3;
use crate::physics::body::Body;
use crate::physics::state::State;

/// One contact of a body's point with a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// `p`, the point of the body that touches [m, body].
    pub point_m: Vector3<f64>,
    /// A point of the surface [m, world].
    pub surface_point_m: Vector3<f64>,
    /// Unit normal of the surface \[world\].
    pub surface_normal: Vector3<f64>,
}

impl Contact {
    /// Distance `φ` of the contact point from the surface \[m\]; negative inside.
    pub fn gap_m(&self, state: &State) -> f64 {
        self.surface_normal
            .dot(&(state.position_m + state.orientation * self.point_m - self.surface_point_m))
    }

    /// `c = p × Rᵀn` for a normal `n`: the change of `φ` \[m\] per turn [rad, body], and the arm
    /// of an impulse along `n` [m, body].
    pub fn arm_m(&self, state: &State, normal: &Vector3<f64>) -> Vector3<f64> {
        self.point_m
            .cross(&state.orientation.inverse_transform_vector(normal))
    }

    /// Speed `u` of the contact point along the surface's normal [m/s]; negative approaching.
    pub fn normal_speed_m_s(&self, state: &State) -> f64 {
        self.surface_normal.dot(&state.velocity_m_s)
            + self
                .arm_m(state, &self.surface_normal)
                .dot(&state.angular_velocity_rad_s)
    }
}

/// State just after the bounce along `normal` (the surface's, or one tilted from it).
pub fn bounce(
    body: &Body,
    contact: &Contact,
    normal: &Vector3<f64>,
    restitution: f64,
    before: &State,
) -> State {
    let arm = contact.arm_m(before, normal);
    let turned = arm.component_div(&body.moments_kg_m2());
    let speed = normal.dot(&before.velocity_m_s) + arm.dot(&before.angular_velocity_rad_s);
    let impulse_n_s = -(1.0 + restitution) * speed / (1.0 / body.mass_kg() + arm.dot(&turned));
    State {
        velocity_m_s: before.velocity_m_s + normal * (impulse_n_s / body.mass_kg()),
        angular_velocity_rad_s: before.angular_velocity_rad_s + turned * impulse_n_s,
        ..*before
    }
}

/// Derivatives of the velocities after a bounce: rows `v⁺` [m/s, world], `ω⁺` [rad/s, body].
#[derive(Clone, Copy, Debug)]
pub struct BounceDerivative {
    /// By orientation, velocity and angular velocity before (nine columns in this order).
    pub by_state: SMatrix<f64, 6, 9>,
    /// By the normal, as a free vector \[world\].
    pub by_normal: SMatrix<f64, 6, 3>,
    /// By the restitution.
    pub by_restitution: SMatrix<f64, 6, 1>,
}

/// Derivatives of [`bounce`].
pub fn bounce_derivative(
    body: &Body,
    contact: &Contact,
    normal: &Vector3<f64>,
    restitution: f64,
    before: &State,
) -> BounceDerivative {
    let inverse_mass = 1.0 / body.mass_kg();
    let inverse_moments = body.moments_kg_m2().map(|moment| 1.0 / moment);
    let normal_in_body = before.orientation.inverse_transform_vector(normal);
    let arm = contact.point_m.cross(&normal_in_body);
    let turned = arm.component_mul(&inverse_moments);
    let omega = &before.angular_velocity_rad_s;
    let speed = normal.dot(&before.velocity_m_s) + arm.dot(omega);
    let inertia = inverse_mass + arm.dot(&turned);
    let factor = -(1.0 + restitution) / inertia;
    let impulse = factor * speed;

    // δc by δθ and by δn, then δj through δu and through the effective inertia.
    let point = so3::hat(&contact.point_m);
    let arm_by_orientation = point * so3::hat(&normal_in_body);
    let arm_by_normal = point * so3::matrix(&before.orientation).transpose();
    let impulse_by_arm = (omega - turned * (2.0 * speed / inertia)) * factor;
    let impulse_by_orientation = arm_by_orientation.tr_mul(&impulse_by_arm);
    let impulse_by_normal = before.velocity_m_s * factor + arm_by_normal.tr_mul(&impulse_by_arm);

    let spread = |arm_change: &Matrix3<f64>, impulse_change: &Vector3<f64>| -> Matrix3<f64> {
        Matrix3::from_diagonal(&inverse_moments) * arm_change * impulse
            + turned * impulse_change.transpose()
    };
    let mut by_state = SMatrix::<f64, 6, 9>::zeros();
    let mut set = |row, column, block: Matrix3<f64>| {
        by_state
            .fixed_view_mut::<3, 3>(row, column)
            .copy_from(&block);
    };
    set(
        0,
        0,
        normal * impulse_by_orientation.transpose() * inverse_mass,
    );
    set(
        0,
        3,
        Matrix3::identity() + normal * normal.transpose() * (factor * inverse_mass),
    );
    set(0, 6, normal * arm.transpose() * (factor * inverse_mass));
    set(3, 0, spread(&arm_by_orientation, &impulse_by_orientation));
    set(3, 3, turned * normal.transpose() * factor);
    set(
        3,
        6,
        Matrix3::identity() + turned * arm.transpose() * factor,
    );

    let mut by_normal = SMatrix::<f64, 6, 3>::zeros();
    by_normal.fixed_view_mut::<3, 3>(0, 0).copy_from(
        &((Matrix3::identity() * impulse + normal * impulse_by_normal.transpose()) * inverse_mass),
    );
    by_normal
        .fixed_view_mut::<3, 3>(3, 0)
        .copy_from(&spread(&arm_by_normal, &impulse_by_normal));

    let mut by_restitution = SMatrix::<f64, 6, 1>::zeros();
    by_restitution
        .fixed_rows_mut::<3>(0)
        .copy_from(&(normal * (-speed / inertia * inverse_mass)));
    by_restitution
        .fixed_rows_mut::<3>(3)
        .copy_from(&(turned * (-speed / inertia)));
    BounceDerivative {
        by_state,
        by_normal,
        by_restitution,
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::UnitQuaternion;

    use super::*;
    use crate::math::differentiate;
    use crate::physics::state::StateTangent;

    fn setting() -> (Body, Contact, State) {
        let body = Body::new(0.006, Vector3::new(1.8e-5, 1.8e-5, 4e-8)).unwrap();
        let contact = Contact {
            point_m: Vector3::new(0.001, -0.002, -0.095),
            surface_point_m: Vector3::new(0.3, 0.1, 0.02),
            surface_normal: Vector3::new(0.1, -0.2, 1.0).normalize(),
        };
        let state = State {
            position_m: Vector3::new(0.1, -0.2, 0.1),
            orientation: UnitQuaternion::from_euler_angles(0.4, -0.3, 2.0),
            velocity_m_s: Vector3::new(0.5, 0.2, -2.0),
            angular_velocity_rad_s: Vector3::new(3.0, -7.0, 20.0),
        };
        (body, contact, state)
    }

    fn energy(body: &Body, state: &State) -> f64 {
        let omega = state.angular_velocity_rad_s;
        0.5 * body.mass_kg() * state.velocity_m_s.norm_squared()
            + 0.5 * body.moments_kg_m2().dot(&omega.component_mul(&omega))
    }

    #[test]
    fn normal_speed_is_reversed_and_scaled() {
        let (body, contact, before) = setting();
        for restitution in [0.0, 0.4, 1.0] {
            let after = bounce(
                &body,
                &contact,
                &contact.surface_normal,
                restitution,
                &before,
            );
            let (u, w) = (
                contact.normal_speed_m_s(&before),
                contact.normal_speed_m_s(&after),
            );
            assert!(u < 0.0 && (w + restitution * u).abs() < 1e-14);
        }
    }

    #[test]
    fn elastic_bounce_conserves_energy_and_an_inelastic_one_loses_it() {
        let (body, contact, before) = setting();
        let energy_after = |e| {
            energy(
                &body,
                &bounce(&body, &contact, &contact.surface_normal, e, &before),
            )
        };
        let e0 = energy(&body, &before);
        assert!((energy_after(1.0) - e0).abs() < 1e-15 * e0.max(1.0));
        assert!(energy_after(0.5) < e0 && energy_after(0.0) < energy_after(0.5));
    }

    #[test]
    fn angular_momentum_about_the_contact_point_is_conserved() {
        let (body, contact, before) = setting();
        let momentum = |s: &State| {
            let spin = s.orientation
                * body
                    .moments_kg_m2()
                    .component_mul(&s.angular_velocity_rad_s);
            spin - (s.orientation * contact.point_m).cross(&(s.velocity_m_s * body.mass_kg()))
        };
        let after = bounce(&body, &contact, &contact.surface_normal, 0.7, &before);
        assert!((momentum(&before) - momentum(&after)).norm() < 1e-16);
    }

    #[test]
    fn bouncing_back_with_the_inverse_restitution_undoes_it() {
        let (body, contact, before) = setting();
        let after = bounce(&body, &contact, &contact.surface_normal, 0.6, &before);
        let back = bounce(&body, &contact, &contact.surface_normal, 1.0 / 0.6, &after);
        assert!(back.minus(&before).norm() < 1e-13);
    }

    #[test]
    fn derivatives_are_exact() {
        let (body, contact, before) = setting();
        let normal = Vector3::new(0.15, -0.1, 1.0).normalize();
        let exact = bounce_derivative(&body, &contact, &normal, 0.6, &before);
        let velocities = |s: &State| {
            let (v, w) = (s.velocity_m_s, s.angular_velocity_rad_s);
            vec![v.x, v.y, v.z, w.x, w.y, w.z]
        };
        let numeric = differentiate::jacobian(6, 16, |d| {
            let moved = before.retract(&StateTangent::from_column_slice(&d[..12]));
            let tilted = normal + Vector3::new(d[12], d[13], d[14]);
            velocities(&bounce(&body, &contact, &tilted, 0.6 + d[15], &moved))
        });
        for i in 0..6 {
            for j in 0..16 {
                let expected = match j {
                    0..3 => 0.0,
                    3..12 => exact.by_state[(i, j - 3)],
                    12..15 => exact.by_normal[(i, j - 12)],
                    _ => exact.by_restitution[i],
                };
                let difference = (numeric[i][j] - expected).abs();
                assert!(
                    difference < 1e-7 * (1.0 + expected.abs()),
                    "{i} {j} {difference}"
                );
            }
        }
    }

    #[test]
    fn arm_is_the_derivative_of_the_gap() {
        let (_, contact, before) = setting();
        let arm = contact.arm_m(&before, &contact.surface_normal);
        let numeric = differentiate::jacobian(1, 6, |d| {
            let mut delta = StateTangent::zeros();
            delta.as_mut_slice()[..6].copy_from_slice(d);
            vec![contact.gap_m(&before.retract(&delta))]
        });
        for i in 0..3 {
            assert!((numeric[0][i] - contact.surface_normal[i]).abs() < 1e-10);
            assert!((numeric[0][3 + i] - arm[i]).abs() < 1e-10);
        }
    }
}
