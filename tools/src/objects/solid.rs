//! The shapes of the objects, in two ways each, so that one sees whether the shape matters.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use anyhow::{Context, Result};
use enact::math::Pose;
use enact::physics::shape::hull_triangles;
use nalgebra::{Translation3, UnitQuaternion, Vector3};

use super::mesh::{mesh_from_body, vertices};
use crate::tosses::Pose as Sample;

/// Meshes that come with the tosses.
const MESHES: [(&str, &str); 4] = [
    ("bottle", "bundlesdf_bottle_mesh.obj"),
    ("cube", "contactnets_cube.obj"),
    ("prism", "gt_prism_simple.obj"),
    ("toblerone", "gt_toblerone_simple.obj"),
];

/// Objects without a mesh: guesses of household size, axis by axis of the tracked frame, whose origin
/// is taken for their middle. The stored heights are no help: they are shifted so that the last is one
/// number for all. Where an object rests with the same axis up several times, that one is short.
const GUESSES: [(&str, [Guess; 2]); 4] = [
    (
        "egg",
        [
            Guess::Box([300.0, 100.0, 70.0], "carton of a dozen, it rests on ±z"),
            Guess::Sphere(25.0, "hen's egg as a ball"),
        ],
    ),
    (
        "half",
        [
            Guess::Box([70.0, 70.0, 130.0], "pint carton, it rests on ±x"),
            Guess::Box([100.0, 100.0, 100.0], "box as large as the cube"),
        ],
    ),
    (
        "milk",
        [
            Guess::Box([195.0, 70.0, 70.0], "quart carton, long along x"),
            Guess::Box([70.0, 195.0, 70.0], "quart carton, long along y"),
        ],
    ),
    (
        "napkin",
        [
            Guess::Box([230.0, 65.0, 120.0], "flat box, it rests on ±y"),
            Guess::Box([110.0, 130.0, 110.0], "upright box"),
        ],
    ),
];

