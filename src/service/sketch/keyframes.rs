//! Keyframes of a motion: of what was acted, or of what is estimated from it.

use anyhow::bail;

use super::super::deadline::Deadline;
use super::super::stopwatch::Stopwatch;
use super::super::working::Working;
use crate::motion::{
    ArcEstimate, EventKind, Keyframe, Mark, Scene, SketchRow, Stamp, TakeEvent, Timing, TrackIndex,
    Verdict,
};
use crate::pipeline::Pipeline;

/// How many keyframes are made of a motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Density {
    /// Every sample.
    All,
    /// So many of every flight.
    PerFlight(usize),
    /// So many a second.
    PerSecond(f64),
}

/// The keyframes that there may be of one flight, in order of time.
struct KeyframeFlight {
    track: TrackIndex,
    /// Its number among the track's, from 0.
    number: usize,
    keyframes: Vec<(Stamp, Keyframe)>,
}

/// A motion of which keyframes are chosen.
pub(super) struct SketchMotion {
    flights: Vec<KeyframeFlight>,
    marks: Vec<Mark>,
}

/// Keyframes of each second of an estimated flight among which is chosen.
const PER_SECOND: f64 = 1000.0;

/// Most keyframes of all estimated flights among which is chosen.
const LIMIT: f64 = 5e5;

impl SketchMotion {
    /// What was acted, flight by flight: parted by the streams of an edited sketch, else by the
    /// marks. Fails where marks without names are not as many as the events that are left for them.
    pub(super) fn acted(scene: &Scene, events: &[TakeEvent]) -> anyhow::Result<Self> {
        let mut marks: Vec<Mark> = events
            .iter()
            .filter_map(|event| match event {
                TakeEvent::Mark(mark) => Some(mark.clone()),
                TakeEvent::Pose { .. } => None,
            })
            .collect();
        marks.sort_by_key(|mark| mark.stamp);
        let is_edited = scene.timing == Timing::Edited;
        if is_edited {
            marks.clear();
        }
        name(scene, &mut marks)?;
        let mut flights = Vec::new();
        for track in scene.tracks.keys() {
            let mount = scene.mount(track);
            for stream in 0..scene.streams(track) {
                let mut keyframes: Vec<(Stamp, Keyframe)> = events
                    .iter()
                    .filter_map(|event| match event {
                        TakeEvent::Pose {
                            track: of,
                            stream: number,
                            sample,
                        } if (*of, *number) == (track, stream) => {
                            let keyframe = mount.keyframe_of(sample)?;
                            Some((sample.stamp, keyframe))
                        }
                        _ => None,
                    })
                    .collect();
                keyframes.sort_by_key(|(stamp, _)| *stamp);
                keyframes.dedup_by_key(|(stamp, _)| *stamp);
                let mut from = 0;
                for mark in marks.iter().map(Some).chain([None]) {
                    let to = mark.map_or(keyframes.len(), |mark| {
                        keyframes.partition_point(|(stamp, _)| *stamp <= mark.stamp)
                    });
                    flights.push(KeyframeFlight {
                        track,
                        number: stream,
                        keyframes: keyframes[from..to.max(from)].to_vec(),
                    });
                    from = to.max(from);
                }
            }
        }
        Ok(Self { flights, marks })
    }

    /// The motion that is estimated from a take, and what to know of it.
    pub(super) fn estimated(
        scene: &Scene,
        events: Vec<TakeEvent>,
        deadline: Deadline,
        working: &Working,
    ) -> anyhow::Result<(Self, Vec<String>)> {
        let mut stopwatch = Stopwatch::start(deadline, working);
        // What may be mistaken is not said here.
        let pipeline = Pipeline::of(scene.clone(), events).with_diagnoses(false);
        let outcome = pipeline.finish(&mut stopwatch)?;
        let has_ended_early = stopwatch.has_ended_it();
        let estimate = &outcome.estimate;
        if estimate.verdict == Verdict::Failed {
            bail!("no motion is found; `replay` says why");
        }
        let spans_s = estimate.arcs.iter().map(|arc| arc.end_s - arc.start_s);
        let span_s: f64 = spans_s.sum();
        // Not so of what is not finite either.
        let is_sane = span_s * PER_SECOND <= LIMIT;
        if !is_sane {
            bail!("the motion lasts {span_s} s: too long for a sketch");
        }
        let scene = &outcome.scene;
        let is_edited = scene.timing == Timing::Edited;
        let stamp = |time_s: f64| Stamp((time_s * 1e9).round() as i64);
        let mut flights = Vec::new();
        for track in scene.tracks.keys() {
            let mechanism = scene.mechanism_seen_by(track);
            let own = estimate
                .arcs
                .iter()
                .filter(|arc| arc.mechanism == mechanism);
            for (number, arc) in own.enumerate() {
                let zero_s = if is_edited { arc.start_s } else { 0.0 };
                let count = ((arc.end_s - arc.start_s) * PER_SECOND).ceil() as usize;
                let keyframes = (0..=count).map(|index| {
                    let share = index as f64 / count.max(1) as f64;
                    let at = stamp(arc.start_s + share * (arc.end_s - arc.start_s) - zero_s);
                    // At the stamp, which counts whole nanoseconds.
                    let time_s = zero_s + at.seconds_since(Stamp(0));
                    (
                        at,
                        keyframe(scene, track, arc, estimate.gravity_m_s2, at, time_s),
                    )
                });
                flights.push(KeyframeFlight {
                    track,
                    number: if is_edited { number } else { 0 },
                    keyframes: keyframes.collect(),
                });
            }
        }
        let marks = estimate.events.iter().map(|event| Mark {
            stamp: stamp(event.time_s),
            event: Some(scene.events[event.event].name.clone()),
        });
        let is_start = |mark: &Mark| {
            let named = scene
                .events
                .iter()
                .find(|e| Some(&e.name) == mark.event.as_ref());
            named.is_some_and(|event| event.kind == EventKind::Start)
        };
        let marks = marks.filter(|mark| !is_edited && !is_start(mark)).collect();
        let note = matches!(scene.timing, Timing::Unknown { .. }).then(|| {
            "its times are physical: read it with `stamps = \"physical\"` in the scene".to_owned()
        });
        let early =
            has_ended_early.then(|| "ended at its deadline with the best motion so far".to_owned());
        let notes = note.into_iter().chain(early).collect();
        Ok((Self { flights, marks }, notes))
    }

