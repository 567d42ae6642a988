//! What an independent look finds of the motion of a tree.

use enact::motion::{Estimate, EventKind, GoalSet, GoalTarget, Scene};
use enact::physics::tree::{Snapshot, Tree, TreeState};
use nalgebra::Vector3;

use super::Performance;
use super::motion::flown;
use crate::trees::RATE_HZ;

/// Bounds of a motion that obeys the laws and meets its goals: distance of any rod's centre from the same motion done
/// again from its start in finer steps, and of the last rod's end from where it should be \[m\]; any coordinate at the
/// start from where it should be [m, rad]; the energy gained or lost, over the greatest kinetic one.
const AGAIN_M: f64 = 1e-5;
const GOAL_M: f64 = 1e-5;
const START: f64 = 1e-5;
const ENERGY: f64 = 1e-6;
/// Steps between samples of the motion done again, and of what says how exact that is.
const STEPS: [usize; 2] = [16, 32];

/// Where the last rod's end is asked to be at the end \[m\].
pub fn asked_end_m(scene: &Scene) -> Option<Vector3<f64>> {
    let mut goals = scene.goals.iter();
    let at_end = goals.rfind(|goal| scene.events[goal.event].kind == EventKind::End)?;
    match &at_end.target {
        GoalTarget::Condition(condition) => match &condition.set {
            GoalSet::Box { lower, .. } => Some(*lower),
            _ => None,
        },
        _ => None,
    }
}

/// Where it is.
pub fn end_m(scene: &Scene, tree: &Tree, state: &TreeState) -> Vector3<f64> {
    let mut snapshot = Snapshot::new(tree, &scene.gravity_m_s2);
    snapshot.set(state);
    let last = tree.link_count() - 1;
    let joint_m = scene.forest_links().last().and_then(|link| {
        let joint = scene.joint_of(link)?;
        Some(joint.place_m(enact::motion::JointEnd::Child))
    });
    // A rod hangs from one end and reaches as far to the other.
    snapshot.point(last, &-joint_m.expect("a rod hangs"))
}

/// Distances of all rods' centres from the true ones at all samples \[m\]; infinite where there is no motion.
pub fn distances_m(performance: &Performance, estimate: &Estimate) -> Vec<f64> {
    let strike = &performance.strike;
    let (true_forest, forest) = (strike.scene.forest(), performance.said.forest());
    let gravity_m_s2 = &strike.scene.gravity_m_s2;
    let mut true_at = Snapshot::new(&true_forest.trees()[0], gravity_m_s2);
    let mut at = Snapshot::new(&forest.trees()[0], gravity_m_s2);
    let mut distances_m = Vec::new();
    for (index, truth) in strike.states.iter().enumerate() {
        let time_s = index as f64 / RATE_HZ;
        let Some(found) = performance.said.forest_state(estimate, &forest, time_s) else {
            return vec![f64::INFINITY];
        };
        true_at.set(truth);
        at.set(&found);
        for place in 0..forest.link_count() {
            let off = true_at.link_state(place).position_m - at.link_state(place).position_m;
            distances_m.push(off.norm());
        }
    }
    distances_m
}

/// What speaks against a motion that is called physical, in words; none where nothing does.
pub fn finding(performance: &Performance, estimate: &Estimate) -> Option<String> {
    let scene = &performance.said;
    let forest = scene.forest();
    let tree = &forest.trees()[0];
    let motion = estimate.trees.first()?;
    let first = &motion.knots[0].state;
    let count = performance.strike.states.len() - 1;
    let [coarse, fine] = STEPS.map(|steps| flown(scene, tree, first, (count, steps)));
    let mut snapshot = Snapshot::new(tree, &scene.gravity_m_s2);
    let mut centres = |state: &TreeState| -> Vec<Vector3<f64>> {
        snapshot.set(state);
        let places = 0..tree.link_count();
        places
            .map(|place| snapshot.link_state(place).position_m)
            .collect()
    };
    let mut apart_m = |one: &TreeState, other: &TreeState| {
        let both = centres(one).into_iter().zip(centres(other));
        both.fold(0.0, |most: f64, (a, b)| larger(most, (a - b).norm()))
    };
    let (mut told_m, mut again_m): (f64, f64) = (0.0, 0.0);
    for (index, state) in fine.iter().enumerate() {
        told_m = larger(told_m, apart_m(state, &coarse[index]));
        let found = motion.state(tree, &scene.gravity_m_s2, index as f64 / RATE_HZ);
        again_m = larger(again_m, apart_m(state, &found));
    }
    let wanted_m = asked_end_m(scene)?;
    let goal_m = (end_m(scene, tree, &fine[count]) - wanted_m).norm();
    let start = tree.minus(first, &performance.strike.states[0]);
    let start = start[..tree.freedoms()].iter();
    let start = start.fold(0.0, |most: f64, off| larger(most, off.abs()));
    let asks_start = scene.goals.len() > 1;
    let found = [
        ("done again it is elsewhere", told_m, AGAIN_M),
        ("done again it is elsewhere than said", again_m, AGAIN_M),
        ("its end is elsewhere", goal_m, GOAL_M),
        (
            "its start is elsewhere",
            if asks_start { start } else { 0.0 },
            START,
        ),
        (
            "its energy changes",
            energy_off(scene, tree, estimate),
            ENERGY,
        ),
    ];
    let beyond = found.into_iter().find(|(_, off, most)| !(off <= most));
    beyond.map(|(what, off, _)| format!("{what}: {off:.1e}"))
}

/// Greatest change of the energy along the motion, over the greatest kinetic one.
fn energy_off(scene: &Scene, tree: &Tree, estimate: &Estimate) -> f64 {
    let mut snapshot = Snapshot::new(tree, &scene.gravity_m_s2);
    let (mut least, mut most, mut kinetic) = (f64::INFINITY, f64::NEG_INFINITY, 0.0_f64);
    for knot in &estimate.trees[0].knots {
        snapshot.set(&knot.state);
        let energy_j = snapshot.energy(0.0);
        (least, most) = (least.min(energy_j), larger(most, energy_j));
        kinetic = kinetic.max(snapshot.kinetic_energy());
    }
    (most - least) / kinetic
}

/// Whether any number of an estimate is none.
pub fn has_nan(estimate: &Estimate) -> bool {
    let is_told = estimate.trees.iter().all(|motion| motion.is_finite());
    let events = estimate.events.iter().all(|event| event.time_s.is_finite());
    !(is_told && events && (estimate.objective.is_finite() || estimate.trees.is_empty()))
}

/// The larger of two; infinite where the other is no number.
fn larger(most: f64, other: f64) -> f64 {
    most.max(if other.is_nan() { f64::INFINITY } else { other })
}
