use nalgebra::{UnitQuaternion, Vector3};

use super::*;
use crate::math::differentiate;
use crate::physics::flow;
use crate::physics::state::{StateTangent, part};
use crate::physics::support::{Pivot, PivotAxes};
use crate::physics::{OnPlane, PlaneSupport, Sustained};

const GRAVITY: Vector3<f64> = Vector3::new(0.1, 0.2, -9.81);
const RADIUS_M: f64 = 0.03;
const FRICTION: f64 = 0.25;

/// A body on a plane, level or on a slope.
fn body(sustained: Sustained, is_ball: bool, normal: Vector3<f64>) -> Body {
    let moments = match is_ball {
        true => Vector3::repeat(0.4 * 0.2 * RADIUS_M * RADIUS_M),
        false => Vector3::new(3e-4, 4e-4, 6e-4),
    };
    let support = Support::Plane(PlaneSupport {
        normal: normal.normalize(),
        sustained,
        friction: FRICTION,
        touching: match is_ball {
            true => OnPlane::Ball { radius_m: RADIUS_M },
            false => OnPlane::Face {
                point_m: Vector3::zeros(),
                normal: -Vector3::z(),
            },
        },
    });
    Body::new(0.2, moments).unwrap().with_support(Some(support))
}

fn state() -> State {
    State {
        position_m: Vector3::new(0.1, -0.2, 0.9),
        orientation: UnitQuaternion::from_euler_angles(0.4, -1.1, 2.0),
        velocity_m_s: Vector3::new(1.5, 0.7, 0.1),
        angular_velocity_rad_s: Vector3::new(3.0, -7.0, 5.0),
    }
}

fn kinds() -> Vec<Body> {
    let mut all = Vec::new();
    for normal in [-GRAVITY, Vector3::new(0.1, -0.2, 1.0)] {
        for is_ball in [true, false] {
            all.push(body(Sustained::Slide, is_ball, normal));
            all.push(body(Sustained::Rest, is_ball, normal));
        }
        all.push(body(Sustained::Roll, true, normal));
    }
    for normal in [-GRAVITY, Vector3::new(0.1, -0.2, 1.0)] {
        all.push(cylinder(normal));
    }
    let axis = Vector3::new(0.3, -0.8, 0.2).normalize();
    for axes in [PivotAxes::All, PivotAxes::One(axis), PivotAxes::None] {
        all.push(pivoting(axes));
    }
    all
}

/// A cylinder that rolls.
fn cylinder(normal: Vector3<f64>) -> Body {
    let support = Support::Plane(PlaneSupport {
        normal: normal.normalize(),
        sustained: Sustained::Roll,
        friction: FRICTION,
        touching: OnPlane::Side {
            radius_m: RADIUS_M,
            axis: Vector3::y(),
        },
    });
    let body = Body::new(0.2, Vector3::new(4e-4, 9e-5, 4e-4)).unwrap();
    body.with_support(Some(support))
}

/// A body at a pivot.
fn pivoting(axes: PivotAxes) -> Body {
    let pivot = Pivot {
        at_m: Vector3::new(0.02, -0.05, 0.31),
        axes,
        damping_n_m_s: 3e-3,
    };
    let body = Body::new(0.2, Vector3::new(3e-4, 4e-4, 6e-4)).unwrap();
    body.with_support(Some(Support::Pivot(pivot)))
}

