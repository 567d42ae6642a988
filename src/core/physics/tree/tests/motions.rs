//! Flows against closed forms and against what is conserved.

use std::f64::consts::PI;

use nalgebra::{DMatrix, Matrix3, UnitQuaternion, Vector3};

use super::examples::{GRAVITY, PIN, UNIVERSAL, at, bush, chain, rod, rods, some_state};
use crate::math::random::Random;
use crate::math::{Pose, so3};
use crate::physics::tree::tableau::DORMAND_PRINCE;
use crate::physics::tree::{Flow, Joint, JointKind, Link, Snapshot, Tree, TreeState};
use crate::physics::{Body, State, flow};

fn advance(
    tree: &Tree,
    gravity: &Vector3<f64>,
    state: &TreeState,
    duration_s: f64,
    steps: usize,
) -> TreeState {
    let mut flow = Flow::new(tree, gravity, DORMAND_PRINCE);
    flow.begin(state, false);
    flow.advance(duration_s, steps);
    flow.state()
}

fn distance(tree: &Tree, a: &TreeState, b: &TreeState) -> f64 {
    tree.minus(a, b)
        .iter()
        .fold(0.0, |most, x| most.max(x.abs()))
}

#[test]
fn all_joints_fixed_are_one_rigid_body() {
    let mut random = Random::default();
    let mut vector = || Vector3::new(random.signed(), random.signed(), random.signed());
    let bodies = [[1.0, 2.0, 2.5], [0.4, 0.5, 0.6], [0.3, 0.9, 0.8]]
        .map(|moments| Body::new(moments[0], Vector3::from(moments) * 0.01).unwrap());
    let links = [0, 1, 2].map(|index: usize| {
        let kind = if index == 0 {
            JointKind::Free
        } else {
            JointKind::Fixed
        };
        let mut pose = || {
            Pose::from_parts(
                (vector() * 0.2).into(),
                UnitQuaternion::from_scaled_axis(vector()),
            )
        };
        Link {
            parent: index.checked_sub(1),
            joint: Joint::new(kind, pose(), pose()),
            body: bodies[index],
        }
    });
    let tree = Tree::new(&links).unwrap();
    assert_eq!(tree.freedoms(), 6);
    let start = some_state(&tree, &mut Random::default(), 2.0, 4.0);
    let mut snapshot = Snapshot::new(&tree, &GRAVITY);
    snapshot.set(&start);
    // The bodies' own mass, centre and moments, put together here anew.
    let poses = [0, 1, 2]
        .map(|link| snapshot.world_from_link(0).inverse() * snapshot.world_from_link(link));
    let mass: f64 = bodies.iter().map(Body::mass_kg).sum();
    let centre: Vector3<f64> = poses
        .iter()
        .zip(&bodies)
        .map(|(pose, body)| pose.translation.vector * body.mass_kg())
        .sum::<Vector3<f64>>()
        / mass;
    let mut moments = Matrix3::zeros();
    for (pose, body) in poses.iter().zip(&bodies) {
        let turn = so3::matrix(&pose.rotation);
        let arm = so3::hat(&(pose.translation.vector - centre));
        moments += turn * Matrix3::from_diagonal(&body.moments_kg_m2()) * turn.transpose()
            - arm * arm * body.mass_kg();
    }
    let eigen = moments.symmetric_eigen();
    let mut axes = eigen.eigenvectors;
    if axes.determinant() < 0.0 {
        axes.set_column(2, &-axes.column(2).into_owned());
    }
    let principal =
        UnitQuaternion::from_rotation_matrix(&nalgebra::Rotation3::from_matrix_unchecked(axes));
    let body = Body::new(mass, eigen.eigenvalues).unwrap();
    let as_body = |state: &TreeState| {
        let turn =
            UnitQuaternion::new_unchecked(super::super::state::quaternion(&state.coordinates[3..]));
        let spin = Vector3::from_column_slice(&state.rates[3..]);
        State {
            position_m: Vector3::from_column_slice(&state.coordinates) + turn * centre,
            orientation: turn * principal,
            velocity_m_s: Vector3::from_column_slice(&state.rates) + turn * spin.cross(&centre),
            angular_velocity_rad_s: principal.inverse() * spin,
        }
    };
    let end = as_body(&advance(&tree, &GRAVITY, &start, 0.5, 100));
    let exact = flow::advance(&body, &GRAVITY, &as_body(&start), 0.5);
    assert!(end.minus(&exact).amax() < 1e-12, "{}", end.minus(&exact));
}

