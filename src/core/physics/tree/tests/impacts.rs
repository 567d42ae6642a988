//! Impacts of trees: the law's promises, bodies by themselves, closed forms and differences.

use nalgebra::{DMatrix, DVector, UnitQuaternion, Vector3};

use super::examples::{GRAVITY, PIN, at, inverse_mass_at, off, rod, rods, some_state, trees};
use super::meetings::{derivatives, numbers, suits};
use crate::math::Pose;
use crate::math::random::Random;
use crate::physics::contact::{Contact, Feature, Frame};
use crate::physics::impact::{self, ContactSet, ImpactError, Law};
use crate::physics::tree::{
    Forest, ForestSnapshot, Joint, JointKind, Link, LinkContact, Snapshot, Tree, TreeImpact,
    TreeImpactDerivative, TreeState,
};
use crate::physics::{Body, State};

const FLOOR: Feature = Feature::Face {
    point_m: Vector3::new(0.0, 0.0, 0.0),
    normal: Vector3::new(0.0, 0.0, 1.0),
};

/// A point, a ball, a rim and a side of a link, each with something of the world that it touches, and two and three
/// that touch at once.
fn contacts(random: &mut Random) -> Vec<ContactSet> {
    let mut vector = || Vector3::new(random.signed(), random.signed(), random.signed());
    let point = |point_m, radius_m| Feature::Point { point_m, radius_m };
    let face = Feature::Face {
        point_m: vector(),
        normal: vector().normalize(),
    };
    let rim = Feature::Rim {
        centre_m: vector() * 0.2,
        axis: Vector3::z(),
        radius_m: 0.05,
    };
    let edge = Feature::Line {
        point_m: vector() + Vector3::new(0.0, 0.0, 4.0),
        direction: vector().normalize(),
        radius_m: 0.0,
    };
    let pairs = [
        (point(vector() * 0.2, 0.0), face),
        (point(vector() * 0.2, 0.1), FLOOR),
        (rim, face),
        (point(vector() * 0.2, 0.1), edge),
        (point(vector() * 0.2, 0.1), point(vector() * 3.0, 0.2)),
    ];
    let pairs = pairs.map(|(a, b)| Contact::new(a, b).unwrap());
    let single = pairs.iter().map(|pair| ContactSet::with_friction(&[*pair]));
    let several = [&pairs[..2], &pairs[..3]].map(ContactSet::frictionless);
    single.chain(several).map(Result::unwrap).collect()
}

/// Trees in some states with some contact, the last link's, and their impacts by these laws. Contacts that
/// recede move the other way instead.
fn each(laws: &[Law], mut check: impl FnMut(&str, &Tree, &TreeState, &ContactSet, &Law)) {
    let (mut several, mut held) = (0, 0);
    let mut random = Random::default();
    let mut all = trees();
    let pins = |count| Tree::new(&rods(count, PIN, PIN)).unwrap();
    all.extend([("one pin", pins(1)), ("four pins", pins(4))]);
    for (name, tree) in all {
        for contact in contacts(&mut random) {
            let mut state = some_state(&tree, &mut random, 1.2, 3.0);
            let count = contact.as_slice().len();
            let any = match impact(&tree, &state, &contact, &Law::frictionless(0.0)) {
                // Fewer freedoms than contacts.
                Err(ImpactError::Dependent { .. }) if tree.freedoms() < count => {
                    held += 1;
                    continue;
                }
                any => any.unwrap(),
            };
            several += usize::from(count > 1);
            if any.speeds_m_s[0] > 0.0 {
                state.rates.iter_mut().for_each(|rate| *rate = -*rate);
            }
            for law in laws {
                if suits(&contact, law) {
                    check(name, &tree, &state, &contact, law);
                }
            }
        }
    }
    assert!(several > 10 && held > 1, "{several} {held}");
}

fn snapshot<'t>(tree: &'t Tree, state: &TreeState) -> Snapshot<'t> {
    let mut snapshot = Snapshot::new(tree, &GRAVITY);
    snapshot.set(state);
    snapshot
}

/// The last link of a tree and the static world.
fn with_world(tree: &Tree, contacts: &ContactSet) -> (Forest, LinkContact) {
    let touching = LinkContact {
        place: tree.link_count() - 1,
        other: None,
        contacts: *contacts,
    };
    (Forest::new(vec![tree.clone()]), touching)
}

fn impact(
    tree: &Tree,
    state: &TreeState,
    contact: &ContactSet,
    law: &Law,
) -> Result<TreeImpact, ImpactError> {
    let (forest, touching) = with_world(tree, contact);
    let mut snapshot = ForestSnapshot::new(&forest, &GRAVITY);
    snapshot.set(state);
    snapshot.impact(state, &touching, law)
}

