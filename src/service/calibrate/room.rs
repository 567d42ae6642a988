//! Noise and mount of a tracker, gravity, and clocks.

use std::path::{Path, PathBuf};

use super::CalibrateChoice;
use super::quantity::{begun, measured, plain, rounded, say_spread, triple};
use super::streams::{Read, read};
use super::tip::{Found, mounted};
use crate::calibrate::{self, Flight, LengthUnit, Measured, NoiseAxis, RestFit, Standing, Stream};
use crate::config::{
    BodyValues, CalibratedQuantity, Calibration, FreeValue, TrackerValue, body_axis,
};
use anyhow::{Context, bail};

/// What moves farther than this is not at rest \[m\], \[rad\].
const MOVED_M: f64 = 3e-3;
const TURNED_RAD: f64 = 0.017;

/// Share of repeated poses from which on a tracker is frozen.
const FROZEN: f64 = 0.5;

/// Gravity that is as much as this from an axis is said to be askew \[rad\].
const ASKEW_RAD: f64 = 0.35;

fn read_all(inputs: &[PathBuf], choice: &CalibrateChoice) -> anyhow::Result<Vec<Read>> {
    inputs
        .iter()
        .map(|input| read(input, choice, 1, 1))
        .collect()
}

fn lost_of(reads: Vec<Read>) -> Vec<String> {
    reads.into_iter().flat_map(|read| read.lost).collect()
}

pub(super) fn rest(
    inputs: &[PathBuf],
    choice: &CalibrateChoice,
    stands: &[String],
) -> anyhow::Result<Found> {
    if !stands.is_empty() && stands.len() != inputs.len() {
        bail!(
            "{} times --stands for {} recordings, expected one for each",
            stands.len(),
            inputs.len()
        );
    }
    let reads = read_all(inputs, choice)?;
    let fits: Vec<RestFit> = reads
        .iter()
        .map(|read| calibrate::rest(&read.streams[0]).with_context(|| read.file.clone()))
        .collect::<anyhow::Result<_>>()?;
    let mut found = begun("rest", &reads);
    for (read, fit) in reads.iter().zip(&fits) {
        say_rest(&mut found, &read.name(), fit);
    }
    // What is worst of several: of one axis or of all, a held body has one number.
    let largest = |of: &dyn Fn(&RestFit) -> [NoiseAxis; 3]| {
        let sds = fits.iter().flat_map(|fit| of(fit).map(|axis| axis.sd));
        sds.fold(0.0, f64::max)
    };
    let held = reads[0]
        .track()
        .filter(|(scene, track)| scene.is_held(track.link));
    if let Some((scene, track)) = held {
        let position = rounded(largest(&|fit| fit.position_m) * 1e3);
        let orientation = rounded(largest(&|fit| fit.orientation_rad).to_degrees());
        found.scene.body.push(BodyValues {
            name: scene.links[track.link].name.clone(),
            tracker_sd_mm: (position > 0.0).then_some(position),
            tracker_sd_deg: (orientation > 0.0).then_some(orientation),
            ..BodyValues::default()
        });
    }
    if !stands.is_empty() {
        say_mount(&mut found, &reads, &fits, stands)?;
    }
    Ok((found, lost_of(reads)))
}

fn say_rest(found: &mut Calibration, file: &str, fit: &RestFit) {
    let mut axes = |name: &str, unit: &str, of: [NoiseAxis; 3], factor: f64| {
        let numbers = |get: fn(&NoiseAxis) -> f64| {
            of.iter().map(|axis| rounded(get(axis) * factor)).collect()
        };
        found.quantity.push(CalibratedQuantity {
            name: format!("noise of {name}, standard deviation, {file}"),
            unit: unit.to_owned(),
            value: numbers(|axis| axis.sd),
            lower: numbers(|axis| axis.lower),
            upper: numbers(|axis| axis.upper),
        });
        let fast: Vec<f64> = of.iter().map(|axis| axis.fast_sd * factor).collect();
        found.quantity.push(plain(
            &format!("of it from sample to sample, {file}"),
            unit,
            &fast,
        ));
        let times: Vec<f64> = of.iter().map(|axis| axis.correlation).collect();
        found.quantity.push(plain(
            &format!("its correlation time, {file}"),
            "samples",
            &times,
        ));
    };
    axes("positions along world axes", "mm", fit.position_m, 1e3);
    axes(
        "orientations about tracker axes",
        "deg",
        fit.orientation_rad,
        1_f64.to_degrees(),
    );
    found.quantity.push(plain(
        &format!("moved during the recording, {file}"),
        "mm",
        &[fit.moved_m * 1e3],
    ));
    if fit.moved_m > MOVED_M || fit.turned_rad > TURNED_RAD {
        found.against.push(format!(
            "{file}: the object moved by {:.2} mm and turned by {:.3}° during the recording: it was not at rest",
            fit.moved_m * 1e3,
            fit.turned_rad.to_degrees()
        ));
    }
    if fit.is_slow {
        found.against.push(format!(
            "{file}: the noise wanders as slowly as the recording is long: its standard deviation is of this recording only"
        ));
    }
    if fit.frozen > FROZEN {
        found.against.push(format!(
            "{file}: {:.0} % of the poses are the very same as the one before: the tracker was frozen, or is polled faster than it measures",
            fit.frozen * 100.0
        ));
    }
}

