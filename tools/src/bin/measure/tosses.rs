//! Real tosses of a cube: what its first flight says of gravity and of the tracker.
//!
//! The data are not part of this repository (DAIRLab's contact-nets, BSD-3); without them this
//! study says so and does nothing. The flight is as long as the manifest that comes with them
//! says; where it does not, until the lowest corner is within 3 mm of the table.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use enact::config::scene_from_toml;
use enact::motion::{Mark, PoseSample, Scene, Stamp, TakeEvent, Verdict};
use enact::physics::contact;
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use crate::results::Options;
use crate::statistics::{mean, median, quantile, robust_sd};
use crate::table::{Table, number};
use enact_tools::case::estimated;

/// As the data are numbered, and as the cameras really ran \[Hz\].
pub const RATES_HZ: [f64; 2] = [148.308, 148.0];
/// A corner nearer to the table than this may have touched it \[m\].
const NEAR_TABLE_M: f64 = 0.003;

/// One toss.
pub struct Toss {
    /// In the manifest.
    pub number: usize,
    /// In order; the cube's centre.
    pub poses: Vec<(Vector3<f64>, UnitQuaternion<f64>)>,
    /// Samples of the first flight.
    pub flight: usize,
    flight_is_given: bool,
}

/// What became of a toss at a rate.
pub struct Flight {
    /// In the manifest.
    pub number: usize,
    rate_hz: f64,
    samples: usize,
    flight_is_given: bool,
    /// What it says, or why nothing.
    pub result: Result<Fit, String>,
}

/// What a flight says.
pub struct Fit {
    /// All three free.
    pub gravity_m_s2: Vector3<f64>,
    /// Reported standard deviation of the vertical part.
    pub sd_m_s2: Option<f64>,
    /// Per axis, the degrees of freedom of a parabola or a constant spin taken off.
    pub position_mm: f64,
    /// The same of the orientation.
    pub orientation_deg: f64,
    /// Of the whole displacement and angle.
    position_total_mm: f64,
    orientation_total_deg: f64,
}

/// Runs it.
pub fn run(options: &Options) -> Result<()> {
    let Some(folder) = folder() else {
        return Ok(());
    };
    let scene = scene_from_toml(&scene_toml()?)?;
    let tosses = read(&folder, &scene)?;
    let flights: Vec<Flight> = RATES_HZ
        .iter()
        .flat_map(|rate_hz| tosses.iter().map(|toss| flight(&scene, toss, *rate_hz)))
        .collect();
    options.show(table(&flights));
    options.show(failures(&flights));
    let header = "toss,rate_hz,samples,flight_is_given,gx_m_s2,gy_m_s2,gz_m_s2,gz_sd_m_s2,\
                  position_mm_per_axis,orientation_deg_per_axis,position_mm,orientation_deg,failed";
    options.write_csv(
        "tosses",
        header,
        &flights.iter().map(line).collect::<Vec<String>>(),
    )
}

/// Where the data are, if they are there: in `tosses` of the folder that the environment's
/// `ENACT_REAL` names, or of `../shared/real`.
pub fn folder() -> Option<PathBuf> {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/real");
    let real = std::env::var_os("ENACT_REAL").map_or(beside, PathBuf::from);
    let folder = real.join("tosses");
    if folder.is_dir() {
        return Some(folder);
    }
    eprintln!("skipped: no real tosses at {}", folder.display());
    None
}

/// The scene of a first flight.
pub fn scene_toml() -> Result<String> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../config/cube_toss.toml");
    Ok(fs::read_to_string(file)?)
}

/// All tosses of the manifest.
pub fn read(folder: &Path, scene: &Scene) -> Result<Vec<Toss>> {
    let manifest = fs::read_to_string(folder.join("manifest.csv"))?;
    manifest
        .lines()
        .skip(1)
        .map(|line| {
            let cells: Vec<&str> = line.split(',').collect();
            let number: usize = cells[0].parse()?;
            let poses = poses(&folder.join(format!("toss_{number:03}.csv")))?;
            let given = cells[4].parse().ok();
            let flight = given.unwrap_or_else(|| until_near_table(scene, &poses));
            Ok(Toss {
                number,
                poses,
                flight,
                flight_is_given: given.is_some(),
            })
        })
        .collect()
}

