//! A performance: what the tracker delivered, and what only its maker knows.

use enact::motion::{Sample, Seen, Sketch, Stamp, TakeEvent, Timing, TrackIndex, TrackSketch};
use nalgebra::{Quaternion, UnitQuaternion};
use typed_index_collections::TiVec;

use super::acting::Acting;
use super::tempo::Tempo;
use super::truth::Truth;

/// An acted motion and its hidden truth.
#[derive(Clone, Debug)]
pub struct Performance {
    /// The motion that was acted; its scene says what the stamps mean.
    pub truth: Truth,
    /// How it was acted.
    pub acting: Acting,
    /// Of the random numbers.
    pub seed: u64,
    /// The hidden tempo.
    pub tempo: Tempo,
    /// What was delivered, in order of arrival.
    pub events: Vec<TakeEvent>,
    /// When each of them arrived.
    pub arrivals: Vec<Stamp>,
    /// Hidden physical time of every sample [s since the start of the motion], track by track, in
    /// the order of the samples.
    pub sample_times_s: TiVec<TrackIndex, Vec<f64>>,
}

impl Performance {
    /// The sketch that a perfect reader of the recording would make: mount undone, signs made
    /// continuous, every mark at its event, nothing dropped. Not for edited sketches.
    pub fn sketch(&self) -> Sketch {
        assert_ne!(self.truth.scene.timing, Timing::Edited, "it has no marks");
        let stamps = self.events.iter().filter_map(|event| match event {
            TakeEvent::Pose { sample, .. } => Some(sample.stamp),
            TakeEvent::Mark(_) => None,
        });
        let origin = stamps.min().unwrap_or(self.acting.start);
        let seen = &self.truth.scene.tracks;
        let mut tracks: TiVec<_, _> = vec![TrackSketch::default(); seen.len()].into();
        let mut marks_s = Vec::new();
        for event in &self.events {
            match event {
                TakeEvent::Mark(mark) => marks_s.push(mark.stamp.seconds_since(origin)),
                TakeEvent::Pose { track, sample, .. } => {
                    let [x, y, z, w] = sample.quaternion_xyzw;
                    let world_from_tracker = enact::math::Pose::from_parts(
                        sample.position_m.into(),
                        UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z)),
                    );
                    let tracker_from_body = seen[*track].link_from_tracker.inverse();
                    let world_from_body = world_from_tracker * tracker_from_body;
                    let samples = &mut tracks[*track].samples;
                    samples.push(Sample {
                        stamp: sample.stamp,
                        acted_s: sample.stamp.seconds_since(origin),
                        seen: Seen::Pose {
                            position_m: world_from_body.translation.vector,
                            orientation: nearer(
                                world_from_body.rotation,
                                samples
                                    .last()
                                    .and_then(|last: &Sample| last.seen.orientation()),
                            ),
                        },
                    });
                }
            }
        }
        Sketch {
            origin,
            tracks,
            contacts_s: Default::default(),
            cuts_sd_s: Default::default(),
            marks: vec![None; marks_s.len()],
            marks_s,
        }
    }
}

/// Of `q` and `−q`, one rotation, the nearer to the one before.
fn nearer(q: UnitQuaternion<f64>, last: Option<UnitQuaternion<f64>>) -> UnitQuaternion<f64> {
    match last {
        Some(last) if last.coords.dot(&q.coords) < 0.0 => {
            UnitQuaternion::new_unchecked(-q.into_inner())
        }
        _ => q,
    }
}
