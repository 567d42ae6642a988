//! First guess of the motion of trees, of a body by itself as of one without joints: as their goals at the start say, else as its first samples show, else straight
//! joints; at rest, but for what flies.

use std::f64::consts::TAU;

use nalgebra::{UnitQuaternion, Vector3};

use super::ballistic;
use crate::motion::{
    EventKind, GoalQuantity, GoalSet, GoalTarget, Joint, JointTree, LinkIndex, Sample, Scene,
    Sketch, Timing,
};
use crate::physics::tree::{Forest, JointKind, Tree, TreeState};

/// Number of first samples from which the velocity of a free base is told.
const FIRST: usize = 10;
/// Angle of joints that nothing tells \[rad\]: hanging straight down, a pendulum would stay there.
const BENT_RAD: f64 = 0.3;

/// Paces that are tried, physical per acted time, where nothing tells one,
const PACES: [f64; 3] = [0.25, 0.45, 0.8];
/// and beside one that a fall tells: of joined bodies one point tells it roughly.
const ABOUT: [f64; 3] = [0.75, 1.0, 1.33];

/// First guesses of the pace, each with the state of all that moves at the beginning: one where stamps are physical times.
pub fn starts(scene: &Scene, sketch: &Sketch, forest: &Forest) -> Vec<(f64, TreeState)> {
    let paces = match scene.timing {
        Timing::Known | Timing::Edited => vec![1.0],
        Timing::Unknown { .. } => paces(scene, sketch),
    };
    let at = |pace: f64| {
        let all = scene.moving().zip(forest.trees());
        let all = all.map(|((_, of), model)| tree(scene, sketch, pace, &of.as_tree(), model));
        TreeState {
            time_s: sketch.whole_span_s(scene)[0],
            ..forest.whole(all)
        }
    };
    paces.into_iter().map(|pace| (pace, at(pace))).collect()
}

/// Paces to try: about that in which what flies falls, where one does.
fn paces(scene: &Scene, sketch: &Sketch) -> Vec<f64> {
    let fallen = scene.moving().find_map(|(_, of)| {
        let joined = of.as_tree();
        joined.base?;
        let of_links = joined.links().map(|link| places_of(scene, sketch, link));
        let places = of_links.max_by_key(Vec::len)?;
        let middle_s = 0.5 * (places.first()?.0 + places.last()?.0);
        ballistic::fit(&places, middle_s, &scene.gravity_m_s2, None).rate
    });
    match fallen {
        Some(pace) => ABOUT.map(|factor| factor * pace).to_vec(),
        None => PACES.to_vec(),
    }
}

/// The state of a tree at the beginning.
fn tree(scene: &Scene, sketch: &Sketch, pace: f64, joined: &JointTree, tree: &Tree) -> TreeState {
    let mut state = tree.at_rest();
    let start = scene
        .events
        .iter()
        .position(|event| event.kind == EventKind::Start);
    let at_start = || scene.goals.iter().filter(|goal| Some(goal.event) == start);
    let mut bend = if joined.base.is_some() { 0.0 } else { BENT_RAD };
    let mut bent = vec![0.0; 2 * tree.freedoms()];
    for joint in &joined.joints {
        let Some(place) = joined.place_of(joint.child) else {
            continue;
        };
        let told = at_start()
            .filter(|goal| goal.link == joint.child)
            .find_map(|goal| match &goal.target {
                GoalTarget::Condition(condition) => match (&condition.quantity, &condition.set) {
                    (GoalQuantity::Angles { .. }, GoalSet::Box { lower, upper }) => {
                        Some((lower + upper) * 0.5)
                    }
                    _ => None,
                },
                _ => None,
            });
        let columns = tree.columns_of(place);
        let is_ball = joint.joint.kind == JointKind::Ball;
        let told = told.or_else(|| seen(scene, sketch, joint));
        for (axis, at) in columns.enumerate() {
            bent[at] = match told {
                Some(told) => told[axis],
                None if is_ball => 0.0,
                None => bend,
            };
            if !is_ball {
                bend = -bend;
            }
        }
    }
    state = tree.retract(&state, &bent);
    let Some(base) = joined.base else {
        return state;
    };
    let pose = at_start()
        .filter(|goal| goal.link == base)
        .find_map(|goal| match &goal.target {
            GoalTarget::Pose { world_from_body } => Some(*world_from_body),
            _ => None,
        });
    let samples = || samples_of(scene, sketch, base);
    let orientation = pose.map(|pose| pose.rotation);
    let orientation = orientation.or_else(|| samples().find_map(|of| of.seen.orientation()));
    let mut places = places_of(scene, sketch, base);
    if places.is_empty() {
        let of_links = joined.links().map(|link| places_of(scene, sketch, link));
        places = of_links.flatten().collect();
    }
    places.truncate(FIRST);
    let position_m = pose.map(|pose| pose.translation.vector);
    let position_m = position_m.or(places.first().map(|first| first.1));
    let orientation: UnitQuaternion<f64> = orientation.unwrap_or_default();
    let velocity_m_s = match places.len() {
        0 | 1 => Vector3::zeros(),
        _ => {
            let fit = ballistic::fit(&places, places[0].0, &scene.gravity_m_s2, Some(pace));
            fit.acted_velocity_m_s / pace
        }
    };
    state.coordinates[..3].copy_from_slice(position_m.unwrap_or_default().as_slice());
    state.coordinates[3..7].copy_from_slice(orientation.coords.as_slice());
    state.rates[..3].copy_from_slice(velocity_m_s.as_slice());
    state
}

