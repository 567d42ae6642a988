//! What is compared: ways to the turn of a free body and its derivatives.

use enact::physics::body::{Body, Symmetry};
use enact::physics::flow::{self, Spin};
use nalgebra::{Matrix3, Quaternion, Rotation3, UnitQuaternion, Vector3};

use super::dual::Dual;
use super::elliptic::{self, Elliptic};
use super::library;
use super::lie;
use super::runge_kutta;
use super::taylor::Taylor;

/// A body and how it begins to turn.
#[derive(Clone, Copy)]
pub struct Start {
    /// [kg m²].
    pub moments: [f64; 3],
    /// [rad/s, body].
    pub omega: [f64; 3],
}

impl Start {
    /// As the program has it.
    pub fn body(&self) -> Body {
        Body::new(1.0, self.moments.into()).expect("a body")
    }
}

/// A turn and its perturbation by the first angular velocity, as a method leaves them.
#[derive(Clone, Copy)]
pub struct Turned {
    /// `R(0)⁻¹R(s)`.
    pub rotation: UnitQuaternion<f64>,
    /// Perturbation \[rad\] of the rotation by `ω(0)` [rad/s].
    pub by_spin: Matrix3<f64>,
    /// On which side of the rotation that perturbation stands.
    pub side: Side,
}

/// Left: seen from the frame of `R(0)`; right: from that of `R(s)`.
#[derive(Clone, Copy, Eq, PartialEq)]
pub enum Side {
    Left,
    Right,
}

impl Turned {
    /// With the perturbation on the right.
    pub fn right(&self) -> Matrix3<f64> {
        match self.side {
            Side::Left => self.rotation.to_rotation_matrix().transpose() * self.by_spin,
            Side::Right => self.by_spin,
        }
    }

    /// From a quaternion that is nearly unit, with the perturbation on the right.
    pub fn of(rotation: Quaternion<f64>, by_spin: Matrix3<f64>) -> Self {
        Self {
            rotation: UnitQuaternion::new_normalize(rotation),
            by_spin,
            side: Side::Right,
        }
    }
}

/// Turns at increasing times \[s\]; fewer where the method gives up.
type Run = Box<dyn Fn(&Start, &[f64], &mut Vec<Turned>)>;

/// A method with one of its settings.
pub struct Method {
    /// Name of the curve.
    pub name: &'static str,
    /// Name of the point.
    pub setting: String,
    /// Whether the program does so for this body.
    pub is_ours: bool,
    /// Does it.
    pub run: Run,
}

/// Name of what the program does, by class of body.
pub fn ours(start: &Start) -> &'static str {
    match start.body().symmetry() {
        Symmetry::Asymmetric => "the program's: Taylor, order 20, its own steps",
        _ => "the program's: closed form",
    }
}

/// All methods for a body.
pub fn methods(start: &Start) -> Vec<Method> {
    let mut methods = vec![
        Method {
            is_ours: true,
            ..method(ours(start), String::new(), program)
        },
        method("elliptic functions", String::new(), closed_form),
    ];
    let tolerances = || [1e-3, 1e-5, 1e-7, 1e-9, 1e-11, 1e-13, 1e-15];
    for tolerance in tolerances() {
        methods.push(method(
            "Taylor, order 8",
            named(tolerance),
            move |s, t, o| {
                taylor::<9>(s, t, tolerance, o);
            },
        ));
    }
    for tolerance in tolerances() {
        methods.push(method(
            "Taylor, order 14",
            named(tolerance),
            move |s, t, o| {
                taylor::<15>(s, t, tolerance, o);
            },
        ));
    }
    for tolerance in tolerances() {
        methods.push(method(
            "Taylor, order 20",
            named(tolerance),
            move |s, t, o| {
                taylor::<21>(s, t, tolerance, o);
            },
        ));
    }
    for tolerance in tolerances() {
        methods.push(method(
            "Taylor, order 28",
            named(tolerance),
            move |s, t, o| {
                taylor::<29>(s, t, tolerance, o);
            },
        ));
    }
    for step_s in [3e-2, 1e-2, 3e-3, 1e-3, 3e-4, 1e-4] {
        let setting = || format!("{} ms", 1e3 * step_s);
        methods.push(method(
            "Runge–Kutta, order 4",
            setting(),
            move |s, t, o| {
                runge_kutta::turns(s, t, step_s, o);
            },
        ));
        methods.push(method(
            "Lie group (RKMK), order 4",
            setting(),
            move |s, t, o| {
                lie::turns(s, t, step_s, o);
            },
        ));
    }
    for tolerance in [1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-14] {
        methods.push(method(
            "DOP853, order 8",
            named(tolerance),
            move |s, t, o| {
                library::turns(s, t, library::Scheme::DormandPrince853, tolerance, o);
            },
        ));
        methods.push(method(
            "Verner, order 9",
            named(tolerance),
            move |s, t, o| {
                library::turns(s, t, library::Scheme::Verner9, tolerance, o);
            },
        ));
    }
    methods
}

fn method(
    name: &'static str,
    setting: String,
    run: impl Fn(&Start, &[f64], &mut Vec<Turned>) + 'static,
) -> Method {
    Method {
        name,
        setting,
        is_ours: false,
        run: Box::new(run),
    }
}

fn named(tolerance: f64) -> String {
    format!("{tolerance:e}")
}

/// One time as its events are evaluated, several as its samples are.
fn program(start: &Start, times_s: &[f64], turns: &mut Vec<Turned>) {
    let body = start.body();
    let omega = Vector3::from(start.omega);
    if let [time_s] = times_s {
        let turn = flow::turn(&body, &UnitQuaternion::identity(), &omega, *time_s);
        turns.push(Turned {
            rotation: turn.orientation,
            by_spin: turn.orientation_by_angular_velocity,
            side: Side::Right,
        });
        return;
    }
    let mut spin = Spin::new(&body, &omega);
    for time_s in times_s {
        let (rotation, by_spin) = spin.turn_and_derivative(*time_s);
        turns.push(Turned {
            rotation,
            by_spin: by_spin * *time_s,
            side: Side::Left,
        });
    }
}

fn closed_form(start: &Start, times_s: &[f64], turns: &mut Vec<Turned>) {
    let variables = [0, 1, 2].map(|i| Dual::variable(start.omega[i], i));
    let turn = Elliptic::new(start.moments, variables);
    for time_s in times_s {
        let (rotation, _, by_spin, _) = elliptic::with_derivatives(&turn, *time_s);
        turns.push(Turned {
            rotation: UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(
                rotation,
            )),
            by_spin,
            side: Side::Left,
        });
    }
}

fn taylor<const TERMS: usize>(
    start: &Start,
    times_s: &[f64],
    tolerance: f64,
    turns: &mut Vec<Turned>,
) {
    let mut taylor = Taylor::<f64, TERMS>::new(start.moments, start.omega, tolerance);
    for time_s in times_s {
        match taylor.at(*time_s) {
            Some(turned) => turns.push(turned),
            None => return,
        }
    }
}
