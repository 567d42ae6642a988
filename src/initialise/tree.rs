//! First guess of a tree's motion: as its goals at the start say, else straight joints at rest where its first
//! samples are.

use nalgebra::{UnitQuaternion, Vector3};

use super::ballistic;
use crate::motion::{EventKind, GoalQuantity, GoalSet, GoalTarget, JointTree, Scene, Seen, Sketch};
use crate::physics::tree::{Tree, TreeState};

/// Number of first samples from which the velocity of a free base is told.
const FIRST: usize = 10;
/// Angle of joints that nothing tells \[rad\]: hanging straight down, a pendulum would stay there.
const BENT_RAD: f64 = 0.3;

/// The state of a tree at the beginning of its motion.
pub fn tree(scene: &Scene, sketch: &Sketch, joined: &JointTree, tree: &Tree) -> TreeState {
    let mut state = tree.at_rest();
    let start = scene
        .events
        .iter()
        .position(|event| event.kind == EventKind::Start);
    let at_start = || scene.goals.iter().filter(|goal| Some(goal.event) == start);
    let mut bend = if joined.base.is_some() { 0.0 } else { BENT_RAD };
    for (place, link) in joined.links().enumerate() {
        let Some([_, coordinates]) = tree.angles_of(place) else {
            continue;
        };
        let told = at_start()
            .filter(|goal| goal.link == link)
            .find_map(|goal| match &goal.target {
                GoalTarget::Condition(condition) => match (&condition.quantity, &condition.set) {
                    (GoalQuantity::Angles { .. }, GoalSet::Box { lower, upper }) => {
                        Some((lower + upper) * 0.5)
                    }
                    _ => None,
                },
                _ => None,
            });
        for (axis, at) in coordinates.enumerate() {
            state.coordinates[at] = told.map_or(bend, |told| told[axis]);
            bend = -bend;
        }
    }
    let Some(base) = joined.base else {
        return state;
    };
    let pose = at_start()
        .filter(|goal| goal.link == base)
        .find_map(|goal| match &goal.target {
            GoalTarget::Pose { world_from_body } => Some(*world_from_body),
            _ => None,
        });
    let samples = || {
        let tracks = scene.tracks.iter_enumerated();
        let of_base = tracks.filter(|(_, track)| track.link == base);
        of_base.flat_map(|(index, _)| &sketch.tracks[index].samples)
    };
    let any = || sketch.tracks.iter().flat_map(|track| &track.samples);
    let orientation = pose.map(|pose| pose.rotation).or_else(|| {
        samples().find_map(|sample| match sample.seen {
            Seen::Pose { orientation, .. } | Seen::Orientation(orientation) => Some(orientation),
            _ => None,
        })
    });
    let place = |sample: &crate::motion::Sample| Some((sample.acted_s, sample.seen.position_m()?));
    let mut places: Vec<ballistic::Place> = samples().filter_map(place).collect();
    if places.is_empty() {
        places = any().filter_map(place).collect();
    }
    places.truncate(FIRST);
    let position_m = pose.map(|pose| pose.translation.vector);
    let position_m = position_m.or(places.first().map(|first| first.1));
    let orientation: UnitQuaternion<f64> = orientation.unwrap_or_default();
    let velocity_m_s = match places.len() {
        0 | 1 => Vector3::zeros(),
        _ => {
            ballistic::fit(&places, places[0].0, &scene.gravity_m_s2, Some(1.0)).acted_velocity_m_s
        }
    };
    state.coordinates[..3].copy_from_slice(position_m.unwrap_or_default().as_slice());
    state.coordinates[3..7].copy_from_slice(orientation.coords.as_slice());
    state.rates[..3].copy_from_slice(velocity_m_s.as_slice());
    state
}
