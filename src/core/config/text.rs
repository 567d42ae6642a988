//! Entry points: from the text of a scene file to a checked scene, or to an error with its place.

use super::capture::{CaptureSettings, capture};
use super::counted;
use super::error::SceneError;
use super::raw::RawScene;
use super::scene::scene;
use crate::motion::Scene;

/// A checked scene from the text of a scene file. Fails with the place of the first error.
///
/// ```
/// let error = enact_core::config::scene_from_toml("name = \"drop\"\nstamps = 3").unwrap_err();
/// assert_eq!((error.line, error.column), (2, 1));
/// ```
pub fn scene_from_toml(text: &str) -> Result<Scene, SceneError> {
    let raw = parse(text)?;
    let checked = || {
        let scene = scene(&raw)?;
        capture(&raw, &scene)?;
        Ok(scene)
    };
    checked().map_err(|fault| SceneError::from_fault(text, fault))
}

/// The text parsed, with only its types checked.
fn parse(text: &str) -> Result<RawScene, SceneError> {
    counted::read(text)
}

/// A checked scene and its capture settings, from the text of a scene file. Fails with the place of
/// the first error.
pub fn capture_from_toml(text: &str) -> Result<(Scene, CaptureSettings), SceneError> {
    let raw = parse(text)?;
    let both = || {
        let scene = scene(&raw)?;
        let settings = capture(&raw, &scene)?;
        Ok((scene, settings))
    };
    both().map_err(|fault| SceneError::from_fault(text, fault))
}
