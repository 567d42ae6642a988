//! From the text of a description to that of a scene.

use super::element::Notes;
use super::mechanism::mechanism;
use super::robot::robot;
use super::text::SceneText;
use crate::config::error::{Fault, SceneError, fault};
use crate::config::text::scene_from_toml;

/// A scene that was made of a robot description.
#[derive(Clone, Debug)]
pub struct UrdfScene {
    /// The scene file; [`scene_from_toml`] reads it.
    pub toml: String,
    /// Its name.
    pub name: String,
    /// Number of bodies.
    pub bodies: usize,
    /// Number of joints.
    pub joints: usize,
    /// What changes the motion and is not in the scene, with the lines of the description.
    pub lost: Vec<String>,
    /// What else is not read, and what was made of what, with the lines of the description.
    pub notes: Vec<String>,
}

/// The text of a scene with the mechanism of a URDF description.
///
/// Fails with the place in the description of what no scene can have: joints that slide or move
/// together, circles, several trees, bodies without mass.
pub fn scene_from_urdf(text: &str) -> Result<UrdfScene, SceneError> {
    made(text).map_err(|fault| SceneError::from_fault(text, fault))
}

fn made(text: &str) -> Result<UrdfScene, Fault> {
    let mut notes = Notes::default();
    let robot = robot(text, &mut notes)?;
    let mechanism = mechanism(&robot, &mut notes)?;
    let scene = SceneText::new(&robot, &mechanism);
    // What scenes refuse beyond is refused here, at the place that it was made of.
    if let Err(error) = scene_from_toml(&scene.toml) {
        let said = format!(
            "the scene that this makes is refused: {}; URDF is in metres, kilograms and kg m², and a link without <collision> and <visual> has the box of its moments for a shape",
            error.message
        );
        return fault(scene.origin(error.line), said);
    }
    Ok(UrdfScene {
        name: robot.name.get_ref().clone(),
        bodies: mechanism.bodies.len(),
        joints: mechanism.hinges.len(),
        lost: robot.lost.lines(text),
        notes: notes.lines(text),
        toml: scene.toml,
    })
}
