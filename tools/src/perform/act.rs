//! How a person acts a motion, and what the tracker makes of it.

use enact::math::{Pose, so3};
use enact::motion::{EventKind, Mark, PoseSample, Stamp, TakeEvent, Timing, TrackIndex};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use rand::{Rng, RngExt};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use typed_index_collections::TiVec;

use super::acting::{Acting, Outliers};
use super::kink::Kinks;
use super::performance::Performance;
use super::streams::{Role, stream};
use super::tempo::Tempo;
use super::truth::Truth;
use super::wander::{HAND_ORIENTATION, HAND_POSITION, Wander};

/// Streams of random numbers per track: more than an edited sketch has segments.
const STREAMS: usize = 64;

fn normal(rng: &mut impl Rng) -> f64 {
    StandardNormal.sample(rng)
}

fn normal3(rng: &mut impl Rng) -> Vector3<f64> {
    Vector3::from_fn(|_, _| normal(rng))
}

/// Normal, cut off at two standard deviations: drawn again beyond.
fn normal_within_two(rng: &mut impl Rng) -> f64 {
    loop {
        let value = normal(rng);
        if value.abs() <= 2.0 {
            return value;
        }
    }
}

/// Acts a true motion. The same arguments give the same performance, bit for bit.
pub fn perform(truth: &Truth, acting: &Acting, seed: u64) -> Performance {
    let mut truth = truth.clone();
    let is_edited = truth.scene.timing == Timing::Edited;
    // The segments of an edited sketch are off by themselves.
    let variation = if is_edited {
        0.0
    } else {
        acting.tempo_variation
    };
    let tempo = Tempo::draw(
        truth.duration_s,
        acting.slowdown,
        variation,
        &mut stream(seed, Role::Tempo, 0),
    );
    if acting.is_timing_known() && !is_edited {
        truth.scene.timing = Timing::Known;
        // The performer's mark of an end is off; what must hold there holds at the true time.
        let goals = truth.scene.goals.iter();
        let mut ends: Vec<usize> = goals.map(|goal| goal.event).collect();
        ends.retain(|event| truth.scene.events[*event].kind == EventKind::End);
        for event in ends {
            truth.scene.events[event].time.is_free = Some(true);
        }
    }
    let mut deliveries: Vec<Delivery> = Vec::new();
    if !is_edited {
        let marks = marks(&truth, acting, &tempo, seed).into_iter();
        deliveries.extend(marks.map(|mark| (mark.stamp, TakeEvent::Mark(mark), None)));
    }
    for track in truth.scene.tracks.keys() {
        if is_edited {
            deliveries.append(&mut edit(&truth, acting, seed, track));
        } else {
            deliveries.append(&mut tracked(&truth, acting, &tempo, seed, track));
        }
    }
    // Stable: simultaneous arrivals stay in the order marks, then tracks.
    deliveries.sort_by_key(|(measured, ..)| *measured);
    let latency_ns = (acting.latency_s * 1e9).round() as i64;
    let mut sample_times_s: TiVec<TrackIndex, _> =
        vec![Vec::new(); truth.scene.tracks.len()].into();
    let (mut events, mut arrivals) = (Vec::new(), Vec::new());
    for (measured, event, time_s) in deliveries {
        if let (TakeEvent::Pose { track, .. }, Some(time_s)) = (&event, time_s) {
            sample_times_s[*track].push(time_s);
        }
        events.push(event);
        arrivals.push(Stamp(measured.0 + latency_ns));
    }
    Performance {
        truth,
        acting: *acting,
        seed,
        tempo,
        events,
        arrivals,
        sample_times_s,
    }
}

/// When it was measured, what was delivered, and the hidden physical time of a sample \[s\].
type Delivery = (Stamp, TakeEvent, Option<f64>);

fn marks(truth: &Truth, acting: &Acting, tempo: &Tempo, seed: u64) -> Vec<Mark> {
    let mut rng = stream(seed, Role::Marks, 0);
    let events = truth.scene.events.iter().zip(&truth.event_times_s);
    events
        .map(|(event, time_s)| {
            let error_s = acting.mark_error_s * normal_within_two(&mut rng);
            Mark {
                stamp: acting.stamp(tempo.acted_s(*time_s) + error_s),
                event: acting.marks_named.then(|| event.name.clone()),
            }
        })
        .collect()
}

