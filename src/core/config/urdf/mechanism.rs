//! Links and joints as bodies and joints of a scene: links without mass become part of what holds
//! them, joints in a row with no mass between become one.

use std::collections::BTreeMap;

use crate::config::spanned::Spanned;
use nalgebra::Vector3;

use super::element::Notes;
use super::merge::{Merged, UrdfTurn, merged};
use super::robot::{Inertial, Robot, UrdfJoint, UrdfKind, UrdfLink, WORLD};
use super::solid::{UrdfSolid, solid};
use crate::config::error::{Fault, fault};
use crate::config::number::{quoted, unique};
use crate::math::Pose;

/// Most bodies: what a scene of them costs grows faster than their number.
const BODIES: usize = 2000;

/// What moves.
#[derive(Debug, Default)]
pub(super) struct UrdfMechanism {
    pub(super) bodies: Vec<UrdfBody>,
    pub(super) hinges: Vec<UrdfHinge>,
}

/// A link with mass.
#[derive(Debug)]
pub(super) struct UrdfBody {
    pub(super) name: Spanned<String>,
    pub(super) solid: UrdfSolid,
    /// Links without mass that are fixed to it: names and places in its frame.
    pub(super) points: Vec<(String, Vector3<f64>)>,
}

/// A joint between two bodies, or a body and the world.
#[derive(Debug)]
pub(super) struct UrdfHinge {
    pub(super) name: Spanned<String>,
    pub(super) parent: Option<usize>,
    pub(super) child: usize,
    pub(super) joint: Merged,
    /// Frame of the parent's link from that of the child's, where all angles are zero.
    pub(super) parent_from_child: Pose,
}

/// Where a link is: in the frame of what holds it, where all angles are zero, after turns with no mass
/// between.
#[derive(Clone, Debug)]
struct Hung {
    /// A body; `None`: the world.
    host: Option<usize>,
    host_from_link: Pose,
    turns: Vec<UrdfTurn>,
}

impl Hung {
    fn on(host: Option<usize>, host_from_link: Pose) -> Self {
        Self {
            host,
            host_from_link,
            turns: Vec::new(),
        }
    }
}

/// Reduces a description.
pub(super) fn mechanism(robot: &Robot, notes: &mut Notes) -> Result<UrdfMechanism, Fault> {
    let graph = Graph::new(robot)?;
    let root = graph.root()?;
    let mut made = UrdfMechanism::default();
    let base = match graph.link(root).name.get_ref() == WORLD {
        true => None,
        false => Some(graph.base(root)?),
    };
    let hung = match &base {
        None if graph.link(root).inertial.is_some() => {
            let said = format!("the link {WORLD:?} has a mass, expected none: it stands still");
            return fault(graph.link(root).name.span(), said);
        }
        None => {
            unread(graph.link(root), notes);
            Hung::on(None, Pose::identity())
        }
        Some(base) => {
            let link = graph.link(base.link);
            let said = format!(
                "{:?} hangs from nothing, so it flies: a joint to it from a link {WORLD:?} would hold it",
                link.name.get_ref()
            );
            notes.add(&link.name.span(), said);
            made.add_body(link, base.inertial, notes)?;
            let hung = Hung::on(Some(0), base.root_from_link.inverse());
            if base.link != root {
                made.point(graph.link(root), &hung, notes);
            }
            hung
        }
    };
    // By a list and not by calls: descriptions may be deep. The last is taken first.
    let mut left: Vec<(usize, Hung)> = Vec::new();
    let joints = graph.hanging[root].iter().rev();
    left.extend(joints.map(|joint| (*joint, hung.clone())));
    while let Some((joint, parent)) = left.pop() {
        let child = graph.child[joint];
        let hung = match &base {
            Some(base) if base.link == child => Hung::on(Some(0), Pose::identity()),
            _ => made.hang(&robot.joints[joint], graph.link(child), &parent, notes)?,
        };
        let joints = &graph.hanging[child];
        if !hung.turns.is_empty() && joints.len() != 1 {
            return dangling(graph.link(child), joints.len());
        }
        left.extend(joints.iter().rev().map(|joint| (*joint, hung.clone())));
    }
    if made.bodies.is_empty() {
        let said = "no link has mass, expected an <inertial> of what moves";
        return fault(robot.span.clone(), said);
    }
    let is_fixed = |of: &UrdfHinge| of.joint.kind == "fixed";
    if base.is_none() && made.hinges.iter().all(is_fixed) && made.hinges.len() == made.bodies.len()
    {
        let said = "nothing can move: every link is fixed to the world";
        return fault(robot.span.clone(), said);
    }
    let flies = made.hinges.iter().all(|of| of.child != 0);
    let mut hang_from_world = made.hinges.iter().filter(|of| of.parent.is_none());
    if let Some(second) = hang_from_world.nth(if flies { 0 } else { 1 }) {
        let said = format!(
            "{:?} hangs a second mechanism from the world, expected one: a scene has one tree at most",
            second.name.get_ref()
        );
        return fault(second.name.span(), said);
    }
    Ok(made)
}

