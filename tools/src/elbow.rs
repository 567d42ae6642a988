//! Real tosses of two boxes joined by a hinge: DAIR Lab's elbow, from their first reading until a corner is near the
//! table.
//!
//! Readings, sizes, masses and the hinge are those of `assets/contactnets_elbow.urdf` and its data in
//! `DAIRLab/dair_pll` (BSD-3): pose of the first box and angle of the hinge at 148.3 Hz, as its authors filtered
//! them. Where the second box was is told by these, through the hinge as documented.

use std::path::{Path, PathBuf};

use enact::config::scene_from_toml;
use enact::math::Pose;
use enact::motion::{Mark, PoseSample, Scene, Stamp, TakeEvent, TrackIndex};
use enact::write::WriteError;
use nalgebra::{Point3, Quaternion, UnitQuaternion, Vector3};

use crate::perform::recording::write_events_of;
use crate::tosses::real_folder;

/// Half the size of a box \[m\].
const HALF_M: [f64; 3] = [0.05, 0.025, 0.025];
/// The hinge in the first box, and the second's centre from it \[m\].
const HINGE_M: [[f64; 3]; 2] = [[-0.035, 0.06, 0.0], [0.035, 0.0, 0.0]];
/// Height at which a corner may touch before the next reading \[m\]: a corner that falls at 3 m/s gets so far.
const NEAR_M: f64 = 0.02;
/// Height above which no corner but that of the first impact touches \[m\],
const APART_M: f64 = 0.005;
/// and least number of readings from the impact on.
const AFTER_LEAST: usize = 6;

/// A reading: time \[s\], pose of the first box, angle of the hinge \[rad\].
#[derive(Clone, Copy, Debug)]
pub struct Reading {
    /// Time \[s\].
    pub time_s: f64,
    /// The first box in the world.
    pub first: Pose,
    /// Angle of the hinge \[rad\].
    pub angle_rad: f64,
}

/// How a toss is read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reads {
    /// Whether the second box is seen as well; otherwise its angle at the start is a goal.
    pub sees_both: bool,
    /// Moment of inertia of a box about all axes [kg m²]; `None`: of a uniform one.
    pub moment_kg_m2: Option<f64>,
    /// By how much the hinge is said to be elsewhere along the first box \[m\].
    pub hinge_off_m: f64,
}

impl Reading {
    /// The second box.
    pub fn second(&self) -> Pose {
        let [hinge, centre] = HINGE_M.map(Vector3::from);
        let turn = UnitQuaternion::from_scaled_axis(Vector3::y() * self.angle_rad);
        self.first * Pose::from_parts(hinge.into(), turn) * Pose::from(centre)
    }

    /// Heights of the corners \[m\]: of the first box, then of the second.
    fn heights_m(&self) -> [f64; 16] {
        let both = [self.first, self.second()];
        std::array::from_fn(|index| {
            let corner = Corner(index);
            let at_m = Vector3::from_fn(|axis, _| corner.sign(axis) * HALF_M[axis]);
            (both[corner.of()] * Point3::from(at_m)).z
        })
    }

    /// Height of the lowest corner of both boxes \[m\].
    fn lowest_m(&self) -> f64 {
        self.heights_m().into_iter().fold(f64::INFINITY, f64::min)
    }
}

/// One of the corners of both boxes: those of the first box, then of the second.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Corner(usize);

impl Corner {
    /// Which box it is of: 0 or 1.
    fn of(self) -> usize {
        self.0 / 8
    }

    fn sign(self, axis: usize) -> f64 {
        if self.0 >> axis & 1 == 0 { -1.0 } else { 1.0 }
    }

    /// As scenes name it.
    fn feature(self) -> String {
        let signs = [0, 1, 2].map(|axis| if self.sign(axis) < 0.0 { '-' } else { '+' });
        format!("corner {}x {}y {}z", signs[0], signs[1], signs[2])
    }
}

