//! A tree of rigid bodies and how its numbers are laid out.
//!
//! Inside, a tree is a list of *nodes*, parents first: what moves as one rigid body. A universal joint
//! is two nodes, the first without mass; links behind fixed joints belong to their parent's node. A free base that
//! something but gravity pushes is three slides along the world's axes and a ball.

use nalgebra::{Matrix3, Vector3};

use super::error::TreeError;
use super::hand::Hand;
use super::joint::{Joint, JointKind};
use super::pushed::PushedLink;
use super::spatial::Inertia;
use crate::math::{Pose, so3};
use crate::physics::body::Body;

/// Least sine of the angle between the axes of a universal joint.
const LEAST_SINE: f64 = 1e-3;

/// A body of a tree and the joint that holds it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Link {
    /// The link that it hangs from, an earlier one; none: the world, or a [hand](Tree::in_hand).
    pub parent: Option<usize>,
    /// How it hangs.
    pub joint: Joint,
    /// Mass and moments, in the link's frame: at the centre of mass, along the principal axes.
    pub body: Body,
}

/// How a node moves against its parent node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Motor {
    /// About the third axis of its frame.
    Pin,
    /// Along the third axis of its frame \[m\].
    Slide,
    /// Any rotation: the coordinate is a quaternion `(i, j, k, w)`.
    Ball,
}

/// What moves as one rigid body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TreeNode {
    /// Its parent's place; none: the world, or what a free base translates with.
    pub parent: Option<usize>,
    pub motor: Motor,
    /// Parent's frame from this node's, at coordinates zero.
    pub rotation: Matrix3<f64>,
    pub translation: Vector3<f64>,
    /// Its first place among the angular coordinates and rates of the tree.
    pub coordinate: usize,
    pub column: usize,
    /// In the node's frame; zero where it has no mass.
    pub inertia: Inertia,
    pub damping_n_m_s: f64,
    pub stiffness_n_m: f64,
    pub rest_rad: f64,
    pub limits_rad: [f64; 2],
}

impl TreeNode {
    /// Its columns: one per rate.
    pub fn columns(&self) -> std::ops::Range<usize> {
        self.column..self.column + if self.motor == Motor::Ball { 3 } else { 1 }
    }

    /// Its coordinates: an angle or a quaternion.
    pub fn coordinates(&self) -> std::ops::Range<usize> {
        self.coordinate..self.coordinate + if self.motor == Motor::Ball { 4 } else { 1 }
    }
}

/// A tree of rigid bodies.
///
/// *Coordinates*: of a free base, position [m, world] and quaternion `(i, j, k, w)`, world from the first
/// link; then, in the links' order, a quaternion for a ball, two angles for a universal joint, one for
/// a pin \[rad\]. *Rates*: of a free base, velocity [m/s, world] and angular velocity [rad/s, body], as in
/// [`State`](crate::physics::State); then the link's angular velocity against its parent [rad/s, link's
/// side] for a ball, derivatives of the angles otherwise. *Tangents*: changes of coordinates (a
/// quaternion's by right perturbation), then changes of rates.
#[derive(Clone, Debug, PartialEq)]
pub struct Tree {
    pub(super) nodes: Vec<TreeNode>,
    /// Each link's node (none: it is fixed to the world or to the hand) and its pose in the node's frame.
    pub(super) links: Vec<(Option<usize>, Pose)>,
    /// Each link's own nodes: those of the joint from which it hangs.
    joints: Vec<std::ops::Range<usize>>,
    /// Links that something but gravity pushes.
    pub(super) pushed: Vec<PushedLink>,
    /// Whether it flies in gravity alone: its centre of mass is on a parabola, and its translation is not integrated.
    pub(super) is_free: bool,
    /// Whether it flies.
    is_flying: bool,
    /// Where the first joint is: the origin of all that is computed, near the bodies.
    /// Of what hangs from a hand it is in the axes of the held body.
    pub(super) anchor_m: Vector3<f64>,
    /// What it hangs from, where that is no part of the world.
    pub(super) hand: Option<Hand>,
    pub(super) mass_kg: f64,
    /// Number of angular coordinates and rates: of all but a free base's translation.
    pub(super) coordinates: usize,
    pub(super) columns: usize,
}

