//! Forward kinematics of a URDF, as those do who have nothing else: by the text, angles of joints and poses of
//! links that float.

use std::collections::BTreeMap;

use nalgebra::{Isometry3, Translation3, UnitQuaternion, UnitVector3, Vector3};
use urdf_rs::JointType;

/// A robot that was read.
pub struct Robot {
    /// What its description says.
    pub said: urdf_rs::Robot,
    /// By links, which joint each hangs on.
    hangs: BTreeMap<String, usize>,
}

impl Robot {
    /// Reads a description, in which no link hangs twice.
    pub fn read(text: &str) -> Self {
        let said = urdf_rs::read_from_string(text).expect("a valid URDF");
        let mut hangs = BTreeMap::new();
        for (index, joint) in said.joints.iter().enumerate() {
            let other = hangs.insert(joint.child.link.clone(), index);
            assert_eq!(other, None, "{} has two parents", joint.child.link);
        }
        Self { said, hangs }
    }

    /// The joint on which a link hangs; none of the root.
    pub fn joint_of(&self, link: &str) -> Option<&urdf_rs::Joint> {
        self.hangs.get(link).map(|index| &self.said.joints[*index])
    }

    /// World from every link.
    pub fn placed(
        &self,
        angles_rad: &BTreeMap<String, f64>,
        floating: &BTreeMap<String, Isometry3<f64>>,
    ) -> BTreeMap<String, Isometry3<f64>> {
        let links = self.said.links.iter().map(|link| link.name.clone());
        links
            .map(|link| {
                let mut pose = Isometry3::identity();
                let mut at = link.as_str();
                while let Some(joint) = self.joint_of(at) {
                    pose = Self::parent_from_child(joint, angles_rad, floating) * pose;
                    at = &joint.parent.link;
                }
                (link, pose)
            })
            .collect()
    }

    fn parent_from_child(
        joint: &urdf_rs::Joint,
        angles_rad: &BTreeMap<String, f64>,
        floating: &BTreeMap<String, Isometry3<f64>>,
    ) -> Isometry3<f64> {
        let [roll, pitch, yaw] = *joint.origin.rpy;
        let about = |axis: Vector3<f64>, angle_rad| {
            UnitQuaternion::from_axis_angle(&UnitVector3::new_normalize(axis), angle_rad)
        };
        let turn =
            about(Vector3::z(), yaw) * about(Vector3::y(), pitch) * about(Vector3::x(), roll);
        let origin =
            Isometry3::from_parts(Translation3::from(Vector3::from(*joint.origin.xyz)), turn);
        match joint.joint_type {
            JointType::Fixed => origin,
            JointType::Floating => floating[&joint.child.link],
            JointType::Revolute | JointType::Continuous => {
                origin * about(Vector3::from(*joint.axis.xyz), angles_rad[&joint.name])
            }
            ref other => panic!("{}: {other:?}", joint.name),
        }
    }
}
