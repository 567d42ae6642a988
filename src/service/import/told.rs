//! What paths tell of how they were read: whether something falls down, at the right pace, and how large
//! all is.

use nalgebra::Vector3;

use super::names::Named;
use super::tracked::{ToldTracker, tracked};
use crate::ingest::table::{Preset, length_name};
use crate::motion::{Fall, Holds, LengthUnit, PoseSample, Scene, Timing, falls};

/// Gravity \[m/s²\]; what is near it by [`NEAR`] counts.
const GRAVITY_M_S2: f64 = 9.81;
const NEAR: f64 = 0.06;
/// Down is an axis up to this angle; trackers' floors tilt.
const TILT_RAD: f64 = 0.2;
/// A single flight tells something from so many samples on.
const FLIGHT_SAMPLES: usize = 9;
/// and speaks against axes and units from so many on.
const AGAINST_SAMPLES: usize = 12;
/// Rooms with trackers are between these \[m\].
const SPAN_M: [f64; 2] = [0.005, 50.0];
/// No hand and no throw has a greater median speed \[m/s\].
const SPEED_MAX_M_S: f64 = 50.0;
/// Presets that differ in which axis is up.
const AXES: [&str; 5] = ["z-up", "y-up", "x-up", "camera", "ned"];
/// Greatest deviation of a quaternion's norm from 1 that rounding explains.
const NORM_LIMIT: f64 = 0.01;
const UNITS: [LengthUnit; 5] = [
    LengthUnit::Metre,
    LengthUnit::Millimetre,
    LengthUnit::Centimetre,
    LengthUnit::Inch,
    LengthUnit::Foot,
];

/// What the path of a body tells.
#[derive(Clone, Debug, Default)]
pub(super) struct ToldImport {
    /// Its free flights, by index of sample.
    pub(super) flights: Vec<Fall>,
    /// Rate by the median interval.
    pub(super) rate_hz: Option<f64>,
    /// What speaks against how it was read.
    pub(super) against: Vec<String>,
    /// What is to be known.
    pub(super) notes: Vec<String>,
}

impl ToldImport {
    /// Adds the sentences of another.
    pub(super) fn add(&mut self, other: Self) {
        self.against.extend(other.against);
        self.notes.extend(other.notes);
    }
}

/// How things fall, as the scene says or everywhere.
#[derive(Clone, Copy, Debug)]
struct Gravity {
    down: Vector3<f64>,
    size_m_s2: f64,
    /// Whether nobody has said that times are real: of a motion acted slower nothing follows.
    is_tempo_possible: bool,
}

impl Gravity {
    /// Of a scene, or everywhere; `None` where stamps are those of acting, or nothing falls.
    fn of(scene: Option<&Scene>) -> Option<Self> {
        let Some(scene) = scene else {
            return Some(Self {
                down: -Vector3::z(),
                size_m_s2: GRAVITY_M_S2,
                is_tempo_possible: true,
            });
        };
        let size_m_s2 = scene.gravity_m_s2.norm();
        let is_acted = matches!(scene.timing, Timing::Unknown { .. });
        (!is_acted && size_m_s2 > 0.0).then(|| Self {
            down: scene.gravity_m_s2 / size_m_s2,
            size_m_s2,
            is_tempo_possible: false,
        })
    }

    fn tilt_rad(&self, acceleration: &Vector3<f64>) -> f64 {
        acceleration
            .normalize()
            .dot(&self.down)
            .clamp(-1.0, 1.0)
            .acos()
    }
}

