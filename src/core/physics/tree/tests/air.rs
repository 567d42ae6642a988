//! What pushes links, against bodies by themselves, closed forms and differences.

use nalgebra::{DMatrix, Vector3};

use super::examples::{GRAVITY, UNIVERSAL, ball, off, pushed, pushed_trees, rod, rods, some_state};
use super::hand::{STILL, hand, swung};
use super::{accelerations, flow as of_flow};
use crate::math::Pose;
use crate::math::random::Random;
use crate::physics::tree::tableau::DORMAND_PRINCE;
use crate::physics::tree::{Flow, Joint, JointKind, Link, Snapshot, Tree, TreeState};
use crate::physics::{Body, Drag, State, flow};

/// A tree of one free link.
fn alone(body: Body) -> Tree {
    let pose = Pose::identity();
    let joint = Joint::new(JointKind::Free, pose, pose);
    let link = Link {
        parent: None,
        joint,
        body,
    };
    Tree::new(&[link]).unwrap()
}

fn flown(tree: &Tree, from: &TreeState, for_s: f64) -> TreeState {
    let mut flow = Flow::new(tree, &GRAVITY, DORMAND_PRINCE);
    flow.begin(from, false);
    flow.reach(for_s, 2e-3);
    flow.state()
}

/// Of what flies, of what hangs from the world, and of what hangs from a hand that swings.
fn everywhere() -> Vec<(String, Tree)> {
    let of_world = pushed_trees().into_iter();
    let of_world = of_world.map(|(name, tree)| (name.to_owned(), tree));
    let in_hand = pushed_trees()
        .into_iter()
        .filter(|(_, tree)| tree.translations() == 0)
        .map(|(name, tree)| (format!("{name}, in a hand"), tree.in_hand(swung())));
    of_world.chain(in_hand).collect()
}

#[test]
fn derivatives_of_accelerations_are_exact() {
    let mut random = Random::default();
    for (name, tree) in everywhere() {
        let state = TreeState {
            time_s: 0.3,
            ..some_state(&tree, &mut random, 1.5, 4.0)
        };
        let off = accelerations::derivatives_off(&tree, &state);
        assert!(off < 1e-8, "{name}: {off:e}");
    }
}

#[test]
fn derivatives_of_the_flow_are_those_of_its_steps() {
    let mut random = Random::default();
    for (name, tree) in everywhere() {
        let state = TreeState {
            time_s: 0.3,
            ..some_state(&tree, &mut random, 1.0, 3.0)
        };
        let off = of_flow::derivatives_off(&tree, &state, 0.097, 0.04);
        assert!(off < 5e-9, "{name}: {off:e}");
    }
}

/// States of links change with those of the tree as differences say, where the base slides.
#[test]
fn links_of_a_pushed_tree_move_with_it() {
    let mut random = Random::default();
    for (name, tree) in pushed_trees() {
        let state = some_state(&tree, &mut random, 1.5, 4.0);
        let last = tree.link_count() - 1;
        let link = |state: &TreeState| {
            let mut snapshot = Snapshot::new(&tree, &GRAVITY);
            snapshot.set(state);
            snapshot.link_state(last)
        };
        let mut snapshot = Snapshot::new(&tree, &GRAVITY);
        snapshot.set(&state);
        let mut exact = DMatrix::zeros(crate::physics::state::DIMENSION, 2 * tree.freedoms());
        snapshot.link_jacobian(last, &mut exact);
        let here = link(&state);
        let off = off(&exact, |delta| {
            let there = link(&tree.retract(&state, delta));
            there.minus(&here).as_slice().to_vec()
        });
        assert!(off < 1e-9, "{name}: {off:e}");
    }
}

/// A free link flies as the body does by itself, with force, drag and lift.
#[test]
fn a_free_link_flies_as_a_body_by_itself() {
    for body in [pushed(ball(), 1.0), pushed(rod(0.1, 0.3), 2.0)] {
        let from = State {
            position_m: Vector3::new(0.1, -0.2, 1.0),
            velocity_m_s: Vector3::new(3.0, -1.0, 4.0),
            angular_velocity_rad_s: Vector3::new(5.0, -9.0, 12.0),
            ..State::at_rest()
        };
        let by_itself = flow::advance(&body, &GRAVITY, &from, 0.6);
        let tree = alone(body);
        let mut snapshot = Snapshot::new(&tree, &GRAVITY);
        snapshot.set(&flown(&tree, &TreeState::of_body(&from), 0.6));
        let off = snapshot.link_state(0).minus(&by_itself);
        assert!(off.amax() < 1e-9, "{off}");
    }
}

