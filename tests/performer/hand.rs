//! The performer's hand wanders like a real one: the figures in `tools/perform/wander.rs`, and
//! the same estimator on what is made of them.

use std::path::Path;

use crate::skip::skip;
use enact::math::so3;
use enact_tools::perform::wander::{HAND_ORIENTATION, HAND_POSITION, Spectrum, Wander};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

const RATE_HZ: f64 = 100.0;
/// Samples of a window of the periodogram.
const WINDOW: usize = 1024;

/// Power of a displacement per Hz, over frequency.
struct Power {
    bins: Vec<(f64, f64)>,
}

impl Power {
    /// Welch's estimate from the rates of displacement (differences times the sampling rate):
    /// Hann windows that overlap by half, lines removed, mean over the columns.
    fn of_rates(rates: &[Vector3<f64>]) -> Self {
        let hann: Vec<f64> = (0..WINDOW)
            .map(|i| {
                (std::f64::consts::PI * i as f64 / WINDOW as f64)
                    .sin()
                    .powi(2)
            })
            .collect();
        let gain = 2.0 / (RATE_HZ * hann.iter().map(|w| w * w).sum::<f64>());
        let windows: Vec<_> = rates
            .windows(WINDOW)
            .step_by(WINDOW / 2)
            .map(detrended)
            .collect();
        let bins = (1..=(6.0 / RATE_HZ * WINDOW as f64) as usize)
            .map(|bin| {
                let frequency_hz = bin as f64 * RATE_HZ / WINDOW as f64;
                let power: f64 = windows
                    .iter()
                    .map(|window| {
                        let (mut re, mut im) = (Vector3::zeros(), Vector3::zeros());
                        for (i, (x, w)) in window.iter().zip(&hann).enumerate() {
                            let phase =
                                std::f64::consts::TAU * (bin * i % WINDOW) as f64 / WINDOW as f64;
                            re += x * (w * phase.cos());
                            im += x * (w * phase.sin());
                        }
                        gain * (re.norm_squared() + im.norm_squared()) / 3.0
                    })
                    .sum::<f64>()
                    / windows.len() as f64;
                let difference =
                    2.0 * RATE_HZ * (std::f64::consts::PI * frequency_hz / RATE_HZ).sin();
                (frequency_hz, power / (difference * difference))
            })
            .collect();
        Self { bins }
    }

    /// Exponent of the power law that fits best between two frequencies.
    fn slope(&self, low_hz: f64, high_hz: f64) -> f64 {
        let points: Vec<_> = self
            .bins
            .iter()
            .filter(|(f, _)| (low_hz..high_hz).contains(f))
            .map(|(f, power)| (f.ln(), power.ln()))
            .collect();
        let count = points.len() as f64;
        let (x, y) = points
            .iter()
            .fold((0.0, 0.0), |m, p| (m.0 + p.0 / count, m.1 + p.1 / count));
        let above: f64 = points.iter().map(|p| (p.0 - x) * (p.1 - y)).sum();
        above / points.iter().map(|p| (p.0 - x) * (p.0 - x)).sum::<f64>()
    }

    /// Root mean square of what is faster than a frequency.
    fn rms_above(&self, low_hz: f64) -> f64 {
        let sum: f64 = self
            .bins
            .iter()
            .filter(|(f, _)| *f >= low_hz)
            .map(|(_, power)| power)
            .sum();
        (sum * RATE_HZ / WINDOW as f64).sqrt()
    }
}

fn detrended(window: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    let count = window.len() as f64;
    let at = |i: usize| i as f64 - 0.5 * (count - 1.0);
    let mean = window.iter().sum::<Vector3<f64>>() / count;
    let square: f64 = (0..window.len()).map(|i| at(i) * at(i)).sum();
    let slope = window
        .iter()
        .enumerate()
        .map(|(i, x)| x * at(i))
        .sum::<Vector3<f64>>()
        / square;
    window
        .iter()
        .enumerate()
        .map(|(i, x)| x - mean - slope * at(i))
        .collect()
}