/// The readings of a toss through its first impact, as far as one corner alone is near the table.
#[derive(Clone, Debug)]
pub struct FirstImpact {
    /// From the first on.
    pub readings: Vec<Reading>,
    /// The reading at which the corner is lowest.
    pub lowest: usize,
    /// What hits.
    pub corner: Corner,
}

/// How the law of the first impact is read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReadLaw {
    /// Restitution and friction, or where they begin.
    pub law: [f64; 2],
    /// Whether both are free.
    pub is_free: bool,
    /// Height of the table \[m\].
    pub table_m: f64,
}

/// The files of all tosses, in order; none where they are not there.
pub fn files() -> Vec<PathBuf> {
    let Some(folder) = real_folder().map(|real| real.join("elbow")) else {
        return Vec::new();
    };
    let Ok(entries) = std::fs::read_dir(&folder) else {
        eprintln!("skipped: no tosses of an elbow at {}", folder.display());
        return Vec::new();
    };
    let paths = entries.filter_map(|entry| Some(entry.ok()?.path()));
    let mut paths: Vec<PathBuf> = paths
        .filter(|path| path.extension().is_some_and(|of| of == "csv"))
        .collect();
    paths.sort();
    paths
}

/// The readings of a toss before a corner is near the table.
///
/// # Panics
/// Where the file is not as documented.
pub fn flight(path: &Path) -> Vec<Reading> {
    let readings = readings(path).into_iter();
    readings
        .take_while(|reading| reading.lowest_m() > NEAR_M)
        .collect()
}

/// The readings through the first impact; `None` where another corner is near the table too soon after it.
///
/// # Panics
/// Where the file is not as documented.
pub fn first_impact(path: &Path) -> Option<FirstImpact> {
    let mut readings = readings(path);
    let lowest_m: Vec<f64> = readings.iter().map(Reading::lowest_m).collect();
    let near = lowest_m.iter().position(|lowest_m| *lowest_m < NEAR_M)?;
    let falls = lowest_m[near..].windows(2);
    let lowest = near + falls.take_while(|pair| pair[1] < pair[0]).count();
    let at_m = readings[lowest].heights_m();
    let corner = (0..16).min_by(|a, b| at_m[*a].total_cmp(&at_m[*b]))?;
    let mut before_m = f64::NEG_INFINITY;
    let free = readings[lowest..].iter().take_while(|reading| {
        let heights_m = reading.heights_m();
        let mut others = (0..16).filter(|other| *other != corner);
        let own_m = heights_m[corner];
        let rises = own_m > before_m.min(NEAR_M);
        before_m = own_m;
        rises && others.all(|other| heights_m[other] > APART_M)
    });
    let after = free.count();
    readings.truncate(lowest + after);
    (after >= AFTER_LEAST).then_some(FirstImpact {
        readings,
        lowest,
        corner: Corner(corner),
    })
}

fn readings(path: &Path) -> Vec<Reading> {
    let text = std::fs::read_to_string(path).expect("a file of the folder");
    let rows = text.lines().skip(1).map(|line| {
        let numbers: Vec<f64> = line
            .split(',')
            .map(|part| part.trim().parse().expect("a number"))
            .collect();
        let &[time_s, x, y, z, qw, qx, qy, qz, angle_rad] = numbers.as_slice() else {
            panic!("nine columns");
        };
        let turn = UnitQuaternion::new_normalize(Quaternion::new(qw, qx, qy, qz));
        Reading {
            time_s,
            first: Pose::from_parts(Vector3::new(x, y, z).into(), turn),
            angle_rad,
        }
    });
    rows.collect()
}

/// Scene and events of a flight.
pub fn take(flight: &[Reading], reads: &Reads) -> (Scene, Vec<TakeEvent>) {
    taken(flight, (&scene_toml(flight, reads, ""), reads), None)
}

/// Writes a flight with its scene.
///
/// # Errors
/// Where the file cannot be written.
pub fn write(flight: &[Reading], reads: &Reads, path: &Path) -> Result<(), WriteError> {
    let (scene, events) = take(flight, reads);
    write_events_of(&scene, &scene_toml(flight, reads, ""), &events, path)
}

