//! Forward kinematics of a URDF, as those do who have nothing else: by the text, angles of joints and poses of
//! links that float.

use std::collections::BTreeMap;
use std::str::FromStr;

use nalgebra::{Isometry3, Translation3, UnitQuaternion, UnitVector3, Vector3};
use roxmltree::{Document, Node};

/// How a joint moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JointKind {
    Fixed,
    Floating,
    Revolute,
    Continuous,
}

/// A link of a description.
pub struct Link {
    pub name: String,
    pub mass_kg: f64,
    /// About x, y and z of its inertial frame.
    pub moments_kg_m2: [f64; 3],
    /// How many shapes it is drawn as.
    pub visuals: usize,
}

/// A joint of a description.
pub struct Joint {
    pub name: String,
    pub kind: JointKind,
    pub parent: String,
    pub child: String,
    pub parent_from_joint: Isometry3<f64>,
    pub axis: Vector3<f64>,
    pub limits_rad: Option<[f64; 2]>,
    pub damping: Option<f64>,
}

/// A robot that was read.
pub struct Robot {
    pub links: Vec<Link>,
    pub joints: Vec<Joint>,
    /// By links, which joint each hangs on.
    hangs: BTreeMap<String, usize>,
}

fn child<'a>(of: Node<'a, 'a>, tag: &str) -> Option<Node<'a, 'a>> {
    let mut found = of.children().filter(|node| node.has_tag_name(tag));
    let first = found.next();
    assert!(found.next().is_none(), "a second <{tag}>");
    first
}

fn text<'a>(of: Node<'a, 'a>, key: &str) -> &'a str {
    let tag = of.tag_name().name();
    of.attribute(key)
        .unwrap_or_else(|| panic!("<{tag}> has no {key}"))
}

fn number<T: FromStr>(text: &str) -> T {
    text.parse()
        .unwrap_or_else(|_| panic!("{text:?} is no number"))
}

fn triple(text: &str) -> Vector3<f64> {
    let numbers: Vec<f64> = text.split_whitespace().map(number).collect();
    assert_eq!(numbers.len(), 3, "{text:?}");
    Vector3::from_column_slice(&numbers)
}

fn about(axis: Vector3<f64>, angle_rad: f64) -> UnitQuaternion<f64> {
    UnitQuaternion::from_axis_angle(&UnitVector3::new_normalize(axis), angle_rad)
}

/// The place that `<origin>` says; none is that of the parent.
fn origin(of: Node) -> Isometry3<f64> {
    let Some(origin) = child(of, "origin") else {
        return Isometry3::identity();
    };
    let [xyz, rpy] = ["xyz", "rpy"].map(|key| {
        let said = origin.attribute(key);
        said.map_or(Vector3::zeros(), triple)
    });
    let turn = about(Vector3::z(), rpy.z) * about(Vector3::y(), rpy.y) * about(Vector3::x(), rpy.x);
    Isometry3::from_parts(Translation3::from(xyz), turn)
}

fn link(of: Node) -> Link {
    let inertial = child(of, "inertial");
    let mass_kg = inertial.map_or(0.0, |inertial| {
        number(text(child(inertial, "mass").expect("a mass"), "value"))
    });
    let moments_kg_m2 = inertial.map_or([0.0; 3], |inertial| {
        let inertia = child(inertial, "inertia").expect("moments");
        ["ixx", "iyy", "izz"].map(|key| number(text(inertia, key)))
    });
    Link {
        name: text(of, "name").to_owned(),
        mass_kg,
        moments_kg_m2,
        visuals: of
            .children()
            .filter(|node| node.has_tag_name("visual"))
            .count(),
    }
}

fn joint(of: Node) -> Joint {
    let linked = |tag: &str| text(child(of, tag).expect("a link"), "link").to_owned();
    let limit = child(of, "limit");
    Joint {
        name: text(of, "name").to_owned(),
        kind: match text(of, "type") {
            "fixed" => JointKind::Fixed,
            "floating" => JointKind::Floating,
            "revolute" => JointKind::Revolute,
            "continuous" => JointKind::Continuous,
            other => panic!("a joint of type {other}"),
        },
        parent: linked("parent"),
        child: linked("child"),
        parent_from_joint: origin(of),
        axis: child(of, "axis").map_or(Vector3::x(), |axis| triple(text(axis, "xyz"))),
        limits_rad: limit.map(|limit| ["lower", "upper"].map(|key| number(text(limit, key)))),
        damping: child(of, "dynamics").map(|of| number(text(of, "damping"))),
    }
}

impl Robot {
    /// Reads a description, in which no link hangs twice and every joint is between links.
    pub fn read(text: &str) -> Self {
        let document = Document::parse(text).expect("XML");
        let root = document.root_element();
        assert!(root.has_tag_name("robot") && root.has_attribute("name"));
        let of_tag = |tag: &'static str| root.children().filter(move |node| node.has_tag_name(tag));
        let links: Vec<Link> = of_tag("link").map(link).collect();
        let joints: Vec<Joint> = of_tag("joint").map(joint).collect();
        let mut hangs = BTreeMap::new();
        for (index, joint) in joints.iter().enumerate() {
            for end in [&joint.parent, &joint.child] {
                assert!(links.iter().any(|link| link.name == *end), "no link {end}");
            }
            let other = hangs.insert(joint.child.clone(), index);
            assert_eq!(other, None, "{} has two parents", joint.child);
        }
        Self {
            links,
            joints,
            hangs,
        }
    }

    /// The joint on which a link hangs; none of the root.
    pub fn joint_of(&self, link: &str) -> Option<&Joint> {
        self.hangs.get(link).map(|index| &self.joints[*index])
    }

    /// World from every link.
    pub fn placed(
        &self,
        angles_rad: &BTreeMap<String, f64>,
        floating: &BTreeMap<String, Isometry3<f64>>,
    ) -> BTreeMap<String, Isometry3<f64>> {
        let links = self.links.iter().map(|link| link.name.clone());
        links
            .map(|link| {
                let mut pose = Isometry3::identity();
                let mut at = link.as_str();
                while let Some(joint) = self.joint_of(at) {
                    pose = Self::parent_from_child(joint, angles_rad, floating) * pose;
                    at = &joint.parent;
                }
                (link, pose)
            })
            .collect()
    }

    fn parent_from_child(
        joint: &Joint,
        angles_rad: &BTreeMap<String, f64>,
        floating: &BTreeMap<String, Isometry3<f64>>,
    ) -> Isometry3<f64> {
        match joint.kind {
            JointKind::Fixed => joint.parent_from_joint,
            JointKind::Floating => floating[&joint.child],
            JointKind::Revolute | JointKind::Continuous => {
                joint.parent_from_joint * about(joint.axis, angles_rad[&joint.name])
            }
        }
    }
}
