//! Impacts of links with each other: of two trees, of a tree and a body by itself, of one tree.

use nalgebra::{DMatrix, Vector3};

use super::examples::{GRAVITY, PIN, bush, chain, off, rods, trees};
use crate::math::Pose;
use crate::math::random::Random;
use crate::physics::contact::{Contact, Feature};
use crate::physics::impact::{ContactSet, Law, Side};
use crate::physics::tree::{
    Forest, ForestSnapshot, Joint, JointKind, Link, LinkContact, Tree, TreeImpact,
    TreeImpactDerivative, TreeState,
};
use crate::physics::{Body, State};

fn body() -> Body {
    Body::new(0.3, Vector3::new(4e-3, 5e-3, 3e-3)).unwrap()
}

/// A body by itself.
fn alone(body: Body) -> Tree {
    let joint = Joint::new(JointKind::Free, Pose::identity(), Pose::identity());
    Tree::new(&[Link {
        parent: None,
        joint,
        body,
    }])
    .unwrap()
}

/// What meets: two links of some trees.
struct Meet {
    name: &'static str,
    forest: Forest,
    places: [usize; 2],
}

fn meets() -> Vec<Meet> {
    let of = |name, trees: Vec<Tree>, places| Meet {
        name,
        forest: Forest::new(trees),
        places,
    };
    let pins = || Tree::new(&rods(2, PIN, PIN)).unwrap();
    vec![
        of("two bodies", vec![alone(body()), alone(body())], [0, 1]),
        of("chain and body", vec![alone(body()), chain()], [3, 0]),
        of("body and bush", vec![bush(false), alone(body())], [8, 6]),
        of("two trees", vec![pins(), chain(), bush(true)], [1, 9]),
        of("a chain's ends", vec![chain()], [2, 0]),
        of("two of a bush", vec![alone(body()), bush(true)], [4, 7]),
        of("two of a clamped bush", vec![bush(false)], [7, 4]),
    ]
}

/// Pairs of features of two links, and two and three that touch at once; of the last pair, the second one's is no face.
fn contacts(random: &mut Random) -> Vec<ContactSet> {
    let mut vector = || Vector3::new(random.signed(), random.signed(), random.signed());
    let point = |point_m, radius_m| Feature::Point { point_m, radius_m };
    let face = Feature::Face {
        point_m: vector() * 0.2,
        normal: vector().normalize(),
    };
    let rim = Feature::Rim {
        centre_m: vector() * 0.2,
        axis: Vector3::z(),
        radius_m: 0.05,
    };
    let side = Feature::Line {
        point_m: vector() * 0.3,
        direction: vector().normalize(),
        radius_m: 0.02,
    };
    let pairs = [
        (point(vector() * 0.2, 0.0), face),
        (point(vector() * 0.2, 0.1), face),
        (rim, face),
        (point(vector() * 0.2, 0.1), side),
        (side, point(vector() * 0.2, 0.1)),
        (point(vector() * 0.2, 0.1), point(vector() * 0.3, 0.2)),
        (face, point(vector() * 0.2, 0.1)),
    ];
    let pairs = pairs.map(|(a, b)| Contact::new(a, b).unwrap());
    let single = pairs.iter().map(|pair| ContactSet::with_friction(&[*pair]));
    let several = [&pairs[..2], &pairs[1..4]].map(ContactSet::frictionless);
    single.chain(several).map(Result::unwrap).collect()
}

fn law(restitution: f64, friction: f64, tilt_rad: [f64; 2]) -> Law {
    Law {
        restitution,
        friction,
        tangential_restitution: 0.0,
        tilt_rad,
    }
}

fn snapshot<'f>(forest: &'f Forest, state: &TreeState) -> ForestSnapshot<'f> {
    let mut snapshot = ForestSnapshot::new(forest, &GRAVITY);
    snapshot.set(state);
    snapshot
}

fn impact(forest: &Forest, state: &TreeState, at: &LinkContact, law: &Law) -> TreeImpact {
    snapshot(forest, state).impact(state, at, law).unwrap()
}