/// What a tracker makes of the whole motion of its link.
fn tracked(
    truth: &Truth,
    acting: &Acting,
    tempo: &Tempo,
    seed: u64,
    track: TrackIndex,
) -> Vec<Delivery> {
    // Trackers are not in step: the others fall anywhere between two samples of the first.
    let late = if track == TrackIndex(0) {
        0.0
    } else {
        stream(seed, Role::Phase, track.into()).random()
    };
    let phase_s = late / acting.rate_hz;
    let whole_s = acting.hold_before_s + tempo.acted_duration_s() + acting.hold_after_s;
    let film = Film {
        acting,
        seed,
        channel: track.into(),
        begin_s: phase_s - acting.hold_before_s,
        length_s: whole_s - phase_s,
    };
    let of = &truth.scene.tracks[track];
    let kinks = Kinks::of(truth, of.link, tempo, acting.kink_s);
    let poses = |acted_s: f64| {
        let truly = truth.world_from_body(of.link, tempo.physical_s(acted_s));
        kinks.rounded(truly, acted_s)
    };
    let shots = film.shots(&of.link_from_tracker, poses).into_iter();
    let delivery = |(acted_s, sample)| {
        let pose = TakeEvent::Pose {
            track,
            stream: 0,
            sample,
        };
        (acting.stamp(acted_s), pose, Some(tempo.physical_s(acted_s)))
    };
    shots.map(delivery).collect()
}

/// What an editor makes of a link's flights, one by one: each begins at the same stamp, wanders
/// by itself, and takes a little more or less than its time.
fn edit(truth: &Truth, acting: &Acting, seed: u64, track: TrackIndex) -> Vec<Delivery> {
    let mount = truth.scene.tracks[track].link_from_tracker;
    let mechanism = truth.scene.mechanism_seen_by(track);
    let flights = truth.arcs.iter().filter(|arc| arc.mechanism == mechanism);
    let mut deliveries = Vec::new();
    for (number, arc) in flights.enumerate() {
        let channel = usize::from(track) + STREAMS * number;
        let pace = normal(&mut stream(seed, Role::Tempo, channel));
        let slowdown = acting.slowdown * (acting.tempo_variation * pace).exp();
        let time_s = |acted_s: f64| arc.start_s + acted_s / slowdown;
        let film = Film {
            acting,
            seed,
            channel,
            begin_s: 0.0,
            length_s: (arc.end_s - arc.start_s) * slowdown,
        };
        let poses = |acted_s: f64| truth.flown(arc, time_s(acted_s)).world_from_body();
        for (acted_s, sample) in film.shots(&mount, poses) {
            let pose = TakeEvent::Pose {
                track,
                stream: number,
                sample,
            };
            deliveries.push((acting.stamp(acted_s), pose, Some(time_s(acted_s))));
        }
    }
    deliveries
}

/// A stretch of acted time before one tracker.
struct Film<'a> {
    acting: &'a Acting,
    seed: u64,
    channel: usize,
    begin_s: f64,
    length_s: f64,
}

impl Film<'_> {
    /// Readings, and when they were really taken [s, acted].
    fn shots(
        &self,
        link_from_tracker: &Pose,
        world_from_body: impl Fn(f64) -> Pose,
    ) -> Vec<(f64, PoseSample)> {
        let (acting, seed, channel) = (self.acting, self.seed, self.channel);
        let hand = Hand::draw(acting, seed, channel);
        let mut noise = stream(seed, Role::Noise, channel);
        let mut jitter = stream(seed, Role::Jitter, channel);
        let mut sight = Sight::new(acting, stream(seed, Role::Dropouts, channel));
        let mut jumps = Jumps::new(acting, stream(seed, Role::Outliers, channel));
        // A sample that rounding would put just past the end still belongs to it.
        let count = (self.length_s * acting.rate_hz + 1e-9).floor() as usize + 1;
        let most_s = 0.45 / acting.rate_hz;
        let mut shots = Vec::new();
        for index in 0..count {
            let acted_s = index as f64 / acting.rate_hz + self.begin_s;
            let true_pose = world_from_body(acted_s);
            let seen = acting.measured(
                &(hand.led_astray(&true_pose, acted_s) * link_from_tracker),
                &mut noise,
            );
            let seen = jumps.jumped(&seen);
            let late_s = (acting.stamp_jitter_s * normal(&mut jitter)).clamp(-most_s, most_s);
            // The first sample, zero of all times, is never lost.
            if sight.is_kept() || index == 0 {
                let sample = PoseSample::from_pose(acting.stamp(acted_s + late_s), &seen);
                shots.push((acted_s, sample));
            }
        }
        shots
    }
}

/// The wander of one tracker.
struct Hand {
    position: [Wander; 3],
    orientation: [Wander; 3],
    position_m: f64,
    orientation_rad: f64,
    pace: f64,
}

impl Hand {
    fn draw(acting: &Acting, seed: u64, channel: usize) -> Self {
        let mut position = stream(seed, Role::PositionWander, channel);
        let mut orientation = stream(seed, Role::OrientationWander, channel);
        let per_axis = acting.distortion / 3_f64.sqrt();
        Self {
            position: std::array::from_fn(|_| Wander::draw(&HAND_POSITION, &mut position)),
            orientation: std::array::from_fn(|_| Wander::draw(&HAND_ORIENTATION, &mut orientation)),
            position_m: per_axis * acting.wander_position_m,
            orientation_rad: per_axis * acting.wander_orientation_rad,
            pace: acting.wander_pace,
        }
    }

