//! Keyframes of a true motion: a few poses of each flight, as somebody poses a body by hand.

use enact::math::{Pose, so3};
use enact::motion::{Estimate, Mark, PoseSample, Stamp, TakeEvent, Timing, TrackIndex};
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::acting::START;
use super::truth::Truth;

/// Which keyframes are made of a motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Keyframing {
    /// Keyframes of every flight.
    pub per_flight: usize,
    /// Standard deviation of their positions, per axis \[m\].
    pub position_sd_m: f64,
    /// Standard deviation of their orientations, per axis \[rad\].
    pub orientation_sd_rad: f64,
}

impl Keyframing {
    /// So many exact ones.
    pub fn exact(per_flight: usize) -> Self {
        Self {
            per_flight,
            position_sd_m: 0.0,
            orientation_sd_rad: 0.0,
        }
    }

    /// The keyframes of a motion, and the marks of its events where its scene's times are
    /// physical. In an edited sketch every flight's stamps count from its own beginning.
    ///
    /// Of `n` keyframes each is somewhere in the middle half of its `n`-th part of the flight.
    pub fn of(&self, truth: &Truth, seed: u64) -> Vec<TakeEvent> {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let is_edited = truth.scene.timing == Timing::Edited;
        let mut events = Vec::new();
        for track in truth.scene.tracks.keys() {
            let mechanism = truth.scene.mechanism_seen_by(track);
            let flights = truth.arcs.iter().filter(|arc| arc.mechanism == mechanism);
            for (number, arc) in flights.enumerate() {
                for index in 0..self.per_flight {
                    let share = index as f64 + 0.25 + 0.5 * random.random::<f64>();
                    let lasts_s = arc.end_s - arc.start_s;
                    let time_s = arc.start_s + lasts_s * share / self.per_flight as f64;
                    let zero_s = if is_edited { arc.start_s } else { 0.0 };
                    let stamp = stamp(time_s - zero_s);
                    // At the stamp, which counts whole nanoseconds.
                    let time_s = zero_s + stamp.seconds_since(START);
                    let pose = truth.flown(arc, time_s).world_from_body();
                    events.push(TakeEvent::Pose {
                        track,
                        stream: if is_edited { number } else { 0 },
                        sample: self.keyframe(truth, track, (stamp, pose), &mut random),
                    });
                }
            }
        }
        if !is_edited {
            let marks = truth.scene.events.iter().zip(&truth.event_times_s);
            events.extend(marks.map(|(event, time_s)| {
                TakeEvent::Mark(Mark {
                    stamp: stamp(*time_s),
                    event: Some(event.name.clone()),
                })
            }));
        }
        events
    }

    fn keyframe(
        &self,
        truth: &Truth,
        track: TrackIndex,
        (stamp, pose): (Stamp, Pose),
        random: &mut ChaCha8Rng,
    ) -> PoseSample {
        let mut normal3 = || -> Vector3<f64> {
            Vector3::from_fn(|_, _| StandardNormal.sample(random))
        };
        let position_m = pose.translation.vector + normal3() * self.position_sd_m;
        let orientation = pose.rotation * so3::exp(&(normal3() * self.orientation_sd_rad));
        let pose = Pose::from_parts(position_m.into(), orientation)
            * truth.scene.tracks[track].link_from_tracker;
        let [x, y, z, w]: [f64; 4] = pose.rotation.coords.into();
        PoseSample {
            stamp,
            position_m: pose.translation.vector,
            quaternion_xyzw: [x, y, z, w],
        }
    }
}

fn stamp(time_s: f64) -> Stamp {
    Stamp(START.0 + (time_s * 1e9).round() as i64)
}

/// Greatest errors of a motion at the ends of its flights and of its events' times.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Off {
    /// \[m\].
    pub position_m: f64,
    /// \[rad\].
    pub orientation_rad: f64,
    /// \[s\].
    pub time_s: f64,
}

impl Off {
    /// Of an estimate from keyframes.
    pub fn of(truth: &Truth, events: &[TakeEvent], estimate: &Estimate) -> Self {
        let first = events.iter().filter_map(|event| match event {
            TakeEvent::Pose { stream: 0, sample, .. } => Some(sample.stamp),
            _ => None,
        });
        // Time zero is the first keyframe.
        let zero_s = first.min().map_or(0.0, |stamp| stamp.seconds_since(START));
        let mut off = Self::default();
        let mut found: Vec<_> = estimate.arcs.iter().collect();
        found.sort_by(|a, b| (a.mechanism, a.start_s).partial_cmp(&(b.mechanism, b.start_s)).unwrap());
        let mut arcs: Vec<_> = truth.arcs.iter().collect();
        arcs.sort_by(|a, b| (a.mechanism, a.start_s).partial_cmp(&(b.mechanism, b.start_s)).unwrap());
        for (arc, found) in arcs.iter().zip(&found) {
            for share in [0.0, 0.5, 1.0] {
                let time_s = arc.start_s + share * (arc.end_s - arc.start_s);
                let state = truth.flown(arc, time_s);
                let since_s = time_s - zero_s - found.epoch_s;
                let dynamics = truth.scene.dynamics(found.mechanism);
                let there = dynamics.advance(&truth.scene.gravity_m_s2, &found.state, since_s);
                let position_m = (there.position_m - state.position_m).norm();
                off.position_m = off.position_m.max(position_m);
                let turn = so3::log(&(state.orientation.inverse() * there.orientation));
                off.orientation_rad = off.orientation_rad.max(turn.norm());
            }
        }
        for event in &estimate.events {
            if truth.scene.events[event.event].kind.collision().is_some() {
                let error_s = event.time_s + zero_s - truth.event_times_s[event.event];
                off.time_s = off.time_s.max(error_s.abs());
            }
        }
        off
    }

    /// The greatest number, metres, radians and seconds alike.
    pub fn greatest(&self) -> f64 {
        self.position_m.max(self.orientation_rad).max(self.time_s)
    }
}