/// The same force per mass on all links is another gravity.
#[test]
fn a_force_on_all_links_is_another_gravity() {
    let force_m_s2 = Vector3::new(1.0, -2.0, 0.5);
    for kind in [JointKind::Free, JointKind::Ball] {
        let still = rods(3, kind, UNIVERSAL);
        let mut links = still.clone();
        for link in &mut links {
            link.body = link.body.with_force(force_m_s2).unwrap();
        }
        let (tree, plain) = (Tree::new(&links).unwrap(), Tree::new(&still).unwrap());
        let state = some_state(&tree, &mut Random::default(), 1.0, 3.0);
        let mut other = Flow::new(&plain, &(GRAVITY + force_m_s2), DORMAND_PRINCE);
        other.begin(&state, false);
        other.reach(0.4, 2e-3);
        let off = tree.minus(&flown(&tree, &state, 0.4), &other.state());
        let off = off.iter().fold(0.0_f64, |most, of| most.max(of.abs()));
        assert!(off < 1e-9, "{kind:?}: {off:e}");
    }
}

/// By a drag `k` in proportion to speed the centre of mass of whatever flies moves as one body's:
/// `v = g/k + (v₀ − g/k) e^{−kt}`.
#[test]
fn drag_in_proportion_to_speed_slows_the_whole() {
    let linear_per_s = 0.7;
    let mut links = rods(3, JointKind::Free, UNIVERSAL);
    for link in &mut links {
        let drag = Drag {
            linear_per_s,
            quadratic_per_m: 0.0,
        };
        link.body = link.body.with_drag(drag).unwrap();
    }
    let tree = Tree::new(&links).unwrap();
    let state = some_state(&tree, &mut Random::default(), 1.0, 3.0);
    let velocity_m_s = |state: &TreeState| {
        let mut snapshot = Snapshot::new(&tree, &GRAVITY);
        snapshot.set(state);
        snapshot.momentum().1 / tree.mass_kg()
    };
    let last_m_s = GRAVITY / linear_per_s;
    let wanted = last_m_s + (velocity_m_s(&state) - last_m_s) * f64::exp(-linear_per_s * 0.5);
    let off = velocity_m_s(&flown(&tree, &state, 0.5)) - wanted;
    assert!(off.norm() < 1e-9, "{off}");
}

/// From a hand that moves evenly a pendulum hangs as from the world in the wind that it feels there.
#[test]
fn a_hand_that_moves_evenly_feels_wind() {
    let drag = Drag {
        linear_per_s: 0.9,
        quadratic_per_m: 0.0,
    };
    let hung = |wind_m_s: Vector3<f64>| {
        let mut links = rods(2, JointKind::Ball, UNIVERSAL);
        for link in &mut links {
            let pushed = link.body.with_force(wind_m_s * drag.linear_per_s);
            link.body = pushed.unwrap().with_drag(drag).unwrap();
        }
        Tree::new(&links).unwrap()
    };
    let moves = hand(
        |time_s| {
            let on = Vector3::new(1.5, -2.0, 0.4);
            [on * time_s, on, Vector3::zeros()]
        },
        STILL,
    );
    let (held, still) = (
        hung(Vector3::zeros()).in_hand(moves),
        hung(-Vector3::new(1.5, -2.0, 0.4)),
    );
    let state = TreeState {
        time_s: 0.0,
        ..some_state(&still, &mut Random::default(), 1.0, 3.0)
    };
    let [in_hand, in_wind] = [&held, &still].map(|tree| flown(tree, &state, 0.5));
    let off = still.minus(&in_hand, &in_wind);
    let off = off.iter().fold(0.0_f64, |most, of| most.max(of.abs()));
    assert!(off < 1e-9, "{off:e}");
}