/// The samples of a link, track by track.
fn samples_of<'a>(
    scene: &'a Scene,
    sketch: &'a Sketch,
    link: LinkIndex,
) -> impl Iterator<Item = &'a Sample> {
    let tracks = scene.tracks.iter_enumerated();
    let of_link = tracks.filter(move |(_, track)| track.link == link);
    of_link.flat_map(|(index, _)| &sketch.tracks[index].samples)
}

/// Where a link was seen, and when.
fn places_of(scene: &Scene, sketch: &Sketch, link: LinkIndex) -> Vec<ballistic::Place> {
    let place = |sample: &Sample| Some((sample.acted_s, sample.seen.position_m()?));
    samples_of(scene, sketch, link).filter_map(place).collect()
}

/// The angles of a joint at the beginning, or the rotation vector of a ball, from the first orientations that are
/// seen of both bodies; `None` where one is not.
fn seen(scene: &Scene, sketch: &Sketch, joint: &Joint) -> Option<Vector3<f64>> {
    let first =
        |link: LinkIndex| samples_of(scene, sketch, link).find_map(|of| of.seen.orientation());
    let parent = match joint.parent {
        Some(parent) => first(parent)?,
        None => UnitQuaternion::identity(),
    };
    let of = &joint.joint;
    let turn = (parent * of.parent_from_joint.rotation).inverse()
        * first(joint.child)?
        * of.link_from_joint.rotation;
    let mut angles = Vector3::zeros();
    match &of.kind {
        JointKind::Fixed | JointKind::Free => {}
        JointKind::Pin { axis } => angles[0] = twist_rad(&turn, axis),
        JointKind::Universal { axes: [one, other] } => {
            // The first turns the second about itself.
            let about = one.normalize();
            let flat = |of: Vector3<f64>| of - about * about.dot(&of);
            let (from, to) = (flat(*other), flat(turn * other));
            angles[0] = about.dot(&from.cross(&to)).atan2(from.dot(&to));
            let first = UnitQuaternion::from_scaled_axis(about * angles[0]);
            angles[1] = twist_rad(&(first.inverse() * turn), other);
        }
        JointKind::Ball => angles = turn.scaled_axis(),
    }
    Some(angles)
}

/// Angle of the part of a rotation that is about an axis \[rad\], within half a turn.
fn twist_rad(turn: &UnitQuaternion<f64>, axis: &Vector3<f64>) -> f64 {
    let half = axis.normalize().dot(&turn.imag()).atan2(turn.w);
    let angle = 2.0 * half;
    angle - TAU * (angle / TAU).round()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Pose;
    use crate::motion::{Seen, Stamp, TrackIndex, TrackSketch};
    use crate::physics::tree::{self, Link};

    /// Every kind of joint, turned anyhow, from the orientations of its two bodies.
    #[test]
    fn angles_are_those_of_the_orientations() {
        let turned = |x: f64, y: f64, z: f64| {
            let turn = UnitQuaternion::from_scaled_axis(Vector3::new(x, y, z));
            Pose::from_parts(Vector3::new(z, x, y).into(), turn)
        };
        let axes = [Vector3::new(2.0, 0.1, 0.0), Vector3::new(0.3, 1.0, 0.5)];
        for (kind, told) in [
            (JointKind::Pin { axis: axes[1] }, vec![-2.9]),
            (JointKind::Universal { axes }, vec![2.6, -1.9]),
            (JointKind::Ball, vec![0.9, -1.4, 1.1]),
        ] {
            let joint = tree::Joint::new(kind, turned(0.4, -0.3, 0.8), turned(-0.9, 0.2, 0.1));
            let text = include_str!("../../../config/chain.toml")
                .replace("tracked = false", "tracker = { position_mm = [0, 0, 0] }");
            let text = text.replace("\n[[body.track]]\nsees = \"point\"\n", "");
            let scene = crate::config::scene_from_toml(&text).expect("a valid scene");
            let body = scene.links[LinkIndex(0)].body;
            let free = tree::Joint::new(JointKind::Free, Pose::identity(), Pose::identity());
            let link = |parent, joint| Link {
                parent,
                joint,
                body,
            };
            let tree = Tree::new(&[link(None, free), link(Some(0), joint)]).expect("a tree");
            let mut delta = vec![0.0; 2 * tree.freedoms()];
            delta[3..6].copy_from_slice(&[0.3, 0.7, -0.2]);
            delta[6..6 + told.len()].copy_from_slice(&told);
            let state = tree.retract(&tree.at_rest(), &delta);
            let mut snapshot = crate::physics::tree::Snapshot::new(&tree, &Vector3::zeros());
            snapshot.set(&state);
            let mut tracks = scene.tracks.iter().map(|_| TrackSketch::new(Vec::new()));
            let mut sketch = Sketch {
                origin: Stamp(0),
                tracks: tracks.by_ref().collect(),
                marks_s: vec![0.0, 0.1],
                contacts_s: Default::default(),
                cuts_sd_s: Default::default(),
                marks: vec![None; 2],
            };
            for place in 0..2 {
                sketch.tracks[TrackIndex(place)] = TrackSketch::new(vec![Sample {
                    stamp: Stamp(0),
                    acted_s: 0.0,
                    seen: Seen::Orientation(snapshot.link_state(place).orientation),
                }]);
            }
            let between = Joint {
                name: "between".to_owned(),
                parent: Some(LinkIndex(0)),
                child: LinkIndex(1),
                joint,
            };
            let found = seen(&scene, &sketch, &between).expect("both are seen");
            for (axis, told) in told.iter().enumerate() {
                assert!((found[axis] - told).abs() < 1e-9, "{found} {told}");
            }
        }
    }
}
