//! Joined bodies in the simulation: a tree is one multibody of rapier, in the joints' coordinates.
//!
//! rapier has joints by impulses, too. Both were measured on three rods of 0.2 m, flung at some 6 rad/s and
//! left alone for two seconds, hung from a nail and flying:
//!
//! | | joints apart | a pin's axis turned | a universal joint's axes turned | energy, of 3.7 to 4.9 J |
//! |---|---|---|---|---|
//! | multibody | 4e-15 m | 0 | 1e-15 rad | −0.02 to −0.42 J |
//! | impulses | 9e-5 to 3e-4 m | 3e-3 rad | 0.1 to 0.5 rad | −0.13 to +0.02 J |
//!
//! By impulses a universal joint is another joint: with two angles free, what is locked is the third
//! imaginary part of the quaternion between the links, and not the angle between two axes. And their
//! angles are not counted on beyond half a turn, as limits are.
//!
//! A multibody may burst: three rods of 200 mm by 4 mm on universal joints, thrown on a table, did after
//! a tenth of a second, since they spin fast about themselves. With sixteen steps of the solver and a
//! damper in each joint, of the rotation's damping times what the child has of inertia, they do not. A
//! simulation that gains energy all the same ends before that ([`settle`](super::settle)).
//!
//! A universal joint is two pins with a cross between them, as in
//! [`physics::tree`](crate::physics::tree): a body without mass, which coordinates of joints allow.
//! Dampers and springs act about each axis. A stop at a limit is without rebound; what begins
//! beyond its limits goes no further.

use nalgebra::{DVector, Quaternion, UnitQuaternion, Vector3};
use rapier3d::prelude::{
    GenericJoint, JointAxesMask, JointAxis, Multibody, PairFilterContext, PhysicsHooks,
    PhysicsWorld, RigidBodyBuilder, RigidBodyHandle, SolverFlags,
};
use typed_index_collections::TiSlice;

use super::convert::to_rapier_pose;
use crate::math::{Pose, so3};
use crate::motion::{JointTree, LinkIndex};
use crate::physics::State;
use crate::physics::tree::{self, JointKind, Tree, TreeState};

/// The first of a joint's angles among rapier's six coordinates of it.
const FIRST_ANGLE: usize = 3;

/// A link in the simulation.
#[derive(Clone, Copy)]
pub(super) struct Moving {
    pub(super) handle: RigidBodyHandle,
    pub(super) state: State,
    /// Its greatest moment of inertia.
    pub(super) moment_kg_m2: f64,
}

/// Bodies joined in a tree.
pub(super) struct Joined {
    /// Energy of its springs when it was joined \[J\].
    pub(super) springs_j: f64,
    /// What hangs on balls with springs, and their stiffness [N m/rad].
    balls: Vec<(RigidBodyHandle, f64)>,
}

impl Joined {
    /// Joins the links of a tree, which are in the world already, and moves them as its state says.
    pub(super) fn new(
        world: &mut PhysicsWorld,
        joined: &JointTree,
        tree: &Tree,
        state: &TreeState,
        links: &TiSlice<LinkIndex, Option<Moving>>,
        damping_per_s: f64,
    ) -> Self {
        let of = |link: LinkIndex| links[link].expect("joined bodies move");
        let base = joined.base.map(of);
        let root = match base {
            Some(base) => base.handle,
            None => world.insert_body(RigidBodyBuilder::fixed()),
        };
        let mut hinges = Vec::new();
        for joint in &joined.joints {
            let moment_kg_m2 = of(joint.child).moment_kg_m2;
            let ends = Ends {
                moment_kg_m2,
                parent: joint.parent.map_or(root, |parent| of(parent).handle),
                child: of(joint.child).handle,
            };
            let place = joined.place_of(joint.child);
            match place.and_then(|place| tree.angles_of(place)) {
                Some([rates, angles]) => {
                    let motion = [&state.coordinates[angles], &state.rates[rates]];
                    hinges.extend(pins(world, ends, &joint.joint, motion));
                }
                None => {
                    let parent = joint.parent.map(|parent| of(parent).state);
                    hinges.push(ball_or_weld(
                        ends,
                        &joint.joint,
                        parent.as_ref(),
                        &of(joint.child).state,
                    ));
                }
            }
        }
        for hinge in &mut hinges {
            hinge.damping_n_m_s += damping_per_s * hinge.ends.moment_kg_m2;
            let inserted =
                world.insert_multibody_joint(hinge.ends.parent, hinge.ends.child, hinge.joint);
            inserted.expect("a tree has no circles");
        }
        move_to(world, root, base.map(|base| base.state), &hinges);
        let springs_j = hinges.iter().map(MotorHinge::energy_j).sum();
        let balls = hinges.iter().filter(|hinge| hinge.is_ball());
        let balls = balls.map(|hinge| (hinge.ends.child, hinge.spring[0]));
        Self {
            springs_j,
            balls: balls.filter(|(_, stiffness)| *stiffness > 0.0).collect(),
        }
    }

