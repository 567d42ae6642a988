//! Impacts with a body that no impact deflects.

use nalgebra::{UnitQuaternion, Vector3};

use super::*;

/// Cases of two bodies of which nothing deflects the second.
fn held_cases(count: usize) -> impl Iterator<Item = (usize, Case)> {
    cases(count).filter_map(|(index, mut case)| {
        case.b.as_mut()?.0 = Body::IMMOVABLE;
        Some((index, case))
    })
}

/// A free body that is heavier and heavier takes the same impulses.
#[test]
fn it_is_the_limit_of_a_heavy_body() {
    for (index, case) in held_cases(1000) {
        let held = case.impact();
        let heavy = Body::new(1e9, Vector3::repeat(1e9)).expect("a body");
        let b = case.b.map(|(_, state)| (heavy, state));
        let near = Case { b, ..case }.impact();
        let before = Velocities::of(&b.expect("a second body").1);
        assert_eq!(held.after[1], before, "{index}");
        assert_eq!(held.sticks, near.sticks, "{index}");
        for body in 0..2 {
            let off = difference(&held.after[body], &near.after[body]);
            assert!(off < 1e-7, "{index}: {off}");
        }
    }
}

/// At rest it is the static world with the same features.
#[test]
fn at_rest_it_is_the_static_world() {
    for (index, case) in held_cases(1000) {
        let (_, at) = case.b.expect("a second body");
        let still = State {
            velocity_m_s: Vector3::zeros(),
            angular_velocity_rad_s: Vector3::zeros(),
            ..at
        };
        let held = Case {
            b: Some((Body::IMMOVABLE, still)),
            ..case
        };
        let placed = case.contact.b().placed(&at.world_from_body());
        let fixed = Case {
            b: None,
            contact: Contact::new(*case.contact.a(), placed).expect("the same pair"),
            ..case
        };
        let (held, fixed) = (held.impact(), fixed.impact());
        let off = difference(&held.after[0], &fixed.after[0]);
        assert!(off < 1e-9, "{index}: {off}");
        assert!((held.gaps_m[0] - fixed.gaps_m[0]).abs() < 1e-12);
        assert!((held.speeds_m_s[0] - fixed.speeds_m_s[0]).abs() < 1e-11);
    }
}

/// Seen from a train, everything has the train's velocity less.
#[test]
fn a_common_velocity_changes_nothing_else() {
    let train = Vector3::new(3.0, -7.0, 2.0);
    for (index, case) in held_cases(1000) {
        let faster = |(body, state): Mover| {
            let velocity_m_s = state.velocity_m_s + train;
            (
                body,
                State {
                    velocity_m_s,
                    ..state
                },
            )
        };
        let moved = Case {
            a: faster(case.a),
            b: case.b.map(faster),
            ..case
        };
        let (one, other) = (case.impact(), moved.impact());
        let back = Velocities {
            velocity_m_s: other.after[0].velocity_m_s - train,
            ..other.after[0]
        };
        let off = difference(&one.after[0], &back);
        assert!(off < 1e-9, "{index}: {off}");
    }
}

/// In its own frame the impact loses energy; what else the hit body gains is the hand's work.
#[test]
fn the_hand_does_what_is_gained() {
    for (index, case) in held_cases(1000) {
        let impact = case.impact();
        let touch = case.touch();
        let (_, holds) = case.b.expect("a second body");
        let speed = holds.velocity_m_s
            + holds.orientation * holds.angular_velocity_rad_s.cross(&touch.on_b_m);
        let (body, state) = case.a;
        let pushed = (impact.after[0].velocity_m_s - state.velocity_m_s) * body.mass_kg();
        let energy = |v: &Velocities| {
            let omega = v.angular_velocity_rad_s;
            0.5 * body.mass_kg() * v.velocity_m_s.norm_squared()
                + 0.5 * body.moments_kg_m2().dot(&omega.component_mul(&omega))
        };
        let gained = energy(&impact.after[0]) - energy(&Velocities::of(&state));
        let lost = pushed.dot(&speed) - gained;
        assert!(lost > -1e-10, "{index}: {lost}");
    }
    // A ball at rest that an elastic racket hits leaves at twice its speed.
    let ball = Body::new(0.1, Vector3::repeat(1e-4)).expect("a body");
    let at = |z: f64, speed: f64| State {
        position_m: Vector3::new(0.0, 0.0, z),
        orientation: UnitQuaternion::identity(),
        velocity_m_s: Vector3::z() * speed,
        angular_velocity_rad_s: Vector3::zeros(),
    };
    let point = Feature::Point {
        point_m: Vector3::zeros(),
        radius_m: 0.02,
    };
    let face = Feature::face(Vector3::zeros(), Vector3::z());
    let case = Case {
        a: (ball, at(0.02, 0.0)),
        b: Some((Body::IMMOVABLE, at(0.0, 3.0))),
        contact: Contact::new(point, face).expect("a pair"),
        law: Law::frictionless(1.0),
    };
    let after = case.impact().after[0];
    assert!((after.velocity_m_s - Vector3::z() * 6.0).norm() < 1e-12);
}
