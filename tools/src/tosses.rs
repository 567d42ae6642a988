//! Real tosses of a cube (DAIRLab's contact-nets, BSD-3), which are not part of this repository.
//!
//! The first flight is as long as the manifest that comes with them says; where it does not, until
//! the lowest corner is within 3 mm of the table.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use enact::config::scene_from_toml;
use enact::motion::{LinkIndex, Mark, PoseSample, Scene, Stamp, TakeEvent, TrackIndex};
use enact::physics::contact;
use enact::pipeline::{Outcome, PipelineError};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use crate::case::estimated;

/// As the cameras really ran, and as the data are numbered \[Hz\].
pub const RATES_HZ: [f64; 2] = [148.308, 148.0];
/// A corner nearer to the table than this may have touched it \[m\].
const NEAR_TABLE_M: f64 = 0.003;
/// An impact whose law is guessed, and the events after it.
pub const IMPACT_TOML: &str = "[[event]]\nname = \"impact\"\nkind = \"collision\"\nbody = \"cube\"\n\
                               surface = \"table\"\nrestitution = 0.3\nfriction = 0.15\n";
/// Its law free.
pub const FREE_LAW_TOML: &str = "[[free]]\nquantity = \"impact.restitution\"\n\
                                 [[free]]\nquantity = \"impact.friction\"\nlower = 0\nupper = 2\n";

/// Centre and orientation of a sample.
pub type Pose = (Vector3<f64>, UnitQuaternion<f64>);

/// One toss.
pub struct Toss {
    /// In the manifest.
    pub number: usize,
    /// In order; the cube's centre.
    pub poses: Vec<Pose>,
    /// Samples of the first flight.
    pub flight: usize,
    /// Whether the manifest gives that.
    pub flight_is_given: bool,
}

/// The folder of real recordings, if it is there: `ENACT_REAL`, or `shared/real` beside the
/// repository.
pub fn real_folder() -> Option<PathBuf> {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/real");
    let real = std::env::var_os("ENACT_REAL").map_or(beside, PathBuf::from);
    if real.is_dir() {
        return Some(real);
    }
    eprintln!("skipped: no real recordings at {}", real.display());
    None
}

/// The scene file of a first flight.
pub fn scene_toml() -> &'static str {
    include_str!("../../config/cube_toss.toml")
}

/// The scene of a first flight, gravity free, and all tosses of the manifest; `None` where they are
/// not there.
pub fn all() -> Result<Option<(Scene, Vec<Toss>)>> {
    let scene = scene_from_toml(scene_toml())?;
    let folder = real_folder().map(|real| real.join("tosses"));
    let Some(folder) = folder.filter(|folder| folder.is_dir()) else {
        return Ok(None);
    };
    let manifest = fs::read_to_string(folder.join("manifest.csv"))?;
    let tosses: Result<Vec<Toss>> = manifest
        .lines()
        .skip(1)
        .map(|line| {
            let cells: Vec<&str> = line.split(',').collect();
            let number: usize = cells[0].parse()?;
            let poses = poses(&folder.join(format!("toss_{number:03}.csv")))?;
            let given = cells[4].parse().ok();
            Ok(Toss {
                number,
                flight: given.unwrap_or_else(|| until_near_table(&scene, &poses)),
                poses,
                flight_is_given: given.is_some(),
            })
        })
        .collect();
    Ok(Some((scene, tosses?)))
}

/// Samples of a file: time, position, orientation.
pub fn poses(file: &Path) -> Result<Vec<Pose>> {
    let text = fs::read_to_string(file).with_context(|| file.display().to_string())?;
    let mut poses = Vec::new();
    for line in text.lines().skip(1) {
        let cells: Vec<f64> = line.split(',').map(str::parse).collect::<Result<_, _>>()?;
        let q = Quaternion::new(cells[4], cells[5], cells[6], cells[7]);
        poses.push((
            Vector3::new(cells[1], cells[2], cells[3]),
            UnitQuaternion::new_normalize(q),
        ));
    }
    Ok(poses)
}

fn until_near_table(scene: &Scene, poses: &[Pose]) -> usize {
    let features = scene.links[LinkIndex(0)].features.iter();
    let corners: Vec<Vector3<f64>> = features
        .filter_map(|feature| match feature.geometry {
            contact::Feature::Point { point_m, .. } => Some(point_m),
            _ => None,
        })
        .collect();
    let is_clear = |(x, q): &&Pose| {
        let mut corners = corners.iter();
        corners.all(|corner| (x + q * *corner).z > NEAR_TABLE_M)
    };
    poses.iter().take_while(is_clear).count()
}

impl Toss {
    /// Its first samples, and marks at places between them, counted in samples.
    pub fn take(&self, rate_hz: f64, samples: usize, marks: &[(f64, &str)]) -> Vec<TakeEvent> {
        let stamp = |place: f64| Stamp((place / rate_hz * 1e9).round() as i64);
        let poses = self.poses.iter().take(samples).enumerate();
        let poses = poses.map(|(index, (position_m, q))| TakeEvent::Pose {
            track: TrackIndex(0),
            stream: 0,
            sample: PoseSample::new(stamp(index as f64), *position_m, [q.i, q.j, q.k, q.w]),
        });
        let marks = marks.iter().map(|(place, event)| {
            TakeEvent::Mark(Mark {
                stamp: stamp(place.max(0.0)),
                event: Some((*event).into()),
            })
        });
        poses.chain(marks).collect()
    }

    /// The samples of the first flight, its end marked as the impact.
    pub fn first_flight_take(&self, rate_hz: f64) -> Vec<TakeEvent> {
        let marks = [(self.flight as f64 - 1.0, "impact")];
        self.take(rate_hz, self.flight, &marks)
    }

    /// The estimate of the first flight.
    pub fn first_flight(&self, scene: &Scene, rate_hz: f64) -> Result<Outcome, PipelineError> {
        estimated(scene, &self.first_flight_take(rate_hz), &mut ())
    }
}

/// The file of an event that ends the motion.
pub fn end_toml(name: &str) -> String {
    format!("[[event]]\nname = \"{name}\"\nkind = \"end\"\n")
}
