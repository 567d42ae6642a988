//! Deviations against those by numeric differentiation of the flight, with everything that may act on it.

use nalgebra::{DMatrix, DVector, UnitQuaternion, Vector3};

use super::*;
use crate::math::differentiate::jacobian;
use crate::math::random::Random;
use crate::physics::drag::Drag;
use crate::physics::flow;
use crate::physics::state::DIMENSION;

const GRAVITY_M_S2: Vector3<f64> = Vector3::new(0.1, -0.2, -9.7);
/// How fine the unknowns are, so that differences stay near: of a state, and of what acts.
const UNITS: [f64; 5] = [1.0, 0.5, 1.0, 2.0, 0.3];

fn body(drag: [f64; 2], log_moments: &Vector3<f64>) -> Body {
    let moments = Vector3::new(2e-4, 3e-4, 4e-4).component_mul(&log_moments.map(f64::exp));
    let body = Body::new(0.2, moments).expect("moments of a body");
    let drag = Drag {
        linear_per_s: drag[0],
        quadratic_per_m: drag[1],
    };
    body.with_drag(drag).expect("a drag")
}

fn state() -> State {
    State {
        position_m: Vector3::new(0.3, -0.1, 0.8),
        orientation: UnitQuaternion::from_scaled_axis(Vector3::new(0.4, -0.9, 1.3)),
        velocity_m_s: Vector3::new(1.2, -0.4, 2.0),
        angular_velocity_rad_s: Vector3::new(5.0, -3.0, 4.0),
    }
}

/// What each unknown after the state changes.
fn acting() -> Vec<FlightChange> {
    let drag = |drag| FlightChange {
        drag,
        ..FlightChange::default()
    };
    vec![
        FlightChange {
            pull_m_s2: Vector3::z(),
            ..FlightChange::default()
        },
        drag([1.0, 0.0]),
        drag([0.0, 1.0]),
        FlightChange {
            log_moments: Vector3::new(0.5, 0.5, 0.0),
            ..FlightChange::default()
        },
        FlightChange {
            centre_m: Vector3::new(0.0, 1.0, 0.0),
            ..FlightChange::default()
        },
    ]
}

/// The frame's place, turn from that at no change, velocity and angular velocity, after a flight with these changes.
fn seen(unknowns: &[f64], duration_s: f64, body_from_frame: &Pose) -> [Vector3<f64>; 4] {
    let by = &unknowns[DIMENSION..];
    let flown = |unknowns: &[f64]| {
        let by = &unknowns[DIMENSION..];
        let body = body(
            [0.4 + by[1], 0.2 + by[2]],
            &Vector3::new(0.5 * by[3], 0.5 * by[3], 0.0),
        );
        let gravity_m_s2 = GRAVITY_M_S2 + Vector3::z() * by[0];
        let from = state().retract(&StateTangent::from_column_slice(&unknowns[..DIMENSION]));
        flow::advance(&body, &gravity_m_s2, &from, duration_s)
    };
    let then = flown(unknowns);
    let without = flown(&vec![0.0; unknowns.len()]);
    let r = body_from_frame.translation.vector - Vector3::new(0.0, by[4], 0.0);
    let of = body_from_frame.rotation;
    let omega = then.angular_velocity_rad_s;
    [
        then.position_m + then.orientation * r,
        so3::log(&((without.orientation * of).inverse() * then.orientation * of)),
        then.velocity_m_s + then.orientation * omega.cross(&r),
        of.inverse() * omega,
    ]
}

