//! The symplectic form, impulses at points, and points' Jacobians.

use nalgebra::{DMatrix, DVector, Vector3};

use super::examples::{GRAVITY, UNIVERSAL, chain, inverse_mass_at, off, rods, some_state, trees};
use crate::math::differentiate;
use crate::math::random::Random;
use crate::physics::tree::tableau::DORMAND_PRINCE;
use crate::physics::tree::{Flow, JointKind, Snapshot, Tree, TreeState};

fn mass_matrix(tree: &Tree, state: &TreeState) -> DMatrix<f64> {
    let freedoms = tree.freedoms();
    let mut snapshot = Snapshot::new(tree, &GRAVITY);
    snapshot.set(state);
    let mut mass = DMatrix::zeros(freedoms, freedoms);
    snapshot.mass_matrix(&mut mass);
    mass
}

fn momenta(tree: &Tree, state: &TreeState) -> DVector<f64> {
    mass_matrix(tree, state) * DVector::from_vec(state.rates.clone())
}

/// `Ω(X, Y) = δp_X·δq_Y − δp_Y·δq_X − p·(θ_X × θ_Y)`, `p = M u`: the derivative of the form `p·δq`, of
/// which the last part is Maurer's and Cartan's for changes of orientation in body axes.
fn form(tree: &Tree, state: &TreeState, balls: &[usize]) -> DMatrix<f64> {
    let freedoms = tree.freedoms();
    let p = momenta(tree, state);
    let by_state = differentiate::jacobian(freedoms, 2 * freedoms, |delta| {
        let scaled: Vec<f64> = delta.iter().map(|x| 0.5 * x).collect();
        momenta(tree, &tree.retract(state, &scaled))
            .as_slice()
            .to_vec()
    });
    let mut form = DMatrix::zeros(2 * freedoms, 2 * freedoms);
    for i in 0..freedoms {
        for j in 0..2 * freedoms {
            let by = by_state[i][j] / 0.5;
            form[(j, i)] += by;
            form[(i, j)] -= by;
        }
    }
    for from in balls {
        for (i, j, k) in [(0, 1, 2), (1, 2, 0), (2, 0, 1)] {
            form[(from + i, from + j)] -= p[from + k];
            form[(from + j, from + i)] += p[from + k];
        }
    }
    form
}

#[test]
fn the_flow_is_symplectic() {
    let of = |count, first, others| Tree::new(&rods(count, first, others)).unwrap();
    let cases: [(Tree, &[usize]); 3] = [
        (chain(), &[3]),
        (of(3, UNIVERSAL, UNIVERSAL), &[]),
        (of(2, JointKind::Ball, JointKind::Ball), &[0, 3]),
    ];
    let mut random = Random::default();
    for (tree, balls) in cases {
        let state = some_state(&tree, &mut random, 1.0, 4.0);
        let size = 2 * tree.freedoms();
        let mut flow = Flow::new(&tree, &GRAVITY, DORMAND_PRINCE);
        flow.begin(&state, true);
        flow.advance(0.2, 100);
        let mut jacobian = DMatrix::zeros(size, size);
        flow.jacobian(&mut jacobian);
        let end = flow.state();
        let before = form(&tree, &state, balls);
        let after = jacobian.transpose() * form(&tree, &end, balls) * &jacobian;
        let off = (&after - &before).amax() / after.amax().max(before.amax());
        assert!(off < 1e-9, "{off:e}");
        // It goes on as the accelerations say.
        let mut snapshot = Snapshot::new(&tree, &GRAVITY);
        snapshot.set(&end);
        let mut rate = end.rates.clone();
        rate.resize(size, 0.0);
        snapshot.accelerations(&mut rate[tree.freedoms()..]);
        let off = (flow.rate() - DVector::from_vec(rate)).amax();
        assert!(off < 1e-9, "{off:e}");
    }
}

#[test]
fn an_impulse_at_a_point_is_answered_by_the_mass_matrix() {
    let mut random = Random::default();
    for (name, tree) in trees() {
        let state = some_state(&tree, &mut random, 1.5, 3.0);
        let freedoms = tree.freedoms();
        let mut snapshot = Snapshot::new(&tree, &GRAVITY);
        snapshot.set(&state);
        let inverse = mass_matrix(&tree, &state).try_inverse().unwrap();
        for link in 0..tree.link_count() {
            let point = Vector3::new(random.signed(), random.signed(), random.signed());
            let mut jacobian = DMatrix::zeros(3, freedoms);
            snapshot.point_jacobian(link, &point, &mut jacobian);
            let found = inverse_mass_at(&tree, &state, (link, &point));
            let dense = &jacobian * &inverse * jacobian.transpose();
            let scale = found.amax();
            assert!(
                (found - dense.fixed_view::<3, 3>(0, 0)).amax() < 1e-11 * scale,
                "{name}"
            );
            assert!((found - found.transpose()).amax() < 1e-12 * scale, "{name}");
            assert!(
                found.symmetric_eigenvalues().min() > -1e-12 * scale,
                "{name}"
            );
            let velocity = &jacobian * DVector::from_vec(state.rates.clone());
            let told = snapshot.point_velocity(link, &point);
            assert!(
                (velocity - DVector::from_column_slice(told.as_slice())).amax() < 1e-12,
                "{name}"
            );
            let worst = off(&jacobian, |delta| {
                let mut moved = Snapshot::new(&tree, &GRAVITY);
                let mut whole = delta.to_vec();
                whole.resize(2 * freedoms, 0.0);
                moved.set(&tree.retract(&state, &whole));
                moved.point(link, &point).as_slice().to_vec()
            });
            assert!(worst < 1e-10, "{name}: {worst:e}");
        }
    }
}
