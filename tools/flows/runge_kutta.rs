//! The classic Runge–Kutta method of fourth order on the turn and its variational equations,
//! with fixed steps: what a general simulator would do.

use nalgebra::{Matrix3, Quaternion, Vector3};

/// The turn, with left perturbation by and change of `ω` by `ω(0)`.
#[derive(Clone, Copy)]
pub struct Turned {
    /// `R(0)⁻¹R(s)`.
    pub rotation: Quaternion<f64>,
    /// [rad/s, body].
    pub omega: Vector3<f64>,
    /// Right perturbation of the rotation by `ω(0)`.
    pub turn_by_spin: Matrix3<f64>,
    /// Change of `ω` by `ω(0)`.
    pub spin_by_spin: Matrix3<f64>,
}

fn slope(moments: &Vector3<f64>, at: &Turned) -> Turned {
    let w = &at.omega;
    let inertia = Matrix3::from_diagonal(moments);
    let momentum = moments.component_mul(w);
    let by_spin = momentum.cross_matrix() - w.cross_matrix() * inertia;
    let inverse = Matrix3::from_diagonal(&moments.map(f64::recip));
    Turned {
        rotation: at.rotation * Quaternion::from_imag(w * 0.5),
        omega: momentum.cross(w).component_div(moments),
        turn_by_spin: at.spin_by_spin - w.cross_matrix() * at.turn_by_spin,
        spin_by_spin: inverse * by_spin * at.spin_by_spin,
    }
}

fn add(at: &Turned, slope: &Turned, h: f64) -> Turned {
    Turned {
        rotation: at.rotation + slope.rotation * h,
        omega: at.omega + slope.omega * h,
        turn_by_spin: at.turn_by_spin + slope.turn_by_spin * h,
        spin_by_spin: at.spin_by_spin + slope.spin_by_spin * h,
    }
}

/// The turn after `duration_s` in steps of about `step_s`.
pub fn turn(moments: &Vector3<f64>, omega: &Vector3<f64>, duration_s: f64, step_s: f64) -> Turned {
    let steps = (duration_s.abs() / step_s).ceil();
    let h = duration_s / steps;
    let mut at = Turned {
        rotation: Quaternion::identity(),
        omega: *omega,
        turn_by_spin: Matrix3::zeros(),
        spin_by_spin: Matrix3::identity(),
    };
    for _ in 0..steps as usize {
        let a = slope(moments, &at);
        let b = slope(moments, &add(&at, &a, h / 2.0));
        let c = slope(moments, &add(&at, &b, h / 2.0));
        let d = slope(moments, &add(&at, &c, h));
        for (part, weight) in [(a, 1.0), (b, 2.0), (c, 2.0), (d, 1.0)] {
            at = add(&at, &part, weight * h / 6.0);
        }
        at.rotation.normalize_mut();
    }
    at
}
