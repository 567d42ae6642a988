//! Real recordings that are no free flight of one rigid body, and some that are.
//!
//! None of them is part of this repository; where they are absent, rows are too, and that is said.

use std::fs;
use std::path::{Path, PathBuf};

use enact::config::scene_from_toml;
use enact::ingest::Recording;
use enact::motion::{Mark, PoseSample, Scene, Stamp, TakeEvent, TrackIndex};
use nalgebra::Vector3;

use super::Asked;
use crate::tosses::RATES_HZ;

/// Samples of the boxes' first flight that are surely before the table.
const ELBOW_SAMPLES: usize = 12;
/// A window of the hovering vehicle, and from one to the next \[s\].
const WINDOW_S: f64 = 2.0;
const STRIDE_S: f64 = 8.0;

/// The files of a folder with that extension, in order of name.
pub fn files(folder: &Path, extension: &str) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let mut files: Vec<PathBuf> = entries.map(|entry| entry.path()).collect();
    files.retain(|file| file.extension().is_some_and(|is| is == extension));
    files.sort();
    files
}

/// A scene of one body that flies and nothing else.
pub fn flight(shape: &str, mass_kg: f64, stamps: &str, more: &str) -> Scene {
    let text = format!(
        "name = \"flight\"\n[timing]\nstamps = {stamps:?}\n[[body]]\nname = \"thing\"\n\
         shape = {shape}\nmass_kg = {mass_kg}\nfeatures_mm = {{}}\n\
         [[event]]\nname = \"end\"\nkind = \"end\"\n{more}"
    );
    scene_from_toml(&text).expect("a valid scene")
}

const FREE_GRAVITY: &str = "[[free]]\nquantity = \"gravity.x\"\n[[free]]\nquantity = \"gravity.y\"\n\
                            [[free]]\nquantity = \"gravity.z\"\n";

/// Two hinged boxes taken for one: the first samples of the first link, gravity free.
pub fn elbow(file: &Path) -> Asked {
    let shape = "{ kind = \"cuboid\", size_mm = [100, 50, 50] }";
    Asked {
        scene: flight(shape, 0.37, "physical", FREE_GRAVITY),
        events: csv(file, 1.0 / RATES_HZ[0], ELBOW_SAMPLES),
    }
}

/// The first flight of a tossed cube, gravity free.
pub fn toss(file: &Path, samples: usize) -> Asked {
    let shape = "{ kind = \"cuboid\", size_mm = [104.8, 104.8, 104.8] }";
    Asked {
        scene: flight(shape, 0.37, "physical", FREE_GRAVITY),
        events: csv(file, 1.0 / RATES_HZ[0], samples),
    }
}

/// The first samples of a tossed object; the cube's shape stands for all of them.
pub fn object(file: &Path, stamps: &str, samples: usize) -> Asked {
    let shape = "{ kind = \"cuboid\", size_mm = [100, 100, 100] }";
    Asked {
        scene: flight(shape, 0.3, stamps, ""),
        events: csv(file, 1.0 / 30.0, samples),
    }
}

fn csv(file: &Path, interval_s: f64, samples: usize) -> Vec<TakeEvent> {
    let text = fs::read_to_string(file).expect("a file that is there");
    let lines = text.lines().skip(1).take(samples).enumerate();
    lines
        .map(|(index, line)| {
            let cells: Vec<f64> = line.split(',').filter_map(|c| c.parse().ok()).collect();
            TakeEvent::Pose {
                track: TrackIndex(0),
                stream: 0,
                sample: PoseSample::new(
                    Stamp((index as f64 * interval_s * 1e9).round() as i64),
                    Vector3::new(cells[1], cells[2], cells[3]),
                    [cells[5], cells[6], cells[7], cells[4]],
                ),
            }
        })
        .collect()
}

/// A camera carried by hand, in the scene that comes with it.
pub fn carried(file: &Path) -> Asked {
    let recording = Recording::open(file).expect("a recording");
    let toml = recording.scene_toml().expect("it carries its scene");
    let scene = scene_from_toml(std::str::from_utf8(toml).expect("text")).expect("valid");
    let events = recording.take(&scene).expect("poses").events;
    Asked { scene, events }
}

/// Two seconds each of a vehicle that hovers, from that second on.
pub fn hovering(file: &Path, stamps: &str, first_s: f64) -> Vec<Asked> {
    let recording = Recording::open(file).expect("a recording");
    let shape = "{ kind = \"cuboid\", size_mm = [600, 600, 150] }";
    let mut scene = flight(shape, 0.6, stamps, "");
    scene.tracks[TrackIndex(0)].topic = "/cub1/pose".into();
    let Ok(take) = recording.take(&scene) else {
        eprintln!("skipped: {} has no poses as expected", file.display());
        return Vec::new();
    };
    let stamp = |event: &TakeEvent| match event {
        TakeEvent::Pose { sample, .. } => sample.stamp,
        TakeEvent::Mark(Mark { stamp, .. }) => *stamp,
    };
    let Some(first) = take.events.iter().map(stamp).min() else {
        return Vec::new();
    };
    let seconds = |event: &TakeEvent| stamp(event).seconds_since(first);
    let last_s = take.events.iter().map(seconds).fold(0.0, f64::max);
    let windows = (0..).map(|window| first_s + f64::from(window) * STRIDE_S);
    let windows = windows.take_while(|begin_s| begin_s + WINDOW_S <= last_s);
    windows
        .map(|begin_s| {
            let is_in =
                |event: &&TakeEvent| (begin_s..begin_s + WINDOW_S).contains(&seconds(event));
            Asked {
                scene: scene.clone(),
                events: take.events.iter().filter(is_in).cloned().collect(),
            }
        })
        .collect()
}