/// A link without mass at the end of moving joints.
fn dangling<T>(link: &UrdfLink, hanging: usize) -> Result<T, Fault> {
    let name = link.name.get_ref();
    let said = match hanging {
        0 => format!(
            "link {name:?} moves and has no mass, and nothing hangs from it: expected an <inertial>, or a fixed joint"
        ),
        _ => format!(
            "link {name:?} moves and has no mass, and {hanging} joints hang from it: expected an <inertial>, or one joint"
        ),
    };
    fault(link.name.span(), said)
}

/// Notes solids of a link that is no body.
fn unread(link: &UrdfLink, notes: &mut Notes) {
    let of = [&link.geometries.collision, &link.geometries.visual];
    if of
        .iter()
        .any(|of| !of.placed.is_empty() || !of.meshes.is_empty())
    {
        let said = format!(
            "solids of {:?}, which has no mass, are not read",
            link.name.get_ref()
        );
        notes.add(&link.name.span(), said);
    }
}

impl UrdfMechanism {
    /// Adds a body; its index.
    fn add_body(
        &mut self,
        link: &UrdfLink,
        inertial: &Inertial,
        notes: &mut Notes,
    ) -> Result<usize, Fault> {
        if self.bodies.len() == BODIES {
            let said = format!(
                "{:?} is one more link with mass than a scene can do with, expected {BODIES} at most",
                link.name.get_ref()
            );
            return fault(link.name.span(), said);
        }
        self.bodies.push(UrdfBody {
            name: link.name.clone(),
            solid: solid(link, inertial, notes)?,
            points: Vec::new(),
        });
        Ok(self.bodies.len() - 1)
    }

    /// A link without mass: where it is fixed to a body, it is a named point of it.
    fn point(&mut self, link: &UrdfLink, hung: &Hung, notes: &mut Notes) {
        unread(link, notes);
        if let (Some(host), true) = (hung.host, hung.turns.is_empty()) {
            let name = link.name.get_ref();
            let body = &mut self.bodies[host];
            let said = format!(
                "{name:?} has no mass: it is a point of {:?}, its axes are not read",
                body.name.get_ref()
            );
            notes.add(&link.name.span(), said);
            let at_m = hung.host_from_link.translation.vector;
            body.points.push((name.clone(), at_m));
        }
    }

    /// Hangs a link from another by a joint: where it is then.
    fn hang(
        &mut self,
        joint: &UrdfJoint,
        child: &UrdfLink,
        parent: &Hung,
        notes: &mut Notes,
    ) -> Result<Hung, Fault> {
        let mut hung = parent.clone();
        hung.host_from_link *= joint.parent_from_child;
        match joint.kind {
            UrdfKind::Floating => return self.let_fly(joint, child, parent, notes),
            UrdfKind::Fixed => {}
            UrdfKind::Revolute { axis, limits_rad } => hung.turns.push(UrdfTurn {
                name: joint.name.clone(),
                at_m: hung.host_from_link.translation.vector,
                axis: hung.host_from_link.rotation * axis,
                limits_rad,
                damping_n_m_s: joint.damping_n_m_s,
            }),
        }
        let Some(inertial) = &child.inertial else {
            self.point(child, &hung, notes);
            return Ok(hung);
        };
        let joined = merged(&hung.turns, hung.host_from_link.translation.vector)?;
        let names: Vec<&str> = match hung.turns.as_slice() {
            [] => vec![joint.name.get_ref()],
            turns => turns.iter().map(|of| of.name.get_ref().as_str()).collect(),
        };
        if joined.is_unlimited {
            let said = format!("limits of {} are not read: a ball has none", quoted(&names));
            notes.add(&joint.name.span(), said);
        }
        if names.len() > 1 {
            let said = format!("{} become one {} joint", quoted(&names), joined.kind);
            notes.add(&joint.name.span(), said);
        }
        let index = self.add_body(child, inertial, notes)?;
        self.hinges.push(UrdfHinge {
            name: Spanned::new(joint.name.span(), names.join(" ")),
            parent: hung.host,
            child: index,
            joint: joined,
            parent_from_child: hung.host_from_link,
        });
        Ok(Hung::on(Some(index), Pose::identity()))
    }

    /// A link that a floating joint lets fly: the first body of all.
    fn let_fly(
        &mut self,
        joint: &UrdfJoint,
        child: &UrdfLink,
        parent: &Hung,
        notes: &mut Notes,
    ) -> Result<Hung, Fault> {
        if parent.host.is_some() || !parent.turns.is_empty() || !self.bodies.is_empty() {
            let said = format!(
                "joint {:?} is floating, expected only the first one to be, from the link {WORLD:?}: a scene has one tree at most",
                joint.name.get_ref()
            );
            return fault(joint.name.span(), said);
        }
        let Some(inertial) = &child.inertial else {
            let said = format!(
                "link {:?} flies and has no mass, expected an <inertial>",
                child.name.get_ref()
            );
            return fault(child.name.span(), said);
        };
        let base = self.add_body(child, inertial, notes)?;
        Ok(Hung::on(Some(base), Pose::identity()))
    }
}

