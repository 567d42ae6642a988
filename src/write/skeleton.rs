//! The frames of bodies and how each hangs from another: what URDF calls links and joints, and what frame
//! transforms place.
//!
//! Every body has the frame of its estimate, the one in which the scene gives it. That of a body by
//! itself, and of the first of a tree that flies, moves freely in the world. In a tree each hinge of a joint
//! ([`hinge_axes`]) has a frame too, at the joint, which turns about the hinge's axis in the frame before it;
//! the child's own is fixed in that of the last hinge. So an angle for each hinge, with the pose of what flies,
//! places all frames, and none has two parents.

use std::collections::BTreeSet;

use nalgebra::{Quaternion, Translation3, UnitQuaternion, UnitVector3};

use super::topics;
use crate::math::Pose;
use crate::motion::{Joint, LinkIndex, MechanismIndex, PoseSample, Scene};
use crate::sampling::{SampledMotion, hinge_axes, make_signs_continuous};

/// The frames of all bodies of a scene, in its order.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Skeleton<'a> {
    /// Name of the world's frame.
    pub world_frame: &'a str,
    /// The bodies' frames.
    pub bodies: Vec<BodyFrame<'a>>,
}

/// The frame of a body.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct BodyFrame<'a> {
    /// The body.
    pub link: LinkIndex,
    /// Name of its frame.
    pub frame: String,
    /// Name of the joint of its frame: the last one above it.
    pub joint: String,
    /// By what it hangs from another body or from the world; `None` where it moves freely in the world.
    pub hanging: Option<Hanging<'a>>,
}

/// A joint of the scene as a series of hinges.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Hanging<'a> {
    /// The joint.
    pub joint: &'a Joint,
    /// Frame of the parent.
    pub parent: String,
    /// The parent's link axes in its frame; of the world the identity.
    parent_from_link: Pose,
    /// The child's frame in its link axes.
    link_from_body: Pose,
    /// Its hinges, from the parent to the child; of a fixed joint none.
    pub hinges: Vec<SkeletonHinge>,
    /// The tree that it is part of.
    mechanism: MechanismIndex,
    /// How many hinges the joints before it in the tree have.
    before: usize,
}

/// A hinge of a joint.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct SkeletonHinge {
    /// Its name.
    pub name: String,
    /// Name of the frame that turns on it.
    pub frame: String,
    /// Its axis, in the joint's frame where all angles are zero.
    pub axis: UnitVector3<f64>,
    /// Least and greatest angle \[rad\], where it has both.
    pub limits_rad: Option<[f64; 2]>,
}

/// Poses of a frame in its parent's.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Moved<'s> {
    pub parent: &'s str,
    pub child: &'s str,
    /// Parent from child, quaternions continuous in sign.
    pub samples: Vec<PoseSample>,
}

impl<'a> Skeleton<'a> {
    /// Of a scene, in a world's frame of that name.
    pub(super) fn new(scene: &'a Scene, world_frame: &'a str) -> Self {
        let mut names = Names::new(scene, world_frame);
        let bodies = scene.links.iter_enumerated().map(|(link, of)| {
            let frame = topics::estimate_frame(&of.name);
            let hanging = hanging(scene, world_frame, link, &mut names);
            let joint = match &hanging {
                Some(hanging) if hanging.hinges.is_empty() => hanging.joint.name.clone(),
                _ => unused(&mut names.joints, format!("{frame}_joint")),
            };
            BodyFrame {
                link,
                frame,
                joint,
                hanging,
            }
        });
        Self {
            world_frame,
            bodies: bodies.collect(),
        }
    }

    /// Names of the hinges of a tree, in the order of [`JointSample`](crate::sampling::JointSample).
    pub(super) fn hinges_of(&self, tree: MechanismIndex) -> Vec<&str> {
        let hanging = self.bodies.iter().filter_map(|body| body.hanging.as_ref());
        let mut of_tree: Vec<&Hanging> = hanging.filter(|of| of.mechanism == tree).collect();
        of_tree.sort_by_key(|of| of.before);
        let hinges = of_tree.into_iter().flat_map(|of| &of.hinges);
        hinges.map(|hinge| hinge.name.as_str()).collect()
    }

    /// Where all frames are in their parents', so that those of bodies are where the motion has them.
    pub(super) fn moved(&self, motion: &SampledMotion) -> Vec<Moved<'_>> {
        let mut all = Vec::new();
        for body in &self.bodies {
            let samples = &motion.estimates[body.link];
            match &body.hanging {
                Some(hanging) => all.extend(hanging.moved(body, motion)),
                None => all.push(Moved {
                    parent: self.world_frame,
                    child: &body.frame,
                    samples: samples.clone(),
                }),
            }
        }
        all
    }
}

