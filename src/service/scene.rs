//! Scenes: made of objects and meshes, and looked at.

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use serde::Serialize;

use super::output::{refuse_present, write_new_file};
use super::provenance::made_by;
use crate::config::{
    BodyCheck, MadeScene, MeshFormat, NewObject, NewScene, SceneCheck, check_scene, new_scene,
    scene_from_toml,
};
use crate::ingest::{read_text, read_whole};

/// The input of [`make_scene`].
#[derive(Clone, Debug)]
pub struct NewSceneJob {
    /// Name of a preset, or a mesh file.
    pub object: String,
    /// The scene, TOML; by default named as the object, in the working folder.
    pub output: Option<PathBuf>,
    /// Unit of length of a mesh \[m\]; glTF is in metres, other files say none.
    pub unit_m: Option<f64>,
    /// Whether the convex hull of a mesh is taken.
    pub take_hull: bool,
    /// Mass \[g\].
    pub mass_g: Option<f64>,
    /// Sides of a preset that is a box \[mm\], if they are others.
    pub size_mm: Option<[f64; 3]>,
    /// How it bounces or rubs, by the name of a material.
    pub material: Option<String>,
    /// Where the tracker is on it \[mm\].
    pub tracker_mm: Option<[f64; 3]>,
    /// How often it bounces before it lands.
    pub bounces: usize,
    /// `tempo` or `physical`.
    pub stamps: String,
    /// The axis or face that is up in the end.
    pub lands: Option<String>,
    /// The command that asks for it, which is noted in the scene.
    pub command: String,
}

/// The result of [`make_scene`].
#[derive(Clone, Debug, Serialize)]
pub struct NewSceneMade {
    /// The file that was written.
    pub output: String,
    /// Name of the scene.
    pub scene: String,
    /// Its body, as it was computed.
    pub body: BodyCheck,
    /// What was computed or decided.
    pub notes: Vec<String>,
}

/// Writes a scene of an object over a table. Never replaces a file: a scene is worked on by hand.
pub fn make_scene(job: &NewSceneJob) -> anyhow::Result<NewSceneMade> {
    if let Some(output) = &job.output {
        refuse_present(output)?;
    }
    let path = Path::new(&job.object);
    let made = made_scene(job)?;
    let output = job.output.clone();
    let output = output.unwrap_or_else(|| PathBuf::from(format!("{}.toml", made.name)));
    refuse_present(&output)?;
    let scene = scene_from_toml(&made.toml)?;
    let checked = check_scene(&scene);
    let body = checked.bodies.into_iter().next();
    // Of a preset there is no such file.
    let text = made_by(&job.command, &made.toml);
    write_new_file(&output, text.as_bytes(), &[path])?;
    Ok(NewSceneMade {
        output: output.display().to_string(),
        scene: made.name,
        body: body.context("the scene has no body")?,
        notes: made.notes,
    })
}

/// The scene of an object over a table, which nobody writes.
pub fn made_scene(job: &NewSceneJob) -> anyhow::Result<MadeScene> {
    let path = Path::new(&job.object);
    let ending = path.extension().and_then(|ending| ending.to_str());
    let object = match ending.and_then(MeshFormat::of_ending) {
        None => NewObject::Preset(job.object.clone()),
        Some(format) => {
            let unit_m = match (job.unit_m, format) {
                (Some(unit_m), _) => unit_m,
                (None, MeshFormat::Glb) => 1.0,
                (None, _) => bail!(
                    "{}: the file does not say its unit of length, expected --unit mm, cm, m or in",
                    job.object
                ),
            };
            let bytes = read_whole(path).with_context(|| format!("{}: cannot read", job.object))?;
            let stem = path.file_stem().and_then(|stem| stem.to_str());
            NewObject::Mesh {
                name: stem.unwrap_or("body").to_owned(),
                bytes,
                format,
                unit_m,
                take_hull: job.take_hull,
            }
        }
    };
    if let NewObject::Preset(_) = object
        && (job.unit_m.is_some() || job.take_hull)
    {
        bail!(
            "{}: a unit or a hull is of a mesh, expected a file that ends in .obj, .stl or .glb",
            job.object
        );
    }
    new_scene(&NewScene {
        object,
        mass_g: job.mass_g,
        size_mm: job.size_mm,
        material: job.material.clone(),
        tracker_mm: job.tracker_mm,
        bounces: job.bounces,
        stamps: job.stamps.clone(),
        lands: job.lands.clone(),
    })
    .with_context(|| job.object.clone())
}

/// What the scene in a file means. Fails where the scene is refused.
pub fn look_at_scene(path: &Path) -> anyhow::Result<SceneCheck> {
    let name = path.display().to_string();
    let text = read_text(path).with_context(|| format!("{name}: cannot read"))?;
    let scene = scene_from_toml(&text).map_err(|error| error.in_file(name))?;
    Ok(check_scene(&scene))
}
