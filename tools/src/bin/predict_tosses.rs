//! Where real tosses of a cube come to rest, predicted from their first flight: materials are fitted to one half of
//! the tosses, the other half is predicted. Writes what MuJoCo needs to do the same (`tools/peers/tosses.py`).
//!
//! A toss counts where it moved by less than 1 mm in the last five samples. Its error is the horizontal distance of the
//! cube's centre from where it rests. What is minimised is the mean square root of that distance: tosses that land on another
//! face do not outweigh the rest.

use std::path::PathBuf;

use anyhow::{Context, Result};
use clap::Parser;
use enact::calibrate::{self, Flight, Reading, Stream};
use enact::config::scene_from_toml;
use enact::math::Pose;
use enact::motion::{Estimate, LinkIndex, Scene, TakeEvent};
use enact::settle::{FRICTION, RESTITUTION, settle};
use enact_tools::tosses::{RATES_HZ, Toss, all, scene_toml};
use nalgebra::Vector3;
use rayon::prelude::*;
use serde_json::{Value, json};

/// A toss that moved by less in its last samples is at rest \[m\].
const STILL_M: f64 = 0.001;
/// How long is simulated at most \[s\].
const LIMIT_S: f64 = 2.0;

#[derive(Parser)]
struct Arguments {
    /// Where states, rests and predictions go, JSON
    #[arg(short, long)]
    output: PathBuf,
    /// Only every so many-th toss
    #[arg(long, default_value_t = 1)]
    every: usize,
    /// Restitution and friction that are not fitted, to be compared: `0.265,0.166`
    #[arg(long, value_delimiter = ',')]
    given: Vec<f64>,
}

/// A toss with the estimate of its first flight.
struct Case {
    number: usize,
    estimate: Estimate,
    rest: Pose,
    is_held_out: bool,
}

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    let (_, tosses) = all()?.context("no real recordings: set ENACT_REAL")?;
    let tosses: Vec<Toss> = tosses
        .into_iter()
        .step_by(arguments.every)
        .filter(is_at_rest)
        .collect();
    let train = || tosses.iter().step_by(2);
    let gravity = gravity(train())?;
    let mut heights: Vec<f64> = train()
        .filter_map(|toss| Some(toss.poses.last()?.0.z))
        .collect();
    heights.sort_by(f64::total_cmp);
    let side_mm = 2e3 * heights[heights.len() / 2];
    eprintln!(
        "gravity {gravity:.3?} m/s², side {side_mm:.2} mm, {} tosses",
        tosses.len()
    );
    let scene = scene(&gravity, side_mm)?;
    let cases: Vec<Case> = tosses
        .par_iter()
        .enumerate()
        .filter_map(|(at, toss)| {
            let outcome = toss.first_flight(&scene, RATES_HZ[0]).ok()?;
            let (x, q) = *toss.poses.last()?;
            Some(Case {
                number: toss.number,
                estimate: outcome.estimate,
                rest: Pose::from_parts(x.into(), q),
                is_held_out: at % 2 == 1,
            })
        })
        .collect();

    let train: Vec<&Case> = cases.iter().filter(|case| !case.is_held_out).collect();
    let held_out: Vec<&Case> = cases.iter().filter(|case| case.is_held_out).collect();
    let cost = |law: [f64; 2]| {
        let errors = errors(&train, &scene, law);
        errors.iter().map(|(m, _)| m.sqrt()).sum::<f64>() / errors.len() as f64
    };
    let fitted = fitted(cost);
    let mut rows = vec![("fitted to the other half".to_owned(), fitted)];
    if let [restitution, friction] = arguments.given[..] {
        rows.push(("given".to_owned(), [restitution, friction]));
    }
    rows.push(("without a material".to_owned(), [RESTITUTION, FRICTION]));
    let mut written = Vec::new();
    for (name, law) in rows {
        for (half, cases) in [("train", &train), ("held out", &held_out)] {
            let errors = errors(cases, &scene, law);
            let line = summary(&name, half, law, &errors);
            println!("{line}");
            written.push(line);
        }
    }
    let tosses: Vec<Value> = cases.iter().map(case).collect();
    let all = json!({ "gravity_m_s2": gravity.as_slice(), "side_m": side_mm / 1e3, "mass_kg": 0.37, "moment_kg_m2": 8.1e-4,
        "limit_s": LIMIT_S, "predictions": written, "tosses": tosses });
    std::fs::write(&arguments.output, serde_json::to_string_pretty(&all)?)?;
    Ok(())
}

fn is_at_rest(toss: &Toss) -> bool {
    let last = &toss.poses[toss.poses.len().saturating_sub(6)..];
    last.iter().all(|(x, _)| (x - last[0].0).norm() < STILL_M) && toss.flight_is_given
}

