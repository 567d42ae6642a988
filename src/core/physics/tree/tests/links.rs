//! States of links, angles and differences of states, with their derivatives.

use nalgebra::DMatrix;

use super::examples::{GRAVITY, bush, chain, rods, some_state};
use crate::math::differentiate;
use crate::math::random::Random;
use crate::physics::state::DIMENSION;
use crate::physics::tree::{JointKind, Snapshot, Tree};

use super::examples::{PIN, UNIVERSAL};

#[test]
fn derivatives_of_a_links_state_are_those_of_differences() {
    for tree in [chain(), bush(true), bush(false)] {
        let state = some_state(&tree, &mut Random::default(), 0.7, 3.0);
        let mut snapshot = Snapshot::new(&tree, &GRAVITY);
        let size = 2 * tree.freedoms();
        let mut by = DMatrix::zeros(DIMENSION, size);
        for link in 0..tree.link_count() {
            snapshot.set(&state);
            let here = snapshot.link_state(link);
            snapshot.link_jacobian(link, &mut by);
            let numeric = differentiate::jacobian(DIMENSION, size, |delta| {
                let mut there = Snapshot::new(&tree, &GRAVITY);
                there.set(&tree.retract(&state, delta));
                there.link_state(link).minus(&here).as_slice().to_vec()
            });
            for row in 0..DIMENSION {
                for column in 0..size {
                    let error = (by[(row, column)] - numeric[row][column]).abs();
                    assert!(error < 1e-8, "{link} {row} {column}: {error}");
                }
            }
        }
    }
}

#[test]
fn derivatives_of_a_difference_of_states_are_those_of_differences() {
    let tree = bush(true);
    let mut random = Random::default();
    let [a, b] = [0.7, 0.9].map(|spread| some_state(&tree, &mut random, spread, 3.0));
    let size = 2 * tree.freedoms();
    let by = tree.minus_jacobians(&a, &b);
    let of_first = |delta: &[f64]| tree.minus(&tree.retract(&a, delta), &b);
    let of_second = |delta: &[f64]| tree.minus(&a, &tree.retract(&b, delta));
    let numeric = [
        differentiate::jacobian(size, size, of_first),
        differentiate::jacobian(size, size, of_second),
    ];
    for (by, numeric) in by.iter().zip(&numeric) {
        for row in 0..size {
            for column in 0..size {
                let error = (by[(row, column)] - numeric[row][column]).abs();
                assert!(error < 1e-8, "{row} {column}: {error}");
            }
        }
    }
}

#[test]
fn angles_are_those_of_the_joint_that_a_link_hangs_on() {
    let tree = Tree::new(&rods(3, JointKind::Ball, UNIVERSAL)).unwrap();
    assert_eq!(tree.angles_of(0), None);
    assert_eq!(tree.angles_of(1), Some([3..5, 4..6]));
    assert_eq!(tree.angles_of(2), Some([5..7, 6..8]));
    let tree = Tree::new(&rods(2, JointKind::Free, PIN)).unwrap();
    assert_eq!(tree.angles_of(1), Some([6..7, 7..8]));
    assert_eq!(tree.columns_of(0), 3..6);
}
