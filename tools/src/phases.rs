//! Takes with phases, drawn at random: their truth is made by forces in small steps, or in closed form.
//!
//! Every kind draws its sizes, speeds, coefficients, rate and noise; marks of changes are off by some 20 ms. A hand that acts
//! strays by a process of Matérn's ν = 3/2.

mod hands;
mod on_table;
mod softly;
mod tied;

use std::f64::consts::PI;

use enact::config::scene_from_toml;
use enact::math::so3;
use enact::motion::{Mark, PoseSample, Scene, Stamp, TakeEvent, TrackIndex};
use nalgebra::{UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

/// Gravity of scenes that do not say it [m/s²].
pub const GRAVITY_M_S2: f64 = 9.80665;
/// Step of the simulations \[s\].
pub const STEP_S: f64 = 2e-5;
/// How far marks of changes are off \[s\].
const MARK_SD_S: f64 = 0.02;
/// How far and how fast a hand strays \[m, rad, s\].
const STRAYS: [f64; 3] = [0.008, 0.05, 0.35];

/// What happens in a take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PhaseKind {
    /// A ball slides, then rolls.
    SlideRoll,
    /// A box slides and turns until it rests.
    SlideRest,
    /// A cylinder rolls until it rests.
    RollRest,
    /// A box lands flat, slides and rests.
    Landing,
    /// A rod swings on a nail and is let go.
    LetGo,
    /// A hand throws a box.
    Thrown,
    /// A hand catches a box.
    Caught,
    /// A hand puts a box down.
    PutDown,
    /// A ball bounces off a soft mat.
    SoftBounce,
}

impl PhaseKind {
    /// All.
    pub const ALL: [Self; 9] = [
        Self::SlideRoll,
        Self::SlideRest,
        Self::RollRest,
        Self::Landing,
        Self::LetGo,
        Self::Thrown,
        Self::Caught,
        Self::PutDown,
        Self::SoftBounce,
    ];

    /// Its name in tables.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::SlideRoll => "slides, then rolls",
            Self::SlideRest => "slides, then rests",
            Self::RollRest => "rolls, then rests",
            Self::Landing => "lands flat, slides, rests",
            Self::LetGo => "swings, is let go",
            Self::Thrown => "thrown",
            Self::Caught => "caught",
            Self::PutDown => "put down",
            Self::SoftBounce => "soft bounce",
        }
    }

    /// A take of it, seen by a tracker, or acted by a hand that strays, too.
    pub fn draw(self, seed: u64, is_acted: bool) -> PhasedTake {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(self as u64);
        let made = match self {
            Self::SlideRoll => on_table::slide_roll(&mut random),
            Self::SlideRest => on_table::slide_rest(&mut random),
            Self::RollRest => on_table::roll_rest(&mut random),
            Self::Landing => on_table::landing(&mut random),
            Self::LetGo => tied::let_go(&mut random),
            Self::Thrown => hands::thrown(&mut random),
            Self::Caught => hands::caught(&mut random),
            Self::PutDown => hands::put_down(&mut random),
            Self::SoftBounce => softly::bounced(&mut random),
        };
        PhasedTake::new(made, is_acted, &mut random)
    }
}

/// A pose of a body: centre of mass \[m\], world from body.
pub type TruePose = (Vector3<f64>, UnitQuaternion<f64>);

