//! How a person acts a motion, and what the tracker makes of it.

use enact::math::{Pose, so3};
use enact::motion::{Mark, PoseSample, Stamp, TakeEvent, Timing};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::acting::{Acting, Outliers};
use super::performance::Performance;
use super::tempo::Tempo;
use super::truth::Truth;
use super::wander::{HAND_ORIENTATION, HAND_POSITION, Wander};

/// What a stream of random numbers is for: a knob changes nothing but what it is about.
#[derive(Clone, Copy)]
enum Role {
    Tempo,
    Marks,
    PositionWander,
    OrientationWander,
    Noise,
    Jitter,
    Dropouts,
    Outliers,
}

fn stream(seed: u64, role: Role, body: usize) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(role as u64 + 16 * body as u64);
    rng
}

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
    let tempo = Tempo::draw(
        truth.duration_s,
        acting.slowdown,
        acting.tempo_variation,
        &mut stream(seed, Role::Tempo, 0),
    );
    let mut truth = truth.clone();
    if acting.is_timing_known() {
        truth.scene.timing = Timing::Known;
    }
    let latency_ns = (acting.latency_s * 1e9).round() as i64;
    let mut arrivals: Vec<(Stamp, TakeEvent)> = marks(&truth, acting, &tempo, seed)
        .into_iter()
        .map(|mark| (Stamp(mark.stamp.0 + latency_ns), TakeEvent::Mark(mark)))
        .collect();
    let mut sample_times_s = Vec::new();
    for body in 0..truth.scene.bodies.len() {
        let mut times_s = Vec::new();
        for shot in track(&truth, acting, &tempo, seed, body) {
            let arrival = Stamp(acting.stamp(shot.acted_s).0 + latency_ns);
            arrivals.push((
                arrival,
                TakeEvent::Pose {
                    body,
                    sample: shot.sample,
                },
            ));
            times_s.push(tempo.physical_s(shot.acted_s));
        }
        sample_times_s.push(times_s);
    }
    // Stable: simultaneous arrivals stay in the order marks, then bodies.
    arrivals.sort_by_key(|(arrival, _)| *arrival);
    let (arrivals, events) = arrivals.into_iter().unzip();
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

/// One reading, and when it was really taken [s, acted].
struct Shot {
    acted_s: f64,
    sample: PoseSample,
}

fn track(truth: &Truth, acting: &Acting, tempo: &Tempo, seed: u64, body: usize) -> Vec<Shot> {
    let hand = Hand::draw(acting, seed, body);
    let mut noise = stream(seed, Role::Noise, body);
    let mut jitter = stream(seed, Role::Jitter, body);
    let mut sight = Sight::new(acting, stream(seed, Role::Dropouts, body));
    let mut jumps = Jumps::new(acting, stream(seed, Role::Outliers, body));
    let body_from_tracker = truth.scene.bodies[body].body_from_tracker;
    let whole_s = acting.hold_before_s + tempo.acted_duration_s() + acting.hold_after_s;
    // A sample that rounding would put just past the end still belongs to it.
    let count = (whole_s * acting.rate_hz + 1e-9).floor() as usize + 1;
    let most_s = 0.45 / acting.rate_hz;
    let mut shots = Vec::new();
    for index in 0..count {
        let acted_s = index as f64 / acting.rate_hz - acting.hold_before_s;
        let true_pose = truth.world_from_body(body, tempo.physical_s(acted_s));
        let seen = acting.measured(
            &(hand.led_astray(&true_pose, acted_s) * body_from_tracker),
            &mut noise,
        );
        let seen = jumps.jumped(&seen);
        let late_s = (acting.stamp_jitter_s * normal(&mut jitter)).clamp(-most_s, most_s);
        // The first sample, zero of all times, is never lost.
        if sight.is_kept() || index == 0 {
            let sample = PoseSample::from_pose(acting.stamp(acted_s + late_s), &seen);
            shots.push(Shot { acted_s, sample });
        }
    }
    shots
}

/// The wander of one body.
struct Hand {
    position: [Wander; 3],
    orientation: [Wander; 3],
    position_m: f64,
    orientation_rad: f64,
    pace: f64,
}

impl Hand {
    fn draw(acting: &Acting, seed: u64, body: usize) -> Self {
        let mut position = stream(seed, Role::PositionWander, body);
        let mut orientation = stream(seed, Role::OrientationWander, body);
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
