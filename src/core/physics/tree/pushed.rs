//! Links that something but gravity pushes.

use nalgebra::Vector3;

use crate::physics::body::Body;

/// A link that is pushed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PushedLink {
    /// Its node.
    pub node: usize,
    /// Its centre of mass in the node's frame \[m\].
    pub centre_m: Vector3<f64>,
    /// Its mass, the force per mass, drag and lift.
    pub body: Body,
}

impl PushedLink {
    /// Whether something but gravity acts on the centre of mass of a body.
    pub fn is_pushed(body: &Body) -> bool {
        !body.feels_no_air() || body.force_m_s2() != Vector3::zeros()
    }
}