/// A guessed shape \[mm\], and where it is from.
#[derive(Clone, Copy)]
enum Guess {
    Box([f64; 3], &'static str),
    Sphere(f64, &'static str),
}

/// A shape of an object, in the axes of its body.
pub struct Solid {
    /// Where it is from.
    pub source: String,
    /// Whether it was measured: a mesh, or the box about one.
    pub is_measured: bool,
    /// Balls whose hull it is: their middles and their radius \[m\].
    pub points_m: Vec<Vector3<f64>>,
    /// See `points_m`.
    pub radius_m: f64,
    /// For a scene file.
    pub shape_toml: String,
    /// What may touch, for a scene file: its corners; empty where the shape has none.
    pub features_toml: String,
    /// Pose of the body's axes in the tracked frame.
    pub tracked_from_body: Pose,
}

/// The two shapes of an object: its mesh and the box about it, or two guesses.
pub fn solids(folder: &Path, object: &str) -> Result<[Solid; 2]> {
    let is_it = |name: &str| name == object;
    if let Some((_, file)) = MESHES.iter().find(|(name, _)| is_it(name)) {
        let text = fs::read_to_string(folder.join(file)).with_context(|| (*file).to_owned())?;
        let points_m = vertices(&text)?;
        return Ok([Solid::hull("its mesh", &points_m)?, Solid::about(&points_m)]);
    }
    let guesses = GUESSES.iter().find(|(name, _)| is_it(name));
    let (_, guesses) = guesses.with_context(|| format!("no shape of {object:?}"))?;
    Ok(guesses.map(Solid::guessed))
}

/// Corners as features of a body.
fn features_toml(points_m: &[Vector3<f64>]) -> String {
    let corner = |(index, point): (usize, &Vector3<f64>)| {
        let [x, y, z] = (point * 1e3).into();
        format!("corner_{index} = [{x:?}, {y:?}, {z:?}]\n")
    };
    let corners: String = points_m.iter().enumerate().map(corner).collect();
    format!("[body.features_mm]\n{corners}")
}

impl Solid {
    /// The hull of a mesh's vertices, of uniform density.
    pub fn hull(source: &str, vertices_m: &[Vector3<f64>]) -> Result<Self> {
        let tracked_from_body = mesh_from_body(vertices_m)?;
        let to_body = |vertex: &Vector3<f64>| {
            tracked_from_body
                .inverse_transform_point(&(*vertex).into())
                .coords
        };
        let all_m: Vec<Vector3<f64>> = vertices_m.iter().map(to_body).collect();
        let corners_m: Vec<Vector3<f64>> = hull_triangles(&all_m)?.into_iter().flatten().collect();
        let is_corner = |point: &Vector3<f64>| corners_m.contains(point);
        let points_m: Vec<Vector3<f64>> = all_m.into_iter().filter(is_corner).collect();
        let mut shape_toml = "{ kind = \"hull\", points_mm = [".to_owned();
        for point in &points_m {
            let [x, y, z] = (point * 1e3).into();
            write!(shape_toml, "[{x:?}, {y:?}, {z:?}], ")?;
        }
        shape_toml += "] }";
        Ok(Self {
            source: source.to_owned(),
            is_measured: true,
            features_toml: features_toml(&points_m),
            points_m,
            radius_m: 0.0,
            shape_toml,
            tracked_from_body,
        })
    }

    /// The box about a mesh, along the axes of its file.
    pub fn about(vertices_m: &[Vector3<f64>]) -> Self {
        let (low_m, high_m) = vertices_m
            .iter()
            .fold((vertices_m[0], vertices_m[0]), |(low_m, high_m), vertex| {
                (low_m.inf(vertex), high_m.sup(vertex))
            });
        let middle_m = Translation3::from((low_m + high_m) / 2.0);
        Self {
            tracked_from_body: Pose::from_parts(middle_m, UnitQuaternion::identity()),
            ..Self::cuboid("box about its mesh", &(high_m - low_m), true)
        }
    }

    fn guessed(guess: Guess) -> Self {
        match guess {
            Guess::Box(size_mm, source) => {
                Self::cuboid(source, &(Vector3::from(size_mm) / 1e3), false)
            }
            Guess::Sphere(radius_mm, source) => Self {
                source: source.to_owned(),
                is_measured: false,
                points_m: vec![Vector3::zeros()],
                radius_m: radius_mm / 1e3,
                shape_toml: format!("{{ kind = \"sphere\", radius_mm = {radius_mm:?} }}"),
                features_toml: String::new(),
                tracked_from_body: Pose::identity(),
            },
        }
    }

    fn cuboid(source: &str, size_m: &Vector3<f64>, is_measured: bool) -> Self {
        let corner = |of: usize| {
            Vector3::from_fn(|axis, _| if of >> axis & 1 == 0 { 0.5 } else { -0.5 })
                .component_mul(size_m)
        };
        let [x, y, z] = (size_m * 1e3).into();
        let points_m: Vec<Vector3<f64>> = (0..8).map(corner).collect();
        Self {
            source: source.to_owned(),
            is_measured,
            features_toml: features_toml(&points_m),
            points_m,
            radius_m: 0.0,
            shape_toml: format!("{{ kind = \"cuboid\", size_mm = [{x:?}, {y:?}, {z:?}] }}"),
            tracked_from_body: Pose::identity(),
        }
    }

    /// Pose of the body where a sample shows the tracked frame.
    pub fn world_from_body(&self, sample: &Sample) -> Pose {
        let tracked = Pose::from_parts(Translation3::from(sample.0), sample.1);
        tracked * self.tracked_from_body
    }

    /// Height of its lowest point there \[m\].
    pub fn lowest_m(&self, world_from_body: &Pose) -> f64 {
        let height_m = |point: &Vector3<f64>| (world_from_body * nalgebra::Point3::from(*point)).z;
        let heights_m = self.points_m.iter().map(height_m);
        heights_m.fold(f64::INFINITY, f64::min) - self.radius_m
    }
}
