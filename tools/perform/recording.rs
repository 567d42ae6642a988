//! Performances as recordings: messages, the scene, and the truth for who wants to compare.
//!
//! Beside `mod.rs` and not in it, for only the tool and the tests write files: they declare
//! `mod perform;` and `mod recording;` both.

use std::path::Path;

use enact::motion::TakeEvent;
use enact::write::{RecordingWriter, WriteError};
use serde::Serialize;

use crate::perform::{Acting, Performance, Style, perform};

/// Frame of all poses.
const WORLD: &str = "world";

/// A recording that is kept in the repository.
pub struct Kept {
    /// File name.
    pub name: &'static str,
    /// What is performed.
    pub style: Style,
    /// How.
    pub acting: Acting,
    /// Of the random numbers.
    pub seed: u64,
}

/// The recordings in `recordings/`. The performer's hand rests after the landing.
pub fn kept() -> [Kept; 2] {
    let acting = Acting {
        hold_after_s: 0.3,
        ..Acting::default()
    };
    [
        Kept {
            name: "pencil_tip.mcap",
            style: Style::Tip,
            acting,
            seed: 7,
        },
        Kept {
            name: "pencil_eraser.mcap",
            style: Style::Eraser,
            acting,
            seed: 8,
        },
    ]
}

impl Kept {
    /// Writes it.
    pub fn write(&self, path: &Path) -> Result<(), WriteError> {
        let performance = perform(&self.style.truth(), &self.acting, self.seed);
        write(&performance, self.style.scene_toml(), path)
    }
}

/// Writes a performance: `scene.toml` first, as a live pipeline would need it, `truth.json` last.
pub fn write(performance: &Performance, scene_toml: &str, path: &Path) -> Result<(), WriteError> {
    let scene = &performance.truth.scene;
    let mut writer = RecordingWriter::create(path)?;
    writer.attach("scene.toml", "application/toml", scene_toml.as_bytes())?;
    for (event, arrival) in performance.events.iter().zip(&performance.arrivals) {
        match event {
            TakeEvent::Pose { body, sample } => {
                writer.pose(&scene.bodies[*body].topic, WORLD, *arrival, sample)?;
            }
            TakeEvent::Mark(mark) => writer.mark(&scene.marks_topic, *arrival, mark)?,
        }
    }
    writer.attach(
        "truth.json",
        "application/json",
        truth_json(performance).as_bytes(),
    )?;
    writer.finish()
}

/// What was really performed. Rounded to 1e-9 of every unit, so that the last bits, which differ
/// between platforms, do not reach the file.
#[derive(Serialize)]
struct Record<'a> {
    note: &'static str,
    scene: &'a str,
    seed: u64,
    start_ns: i64,
    acting: &'a Acting,
    duration_s: f64,
    acted_duration_s: f64,
    events: Vec<EventRecord<'a>>,
    arcs: Vec<ArcRecord<'a>>,
    samples: Vec<SamplesRecord<'a>>,
}

#[derive(Serialize)]
struct EventRecord<'a> {
    name: &'a str,
    time_s: f64,
    acted_s: f64,
}

#[derive(Serialize)]
struct ArcRecord<'a> {
    body: &'a str,
    start_s: f64,
    end_s: f64,
    position_m: [f64; 3],
    orientation_wxyz: [f64; 4],
    velocity_m_s: [f64; 3],
    angular_velocity_rad_s: [f64; 3],
}

#[derive(Serialize)]
struct SamplesRecord<'a> {
    body: &'a str,
    stamps_ns: Vec<i64>,
    times_s: Vec<f64>,
}

/// The attachment `truth.json`.
pub fn truth_json(performance: &Performance) -> String {
    let truth = &performance.truth;
    let name = |body: usize| truth.scene.bodies[body].name.as_str();
    let record = Record {
        note: "The hidden truth of this made-up performance, for comparison only. Times are physical \
               seconds since the start of the motion; acted_s are acted seconds since then; \
               states are at start_s, centre of mass, angular velocity in body axes.",
        scene: &truth.scene.name,
        seed: performance.seed,
        start_ns: performance.acting.start.0,
        acting: &performance.acting,
        duration_s: rounded(truth.duration_s),
        acted_duration_s: rounded(performance.tempo.acted_duration_s()),
        events: truth
            .scene
            .events
            .iter()
            .zip(&truth.event_times_s)
            .map(|(event, time_s)| EventRecord {
                name: &event.name,
                time_s: rounded(*time_s),
                acted_s: rounded(performance.tempo.acted_s(*time_s)),
            })
            .collect(),
        arcs: truth
            .arcs
            .iter()
            .map(|arc| {
                let q = arc.state.orientation.quaternion();
                ArcRecord {
                    body: name(arc.body),
                    start_s: rounded(arc.start_s),
                    end_s: rounded(arc.end_s),
                    position_m: arc.state.position_m.map(rounded).into(),
                    orientation_wxyz: [q.w, q.i, q.j, q.k].map(rounded),
                    velocity_m_s: arc.state.velocity_m_s.map(rounded).into(),
                    angular_velocity_rad_s: arc.state.angular_velocity_rad_s.map(rounded).into(),
                }
            })
            .collect(),
        samples: samples(performance),
    };
    let mut text = serde_json::to_string(&record).expect("numbers and names are JSON");
    text.push('\n');
    text
}

fn samples(performance: &Performance) -> Vec<SamplesRecord<'_>> {
    let bodies = performance
        .truth
        .scene
        .bodies
        .iter()
        .zip(&performance.sample_times_s);
    bodies
        .enumerate()
        .map(|(index, (body, times_s))| SamplesRecord {
            body: &body.name,
            stamps_ns: performance
                .events
                .iter()
                .filter_map(|event| match event {
                    TakeEvent::Pose { body, sample } if *body == index => Some(sample.stamp.0),
                    _ => None,
                })
                .collect(),
            times_s: times_s.iter().copied().map(rounded).collect(),
        })
        .collect()
}

fn rounded(value: f64) -> f64 {
    (value * 1e9).round() / 1e9
}
