//! What was found on several intervals, as one flow.

use nalgebra::Vector3;

use super::{Schedule, finished, in_one};
use crate::config::scene_from_toml;
use crate::estimate::tree::part::Part;
use crate::estimate::tree::point::TreePoint;
use crate::estimate::tree::problem::TreeProblem;
use crate::estimate::tree::program::TreeProgram;
use crate::estimate::tree::sample::Residual;
use crate::motion::{Sample, Seen, Sketch, Stamp, TrackSketch};
use crate::optimise::{Program, Work};

/// A motion of which errors grow by more than an interval may have, with exact samples of a point of each rod; without goals.
fn long() -> (TreeProblem, TreePoint) {
    const COUNT: usize = 121;
    let text = include_str!("../../../../../config/chain.toml").replace(
        "tracked = false",
        "[[body.track]]\nsees = \"point\"\ntracker = { position_mm = [0, 0, -100] }",
    );
    let scene = scene_from_toml(&text).expect("a scene");
    let samples = (0..COUNT).map(|index| Sample {
        stamp: Stamp(index as i64 * 10_000_000),
        acted_s: 0.01 * index as f64,
        seen: Seen::Point(Vector3::zeros()),
    });
    let track = TrackSketch::new(samples.collect());
    let sketch = Sketch {
        origin: Stamp(0),
        tracks: scene.tracks.iter().map(|_| track.clone()).collect(),
        marks_s: vec![0.0, 0.01 * (COUNT - 1) as f64],
        contacts_s: Default::default(),
        cuts_sd_s: Default::default(),
        marks: vec![None; 2],
    };
    let mut problem = TreeProblem::new(&scene, &sketch);
    problem.goals.clear();
    problem.step_s = 0.002;
    let delta: Vec<f64> = (0..problem.width())
        .map(|at| 2.0 * (at as f64).sin())
        .collect();
    let mut state = problem.forest.retract(&problem.forest.at_rest(), &delta);
    state.rates.iter_mut().for_each(|rate| *rate *= 2.0);
    let point = TreePoint::new(&problem, vec![state]);
    let mut seen = Vec::new();
    let program = TreeProgram::new(&problem, point.clone());
    let mut system = program.evaluated(&Part::whole(), &point);
    program.evaluate_each(
        &Part::whole(),
        &point,
        false,
        &mut system,
        &mut |_, of: &Residual| {
            seen.push(of.sample.seen + of.value * of.sample.unit);
        },
    );
    for (sample, seen) in problem.samples.iter_mut().zip(seen) {
        sample.seen = seen;
    }
    (problem, point)
}

#[test]
fn what_is_found_on_legs_is_found_as_one_flow() {
    let (problem, point) = long();
    let until_s = problem.span_s[1];
    let (cut, point) = problem.cut(point, until_s);
    assert!(cut.nodes_s.len() > 1);
    let mut work = Work::default();
    let at_once = Schedule::default().from_the_last();
    let intervals = finished(&cut, &point, &at_once, &mut work, &mut ());
    assert!(intervals.solution.finished.converged);
    assert_eq!(intervals.problem.nodes_s, cut.nodes_s);
    let cost = intervals.cost();
    let one = in_one(intervals, &mut work, &mut ());
    assert!(one.solution.finished.converged);
    assert_eq!(
        (one.problem.nodes_s.len(), one.solution.point.nodes.len()),
        (1, 1)
    );
    assert!(
        (one.cost() - cost).abs() < 1e-6 * cost,
        "{} {cost}",
        one.cost()
    );
}
