//! Scenes of an object over a table.

use std::fmt::Write;

use thiserror::Error;

use super::error::SceneError;
use super::keys::nearest;
use super::material::{Coefficient, Material};
use super::mesh::{MeshError, MeshFormat, mesh};
use super::preset::{PRESETS, Preset, TENNIS_BALL, preset};
use super::text::scene_from_toml;
use crate::physics::shape::TriangleMesh;

/// Most corners of a mesh that become features.
const CORNERS: usize = 40;

/// Most collisions before the end.
const BOUNCES: usize = 100;

/// What a scene is made of.
#[derive(Clone, Debug, PartialEq)]
pub struct NewScene {
    /// What flies.
    pub object: NewObject,
    /// Its mass \[g\], if it is another than that of the preset; of a mesh it is needed.
    pub mass_g: Option<f64>,
    /// Its sides along x, y and z \[mm\], if they are others than those of the preset, which is a box then.
    pub size_mm: Option<[f64; 3]>,
    /// How it bounces or rubs, by the name of a [`Material`]; by default as is usual for it, roughly.
    pub material: Option<String>,
    /// Where the tracker is on it \[mm\], in its frame.
    pub tracker_mm: Option<[f64; 3]>,
    /// How often it bounces before it lands.
    pub bounces: usize,
    /// What stamps are: `tempo`, `physical`.
    pub stamps: String,
    /// The axis or the face that is up when all has come to rest, in any yaw.
    pub lands: Option<String>,
}

/// What flies.
#[derive(Clone, Debug, PartialEq)]
pub enum NewObject {
    /// A preset, by its name.
    Preset(String),
    /// A mesh.
    Mesh {
        /// What the body is called.
        name: String,
        /// The bytes of its file.
        bytes: Vec<u8>,
        /// What they are.
        format: MeshFormat,
        /// Its unit of length \[m\].
        unit_m: f64,
        /// Whether its convex hull is taken.
        take_hull: bool,
    },
}

/// A scene that was made.
#[derive(Clone, Debug, PartialEq)]
pub struct MadeScene {
    /// The scene file; [`scene_from_toml`] reads it.
    pub toml: String,
    /// Its name.
    pub name: String,
    /// What was computed or decided, for people.
    pub notes: Vec<String>,
}

/// Why no scene is made.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum NewSceneError {
    /// There is no such preset.
    #[error("no object {name:?}, {expected}")]
    Object {
        /// As given.
        name: String,
        /// What there is.
        expected: String,
    },
    /// There is no such material.
    #[error("no material {name:?}, {expected}")]
    Material {
        /// As given.
        name: String,
        /// What there is.
        expected: String,
    },
    /// A mesh without a mass.
    #[error("the mesh has no mass, expected its mass in grams")]
    Mass,
    /// A number that makes no scene.
    #[error("{what} is {value}, expected {expected}")]
    Number {
        /// Which.
        what: &'static str,
        /// As given.
        value: f64,
        /// What would do.
        expected: &'static str,
    },
    /// A size for what has none.
    #[error("{name:?} has no sides, expected a size for {expected} only")]
    Size {
        /// As given.
        name: String,
        /// What has one.
        expected: String,
    },
    /// Another size, and no mass.
    #[error("another size has another mass, expected the mass in grams too")]
    SizeWithoutMass,
    /// The mesh is refused.
    #[error("the mesh: {0}")]
    Mesh(#[from] MeshError),
    /// The scene that is made is refused.
    #[error("the scene that this makes is refused: {}", .0.message)]
    Refused(SceneError),
}

/// What a scene says whose stamps are physical: who acts seldom keeps the tempo of a fall.
const MEASURED: &str = "# Nobody acted it: what is left of the motion is a tracker's errors. Where somebody did, \"acted\".\n\
                        hand = \"none\"\n";

