//! Hands that wander otherwise than the performance maker's: rougher, smoother, steadily away, and a
//! real one.
//!
//! Tests include this file too, beside `mod perform;`.

use std::f64::consts::TAU;
use std::path::Path;

use enact::math::{Pose, so3};
use enact::motion::{PoseSample, TakeEvent};
use nalgebra::{Quaternion, Translation3, UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::perform::{Acting, Performance};

/// A way of going astray. Times are those of the physical motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Hand {
    /// Ornstein and Uhlenbeck's process, rough at every scale, with this correlation time \[s\].
    Rough(f64),
    /// Three sinusoids between these frequencies \[Hz\].
    Sinusoids([f64; 2]),
    /// Steadily away from a random offset: straight or along a parabola, alike over the whole take.
    Drift,
    /// A stretch of the hand that a Vicon system saw, without what is slower than two seconds.
    Real,
}

/// Six functions of time: shift and turn.
type Astray = Box<dyn Fn(f64) -> (Vector3<f64>, Vector3<f64>)>;

impl Hand {
    /// Leads every sample of a performance astray, as far as `acting` says the maker's own hand goes.
    ///
    /// `None` where the real hand is not there.
    pub fn lead_astray(self, performance: &mut Performance, acting: &Acting) -> Option<()> {
        let first = performance.events.iter().find_map(stamp_s)?;
        let last = performance.events.iter().rev().find_map(stamp_s)?;
        let length_s = (last - first) / acting.slowdown;
        let bodies = performance.truth.scene.bodies.len();
        let mut astray = Vec::new();
        for body in 0..bodies {
            let mut rng = ChaCha8Rng::seed_from_u64(performance.seed);
            rng.set_stream(1000 + body as u64);
            astray.push(self.draw(acting, length_s, &mut rng)?);
        }
        for event in &mut performance.events {
            let Some(now_s) = stamp_s(event) else {
                continue;
            };
            let TakeEvent::Pose { body, sample, .. } = event else {
                continue;
            };
            let mount = performance.truth.scene.bodies[*body].body_from_tracker;
            let (shift, turn) = astray[*body]((now_s - first) / acting.slowdown);
            let [x, y, z, w] = sample.quaternion_xyzw;
            let rotation = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z));
            let seen = Pose::from_parts(Translation3::from(sample.position_m), rotation);
            let held = seen * mount.inverse();
            let held = Pose::from_parts(
                (held.translation.vector + shift).into(),
                held.rotation * so3::exp(&turn),
            );
            *sample = PoseSample::from_pose(sample.stamp, &(held * mount));
        }
        Some(())
    }

    fn draw(self, acting: &Acting, length_s: f64, rng: &mut ChaCha8Rng) -> Option<Astray> {
        let sizes = [
            acting.wander_position_m / 3_f64.sqrt(),
            acting.wander_orientation_rad / 3_f64.sqrt(),
        ];
        if self == Self::Real {
            return real(
                length_s * acting.slowdown.max(acting.wander_pace),
                length_s,
                rng,
            );
        }
        let axes: Vec<Box<dyn Fn(f64) -> f64>> = (0..6).map(|_| self.axis(length_s, rng)).collect();
        Some(Box::new(move |time_s| {
            let three = |from: usize, size: f64| {
                Vector3::from_fn(|axis, _| size * axes[from + axis](time_s))
            };
            (three(0, sizes[0]), three(3, sizes[1]))
        }))
    }

    /// One function of unit variance.
    fn axis(self, length_s: f64, rng: &mut ChaCha8Rng) -> Box<dyn Fn(f64) -> f64> {
        let mut normal = || -> f64 { StandardNormal.sample(rng) };
        match self {
            Self::Rough(time_s) => {
                const STEP_S: f64 = 1e-3;
                let keep = (-STEP_S / time_s).exp();
                let mut values = vec![normal()];
                for _ in 0..=((length_s / STEP_S) as usize + 2) {
                    let last = values[values.len() - 1];
                    values.push(keep * last + (1.0 - keep * keep).sqrt() * normal());
                }
                Box::new(move |time_s| {
                    let place = (time_s / STEP_S).max(0.0);
                    let at = (place as usize).min(values.len() - 2);
                    let share = place - at as f64;
                    values[at] * (1.0 - share) + values[at + 1] * share
                })
            }
            Self::Sinusoids([low_hz, high_hz]) => {
                let lines: Vec<[f64; 3]> = (0..3)
                    .map(|_| {
                        let (cosine, sine) = (normal(), normal());
                        let share = normal().abs().fract();
                        let frequency_hz = low_hz * (high_hz / low_hz).powf(share);
                        [TAU * frequency_hz, cosine, sine]
                    })
                    .collect();
                Box::new(move |time_s| {
                    let line = |[omega, cosine, sine]: &[f64; 3]| {
                        let (s, c) = (omega * time_s).sin_cos();
                        cosine * c + sine * s
                    };
                    lines.iter().map(line).sum::<f64>() / 3_f64.sqrt()
                })
            }
            Self::Drift => {
                let (offset, slope, bend) = (normal(), normal(), normal());
                Box::new(move |time_s| {
                    let x = 2.0 * time_s / length_s - 1.0;
                    let legendre = 5_f64.sqrt() * 0.5 * (3.0 * x * x - 1.0);
                    (offset + slope * 3_f64.sqrt() * x + bend * legendre) / 3_f64.sqrt()
                })
            }
            Self::Real => unreachable!("it has six axes at once"),
        }
    }
}

