//! Takes of one ball that share what is true of it: restitution, friction, gravity and where its tracker is mounted, each
//! the same in all or drawn anew for every take.
//!
//! Their truth is in closed form and not by the program's formulas: a parabola, an even spin, and at the table the impulse of
//! Coulomb's law on a solid sphere, `(1 + e) m v` along the normal and along the table at most `μ` times as much, or as much as
//! ends the slip, `2/7 m u`.

use std::path::{Path, PathBuf};

use anyhow::Result;
use enact::config::scene_from_toml;
use enact::math::so3;
use enact::motion::{Mark, PoseSample, Scene, Stamp, TakeEvent, TrackIndex};
use nalgebra::{UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use crate::perform::recording::write_events_of;

/// Radius of the ball \[m\].
const RADIUS_M: f64 = 0.03;
/// What the scene says, which is not true.
const SAID: [f64; 2] = [0.5, 0.3];

/// A number over takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Over {
    /// Its mean.
    pub mean: f64,
    /// Its standard deviation over takes; zero: the same in all.
    pub sd: f64,
}

impl Over {
    /// The same in all takes.
    pub fn same(mean: f64) -> Self {
        Self { mean, sd: 0.0 }
    }

    fn draw(self, random: &mut ChaCha8Rng) -> f64 {
        let one: f64 = random.sample(StandardNormal);
        self.mean + self.sd * one
    }
}

/// What is true of takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BallTruth {
    /// Restitution.
    pub restitution: Over,
    /// Friction.
    pub friction: Over,
    /// Gravity [m/s²].
    pub gravity_m_s2: Vector3<f64>,
    /// Where the tracker is on the ball \[m\]; the scene has it in the middle.
    pub tracker_m: Vector3<f64>,
    /// White noise of the tracker \[m\], \[rad\].
    pub noise: [f64; 2],
    /// How fast it slides at least, so that it still slides where it leaves the table [m/s].
    pub slides_m_s: f64,
}

impl BallTruth {
    /// What is true of takes of a seed: nothing was tuned on it.
    pub fn drawn(random: &mut ChaCha8Rng) -> Self {
        Self {
            restitution: Over::same(random.random_range(0.3..0.85)),
            friction: Over::same(random.random_range(0.08..0.25)),
            gravity_m_s2: Vector3::new(
                random.random_range(-0.2..0.2),
                random.random_range(-0.2..0.2),
                -9.81 + random.random_range(-0.1..0.1),
            ),
            tracker_m: Vector3::from_fn(|_, _| random.random_range(-0.01..0.01)),
            noise: [
                random.random_range(0.2e-3..0.8e-3),
                random.random_range(0.002..0.008),
            ],
            slides_m_s: 1.5,
        }
    }

    /// What is true of them by the names of free quantities, SI.
    pub fn values(&self) -> Vec<(String, f64)> {
        let laws = [
            ("restitution", self.restitution),
            ("friction", self.friction),
        ];
        let laws = laws.map(|(name, over)| (format!("ball.{name}"), over.mean));
        let axes = ["x", "y", "z"].into_iter().enumerate();
        let vectors = axes.flat_map(|(at, axis)| {
            let gravity = (format!("gravity.{axis}"), self.gravity_m_s2[at]);
            [
                gravity,
                (format!("ball.tracker.{axis}"), self.tracker_m[at]),
            ]
        });
        laws.into_iter().chain(vectors).collect()
    }

    /// The scene of all takes.
    pub fn scene_toml() -> String {
        format!(
            "name = \"a ball that bounces\"\nhand = \"none\"\n[timing]\nstamps = \"physical\"\n\
             [[body]]\nname = \"ball\"\nshape = {{ kind = \"sphere\", radius_mm = {} }}\nmass_g = 110\n\
             restitution = {}\nfriction = {}\n\
             [[surface]]\nname = \"table\"\npoint_mm = [0, 0, 0]\nnormal = [0, 0, 1]\n\
             [[event]]\nname = \"go\"\nkind = \"start\"\n\
             [[event]]\nname = \"bounce\"\nkind = \"collision\"\nbody = \"ball\"\nsurface = \"table\"\n\
             [[event]]\nname = \"end\"\nkind = \"end\"\n",
            RADIUS_M * 1e3,
            SAID[0],
            SAID[1]
        )
    }

