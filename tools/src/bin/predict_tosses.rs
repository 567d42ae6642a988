//! Where real tosses of a cube come to rest, predicted from their first flight: materials are fitted to one half of
//! the tosses, the other half is predicted. Writes what MuJoCo needs to do the same (`tools/peers/tosses.py`).
//!
//! A toss counts where it moved by less than 1 mm in the last five samples. Its error is the horizontal distance of the
//! cube's centre from where it rests. What is minimised is the mean square root of that distance: tosses that land on another
//! face do not outweigh the rest.
//!
//! Then what the simulation has wrong is stated as a scatter of the material from toss to toss: the least with which nine in ten
//! tosses of the half that is fitted rest within the distance that `predict` says. The other half tells whether that holds.

use std::path::PathBuf;

use anyhow::{Context, Result};
use clap::Parser;
use enact::calibrate::{self, Flight, Reading, Stream};
use enact::config::scene_from_toml;
use enact::math::Pose;
use enact::motion::{Estimate, LinkIndex, LinkSpread, Scene, TakeEvent};
use enact::pipeline::Pipeline;
use enact::settle::{FRICTION, RESTITUTION, settle};
use enact::verify::up_name;
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
    /// What was seen of the first flight.
    take: Vec<TakeEvent>,
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
                take: toss.first_flight_take(RATES_HZ[0]),
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
    for line in spreads(&train, &held_out, &scene, fitted) {
        println!("{line}");
        written.push(line);
    }
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

/// Standard deviations of restitution and friction from toss to toss that are tried.
const RESTITUTION_SDS: [f64; 3] = [0.0, 0.05, 0.1];
const FRICTION_SDS: [f64; 6] = [0.0, 0.01, 0.0125, 0.015, 0.02, 0.03];

/// How often tosses rest within what `predict` says: with the material taken as exact, and with the scatter of the least distance
/// that covers nine in ten of the half that it is fitted to.
fn spreads(train: &[&Case], held_out: &[&Case], scene: &Scene, law: [f64; 2]) -> Vec<Value> {
    let mut lines = Vec::new();
    let mut best: Option<(f64, [f64; 2])> = None;
    for restitution_sd in RESTITUTION_SDS {
        for friction_sd in FRICTION_SDS {
            let sds = [restitution_sd, friction_sd];
            let line = spread_line("train", train, scene, law, sds);
            let [covered, mean_mm] = ["covered", "mean_radius_mm"].map(|key| line[key].as_f64());
            let is_less = |of: f64| best.is_none_or(|(least, _)| of < least);
            if covered.is_some_and(|of| of >= 0.9) && mean_mm.is_some_and(is_less) {
                best = mean_mm.map(|of| (of, sds));
            }
            lines.push(line);
        }
    }
    lines.push(spread_line("held out", held_out, scene, law, [0.0; 2]));
    if let Some((_, sds)) = best {
        lines.push(spread_line("held out", held_out, scene, law, sds));
    }
    lines
}

fn spread_line(half: &str, cases: &[&Case], scene: &Scene, law: [f64; 2], sds: [f64; 2]) -> Value {
    let mut scene = scene.clone();
    for of in &mut scene.contact_laws {
        [of.restitution, of.friction] = law;
        [of.restitution_sd, of.friction_sd] = sds;
    }
    let began = std::time::Instant::now();
    let told: Vec<(&Case, Option<(LinkSpread, Pose)>)> = cases
        .par_iter()
        .map(|case| {
            let pipeline = Pipeline::of(scene.clone(), case.take.iter().cloned());
            let outcome = pipeline
                .predicting(0, LIMIT_S)
                .and_then(|pipeline| pipeline.finish(&mut ()).ok());
            let settled = outcome.and_then(|outcome| outcome.settled);
            let found = settled.and_then(|settled| {
                let own = settled.links[LinkIndex(0)].poses.last().copied()?;
                Some((settled.spread?.links.pop()?, own))
            });
            (*case, found)
        })
        .collect();
    let took_s = began.elapsed().as_secs_f64() / cases.len() as f64;
    let found = || {
        told.iter()
            .filter_map(|(case, of)| Some((*case, of.as_ref()?)))
    };
    let share = |is_it: &dyn Fn(&Case, &LinkSpread, &Pose) -> bool| {
        let right = found().filter(|(case, (of, own))| is_it(case, of, own));
        right.count() as f64 / cases.len() as f64
    };
    let is_like = |a: &Pose, b: &Pose| a.rotation.angle_to(&b.rotation).to_degrees() < 20.0;
    let off_mm =
        |case: &Case, at: &Vector3<f64>| 1e3 * (case.rest.translation.vector - at).xy().norm();
    let mut radii_mm: Vec<f64> = found().map(|(_, (of, _))| 1e3 * of.radius_m).collect();
    radii_mm.sort_by(f64::total_cmp);
    let mut medians_mm: Vec<f64> = found()
        .map(|(case, (of, _))| off_mm(case, &of.median_m))
        .collect();
    medians_mm.sort_by(f64::total_cmp);
    let up = |pose: &Pose| up_name(&scene.links[LinkIndex(0)], &pose.rotation, &Vector3::z());
    // How often the likeliest face is up where it is that in so many of the draws.
    let of_certain = |least: f64, most: f64| {
        let sure: Vec<bool> = found()
            .filter(|(_, (of, _))| (least..most).contains(&of.up[0].1))
            .map(|(case, (of, _))| of.up[0].0 == up(&case.rest))
            .collect();
        json!([sure.len(), sure.iter().filter(|right| **right).count()])
    };
    json!({ "half": half, "restitution_sd": sds[0], "friction_sd": sds[1], "tosses": cases.len(), "told": found().count(),
        "covered": share(&|case, of, _| off_mm(case, &of.median_m) <= 1e3 * of.radius_m),
        "mean_radius_mm": radii_mm.iter().sum::<f64>() / radii_mm.len().max(1) as f64,
        "median_radius_mm": radii_mm.get(radii_mm.len() / 2),
        "median_off_mm": medians_mm.get(medians_mm.len() / 2),
        "own_orientation": share(&|case, _, own| is_like(own, &case.rest)),
        "likely_orientation": share(&|case, of, _| is_like(&of.likely, &case.rest)),
        "own_face": share(&|case, _, own| up(own) == up(&case.rest)),
        "likely_face": share(&|case, of, _| of.up[0].0 == up(&case.rest)),
        "face_of_share_95": of_certain(0.95, 1.1), "face_of_share_60": of_certain(0.6, 0.95), "face_of_less": of_certain(0.0, 0.6),
        "seconds_each": took_s })
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
