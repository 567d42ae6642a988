//! Links and joints as a description has them, in SI units.

use std::ops::Range;

use crate::config::spanned::Spanned;
use nalgebra::{Matrix3, Vector3};
use roxmltree::{Document, Node};

use super::element::{Element, Notes};
use super::geometry::{Geometries, geometry};
use crate::config::error::{Fault, fault};
use crate::math::Pose;

/// The link that is the world, by the convention of MoveIt and Drake.
pub(super) const WORLD: &str = "world";

/// A description.
#[derive(Debug)]
pub(super) struct Robot {
    pub(super) name: Spanned<String>,
    pub(super) span: Range<usize>,
    pub(super) links: Vec<UrdfLink>,
    pub(super) joints: Vec<UrdfJoint>,
    /// What changes the motion and is not read.
    pub(super) lost: Notes,
}

/// A link.
#[derive(Debug)]
pub(super) struct UrdfLink {
    pub(super) name: Spanned<String>,
    /// `None`: it has no mass.
    pub(super) inertial: Option<Inertial>,
    pub(super) geometries: Geometries,
}

/// Mass and inertia about the centre of mass.
#[derive(Clone, Debug)]
pub(super) struct Inertial {
    pub(super) span: Range<usize>,
    pub(super) mass_kg: f64,
    pub(super) link_from_centre: Pose,
    /// Along the axes of `link_from_centre` [kg m²].
    pub(super) tensor_kg_m2: Matrix3<f64>,
}

/// A joint.
#[derive(Debug)]
pub(super) struct UrdfJoint {
    pub(super) name: Spanned<String>,
    pub(super) kind: UrdfKind,
    pub(super) parent: Spanned<String>,
    pub(super) child: Spanned<String>,
    /// The child's frame at angle zero.
    pub(super) parent_from_child: Pose,
    pub(super) damping_n_m_s: f64,
}

/// What a joint leaves free.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum UrdfKind {
    Fixed,
    Floating,
    /// About an axis in the child's frame, of length 1, within limits.
    Revolute {
        axis: Vector3<f64>,
        limits_rad: [f64; 2],
    },
}

/// Most attributes of an element.
const ATTRIBUTES: usize = 1000;

/// Reads a description; what is not read is noted.
pub(super) fn robot(text: &str, notes: &mut Notes) -> Result<Robot, Fault> {
    check_attributes(text)?;
    let document = Document::parse(text).or_else(|error| {
        let at = offset(text, error.pos().row, error.pos().col);
        fault(at..at, format!("is no XML: {error}"))
    })?;
    if let Some(node) = document.descendants().find(is_of_xacro) {
        let said = "is xacro, expected plain URDF: `xacro robot.urdf.xacro > robot.urdf` makes it";
        return fault(node.range(), said);
    }
    let mut root = Element::new(document.root_element(), notes);
    if root.tag() != "robot" {
        let said = format!("is <{}>, expected <robot>: a URDF file", root.tag());
        return root.fault(said);
    }
    let mut robot = Robot {
        name: root.only(&["name", "version"]).name("name")?,
        span: root.span(),
        links: Vec::new(),
        joints: Vec::new(),
        lost: Notes::default(),
    };
    root.children(|child| {
        match child.tag() {
            "link" => robot.links.push(link(child)?),
            "joint" => robot.joints.push(joint(child, &mut robot.lost)?),
            _ => return Ok(false),
        }
        Ok(true)
    })?;
    Ok(robot)
}

/// Fails for an element with more attributes than any description has: the parser compares each with each.
fn check_attributes(text: &str) -> Result<(), Fault> {
    let (mut begin, mut attributes) = (0, 0);
    for (at, pair) in text.as_bytes().windows(2).enumerate() {
        match pair {
            [b'<', _] => (begin, attributes) = (at, 0),
            [b'=' | b' ' | b'\n' | b'\t' | b'\r', b'"' | b'\''] => attributes += 1,
            _ => {}
        }
        if attributes > ATTRIBUTES {
            let said =
                format!("has more than {ATTRIBUTES} attributes, expected an element of URDF");
            return fault(begin..begin, said);
        }
    }
    Ok(())
}