    /// Tells the springs of balls where they are: rapier's coordinates of a ball are sums of turns, and
    /// its springs are about each axis, `−k (q − q₀)`. With `q₀ = q − Log(R)` that is `−k Log(R)`.
    pub(super) fn stretch(&self, world: &mut PhysicsWorld) {
        for (child, stiffness_n_m) in &self.balls {
            let (multibody, place) = multibody_of(world, *child);
            let joint = &mut multibody.link_mut(place).expect("a link").joint;
            let q = joint.joint_rot();
            let turn = UnitQuaternion::new_normalize(Quaternion::new(q.w, q.x, q.y, q.z));
            let turn = so3::log(&turn);
            for (axis, turn_rad) in (FIRST_ANGLE..).zip(turn.iter()) {
                let rest_rad = joint.coords()[axis] - turn_rad;
                joint.set_spring(axis, *stiffness_n_m, rest_rad);
            }
        }
    }
}

/// What a joint ties.
#[derive(Clone, Copy)]
struct Ends {
    parent: RigidBodyHandle,
    child: RigidBodyHandle,
    /// Greatest moment of inertia of what hangs on it.
    moment_kg_m2: f64,
}

/// One joint of a multibody, and how it moves: about an axis, about any, or not at all.
struct MotorHinge {
    ends: Ends,
    joint: GenericJoint,
    /// An angle, or the rotation vector of a ball.
    angles_rad: Vec<f64>,
    /// Derivative of the angle, or the child's angular velocity against the parent in the axes of the
    /// joint on the parent's side.
    rates_rad_s: Vec<f64>,
    damping_n_m_s: f64,
    /// Stiffness [N m/rad] and angle of rest \[rad\].
    spring: [f64; 2],
}

impl MotorHinge {
    fn is_ball(&self) -> bool {
        self.angles_rad.len() == 3
    }

    /// Of its spring.
    fn energy_j(&self) -> f64 {
        let [stiffness_n_m, rest_rad] = self.spring;
        let squares = self.angles_rad.iter().map(|at| (at - rest_rad).powi(2));
        0.5 * stiffness_n_m * squares.sum::<f64>()
    }
}

/// The cross of a universal joint: without mass and shape, and at rest where what it ties is.
fn cross(world: &mut PhysicsWorld) -> RigidBodyHandle {
    let mut cross = RigidBodyBuilder::dynamic().build();
    cross.activation_mut().normalized_linear_threshold = f64::MAX;
    cross.activation_mut().angular_threshold = f64::MAX;
    world.insert_body(cross)
}

/// The pins of a joint, with a cross between them where they are two.
fn pins(
    world: &mut PhysicsWorld,
    ends: Ends,
    joint: &tree::Joint,
    [angles_rad, rates_rad_s]: [&[f64]; 2],
) -> Vec<MotorHinge> {
    let axes = joint.kind.axes();
    let mut parent = ends.parent;
    let mut parent_from_joint = joint.parent_from_joint;
    let mut pins = Vec::new();
    for (index, axis) in axes.iter().enumerate() {
        let is_last = index + 1 == axes.len();
        let (child, child_from_joint) = match is_last {
            true => (ends.child, joint.link_from_joint),
            false => (cross(world), Pose::identity()),
        };
        // Its axis is the first of the joint's frame.
        let turned = Pose::from_parts(Vector3::zeros().into(), so3::between(&Vector3::x(), axis));
        let mut pin = GenericJoint::new(JointAxesMask::LOCKED_REVOLUTE_AXES);
        pin.set_local_frame1(to_rapier_pose(&(parent_from_joint * turned)));
        pin.set_local_frame2(to_rapier_pose(&(child_from_joint * turned)));
        let angle_rad = angles_rad[index];
        let [least, greatest] = joint.limits_rad[index];
        if least.is_finite() || greatest.is_finite() {
            let limits = [least.min(angle_rad), greatest.max(angle_rad)];
            pin.set_limits(JointAxis::AngX, limits);
        }
        pins.push(MotorHinge {
            ends: Ends {
                parent,
                child,
                ..ends
            },
            joint: pin,
            angles_rad: vec![angle_rad],
            rates_rad_s: vec![rates_rad_s[index]],
            damping_n_m_s: joint.damping_n_m_s,
            spring: [joint.stiffness_n_m, joint.rest_rad[index]],
        });
        (parent, parent_from_joint) = (child, Pose::identity());
    }
    pins
}

