//! The tip of a body, and the plane that it touches.

use std::path::Path;

use anyhow::{Context, bail};
use nalgebra::{Isometry3, Vector3};

use super::quantity::{begun, measured, plain, rounded, say_spread, triple};
use super::streams::{Read, read};
use super::{CalibrateChoice, TouchingPoint, calibration};
use crate::calibrate;
use crate::config::{BodyValues, Calibration, SurfaceValue, TrackValues, TrackerValue};
use crate::motion::{Scene, Track};

/// Share of samples that may be too far off.
const OUTLIERS: f64 = 0.1;

/// A tip that strays by more was not held \[m\].
const STRAYS_M: f64 = 5e-3;

/// Names of what a pivot finds, by which `plane --tip` reads it.
const TIP: &str = "tip in the tracker's axes";

/// The calibration, and what was lost of the recording.
pub(super) type Found = (Calibration, Vec<String>);

/// A place of a feature, in link axes.
fn feature_m(scene: &Scene, track: &Track, name: &str) -> anyhow::Result<Vector3<f64>> {
    let link = &scene.links[track.link];
    let feature = link.features.iter().find(|feature| feature.name == name);
    let Some(feature) = feature else {
        let names: Vec<&str> = link.features.iter().map(|of| of.name.as_str()).collect();
        bail!(
            "body {:?} has no feature {name:?}, expected one of {}",
            link.name,
            names.join(", ")
        );
    };
    Ok(feature.geometry.place_m())
}

/// The keys of a scene for a tracker.
pub(super) fn mounted(scene: &Scene, track: &Track, tracker: TrackerValue) -> BodyValues {
    let body = &scene.links[track.link].name;
    let mut values = BodyValues {
        name: body.clone(),
        ..BodyValues::default()
    };
    match track
        .name
        .strip_prefix(body)
        .and_then(|rest| rest.strip_prefix('.'))
    {
        Some(own) => values.track.push(TrackValues {
            name: own.to_owned(),
            tracker,
        }),
        None => values.tracker = Some(tracker),
    }
    values
}

pub(super) fn pivot(
    input: &Path,
    choice: &CalibrateChoice,
    feature: Option<&str>,
) -> anyhow::Result<Found> {
    let read = read(input, choice, 1, 1)?;
    let fit = calibrate::pivot(&read.streams[0]).with_context(|| read.file.clone())?;
    let mut found = begun("pivot", std::slice::from_ref(&read));
    found
        .quantity
        .push(measured(TIP, "mm", &fit.tip_m.times(1e3)));
    found.quantity.push(measured(
        "place of the tip, world",
        "mm",
        &fit.place_m.times(1e3),
    ));
    found
        .quantity
        .push(plain("residual, rms", "mm", &[fit.residual_m * 1e3]));
    found.quantity.push(plain(
        "least swing, rms",
        "deg",
        &[fit.swing_rad.to_degrees()],
    ));
    let share = fit.outliers as f64 / read.streams[0].readings.len() as f64;
    found.quantity.push(plain(
        "samples too far off to count",
        "",
        &[fit.outliers as f64],
    ));
    say_spread(&mut found, &fit.spread);

    if fit.residual_m > STRAYS_M {
        found.against.push(format!(
            "the tip strays by {:.1} mm: it was not held in one place",
            fit.residual_m * 1e3
        ));
    }
    if share > OUTLIERS {
        found.against.push(format!(
            "the tip is elsewhere in {:.0} % of the samples: it slipped; use --from and --to, or hold it in a dimple",
            share * 100.0
        ));
    }
    match (read.track(), feature) {
        (Some((scene, track)), Some(feature)) => {
            let at_m = feature_m(scene, track, feature).with_context(|| read.file.clone())?;
            // The feature is where the tip is: p_link = R p_tracker + d. The key is of the frame in which the
            // scene gives the body.
            let tip_m = Vector3::from_column_slice(&fit.tip_m.value);
            let turn = track.link_from_tracker.rotation;
            let off_mm = (at_m - turn * tip_m - track.point_m()).norm() * 1e3;
            let link_from_tracker = Isometry3::from_parts((at_m - turn * tip_m).into(), turn);
            let given_from_tracker = scene.links[track.link].given_from(&link_from_tracker);
            let position_m = given_from_tracker.translation.vector;
            found.notes.push(format!(
                "tracker.position_mm as it follows from where {feature} is in the scene and how the tracker is turned \
                 there; {off_mm:.2} mm from what the scene has"
            ));
            let tracker = TrackerValue {
                position_mm: Some(triple(position_m.iter().map(|x| x * 1e3))),
                orientation_wxyz: None,
            };
            found.scene.body.push(mounted(scene, track, tracker));
        }
        (None, Some(feature)) => bail!(
            "{}: --feature {feature} is of a scene, expected --scene FILE or a scene in the recording, and --body NAME where it has several",
            read.file
        ),
        (_, None) => found.notes.push(
            "with --scene FILE and --feature NAME, which the tip is there, it becomes tracker.position_mm".to_owned(),
        ),
    }
    Ok((found, read.lost))
}

