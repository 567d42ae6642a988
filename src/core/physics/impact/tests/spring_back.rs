//! Tangential restitution: what becomes of energy, momentum and the speed along the surface, and the superball in closed form.

use super::*;

/// The impact of a case with other coefficients: restitution, friction, tangential restitution.
fn hit(case: &Case, [restitution, friction, tangential_restitution]: [f64; 3]) -> (Case, Impact) {
    let law = Law {
        restitution,
        friction,
        tangential_restitution,
        tilt_rad: [0.0; 2],
    };
    let case = Case { law, ..*case };
    let impact = case.impact();
    (case, impact)
}

#[test]
fn no_impact_of_any_bodies_gains_energy() {
    let mut draw = Draw::new(41);
    let (mut stuck, mut slid, mut kept) = (0, 0, 0);
    for index in 0..60 * KINDS {
        let case = Case::draw(&mut draw, index % KINDS, (index / KINDS).is_multiple_of(2));
        let (before, normal) = (case.before(), case.touch().normal);
        let was_j = case.energy(&before);
        let came = case.relative(&before);
        let drawn = [
            draw.between(0.0, 1.0),
            draw.between(0.0, 3.0),
            draw.between(0.0, 1.0),
        ];
        for law in [drawn, [1.0, 3.0, 1.0], [0.0, 3.0, 1.0]] {
            let [restitution, friction, _] = law;
            let (hit, impact) = hit(&case, law);
            let is_j = hit.energy(&impact.after);
            assert!(is_j <= was_j * (1.0 + 1e-12), "{index}: {was_j} {is_j}");
            let left = hit.relative(&impact.after);
            let off_m_s = normal.dot(&left) + restitution * normal.dot(&came);
            assert!(off_m_s.abs() < 1e-9, "{index}: {off_m_s}");
            let pushed = impact.after[0].velocity_m_s - before[0].velocity_m_s;
            let pushed = pushed * case.a.0.mass_kg();
            let along = pushed.dot(&normal);
            let across = (pushed - normal * along).norm();
            assert!(
                across <= friction * along + 1e-9,
                "{index}: {across} {along}"
            );
            stuck += usize::from(impact.sticks);
            slid += usize::from(!impact.sticks);
            if law == [1.0, 3.0, 1.0] && impact.sticks {
                assert!(
                    (is_j - was_j).abs() < 1e-11 * was_j,
                    "{index}: {was_j} {is_j}"
                );
                kept += 1;
            }
        }
    }
    assert!(
        stuck > 300 && slid > 300 && kept > 100,
        "{stuck} {slid} {kept}"
    );
}

/// A solid ball on a level floor: its spin and its level velocity after, of which the slip is turned back.
#[test]
fn a_superball_springs_back_as_garwin_says() {
    let (mass_kg, radius_m) = (0.05, 0.02);
    let body = Body::new(
        mass_kg,
        Vector3::repeat(0.4 * mass_kg * radius_m * radius_m),
    )
    .unwrap();
    let ball = Feature::Point {
        point_m: Vector3::zeros(),
        radius_m,
    };
    let floor = Feature::face(Vector3::zeros(), Vector3::z());
    let contacts = ContactSet::with_friction(&[Contact::new(ball, floor).unwrap()]).unwrap();
    let mut state = State {
        position_m: Vector3::z() * radius_m,
        velocity_m_s: Vector3::new(1.0, 0.0, -3.0),
        angular_velocity_rad_s: Vector3::new(0.0, -120.0, 7.0),
        ..State::at_rest()
    };
    for tangential_restitution in [1.0, 1.0, 0.6, 0.0] {
        let law = Law {
            restitution: 1.0,
            friction: 2.0,
            tangential_restitution,
            tilt_rad: [0.0; 2],
        };
        let side = Side {
            body: &body,
            state: &state,
        };
        let impact = contacts.impact(&side, None, &law).unwrap();
        assert!(impact.sticks);
        let [after, _] = impact.after;
        // Along x, with the slip `v − ω r` of the lowest point: 2/7 of its change goes to the velocity and 5/7 to the spin.
        let (v, w) = (state.velocity_m_s.x, state.angular_velocity_rad_s.y);
        let slip = v - w * radius_m;
        let change = -(1.0 + tangential_restitution) * slip;
        assert!((after.velocity_m_s.x - (v + change * 2.0 / 7.0)).abs() < 1e-12);
        let spin = w - change * 5.0 / 7.0 / radius_m;
        assert!((after.angular_velocity_rad_s.y - spin).abs() < 1e-9);
        assert!((after.angular_velocity_rad_s.z - 7.0).abs() < 1e-12);
        assert!((after.velocity_m_s.z + state.velocity_m_s.z).abs() < 1e-12);
        let now = after.velocity_m_s.x - after.angular_velocity_rad_s.y * radius_m;
        assert!((now + tangential_restitution * slip).abs() < 1e-12);
        let energy = |v: &Vector3<f64>, w: &Vector3<f64>| {
            0.5 * mass_kg * (v.norm_squared() + 0.4 * radius_m * radius_m * w.norm_squared())
        };
        let was = energy(&state.velocity_m_s, &state.angular_velocity_rad_s);
        let is = energy(&after.velocity_m_s, &after.angular_velocity_rad_s);
        let lost =
            0.5 * mass_kg * (2.0 / 7.0) * slip * slip * (1.0 - tangential_restitution.powi(2));
        assert!((was - is - lost).abs() < 1e-12, "{was} {is} {lost}");
        state.velocity_m_s = after.velocity_m_s;
        state.velocity_m_s.z *= -1.0;
        state.angular_velocity_rad_s = after.angular_velocity_rad_s;
    }
}

#[test]
fn springing_back_is_of_one_contact_with_friction() {
    let slippery = ContactSet::frictionless(&corners(1)).unwrap();
    let flat = ContactSet::with_friction(&corners(3)).unwrap();
    let one = ContactSet::with_friction(&corners(1)).unwrap();
    assert!(slippery.check_spring_back().is_err() && flat.check_spring_back().is_err());
    assert_eq!(one.check_spring_back(), Ok(()));
}