fn stamp_s(event: &TakeEvent) -> Option<f64> {
    match event {
        TakeEvent::Pose { sample, .. } => {
            Some((sample.stamp.0 - crate::perform::acting::START.0) as f64 * 1e-9)
        }
        TakeEvent::Mark(_) => None,
    }
}

/// `acted_s` seconds of the real hand, compressed to `length_s`.
fn real(acted_s: f64, length_s: f64, rng: &mut ChaCha8Rng) -> Option<Astray> {
    const RATE_HZ: f64 = 100.0;
    /// Half the window of the moving average that is taken off, in samples.
    const HALF: usize = 100;
    let file = "handheld/vicon_handheld_primesense_2.csv";
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/real");
    let folder = std::env::var_os("ENACT_REAL").map_or(beside, Into::into);
    let text = std::fs::read_to_string(folder.join(file)).ok()?;
    let rows: Vec<Vec<f64>> = text
        .lines()
        .skip(1)
        .map(|line| {
            line.split(',')
                .filter_map(|cell| cell.parse().ok())
                .collect()
        })
        .collect();
    let count = (acted_s * RATE_HZ) as usize + 3;
    let begin = rng.random_range(HALF..rows.len() - count - HALF);
    let wander: Vec<(Vector3<f64>, Vector3<f64>)> = (begin..begin + count)
        .map(|at| {
            let position = |row: &[f64]| Vector3::new(row[1], row[2], row[3]);
            let rotation = |row: &[f64]| {
                UnitQuaternion::new_normalize(Quaternion::new(row[4], row[5], row[6], row[7]))
            };
            let middle = rotation(&rows[at]);
            let window = &rows[at - HALF..=at + HALF];
            let count = window.len() as f64;
            let shift: Vector3<f64> = window.iter().map(|row| position(row)).sum::<Vector3<f64>>();
            let turn: Vector3<f64> = window
                .iter()
                .map(|row| so3::log(&(middle.inverse() * rotation(row))))
                .sum();
            (position(&rows[at]) - shift / count, -turn / count)
        })
        .collect();
    let pace = acted_s / length_s;
    Some(Box::new(move |time_s| {
        let place = (time_s * pace * RATE_HZ).max(0.0);
        let at = (place as usize).min(wander.len() - 2);
        let share = place - at as f64;
        let (a, b) = (wander[at], wander[at + 1]);
        (a.0.lerp(&b.0, share), a.1.lerp(&b.1, share))
    }))
}