/// The first link with mass of a mechanism that flies.
struct Base<'a> {
    link: usize,
    inertial: &'a Inertial,
    root_from_link: Pose,
}

/// Which joint hangs from which link.
struct Graph<'a> {
    robot: &'a Robot,
    /// Per link: the joints whose parent it is.
    hanging: Vec<Vec<usize>>,
    /// Per joint: its child.
    child: Vec<usize>,
    /// Per link: the joint whose child it is.
    holder: Vec<Option<usize>>,
}

impl<'a> Graph<'a> {
    fn new(robot: &'a Robot) -> Result<Self, Fault> {
        let mut index: BTreeMap<&str, usize> = BTreeMap::new();
        for (at, link) in robot.links.iter().enumerate() {
            let name = link.name.get_ref().as_str();
            if index.insert(name, at).is_some() {
                unique("link", &link.name, name, [name])?;
            }
        }
        let mut names: BTreeMap<&str, usize> = BTreeMap::new();
        let mut graph = Self {
            robot,
            hanging: vec![Vec::new(); robot.links.len()],
            child: Vec::new(),
            holder: vec![None; robot.links.len()],
        };
        for (at, joint) in robot.joints.iter().enumerate() {
            let name = joint.name.get_ref().as_str();
            if names.insert(name, at).is_some() {
                unique("joint", &joint.name, name, [name])?;
            }
            let find = |text: &Spanned<String>| match index.get(text.get_ref().as_str()) {
                Some(found) => Ok(*found),
                None => fault(
                    text.span(),
                    format!(
                        "joint {name:?} ties {:?}, expected a <link> of that name",
                        text.get_ref()
                    ),
                ),
            };
            let (parent, child) = (find(&joint.parent)?, find(&joint.child)?);
            if let Some(other) = graph.holder[child] {
                let said = format!(
                    "link {:?} hangs from {:?} already, expected one joint for each child: links form trees, not circles",
                    joint.child.get_ref(),
                    robot.joints[other].name.get_ref()
                );
                return fault(joint.child.span(), said);
            }
            graph.holder[child] = Some(at);
            graph.hanging[parent].push(at);
            graph.child.push(child);
        }
        Ok(graph)
    }

    fn link(&self, index: usize) -> &'a UrdfLink {
        &self.robot.links[index]
    }

    /// The one link that hangs from none, from which all others do.
    fn root(&self) -> Result<usize, Fault> {
        let roots: Vec<usize> = (0..self.robot.links.len())
            .filter(|link| self.holder[*link].is_none())
            .collect();
        let [root] = roots.as_slice() else {
            let Some(second) = roots.get(1) else {
                let said = match self.robot.joints.first() {
                    None => "there is no <link>, expected at least one",
                    Some(_) => {
                        "every link hangs from another, in a circle, expected a tree: one link that is no joint's child"
                    }
                };
                return fault(self.robot.span.clone(), said);
            };
            let said = format!(
                "{:?} and {:?} hang from nothing, expected one such link: a joint that ties the one to the other",
                self.link(roots[0]).name.get_ref(),
                self.link(*second).name.get_ref()
            );
            return fault(self.link(*second).name.span(), said);
        };
        let mut is_reached = vec![false; self.robot.links.len()];
        let mut left = vec![*root];
        while let Some(link) = left.pop() {
            is_reached[link] = true;
            left.extend(self.hanging[link].iter().map(|of| self.child[*of]));
        }
        match is_reached.iter().position(|of| !of) {
            None => Ok(*root),
            Some(lost) => {
                let said = format!(
                    "link {:?} hangs from itself, in a circle, expected a tree that begins with {:?}",
                    self.link(lost).name.get_ref(),
                    self.link(*root).name.get_ref()
                );
                fault(self.link(lost).name.span(), said)
            }
        }
    }

    /// The first link, or the one with mass to which it is fixed.
    fn base(&self, root: usize) -> Result<Base<'a>, Fault> {
        let mut left = vec![(root, Pose::identity())];
        while let Some((link, root_from_link)) = left.pop() {
            if let Some(inertial) = &self.link(link).inertial {
                return Ok(Base {
                    link,
                    inertial,
                    root_from_link,
                });
            }
            for of in self.hanging[link].iter().rev() {
                let joint = &self.robot.joints[*of];
                if joint.kind == UrdfKind::Fixed {
                    left.push((self.child[*of], root_from_link * joint.parent_from_child));
                }
            }
        }
        let said = format!(
            "the first link {:?} has no mass and is fixed to none that has, expected an <inertial>; or the name {WORLD:?}, if it stands still",
            self.link(root).name.get_ref()
        );
        fault(self.link(root).name.span(), said)
    }
}