fn say_mount(
    found: &mut Calibration,
    reads: &[Read],
    fits: &[RestFit],
    stands: &[String],
) -> anyhow::Result<()> {
    let Some((scene, track)) = reads[0].track() else {
        bail!(
            "{}: --stands is of a scene's body, expected --scene FILE or a scene in the recording, and --body NAME where it has several",
            reads[0].file
        );
    };
    let Some(up) = (-scene.gravity_m_s2).try_normalize(1e-6) else {
        bail!("the scene has no gravity: nothing is up in it");
    };
    // Everything in the frame in which the scene gives the body: that is where its keys are.
    let link = &scene.links[track.link];
    let in_scene = link.given_from(&track.link_from_tracker).rotation;
    let given_from_link = link.link_from_given.rotation.inverse();
    let standings: Vec<Standing> = fits
        .iter()
        .zip(stands)
        .map(|(fit, name)| {
            Ok(Standing {
                body_up: given_from_link * body_axis(link, name)?,
                tracker_up: fit.world_from_tracker.inverse() * up,
            })
        })
        .collect::<anyhow::Result<_>>()?;
    let Some(mount) = calibrate::mount(&standings, &in_scene) else {
        return Ok(());
    };
    let to_deg = 1_f64.to_degrees();
    let correction = mount.correction_rad * to_deg;
    found.quantity.push(plain(
        "tracker's turn from the scene's, tracker axes",
        "deg",
        correction.as_slice(),
    ));
    found.quantity.push(measured(
        "its interval, about body axes",
        "deg",
        &mount.interval_rad.times(to_deg),
    ));
    if let Some(residual_rad) = mount.residual_rad {
        found.quantity.push(plain(
            "residual of what was up, rms",
            "deg",
            &[residual_rad * to_deg],
        ));
    }
    if !mount.is_whole {
        found.notes.push(format!(
            "how the tracker is turned about the body's {} is the scene's: another recording in which it stands on another side tells",
            stands[0]
        ));
    }
    let q = mount.body_from_tracker.quaternion();
    let orientation = [q.w, q.i, q.j, q.k].map(|x| (x * 1e9).round() / 1e9);
    let tracker = TrackerValue {
        position_mm: None,
        orientation_wxyz: Some(orientation),
    };
    let values = mounted(scene, track, tracker);
    match found.scene.body.first_mut() {
        Some(held) => (held.tracker, held.track) = (values.tracker, values.track),
        None => found.scene.body.push(values),
    }
    Ok(())
}

/// Flights of which each is told.
const TOLD: usize = 5;

pub(super) fn gravity(inputs: &[PathBuf], choice: &CalibrateChoice) -> anyhow::Result<Found> {
    let reads = read_all(inputs, choice)?;
    // With a scene the tracker's mount says where the centre of mass is in its axes.
    let centre_m = reads[0]
        .track()
        .map(|(_, track)| track.link_from_tracker.inverse().translation.vector);
    let is_given = choice.from_s.is_some() || choice.to_s.is_some();
    let mut flights: Vec<Flight> = Vec::new();
    let mut told: Vec<String> = Vec::new();
    let mut found = begun("gravity", &reads);
    for read in &reads {
        let stream = &read.streams[0];
        let ranges = if is_given {
            std::iter::once(0..stream.readings.len()).collect()
        } else {
            calibrate::flights(stream, &centre_m.unwrap_or_default())
        };
        if ranges.is_empty() {
            let missing = calibrate::CalibrateError::NoFlight(calibrate::LEAST_FLIGHT);
            return Err(missing).with_context(|| read.file.clone());
        }
        for range in ranges {
            let readings = stream.readings[range].to_vec();
            if let [Some(first), Some(last)] = [readings.first(), readings.last()] {
                told.push(format!(
                    "{}: flight from {:.3} s to {:.3} s, {} samples",
                    read.name(),
                    first.time_s,
                    last.time_s,
                    readings.len()
                ));
            }
            flights.push(Flight { readings });
        }
    }
    if told.len() > TOLD {
        let samples = flights.iter().map(|flight| flight.readings.len());
        let (least, most) = (samples.clone().min(), samples.max());
        told = vec![format!(
            "{} flights of {} to {} samples in {} recordings",
            flights.len(),
            least.unwrap_or_default(),
            most.unwrap_or_default(),
            reads.len()
        )];
    }
    found.notes.extend(told);
    for at in calibrate::unlike(&flights, &centre_m.unwrap_or_default())
        .into_iter()
        .rev()
    {
        let flight = flights.remove(at);
        found.notes.push(format!(
            "flight {} of {} samples falls unlike the others and was left out",
            at + 1,
            flight.readings.len()
        ));
    }
    let fit = calibrate::gravity(&flights, centre_m.as_ref())?;
    found.quantity.push(measured(
        "gravity in the tracker's frame",
        "m/s²",
        &fit.gravity,
    ));
    found
        .quantity
        .push(measured("size of gravity", "m/s²", &fit.size));
    if let Some(centre) = &fit.centre {
        found.quantity.push(measured(
            "centre of mass in the tracker's axes",
            "mm",
            &centre.times(1e3),
        ));
    }
    found
        .quantity
        .push(plain("residual per axis", "mm", &[fit.residual * 1e3]));
    found.quantity.push(plain(
        "angle of up to the nearest axis",
        "deg",
        &[fit.tilt_rad.to_degrees()],
    ));
    let (axis, sign) = fit.up_axis;
    let sign = if sign < 0.0 { "-" } else { "+" };
    found.notes.push(format!(
        "up is near {sign}{} of the tracker's frame",
        ["x", "y", "z"][axis]
    ));
    found.notes.push(
        if fit.is_between_flights {
            "the interval is that of how flights differ"
        } else {
            "the interval is that of the noise within flights: how the tracker's scale and axes differ from place to place is not in it, five flights and more show it"
        }
        .to_owned(),
    );
    match fit.unit {
        Some(LengthUnit::Metre) => {}
        Some(unit) => found.against.push(format!(
            "gravity is {:.1} per s² in size: lengths come in {}, not in metres; convert them where they are recorded",
            fit.size.value[0],
            unit.as_str()
        )),
        None => found.against.push(format!(
            "gravity is {:.2} m/s² in size, which it is in no unit of length: either this is no free flight, or stamps run {:.2} times too fast",
            fit.size.value[0],
            (9.806_65 / fit.size.value[0]).sqrt().recip()
        )),
    }
    if fit.tilt_rad > ASKEW_RAD {
        found.against.push(format!(
            "up is {:.0}° from every axis of the tracker's frame: its floor was not set, or this is no free flight",
            fit.tilt_rad.to_degrees()
        ));
    }
    if fit.unit == Some(LengthUnit::Metre) {
        found.scene.gravity_m_s2 = Some(triple(fit.gravity.value.iter().copied()));
    }
    Ok((found, lost_of(reads)))
}