impl Tree {
    /// A tree of links, each after its parent.
    pub fn new(links: &[Link]) -> Result<Self, TreeError> {
        let first = links.first().ok_or(TreeError::Empty)?;
        let is_flying = first.joint.kind == JointKind::Free;
        let is_pushed = links.iter().any(|of| PushedLink::is_pushed(&of.body));
        let mut tree = Self {
            nodes: Vec::new(),
            links: Vec::new(),
            joints: Vec::new(),
            pushed: Vec::new(),
            is_free: is_flying && !is_pushed,
            is_flying,
            anchor_m: match is_flying {
                true => Vector3::zeros(),
                false => first.joint.parent_from_joint.translation.vector,
            },
            hand: None,
            mass_kg: 0.0,
            coordinates: 0,
            columns: 0,
        };
        for (index, link) in links.iter().enumerate() {
            check(index, link, is_flying)?;
            let first = tree.nodes.len();
            tree.add(link);
            tree.joints.push(first..tree.nodes.len());
        }
        Ok(tree)
    }

    /// The same tree, hanging from a hand in place of the world: its first joint is in the axes of the held body.
    ///
    /// # Panics
    /// Of a tree that flies.
    pub fn in_hand(self, hand: Hand) -> Self {
        assert!(!self.is_flying, "what flies hangs from nothing");
        Self {
            hand: Some(hand),
            ..self
        }
    }

    /// Whether its energy stays what it is between impacts: nothing damps, pushes or drives it, and no joint has a spring.
    pub fn keeps_energy(&self) -> bool {
        let is_passive = |of: &TreeNode| of.damping_n_m_s == 0.0 && of.stiffness_n_m == 0.0;
        !self.is_in_hand() && self.pushed.is_empty() && self.nodes.iter().all(is_passive)
    }

    /// Whether it hangs from a hand.
    pub fn is_in_hand(&self) -> bool {
        self.hand.is_some()
    }

    fn add(&mut self, link: &Link) {
        let Joint {
            kind,
            parent_from_joint,
            link_from_joint,
            ..
        } = &link.joint;
        let (mut parent, placed) = match link.parent {
            Some(parent) => self.links[parent],
            None => (
                None,
                Pose::translation(-self.anchor_m.x, -self.anchor_m.y, -self.anchor_m.z),
            ),
        };
        let mut pose = placed * parent_from_joint;
        for (index, axis) in kind.axes().iter().enumerate() {
            // The node's third axis is the joint's.
            let turned =
                Pose::from_parts(Vector3::zeros().into(), so3::between(&Vector3::z(), axis));
            parent = Some(self.push(parent, &(pose * turned), Motor::Pin, link, index));
            pose = turned.inverse();
        }
        match kind {
            JointKind::Ball => {
                parent = Some(self.push(parent, &pose, Motor::Ball, link, 0));
                pose = Pose::identity();
            }
            JointKind::Free => {
                let mut pose = Pose::identity();
                let slides = if self.is_free { 0 } else { 3 };
                for axis in 0..slides {
                    let turned = so3::between(&Vector3::z(), &Vector3::ith(axis, 1.0));
                    let turned = Pose::from_parts(Vector3::zeros().into(), turned);
                    parent = Some(self.push(parent, &(pose * turned), Motor::Slide, link, 0));
                    pose = turned.inverse();
                }
                parent = Some(self.push(parent, &pose, Motor::Ball, link, 0));
                self.links.push((parent, Pose::identity()));
                self.load(parent, &Pose::identity(), &link.body);
                return;
            }
            _ => {}
        }
        let node_from_link = pose * link_from_joint.inverse();
        self.links.push((parent, node_from_link));
        self.load(parent, &node_from_link, &link.body);
    }

    fn push(
        &mut self,
        parent: Option<usize>,
        pose: &Pose,
        motor: Motor,
        link: &Link,
        axis: usize,
    ) -> usize {
        let joint = &link.joint;
        self.nodes.push(TreeNode {
            parent,
            motor,
            rotation: so3::matrix(&pose.rotation),
            translation: pose.translation.vector,
            coordinate: self.coordinates,
            column: self.columns,
            inertia: Inertia::ZERO,
            damping_n_m_s: joint.damping_n_m_s,
            stiffness_n_m: joint.stiffness_n_m,
            rest_rad: joint.rest_rad[axis],
            limits_rad: joint.limits_rad[axis],
        });
        let node = &self.nodes[self.nodes.len() - 1];
        (self.coordinates, self.columns) = (node.coordinates().end, node.columns().end);
        self.nodes.len() - 1
    }

    fn load(&mut self, node: Option<usize>, node_from_link: &Pose, body: &Body) {
        let Some(node) = node else { return };
        let turn = so3::matrix(&node_from_link.rotation);
        let moments = turn * Matrix3::from_diagonal(&body.moments_kg_m2()) * turn.transpose();
        self.nodes[node].inertia +=
            Inertia::new(body.mass_kg(), &node_from_link.translation.vector, &moments);
        self.mass_kg += body.mass_kg();
        if PushedLink::is_pushed(body) {
            self.pushed.push(PushedLink {
                node,
                centre_m: node_from_link.translation.vector,
                body: *body,
            });
        }
    }