/// The text of a scene in which an object bounces on a table and lands. Fails with the reason where there is no
/// such object, where a mesh is no solid, and where a number makes no scene.
pub fn new_scene(of: &NewScene) -> Result<MadeScene, NewSceneError> {
    if of.bounces > BOUNCES {
        return Err(NewSceneError::Number {
            what: "the number of bounces",
            value: of.bounces as f64,
            expected: "100 at most",
        });
    }
    let material = of.material.as_deref().map(|name| {
        Material::named(name).map_err(|expected| NewSceneError::Material {
            name: name.to_owned(),
            expected,
        })
    });
    let material = material.transpose()?;
    let mut notes = Vec::new();
    let (name, title, mut body, feature) = match &of.object {
        NewObject::Preset(name) => {
            let preset = preset(name).ok_or_else(|| unknown(name))?;
            let preset = meant(preset, material)?;
            let body = of_preset(preset, of.mass_g, of.size_mm)?;
            (
                preset.name.to_owned(),
                preset.what.to_owned(),
                body,
                preset.feature,
            )
        }
        NewObject::Mesh {
            name,
            bytes,
            format,
            unit_m,
            take_hull,
        } => {
            if !(*unit_m > 0.0 && unit_m.is_finite()) {
                return Err(NewSceneError::Number {
                    what: "the unit",
                    value: *unit_m,
                    expected: "a positive number of metres",
                });
            }
            let mass_g = of.mass_g.ok_or(NewSceneError::Mass)?;
            if of.size_mm.is_some() {
                return Err(without_sides(name));
            }
            let mesh = mesh(bytes, *format, *unit_m, *take_hull)?;
            let body = of_mesh(&mesh, mass_g, &mut notes)?;
            if *format == MeshFormat::Glb {
                notes.push(
                    "glTF is y up, the scene z up: x, y, z of the body are x, -z, y of the file"
                        .into(),
                );
            }
            let title = format!("{name}, of a mesh; in the frame of the mesh");
            (name.clone(), title, body, None)
        }
    };
    let restitution = material.and_then(|material| match material.states() {
        (Coefficient::Restitution, between) => Some(between),
        (Coefficient::Friction, _) => None,
    });
    if let (NewObject::Mesh { .. }, None) = (&of.object, restitution) {
        notes.push("the restitution is a guess: set it, or free it by [[free]]".into());
    }
    if let Some(material) = material {
        body.take(material);
        let (of, _) = material.states();
        notes.push(format!(
            "{} of {}, by {}; {} is not said there and stays as it was",
            of.key(),
            material.what,
            material.source,
            of.other().key()
        ));
    }
    let mut toml = String::new();
    let quoted = toml::Value::from(name.as_str()).to_string();
    let _ = write!(
        toml,
        "# {title}.\n# World: table at z = 0, z up.\n\nname = {quoted}\n\
         # The motion goes on by simulation until all rests.\nsettle_s = 5\n{}\n\
         [timing]\nstamps = {}\n\n[[body]]\nname = {quoted}\n{}",
        match of.stamps.as_str() {
            "physical" => MEASURED,
            _ => "",
        },
        toml::Value::from(of.stamps.as_str()),
        body.keys
    );
    match of.tracker_mm {
        Some([x, y, z]) => {
            let _ = writeln!(toml, "tracker = {{ position_mm = [{x}, {y}, {z}] }}");
        }
        None => {
            toml += "# Where the tracker is on it, in the frame in which it is given here.\n\
                     tracker = { position_mm = [0, 0, 0], orientation_wxyz = [1, 0, 0, 0] }\n";
            notes.push(
                "the tracker is taken to be at the origin of the body, along its axes: set `body.tracker`"
                    .into(),
            );
        }
    }
    toml += &body.tables;
    toml += "\n[[surface]]\nname = \"table\"\npoint_mm = [0, 0, 0]\nnormal = [0, 0, 1]\n";
    for bounce in 1..=of.bounces {
        let number = match of.bounces {
            1 => String::new(),
            _ => format!(" {bounce}"),
        };
        let _ = write!(
            toml,
            "\n[[event]]\nname = \"bounce{number}\"\nkind = \"collision\"\nbody = {quoted}\nsurface = \"table\"\n"
        );
        match feature {
            Some(feature) => {
                let _ = writeln!(
                    toml,
                    "# Left out, it is inferred which part of the body touches.\nfeature = {feature:?}"
                );
            }
            None => {
                toml += "# Which part of the body touches is inferred; `feature` would say it.\n"
            }
        }
    }
    if let Some([lower, upper]) = restitution.filter(|[a, b]| a < b) {
        let quantity = toml::Value::from(format!("{name}.restitution"));
        let _ = write!(
            toml,
            "\n# As far as the rule lets it differ.\n[[free]]\nquantity = {quantity}\nlower = {lower}\nupper = {upper}\n"
        );
    }
    toml += "\n[[event]]\nname = \"landing\"\nkind = \"end\"\n";
    if let Some(up) = &of.lands {
        let up = toml::Value::from(up.as_str());
        let _ = write!(
            toml,
            "\n# So it rests in the end, in any yaw.\n[[goal]]\nevent = \"rest\"\nbody = {quoted}\nface_up = {up}\n"
        );
    }
    scene_from_toml(&toml).map_err(NewSceneError::Refused)?;
    Ok(MadeScene { toml, name, notes })
}

/// The object that is meant with a material: of "ball", the ball that bounces so. Fails where another object is named
/// than the one that does.
fn meant(
    named: &'static Preset,
    material: Option<&'static Material>,
) -> Result<&'static Preset, NewSceneError> {
    let Some((material, object)) = material.and_then(|of| Some((of, of.object?))) else {
        return Ok(named);
    };
    let bounces = preset(object).filter(|of| named.name == TENNIS_BALL || of.name == named.name);
    bounces.ok_or_else(|| NewSceneError::Material {
        name: material.name.to_owned(),
        expected: format!(
            "for {:?}: {} bounces so, expected `scene new {object}`",
            named.name, material.what
        ),
    })
}

fn unknown(name: &str) -> NewSceneError {
    let names: Vec<&str> = PRESETS.iter().map(|of| of.name).collect();
    let meant = match nearest(name, &names) {
        Some(near) => format!("did you mean {near}? Expected"),
        None => "expected".into(),
    };
    NewSceneError::Object {
        name: name.to_owned(),
        expected: format!(
            "{meant} one of {}, or a mesh file (.obj, .stl, .glb)",
            names.join(", ")
        ),
    }
}

