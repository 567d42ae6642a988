//! Acted time against physical time, as a message.

use serde::Serialize;

use crate::motion::{Estimate, Scene, Sketch, Stamp};

/// JSON schema of [`TimeMapMessage`].
pub const TIME_MAP_SCHEMA: &str = include_str!("time_map.schema.json");

/// A stamp as foxglove's JSON has it: exact, where one number would lose nanoseconds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Time {
    sec: i64,
    nsec: i64,
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
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TimeMapMessage {
    origin: Time,
    physical_zero: Time,
    bodies: Vec<BodyTimes>,
    events: Vec<EventTimeLine>,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
struct BodyTimes {
    body: String,
    acted_s: Vec<f64>,
    physical_s: Vec<f64>,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
struct EventTimeLine {
    event: String,
    acted_s: f64,
    physical_s: f64,
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
            physical_zero: zero.into(),
            bodies: bodies.collect(),
            events: events.collect(),
        }
    }
}