/// A true motion.
pub struct MadeMotion {
    /// Its scene, but for its name, what its stamps mean and whether a hand acts.
    pub toml: String,
    /// Poses, [`STEP_S`] apart.
    pub poses: Vec<TruePose>,
    /// Marked events between start and end, and when they are \[s\].
    pub changes_s: Vec<(&'static str, f64)>,
    /// Free parameters, and their values.
    pub values: Vec<(&'static str, f64)>,
}

/// A take, and what is true of it.
pub struct PhasedTake {
    /// Where it happens.
    pub scene: Scene,
    /// Poses and marks.
    pub events: Vec<TakeEvent>,
    /// Its events between start and end, by name \[s since the first pose\].
    pub changes_s: Vec<(&'static str, f64)>,
    /// Its free parameters, by name.
    pub values: Vec<(&'static str, f64)>,
}

impl PhasedTake {
    fn new(made: MadeMotion, is_acted: bool, random: &mut ChaCha8Rng) -> Self {
        let rate_hz = [60.0, 90.0, 120.0, 240.0, 360.0][random.random_range(0..5)];
        let sd_m = random.random_range(0.1e-3..0.6e-3);
        let sd_rad = random.random_range(0.001..0.006);
        let end_s = (made.poses.len() - 1) as f64 * STEP_S;
        let count = (end_s * rate_hz) as usize + 1;
        let strays: Vec<Vec<f64>> = (0..6).map(|_| strayed(count, rate_hz, random)).collect();
        let mut noise = |sd: f64| {
            Vector3::from_fn(|_, _| {
                let one: f64 = random.sample(StandardNormal);
                sd * one
            })
        };
        let share = f64::from(u8::from(is_acted));
        let poses = (0..count).map(|index| {
            let now_s = index as f64 / rate_hz;
            let step = (now_s / STEP_S).round() as usize;
            let (position_m, orientation) = made.poses[step.min(made.poses.len() - 1)];
            let [length_m, angle_rad, _] = STRAYS.map(|size| size * share);
            let three = |from: usize| Vector3::from_fn(|axis, _| strays[from + axis][index]);
            let position_m = position_m + three(0) * length_m + noise(sd_m);
            let turned = so3::exp(&(three(3) * angle_rad)) * so3::exp(&noise(sd_rad));
            let q = orientation * turned;
            TakeEvent::Pose {
                track: TrackIndex(0),
                stream: 0,
                sample: PoseSample::new(stamp(now_s), position_m, [q.i, q.j, q.k, q.w]),
            }
        });
        let mut events: Vec<TakeEvent> = poses.collect();
        let last_s = (count - 1) as f64 / rate_hz;
        let mut marks = vec![("go", 0.0), ("end", last_s)];
        for (name, time_s) in &made.changes_s {
            let off: f64 = random.sample(StandardNormal);
            let mark_s = (time_s + MARK_SD_S * off).clamp(0.02, last_s - 0.02);
            marks.push((name, mark_s));
        }
        events.extend(marks.into_iter().map(|(name, time_s)| {
            TakeEvent::Mark(Mark {
                stamp: stamp(time_s),
                event: Some(name.to_owned()),
            })
        }));
        let hand = if is_acted { "" } else { "hand = \"none\"\n" };
        let toml = format!(
            "name = \"phases\"\n{hand}[timing]\nstamps = \"physical\"\n{}",
            made.toml
        );
        Self {
            scene: scene_from_toml(&toml).unwrap_or_else(|error| panic!("{error}\n{toml}")),
            events,
            changes_s: made.changes_s,
            values: made.values,
        }
    }
}

fn stamp(time_s: f64) -> Stamp {
    Stamp(1_000_000_000 + (time_s * 1e9).round() as i64)
}

/// A process of Matérn's ν = 3/2 of unit variance, by the exact steps of its state.
fn strayed(count: usize, rate_hz: f64, random: &mut ChaCha8Rng) -> Vec<f64> {
    let decay_per_s = 3_f64.sqrt() / STRAYS[2];
    let step_s = 1.0 / rate_hz;
    let (faded, turned) = ((-decay_per_s * step_s).exp(), decay_per_s * step_s);
    let by = [
        [faded * (1.0 + turned), faded * step_s],
        [-faded * decay_per_s * turned, faded * (1.0 - turned)],
    ];
    // P − F P Fᵀ with P = diag(1, λ²).
    let p = [1.0, decay_per_s * decay_per_s];
    let q = |i: usize, j: usize| {
        let kept = if i == j { p[i] } else { 0.0 };
        kept - by[i][0] * p[0] * by[j][0] - by[i][1] * p[1] * by[j][1]
    };
    let first = q(0, 0).max(0.0).sqrt();
    let cross = if first > 0.0 { q(0, 1) / first } else { 0.0 };
    let second = (q(1, 1) - cross * cross).max(0.0).sqrt();
    let mut normal = || -> f64 { random.sample(StandardNormal) };
    let mut state = [normal(), decay_per_s * normal()];
    let each = (0..count).map(|_| {
        let now = state[0];
        let (a, b) = (normal(), normal());
        state = [
            by[0][0] * state[0] + by[0][1] * state[1] + first * a,
            by[1][0] * state[0] + by[1][1] * state[1] + cross * a + second * b,
        ];
        now
    });
    each.collect()
}

/// A number between two of one sign, evenly in its logarithm.
fn between(random: &mut ChaCha8Rng, least: f64, most: f64) -> f64 {
    random.random_range(least.ln()..most.ln()).exp()
}

/// A direction.
fn direction(random: &mut ChaCha8Rng) -> Vector3<f64> {
    let z: f64 = random.random_range(-1.0..1.0);
    let angle: f64 = random.random_range(-PI..PI);
    let level = (1.0 - z * z).sqrt();
    Vector3::new(level * angle.cos(), level * angle.sin(), z)
}

/// The lines of an event of a kind.
fn event(name: &str, kind: &str, more: &str) -> String {
    format!("[[event]]\nname = \"{name}\"\nkind = \"{kind}\"\n{more}")
}

/// The lines of a phase of the body on the table.
fn on_table_phase(name: &str, motion: &str, more: &str, ends: [&str; 2]) -> String {
    let [from, until] = ends;
    format!(
        "[[phase]]\nname = \"{name}\"\nmotion = \"{motion}\"\nbody = \"thing\"\nsurface = \"table\"\n{more}from = \"{from}\"\nuntil = \"{until}\"\n"
    )
}

/// The lines of a free quantity.
fn free(name: &str) -> String {
    format!("[[free]]\nquantity = \"{name}\"\n")
}

/// The lines of a body of that shape with what else it is.
fn body(shape: &str, more: &str) -> String {
    format!("[[body]]\nname = \"thing\"\nshape = {shape}\nmass_g = 150\n{more}")
}

const TABLE: &str = "[[surface]]\nname = \"table\"\npoint_mm = [0, 0, 0]\nnormal = [0, 0, 1]\n";
const CHANGE: &str = "body = \"thing\"\n";
