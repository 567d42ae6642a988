//! A plain start of multiple shooting: a state at each node, read off the sketch there by inverse kinematics.

use enact::estimate::tree::{TreePoint, TreeProblem};
use enact::physics::tree::{Snapshot, Tree, TreeState};
use nalgebra::{DMatrix, DVector, Vector3};

/// Steps of inverse kinematics.
const STEPS: usize = 20;
/// Damping \[m²\].
const DAMPING_M2: f64 = 9e-5;
/// Step of differences \[rad, m\].
const NUDGE: f64 = 1e-6;
/// Samples on either side of which a line tells place and velocity.
const ABOUT: usize = 5;

/// States at the nodes of a problem of one tree of which one point is seen, each found from the one before; the first is given
/// but for its rates.
pub fn states(problem: &TreeProblem, first: &TreeState) -> TreePoint {
    let tree = &problem.forest.trees()[0];
    let mut state = first.clone();
    let mut nodes = Vec::new();
    for (node, node_s) in problem.nodes_s.iter().enumerate() {
        let [place_m, velocity_m_s] = seen(problem, *node_s);
        if node > 0 {
            for _ in 0..STEPS {
                let off_m = place_m - at(problem, tree, &state);
                state = moved(tree, &state, &along(problem, tree, &state, &off_m));
            }
        }
        let rates = along(problem, tree, &state, &velocity_m_s);
        state.rates.copy_from_slice(rates.as_slice());
        nodes.push(state.clone());
    }
    TreePoint::new(problem, nodes)
}

/// Place and velocity of what is seen about a time \[m, m/s\]: of a line through the samples there.
fn seen(problem: &TreeProblem, time_s: f64) -> [Vector3<f64>; 2] {
    let samples = &problem.samples;
    let here = samples.partition_point(|sample| sample.acted_s < time_s);
    let about = here.saturating_sub(ABOUT)..(here + ABOUT + 1).min(samples.len());
    let about = &samples[about];
    let count = about.len() as f64;
    let mean_s = about.iter().map(|of| of.acted_s - time_s).sum::<f64>() / count;
    let mean_m = about.iter().map(|of| of.seen).sum::<Vector3<f64>>() / count;
    let off = |of: &enact::estimate::tree::sample::TreeSample| of.acted_s - time_s - mean_s;
    let square: f64 = about.iter().map(|of| off(of).powi(2)).sum();
    let cross: Vector3<f64> = about.iter().map(|of| (of.seen - mean_m) * off(of)).sum();
    let velocity_m_s = cross / square;
    [mean_m - velocity_m_s * mean_s, velocity_m_s]
}

/// Where what is seen is \[m\].
fn at(problem: &TreeProblem, tree: &Tree, state: &TreeState) -> Vector3<f64> {
    let mut snapshot = Snapshot::new(tree, &problem.gravity_m_s2);
    snapshot.set(state);
    let sample = &problem.samples[0];
    snapshot.point(sample.place, &sample.point_m)
}

fn moved(tree: &Tree, state: &TreeState, by: &DVector<f64>) -> TreeState {
    let mut delta = vec![0.0; 2 * tree.freedoms()];
    delta[..tree.freedoms()].copy_from_slice(by.as_slice());
    tree.retract(state, &delta)
}

/// The least damped change of coordinates, or rates, that moves what is seen by so much: `Jᵀ (J Jᵀ + d)⁻¹ x`.
fn along(problem: &TreeProblem, tree: &Tree, state: &TreeState, by: &Vector3<f64>) -> DVector<f64> {
    let freedoms = tree.freedoms();
    let mut jacobian = DMatrix::zeros(3, freedoms);
    for freedom in 0..freedoms {
        let [before_m, after_m] = [-NUDGE, NUDGE].map(|nudge| {
            let mut delta = DVector::zeros(freedoms);
            delta[freedom] = nudge;
            at(problem, tree, &moved(tree, state, &delta))
        });
        jacobian.set_column(freedom, &((after_m - before_m) / (2.0 * NUDGE)));
    }
    let mut square = &jacobian * jacobian.transpose();
    for axis in 0..3 {
        square[(axis, axis)] += DAMPING_M2;
    }
    let solved = square.cholesky().expect("a damped matrix").solve(by);
    jacobian.tr_mul(&solved)
}