/// A joint with all angles free or none, by the states of what it hangs from (none: the world) and of
/// what hangs on it.
fn ball_or_weld(
    ends: Ends,
    joint: &tree::Joint,
    parent: Option<&State>,
    child: &State,
) -> MotorHinge {
    let is_ball = joint.kind == JointKind::Ball;
    let mut tied = GenericJoint::new(match is_ball {
        true => JointAxesMask::LOCKED_SPHERICAL_AXES,
        false => JointAxesMask::LOCKED_FIXED_AXES,
    });
    tied.set_local_frame1(to_rapier_pose(&joint.parent_from_joint));
    tied.set_local_frame2(to_rapier_pose(&joint.link_from_joint));
    let spin = |state: &State| state.orientation * state.angular_velocity_rad_s;
    let orientation = parent.map_or(UnitQuaternion::identity(), |parent| parent.orientation);
    let world_from_joint = orientation * joint.parent_from_joint.rotation;
    let turn = world_from_joint.inverse() * child.orientation * joint.link_from_joint.rotation;
    let against = spin(child) - parent.map_or(Vector3::zeros(), spin);
    let free = if is_ball { 3 } else { 0 };
    MotorHinge {
        ends,
        joint: tied,
        angles_rad: so3::log(&turn).as_slice()[..free].to_vec(),
        rates_rad_s: world_from_joint
            .inverse_transform_vector(&against)
            .as_slice()[..free]
            .to_vec(),
        damping_n_m_s: joint.damping_n_m_s,
        spring: [joint.stiffness_n_m, 0.0],
    }
}

/// Moves a multibody to where and as fast as its joints are; its base in a state, or fixed.
fn move_to(
    world: &mut PhysicsWorld,
    root: RigidBodyHandle,
    base: Option<State>,
    hinges: &[MotorHinge],
) {
    let joints = &mut world.multibody_joints;
    let id = joints
        .rigid_body_link(root)
        .expect("a tree has joints")
        .multibody;
    let places: Vec<usize> = hinges
        .iter()
        .map(|hinge| joints.rigid_body_link(hinge.ends.child).expect("joined").id)
        .collect();
    let multibody = joints.get_multibody_mut(id).expect("a multibody");
    // Only now it knows whether its base moves.
    multibody.forward_kinematics(&world.bodies, true);
    let mut angles_rad = DVector::zeros(multibody.ndofs());
    multibody.damping_mut().fill(0.0);
    if let Some(base) = base {
        let spin = base.orientation * base.angular_velocity_rad_s;
        let rates = base.velocity_m_s.iter().chain(spin.iter());
        for (to, rate) in multibody.generalized_velocity_mut().iter_mut().zip(rates) {
            *to = *rate;
        }
    }
    for (hinge, place) in hinges.iter().zip(places) {
        let link = multibody.link_mut(place).expect("a link");
        if !hinge.is_ball() {
            let [stiffness_n_m, rest_rad] = hinge.spring;
            link.joint.set_spring(FIRST_ANGLE, stiffness_n_m, rest_rad);
        }
        let first = link.assembly_id();
        for (index, angle_rad) in hinge.angles_rad.iter().enumerate() {
            angles_rad[first + index] = *angle_rad;
            multibody.generalized_velocity_mut()[first + index] = hinge.rates_rad_s[index];
            multibody.damping_mut()[first + index] = hinge.damping_n_m_s;
        }
    }
    multibody.apply_displacements(angles_rad.as_slice());
    multibody.forward_kinematics(&world.bodies, false);
    multibody.update_rigid_bodies(&mut world.bodies, true);
}

/// The multibody of a link and the link's place in it.
fn multibody_of(world: &mut PhysicsWorld, link: RigidBodyHandle) -> (&mut Multibody, usize) {
    let joints = &mut world.multibody_joints;
    let id = *joints.rigid_body_link(link).expect("joined");
    let multibody = joints.get_multibody_mut(id.multibody);
    (multibody.expect("a multibody"), id.id)
}

/// Pairs of bodies that do not touch each other, since a joint ties them: those of a universal joint
/// are no neighbours to rapier.
#[derive(Default)]
pub(super) struct Tied(Vec<[RigidBodyHandle; 2]>);

impl Tied {
    /// Adds the pairs of a tree.
    pub(super) fn tie(&mut self, tree: &JointTree, links: &TiSlice<LinkIndex, Option<Moving>>) {
        let of = |link: LinkIndex| links[link].map(|link| link.handle);
        let pairs = tree.joints.iter();
        let pairs = pairs.filter_map(|joint| Some([of(joint.parent?)?, of(joint.child)?]));
        self.0.extend(pairs);
    }
}

impl PhysicsHooks for Tied {
    fn filter_contact_pair(&self, context: &PairFilterContext) -> Option<SolverFlags> {
        let (Some(one), Some(other)) = (context.rigid_body1, context.rigid_body2) else {
            return Some(SolverFlags::default());
        };
        let is_tied = self.0.contains(&[one, other]) || self.0.contains(&[other, one]);
        (!is_tied).then(SolverFlags::default)
    }
}

#[cfg(test)]
mod tests;