/// What the samples of a body tell, which are in order of time.
pub(super) fn told(named: &Named, samples: &[&PoseSample], scene: Option<&Scene>) -> ToldImport {
    let mut told = ToldImport::default();
    let name = &named.name;
    let of_name = |lines: &[String]| -> Vec<String> {
        lines.iter().map(|line| format!("{name}: {line}")).collect()
    };
    told.against.extend(of_name(&named.body.against));
    told.notes.extend(of_name(&named.body.notes));
    rate(samples, &mut told);
    let ToldTracker { notes, against } = tracked(name, samples, told.rate_hz);
    told.notes.extend(notes);
    told.against.extend(against);
    if samples.iter().any(|sample| sample.holds == Holds::Pose) {
        norms(name, samples, &mut told);
    }
    let first = samples.first().map(|sample| sample.stamp);
    let mut times_s: Vec<f64> = Vec::new();
    let mut points: Vec<Vector3<f64>> = Vec::new();
    let mut places: Vec<usize> = Vec::new();
    for (place, sample) in samples.iter().enumerate() {
        let time_s = first.map_or(0.0, |first| sample.stamp.seconds_since(first));
        if times_s.last().is_none_or(|last| *last < time_s) {
            times_s.push(time_s);
            points.push(sample.position_m);
            places.push(place);
        }
    }
    speed(named, &times_s, &points, &mut told);
    let Some(gravity) = Gravity::of(scene) else {
        size(named, &points, &mut told);
        return told;
    };
    // Were lengths in another unit, gravity would be as many times too great. What does not fall down is a
    // hand's swing, whatever its size.
    let taken = named.table.length;
    let factor = |unit: LengthUnit| taken.length_m() / unit.length_m();
    let unit_of = |acceleration: &Vector3<f64>, sd: f64| {
        UNITS.into_iter().find(|unit| {
            let expected = gravity.size_m_s2 * factor(*unit);
            // What is read too small says nothing: hands have small accelerations too.
            factor(*unit) >= 1.0
                && (acceleration.norm() - expected).abs() <= NEAR * expected + 3.0 * sd
                && (*unit == taken || gravity.tilt_rad(acceleration) <= TILT_RAD)
        })
    };
    let found = falls(&times_s, &points, |a, sd| unit_of(a, sd).is_some());
    let longest = found.iter().max_by_key(|fall| fall.samples.len());
    if let Some(longest) = longest.filter(|fall| fall.samples.len() >= FLIGHT_SAMPLES)
        && let Some(unit) = unit_of(&longest.acceleration, longest.acceleration_sd)
    {
        let begin_s = times_s[longest.samples.start];
        let flight = ToldFlight {
            fall: longest,
            unit,
            begin_s,
        };
        fall(named, &flight, &gravity, &mut told);
        let is_of_unit =
            |fall: &Fall| unit_of(&fall.acceleration, fall.acceleration_sd) == Some(unit);
        let of_unit = found.iter().filter(|fall| is_of_unit(fall));
        told.flights = of_unit
            .map(|fall| Fall {
                samples: places[fall.samples.start]..places[fall.samples.end - 1] + 1,
                ..fall.clone()
            })
            .collect();
    } else {
        size(named, &points, &mut told);
    }
    told
}

/// A flight, the unit that its fall would have, and when it begins.
struct ToldFlight<'a> {
    fall: &'a Fall,
    unit: LengthUnit,
    begin_s: f64,
}

/// What a flight tells of axes and units.
fn fall(named: &Named, flight: &ToldFlight, gravity: &Gravity, told: &mut ToldImport) {
    let (name, preset) = (&named.name, named.table.preset);
    let (fall, unit) = (flight.fall, flight.unit);
    let down = fall.acceleration.normalize();
    let size = fall.acceleration.norm();
    let samples = fall.samples.len();
    let flight = format!(
        "{name}: a flight of {samples} samples from {:.3} s",
        flight.begin_s
    );
    if unit != named.table.length && samples >= AGAINST_SAMPLES {
        let tempo = match gravity.is_tempo_possible {
            true => {
                "; where the motion was acted slower than it is, this tells nothing: say --scene, or the unit"
            }
            false => "",
        };
        told.against.push(format!(
            "{flight} falls at {size:.4} m/s²: positions are in {}, not in {}; expected --length-unit {}{tempo}",
            word(unit),
            word(named.table.length),
            length_name(unit)
        ));
    }
    let tilt_rad = gravity.tilt_rad(&fall.acceleration);
    if tilt_rad <= TILT_RAD {
        if unit == named.table.length {
            told.notes.push(format!(
                "{flight} falls down, at {size:.2} m/s², {:.1}° from {}: axes and units agree with it",
                tilt_rad.to_degrees(),
                if gravity.down == -Vector3::z() { "−z" } else { "the scene's gravity" }
            ));
        }
        return;
    }
    let axis = down.iamax();
    let along = down[axis].abs().clamp(0.0, 1.0).acos();
    let letter = ["x", "y", "z"][axis];
    let sign = if down[axis] < 0.0 { "−" } else { "+" };
    let right = AXES
        .iter()
        .filter_map(|name| Preset::named(name))
        .find(|other| {
            let own = preset.undone(down.into());
            Vector3::from(other.vector(own)).dot(&gravity.down) > TILT_RAD.cos()
        });
    match right.filter(|_| along <= TILT_RAD && samples >= AGAINST_SAMPLES) {
        Some(right) => told.against.push(format!(
            "{flight} falls along {sign}{letter} as read with {}; its world is {}: expected --from {}",
            preset.name, right.about, right.name
        )),
        // Of a body that hangs on another, that a hand moves, or that the tracker smooths.
        None => told.notes.push(format!(
            "{flight} seems to fall {:.0}° from down, which tells nothing of axes",
            tilt_rad.to_degrees()
        )),
    }
}