pub(super) fn clock(input: &Path, choice: &CalibrateChoice) -> anyhow::Result<Found> {
    // The part is one of the first stream's time; the second is searched whole.
    let whole = CalibrateChoice {
        from_s: None,
        to_s: None,
        ..choice.clone()
    };
    let mut read = read(input, &whole, 2, 2)?;
    let cut = |stream: &Stream| stream.clone().between(choice.from_s, choice.to_s, 2);
    let first = cut(&read.streams[0]).with_context(|| read.file.clone())?;
    read.streams[0] = first;
    let fit =
        calibrate::clock(&read.streams[0], &read.streams[1]).with_context(|| read.file.clone())?;
    let mut found = begun("clock", std::slice::from_ref(&read));
    let (one, other) = (&read.topics[0], &read.topics[1]);
    found.notes.push(format!(
        "what is added to stamps on {other} gives times on the clock of {one}"
    ));
    let (offset_ms, rate) = (fit.offset_s.times(1e3), fit.rate.times(1e6));
    found.quantity.push(measured(
        "offset at the second stream's first sample",
        "ms",
        &offset_ms,
    ));
    found.quantity.push(measured(
        "offset at the middle",
        "ms",
        &fit.middle_offset_s.times(1e3),
    ));
    found.quantity.push(measured("drift", "ppm", &rate));
    let turn = fit.first_from_second.scaled_axis() * 1_f64.to_degrees();
    found.quantity.push(plain(
        "rotation vector between the trackers, first from second",
        "deg",
        turn.as_slice(),
    ));

    found.quantity.push(plain(
        "residual of the orientations, rms",
        "deg",
        &[fit.residual_rad.to_degrees()],
    ));
    found.quantity.push(plain(
        "angular velocity, rms",
        "rad/s",
        &[fit.turning_rad_s],
    ));
    found
        .quantity
        .push(plain("time in common", "s", &[fit.overlap_s]));
    say_spread(&mut found, &fit.spread);
    if fit.residual_rad > 0.5 * fit.turn_rad {
        found.against.push(
            "the trackers' turning differs by more than half of what it is: are both on one rigid object?".to_owned(),
        );
    }
    if let Some((scene, tracks)) = &read.scene {
        let track = &scene.tracks[tracks[1]].name;
        let drifts = Measured::covers(&fit.rate, &[0.0]) != [true];
        found.scene.free.push(FreeValue {
            quantity: format!("{track}.clock.offset"),
            initial: rounded(offset_ms.value[0]),
            prior_sd: rounded(offset_ms.sd[0]).max(1e-6),
        });
        if drifts {
            found.scene.free.push(FreeValue {
                quantity: format!("{track}.clock.rate"),
                initial: (fit.rate.value[0] * 1e11).round() / 1e9,
                prior_sd: (fit.rate.sd[0] * 1e2).max(1e-9),
            });
        }
    }
    Ok((found, read.lost))
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    #[test]
    fn a_vector_is_rounded_to_what_is_written() {
        assert_eq!(
            triple(Vector3::new(1.000_000_4, -0.0, 2.0).iter().copied()),
            [1.0, 0.0, 2.0]
        );
    }
}