#[test]
fn a_ball_at_both_centres_leaves_two_free_flights() {
    let pose = Pose::identity();
    let body = |a: f64| Body::new(0.3 + a, Vector3::new(1.0 + a, 2.0, 2.5) * 0.01).unwrap();
    let links = [
        (None, JointKind::Free, 0.0),
        (Some(0), JointKind::Ball, 0.4),
    ]
    .map(|(parent, kind, a)| Link {
        parent,
        joint: Joint::new(kind, pose, pose),
        body: body(a),
    });
    let tree = Tree::new(&links).unwrap();
    let start = some_state(&tree, &mut Random::default(), 2.0, 4.0);
    let end = advance(&tree, &GRAVITY, &start, 0.5, 100);
    for link in 0..2 {
        let as_body = |state: &TreeState| {
            let mut snapshot = Snapshot::new(&tree, &GRAVITY);
            snapshot.set(state);
            let pose = snapshot.world_from_link(link);
            let (velocity_m_s, angular_velocity_rad_s) = snapshot.velocity(link);
            State {
                position_m: pose.translation.vector,
                orientation: pose.rotation,
                velocity_m_s,
                angular_velocity_rad_s,
            }
        };
        let exact = flow::advance(&links[link].body, &GRAVITY, &as_body(&start), 0.5);
        let off = as_body(&end).minus(&exact).amax();
        assert!(off < 1e-12, "{link}: {off:e}");
    }
}

/// Period and quarter of a pendulum released at rest, by the arithmetic-geometric mean.
#[test]
fn a_pin_pendulum_swings_by_elliptic_functions() {
    let tree = Tree::new(&rods(1, PIN, PIN)).unwrap();
    let gravity = Vector3::new(0.0, 0.0, -9.81);
    // rod of length l about its end: ω₀² = m g (l/2)/(m l²/3)
    let slow = (1.5_f64 * 9.81 / 0.3).sqrt();
    for amplitude in [0.1, 1.0, 2.0, 3.0_f64] {
        let (mut a, mut b) = (1.0, (0.5 * amplitude).cos());
        for _ in 0..30 {
            (a, b) = (0.5 * (a + b), (a * b).sqrt());
        }
        let period = 2.0 * PI / (slow * a);
        let mut start = tree.at_rest();
        start.coordinates[0] = amplitude;
        let end = advance(&tree, &gravity, &start, period, 200);
        assert!(distance(&tree, &end, &start) < 2e-11, "{amplitude}");
        let quarter = advance(&tree, &gravity, &start, 0.25 * period, 50);
        assert!(quarter.coordinates[0].abs() < 1e-11, "{amplitude}");
        let fastest = -2.0 * slow * (0.5 * amplitude).sin();
        assert!((quarter.rates[0] - fastest).abs() < 1e-10, "{amplitude}");
    }
}

/// Two equal thin rods: `λ = ω² l/g = 3 ± 6/√7`.
#[test]
fn the_double_rod_oscillates_as_known() {
    let tree = Tree::new(&rods(2, PIN, PIN)).unwrap();
    let mut snapshot = Snapshot::new(&tree, &Vector3::new(0.0, 0.0, -9.81));
    snapshot.set(&tree.at_rest());
    let mut by_state = DMatrix::zeros(2, 4);
    snapshot.acceleration_derivatives(&mut by_state);
    let (trace, determinant) = (
        -(by_state[(0, 0)] + by_state[(1, 1)]),
        by_state[(0, 0)] * by_state[(1, 1)] - by_state[(0, 1)] * by_state[(1, 0)],
    );
    let scale = 9.81 / 0.3;
    assert!((trace / scale - 6.0).abs() < 1e-12, "{trace}");
    // (3 + 6/√7)(3 − 6/√7) = 9 − 36/7
    assert!((determinant / (scale * scale) - (9.0 - 36.0 / 7.0)).abs() < 1e-12);
}