#[test]
fn deviations_are_those_of_the_differentiated_flight() {
    let body_from_frame = Pose::from_parts(
        Vector3::new(0.05, -0.02, 0.1).into(),
        UnitQuaternion::from_scaled_axis(Vector3::new(-0.7, 0.2, 0.5)),
    );
    let acting = acting();
    let count = DIMENSION + acting.len();
    let unit = |at: usize| match at < DIMENSION {
        true => 1e-2,
        false => 1e-2 * UNITS[at - DIMENSION],
    };
    let mut random = Random::default();
    let root = DMatrix::from_fn(count, count, |row, _| unit(row) * random.signed());
    let covariance = &root * root.transpose();
    let certainty = FlightCertainty {
        acting,
        variance: Variance {
            whole: covariance.clone(),
            damped: DMatrix::zeros(count, count),
            informed: covariance.clone(),
            known: covariance.clone(),
            errors: 0.25 * &covariance,
            priors: 0.75 * &covariance,
        },
    };
    for duration_s in [-0.4, 0.0, 0.7] {
        let told = certainty.deviation(
            &body([0.4, 0.2], &Vector3::zeros()),
            &GRAVITY_M_S2,
            &state(),
            duration_s,
            &body_from_frame,
        );
        let by = jacobian(12, count, |unknowns| {
            let parts = seen(unknowns, duration_s, &body_from_frame);
            parts.iter().flat_map(|part| part.iter().copied()).collect()
        });
        let expected = by.into_iter().map(|row| {
            let row = DVector::from_vec(row);
            row.dot(&(&covariance * &row)).sqrt()
        });
        let told = told.parts().into_iter().flatten();
        for (at, (told, expected)) in told.zip(expected).enumerate() {
            let told = told.expect("all is determined");
            assert!(
                (told - expected).abs() < 1e-6 * expected,
                "{duration_s} s, {at}: {told}, not {expected}"
            );
        }
    }
}

#[test]
fn what_damping_alone_holds_is_not_told() {
    let told = Variance {
        whole: 2.0,
        damped: 0.0,
        informed: 1.5,
        known: 2.0,
        errors: 3.0,
        priors: 1.0,
    };
    assert_eq!(told.sd(), Some(2.0));
    let held = Variance {
        damped: 0.3,
        ..told.clone()
    };
    assert_eq!(held.sd(), None);
    let assumed = Variance {
        informed: 1e-5,
        ..told.clone()
    };
    assert_eq!(assumed.sd(), None);
    let nothing = Variance {
        whole: f64::NAN,
        ..told
    };
    assert_eq!(nothing.sd(), None);
}

/// Of a ball that the air lifts: its place and its velocity follow its spin, its turn and the lift.
#[test]
fn deviations_of_a_lifted_ball_are_those_of_the_differentiated_flight() {
    let ball = |lift: f64| {
        let body = Body::new(0.2, Vector3::repeat(3e-4)).expect("moments of a ball");
        body.with_lift(lift).expect("a lift")
    };
    let acting = vec![FlightChange {
        lift: 1.0,
        ..FlightChange::default()
    }];
    let count = DIMENSION + 1;
    let mut random = Random::default();
    let root = DMatrix::from_fn(count, count, |_, _| 1e-2 * random.signed());
    let covariance = &root * root.transpose();
    let certainty = FlightCertainty {
        acting,
        variance: Variance {
            whole: covariance.clone(),
            damped: DMatrix::zeros(count, count),
            informed: covariance.clone(),
            known: covariance.clone(),
            errors: covariance.clone(),
            priors: DMatrix::zeros(count, count),
        },
    };
    for duration_s in [-0.4, 0.7] {
        let flown = |unknowns: &[f64]| {
            let tangent = StateTangent::from_column_slice(&unknowns[..DIMENSION]);
            let (from, lift) = (state().retract(&tangent), 0.1 + unknowns[DIMENSION]);
            flow::advance(&ball(lift), &GRAVITY_M_S2, &from, duration_s)
        };
        let then = flown(&vec![0.0; count]);
        let by = jacobian(DIMENSION, count, |unknowns| {
            flown(unknowns).minus(&then).as_slice().to_vec()
        });
        let centre = Pose::identity();
        let told = certainty.deviation(&ball(0.1), &GRAVITY_M_S2, &state(), duration_s, &centre);
        let told = told.parts().into_iter().flatten();
        for (at, (told, row)) in told.zip(by).enumerate() {
            let row = DVector::from_vec(row);
            let expected = row.dot(&(&covariance * &row)).sqrt();
            let told = told.expect("all is determined");
            assert!(
                (told - expected).abs() < 1e-6 * expected,
                "{duration_s} s, {at}: {told}, not {expected}"
            );
        }
    }
}