fn derivative(
    tree: &Tree,
    state: &TreeState,
    contact: &ContactSet,
    law: &Law,
) -> TreeImpactDerivative {
    let (forest, touching) = with_world(tree, contact);
    let mut snapshot = ForestSnapshot::new(&forest, &GRAVITY);
    snapshot.set(state);
    let both = snapshot.impact_derivative(state, &touching, law);
    both.unwrap().1
}

fn after(state: &TreeState, impact: &TreeImpact) -> TreeState {
    TreeState {
        rates: impact.rates.clone(),
        ..state.clone()
    }
}

/// The same where what sticks springs back.
fn springing(law: Law, tangential_restitution: f64) -> Law {
    Law {
        tangential_restitution,
        ..law
    }
}

fn law(restitution: f64, friction: f64, tilt_rad: [f64; 2]) -> Law {
    Law {
        restitution,
        friction,
        tangential_restitution: 0.0,
        tilt_rad,
    }
}

#[test]
fn the_law_keeps_its_promises_for_trees() {
    let laws = [0.0, 0.4, 1.0].map(|e| [0.0, 0.1, 0.5, 3.0].map(|mu| law(e, mu, [0.0; 2])));
    let back = [0.0, 1.0].map(|e| [0.5, 3.0].map(|mu| springing(law(e, mu, [0.0; 2]), 1.0)));
    let laws = [laws.as_flattened(), back.as_flattened()].concat();
    let (mut stuck, mut slid, mut lossless) = (0, 0, 0);
    each(&laws, |name, tree, state, contact, law| {
        let hit = impact(tree, state, contact, law).unwrap();
        let later = after(state, &hit);
        let again = impact(tree, &later, contact, law).unwrap();
        for (again, speed) in again.speeds_m_s.iter().zip(&hit.speeds_m_s) {
            let rebound = again + law.restitution * speed;
            assert!(rebound.abs() < 1e-10, "{name} {law:?}: {rebound}");
        }
        let energies = [state, &later].map(|of| snapshot(tree, of).energy(0.0));
        let lost = energies[0] - energies[1];
        assert!(lost > -1e-11, "{name} {law:?}: {lost}");
        let is_elastic = law.tangential_restitution == 1.0 && hit.sticks;
        if law.restitution == 1.0 && (law.friction == 0.0 || is_elastic) {
            assert!(lost.abs() < 1e-11, "{name}: {lost}");
            lossless += 1;
        }
        let link = snapshot(tree, state).link_state(tree.link_count() - 1);
        let frame = Frame::of(&link);
        for (contact, impulse) in contact.as_slice().iter().zip(&hit.impulses_n_s) {
            let touch = contact.touch(&frame, &Frame::world());
            let normal = touch.unwrap().normal;
            let along = impulse.dot(&normal);
            // Of several that come as they like, one may be lifted off.
            assert!(along > 0.0 || hit.gaps_m.len() > 1, "{name}");
            let across = (impulse - normal * along).norm();
            assert!(
                across <= law.friction * along.abs() * (1.0 + 1e-9) + 1e-12,
                "{name} {law:?}"
            );
        }
        stuck += usize::from(hit.sticks);
        slid += usize::from(!hit.sticks && law.friction > 0.0);
    });
    assert!(
        stuck > 50 && slid > 50 && lossless > 30,
        "{stuck} {slid} {lossless}"
    );
}

