//! A Lie-group method of fourth order: the classic Runge–Kutta method in the algebra, each step
//! in exponential coordinates about its start, so that the rotation stays one (Munthe-Kaas,
//! "High order Runge–Kutta methods on manifolds", Applied Numerical Mathematics 29, 1999).

use enact::math::so3;
use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use super::method::{Side, Start, Turned};
use super::runge_kutta::rates;

/// Within a step: the turn since its start, `ω`, and both derivatives by `ω(0)`.
#[derive(Clone, Copy)]
struct Local {
    turn: Vector3<f64>,
    omega: Vector3<f64>,
    spin_by_spin: Matrix3<f64>,
    turn_by_spin: Matrix3<f64>,
}

/// With `R = R₀ Exp(u)`: `u̇ = ω + ½ u × ω + 1/12 u × (u × ω)`, what is left out being of fifth
/// order in the step.
fn slope(moments: &Vector3<f64>, at: &Local) -> Local {
    let (omega, spin_by_spin, turn_by_spin) =
        rates(moments, &at.omega, &at.spin_by_spin, &at.turn_by_spin);
    let once = at.turn.cross(&at.omega);
    Local {
        turn: at.omega + once * 0.5 + at.turn.cross(&once) / 12.0,
        omega,
        spin_by_spin,
        turn_by_spin,
    }
}

fn add(at: &Local, slope: &Local, h: f64) -> Local {
    Local {
        turn: at.turn + slope.turn * h,
        omega: at.omega + slope.omega * h,
        spin_by_spin: at.spin_by_spin + slope.spin_by_spin * h,
        turn_by_spin: at.turn_by_spin + slope.turn_by_spin * h,
    }
}

/// Turns at increasing times, in steps of at most `step_s`, an equal number to each time.
pub fn turns(start: &Start, times_s: &[f64], step_s: f64, turns: &mut Vec<Turned>) {
    let moments = Vector3::from(start.moments);
    let mut rotation = UnitQuaternion::identity();
    let mut at = Local {
        turn: Vector3::zeros(),
        omega: start.omega.into(),
        spin_by_spin: Matrix3::identity(),
        turn_by_spin: Matrix3::zeros(),
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
            rotation *= so3::exp(&at.turn);
            rotation.renormalize_fast();
            at.turn = Vector3::zeros();
        }
        now_s = *time_s;
        turns.push(Turned {
            rotation,
            by_spin: at.turn_by_spin,
            side: Side::Right,
        });
    }
}