#[test]
fn derivatives_are_those_of_differences() {
    for body in kinds() {
        for s in [0.13, -0.21, 0.004] {
            let carried = Supported::new(&body, &GRAVITY, &state())
                .unwrap()
                .carried(s);
            let support = body.support().unwrap();
            let moved = |x: &[f64]| {
                let start = state().retract(&StateTangent::from_column_slice(&x[..12]));
                let gravity = GRAVITY + Vector3::new(x[12], x[13], x[14]);
                let changed = match support {
                    Support::Plane(plane) => Support::Plane(PlaneSupport {
                        friction: FRICTION + x[15],
                        ..plane
                    }),
                    pivot => pivot,
                };
                let body = body.with_support(Some(changed));
                let carried = Supported::new(&body, &gravity, &start)
                    .unwrap()
                    .carried(s + x[16]);
                let change = carried.state.minus(&flow::advance(
                    &self::kind(&body, support),
                    &GRAVITY,
                    &state(),
                    s,
                ));
                let mut all: Vec<f64> = change.iter().copied().collect();
                all.push(carried.slip_m_s);
                all
            };
            let numeric = differentiate::jacobian(13, 17, |x| {
                moved(&x.iter().map(|x| 0.1 * x).collect::<Vec<_>>())
            });
            for row in 0..13 {
                for column in 0..17 {
                    let exact = match (row, column) {
                        (12, 0..12) => carried.slip_by_state[column],
                        (12, 12..15) => carried.slip_by_pull[column - 12],
                        (12, 15) => carried.slip_by_friction,
                        (12, _) => carried.slip_rate_m_s2,
                        (_, 0..12) => carried.by_state[(row, column)],
                        (_, 12..15) => carried.by_pull[column - 12][row],
                        (_, 15) => carried.by_friction[row],
                        _ => carried.rate[row],
                    };
                    // Nothing slips of what rests.
                    if row == 12 && is_still(&support) {
                        continue;
                    }
                    let found = 10.0 * numeric[row][column];
                    // Between grid points the steps of a slope differ by their own error.
                    let most = if column == 16 { 3e-3 } else { 1e-6 };
                    assert!(
                        (exact - found).abs() < most * (1.0 + exact.abs()),
                        "{support:?} {s}: {row} by {column}: {exact} for {found}"
                    );
                }
            }
        }
    }
}

/// Whether nothing slips.
fn is_still(support: &Support) -> bool {
    match support {
        Support::Plane(plane) => plane.sustained == Sustained::Rest,
        Support::Pivot(_) => true,
        Support::Stuck(_) => false,
    }
}

/// The body with the support as it was.
fn kind(body: &Body, support: Support) -> Body {
    body.with_support(Some(support))
}

#[test]
fn a_ball_slides_until_two_sevenths_of_its_speed_are_gone() {
    let ball = body(Sustained::Slide, true, Vector3::z());
    let gravity = Vector3::new(0.0, 0.0, -9.81);
    let start = State {
        velocity_m_s: Vector3::new(2.0, 0.0, 0.0),
        angular_velocity_rad_s: Vector3::zeros(),
        ..state()
    };
    let mut supported = Supported::new(&ball, &gravity, &start).unwrap();
    // u = v (1 − 7/2 μ g t/v).
    let end_s = 2.0 * 2.0 / (7.0 * FRICTION * 9.81);
    let end = supported.carried(end_s);
    assert!(end.slip_m_s.abs() < 1e-12);
    assert!((end.state.velocity_m_s - Vector3::x() * (10.0 / 7.0)).norm() < 1e-12);
    let spin = end.state.orientation * end.state.angular_velocity_rad_s;
    assert!((spin - Vector3::y() * (10.0 / 7.0 / RADIUS_M)).norm() < 1e-10);
    let way_m = 2.0 * end_s - 0.5 * FRICTION * 9.81 * end_s * end_s;
    assert!((end.state.position_m - start.position_m - Vector3::x() * way_m).norm() < 1e-12);
    // About an axis that stays the angle is the integral of the angular velocity.
    let angle = 0.5 * (10.0 / 7.0 / RADIUS_M) * end_s;
    let turned = UnitQuaternion::from_scaled_axis(Vector3::y() * angle) * start.orientation;
    assert!(turned.angle_to(&end.state.orientation) < 1e-10);
}

#[test]
fn what_lies_flat_ends_its_slip_and_its_yaw_at_once() {
    let body = body(Sustained::Slide, false, Vector3::z());
    let gravity = Vector3::new(0.0, 0.0, -9.81);
    let gyration_m = (6e-4_f64 / 0.2).sqrt();
    let start = State {
        orientation: UnitQuaternion::identity(),
        velocity_m_s: Vector3::new(0.6, 0.0, 0.0),
        angular_velocity_rad_s: Vector3::new(0.0, 0.0, 0.8 / gyration_m),
        ..state()
    };
    let end = Supported::new(&body, &gravity, &start).unwrap();
    let end = { end }.carried(1.0 / (FRICTION * 9.81));
    assert!(end.slip_m_s.abs() < 1e-12);
    assert!(end.state.velocity_m_s.norm() < 1e-12);
    assert!(end.state.angular_velocity_rad_s.norm() < 1e-9);
}

