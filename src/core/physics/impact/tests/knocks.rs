//! What is told of each contact is what the bodies do: momentum, angular momentum, and speeds by how gaps change.

use nalgebra::Vector3;

use super::*;
use crate::math::so3;

/// A state a moment later, without forces.
fn moved(state: &State, after: &Velocities, duration_s: f64) -> State {
    State {
        position_m: state.position_m + after.velocity_m_s * duration_s,
        orientation: state.orientation * so3::exp(&(after.angular_velocity_rad_s * duration_s)),
        ..*state
    }
}

/// Momentum and angular momentum about the own centre of mass that a body gains, without what impulses at places give it.
fn unexplained(mover: &Mover, after: &Velocities, knocks: &[Knock], sign: f64) -> f64 {
    let (body, state) = mover;
    let spun = after.angular_velocity_rad_s - state.angular_velocity_rad_s;
    let mut momentum = (after.velocity_m_s - state.velocity_m_s) * body.mass_kg();
    let mut turned = state.orientation * spun.component_mul(&body.moments_kg_m2());
    for knock in knocks {
        let impulse = knock.impulse_n_s * sign;
        momentum -= impulse;
        turned -= (knock.point_m - state.position_m).cross(&impulse);
        turned -= knock.moment_n_m_s * sign;
    }
    momentum.norm() + turned.norm()
}

#[test]
fn one_contact_explains_what_both_bodies_gain() {
    for (index, case) in cases(400) {
        let contacts = ContactSet::with_friction(&[case.contact]).expect("one contact");
        let other = case.b.as_ref().map(side);
        let knocks = contacts.knocks(&side(&case.a), other.as_ref(), &case.law);
        let knocks = knocks.expect("a regular pose");
        let impact = case.impact();
        assert_eq!(knocks.len(), 1);
        let off = unexplained(&case.a, &impact.after[0], &knocks, 1.0);
        assert!(off < 1e-11, "{index}: {off}");
        if let Some(b) = &case.b {
            let off = unexplained(b, &impact.after[1], &knocks, -1.0);
            assert!(off < 1e-11, "{index}: {off}");
        }
        // The gap closes as fast as what touches approaches, and opens as fast as it parts.
        let h = 1e-6;
        let gap_m = |velocities: &[Velocities; 2], duration_s: f64| {
            let at = |mover: &Mover, of: &Velocities| Frame::of(&moved(&mover.1, of, duration_s));
            let a = at(&case.a, &velocities[0]);
            let b = case.b.as_ref().map(|b| at(b, &velocities[1]));
            let touch = case.contact.touch(&a, &b.unwrap_or(Frame::world()));
            touch.expect("a regular pose").gap_m
        };
        let rate = |of: &[Velocities; 2]| (gap_m(of, h) - gap_m(of, -h)) / (2.0 * h);
        let closing_m_s = -rate(&case.before());
        let off = (knocks[0].approach_m_s() - closing_m_s).abs();
        assert!(off < 1e-7, "{index}: {off}");
        let off = (knocks[0].parting_m_s() - rate(&impact.after)).abs();
        assert!(off < 1e-7, "{index}: {off}");
        let rebound = knocks[0].parting_m_s() - case.law.restitution * knocks[0].approach_m_s();
        assert!(rebound.abs() < 1e-11, "{index}: {rebound}");
        let [slip_m_s, after_m_s] = knocks[0].slips_m_s();
        let whole = case.relative(&case.before()).norm_squared();
        let parts = slip_m_s.powi(2) + closing_m_s.powi(2);
        assert!((whole - parts).abs() < 1e-6, "{index}: {whole} {parts}");
        assert!(after_m_s.is_finite() && knocks[0].moment_n_m_s == Vector3::zeros());
    }
}

#[test]
fn a_face_is_told_by_its_corners_without_friction_and_as_a_whole_with_it() {
    let mut draw = Draw::new(15);
    let corners = corners(3);
    let smooth = ContactSet::frictionless(&corners).expect("three");
    let rough = ContactSet::with_friction(&corners).expect("a face");
    let mut twisted = 0;
    for index in 0..200 {
        let mut state = draw.state();
        state.orientation = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 0.7);
        state.position_m.z = 0.3;
        state.velocity_m_s.z = -draw.between(0.1, 2.0);
        let a = (draw.body(), state);
        let restitution = draw.between(0.0, 1.0);
        for (contacts, friction) in [(&smooth, 0.0), (&rough, draw.between(0.0, 1.2))] {
            let law = Law {
                tangential_restitution: 0.0,
                restitution,
                friction,
                tilt_rad: [0.0; 2],
            };
            let knocks = contacts.knocks(&side(&a), None, &law).expect("regular");
            let impact = contacts.impact(&side(&a), None, &law).expect("regular");
            let off = unexplained(&a, &impact.after[0], &knocks, 1.0);
            assert!(off < 1e-11, "{index}: {off}");
            assert_eq!(knocks.len(), if friction == 0.0 { 3 } else { 1 });
            let twist_n_m_s = knocks[0].moment_n_m_s.z;
            twisted += usize::from(twist_n_m_s.abs() > 1e-3);
            let across = knocks[0].moment_n_m_s.xy().norm();
            assert!(across < 1e-12, "{index}: {across}");
            let whole = Knock::whole(&knocks).expect("contacts");
            let off = unexplained(&a, &impact.after[0], &[whole], 1.0);
            assert!(off < 1e-11, "{index}: {off}");
            let rebound = whole.parting_m_s() - restitution * whole.approach_m_s();
            assert!(rebound.abs() < 1e-11, "{index}: {rebound}");
        }
    }
    assert!(twisted > 50, "{twisted}");
    assert_eq!(Knock::whole(&[]), None);
}

/// Of what recedes nothing presses: the middle of its corners is told, and all is finite.
#[test]
fn what_recedes_is_told_in_its_middle() {
    let contacts = ContactSet::with_friction(&corners(3)).expect("a face");
    let body = Body::new(1.0, Vector3::repeat(0.1)).expect("a body");
    let state = State {
        position_m: Vector3::new(0.0, 0.0, 0.3),
        velocity_m_s: Vector3::new(3.0, 0.0, 1.0),
        ..State::at_rest()
    };
    let law = Law::frictionless(0.5);
    let knocks = contacts.knocks(&side(&(body, state)), None, &law);
    let knocks = knocks.expect("regular");
    assert!(knocks[0].approach_m_s() < 0.0);
    let middle = Vector3::new(0.5 - 0.5 + 0.5, 0.4, 0.0) / 3.0;
    assert!((knocks[0].point_m - middle).norm() < 1e-12, "{knocks:?}");
}