/// Poses at 100 Hz of a real hand-held body; `None` where the measurements are absent.
fn real_hand(test: &str) -> Option<Vec<(Vector3<f64>, UnitQuaternion<f64>)>> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../shared/real/handheld/vicon_handheld_primesense_2.csv");
    let Ok(text) = std::fs::read_to_string(&path) else {
        skip(test, &format!("no {}", path.display()));
        return None;
    };
    let mut rows: Vec<Vec<f64>> = text
        .lines()
        .skip(1)
        .map(|line| {
            line.split(',')
                .map(|field| field.trim().parse().unwrap())
                .collect()
        })
        .collect();
    rows.dedup_by(|later, earlier| later[0] - earlier[0] < 1e-6);
    let pose = |row: &[f64]| {
        let q = Quaternion::new(row[4], row[5], row[6], row[7]);
        (
            Vector3::new(row[1], row[2], row[3]),
            UnitQuaternion::new_normalize(q),
        )
    };
    let count = (rows[rows.len() - 1][0] * RATE_HZ) as usize;
    let at = |index: usize| {
        let time_s = index as f64 / RATE_HZ;
        let after = rows
            .partition_point(|row| row[0] <= time_s)
            .clamp(1, rows.len() - 1);
        let ((x, q), (y, r)) = (pose(&rows[after - 1]), pose(&rows[after]));
        let share = (time_s - rows[after - 1][0]) / (rows[after][0] - rows[after - 1][0]);
        (
            x.lerp(&y, share),
            q * so3::exp(&(so3::log(&(q.inverse() * r)) * share)),
        )
    };
    Some((0..count).map(at).collect())
}

/// Power of position [m²/Hz] and of orientation [rad²/Hz], per axis.
fn real_power(test: &str) -> Option<(Power, Power)> {
    let poses = real_hand(test)?;
    let velocity: Vec<_> = poses
        .windows(2)
        .map(|p| (p[1].0 - p[0].0) * RATE_HZ)
        .collect();
    let turning: Vec<_> = poses
        .windows(2)
        .map(|p| so3::log(&(p[0].1.inverse() * p[1].1)) * RATE_HZ)
        .collect();
    Some((Power::of_rates(&velocity), Power::of_rates(&turning)))
}

/// Power of 60 made-up wanders of unit variance, as long as the real one.
fn made_power(spectrum: &Spectrum) -> Power {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut sum: Vec<(f64, f64)> = Vec::new();
    for _ in 0..20 {
        let axes: [Wander; 3] = std::array::from_fn(|_| Wander::draw(spectrum, &mut rng));
        let at = |index: usize| Vector3::from_fn(|i, _| axes[i].at(index as f64 / RATE_HZ));
        let rates: Vec<_> = (0..3800).map(|i| (at(i + 1) - at(i)) * RATE_HZ).collect();
        let bins = Power::of_rates(&rates).bins;
        sum.resize(bins.len(), (0.0, 0.0));
        for (total, bin) in sum.iter_mut().zip(bins) {
            *total = (bin.0, total.1 + bin.1 / 20.0);
        }
    }
    Power { bins: sum }
}

fn between(value: f64, low: f64, high: f64) {
    assert!(
        (low..=high).contains(&value),
        "{value}, expected {low} to {high}"
    );
}

#[test]
fn a_real_hand_is_as_described() {
    let Some((position, orientation)) = real_power("a_real_hand_is_as_described") else {
        return;
    };
    between(position.slope(0.3, 1.0), -4.1, -3.8);
    between(position.slope(1.2, 4.0), -5.1, -4.8);
    between(position.rms_above(0.2), 0.023, 0.025);
    between(position.rms_above(1.0), 0.0020, 0.0022);
    between(orientation.slope(0.3, 1.0), -3.2, -3.0);
    between(orientation.slope(0.3, 3.0), -3.1, -2.9);
    between(orientation.rms_above(0.2).to_degrees(), 2.5, 2.7);
    between(orientation.rms_above(1.0).to_degrees(), 0.5, 0.6);
}

#[test]
fn a_made_up_hand_is_like_it() {
    let position = made_power(&HAND_POSITION);
    between(position.slope(0.3, 3.0), -4.3, -3.7);
    between(position.rms_above(1.0), 0.08, 0.10);
    let orientation = made_power(&HAND_ORIENTATION);
    between(orientation.slope(0.3, 3.0), -3.3, -2.7);
    between(orientation.rms_above(1.0), 0.18, 0.22);
}

#[test]
fn a_real_tracker_is_quieter_than_the_performances() {
    let Some(poses) = real_hand("a_real_tracker_is_quieter_than_the_performances") else {
        return;
    };
    // Fourth differences of white noise are √70 times as large; the median does not see jumps.
    let mut noise_m: Vec<f64> = poses
        .windows(5)
        .flat_map(|p| {
            let difference = p[0].0 - p[1].0 * 4.0 + p[2].0 * 6.0 - p[3].0 * 4.0 + p[4].0;
            difference.iter().map(|x| x.abs()).collect::<Vec<_>>()
        })
        .collect();
    noise_m.sort_by(f64::total_cmp);
    let sd_m = 1.4826 * noise_m[noise_m.len() / 2] / 70_f64.sqrt();
    between(sd_m, 2.5e-5, 3.5e-5);
}