pub(super) fn plane(
    input: &Path,
    choice: &CalibrateChoice,
    point: &TouchingPoint,
    at_s: &[f64],
    window_s: f64,
    surface: &str,
) -> anyhow::Result<Found> {
    let read = read(input, choice, 1, 1)?;
    let (point_m, sd_m) = touching(&read, point)?;
    let times_s = if at_s.is_empty() { &read.marks_s } else { at_s };
    if times_s.is_empty() {
        bail!(
            "{}: no touches, expected marks in the recording or --at S,S,S",
            read.file
        );
    }
    let touches: Vec<calibrate::Touch> = times_s
        .iter()
        .map(|time_s| calibrate::touch(&read.streams[0], *time_s, &point_m, window_s))
        .collect::<Result<_, _>>()
        .with_context(|| read.file.clone())?;
    let gravity = read.track().map(|(scene, _)| scene.gravity_m_s2);
    let up = gravity
        .and_then(|g| (-g).try_normalize(1e-6))
        .unwrap_or_else(Vector3::z);
    let fit = calibrate::plane(&touches, &sd_m, &up).with_context(|| read.file.clone())?;
    let mut found = begun("plane", std::slice::from_ref(&read));
    let tilt = fit.tilt_rad.times(1_f64.to_degrees());
    found
        .quantity
        .push(plain("normal, world", "", fit.normal.as_slice()));
    found.quantity.push(measured(
        "lean of the normal along two axes in the plane",
        "deg",
        &tilt,
    ));
    let middle_mm = fit.point_m * 1e3;
    found.quantity.push(plain(
        "middle of the touches, world",
        "mm",
        middle_mm.as_slice(),
    ));
    found.quantity.push(measured(
        "height of that point along the normal",
        "mm",
        &fit.height_m.times(1e3),
    ));
    let from_up_deg = fit.normal.dot(&up).clamp(-1.0, 1.0).acos().to_degrees();
    found
        .quantity
        .push(plain("angle of the normal to up", "deg", &[from_up_deg]));
    let distances: Vec<f64> = fit.distances_m.iter().map(|d| d * 1e3).collect();
    found
        .quantity
        .push(plain("distances of the touches", "mm", &distances));
    match fit.residual_m {
        Some(residual_m) => {
            found.quantity.push(plain("residual, rms", "mm", &[residual_m * 1e3]));
        }
        None => found.notes.push("three touches always lie in a plane: no residual and no interval, four and more have them".to_owned()),
    }
    for at in &fit.outliers {
        found.against.push(format!(
            "the touch at {:.3} s is {:.1} mm off the plane of the others and was left out",
            touches[*at].time_s, distances[*at]
        ));
    }
    found.scene.surface.push(SurfaceValue {
        name: surface.to_owned(),
        point_mm: triple(middle_mm.iter().copied()),
        normal: fit.normal.map(|x| (x * 1e9).round() / 1e9).into(),
    });
    Ok((found, read.lost))
}

/// The point that touches in the tracker's axes, and its standard deviation \[m\].
fn touching(read: &Read, point: &TouchingPoint) -> anyhow::Result<(Vector3<f64>, Vector3<f64>)> {
    match point {
        TouchingPoint::InTracker(mm) => Ok((Vector3::from(*mm) / 1e3, Vector3::zeros())),
        TouchingPoint::Pivot(path) => {
            let file = calibration(path)?;
            let tip = file
                .quantity
                .iter()
                .find(|of| of.name == TIP && of.unit == "mm");
            let numbers = tip.filter(|of| {
                [&of.value, &of.lower, &of.upper]
                    .iter()
                    .all(|n| n.len() == 3)
            });
            let Some(tip) = numbers else {
                bail!(
                    "{}: has no tip, expected what `calibrate pivot` wrote",
                    path.display()
                );
            };
            // An interval of two standard deviations, nearly, with the degrees of freedom of blocks.
            let sd_m = |axis: usize| rounded(tip.upper[axis] - tip.lower[axis]) / 4e3;
            Ok((
                Vector3::from_column_slice(&tip.value) / 1e3,
                Vector3::from_fn(|axis, _| sd_m(axis)),
            ))
        }
        TouchingPoint::Feature(name) => {
            let Some((scene, track)) = read.track() else {
                bail!(
                    "{}: --feature {name} is of a scene, expected --scene FILE or a scene in the recording",
                    read.file
                );
            };
            let at_m = feature_m(scene, track, name).with_context(|| read.file.clone())?;
            let tracker_from_link = track.link_from_tracker.inverse();
            Ok((
                (tracker_from_link * nalgebra::Point3::from(at_m)).coords,
                Vector3::zeros(),
            ))
        }
    }
}