/// What the median speed tells: no hand and no throw goes on so fast.
fn speed(named: &Named, times_s: &[f64], points: &[Vector3<f64>], told: &mut ToldImport) {
    let steps = times_s.windows(2).zip(points.windows(2));
    let mut speeds_m_s: Vec<f64> = steps
        .map(|(times, places)| (places[1] - places[0]).norm() / (times[1] - times[0]))
        .collect();
    if speeds_m_s.len() < FLIGHT_SAMPLES {
        return;
    }
    let middle = speeds_m_s.len() / 2;
    let median_m_s = *speeds_m_s.select_nth_unstable_by(middle, f64::total_cmp).1;
    if median_m_s > SPEED_MAX_M_S {
        told.against.push(format!(
            "{}: it moves at {median_m_s:.0} m/s in the median, in {} and with these times; expected --length-unit, \
             --time-unit or --rate for others",
            named.name,
            word(named.table.length)
        ));
    }
}

/// What lengths alone tell.
fn size(named: &Named, points: &[Vector3<f64>], told: &mut ToldImport) {
    let Some(first) = points.first() else {
        return;
    };
    let (least, greatest) = points
        .iter()
        .fold((*first, *first), |(a, b), p| (a.inf(p), b.sup(p)));
    let span_m = (greatest - least).max();
    let (name, unit) = (&named.name, word(named.table.length));
    if span_m > SPAN_M[1] {
        told.against.push(format!(
            "{name}: positions span {span_m:.0} m, taken in {unit}; expected a room: is it --length-unit mm?"
        ));
    } else if span_m < SPAN_M[0] && span_m > 0.0 && points.len() >= FLIGHT_SAMPLES {
        told.notes.push(format!(
            "{name}: positions span {:.2} mm, taken in {unit}; if it moves more than that, say --length-unit",
            1e3 * span_m
        ));
    }
}

fn rate(samples: &[&PoseSample], told: &mut ToldImport) {
    let intervals = samples.windows(2);
    let mut intervals_s: Vec<f64> = intervals
        .map(|pair| pair[1].stamp.seconds_since(pair[0].stamp))
        .filter(|interval_s| *interval_s > 0.0)
        .collect();
    intervals_s.sort_by(f64::total_cmp);
    let median_s = intervals_s.get(intervals_s.len() / 2);
    told.rate_hz = median_s.map(|of| 1.0 / of);
}

fn norms(name: &str, samples: &[&PoseSample], told: &mut ToldImport) {
    let norms = samples.iter().map(|sample| {
        let parts = sample.quaternion_xyzw.iter().map(|part| part * part);
        parts.sum::<f64>().sqrt()
    });
    let off: Vec<f64> = norms
        .filter(|norm| !((norm - 1.0).abs() <= NORM_LIMIT))
        .collect();
    if let Some(first) = off.first() {
        told.against.push(format!(
            "{name}: {} of {} quaternions have a norm other than 1, the first {first:.3}: is one of their \
             columns another?",
            off.len(),
            samples.len()
        ));
    }
}

fn word(unit: LengthUnit) -> &'static str {
    match unit {
        LengthUnit::Millimetre => "millimetres",
        LengthUnit::Centimetre => "centimetres",
        LengthUnit::Inch => "inches",
        LengthUnit::Foot => "feet",
        LengthUnit::Metre => "metres",
    }
}