fn some_state(forest: &Forest, random: &mut Random) -> TreeState {
    let freedoms = forest.freedoms();
    let delta: Vec<f64> = (0..2 * freedoms)
        .map(|at| random.signed() * if at < freedoms { 1.2 } else { 3.0 })
        .collect();
    forest.retract(&forest.at_rest(), &delta)
}

fn after(state: &TreeState, impact: &TreeImpact) -> TreeState {
    TreeState {
        rates: impact.rates.clone(),
        ..state.clone()
    }
}

/// Whether a law may be that of these contacts.
pub(super) fn suits(contacts: &ContactSet, law: &Law) -> bool {
    let is_tilted = law.tilt_rad != [0.0; 2];
    (!is_tilted || contacts.check_tilt().is_ok())
        && (law.friction == 0.0 || contacts.has_friction())
        && (law.tangential_restitution == 0.0 || contacts.check_spring_back().is_ok())
}

/// Gaps and speeds of all contacts, and rates after.
pub(super) fn numbers(of: &TreeImpact) -> Vec<f64> {
    [&of.gaps_m[..], &of.speeds_m_s, &of.rates].concat()
}

/// Their derivatives, a row each.
pub(super) fn derivatives(of: &TreeImpactDerivative) -> DMatrix<f64> {
    let rows = of.gaps.iter().chain(&of.speeds).map(|row| row.transpose());
    let rows: Vec<_> = rows
        .chain(of.rates.row_iter().map(|row| row.into()))
        .collect();
    DMatrix::from_rows(&rows)
}

/// What approaches in some states, by each of these laws.
fn each(laws: &[Law], mut check: impl FnMut(&Meet, &TreeState, &LinkContact, &Law)) {
    let mut random = Random::default();
    for meet in meets() {
        for contacts in contacts(&mut random) {
            let at = LinkContact {
                place: meet.places[0],
                other: Some(meet.places[1]),
                contacts,
            };
            let mut state = some_state(&meet.forest, &mut random);
            let frictionless = Law::frictionless(0.0);
            if impact(&meet.forest, &state, &at, &frictionless).speeds_m_s[0] > 0.0 {
                state.rates.iter_mut().for_each(|rate| *rate = -*rate);
            }
            for law in laws {
                if suits(&contacts, law) {
                    check(&meet, &state, &at, law);
                }
            }
        }
    }
}

/// Momentum, and angular momentum about the world's origin, of a tree.
fn momenta(forest: &Forest, state: &TreeState, tree: usize) -> [Vector3<f64>; 2] {
    let (centre_m, momentum, spin) = snapshot(forest, state).trees[tree].momentum();
    [momentum, spin + centre_m.cross(&momentum)]
}

fn energy_j(forest: &Forest, state: &TreeState) -> f64 {
    let trees = snapshot(forest, state).trees;
    trees.iter().map(|tree| tree.kinetic_energy()).sum()
}