/// Lagrange's top: energy, `L_z` and spin are conserved.
#[test]
fn a_rod_on_a_ball_joint_is_lagranges_top() {
    let tree = Tree::new(&rods(1, JointKind::Ball, PIN)).unwrap();
    let gravity = Vector3::new(0.0, 0.0, -9.81);
    let start = some_state(&tree, &mut Random::default(), 1.0, 6.0);
    let kept = |state: &TreeState| {
        let mut snapshot = Snapshot::new(&tree, &gravity);
        snapshot.set(state);
        let mut inertia = DMatrix::zeros(3, 3);
        snapshot.mass_matrix(&mut inertia);
        let momentum = inertia * nalgebra::DVector::from_vec(state.rates.clone());
        let turn = snapshot.world_from_link(0).rotation;
        let world = turn * Vector3::from_column_slice(momentum.as_slice());
        [snapshot.energy(0.0), world.z, state.rates[2]]
    };
    let end = advance(&tree, &gravity, &start, 1.0, 240);
    for (before, after) in kept(&start).iter().zip(kept(&end)) {
        assert!((before - after).abs() < 1e-11, "{before} {after}");
    }
    assert!(distance(&tree, &start, &end) > 1.0);
}

#[test]
fn a_free_chain_keeps_its_momenta_and_does_not_feel_gravity() {
    let tree = chain();
    let start = some_state(&tree, &mut Random::default(), 1.0, 5.0);
    let momenta = |state: &TreeState| {
        let mut snapshot = Snapshot::new(&tree, &GRAVITY);
        snapshot.set(state);
        (snapshot.momentum(), snapshot.energy(0.0))
    };
    let end = advance(&tree, &GRAVITY, &start, 0.9, 216);
    let ((centre, momentum, spin), energy) = momenta(&start);
    let ((centre_end, momentum_end, spin_end), energy_end) = momenta(&end);
    let velocity = momentum / tree.mass_kg();
    let parabola = centre + velocity * 0.9 + GRAVITY * (0.5 * 0.81);
    assert!((centre_end - parabola).amax() < 4e-15 * 10.0);
    assert!((momentum_end - momentum - GRAVITY * (0.9 * tree.mass_kg())).amax() < 1e-14);
    assert!((spin_end - spin).amax() < 1e-12, "{}", spin_end - spin);
    assert!(
        (energy_end - energy).abs() < 1e-11,
        "{}",
        energy_end - energy
    );
    let weightless = advance(&tree, &Vector3::zeros(), &start, 0.9, 216);
    assert_eq!(end.coordinates[3..], weightless.coordinates[3..]);
    assert_eq!(end.rates[3..], weightless.rates[3..]);
}

#[test]
fn flows_compose_and_go_back() {
    let mut random = Random::default();
    for tree in [chain(), bush(true), bush(false)] {
        let start = some_state(&tree, &mut random, 1.0, 3.0);
        let whole = advance(&tree, &GRAVITY, &start, 0.3, 300);
        let part = advance(&tree, &GRAVITY, &start, 0.1, 130);
        let both = advance(&tree, &GRAVITY, &part, 0.2, 230);
        let off = distance(&tree, &whole, &both);
        assert!(off < 1e-10, "{off:e}");
        let back = distance(&tree, &advance(&tree, &GRAVITY, &whole, -0.3, 300), &start);
        assert!(back < 1e-10, "{back:e}");
    }
}

/// A rod swings through where its axis is the first axis of its universal joint: rates along the cross
/// become large, and energy stays.
#[test]
fn a_universal_joint_passes_ninety_degrees() {
    let links = [Link {
        parent: None,
        joint: Joint::new(UNIVERSAL, Pose::identity(), at(0.15)),
        body: rod(0.1, 0.3),
    }];
    let tree = Tree::new(&links).unwrap();
    let gravity = Vector3::new(0.0, 0.0, -9.81);
    let energy = |state: &TreeState| {
        let mut snapshot = Snapshot::new(&tree, &gravity);
        snapshot.set(state);
        snapshot.energy(0.0)
    };
    for miss in [0.0, 0.1, 0.5_f64] {
        let start = TreeState {
            coordinates: vec![0.2, 0.5 * PI - 0.6],
            rates: vec![miss, 14.0],
            time_s: 0.0,
        };
        let end = advance(&tree, &gravity, &start, 0.15, 400);
        assert!(
            end.coordinates[1] > 0.5 * PI + 0.3 || miss > 0.0,
            "{:?}",
            end.coordinates
        );
        let off = (energy(&end) - energy(&start)).abs();
        assert!(off < 1e-11, "{miss}: {off:e}");
        let back = advance(&tree, &gravity, &end, -0.15, 400);
        let off = distance(&tree, &back, &start);
        assert!(off < 1e-10, "{miss}: {off:e}");
    }
}