#[test]
fn derivatives_of_an_impact_are_those_of_differences() {
    let laws = [
        law(0.6, 0.0, [0.0; 2]),
        law(0.3, 0.15, [0.0; 2]),
        law(0.3, 50.0, [0.0; 2]),
        law(0.5, 0.2, [0.07, -0.04]),
        springing(law(0.3, 50.0, [0.05, 0.02]), 0.4),
        springing(law(0.3, 0.15, [0.0; 2]), 0.4),
    ];
    let mut sticking = [0; 2];
    each(&laws, |name, tree, state, contact, law| {
        let given = derivative(tree, state, contact, law);
        let here = impact(tree, state, contact, law).unwrap();
        sticking[usize::from(here.sticks)] += 1;
        let freedoms = tree.freedoms();
        let worst = off(&derivatives(&given), |delta| {
            let delta: Vec<f64> = delta.iter().map(|x| 0.03 * x).collect();
            let there = impact(tree, &tree.retract(state, &delta), contact, law).unwrap();
            numbers(&there).iter().map(|x| x / 0.03).collect()
        });
        assert!(worst < 1e-7, "{name} {contact:?} {law:?}: {worst:e}");
        let mut by_law = DMatrix::zeros(freedoms, 5);
        by_law.set_column(0, &given.by_restitution);
        by_law.set_column(1, &given.by_friction);
        by_law.set_column(4, &given.by_tangential_restitution);
        if let Some(by_tilt) = &given.by_tilt {
            by_law.columns_mut(2, 2).copy_from(by_tilt);
        }
        let can_tilt = given.by_tilt.is_some();
        if law.friction == 0.0 {
            // Less friction than none is none.
            by_law.column_mut(1).fill(0.0);
        }
        let springs_back = law.friction > 0.0 && contact.check_spring_back().is_ok();
        if !springs_back {
            by_law.column_mut(4).fill(0.0);
        }
        by_law.column_mut(1).scale_mut(0.1);
        let worst = off(&by_law, |delta| {
            let mut law = *law;
            law.restitution += delta[0];
            if law.friction > 0.0 {
                law.friction += 0.1 * delta[1];
            }
            if can_tilt {
                law.tilt_rad[0] += delta[2];
                law.tilt_rad[1] += delta[3];
            }
            if springs_back {
                law.tangential_restitution += delta[4];
            }
            impact(tree, state, contact, &law).unwrap().rates
        });
        assert!(worst < 1e-7, "{name} {contact:?} {law:?}: {worst:e}");
    });
    assert!(sticking.iter().all(|count| *count > 20), "{sticking:?}");
}

/// The mass matrix by polarisation of the kinetic energy, which is a quadratic form of the rates.
#[test]
fn the_response_of_a_contact_is_that_of_the_energys_mass_matrix() {
    let mut random = Random::default();
    for (name, tree) in trees() {
        let state = some_state(&tree, &mut random, 1.2, 0.0);
        let freedoms = tree.freedoms();
        let energy = |rates: DVector<f64>| {
            let moving = TreeState {
                rates: rates.as_slice().to_vec(),
                ..state.clone()
            };
            snapshot(&tree, &moving).energy(0.0)
        };
        let unit = |at: usize| DVector::from_fn(freedoms, |row, _| f64::from(u8::from(row == at)));
        let mass = DMatrix::from_fn(freedoms, freedoms, |i, j| {
            0.5 * (energy(unit(i) + unit(j)) - energy(unit(i) - unit(j)))
        });
        let inverse = mass.try_inverse().unwrap();
        let last = tree.link_count() - 1;
        let point = Vector3::new(0.1, -0.2, 0.3);
        let here = snapshot(&tree, &state);
        let mut jacobian = DMatrix::zeros(3, freedoms);
        here.point_jacobian(last, &point, &mut jacobian);
        let dense = &jacobian * inverse * jacobian.transpose();
        let found = inverse_mass_at(&tree, &state, (last, &point));
        let error = (found - dense.fixed_view::<3, 3>(0, 0)).amax() / found.amax();
        assert!(error < 1e-10, "{name}: {error:e}");
    }
}

fn state_of(tree: &Tree, place: &State) -> TreeState {
    let mut state = tree.at_rest();
    let base = TreeState::of_body(place);
    state.coordinates[..7].copy_from_slice(&base.coordinates);
    state.rates[..6].copy_from_slice(&base.rates);
    state
}

fn some_place(random: &mut Random) -> State {
    let mut vector = || Vector3::new(random.signed(), random.signed(), random.signed());
    State {
        position_m: vector(),
        orientation: UnitQuaternion::from_scaled_axis(vector() * 2.0),
        velocity_m_s: vector() * 2.0,
        angular_velocity_rad_s: vector() * 4.0,
    }
}

fn some_law(random: &mut Random) -> Law {
    let mut share = || 0.5 + 0.5 * random.signed();
    law(share(), share(), [0.1 * share(), -0.1 * share()])
}

fn on_floor(feature: Feature) -> ContactSet {
    ContactSet::with_friction(&[Contact::new(feature, FLOOR).unwrap()]).unwrap()
}

/// What an impact makes of a body by itself.
fn bounced(body: &Body, state: &State, contacts: ContactSet, law: &Law) -> State {
    let impact = contacts
        .impact(&impact::Side { body, state }, None, law)
        .unwrap();
    State {
        velocity_m_s: impact.after[0].velocity_m_s,
        angular_velocity_rad_s: impact.after[0].angular_velocity_rad_s,
        ..*state
    }
}

