//! The program of a chain against differences.

use nalgebra::{DVector, Vector3};
use typed_index_collections::TiVec;

use super::problem::TreeProblem;
use super::program::{Part, TreeProgram};
use crate::config::scene_from_toml;
use crate::math::differentiate;
use crate::math::random::Random;
use crate::motion::{Sample, Scene, Seen, Sketch, Stamp, TrackSketch};
use crate::optimise::Program;
use crate::physics::tree::TreeState;

fn scene() -> Scene {
    scene_from_toml(include_str!("../../../config/chain.toml")).expect("a valid scene")
}

/// A tenth of a second of any path.
fn sketch(scene: &Scene) -> Sketch {
    let mut random = Random::default();
    let sample = |index: usize, at_m: Vector3<f64>| Sample {
        stamp: Stamp(index as i64 * 10_000_000),
        acted_s: 0.01 * index as f64,
        seen: Seen::Point(at_m),
    };
    let samples = (0..11).map(|index| sample(index, Vector3::from_fn(|_, _| random.signed())));
    let track = TrackSketch::new(samples.collect());
    Sketch {
        origin: Stamp(0),
        tracks: scene
            .tracks
            .iter()
            .map(|_| track.clone())
            .collect::<TiVec<_, _>>(),
        marks_s: vec![0.0, 0.1],
        marks: vec![None; 2],
    }
}

fn some_state(problem: &TreeProblem) -> TreeState {
    let mut random = Random::default();
    let delta: Vec<f64> = (0..problem.width()).map(|_| random.signed()).collect();
    problem.tree.retract(&problem.tree.at_rest(), &delta)
}

/// Gradient, rows of goals and rows of continuity, with one node and with three.
#[test]
fn derivatives_are_those_of_differences() {
    let scene = scene();
    let sketch = sketch(&scene);
    let tree = scene.joint_trees().next().expect("a tree");
    let mut problem = TreeProblem::new(&scene, &sketch, tree);
    problem.step_s = 0.01;
    // One of the goals weighs instead.
    problem.goals[1].condition.sd = Some(0.2);
    for nodes_s in [vec![0.0], vec![0.0, 0.035, 0.07]] {
        problem.nodes_s = nodes_s;
        let nodes = vec![some_state(&problem); problem.nodes_s.len()];
        let of = TreeProgram::new(&problem, vec![problem.tree.at_rest(); nodes.len()]);
        let part = Part::whole();
        let here = of.evaluated(&part, &nodes);
        let size = of.structure().size();
        let values = |delta: &[f64]| {
            let mut moved = nodes.clone();
            of.retract(&nodes, &DVector::from_column_slice(delta), &mut moved);
            let there = of.evaluated(&part, &moved);
            std::iter::once(there.cost).chain(there.values()).collect()
        };
        let rows = 1 + here.row_count();
        let numeric = differentiate::jacobian(rows, size, values);
        for column in 0..size {
            let mut step = DVector::zeros(size);
            step[column] = 1.0;
            let mut along = Vec::new();
            here.along(of.structure(), &step, &mut along);
            along.insert(0, here.gradient[column]);
            for (row, given) in along.iter().enumerate() {
                let error = (numeric[row][column] - given).abs() / (1.0 + given.abs());
                assert!(error < 1e-6, "{row} {column}: {error}");
            }
        }
    }
}
