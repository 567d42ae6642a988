//! The joints of a tree at its frames: angles of their hinges, and how fast these turn.

use nalgebra::{UnitQuaternion, Vector3};

use super::error::SamplingError;
use super::frames::{stamp, tree_states};
use super::hinges::hinge_angles;
use crate::math::{Pose, euler};
use crate::motion::{Estimate, Joint, JointTree, LinkIndex, MechanismIndex, Scene, Settled, Stamp};
use crate::physics::tree::{Snapshot, Tree, TreeState};

/// The joints of a tree, frame by frame.
#[derive(Clone, Debug, PartialEq)]
pub struct SampledJoints {
    /// The tree.
    pub mechanism: MechanismIndex,
    /// At the same stamps as the poses of its links.
    pub samples: Vec<JointSample>,
}

/// The hinges of a tree's joints at one instant: in the order of its joints, and of each joint's
/// [`hinge_axes`](super::hinge_axes).
#[derive(Clone, Debug, PartialEq)]
pub struct JointSample {
    /// When.
    pub stamp: Stamp,
    /// Angles \[rad\], continuous in time: counted on beyond half a turn.
    pub angles_rad: Vec<f64>,
    /// Their rates [rad/s], at an impact those after it; `None` of what is simulated after the
    /// estimate, of which poses alone are known.
    pub rates_rad_s: Option<Vec<f64>>,
}

/// Samples the joints of a tree at a rate; see [`estimate_frames`](super::estimate_frames). Fails as that does.
pub(super) fn joint_frames(
    scene: &Scene,
    estimate: &Estimate,
    mechanism: MechanismIndex,
    joined: &JointTree,
    zero: Stamp,
    frame_rate_hz: f64,
) -> Result<Vec<JointSample>, SamplingError> {
    let tree = scene.tree_model_with(joined, &estimate.held);
    let mut snapshot = Snapshot::new(&tree, &estimate.gravity_m_s2);
    let mut before = vec![0.0; hinge_count(joined)];
    let states = tree_states(scene, &tree, estimate, mechanism, zero, frame_rate_hz)?;
    let samples = states.into_iter().map(|(stamp, state)| {
        snapshot.set(&state);
        let pose = |link: LinkIndex| match joined.place_of(link) {
            Some(place) => snapshot.world_from_link(place),
            None => {
                let held = estimate.held_motion(link);
                let held = held.expect("of the tree, or what it hangs from");
                held.state(state.time_s).world_from_body()
            }
        };
        let (mut angles_rad, mut rates_rad_s) = (Vec::new(), Vec::new());
        for joint in &joined.joints {
            let place = joined.place_of(joint.child).expect("a link of the tree");
            let own = angles_rad.len()..angles_rad.len() + joint.joint.kind.freedoms();
            let turn = turn(joint, &pose);
            let [angles, rates] = of_joint(joint, &turn, &tree, place, &state, &before[own]);
            angles_rad.extend(angles);
            rates_rad_s.extend(rates);
        }
        before.clone_from(&angles_rad);
        JointSample {
            stamp,
            angles_rad,
            rates_rad_s: Some(rates_rad_s),
        }
    });
    Ok(samples.collect())
}

/// Appends the joints of what is simulated, from the poses of its links: those stamped after the estimated ones.
pub(super) fn append_settled_joints(
    samples: &mut Vec<JointSample>,
    settled: &Settled,
    joined: &JointTree,
    zero: Stamp,
) {
    let Some(last) = samples.last() else {
        return;
    };
    let (after, mut before) = (last.stamp, last.angles_rad.clone());
    let links = joined.links().filter_map(|link| settled.links.get(link));
    let steps = links.map(|link| link.poses.len()).min().unwrap_or(0);
    for step in 0..steps {
        let time_s = settled.from_s + step as f64 * settled.interval_s;
        let stamp = stamp(zero, time_s);
        if stamp <= after {
            continue;
        }
        let pose = |link: LinkIndex| settled.links[link].poses[step];
        let mut angles_rad = Vec::new();
        for joint in &joined.joints {
            let own = angles_rad.len()..angles_rad.len() + joint.joint.kind.freedoms();
            let turn = turn(joint, &pose);
            angles_rad.extend(hinge_angles(&joint.joint.kind, &turn, &before[own]));
        }
        before.clone_from(&angles_rad);
        samples.push(JointSample {
            stamp,
            angles_rad,
            rates_rad_s: None,
        });
    }
}

/// How many hinges a tree has.
fn hinge_count(joined: &JointTree) -> usize {
    let joints = joined.joints.iter();
    joints.map(|of| of.joint.kind.freedoms()).sum()
}

/// How the child's side of a joint is turned in the parent's.
fn turn(joint: &Joint, pose: &impl Fn(LinkIndex) -> Pose) -> UnitQuaternion<f64> {
    let world_from_parent = joint.parent.map_or_else(Pose::identity, pose);
    let world_from_side = world_from_parent * joint.joint.parent_from_joint;
    let turned = pose(joint.child) * joint.joint.link_from_joint;
    world_from_side.rotation.inverse() * turned.rotation
}

/// Angles and rates of a joint's hinges: those of the state, or of a ball those nearest to `before`.
fn of_joint(
    joint: &Joint,
    turn: &UnitQuaternion<f64>,
    tree: &Tree,
    place: usize,
    state: &TreeState,
    before: &[f64],
) -> [Vec<f64>; 2] {
    let rates = &state.rates[tree.columns_of(place)];
    if let Some([_, angles]) = tree.angles_of(place) {
        return [state.coordinates[angles].to_vec(), rates.to_vec()];
    }
    let angles = hinge_angles(&joint.joint.kind, turn, before);
    let rates = match angles[..] {
        [a, b, c] => euler::xyz_rates(&[a, b, c], &Vector3::from_column_slice(rates)).to_vec(),
        _ => Vec::new(),
    };
    [angles, rates]
}
