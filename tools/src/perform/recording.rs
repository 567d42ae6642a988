//! Performances as recordings: messages, the scene, and the truth for who wants to compare.
//!
//! Beside `mod.rs` and not in it, for only the tool and the tests write files: they declare
//! `mod perform;` and `mod recording;` both.

use std::collections::BTreeMap;
use std::path::Path;

use enact::motion::{Scene, Stamp, TakeEvent, TrackIndex};
use enact::write::{RecordingWriter, WriteError};
use serde::Serialize;
use typed_index_collections::TiVec;

use crate::perform::{Acting, Performance, Style, Truth, die, hat_box, perform};

/// Frame of all poses.
const WORLD: &str = "world";

/// A recording that is kept in the repository.
pub struct Kept {
    /// File name.
    pub name: &'static str,
    /// What is performed.
    pub truth: fn() -> Truth,
    /// Its scene file.
    pub scene_toml: &'static str,
    /// How.
    pub acting: Acting,
    /// Of the random numbers.
    pub seed: u64,
}

/// The recordings in `recordings/`. The performer's hand rests after the landing.
pub fn kept() -> [Kept; 5] {
    let acting = Acting {
        hold_after_s: 0.3,
        ..Acting::default()
    };
    [
        Kept {
            name: "pencil_tip.mcap",
            truth: || Style::Tip.truth(),
            scene_toml: Style::Tip.scene_toml(),
            acting,
            seed: 7,
        },
        Kept {
            name: "pencil_eraser.mcap",
            truth: || Style::Eraser.truth(),
            scene_toml: Style::Eraser.scene_toml(),
            acting,
            seed: 8,
        },
        Kept {
            name: "hat_box.mcap",
            truth: hat_box::truth,
            scene_toml: hat_box::SCENE_TOML,
            acting,
            seed: 10,
        },
        Kept {
            name: "hat_box_bent.mcap",
            truth: hat_box::bent_reference,
            scene_toml: hat_box::BENT_TOML,
            acting,
            seed: 11,
        },
        Kept {
            name: "die.mcap",
            truth: die::reference,
            scene_toml: die::SCENE_TOML,
            acting: Acting::edited(),
            seed: 9,
        },
    ]
}

impl Kept {
    /// Writes it.
    pub fn write(&self, path: &Path) -> Result<(), WriteError> {
        let performance = perform(&(self.truth)(), &self.acting, self.seed);
        write(&performance, self.scene_toml, path)
    }
}

/// Writes a performance: `scene.toml` first, as a live pipeline would need it, `truth.json` last.
pub fn write(performance: &Performance, scene_toml: &str, path: &Path) -> Result<(), WriteError> {
    let scene = &performance.truth.scene;
    let mut writer = RecordingWriter::create(path)?;
    writer.attach("scene.toml", "application/toml", scene_toml.as_bytes())?;
    let arrivals = performance.arrivals.iter().copied();
    write_events(&mut writer, scene, performance.events.iter().zip(arrivals))?;
    writer.attach(
        "truth.json",
        "application/json",
        truth_json(performance).as_bytes(),
    )?;
    writer.finish()
}

/// Writes samples and marks that arrive at once, with their scene.
pub fn write_events_of(
    scene: &Scene,
    scene_toml: &str,
    events: &[TakeEvent],
    path: &Path,
) -> Result<(), WriteError> {
    let mut writer = RecordingWriter::create(path)?;
    writer.attach("scene.toml", "application/toml", scene_toml.as_bytes())?;
    let stamped = events.iter().map(|event| match event {
        TakeEvent::Pose { sample, .. } => (event, sample.stamp),
        TakeEvent::Mark(mark) => (event, mark.stamp),
    });
    write_events(&mut writer, scene, stamped)?;
    writer.finish()
}

/// Writes samples and marks of a scene, each with its arrival.
pub fn write_events<'a>(
    writer: &mut RecordingWriter,
    scene: &Scene,
    events: impl Iterator<Item = (&'a TakeEvent, Stamp)>,
) -> Result<(), WriteError> {
    for (event, arrival) in events {
        match event {
            TakeEvent::Pose {
                track,
                stream,
                sample,
            } => {
                let topic = scene.stream_topic(*track, *stream);
                writer.pose(&topic, WORLD, arrival, sample)?;
            }
            TakeEvent::Mark(mark) => writer.mark(&scene.marks_topic, arrival, mark)?,
        }
    }
    Ok(())
}

const TRUTH: &str = "The hidden truth of this made-up performance, for comparison only. Times are physical \
     seconds since the start of the motion; acted_s are acted seconds since then; \
     states are at start_s, centre of mass, angular velocity in body axes.";

const INTENTION: &str = "What the maker of this performance had in mind, which physics does not allow: flights \
     that no impacts join. Times are physical seconds since the start of the motion; \
     states are at start_s, centre of mass, angular velocity in body axes.";

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
    #[serde(skip_serializing_if = "Vec::is_empty")]
    parameters: Vec<ParameterRecord<'a>>,
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
struct ParameterRecord<'a> {
    name: &'a str,
    value: f64,
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
    /// Where the body has several.
    #[serde(skip_serializing_if = "Option::is_none")]
    topic: Option<String>,
    stamps_ns: Vec<i64>,
    times_s: Vec<f64>,
}

/// The attachment `truth.json`.
pub fn truth_json(performance: &Performance) -> String {
    let truth = &performance.truth;

    let record = Record {
        note: if truth.is_physical { TRUTH } else { INTENTION },
        scene: &truth.scene.name,
        seed: performance.seed,
        start_ns: performance.acting.start.0,
        acting: &performance.acting,
        duration_s: rounded(truth.duration_s),
        acted_duration_s: rounded(performance.tempo.acted_duration_s()),
        parameters: truth
            .scene
            .parameters
            .iter()
            .zip(&truth.parameters)
            .filter(|_| truth.is_physical)
            .map(|(parameter, value)| ParameterRecord {
                name: &parameter.name,
                value: rounded(*value),
            })
            .collect(),
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
                    body: truth.scene.name_of_mechanism(arc.mechanism),
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
    let scene = &performance.truth.scene;
    let mut records: BTreeMap<(TrackIndex, usize), SamplesRecord> = BTreeMap::new();
    let mut times_s: TiVec<TrackIndex, _> = performance
        .sample_times_s
        .iter()
        .map(|s| s.iter())
        .collect();
    for event in &performance.events {
        let TakeEvent::Pose {
            track,
            stream,
            sample,
        } = event
        else {
            continue;
        };
        let record = records
            .entry((*track, *stream))
            .or_insert_with(|| SamplesRecord {
                body: &scene.link_seen_by(*track).name,
                topic: (scene.streams(*track) > 1).then(|| scene.stream_topic(*track, *stream)),
                stamps_ns: Vec::new(),
                times_s: Vec::new(),
            });
        record.stamps_ns.push(sample.stamp.0);
        record
            .times_s
            .extend(times_s[*track].next().copied().map(rounded));
    }
    records.into_values().collect()
}

fn rounded(value: f64) -> f64 {
    (value * 1e9).round() / 1e9
}
