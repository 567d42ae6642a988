//! Real tosses of a cube: the first flight, with free gravity, against the fits that came with
//! the data. Skipped, saying so, where the data are not there.

#[path = "support/skip.rs"]
mod skip;

use std::fs;
use std::path::{Path, PathBuf};

use enact::config::scene_from_toml;
use enact::motion::{Mark, PoseSample, Scene, Stamp, TakeEvent, Verdict};
use enact::pipeline::{Outcome, Pipeline};
use nalgebra::Vector3;
use skip::skip;

/// One line of the manifest: a toss that somebody else has fitted.
struct Toss {
    number: usize,
    samples: usize,
    gravity_m_s2: f64,
    position_rms_mm: f64,
    orientation_rms_deg: f64,
}

fn folder() -> Option<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/real/tosses");
    if folder.is_dir() {
        return Some(folder);
    }
    let name = "first_flights_agree_with_the_fits_that_came_with_them";
    skip(name, &format!("no real tosses at {}", folder.display()));
    None
}

fn scene() -> Scene {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("config/cube_toss.toml");
    scene_from_toml(&fs::read_to_string(file).unwrap()).unwrap()
}

fn manifest(folder: &Path) -> Vec<Toss> {
    let text = fs::read_to_string(folder.join("manifest.csv")).unwrap();
    let mut tosses = Vec::new();
    for line in text.lines().skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        // Tosses without a first flight of their own have no fit.
        let (Ok(number), Ok(samples), Ok(gravity_m_s2)) =
            (cells[0].parse(), cells[4].parse(), cells[5].parse())
        else {
            continue;
        };
        tosses.push(Toss {
            number,
            samples,
            gravity_m_s2,
            position_rms_mm: cells[6].parse().unwrap(),
            orientation_rms_deg: cells[7].parse().unwrap(),
        });
    }
    tosses
}

/// The first samples of a toss, and the mark of the impact at the last of them.
fn take(folder: &Path, toss: &Toss) -> Vec<TakeEvent> {
    let file = folder.join(format!("toss_{:03}.csv", toss.number));
    let text = fs::read_to_string(file).unwrap();
    let mut events = Vec::new();
    let mut last = Stamp(0);
    for line in text.lines().skip(1).take(toss.samples) {
        let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
        let [t, x, y, z, qw, qx, qy, qz] = cells.try_into().unwrap();
        last = Stamp((t * 1e9_f64).round() as i64);
        events.push(TakeEvent::Pose {
            body: 0,
            stream: 0,
            sample: PoseSample {
                stamp: last,
                position_m: Vector3::new(x, y, z),
                quaternion_xyzw: [qx, qy, qz, qw],
            },
        });
    }
    events.push(TakeEvent::Mark(Mark {
        stamp: last,
        event: Some("impact".into()),
    }));
    events
}

fn estimated(scene: &Scene, take: Vec<TakeEvent>) -> Outcome {
    Pipeline::of(scene.clone(), take).finish(&mut ()).unwrap()
}

#[test]
fn first_flights_agree_with_the_fits_that_came_with_them() {
    let Some(folder) = folder() else { return };
    let scene = scene();
    let tosses = manifest(&folder);
    assert!(tosses.len() > 90, "{}", tosses.len());
    for toss in &tosses {
        let outcome = estimated(&scene, take(&folder, toss));
        let estimate = &outcome.estimate;
        assert_eq!(
            estimate.verdict,
            Verdict::Physical,
            "{}: {}",
            toss.number,
            estimate.reason
        );
        // The stamps of the data are rounded to a microsecond.
        let gravity_m_s2 = estimate.gravity_m_s2.z;
        assert!(
            (gravity_m_s2 - toss.gravity_m_s2).abs() < 1e-3,
            "{}: {gravity_m_s2} against {}",
            toss.number,
            toss.gravity_m_s2
        );
        // Theirs are per axis, with the degrees of freedom of a parabola and of a constant
        // spin taken off; the manifest has four digits.
        let samples = toss.samples as f64;
        let agree = |rms: f64, per_axis: f64, unknowns: f64| {
            let expected = per_axis * (3.0 * (1.0 - unknowns / samples)).sqrt();
            assert!(
                (rms - expected).abs() < 0.01 * expected + 1e-4,
                "{}: {rms} against {expected}",
                toss.number
            );
        };
        let residual = &estimate.residuals[0];
        agree(residual.position_rms_m * 1e3, toss.position_rms_mm, 3.0);
        agree(
            residual.orientation_rms_rad.to_degrees(),
            toss.orientation_rms_deg,
            2.0,
        );
    }
}
