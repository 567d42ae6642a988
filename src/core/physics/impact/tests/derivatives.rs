use super::*;

/// Movers moved by a tangent each.
fn moved(movers: &[Mover], d: &[f64]) -> Vec<Mover> {
    movers
        .iter()
        .zip(d.chunks(12))
        .map(|((body, state), d)| (*body, state.retract(&StateTangent::from_column_slice(d))))
        .collect()
}

/// Gaps, speeds and velocities after.
fn values(impact: &Impact) -> Vec<f64> {
    let mut values = Vec::new();
    values.extend(impact.gaps_m);
    values.extend(impact.speeds_m_s);
    for after in &impact.after {
        values.extend(after.velocity_m_s.iter());
        values.extend(after.angular_velocity_rad_s.iter());
    }
    values
}

/// The same rows of the derivative: two states, restitution, friction, two tilts, tangential restitution.
fn expected(derivative: &ImpactDerivative, row: usize, column: usize) -> f64 {
    let by_state = column < 24;
    let (body, of_state) = (column / 12, column % 12);
    match row {
        0..3 if by_state => derivative.gap[row][body][of_state],
        3..6 if by_state => derivative.speed[row - 3][body][of_state],
        0..6 => 0.0,
        _ => {
            let (i, row) = ((row - 6) / 6, (row - 6) % 6);
            match column {
                0..24 => derivative.after[i][body][(row, of_state)],
                24 => derivative.after_by_restitution[i][row],
                25 => derivative.after_by_friction[i][row],
                28 => derivative.after_by_tangential_restitution[i][row],
                _ => derivative.after_by_tilt[i][(row, column - 26)],
            }
        }
    }
}

/// Compares all derivatives with differences, unless a switch is within their reach; returns
/// whether it did.
fn check(contacts: &ContactSet, movers: &[Mover], law: &Law, name: &str) -> bool {
    const STEP: f64 = 0.1;
    let at = |d: &[f64]| {
        let d: Vec<f64> = d.iter().map(|x| STEP * x).collect();
        let movers = moved(movers, &d);
        let mut law = *law;
        law.restitution += d[24];
        if contacts.has_friction() {
            law.friction += d[25];
        }
        if contacts.check_spring_back().is_ok() {
            law.tangential_restitution += d[28];
        }
        if contacts.check_tilt().is_ok() {
            law.tilt_rad[0] += d[26];
            law.tilt_rad[1] += d[27];
        }
        contacts
            .impact(&side(&movers[0]), movers.get(1).map(side).as_ref(), &law)
            .expect("regular")
    };
    let base = at(&[0.0; 29]);
    let mut derivative = ImpactDerivative::zeros();
    // What was there before must not show through.
    for body in 0..movers.len() {
        for i in 0..movers.len() {
            derivative.after[i][body].fill(7.0);
        }
        for contact in 0..contacts.as_slice().len() {
            derivative.gap[contact][body].fill(7.0);
            derivative.speed[contact][body].fill(7.0);
        }
        derivative.after_by_restitution[body].fill(7.0);
        derivative.after_by_friction[body].fill(7.0);
        derivative.after_by_tangential_restitution[body].fill(7.0);
        derivative.after_by_tilt[body].fill(7.0);
    }
    let b = movers.get(1).map(side);
    let impact = contacts
        .derivative(&side(&movers[0]), b.as_ref(), law, &mut derivative)
        .expect("regular");
    for (here, there) in values(&impact).iter().zip(values(&base)) {
        assert!((here - there).abs() < 1e-12, "{name}");
    }
    assert_eq!((impact.sticks, impact.pulls()), (base.sticks, base.pulls()));
    let branches_differ = (0..58).any(|probe| {
        let mut d = [0.0; 29];
        d[probe / 2] = if probe % 2 == 0 { 0.02 } else { -0.02 };
        at(&d).sticks != base.sticks
    });
    if branches_differ {
        return false;
    }
    let numeric = differentiate::jacobian(18, 29, |d| {
        values(&at(d)).iter().map(|x| x / STEP).collect()
    });
    for row in 0..18 {
        for column in 0..29 {
            let (found, known) = (numeric[row][column], expected(&derivative, row, column));
            assert!(
                (found - known).abs() < 2e-8 * (1.0 + known.abs()),
                "{name}: row {row}, column {column}: {known} against {found}"
            );
        }
    }
    true
}

fn movers(case: &Case) -> Vec<Mover> {
    std::iter::once(case.a).chain(case.b).collect()
}

#[test]
fn sticking_and_sliding() {
    let mut draw = Draw::new(21);
    let (mut stuck, mut slid) = ([0; KINDS], [0; KINDS]);
    let mut sprung = 0;
    for index in 0..30 * KINDS {
        let kind = index % KINDS;
        let mut case = Case::draw(&mut draw, kind, (index / KINDS).is_multiple_of(2));
        if case.contact.tilt_axes().is_some() && (index / KINDS).is_multiple_of(3) {
            case.law.tilt_rad = [draw.between(-0.1, 0.1), draw.between(-0.1, 0.1)];
        }
        let contacts = ContactSet::with_friction(&[case.contact]).expect("one");
        let name = format!("case {index}, kind {kind}");
        if check(&contacts, &movers(&case), &case.law, &name) {
            let count = if case.impact().sticks {
                &mut stuck
            } else {
                &mut slid
            };
            count[kind] += 1;
        }
        case.law.tangential_restitution = 0.6;
        case.law.friction += 2.0;
        let is_told = check(&contacts, &movers(&case), &case.law, &name);
        sprung += usize::from(is_told && case.impact().sticks);
    }
    assert!(sprung > 100, "{sprung}");
    assert!(
        stuck.iter().chain(&slid).all(|count| *count >= 3),
        "{stuck:?} {slid:?}"
    );
}