/// Two rods end to end with a fixed joint are a rod of their length.
#[test]
fn with_fixed_joints_it_is_the_impact_of_one_body() {
    let mut random = Random::default();
    let tree = Tree::new(&rods(2, JointKind::Free, JointKind::Fixed)).unwrap();
    let half = rod(0.1, 0.3).moments_kg_m2();
    let across = 2.0 * (half.x + 0.1 * 0.15 * 0.15);
    let whole = Body::new(0.2, Vector3::new(across, across, 2.0 * half.z)).unwrap();
    // The upper rod's centre is so far above that of both.
    let up = Vector3::new(0.0, 0.0, 0.15);
    for _ in 0..200 {
        let (place, law) = (some_place(&mut random), some_law(&mut random));
        let tip = |z| Feature::Point {
            point_m: Vector3::new(0.02, 0.0, z),
            radius_m: 0.01,
        };
        let state = state_of(&tree, &place);
        let hit = impact(&tree, &state, &on_floor(tip(-0.15)), &law).unwrap();
        let spin = place.angular_velocity_rad_s;
        let centre = State {
            position_m: place.position_m - place.orientation * up,
            velocity_m_s: place.velocity_m_s - place.orientation * spin.cross(&up),
            ..place
        };
        let alone = bounced(&whole, &centre, on_floor(tip(-0.3)), &law);
        let spin = alone.angular_velocity_rad_s;
        let velocity = alone.velocity_m_s + place.orientation * spin.cross(&up);
        let expected = [velocity.as_slice(), spin.as_slice()].concat();
        for (found, expected) in hit.rates.iter().zip(expected) {
            assert!(
                (found - expected).abs() < 1e-12 * (1.0 + expected.abs()),
                "{found} {expected}"
            );
        }
    }
}

/// A ball joint at both centres of mass carries the push over and no turn: a body with the mass of both and the
/// moments of its own.
#[test]
fn joined_at_both_centres_two_bodies_share_their_mass_alone() {
    let mut random = Random::default();
    let own = Body::new(0.4, Vector3::new(0.02, 0.03, 0.025)).unwrap();
    let other = Body::new(0.7, Vector3::new(0.05, 0.04, 0.03)).unwrap();
    let link = |parent, kind, body| Link {
        parent,
        joint: Joint::new(kind, Pose::identity(), Pose::identity()),
        body,
    };
    let links = [
        link(None, JointKind::Free, other),
        link(Some(0), JointKind::Ball, own),
    ];
    let tree = Tree::new(&links).unwrap();
    let both = Body::new(1.1, own.moments_kg_m2()).unwrap();
    for _ in 0..200 {
        let (place, law) = (some_place(&mut random), some_law(&mut random));
        let mut state = some_state(&tree, &mut random, 1.0, 4.0);
        state.coordinates[..3].copy_from_slice(place.position_m.as_slice());
        let corner = Feature::Point {
            point_m: Vector3::new(0.1, -0.2, 0.15),
            radius_m: 0.0,
        };
        let contact = on_floor(corner);
        let before = snapshot(&tree, &state);
        let hit = impact(&tree, &state, &contact, &law).unwrap();
        let later = after(&state, &hit);
        let alone = bounced(&both, &before.link_state(1), contact, &law);
        let found = snapshot(&tree, &later).link_state(1);
        assert!(found.minus(&alone).amax() < 1e-11);
        for axis in 3..6 {
            assert!((hit.rates[axis] - state.rates[axis]).abs() < 1e-12);
        }
    }
}

/// A rod on a pin hits a wall with its end: the rate is reversed and scaled, whatever the friction; where the
/// wall is along the way nothing can be said.
#[test]
fn a_pinned_rod_rebounds_by_its_rate_alone() {
    let tree = Tree::new(&rods(1, PIN, PIN)).unwrap();
    let mut state = tree.at_rest();
    (state.coordinates[0], state.rates[0]) = (0.4, 3.0);
    let tip = Feature::Point {
        point_m: at(-0.15).translation.vector,
        radius_m: 0.0,
    };
    let tangent = snapshot(&tree, &state).point_velocity(0, &Vector3::new(0.0, 0.0, -0.15));
    let along = snapshot(&tree, &state).point(0, &Vector3::new(0.0, 0.0, -0.15));
    for friction in [0.0, 0.3, 2.0] {
        let mixed = Vector3::x() + along.normalize() - tangent.normalize();
        let wall = |normal: Vector3<f64>| Feature::Face {
            point_m: along,
            normal: normal.normalize(),
        };
        let contact = |normal| {
            let contact = Contact::new(tip, wall(normal)).unwrap();
            ContactSet::with_friction(&[contact]).unwrap()
        };
        let law = law(0.7, friction, [0.0; 2]);
        let hit = impact(&tree, &state, &contact(mixed), &law).unwrap();
        assert!((hit.rates[0] + 0.7 * 3.0).abs() < 1e-12, "{friction}");
        for normal in [along, Vector3::x()] {
            let none = impact(&tree, &state, &contact(normal), &law);
            assert_eq!(none, Err(ImpactError::NoResponse));
        }
    }
}