fn scene(gravity: &Vector3<f64>, side_mm: f64) -> Result<Scene> {
    // The flight's scene with gravity fixed, lengths as the cameras have them, and a material.
    let (text, _) = scene_toml()
        .split_once("[[free]]")
        .context("free gravity")?;
    let half = side_mm / 2.0;
    let text = text
        .replace("104.8", &format!("{side_mm}"))
        .replace("52.4", &format!("{half}"))
        .replace(
            "mass_kg = 0.37",
            "mass_kg = 0.37\nrestitution = 0.2\nfriction = 0.2",
        );
    let [x, y, z] = [gravity.x, gravity.y, gravity.z];
    Ok(scene_from_toml(&format!(
        "gravity_m_s2 = [{x}, {y}, {z}]\n{text}"
    ))?)
}

/// Gravity by the first flights.
fn gravity<'a>(tosses: impl Iterator<Item = &'a Toss>) -> Result<Vector3<f64>> {
    let flights: Vec<Flight> = tosses
        .map(|toss| {
            let samples: Vec<_> = toss
                .first_flight_take(RATES_HZ[0])
                .into_iter()
                .filter_map(|event| match event {
                    TakeEvent::Pose { sample, .. } => Some(sample),
                    TakeEvent::Mark(_) => None,
                })
                .collect();
            let readings: Vec<Reading> = Stream::of(&samples, None, 4)?.readings;
            Ok(Flight { readings })
        })
        .collect::<Result<_, calibrate::CalibrateError>>()?;
    let fit = calibrate::gravity(&flights, Some(&Vector3::zeros()))?;
    eprintln!("gravity {:?} ± {:?}", fit.gravity.value, fit.gravity.half);
    Ok(Vector3::from_column_slice(&fit.gravity.value))
}

/// Horizontal distance \[m\] and angle \[rad\] from where each rests.
fn errors(cases: &[&Case], scene: &Scene, law: [f64; 2]) -> Vec<(f64, f64)> {
    let mut scene = scene.clone();
    for of in &mut scene.contact_laws {
        [of.restitution, of.friction] = law;
    }
    let errors = cases.par_iter().map(|case| {
        let settled = settle(&scene, &case.estimate, LIMIT_S);
        let last = settled.and_then(|settled| settled.links[LinkIndex(0)].poses.last().copied());
        last.map_or((1.0, std::f64::consts::PI), |last| {
            let off = last.translation.vector - case.rest.translation.vector;
            (off.xy().norm(), last.rotation.angle_to(&case.rest.rotation))
        })
    });
    errors.collect()
}

/// The least of a grid, and of a finer one about it.
fn fitted(cost: impl Fn([f64; 2]) -> f64) -> [f64; 2] {
    let grid = |around: [f64; 2], steps: [f64; 2], counts: [i32; 2]| {
        let mut best = (f64::INFINITY, around);
        for a in -counts[0]..=counts[0] {
            for b in -counts[1]..=counts[1] {
                let law = [
                    (around[0] + steps[0] * f64::from(a)).clamp(0.0, 1.0),
                    (around[1] + steps[1] * f64::from(b)).max(0.01),
                ];
                let of = cost(law);
                if of < best.0 {
                    best = (of, law);
                }
            }
        }
        eprintln!(
            "cost {:.4}, restitution and friction {:.3?}",
            best.0, best.1
        );
        best.1
    };
    let coarse = grid([0.2, 0.2], [0.1, 0.01], [2, 4]);
    grid(coarse, [0.05, 0.005], [1, 2])
}

fn summary(name: &str, half: &str, law: [f64; 2], errors: &[(f64, f64)]) -> Value {
    let mut sorted: Vec<f64> = errors.iter().map(|(m, _)| m * 1e3).collect();
    sorted.sort_by(f64::total_cmp);
    let at = |share: f64| sorted[((sorted.len() - 1) as f64 * share).round() as usize];
    let near = errors
        .iter()
        .filter(|(_, angle)| angle.to_degrees() < 20.0)
        .count();
    json!({ "name": name, "half": half, "restitution": law[0], "friction": law[1], "tosses": errors.len(),
        "median_mm": at(0.5), "quartiles_mm": [at(0.25), at(0.75)], "mean_mm": sorted.iter().sum::<f64>() / sorted.len() as f64,
        "orientation_within_20_deg": near as f64 / errors.len() as f64 })
}

fn case(case: &Case) -> Value {
    let arc = case.estimate.arcs.last().expect("a flight");
    let pose = |pose: &Pose| {
        let q = pose.rotation.quaternion();
        json!({ "position_m": pose.translation.vector.as_slice(), "wxyz": [q.w, q.i, q.j, q.k] })
    };
    // The state at the epoch; the flight goes on to its end.
    json!({ "number": case.number, "held_out": case.is_held_out, "state": pose(&arc.state.world_from_body()),
        "velocity_m_s": arc.state.velocity_m_s.as_slice(), "spin_rad_s": arc.state.angular_velocity_rad_s.as_slice(),
        "until_end_s": arc.end_s - arc.epoch_s, "rest": pose(&case.rest) })
}