#[test]
fn grids_do_not_show_on_a_slope() {
    let slope = Vector3::new(0.1, -0.2, 1.0);
    for body in [
        body(Sustained::Slide, true, slope),
        body(Sustained::Slide, false, slope),
        body(Sustained::Roll, true, slope),
    ] {
        // By way of a moment between the nodes, so that the steps after it are others.
        let whole = flow::advance(&body, &GRAVITY, &state(), 0.2);
        let middle = flow::advance(&body, &GRAVITY, &state(), 0.0733);
        let twice = flow::advance(&body, &GRAVITY, &middle, 0.2 - 0.0733);
        // Of places and velocities: a ball's spin is that of its slip over its radius.
        let off = twice.minus(&whole);
        let off =
            off.fixed_rows::<3>(part::POSITION).norm() + off.fixed_rows::<3>(part::VELOCITY).norm();
        assert!(off < 2e-3, "{:?}: {off:e}", body.support());
    }
}

#[test]
fn a_pendulum_keeps_its_energy_and_its_place() {
    let at_m = Vector3::new(0.0, 0.0, 0.25);
    let pivot = Pivot {
        at_m,
        axes: PivotAxes::One(Vector3::y()),
        damping_n_m_s: 0.0,
    };
    let body = Body::new(0.5, Vector3::new(2e-3, 3e-3, 1e-3)).unwrap();
    let body = body.with_support(Some(Support::Pivot(pivot)));
    let gravity = Vector3::new(0.0, 0.0, -9.81);
    let start = State {
        position_m: Vector3::new(0.25, 0.0, 1.0),
        orientation: UnitQuaternion::from_scaled_axis(Vector3::y() * -1.5),
        velocity_m_s: Vector3::zeros(),
        angular_velocity_rad_s: Vector3::zeros(),
    };
    let place_m = |state: &State| state.position_m + state.orientation * at_m;
    let energy = |state: &State| {
        let turning = 0.5 * (3e-3 + 0.5 * 0.0625) * state.angular_velocity_rad_s.y.powi(2);
        turning + 0.5 * 9.81 * state.position_m.z
    };
    let mut supported = Supported::new(&body, &gravity, &start).unwrap();
    let mut most_rad_s: f64 = 0.0;
    for step in 1..100 {
        let now = supported.at(0.07 * f64::from(step));
        assert!((place_m(&now) - place_m(&start)).norm() < 1e-12);
        assert!((energy(&now) - energy(&start)).abs() < 1e-10);
        most_rad_s = most_rad_s.max(now.angular_velocity_rad_s.norm());
    }
    assert!(most_rad_s > 5.0);
}

#[test]
fn a_top_keeps_its_energy_and_its_momentum_about_the_vertical_however_fast() {
    let at_m = Vector3::new(0.0, 0.0, -0.03);
    let pivot = Pivot {
        at_m,
        axes: PivotAxes::All,
        damping_n_m_s: 0.0,
    };
    let moments = Vector3::new(1e-5, 1.1e-5, 1.6e-5);
    let mass_kg = 0.05;
    let body = Body::new(mass_kg, moments).unwrap();
    let body = body.with_support(Some(Support::Pivot(pivot)));
    let gravity = Vector3::new(0.0, 0.0, -9.81);
    let about_m2 = |axis: usize| if axis < 2 { 0.03 * 0.03 } else { 0.0 };
    let inertia = Vector3::from_fn(|axis, _| moments[axis] + mass_kg * about_m2(axis));
    for spin_rad_s in [20.0, 90.0, 300.0] {
        let orientation = UnitQuaternion::from_euler_angles(0.3, -0.2, 0.7);
        let omega = Vector3::new(1.0, -2.0, spin_rad_s);
        let start = State {
            position_m: -(orientation * at_m),
            orientation,
            velocity_m_s: -(orientation * omega.cross(&at_m)),
            angular_velocity_rad_s: omega,
        };
        let momentum =
            |of: &State| of.orientation * inertia.component_mul(&of.angular_velocity_rad_s);
        let energy = |of: &State| {
            let omega = of.angular_velocity_rad_s;
            let turning = 0.5 * omega.dot(&inertia.component_mul(&omega));
            turning + mass_kg * 9.81 * of.position_m.z
        };
        let mut supported = Supported::new(&body, &gravity, &start).unwrap();
        for step in 1..20 {
            let now = supported.at(0.05 * f64::from(step));
            let lost = (energy(&now) / energy(&start) - 1.0).abs();
            let turned = (momentum(&now).z / momentum(&start).z - 1.0).abs();
            assert!(
                lost < 1e-8 && turned < 1e-8,
                "{spin_rad_s}: {lost:e} {turned:e}"
            );
            let place_m = now.position_m + now.orientation * at_m;
            assert!(place_m.norm() < 1e-9, "{spin_rad_s}: {place_m}");
        }
    }
}
