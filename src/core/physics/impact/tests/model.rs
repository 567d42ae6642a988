//! Derivatives by the model against differences of impacts of other models.

use nalgebra::SMatrix;

use super::*;
use crate::math::Pose;
use crate::physics::impact::ImpactByModel;

/// Columns: of each body `ln` mass, three `ln` moments, three shifts; then of each contact the
/// displacement and rotation of the world's feature.
const BODY: usize = 7;
const PLACE: usize = 2 * BODY;
const COLUMNS: usize = PLACE + 3 * 6;

/// Step of the differences in these units.
const STEP: f64 = 0.1;

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

/// The same rows of the derivative.
fn expected(by: &ImpactByModel, row: usize, column: usize) -> f64 {
    if column >= PLACE {
        let (contact, axis) = ((column - PLACE) / 6, (column - PLACE) % 6);
        return match row {
            0..3 if row == contact => by.gap_by_place[contact][axis],
            3..6 if row - 3 == contact => by.speed_by_place[contact][axis],
            6..12 => by.after_by_place[contact][(row - 6, axis)],
            _ => 0.0,
        };
    }
    let (body, of_body) = (column / BODY, column % BODY);
    match (row, of_body) {
        (0..6, 0..4) => 0.0,
        (0..3, _) => by.gap_by_shift[row][body][of_body - 4],
        (3..6, _) => by.speed_by_shift[row - 3][body][of_body - 4],
        _ => {
            let (i, row) = ((row - 6) / 6, (row - 6) % 6);
            match of_body {
                0 => by.after_by_mass[i][body][row],
                1..4 => by.after_by_moments[i][body][(row, of_body - 1)],
                _ => by.after_by_shift[i][body][(row, of_body - 4)],
            }
        }
    }
}

/// A body with other mass and moments.
fn remade(body: &Body, d: &[f64]) -> Body {
    let moments = Vector3::from_fn(|i, _| body.moments_kg_m2()[i] * d[1 + i].exp());
    Body::new(body.mass_kg() * d[0].exp(), moments).expect("a body")
}

/// A contact with its features elsewhere.
fn moved(contact: &Contact, d: &[f64], index: usize, in_world: bool) -> Contact {
    let three = |at: usize| Vector3::from_column_slice(&d[at..at + 3]);
    let contact = contact
        .with_shifts([three(4), three(BODY + 4)])
        .expect("regular");
    let at = PLACE + 6 * index;
    if !in_world || d[at..at + 6] == [0.0; 6] {
        return contact;
    }
    let own_m = contact.b().place_m();
    let turned = contact
        .b()
        .shifted(&-own_m)
        .placed(&Pose::rotation(three(at + 3)));
    let placed = turned.shifted(&(own_m + three(at)));
    Contact::new(*contact.a(), placed).expect("regular")
}