    /// The chosen keyframes with the marks, in order of time, which begins with the first.
    pub(super) fn rows(self, scene: &Scene, density: Density) -> anyhow::Result<Vec<SketchRow>> {
        let is_edited = scene.timing == Timing::Edited;
        let stamps = self
            .flights
            .iter()
            .filter_map(|flight| flight.keyframes.first());
        let marks = self.marks.iter().map(|mark| mark.stamp);
        let zero = stamps.map(|(stamp, _)| *stamp).chain(marks).min();
        let Some(zero) = zero else {
            bail!("no poses, expected some to make keyframes of");
        };
        let mut rows: Vec<((usize, Stamp), SketchRow)> = Vec::new();
        for flight in &self.flights {
            let Some((first, _)) = flight.keyframes.first() else {
                continue;
            };
            let zero = if is_edited { *first } else { zero };
            for index in chosen(&flight.keyframes, density) {
                let (stamp, keyframe) = &flight.keyframes[index];
                let stamp = Stamp(stamp.0.saturating_sub(zero.0));
                let keyframe = Keyframe {
                    time: keyframe.time.since(zero),
                    ..keyframe.clone()
                };
                let row = SketchRow::Keyframe {
                    track: flight.track,
                    flight: flight.number,
                    keyframe,
                };
                rows.push(((flight.number, stamp), row));
            }
        }
        for mark in self.marks {
            let stamp = Stamp(mark.stamp.0.saturating_sub(zero.0));
            rows.push(((0, stamp), SketchRow::Mark(Mark { stamp, ..mark })));
        }
        rows.sort_by_key(|(key, _)| *key);
        Ok(rows.into_iter().map(|(_, row)| row).collect())
    }
}

/// Gives marks without names, in order of time, those of the events that no mark names: a written sketch names
/// them all.
fn name(scene: &Scene, marks: &mut [Mark]) -> anyhow::Result<()> {
    let scene = scene.with_marks(marks.len());
    let is_named = |name: &String| marks.iter().any(|mark| mark.event.as_ref() == Some(name));
    let names = scene.events.iter().map(|event| &event.name);
    let left: Vec<String> = names.filter(|name| !is_named(name)).cloned().collect();
    let unnamed = marks.iter_mut().filter(|mark| mark.event.is_none());
    let unnamed: Vec<&mut Mark> = unnamed.collect();
    if unnamed.is_empty() {
        return Ok(());
    }
    if unnamed.len() != left.len() {
        bail!(
            "{} marks without a name, expected {}: {}; `enact mark` gives them names",
            unnamed.len(),
            left.len(),
            left.join(", ")
        );
    }
    for (mark, name) in unnamed.into_iter().zip(left) {
        mark.event = Some(name);
    }
    Ok(())
}

fn keyframe(
    scene: &Scene,
    track: TrackIndex,
    arc: &ArcEstimate,
    gravity_m_s2: nalgebra::Vector3<f64>,
    stamp: Stamp,
    time_s: f64,
) -> Keyframe {
    let state = scene.flown(arc, &gravity_m_s2, time_s);
    let link_from_given = scene.links[scene.tracks[track].link].link_from_given;
    Keyframe::of_pose(stamp, &(state.world_from_body() * link_from_given))
}

/// Indices of the keyframes that are nearest to evenly spread times.
fn chosen(keyframes: &[(Stamp, Keyframe)], density: Density) -> Vec<usize> {
    let (Some((first, _)), Some((last, _))) = (keyframes.first(), keyframes.last()) else {
        return Vec::new();
    };
    let span_s = last.seconds_since(*first);
    let times_s: Vec<f64> = match density {
        Density::All => return (0..keyframes.len()).collect(),
        Density::PerFlight(count) => (0..count)
            .map(|index| span_s * (index as f64 + 0.5) / count as f64)
            .collect(),
        // Of all times those beside keyframes: whichever keyframe is nearest to any is to one of them,
        // and years may lie between two.
        Density::PerSecond(rate_hz) => {
            let last = (span_s * rate_hz).floor();
            let beside = keyframes.iter().flat_map(|(at, _)| {
                let index = at.seconds_since(*first) * rate_hz;
                [index.floor(), index.ceil()]
            });
            let mut indices: Vec<f64> = beside.filter(|index| *index <= last).collect();
            indices.sort_by(f64::total_cmp);
            indices.dedup();
            indices.into_iter().map(|index| index / rate_hz).collect()
        }
    };
    let nearest = times_s.iter().map(|time_s| {
        let after = keyframes.partition_point(|(at, _)| at.seconds_since(*first) < *time_s);
        let off_s = |index: usize| (keyframes[index].0.seconds_since(*first) - time_s).abs();
        let after = after.min(keyframes.len() - 1);
        match after.checked_sub(1) {
            Some(before) if off_s(before) <= off_s(after) => before,
            _ => after,
        }
    });
    let mut chosen: Vec<usize> = nearest.collect();
    chosen.dedup();
    chosen
}