/// Restitution, energy, cone; action and reaction: flying systems together keep their momenta, and one that flies gains
/// the impulse.
#[test]
fn the_law_keeps_its_promises_for_two_links() {
    let laws = [0.0, 0.4, 1.0].map(|e| [0.0, 0.1, 0.5, 3.0].map(|mu| law(e, mu, [0.0; 2])));
    let (mut stuck, mut slid, mut lossless, mut kept, mut pulled) = (0, 0, 0, 0, 0);
    each(laws.as_flattened(), |meet, state, at, law| {
        let Meet { name, forest, .. } = meet;
        let hit = impact(forest, state, at, law);
        let later = after(state, &hit);
        let again = impact(forest, &later, at, law);
        for (again, speed) in again.speeds_m_s.iter().zip(&hit.speeds_m_s) {
            let rebound = again + law.restitution * speed;
            assert!(rebound.abs() < 1e-10, "{name} {law:?}: {rebound}");
        }
        let lost = energy_j(forest, state) - energy_j(forest, &later);
        assert!(lost > -1e-11, "{name} {law:?}: {lost}");
        if law.restitution == 1.0 && law.friction == 0.0 {
            assert!(lost.abs() < 1e-11, "{name}: {lost}");
            lossless += 1;
        }
        for (impulse, along) in hit.impulses_n_s.iter().zip(&hit.normal_impulses_n_s) {
            // Of several that come as they like, one may be lifted off.
            assert!(*along > 0.0 || hit.gaps_m.len() > 1, "{name}");
            pulled += usize::from(*along < 0.0);
            let across = impulse.norm_squared() - along.powi(2);
            // The root of what is left of two squares.
            let most = (law.friction + 1e-7) * along.abs() * (1.0 + 1e-9);
            assert!(across.max(0.0).sqrt() <= most, "{name} {law:?}");
        }
        stuck += usize::from(hit.sticks);
        slid += usize::from(!hit.sticks && law.friction > 0.0);

        let own = |place: usize| forest.tree_of(place).0;
        let sides = [(own(at.place), 1.0), (own(at.other.unwrap()), -1.0)];
        let gained = |tree: usize| {
            let [was, is] = [state, &later].map(|of| momenta(forest, of, tree));
            [is[0] - was[0], is[1] - was[1]]
        };
        let flies = |tree: usize| forest.trees()[tree].translations() > 0;
        let is_one = sides[0].0 == sides[1].0;
        for (tree, sign) in sides.into_iter().filter(|(tree, _)| flies(*tree)) {
            let of_impulse = match is_one {
                true => Vector3::zeros(),
                false => hit.impulses_n_s.iter().sum::<Vector3<f64>>() * sign,
            };
            assert!((gained(tree)[0] - of_impulse).norm() < 1e-11, "{name}");
        }
        if sides.iter().all(|(tree, _)| flies(*tree)) {
            let mut turned = gained(sides[0].0)[1];
            if !is_one {
                turned += gained(sides[1].0)[1];
                // The points of both sides are where the contact is but for its gap.
                let gaps = hit.gaps_m.iter().zip(&hit.impulses_n_s);
                let most: f64 = gaps.map(|(gap, impulse)| gap.abs() * impulse.norm()).sum();
                assert!(turned.norm() <= most + 1e-10, "{name}");
            }
            kept += 1;
        }
        for tree in 0..forest.trees().len() {
            if sides.iter().all(|(side, _)| *side != tree) {
                let rates = forest.rates_of(tree);
                assert_eq!(state.rates[rates.clone()], later.rates[rates], "{name}");
            }
        }
    });
    assert!(
        stuck > 50 && slid > 50 && lossless > 30 && kept > 100 && pulled > 5,
        "{stuck} {slid} {lossless} {kept} {pulled}"
    );
}

#[test]
fn derivatives_of_an_impact_of_two_links_are_those_of_differences() {
    let laws = [
        law(0.6, 0.0, [0.0; 2]),
        law(0.3, 0.15, [0.0; 2]),
        law(0.3, 50.0, [0.0; 2]),
        law(0.5, 0.2, [0.07, -0.04]),
    ];
    let mut sticking = [0; 2];
    each(&laws, |meet, state, at, law| {
        let Meet { name, forest, .. } = meet;
        let both = snapshot(forest, state).impact_derivative(state, at, law);
        let (here, given) = both.unwrap();
        sticking[usize::from(here.sticks)] += 1;
        let worst = off(&derivatives(&given), |delta| {
            let delta: Vec<f64> = delta.iter().map(|x| 0.01 * x).collect();
            let there = impact(forest, &forest.retract(state, &delta), at, law);
            numbers(&there).iter().map(|x| x / 0.01).collect()
        });
        assert!(worst < 1e-6, "{name} {at:?} {law:?}: {worst:e}");
        let by_tilt = given.by_tilt.map(|by_tilt| {
            off(&by_tilt, |delta| {
                let mut law = *law;
                law.tilt_rad[0] += 0.1 * delta[0];
                law.tilt_rad[1] += 0.1 * delta[1];
                let there = impact(forest, state, at, &law);
                there.rates.iter().map(|x| x / 0.1).collect()
            })
        });
        assert!(by_tilt.is_none_or(|worst| worst < 1e-6), "{name} {law:?}");
    });
    assert!(sticking.iter().all(|count| *count > 10), "{sticking:?}");
}