fn poses(file: &PathBuf) -> Result<Vec<(Vector3<f64>, UnitQuaternion<f64>)>> {
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

fn until_near_table(scene: &Scene, poses: &[(Vector3<f64>, UnitQuaternion<f64>)]) -> usize {
    let features = scene.bodies[0].features.iter();
    let corners: Vec<Vector3<f64>> = features
        .filter_map(|feature| match feature.geometry {
            contact::Feature::Point { point_m, .. } => Some(point_m),
            _ => None,
        })
        .collect();
    let is_clear = |(x, q): &&(Vector3<f64>, UnitQuaternion<f64>)| {
        corners
            .iter()
            .all(|corner| (x + q * *corner).z > NEAR_TABLE_M)
    };
    poses.iter().take_while(is_clear).count()
}

/// The first flight alone, gravity free.
pub fn flight(scene: &Scene, toss: &Toss, rate_hz: f64) -> Flight {
    Flight {
        number: toss.number,
        rate_hz,
        samples: toss.flight,
        flight_is_given: toss.flight_is_given,
        result: fit(scene, toss, rate_hz),
    }
}

/// The first samples of a toss, and marks at places between them, counted in samples.
pub fn take(toss: &Toss, rate_hz: f64, samples: usize, marks: &[(f64, &str)]) -> Vec<TakeEvent> {
    let stamp = |place: f64| Stamp((place / rate_hz * 1e9).round() as i64);
    let poses = toss.poses.iter().take(samples).enumerate();
    let poses = poses.map(|(index, (position_m, q))| TakeEvent::Pose {
        body: 0,
        stream: 0,
        sample: PoseSample {
            stamp: stamp(index as f64),
            position_m: *position_m,
            quaternion_xyzw: [q.i, q.j, q.k, q.w],
        },
    });
    let marks = marks.iter().map(|(place, event)| {
        TakeEvent::Mark(Mark {
            stamp: stamp(place.max(0.0)),
            event: Some((*event).into()),
        })
    });
    poses.chain(marks).collect()
}

fn fit(scene: &Scene, toss: &Toss, rate_hz: f64) -> Result<Fit, String> {
    let events = take(
        toss,
        rate_hz,
        toss.flight,
        &[(toss.flight as f64 - 1.0, "impact")],
    );
    let outcome = estimated(scene, &events, &mut ()).map_err(|error| error.to_string())?;
    let estimate = &outcome.estimate;
    if estimate.verdict != Verdict::Physical {
        return Err(format!(
            "{}: {}",
            estimate.verdict.as_str(),
            enact::report::reason_text(&outcome.scene, &estimate.reason)
        ));
    }
    let residual = &estimate.residuals[0];
    let samples = residual.samples as f64;
    let per_axis = |unknowns: f64| (3.0 * (1.0 - unknowns / samples)).sqrt().recip();
    let vertical = estimate.parameters.iter().find(|p| p.name == "gravity.z");
    let (position_mm, orientation_deg) = (
        1e3 * residual.position_rms_m,
        residual.orientation_rms_rad.to_degrees(),
    );
    Ok(Fit {
        gravity_m_s2: estimate.gravity_m_s2,
        sd_m_s2: vertical.and_then(|parameter| parameter.sd),
        position_mm: position_mm * per_axis(3.0),
        orientation_deg: orientation_deg * per_axis(2.0),
        position_total_mm: position_mm,
        orientation_total_deg: orientation_deg,
    })
}

fn table(flights: &[Flight]) -> Table {
    let mut table = Table::new(
        "Real tosses of a cube, first flight, gravity free: median (robust sd over the tosses)",
        &[
            "rate Hz",
            "tosses",
            "estimated",
            "gravity m/s²",
            "its vertical part",
            "median reported sd of that",
            "robust sd of its error over reported sd",
            "tilt from −z deg",
            "mean gravity's tilt deg",
            "residual mm per axis",
            "residual deg per axis",
            "residual mm",
            "residual deg",
        ],
    );
    for rate_hz in RATES_HZ {
        let at_rate: Vec<&Flight> = flights.iter().filter(|f| f.rate_hz == rate_hz).collect();
        let fits: Vec<&Fit> = at_rate
            .iter()
            .filter_map(|f| f.result.as_ref().ok())
            .collect();
        let of = |value: &dyn Fn(&Fit) -> f64, decimals: usize| {
            let values: Vec<f64> = fits.iter().map(|fit| value(fit)).collect();
            format!(
                "{:.decimals$} ({:.decimals$})",
                median(&values),
                robust_sd(&values)
            )
        };
        let tilt_deg = |g: &Vector3<f64>| g.angle(&-Vector3::z()).to_degrees();
        let axis = |axis: usize| {
            mean(
                &fits
                    .iter()
                    .map(|f| f.gravity_m_s2[axis])
                    .collect::<Vec<f64>>(),
            )
        };
        let sds: Vec<f64> = fits.iter().filter_map(|fit| fit.sd_m_s2).collect();
        let verticals: Vec<f64> = fits.iter().map(|fit| fit.gravity_m_s2.z).collect();
        let middle = median(&verticals);
        let normalised = fits
            .iter()
            .filter_map(|fit| Some((fit.gravity_m_s2.z - middle) / fit.sd_m_s2?));
        let normalised: Vec<f64> = normalised.collect();
        table.row([
            rate_hz.to_string(),
            at_rate.len().to_string(),
            fits.len().to_string(),
            of(&|fit| fit.gravity_m_s2.norm(), 3),
            of(&|fit| fit.gravity_m_s2.z, 3),
            format!(
                "{} ({} to {})",
                number(median(&sds)),
                number(quantile(&sds, 0.05)),
                number(quantile(&sds, 0.95))
            ),
            number(robust_sd(&normalised)),
            of(&|fit| tilt_deg(&fit.gravity_m_s2), 2),
            format!("{:.2}", tilt_deg(&Vector3::from_fn(|i, _| axis(i)))),
            of(&|fit| fit.position_mm, 4),
            of(&|fit| fit.orientation_deg, 4),
            of(&|fit| fit.position_total_mm, 4),
            of(&|fit| fit.orientation_total_deg, 4),
        ]);
    }
    table
}

fn failures(flights: &[Flight]) -> Table {
    let mut table = Table::new(
        "Tosses without an estimate, or whose flight the manifest does not give",
        &["toss", "rate Hz", "samples", "what"],
    );
    for flight in flights {
        let what = match &flight.result {
            Err(reason) => reason.clone(),
            Ok(_) if flight.flight_is_given => continue,
            Ok(fit) => format!(
                "flight until 3 mm above the table: gravity {:.3} m/s², {:.4} mm, {:.4}° per axis",
                fit.gravity_m_s2.norm(),
                fit.position_mm,
                fit.orientation_deg
            ),
        };
        let Flight {
            number,
            rate_hz,
            samples,
            ..
        } = flight;
        table.row([
            number.to_string(),
            rate_hz.to_string(),
            samples.to_string(),
            what,
        ]);
    }
    table
}

fn line(flight: &Flight) -> String {
    let Flight {
        number,
        rate_hz,
        samples,
        flight_is_given,
        result,
    } = flight;
    let head = format!("{number},{rate_hz},{samples},{flight_is_given}");
    match result {
        Ok(fit) => {
            let g = &fit.gravity_m_s2;
            let sd = fit.sd_m_s2.map_or(String::new(), |sd| format!("{sd:.4}"));
            format!(
                "{head},{:.5},{:.5},{:.5},{sd},{:.5},{:.5},{:.5},{:.5},",
                g.x,
                g.y,
                g.z,
                fit.position_mm,
                fit.orientation_deg,
                fit.position_total_mm,
                fit.orientation_total_deg
            )
        }
        Err(reason) => format!("{head},,,,,,,,,{:?}", reason.replace('"', "'")),
    }
}