    /// One take.
    pub fn take(&self, random: &mut ChaCha8Rng) -> Vec<TakeEvent> {
        let restitution = self.restitution.draw(random).clamp(0.02, 0.98);
        let friction = self.friction.draw(random).max(0.0);
        let along: f64 = random.random_range(-3.1..3.1);
        let speed_m_s = random.random_range(0.5..1.5);
        let level = Vector3::new(along.cos(), along.sin(), 0.0);
        let x = Vector3::new(0.2, -0.1, RADIUS_M + random.random_range(0.3..0.7));
        let v = level * speed_m_s + Vector3::z() * random.random_range(-1.0..0.5);
        let spin: f64 = random.random_range(-1.0..1.0);
        // Against the way it flies: it slides.
        let w = level.cross(&Vector3::z()) * ((speed_m_s + self.slides_m_s) / RADIUS_M)
            + Vector3::new(spin, -spin, 4.0 * spin);
        let g = self.gravity_m_s2;
        let root = (v.z * v.z - 2.0 * g.z * (x.z - RADIUS_M)).sqrt();
        let touch_s = (-v.z - root) / g.z;
        let arriving = v + g * touch_s;
        let (left, turning) = struck(arriving, w, restitution, friction);
        let end_s = touch_s + 0.9 * (-2.0 * left.z / g.z);
        let at = |time_s: f64| {
            let fallen = |x: Vector3<f64>, v: Vector3<f64>, s: f64| x + v * s + g * (0.5 * s * s);
            let turned = |w: Vector3<f64>, s: f64| UnitQuaternion::from_scaled_axis(w * s);
            if time_s < touch_s {
                return (fallen(x, v, time_s), turned(w, time_s));
            }
            let since_s = time_s - touch_s;
            let touched = turned(w, touch_s);
            let there = fallen(fallen(x, v, touch_s), left, since_s);
            (there, turned(turning, since_s) * touched)
        };
        let rate_hz = 120.0;
        let mut normal = || -> f64 { random.sample(StandardNormal) };
        let mut events = Vec::new();
        let count = (end_s * rate_hz) as usize + 1;
        for index in 0..count {
            let (position_m, q) = at(index as f64 / rate_hz);
            let noise = Vector3::from_fn(|_, _| self.noise[0] * normal());
            let turn = Vector3::from_fn(|_, _| self.noise[1] * normal());
            let seen_m = position_m + q * self.tracker_m + noise;
            let q = q * so3::exp(&turn);
            events.push(TakeEvent::Pose {
                track: TrackIndex(0),
                stream: 0,
                sample: PoseSample::new(
                    stamp(index as f64 / rate_hz),
                    seen_m,
                    [q.i, q.j, q.k, q.w],
                ),
            });
        }
        let marked_s = touch_s + 0.008 * normal();
        let last_s = (count - 1) as f64 / rate_hz;
        for (name, time_s) in [("go", 0.0), ("bounce", marked_s), ("end", last_s)] {
            events.push(TakeEvent::Mark(Mark {
                stamp: stamp(time_s),
                event: Some(name.to_owned()),
            }));
        }
        events
    }

    /// A flight alone of that long, seen at the centre.
    pub fn flight(&self, long_s: f64, random: &mut ChaCha8Rng) -> Vec<TakeEvent> {
        let v = Vector3::from_fn(|_, _| random.random_range(-1.0..1.0));
        let w = Vector3::from_fn(|_, _| random.random_range(-8.0..8.0));
        let rate_hz = 120.0;
        let count = (long_s * rate_hz) as usize + 1;
        let mut normal = || -> f64 { random.sample(StandardNormal) };
        let poses = (0..count).map(|index| {
            let now_s = index as f64 / rate_hz;
            let noise = Vector3::from_fn(|_, _| self.noise[0] * normal());
            let turn = Vector3::from_fn(|_, _| self.noise[1] * normal());
            let fallen_m = v * now_s + self.gravity_m_s2 * (0.5 * now_s * now_s);
            let q = UnitQuaternion::from_scaled_axis(w * now_s) * so3::exp(&turn);
            TakeEvent::Pose {
                track: TrackIndex(0),
                stream: 0,
                sample: PoseSample::new(stamp(now_s), fallen_m + noise, [q.i, q.j, q.k, q.w]),
            }
        });
        let mut events: Vec<TakeEvent> = poses.collect();
        let last_s = (count - 1) as f64 / rate_hz;
        for (name, time_s) in [("go", 0.0), ("end", last_s)] {
            events.push(TakeEvent::Mark(Mark {
                stamp: stamp(time_s),
                event: Some(name.to_owned()),
            }));
        }
        events
    }

    /// The scene, and so many takes of a seed.
    pub fn takes(&self, count: usize, random: &mut ChaCha8Rng) -> (Scene, Vec<Vec<TakeEvent>>) {
        let scene = scene_from_toml(&Self::scene_toml());
        let scene = scene.unwrap_or_else(|error| panic!("{error}"));
        let takes = (0..count).map(|_| self.take(random));
        (scene, takes.collect())
    }

    /// The same as recordings in a folder.
    pub fn write(&self, count: usize, seed: u64, folder: &Path) -> Result<Vec<PathBuf>> {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let (scene, takes) = self.takes(count, &mut random);
        let toml = Self::scene_toml();
        let files = takes.iter().enumerate().map(|(at, events)| {
            let path = folder.join(format!("take_{at:04}.mcap"));
            write_events_of(&scene, &toml, events, &path)?;
            Ok(path)
        });
        files.collect()
    }
}

/// Velocity and spin of a solid sphere after it touched the table.
fn struck(
    v: Vector3<f64>,
    w: Vector3<f64>,
    restitution: f64,
    friction: f64,
) -> (Vector3<f64>, Vector3<f64>) {
    let arm = Vector3::z() * -RADIUS_M;
    let slip = v + w.cross(&arm);
    let slip = Vector3::new(slip.x, slip.y, 0.0);
    let pushed = -(1.0 + restitution) * v.z;
    let most = 2.0 / 7.0 * slip.norm();
    let rubbed = match slip.norm() > 0.0 {
        true => -slip.normalize() * (friction * pushed).min(most),
        false => Vector3::zeros(),
    };
    let gyration_m2 = 0.4 * RADIUS_M * RADIUS_M;
    (
        v + Vector3::z() * pushed + rubbed,
        w + arm.cross(&rubbed) / gyration_m2,
    )
}

fn stamp(time_s: f64) -> Stamp {
    Stamp(1_000_000_000 + (time_s * 1e9).round() as i64)
}