fn is_of_xacro(node: &Node<'_, '_>) -> bool {
    let space = node.tag_name().namespace();
    space.is_some_and(|space| space.contains("xacro"))
}

/// Offset of a row and column, both from 1, the column in characters.
fn offset(text: &str, row: u32, column: u32) -> usize {
    let before = text.split_inclusive('\n').take(row as usize - 1);
    let start: usize = before.map(str::len).sum();
    let line = &text[start..];
    let inside = line.char_indices().nth(column as usize - 1);
    start + inside.map_or(line.len(), |(at, _)| at)
}

fn link(element: &mut Element) -> Result<UrdfLink, Fault> {
    let name = element.only(&["name"]).name("name")?;
    let mut read = None;
    let mut geometries = Geometries::default();
    element.children(|child| {
        match child.tag() {
            "inertial" => {
                child.once(&read)?;
                read = Some(inertial(child)?);
            }
            "collision" => geometry(child, &mut geometries.collision)?,
            "visual" => geometry(child, &mut geometries.visual)?,
            _ => return Ok(false),
        }
        Ok(true)
    })?;
    Ok(UrdfLink {
        name,
        inertial: read.flatten(),
        geometries,
    })
}

/// `None` where mass and inertia are zero, which is how some write that there are none.
fn inertial(element: &mut Element) -> Result<Option<Inertial>, Fault> {
    element.only(&[]);
    let (mut origin, mut mass, mut inertia) = (None, None, None);
    element.children(|child| {
        match child.tag() {
            "origin" => {
                child.once(&origin)?;
                origin = Some(child.pose()?);
            }
            "mass" => {
                child.once(&mass)?;
                mass = Some(child.only(&["value"]).number("value")?);
            }
            "inertia" => {
                child.once(&inertia)?;
                child.only(&["ixx", "ixy", "ixz", "iyy", "iyz", "izz"]);
                let [xx, yy, zz] = ["ixx", "iyy", "izz"].map(|key| child.number(key));
                let [xy, xz, yz] = ["ixy", "ixz", "iyz"].map(|key| child.number_if(key));
                let [xy, xz, yz] = [xy?, xz?, yz?].map(|of| of.unwrap_or(0.0));
                let (xx, yy, zz) = (xx?, yy?, zz?);
                inertia = Some(Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz));
            }
            _ => return Ok(false),
        }
        Ok(true)
    })?;
    let (Some(mass_kg), Some(tensor_kg_m2)) = (mass, inertia) else {
        return element.fault("<inertial> is not whole, expected <mass> and <inertia>");
    };
    if mass_kg == 0.0 && tensor_kg_m2.amax() == 0.0 {
        return Ok(None);
    }
    if !(mass_kg > 0.0) {
        let said = format!(
            "mass is {mass_kg} kg, expected a positive number, or no <inertial> for a link without mass"
        );
        return element.fault(said);
    }
    Ok(Some(Inertial {
        span: element.span(),
        mass_kg,
        link_from_centre: origin.unwrap_or_else(Pose::identity),
        tensor_kg_m2,
    }))
}