impl Hanging<'_> {
    /// The joint's frame, where its first hinge is, in the parent's.
    pub(super) fn parent_from_joint(&self) -> Pose {
        self.parent_from_link * self.joint.joint.parent_from_joint
    }

    /// The body's frame in the last hinge's, or of a fixed joint in the parent's.
    pub(super) fn last_from_body(&self) -> Pose {
        let joint_from_body = self.joint.joint.link_from_joint.inverse() * self.link_from_body;
        match self.hinges.is_empty() {
            true => self.parent_from_joint() * joint_from_body,
            false => joint_from_body,
        }
    }

    /// Poses of the frames of its hinges and of its child. The child's is what is left to where the motion has
    /// it, which is nothing but rounding beside [`Self::last_from_body`].
    fn moved<'s>(&'s self, body: &'s BodyFrame, motion: &SampledMotion) -> Vec<Moved<'s>> {
        let mut joints = motion.joints.iter();
        let joints = joints.find(|of| of.mechanism == self.mechanism);
        let joints = &joints.expect("every tree is sampled").samples;
        let children = &motion.estimates[body.link];
        let mut moved: Vec<Moved> = Vec::new();
        let mut parent = self.parent.as_str();
        for hinge in &self.hinges {
            let (child, samples) = (hinge.frame.as_str(), Vec::new());
            moved.push(Moved {
                parent,
                child,
                samples,
            });
            parent = child;
        }
        moved.push(Moved {
            parent,
            child: &body.frame,
            samples: Vec::new(),
        });
        for (frame, (sample, child)) in joints.iter().zip(children).enumerate() {
            assert_eq!(sample.stamp, child.stamp, "joints and bodies go together");
            let parent = self.joint.parent;
            let mut above = parent.map_or_else(Pose::identity, |parent| {
                pose_of(&motion.estimates[parent][frame])
            });
            let mut parent_from_frame = self.parent_from_joint();
            for (index, hinge) in self.hinges.iter().enumerate() {
                let angle_rad = sample.angles_rad[self.before + index];
                parent_from_frame *= UnitQuaternion::from_axis_angle(&hinge.axis, angle_rad);
                let sample = PoseSample::from_pose(sample.stamp, &parent_from_frame);
                moved[index].samples.push(sample);
                above *= parent_from_frame;
                parent_from_frame = Pose::identity();
            }
            let last_from_body = above.inverse() * pose_of(child);
            let sample = PoseSample::from_pose(sample.stamp, &last_from_body);
            moved[self.hinges.len()].samples.push(sample);
        }
        for of in &mut moved {
            make_signs_continuous(&mut of.samples);
        }
        moved
    }
}

fn pose_of(sample: &PoseSample) -> Pose {
    let [x, y, z, w] = sample.quaternion_xyzw;
    let turn = UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z));
    Pose::from_parts(Translation3::from(sample.position_m), turn)
}

/// By what a body hangs; `None` where it moves freely.
fn hanging<'a>(
    scene: &'a Scene,
    world_frame: &str,
    link: LinkIndex,
    names: &mut Names,
) -> Option<Hanging<'a>> {
    let mechanism = scene.mechanism_of(link);
    let joints = &scene.joint_tree(mechanism)?.joints;
    let at = joints.iter().position(|joint| joint.child == link)?;
    let joint = &joints[at];
    let axes = hinge_axes(&joint.joint.kind);
    let endings: &[&str] = match axes.len() {
        2 => &["_1", "_2"],
        3 => &["_x", "_y", "_z"],
        _ => &[],
    };
    let hinges = axes.into_iter().enumerate().map(|(index, axis)| {
        let name = match endings.get(index) {
            Some(ending) => unused(&mut names.joints, format!("{}{ending}", joint.name)),
            None => joint.name.clone(),
        };
        let limits_rad = joint.joint.limits_rad.get(index).copied();
        SkeletonHinge {
            frame: unused(&mut names.frames, format!("{name}_link")),
            name,
            axis,
            limits_rad: limits_rad.filter(|of| of.iter().all(|limit| limit.is_finite())),
        }
    });
    let hinges = hinges.collect();
    let before = joints[..at].iter().map(|of| of.joint.kind.freedoms()).sum();
    let parent = joint.parent.map_or(world_frame.to_owned(), |parent| {
        topics::estimate_frame(&scene.links[parent].name)
    });
    let parent_from_link = joint.parent.map_or_else(Pose::identity, |parent| {
        scene.links[parent].link_from_given.inverse()
    });
    Some(Hanging {
        joint,
        parent,
        parent_from_link,
        link_from_body: scene.links[link].link_from_given,
        hinges,
        mechanism,
        before,
    })
}

/// Names that are taken.
struct Names {
    joints: BTreeSet<String>,
    frames: BTreeSet<String>,
}

impl Names {
    fn new(scene: &Scene, world_frame: &str) -> Self {
        let joints = scene.joint_trees().flat_map(|(_, tree)| &tree.joints);
        let bodies = scene.links.iter().map(|link| &link.name);
        let frames =
            bodies.flat_map(|name| [topics::estimate_frame(name), topics::sketch_frame(name)]);
        Self {
            joints: joints.map(|joint| joint.name.clone()).collect(),
            frames: frames.chain([world_frame.to_owned()]).collect(),
        }
    }
}

/// The wanted name, or the next one that is not taken.
fn unused(taken: &mut BTreeSet<String>, mut wanted: String) -> String {
    while !taken.insert(wanted.clone()) {
        wanted.push('_');
    }
    wanted
}
