//! Keyframes of a true motion: a few poses of each flight, as somebody poses a body by hand.

use enact::math::{Pose, so3};
use enact::motion::{
    ArcEstimate, Estimate, LinkIndex, Mark, PoseSample, Stamp, TakeEvent, Timing, TrackIndex,
};
use enact::physics::flow;
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::acting::START;
use super::bounces::{Polyhedron, Throw, bounces, thrown};
use super::styles::Style;
use super::truth::{Truth, TruthError, simulate};

/// A motion of which keyframes are made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Keyframed {
    /// A pencil that falls on its tip or its eraser, about as into the mug, without the mug.
    Pencil(Style),
    /// A box with so many bounces.
    Box(usize),
    /// A die with so many bounces.
    Die(usize),
}

impl Keyframed {
    /// A true motion; a pencil's ends before it hits again.
    pub fn truth(self, seed: u64) -> Result<Truth, TruthError> {
        match self {
            Keyframed::Box(count) => bounces(count, seed),
            Keyframed::Die(count) => thrown(Polyhedron::Cube, &Throw::DIE, count, seed),
            Keyframed::Pencil(style) => pencil(style, seed),
        }
    }
}

/// Half of the pencil's length, and how near to the table its ends may come after the bounce \[m\].
const HALF_M: f64 = 0.095;
const CLEAR_M: f64 = 0.01;

fn pencil(style: Style, seed: u64) -> Result<Truth, TruthError> {
    let known = style.truth();
    let mut scene = known.scene.clone();
    scene.goals.clear();
    scene.obstacles.clear();
    scene.settle_s = None;
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut state = known.arcs[0].state;
    let mut any3 = || Vector3::from_fn(|_, _| 2.0 * random.random::<f64>() - 1.0);
    state.velocity_m_s += any3() * 0.15;
    state.angular_velocity_rad_s += any3();
    let whole = simulate(&scene, &[], &[state], known.duration_s)?;
    let bounce_s = whole.event_times_s[0];
    let is_clear = |time_s: &f64| {
        let state = whole.state(LinkIndex(0), *time_s);
        let along = state.orientation * Vector3::z();
        state.position_m.z - HALF_M * along.z.abs() > CLEAR_M
    };
    // From three tenths of the flight after the bounce on both ends are up.
    let after_s = known.duration_s - bounce_s;
    let times_s = (30..=100).map(|percent| bounce_s + 0.01 * f64::from(percent) * after_s);
    let until_s = times_s.take_while(is_clear).last();
    let until_s = until_s.ok_or(TruthError::Lacks {
        what: "a second flight",
    })?;
    simulate(&scene, &[], &[state], until_s)
}

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
        let mut normal3 =
            || -> Vector3<f64> { Vector3::from_fn(|_, _| StandardNormal.sample(random)) };
        let position_m = pose.translation.vector + normal3() * self.position_sd_m;
        let orientation = pose.rotation * so3::exp(&(normal3() * self.orientation_sd_rad));
        let pose = Pose::from_parts(position_m.into(), orientation)
            * truth.scene.tracks[track].link_from_tracker;
        let [x, y, z, w]: [f64; 4] = pose.rotation.coords.into();
        PoseSample::new(stamp, pose.translation.vector, [x, y, z, w])
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
            TakeEvent::Pose {
                stream: 0, sample, ..
            } => Some(sample.stamp),
            _ => None,
        });
        // Time zero is the first keyframe.
        let zero_s = first.min().map_or(0.0, |stamp| stamp.seconds_since(START));
        let mut off = Self::default();
        let in_order = |arcs: &[ArcEstimate]| -> Vec<ArcEstimate> {
            let mut arcs = arcs.to_vec();
            arcs.sort_by(|a, b| {
                let by_mechanism = a.mechanism.cmp(&b.mechanism);
                by_mechanism.then(a.start_s.total_cmp(&b.start_s))
            });
            arcs
        };
        let (arcs, found) = (in_order(&truth.arcs), in_order(&estimate.arcs));
        for (arc, found) in arcs.iter().zip(&found) {
            for share in [0.0, 0.5, 1.0] {
                let time_s = arc.start_s + share * (arc.end_s - arc.start_s);
                let state = truth.flown(arc, time_s);
                let since_s = time_s - zero_s - found.epoch_s;
                let body = truth.scene.body_of(found.mechanism);
                let there = flow::advance(body, &truth.scene.gravity_m_s2, &found.state, since_s);
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