    /// Where the hand holds the body instead, at an acted time.
    fn led_astray(&self, world_from_body: &Pose, acted_s: f64) -> Pose {
        let at = |axes: &[Wander; 3]| Vector3::from_fn(|i, _| axes[i].at(self.pace * acted_s));
        let shift = at(&self.position) * self.position_m;
        let turn = so3::exp(&(at(&self.orientation) * self.orientation_rad));
        Pose::from_parts(
            (world_from_body.translation.vector + shift).into(),
            world_from_body.rotation * turn,
        )
    }
}

/// Whether the tracker sees its target: a chain of two states.
struct Sight {
    rng: ChaCha8Rng,
    lose: f64,
    find: f64,
    is_lost: bool,
}

impl Sight {
    fn new(acting: &Acting, rng: ChaCha8Rng) -> Self {
        let (find, rate) = (1.0 / acting.dropout_burst, acting.dropout_rate);
        Self {
            rng,
            lose: (find * rate / (1.0 - rate)).min(1.0),
            find,
            is_lost: false,
        }
    }

    fn is_kept(&mut self) -> bool {
        let chance = if self.is_lost { self.find } else { self.lose };
        if self.rng.random::<f64>() < chance {
            self.is_lost = !self.is_lost;
        }
        !self.is_lost
    }
}

/// Where the tracker jumps instead.
struct Jumps {
    rng: ChaCha8Rng,
    outliers: Option<Outliers>,
    /// Jumps still to come of this burst, last first.
    burst: Vec<(Vector3<f64>, Vector3<f64>)>,
}

impl Jumps {
    /// Mean length of a burst.
    const BURST: f64 = 2.0;

    fn new(acting: &Acting, rng: ChaCha8Rng) -> Self {
        Self {
            rng,
            outliers: acting.outliers,
            burst: Vec::new(),
        }
    }

    fn jumped(&mut self, world_from_tracker: &Pose) -> Pose {
        let Some(outliers) = self.outliers else {
            return *world_from_tracker;
        };
        if self.burst.is_empty() {
            let chance = outliers.share / (Self::BURST * (1.0 - outliers.share));
            if self.rng.random::<f64>() >= chance {
                return *world_from_tracker;
            }
            self.burst = self.draw(&outliers);
        }
        let (shift, turn) = self.burst.pop().unwrap_or_default();
        Pose::from_parts(
            (world_from_tracker.translation.vector + shift).into(),
            world_from_tracker.rotation * so3::exp(&turn),
        )
    }

    fn draw(&mut self, outliers: &Outliers) -> Vec<(Vector3<f64>, Vector3<f64>)> {
        let rng = &mut self.rng;
        let length = rng.random_range(1..=3_usize);
        let is_one_jump = rng.random::<bool>();
        let what = rng.random_range(0..3);
        let size = |[least, greatest]: [f64; 2], rng: &mut ChaCha8Rng| {
            let size = least * (greatest / least).powf(rng.random::<f64>());
            normal3(rng).normalize() * size
        };
        let mut burst: Vec<_> = (0..length)
            .map(|_| {
                let shift = size(outliers.position_m, rng) * f64::from(u8::from(what != 1));
                let turn = size(outliers.orientation_rad, rng) * f64::from(u8::from(what != 2));
                (shift, turn)
            })
            .collect();
        if is_one_jump {
            let jump = burst[0];
            burst.fill(jump);
        }
        burst
    }
}

impl Acting {
    /// What the tracker makes of a pose: noise, rounding, and the quaternion of positive `w`.
    fn measured(&self, world_from_tracker: &Pose, rng: &mut impl Rng) -> Pose {
        let shift = normal3(rng) * self.noise_position_m;
        let turn = so3::exp(&(normal3(rng) * self.noise_orientation_rad));
        let position_m = world_from_tracker.translation.vector + shift;
        let q = (world_from_tracker.rotation * turn).into_inner();
        let q = if q.w < 0.0 { -q } else { q };
        Pose::from_parts(
            position_m.map(|x| rounded(x, self.resolution_m)).into(),
            unit(q.coords.map(|x| rounded(x, self.resolution_quaternion))),
        )
    }
}

/// To the nearest multiple, so that the last bits of sines, which differ between platforms, do
/// not reach the recording.
fn rounded(value: f64, resolution: f64) -> f64 {
    if resolution > 0.0 {
        (value / resolution).round() * resolution
    } else {
        value
    }
}

fn unit(xyzw: nalgebra::Vector4<f64>) -> UnitQuaternion<f64> {
    UnitQuaternion::new_normalize(Quaternion::from_vector(xyzw))
}