/// The lines of a body.
struct BodyText {
    /// Its keys.
    keys: String,
    /// Tables below it.
    tables: String,
}

impl BodyText {
    /// Takes the coefficient of a material, in the middle of what is stated; of friction with the standard deviation of a value
    /// that is as likely anywhere between.
    fn take(&mut self, material: &Material) {
        let (of, [least, most]) = material.states();
        let (key, middle) = (of.key(), ((least + most) * 500.0).round() / 1e3);
        let told_on = format!("{key} on");
        let lines = self.keys.lines();
        let others = lines.filter(|line| !line.starts_with(key) && !line.contains(&told_on));
        let mut keys: String = others.map(|line| format!("{line}\n")).collect();
        let _ = write!(
            keys,
            "# {}: {}.\n{key} = {middle}\n",
            material.what, material.source
        );
        if of == Coefficient::Friction {
            let sd = ((most - least) / 12.0_f64.sqrt() * 1e3).round() / 1e3;
            let _ = writeln!(keys, "friction_sd = {sd}");
        }
        self.keys = keys;
    }
}

fn of_preset(
    preset: &Preset,
    mass_g: Option<f64>,
    size_mm: Option<[f64; 3]>,
) -> Result<BodyText, NewSceneError> {
    let mut body = preset.body.to_owned();
    if let Some(size_mm) = size_mm {
        let sized = preset.sized(size_mm);
        body = sized.ok_or_else(|| without_sides(preset.name))?;
        if mass_g.is_none() && preset.mass.starts_with("mass_g") {
            return Err(NewSceneError::SizeWithoutMass);
        }
    }
    let mass = match mass_g {
        Some(mass_g) => format!("mass_g = {mass_g}\n"),
        None => format!("# {}.\n{}\n", preset.source, preset.mass),
    };
    Ok(BodyText {
        keys: mass + &body,
        tables: preset.parts.to_owned(),
    })
}

fn without_sides(name: &str) -> NewSceneError {
    let with = PRESETS.iter().filter(|of| of.has_sides());
    let names: Vec<&str> = with.map(|of| of.name).collect();
    NewSceneError::Size {
        name: name.to_owned(),
        expected: names.join(", "),
    }
}

fn of_mesh(
    mesh: &TriangleMesh,
    mass_g: f64,
    notes: &mut Vec<String>,
) -> Result<BodyText, NewSceneError> {
    if !(mass_g > 0.0 && mass_g.is_finite()) {
        return Err(NewSceneError::Number {
            what: "the mass in grams",
            value: mass_g,
            expected: "a positive number",
        });
    }
    let mass = mesh.mass().map_err(MeshError::Shape)?;
    let pieces = mesh.pieces().map_err(MeshError::Shape)?;
    let corners_m = mesh.hull_corners_m(CORNERS).map_err(MeshError::Shape)?;
    let point = |p: &nalgebra::Vector3<f64>| {
        let [x, y, z] = [p.x, p.y, p.z].map(micrometres);
        format!("[{x}, {y}, {z}]")
    };
    let hulls = pieces.parts.iter().map(|part| match &part.shape {
        crate::physics::Shape::Hull { points_m } => {
            let points: Vec<String> = points_m.iter().map(point).collect();
            format!("  [{}],\n", points.join(", "))
        }
        _ => String::new(),
    });
    let hulls: String = hulls.collect();
    let c = mass.centre_m * 1e3;
    let t = mass.tensor_m2 * (mass_g * 1e-3);
    let mut keys = format!(
        "mass_g = {mass_g}\n\
         # Computed from the closed surface at uniform density.\n\
         centre_mm = [{}, {}, {}]\ninertia_kg_m2 = [{}, {}, {}, {}, {}, {}]\n\
         # Its coefficient of restitution on the table.\nrestitution = 0.4\n",
        c.x,
        c.y,
        c.z,
        t[(0, 0)],
        t[(1, 1)],
        t[(2, 2)],
        t[(0, 1)],
        t[(0, 2)],
        t[(1, 2)]
    );
    let _ = write!(
        keys,
        "shape = {{ kind = \"pieces\", pieces_mm = [\n{hulls}] }}\n"
    );
    let mut tables = String::from(
        "\n# Corners of its convex hull, by which it may touch.\n[body.features_mm]\n",
    );
    for (index, corner) in corners_m.iter().enumerate() {
        let _ = writeln!(tables, "\"corner {}\" = {}", index + 1, point(corner));
    }
    notes.push(format!(
        "{} triangles, {} cm³, {} convex {}, {} corners",
        mesh.triangles(),
        (mass.volume_m3 * 1e8).round() / 100.0,
        pieces.parts.len(),
        if pieces.parts.len() == 1 {
            "piece"
        } else {
            "pieces"
        },
        corners_m.len()
    ));
    Ok(BodyText { keys, tables })
}

/// Millimetres to the micrometre.
fn micrometres(m: f64) -> f64 {
    (m * 1e6).round() / 1e3
}