/// Scene and events of a toss through its first impact.
pub fn take_struck(of: &FirstImpact, reads: &Reads, law: &ReadLaw) -> (Scene, Vec<TakeEvent>) {
    let [restitution, friction] = law.law;
    let mut hit = format!(
        "\n[[surface]]\nname = \"table\"\npoint_mm = [0, 0, {:?}]\nnormal = [0, 0, 1]\n\n[[event]]\nname = \"hit\"\nkind = \"collision\"\nbody = \"{}\"\nfeature = \"{}\"\nsurface = \"table\"\nrestitution = {restitution:?}\nfriction = {friction:?}\n",
        1e3 * law.table_m,
        ["first", "second"][of.corner.of()],
        of.corner.feature(),
    );
    if law.is_free {
        hit += "\n[[free]]\nquantity = \"hit.restitution\"\n\n[[free]]\nquantity = \"hit.friction\"\nupper = 1.5\n";
    }
    let toml = scene_toml(&of.readings, reads, &hit);
    taken(&of.readings, (&toml, reads), Some(of.lowest))
}

fn taken(
    flight: &[Reading],
    (toml, reads): (&str, &Reads),
    hit: Option<usize>,
) -> (Scene, Vec<TakeEvent>) {
    let scene = scene_from_toml(toml).expect("a valid scene");
    let stamp = |reading: &Reading| Stamp(1_000_000_000 + (1e9 * reading.time_s).round() as i64);
    let mark = |name: &str, reading: &Reading| {
        TakeEvent::Mark(Mark {
            stamp: stamp(reading),
            event: Some(name.to_owned()),
        })
    };
    let mut events = Vec::new();
    for reading in flight {
        let both = [reading.first, reading.second()];
        let seen = if reads.sees_both {
            &both[..]
        } else {
            &both[..1]
        };
        for (track, pose) in seen.iter().enumerate() {
            events.push(TakeEvent::Pose {
                track: TrackIndex(track),
                stream: 0,
                sample: PoseSample::from_pose(stamp(reading), pose),
            });
        }
    }
    events.push(mark("start", &flight[0]));
    events.extend(hit.map(|hit| mark("hit", &flight[hit])));
    events.push(mark("end", &flight[flight.len() - 1]));
    (scene, events)
}

fn scene_toml(flight: &[Reading], reads: &Reads, hit: &str) -> String {
    let mut text = String::from(
        "name = \"elbow\"\n\n[timing]\nstamps = \"physical\"\n\n[weights]\nposition_mm = 1\norientation_deg = 1\n",
    );
    for name in ["first", "second"] {
        text += &format!(
            "\n[[body]]\nname = \"{name}\"\nshape = {{ kind = \"cuboid\", size_mm = [100, 50, 50] }}\nmass_g = 370\n"
        );
        if let Some(moment) = reads.moment_kg_m2 {
            text += &format!("moments_kg_m2 = [{moment:?}, {moment:?}, {moment:?}]\n");
        }
        if name == "second" && !reads.sees_both {
            text += "tracked = false\n";
        }
    }
    let hinge_mm = -35.0 + 1e3 * reads.hinge_off_m;
    text += &format!(
        "\n[[joint]]\nname = \"hinge\"\nkind = \"pin\"\naxis = [0, 1, 0]\nparent = \"first\"\nparent_at_mm = [{hinge_mm:?}, 60, 0]\nchild = \"second\"\nchild_at_mm = [-35, 0, 0]\n"
    );
    text += "\n[[event]]\nname = \"start\"\nkind = \"start\"\n";
    text += hit;
    text += "\n[[event]]\nname = \"end\"\nkind = \"end\"\n";
    if !reads.sees_both {
        let angle_deg = flight[0].angle_rad.to_degrees();
        text += &format!(
            "\n[[goal]]\nevent = \"start\"\njoint = \"hinge\"\nangles_deg = [{angle_deg:?}]\n"
        );
    }
    text
}
