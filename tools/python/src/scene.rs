//! Scenes.

use std::fmt::Display;
use std::path::PathBuf;

use enact::config::scene_from_toml;
use enact::motion::{Sees, TrackIndex};
use enact::service::{NewSceneJob, SceneInMemory, made_scene};
use pyo3::exceptions::{PyKeyError, PyValueError};
use pyo3::prelude::*;
use toml::Table;

use crate::errors;

/// A scene with its text.
#[pyclass(frozen, module = "enact_motion._core")]
pub struct Scene {
    pub of: SceneInMemory,
}

/// The place of a name; an error says what names there are.
pub fn place<'a>(
    what: &str,
    name: &str,
    mut names: impl Iterator<Item = &'a String> + Clone,
) -> PyResult<usize> {
    let all: Vec<&str> = names.clone().map(String::as_str).collect();
    names.position(|of| of == name).ok_or_else(|| {
        let all = all.join(", ");
        PyKeyError::new_err(format!(
            "{what}: no {name:?} in the scene, expected one of {all}"
        ))
    })
}

impl Scene {
    /// The track of a name.
    pub fn track(&self, name: &str) -> PyResult<TrackIndex> {
        let names = self.of.scene.tracks.iter().map(|of| &of.name);
        place("track", name, names).map(TrackIndex)
    }
}

#[pymethods]
impl Scene {
    /// Of a text, as if it were that of the file.
    #[new]
    fn new(py: Python<'_>, toml: String, file: Option<PathBuf>) -> PyResult<Self> {
        let scene = scene_from_toml(&toml).map_err(|error| {
            errors::of_scene(
                py,
                &match &file {
                    Some(file) => error.in_file(file.display().to_string()),
                    None => error,
                },
            )
        })?;
        let of = SceneInMemory { scene, toml, file };
        Ok(Self { of })
    }

    /// The text that `enact scene new` makes.
    #[staticmethod]
    #[pyo3(signature = (object, *, mass_g, size_mm, material, tracker_mm, bounces, stamps, lands, unit_m, hull))]
    #[expect(clippy::too_many_arguments, reason = "Python names them")]
    fn text_of_new(
        py: Python<'_>,
        object: String,
        mass_g: Option<f64>,
        size_mm: Option<[f64; 3]>,
        material: Option<String>,
        tracker_mm: Option<[f64; 3]>,
        bounces: usize,
        stamps: String,
        lands: Option<String>,
        unit_m: Option<f64>,
        hull: bool,
    ) -> PyResult<String> {
        let made = made_scene(&NewSceneJob {
            object,
            output: None,
            unit_m,
            take_hull: hull,
            mass_g,
            size_mm,
            material,
            tracker_mm,
            bounces,
            stamps,
            lands,
            command: String::new(),
        });
        match made {
            Ok(made) => Ok(made.toml),
            Err(error) => Err(errors::of_any(py, &error)),
        }
    }

    /// The same with these goals, JSON of what `[[goal]]` has, in place of its own.
    fn with_goals(&self, py: Python<'_>, goals: &str) -> PyResult<Self> {
        let refused = |error: &dyn Display| PyValueError::new_err(format!("goals: {error}"));
        let goals: Vec<Table> = serde_json::from_str(goals).map_err(|error| refused(&error))?;
        let mut table: Table = self.of.toml.parse().map_err(|error| refused(&error))?;
        match goals.is_empty() {
            true => table.remove("goal"),
            false => table.insert("goal".to_owned(), goals.into()),
        };
        let toml = toml::to_string(&table).map_err(|error| refused(&error))?;
        Self::new(py, toml, None)
    }

    #[getter]
    fn toml(&self) -> &str {
        &self.of.toml
    }

    #[getter]
    fn file(&self) -> Option<PathBuf> {
        self.of.file.clone()
    }

    #[getter]
    fn name(&self) -> &str {
        &self.of.scene.name
    }

    #[getter]
    fn bodies(&self) -> Vec<&str> {
        let links = self.of.scene.links.iter();
        links.map(|of| of.name.as_str()).collect()
    }

    #[getter]
    fn events(&self) -> Vec<&str> {
        let events = self.of.scene.events.iter();
        events.map(|of| of.name.as_str()).collect()
    }

    /// Names, and what each sees.
    #[getter]
    fn tracks(&self) -> Vec<(&str, &'static str)> {
        let tracks = self.of.scene.tracks.iter();
        let tracks = tracks.map(|of| {
            let sees = match of.sees {
                Sees::Pose => "pose",
                Sees::Point => "point",
                Sees::Orientation => "orientation",
                Sees::Direction(_) => "direction",
            };
            (of.name.as_str(), sees)
        });
        tracks.collect()
    }
}