fn joint(element: &mut Element, lost: &mut Notes) -> Result<UrdfJoint, Fault> {
    let name = element.only(&["name", "type"]).name("name")?;
    let written = element.text("type")?;
    let (mut parent, mut child_link, mut origin) = (None, None, None);
    let (mut axis, mut limits, mut damping) = (None, None, None);
    element.children(|child| {
        match child.tag() {
            "parent" => {
                child.once(&parent)?;
                parent = Some(child.only(&["link"]).text("link")?);
            }
            "child" => {
                child.once(&child_link)?;
                child_link = Some(child.only(&["link"]).text("link")?);
            }
            "origin" => {
                child.once(&origin)?;
                origin = Some(child.pose()?);
            }
            "axis" => {
                child.once(&axis)?;
                let given = child.only(&["xyz"]).vector_if("xyz")?;
                axis = Some((given.unwrap_or_else(Vector3::x), child.span()));
            }
            "limit" => {
                child.once(&limits)?;
                child.only(&["lower", "upper"]);
                let [lower, upper] = ["lower", "upper"].map(|key| child.number_if(key));
                limits = Some([lower?.unwrap_or(0.0), upper?.unwrap_or(0.0)]);
            }
            "dynamics" => {
                child.once(&damping)?;
                child.only(&["damping", "friction"]);
                damping = Some(child.number_if("damping")?.unwrap_or(0.0));
                if child.number_if("friction")?.unwrap_or(0.0) != 0.0 {
                    let said = "dry friction in a joint is not read: joints have damping alone";
                    lost.add(&child.span(), said.into());
                }
            }
            "mimic" => {
                let said = format!(
                    "joint {:?} moves as another does (<mimic>), expected joints that move by themselves: no motion of gears is estimated",
                    name.get_ref()
                );
                return child.fault(said);
            }
            _ => return Ok(false),
        }
        Ok(true)
    })?;
    let (Some(parent), Some(child)) = (parent, child_link) else {
        let said = format!(
            "joint {:?} ties nothing, expected <parent link=…> and <child link=…>",
            name.get_ref()
        );
        return element.fault(said);
    };
    let axis = axis.unwrap_or_else(|| (Vector3::x(), element.span()));
    let kind = kind(&name, &written, axis.0, axis.1, limits, element)?;
    let damping_n_m_s = damping.unwrap_or(0.0);
    if !(damping_n_m_s >= 0.0) {
        let said = format!(
            "joint {:?} has a damping of {damping_n_m_s}, expected zero or more",
            name.get_ref()
        );
        return element.fault(said);
    }
    Ok(UrdfJoint {
        name,
        kind,
        parent,
        child,
        parent_from_child: origin.unwrap_or_else(Pose::identity),
        damping_n_m_s,
    })
}

fn kind(
    name: &Spanned<String>,
    written: &Spanned<String>,
    axis: Vector3<f64>,
    axis_span: Range<usize>,
    limits: Option<[f64; 2]>,
    element: &Element,
) -> Result<UrdfKind, Fault> {
    let name = name.get_ref();
    let limits_rad = match (written.get_ref().as_str(), limits) {
        ("fixed", _) => return Ok(UrdfKind::Fixed),
        ("floating", _) => return Ok(UrdfKind::Floating),
        ("continuous", _) => [f64::NEG_INFINITY, f64::INFINITY],
        ("revolute", Some([lower, upper])) if lower < upper => [lower, upper],
        ("revolute", Some([lower, upper])) => {
            let said = format!(
                "joint {name:?} has limits {lower} and {upper}, expected the lesser first, or type=\"continuous\" for a joint without"
            );
            return element.fault(said);
        }
        ("revolute", None) => {
            let said = format!(
                "joint {name:?} has no <limit>, expected lower and upper, or type=\"continuous\" for a joint without"
            );
            return element.fault(said);
        }
        (sliding @ ("prismatic" | "planar"), _) => {
            let said = format!(
                "joint {name:?} is {sliding}, expected joints that turn: no motion of sliding joints is estimated; \"fixed\" where it does not move in the performance"
            );
            return fault(written.span(), said);
        }
        (other, _) => {
            let said = format!(
                "joint {name:?} is {other:?}, expected \"revolute\", \"continuous\", \"fixed\" or \"floating\""
            );
            return fault(written.span(), said);
        }
    };
    let length = axis.norm();
    if !(length > 0.0) {
        let said = format!("the axis of joint {name:?} is zero, expected a direction");
        return fault(axis_span, said);
    }
    Ok(UrdfKind::Revolute {
        axis: axis / length,
        limits_rad,
    })
}