/// Compares all derivatives with differences, unless a switch is within their reach; returns
/// whether it did.
fn check(contacts: &ContactSet, movers: &[Mover], law: &Law, name: &str) -> bool {
    let in_world = movers.len() == 1;
    let at = |d: &[f64]| {
        let d: Vec<f64> = d.iter().map(|x| STEP * x).collect();
        let bodies: Vec<Mover> = movers
            .iter()
            .zip(d.chunks(BODY))
            .map(|((body, state), d)| (remade(body, d), *state))
            .collect();
        let all = contacts.as_slice().iter().enumerate();
        let all: Vec<Contact> = all
            .map(|(index, contact)| moved(contact, &d, index, in_world))
            .collect();
        let all = if contacts.has_friction() {
            ContactSet::with_friction(&all)
        } else {
            ContactSet::frictionless(&all)
        };
        all.expect("as many")
            .impact(&side(&bodies[0]), bodies.get(1).map(side).as_ref(), law)
            .expect("regular")
    };
    let base = at(&[0.0; COLUMNS]);
    let branches_differ = (0..2 * COLUMNS).any(|probe| {
        let mut d = [0.0; COLUMNS];
        d[probe / 2] = if probe % 2 == 0 { 0.02 } else { -0.02 };
        at(&d).sticks != base.sticks
    });
    if branches_differ {
        return false;
    }
    let b = movers.get(1).map(side);
    let by = contacts.by_model(&side(&movers[0]), b.as_ref(), law);
    let by = by.expect("regular");
    let numeric = differentiate::jacobian(18, COLUMNS, |d| {
        values(&at(d)).iter().map(|x| x / STEP).collect()
    });
    for row in 0..18 {
        for column in 0..COLUMNS {
            // Shifts of B's features are those of a body only.
            if in_world && (BODY..PLACE).contains(&column) {
                assert_eq!(expected(&by, row, column), 0.0);
                continue;
            }
            let (found, known) = (numeric[row][column], expected(&by, row, column));
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
fn all_kinds_of_contact_with_friction_and_without() {
    let mut draw = Draw::new(51);
    let (mut stuck, mut slid, mut smooth) = ([0; KINDS], [0; KINDS], [0; KINDS]);
    for index in 0..24 * KINDS {
        let (kind, round) = (index % KINDS, index / KINDS);
        let mut case = Case::draw(&mut draw, kind, round % 2 == 0);
        let name = format!("case {index}, kind {kind}");
        if round % 3 == 0 {
            case.law.friction = 0.0;
            let contacts = ContactSet::frictionless(&[case.contact]).expect("one");
            smooth[kind] += usize::from(check(&contacts, &movers(&case), &case.law, &name));
            continue;
        }
        let contacts = ContactSet::with_friction(&[case.contact]).expect("one");
        if check(&contacts, &movers(&case), &case.law, &name) {
            let count = if case.impact().sticks {
                &mut stuck
            } else {
                &mut slid
            };
            count[kind] += 1;
        }
    }
    let least = |counts: &[usize; KINDS]| counts.iter().all(|count| *count >= 1);
    assert!(
        least(&stuck) && least(&slid) && least(&smooth),
        "{stuck:?} {slid:?} {smooth:?}"
    );
}

#[test]
fn several_contacts() {
    let mut draw = Draw::new(52);
    for index in 0..8 {
        let count = 2 + index % 2;
        let mut movers = vec![(draw.body(), draw.state())];
        if index % 4 < 2 {
            movers.push((draw.body(), draw.state()));
        }
        let contacts = ContactSet::frictionless(&corners(count)).expect("a few");
        let law = Law::frictionless(draw.between(0.0, 1.0));
        assert!(check(&contacts, &movers, &law, &format!("case {index}")));
    }
}

/// Height and tilts of a whole surface, about none and about some, with a tilt of the law as well.
#[test]
fn a_surface_that_lies_elsewhere() {
    let mut draw = Draw::new(53);
    let mut checked = 0;
    for index in 0..60 {
        let case = Case::draw(&mut draw, [0, 1, 3][index % 3], false);
        let several = index % 5 == 0;
        let nominal = if several {
            corners(3)
        } else {
            vec![case.contact]
        };
        let mut law = case.law;
        let is_smooth = several && index % 2 == 0;
        if is_smooth {
            law.friction = 0.0;
        }
        if index % 2 == 0 {
            law.tilt_rad = [draw.between(-0.1, 0.1), draw.between(-0.1, 0.1)];
        }
        let there = match index % 4 {
            0 | 1 => [0.0; 3],
            _ => [0.0; 3].map(|_: f64| draw.between(-0.1, 0.1)),
        };
        let set = |d: &[f64]| {
            let [h, s, t] = [0, 1, 2].map(|i| there[i] + STEP * d[i]);
            let moved: Vec<_> = nominal
                .iter()
                .map(|contact| contact.with_surface(h, [s, t]).expect("a face"))
                .collect();
            let contacts: Vec<Contact> = moved.iter().map(|(contact, _)| *contact).collect();
            let contacts = if is_smooth {
                ContactSet::frictionless(&contacts)
            } else {
                ContactSet::with_friction(&contacts)
            };
            (contacts.expect("a few"), moved[0].1)
        };
        let at = |d: &[f64]| {
            set(d)
                .0
                .impact(&side(&case.a), None, &law)
                .expect("regular")
        };
        let base = at(&[0.0; 3]);
        let branches_differ = (0..6).any(|probe| {
            let mut d = [0.0; 3];
            d[probe / 2] = if probe % 2 == 0 { 0.02 } else { -0.02 };
            at(&d).sticks != base.sticks
        });
        if branches_differ {
            continue;
        }
        let (contacts, motion) = set(&[0.0; 3]);
        let by = contacts.by_model(&side(&case.a), None, &law);
        let by = by.expect("regular");
        let numeric =
            differentiate::jacobian(18, 3, |d| values(&at(d)).iter().map(|x| x / STEP).collect());
        let count = nominal.len();
        let after: SMatrix<f64, 6, 6> = by.after_by_place[..count].iter().sum();
        let after = after * motion;
        for column in 0..3 {
            for contact in 0..count {
                let gap = (by.gap_by_place[contact] * motion)[column];
                let speed = (by.speed_by_place[contact] * motion)[column];
                assert!((numeric[contact][column] - gap).abs() < 1e-8 * (1.0 + gap.abs()));
                let found = numeric[3 + contact][column];
                assert!((found - speed).abs() < 1e-8 * (1.0 + speed.abs()));
            }
            for row in 0..6 {
                let (found, known) = (numeric[6 + row][column], after[(row, column)]);
                assert!(
                    (found - known).abs() < 2e-8 * (1.0 + known.abs()),
                    "{index}: {row} {column}: {known} against {found}"
                );
            }
        }
        checked += 1;
    }
    assert!(checked > 40, "{checked}");
}

#[test]
fn a_face_that_lands_flat_with_friction() {
    let mut draw = Draw::new(54);
    let contacts = ContactSet::with_friction(&corners(3)).expect("a face");
    let (mut stuck, mut slid) = (0, 0);
    for index in 0..40 {
        let (body, state) = (draw.body(), draw.state());
        let law = Law {
            restitution: draw.between(0.0, 1.0),
            friction: draw.between(0.05, 1.5),
            tangential_restitution: 0.0,
            tilt_rad: [0.0; 2],
        };
        let at = |d: &[f64]| {
            let d: Vec<f64> = d.iter().map(|x| STEP * x).collect();
            let a = (remade(&body, &d), state);
            contacts.impact(&side(&a), None, &law).expect("regular")
        };
        let base = at(&[0.0; 4]);
        let is_near = |axis: usize| {
            [-0.02, 0.02].iter().any(|by| {
                let mut d = [0.0; 4];
                d[axis] = *by;
                at(&d).sticks != base.sticks
            })
        };
        if (0..4).any(is_near) {
            continue;
        }
        let by = contacts.by_model(&side(&(body, state)), None, &law);
        let by = by.expect("regular");
        let numeric =
            differentiate::jacobian(18, 4, |d| values(&at(d)).iter().map(|x| x / STEP).collect());
        for row in 0..18 {
            for column in 0..4 {
                let (found, known) = (numeric[row][column], expected(&by, row, column));
                assert!(
                    (found - known).abs() < 2e-8 * (1.0 + known.abs()),
                    "case {index}: row {row}, column {column}: {known} against {found}"
                );
            }
        }
        stuck += usize::from(base.sticks);
        slid += usize::from(!base.sticks);
    }
    assert!(stuck > 3 && slid > 3, "{stuck} {slid}");
}