/// Two trees of one free link each are two bodies by themselves, whose law is written down elsewhere.
#[test]
fn of_two_bodies_by_themselves_it_is_their_impact() {
    let other = Body::new(0.7, Vector3::new(0.02, 0.03, 0.025)).unwrap();
    let bodies = [body(), other];
    let forest = Forest::new(bodies.map(alone).to_vec());
    let mut random = Random::default();
    let mut hits = 0;
    for _ in 0..20 {
        for contacts in contacts(&mut random) {
            let state = some_state(&forest, &mut random);
            let at = LinkContact {
                place: 0,
                other: Some(1),
                contacts,
            };
            let law = law(
                0.5 + 0.5 * random.signed(),
                match contacts.has_friction() {
                    true => 0.5 + 0.5 * random.signed(),
                    false => 0.0,
                },
                match contacts.check_tilt() {
                    Ok(()) => [0.1 * random.signed(), 0.1],
                    Err(_) => [0.0; 2],
                },
            );
            let found = impact(&forest, &state, &at, &law);
            let here = snapshot(&forest, &state);
            let states: [State; 2] = [0, 1].map(|place| here.link_state(place));
            let sides = [0, 1].map(|side| Side {
                body: &bodies[side],
                state: &states[side],
            });
            let expected = contacts.impact(&sides[0], Some(&sides[1]), &law).unwrap();
            for contact in 0..found.gaps_m.len() {
                let off = |a: &[f64], b: &[f64]| (a[contact] - b[contact]).abs();
                assert!(off(&found.gaps_m, &expected.gaps_m) < 1e-12);
                assert!(off(&found.speeds_m_s, &expected.speeds_m_s) < 1e-11);
                let [own, other] = [
                    &found.normal_impulses_n_s[..],
                    &expected.normal_impulses_n_s,
                ];
                assert!(off(own, other) < 1e-10);
            }
            for (rates, after) in found.rates.chunks_exact(6).zip(expected.after) {
                let velocities = after.velocity_m_s.iter();
                let velocities = velocities.chain(&after.angular_velocity_rad_s);
                for (rate, velocity) in rates.iter().zip(velocities) {
                    let off = (rate - velocity).abs() / (1.0 + velocity.abs());
                    assert!(off < 1e-10, "{contacts:?} {law:?}: {off:e}");
                }
            }
            hits += usize::from(found.speeds_m_s[0] < 0.0);
        }
    }
    assert!(hits > 40, "{hits}");
}

/// Trees side by side move and differ as each does.
#[test]
fn a_forest_moves_as_its_trees() {
    let mut random = Random::default();
    for (name, tree) in trees() {
        let forest = Forest::new(vec![alone(body()), tree.clone(), chain()]);
        let state = some_state(&forest, &mut random);
        let delta: Vec<f64> = (0..2 * forest.freedoms())
            .map(|_| random.signed())
            .collect();
        let moved = forest.retract(&state, &delta);
        for (found, given) in forest.minus(&moved, &state).iter().zip(&delta) {
            assert!((found - given).abs() < 1e-12, "{name}");
        }
        let own = forest.rates_of(1);
        let own_delta = [&delta[own.clone()], {
            let first = forest.freedoms();
            &delta[first + own.start..first + own.end]
        }];
        let expected = tree.retract(&forest.part(&state, 1), &own_delta.concat());
        assert_eq!(*forest.part(&moved, 1), expected, "{name}");
        let exact = forest.minus_jacobians(&moved, &state)[0].clone();
        let worst = off(&exact, |by| {
            forest.minus(&forest.retract(&moved, by), &state)
        });
        assert!(worst < 1e-8, "{name}: {worst:e}");
    }
}
