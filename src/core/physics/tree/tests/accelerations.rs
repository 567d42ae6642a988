//! Accelerations, inverse dynamics, mass matrix, and derivatives at one instant.

use nalgebra::{DMatrix, DVector, Vector3};

use super::examples::{GRAVITY, off, some_state, trees};
use crate::math::random::Random;
use crate::physics::tree::{Joint, JointKind, Link, Snapshot, Tree, TreeState};

fn accelerations(tree: &Tree, state: &TreeState) -> Vec<f64> {
    let mut snapshot = Snapshot::new(tree, &GRAVITY);
    snapshot.set(state);
    let mut result = vec![0.0; tree.freedoms()];
    snapshot.accelerations(&mut result);
    result
}

/// Inverse dynamics of the accelerations are the moments of dampers and springs alone; without them
/// nothing. And `M x + ID(0) = ID(x)`.
#[test]
fn inverse_dynamics_undoes_accelerations_and_agrees_with_the_mass_matrix() {
    let mut random = Random::default();
    for (name, tree) in trees() {
        let state = some_state(&tree, &mut random, 2.0, 5.0);
        let freedoms = tree.freedoms();
        let mut snapshot = Snapshot::new(&tree, &GRAVITY);
        snapshot.set(&state);
        let mut mass = DMatrix::zeros(freedoms, freedoms);
        snapshot.mass_matrix(&mut mass);
        let inverse = |x: &DVector<f64>| {
            let mut result = DVector::zeros(freedoms);
            snapshot.inverse_dynamics(x.as_slice(), result.as_mut_slice());
            result
        };
        let bias = inverse(&DVector::zeros(freedoms));
        let x = DVector::from_fn(freedoms, |_, _| random.signed() * 10.0);
        let off = (&mass * &x + &bias - inverse(&x)).norm() / bias.norm();
        assert!(off < 1e-13, "{name}: {off:e}");
        if name.contains("bush") {
            continue;
        }
        let left = inverse(&DVector::from_vec(accelerations(&tree, &state))).norm() / bias.norm();
        assert!(left < 1e-12, "{name}: {left:e}");
    }
}

/// How far derivatives of accelerations are off differences along right perturbations, of the greatest entry.
pub fn derivatives_off(tree: &Tree, state: &TreeState) -> f64 {
    let freedoms = tree.freedoms();
    let mut snapshot = Snapshot::new(tree, &GRAVITY);
    snapshot.set(state);
    let mut exact = DMatrix::zeros(freedoms, 2 * freedoms);
    snapshot.acceleration_derivatives(&mut exact);
    off(&exact, |delta| {
        accelerations(tree, &tree.retract(state, delta))
    })
}

#[test]
fn derivatives_of_accelerations_are_exact() {
    let mut random = Random::default();
    for (name, tree) in trees() {
        for _ in 0..4 {
            let state = some_state(&tree, &mut random, 1.5, 4.0);
            let off = derivatives_off(&tree, &state);
            assert!(off < 1e-9, "{name}: {off:e}");
        }
    }
}

/// Kinetic energy by the mass matrix is that by the links' own velocities.
#[test]
fn kinetic_energy_by_links_is_that_by_the_mass_matrix() {
    let mut random = Random::default();
    for (name, tree) in trees() {
        let state = some_state(&tree, &mut random, 2.0, 5.0);
        let mut snapshot = Snapshot::new(&tree, &Vector3::zeros());
        snapshot.set(&state);
        let freedoms = tree.freedoms();
        let mut mass = DMatrix::zeros(freedoms, freedoms);
        snapshot.mass_matrix(&mut mass);
        let rates = DVector::from_vec(state.rates.clone());
        let by_matrix = 0.5 * rates.dot(&(&mass * &rates));
        let off = by_matrix - snapshot.energy(0.0);
        assert!(off.abs() < 1e-13 * by_matrix, "{name}: {off:e}");
    }
}

/// Links of a free tree with all joints fixed, and a ball joint at both centres of mass.
#[test]
fn a_ball_at_both_centres_leaves_two_free_bodies() {
    let mut random = Random::default();
    let body = |a: f64| {
        let moments = Vector3::new(1.0 + a, 2.0, 2.5) * 0.01;
        crate::physics::Body::new(0.3 + a, moments).unwrap()
    };
    let pose = crate::math::Pose::identity();
    let links = [
        Link {
            parent: None,
            joint: Joint::new(JointKind::Free, pose, pose),
            body: body(0.0),
        },
        Link {
            parent: Some(0),
            joint: Joint::new(JointKind::Ball, pose, pose),
            body: body(0.4),
        },
    ];
    let tree = Tree::new(&links).unwrap();
    let state = some_state(&tree, &mut random, 2.0, 5.0);
    let found = accelerations(&tree, &state);
    assert!((Vector3::from_column_slice(&found[..3]) - GRAVITY).norm() < 1e-14);
    let euler = |body: &crate::physics::Body, omega: &Vector3<f64>| {
        let moments = body.moments_kg_m2();
        moments
            .component_mul(omega)
            .cross(omega)
            .component_div(&moments)
    };
    let first = Vector3::from_column_slice(&state.rates[3..6]);
    let own = Vector3::from_column_slice(&found[3..6]);
    assert!((own - euler(&links[0].body, &first)).norm() < 1e-12);
    let mut snapshot = Snapshot::new(&tree, &GRAVITY);
    snapshot.set(&state);
    let (_, second) = snapshot.velocity(1);
    // ω₂ = Rᵀ ω₁ + ω, with R from the second to the first link.
    let turn =
        snapshot.world_from_link(0).rotation.inverse() * snapshot.world_from_link(1).rotation;
    let relative = Vector3::from_column_slice(&found[6..9]);
    let carried = turn.inverse() * own - second.cross(&(turn.inverse() * first));
    let sum = relative + carried;
    assert!(
        (sum - euler(&links[1].body, &second)).norm() < 1e-12,
        "{sum}"
    );
}