    /// Mass of all that moves \[kg\].
    pub fn mass_kg(&self) -> f64 {
        self.mass_kg
    }

    /// Number of links.
    pub fn link_count(&self) -> usize {
        self.links.len()
    }

    /// Places among the tangent's first half of what the joint leaves free from which a link hangs; of a
    /// free base, of its orientation.
    pub fn columns_of(&self, link: usize) -> std::ops::Range<usize> {
        let nodes = self.nodes[self.joints[link].clone()].iter();
        let mut nodes = nodes.filter(|node| node.motor != Motor::Slide);
        let first = nodes.next();
        match (first, nodes.next_back().or(first)) {
            (Some(first), Some(last)) => {
                self.shift() + first.columns().start..self.shift() + last.columns().end
            }
            _ => 0..0,
        }
    }

    /// Places among the tangent's first half, and among the coordinates, of the angles of the pin or universal
    /// joint from which a link hangs; `None` of another joint.
    pub fn angles_of(&self, link: usize) -> Option<[std::ops::Range<usize>; 2]> {
        let nodes = self.joints[link].clone();
        let is_pin = |node: &TreeNode| node.motor == Motor::Pin;
        let pins = &self.nodes[nodes];
        let (first, last) = (pins.first()?, pins.last()?);
        pins.iter().all(is_pin).then(|| {
            let shift = self.shift();
            [
                shift + first.column..shift + last.column + 1,
                shift + first.coordinate..shift + last.coordinate + 1,
            ]
        })
    }

    /// Number of coordinates.
    pub fn coordinate_count(&self) -> usize {
        self.coordinates + self.shift()
    }

    /// Number of rates: degrees of freedom. Tangents are twice as long.
    pub fn freedoms(&self) -> usize {
        self.columns + self.shift()
    }

    /// How many of the first rates, and coordinates, are a free base's translation.
    pub fn translations(&self) -> usize {
        if self.is_flying { 3 } else { 0 }
    }

    /// How many of them are not integrated.
    pub(super) fn shift(&self) -> usize {
        if self.is_free { 3 } else { 0 }
    }

    /// The first column by whose coordinate anything changes: the orientation of a free base does
    /// not count, wherever it points its links move alike.
    pub(super) fn first_turned(&self) -> usize {
        if self.is_free { 3 } else { 0 }
    }
}

fn check(index: usize, link: &Link, is_free: bool) -> Result<(), TreeError> {
    let joint = &link.joint;
    if let Some(parent) = link.parent
        && parent >= index
    {
        return Err(TreeError::Order {
            link: index,
            parent,
        });
    }
    let is_first_free = joint.kind == JointKind::Free && index == 0 && link.parent.is_none();
    if joint.kind == JointKind::Free && !is_first_free
        || is_free && index > 0 && link.parent.is_none()
    {
        return Err(TreeError::Free { link: index });
    }
    let finite = |pose: &Pose| {
        pose.translation.vector.iter().all(|x| x.is_finite())
            && pose.rotation.coords.iter().all(|x| x.is_finite())
    };
    if !finite(&joint.parent_from_joint) || !finite(&joint.link_from_joint) {
        return Err(TreeError::Pose { link: index });
    }
    let has_direction = |axis: &Vector3<f64>| axis.norm() > 0.0 && axis.norm().is_finite();
    let axes = joint.kind.axes();
    if let Some(axis) = axes.iter().position(|axis| !has_direction(axis)) {
        return Err(TreeError::Axis { link: index, axis });
    }
    if let [first, second] = axes
        && first.normalize().cross(&second.normalize()).norm() < LEAST_SINE
    {
        return Err(TreeError::ParallelAxes { link: index });
    }
    if !link.body.mass_kg().is_finite() {
        return Err(TreeError::Mass {
            link: index,
            mass_kg: link.body.mass_kg(),
        });
    }
    if link.body.support().is_some() {
        return Err(TreeError::Support { link: index });
    }
    let passive = [joint.damping_n_m_s, joint.stiffness_n_m];
    let can = !matches!(joint.kind, JointKind::Fixed | JointKind::Free);
    if !passive.iter().all(|x| *x >= 0.0 && x.is_finite())
        || !can && passive != [0.0; 2]
        || !joint.rest_rad.iter().all(|x| x.is_finite())
    {
        return Err(TreeError::Passive { link: index });
    }
    Ok(())
}
