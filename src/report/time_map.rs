//! Acted time against physical time, as a message.

use serde::{Deserialize, Serialize};

use crate::motion::{Estimate, Scene, Sketch, Stamp};

/// JSON schema of [`TimeMapMessage`].
pub const TIME_MAP_SCHEMA: &str = include_str!("time_map.schema.json");

/// A stamp as foxglove's JSON has it: exact, where one number would lose nanoseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Time {
    sec: i64,
    nsec: i64,
}

impl From<Time> for Stamp {
    fn from(time: Time) -> Self {
        Self(
            time.sec
                .saturating_mul(1_000_000_000)
                .saturating_add(time.nsec),
        )
    }
}

impl From<Stamp> for Time {
    fn from(stamp: Stamp) -> Self {
        Self {
            sec: stamp.0.div_euclid(1_000_000_000),
            nsec: stamp.0.rem_euclid(1_000_000_000),
        }
    }
}

/// Acted time, in seconds since `origin`, against physical time, in seconds since `physical_zero`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct TimeMapMessage {
    /// The stamp of acted time zero.
    pub origin: Time,
    /// The stamp of physical time zero; none where the file does not say it.
    pub physical_zero: Option<Time>,
    /// Bodies with samples.
    pub bodies: Vec<BodyTimes>,
    /// In order of time.
    pub events: Vec<EventTimeLine>,
}

/// When the samples of a body are.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct BodyTimes {
    /// Name of the track: that of the body, unless that has several.
    pub body: String,
    /// Acted times of the samples,
    pub acted_s: Vec<f64>,
    /// and the physical ones, one by one.
    pub physical_s: Vec<f64>,
}

/// When an event is.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct EventTimeLine {
    /// Name of the event.
    pub event: String,
    /// When it is acted.
    pub acted_s: f64,
    /// When it happens.
    pub physical_s: f64,
}

impl TimeMapMessage {
    /// The map of an estimate, body by body and event by event; physical time zero is stamped `zero`.
    pub fn new(scene: &Scene, sketch: &Sketch, estimate: &Estimate, zero: Stamp) -> Self {
        let bodies = scene.tracks.keys().map(|track| {
            let times = estimate
                .all_sample_times()
                .filter(|time| time.track == track);
            let (acted_s, physical_s) = times
                .map(|time| (time.stamp.seconds_since(sketch.origin), time.time_s))
                .unzip();
            BodyTimes {
                body: scene.tracks[track].name.clone(),
                acted_s,
                physical_s,
            }
        });
        let events = estimate.events.iter().map(|event| EventTimeLine {
            event: scene.events[event.event].name.clone(),
            acted_s: event.acted_s,
            physical_s: event.time_s,
        });
        Self {
            origin: sketch.origin.into(),
            physical_zero: Some(zero.into()),
            bodies: bodies.collect(),
            events: events.collect(),
        }
    }
}
