//! The classic Runge–Kutta method of fourth order on the turn and its variational equations,
//! with fixed steps: what a general simulator would do.

use nalgebra::{Matrix3, Quaternion, Vector3};

use super::method::{Start, Turned};

/// The turn and its derivatives by `ω(0)`.
#[derive(Clone, Copy)]
struct Node {
    /// `R(0)⁻¹R(s)`.
    rotation: Quaternion<f64>,
    /// [rad/s, body].
    omega: Vector3<f64>,
    /// Right perturbation of the rotation by `ω(0)`.
    turn_by_spin: Matrix3<f64>,
    /// Change of `ω` by `ω(0)`.
    spin_by_spin: Matrix3<f64>,
}

/// Rates of `ω`, of its derivative and of the turn's, of a body with these moments.
pub fn rates(
    moments: &Vector3<f64>,
    omega: &Vector3<f64>,
    spin_by_spin: &Matrix3<f64>,
    turn_by_spin: &Matrix3<f64>,
) -> (Vector3<f64>, Matrix3<f64>, Matrix3<f64>) {
    let momentum = moments.component_mul(omega);
    let mut by_spin =
        momentum.cross_matrix() - omega.cross_matrix() * Matrix3::from_diagonal(moments);
    for row in 0..3 {
        by_spin.row_mut(row).scale_mut(moments[row].recip());
    }
    (
        momentum.cross(omega).component_div(moments),
        by_spin * spin_by_spin,
        spin_by_spin - omega.cross_matrix() * turn_by_spin,
    )
}

fn slope(moments: &Vector3<f64>, at: &Node) -> Node {
    let (omega, spin_by_spin, turn_by_spin) =
        rates(moments, &at.omega, &at.spin_by_spin, &at.turn_by_spin);
    Node {
        rotation: at.rotation * Quaternion::from_imag(at.omega * 0.5),
        omega,
        turn_by_spin,
        spin_by_spin,
    }
}

fn add(at: &Node, slope: &Node, h: f64) -> Node {
    Node {
        rotation: at.rotation + slope.rotation * h,
        omega: at.omega + slope.omega * h,
        turn_by_spin: at.turn_by_spin + slope.turn_by_spin * h,
        spin_by_spin: at.spin_by_spin + slope.spin_by_spin * h,
    }
}

/// Turns at increasing times, in steps of at most `step_s`, an equal number to each time.
pub fn turns(start: &Start, times_s: &[f64], step_s: f64, turns: &mut Vec<Turned>) {
    let moments = Vector3::from(start.moments);
    let mut at = Node {
        rotation: Quaternion::identity(),
        omega: start.omega.into(),
        turn_by_spin: Matrix3::zeros(),
        spin_by_spin: Matrix3::identity(),
    };
    let mut now_s = 0.0;
    for time_s in times_s {
        let steps = ((time_s - now_s) / step_s - 1e-9).ceil().max(1.0);
        let h = (time_s - now_s) / steps;
        for _ in 0..steps as usize {
            let a = slope(&moments, &at);
            let b = slope(&moments, &add(&at, &a, h / 2.0));
            let c = slope(&moments, &add(&at, &b, h / 2.0));
            let d = slope(&moments, &add(&at, &c, h));
            for (part, weight) in [(a, 1.0), (b, 2.0), (c, 2.0), (d, 1.0)] {
                at = add(&at, &part, weight * h / 6.0);
            }
            at.rotation.normalize_mut();
        }
        now_s = *time_s;
        turns.push(Turned::of(at.rotation, at.turn_by_spin));
    }
}