#[test]
fn receding_contacts_with_friction() {
    // A solver on its way meets them: the law goes on, without friction.
    let mut draw = Draw::new(27);
    let mut checked = 0;
    for index in 0..4 * KINDS {
        let kind = index % KINDS;
        let mut case = Case::draw(&mut draw, kind, (index / KINDS).is_multiple_of(2));
        case.a.1 = reversed(&case.a.1);
        case.b = case.b.map(|(body, state)| (body, reversed(&state)));
        let impact = case.impact();
        assert!(impact.speeds_m_s[0] > 0.0 && !impact.sticks);
        let contacts = ContactSet::with_friction(&[case.contact]).expect("one");
        let name = format!("receding case {index}, kind {kind}");
        checked += usize::from(check(&contacts, &movers(&case), &case.law, &name));
    }
    assert!(checked >= 3 * KINDS, "{checked}");
}

#[test]
fn friction_that_may_grow_from_none() {
    // At no friction differences would cross into negative friction, where the law's formula
    // goes on smoothly.
    let mut draw = Draw::new(25);
    for kind in 0..KINDS {
        let mut case = Case::draw(&mut draw, kind, true);
        case.law.friction = 0.0;
        let contacts = ContactSet::with_friction(&[case.contact]).expect("one");
        let name = format!("kind {kind}");
        assert!(check(&contacts, &movers(&case), &case.law, &name));
    }
}

#[test]
fn without_friction() {
    let mut draw = Draw::new(22);
    for index in 0..6 * KINDS {
        let (kind, round) = (index % KINDS, index / KINDS);
        let mut case = Case::draw(&mut draw, kind, round % 2 == 0);
        case.law.friction = 0.0;
        if case.contact.tilt_axes().is_some() && round > 2 {
            case.law.tilt_rad = [draw.between(-0.1, 0.1), draw.between(-0.1, 0.1)];
        }
        let contacts = ContactSet::frictionless(&[case.contact]).expect("one");
        let name = format!("case {index}, kind {kind}");
        assert!(check(&contacts, &movers(&case), &case.law, &name));
    }
}

#[test]
fn several_contacts_at_once() {
    let mut draw = Draw::new(23);
    for index in 0..12 {
        let count = 2 + index % 2;
        let two_bodies = index % 4 < 2;
        let mut movers = vec![(draw.body(), draw.state())];
        if two_bodies {
            movers.push((draw.body(), draw.state()));
        }
        let contacts = ContactSet::frictionless(&corners(count)).expect("a few");
        let mut law = Law::frictionless(draw.between(0.0, 1.0));
        if index > 5 {
            law.tilt_rad = [draw.between(-0.1, 0.1), draw.between(-0.1, 0.1)];
        }
        // Nothing but the rule is asked here: the pose need not be flat on the ground.
        assert!(check(&contacts, &movers, &law, &format!("case {index}")));
    }
}

#[test]
fn several_contacts_of_different_kinds() {
    let mut draw = Draw::new(24);
    let mut checked = 0;
    for _ in 0..DRAWS {
        let first = Case::draw(&mut draw, 3, true);
        let second = Case::draw(&mut draw, 8, true);
        let movers = movers(&first);
        let frames = (frame(Some(&movers[0])), frame(Some(&movers[1])));
        let rates = second.contact.touch_derivative(&frames.0, &frames.1);
        if rates.is_ok_and(|(_, rates)| rates.on_a.norm() + rates.on_b.norm() < 8.0) {
            let contacts = [first.contact, second.contact];
            let contacts = ContactSet::frictionless(&contacts).expect("two");
            let law = Law::frictionless(first.law.restitution);
            assert!(check(&contacts, &movers, &law, "a rim and an edge"));
            checked += 1;
        }
        if checked == 6 {
            return;
        }
    }
    panic!("only {checked} cases in {DRAWS} draws");
}

#[test]
fn a_face_that_lands_flat_with_friction() {
    let mut draw = Draw::new(26);
    let contacts = ContactSet::with_friction(&corners(3)).expect("a face");
    let (mut stuck, mut slid, mut receded) = (0, 0, 0);
    for index in 0..60 {
        let movers = vec![(draw.body(), draw.state())];
        let law = Law {
            restitution: draw.between(0.0, 1.0),
            friction: draw.between(0.05, 1.5),
            tangential_restitution: 0.0,
            tilt_rad: match index % 3 {
                0 => [draw.between(-0.1, 0.1), draw.between(-0.1, 0.1)],
                _ => [0.0; 2],
            },
        };
        if !check(&contacts, &movers, &law, &format!("case {index}")) {
            continue;
        }
        let impact = contacts.impact(&side(&movers[0]), None, &law);
        let impact = impact.expect("regular");
        let recedes = movers[0].1.velocity_m_s.z > 0.0;
        stuck += usize::from(impact.sticks);
        receded += usize::from(recedes);
        slid += usize::from(!impact.sticks && !recedes);
    }
    assert!(
        stuck > 3 && slid > 3 && receded > 3,
        "{stuck} {slid} {receded}"
    );
}
