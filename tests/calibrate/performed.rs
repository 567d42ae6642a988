//! Streams of trackers as they are with known truth, from a seed: white noise of the tracker, and of the
//! hand what is correlated in time or vibrates.

#![allow(dead_code)]

use enact::math::Pose;
use enact::math::so3::exp;
use enact::motion::{PoseSample, Stamp};
use nalgebra::{UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

/// What the hand adds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Hand {
    /// Nothing.
    None,
    /// An Ornstein-Uhlenbeck process of this correlation time \[s\].
    Wanders(f64),
    /// A sine of this frequency \[Hz\].
    Vibrates(f64),
}

pub struct Noise {
    random: ChaCha8Rng,
    hand: Hand,
    state: [f64; 3],
    phases: [f64; 3],
}

impl Noise {
    pub fn new(seed: u64, hand: Hand) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut normal = || random.sample::<f64, _>(StandardNormal);
        let state = [normal(), normal(), normal()];
        let phases = [normal(), normal(), normal()].map(|x| x * 3.0);
        Self {
            random,
            hand,
            state,
            phases,
        }
    }

    pub fn white(&mut self) -> Vector3<f64> {
        Vector3::from_fn(|_, _| self.random.sample(StandardNormal))
    }

    pub fn uniform(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.random.random::<f64>()
    }

    /// The hand's next, of standard deviation 1.
    pub fn hand(&mut self, time_s: f64, step_s: f64) -> Vector3<f64> {
        match self.hand {
            Hand::None => Vector3::zeros(),
            Hand::Wanders(constant_s) => {
                let keep = (-step_s / constant_s).exp();
                let fresh = self.white();
                for axis in 0..3 {
                    self.state[axis] =
                        keep * self.state[axis] + (1.0 - keep * keep).sqrt() * fresh[axis];
                }
                self.state.into()
            }
            Hand::Vibrates(rate_hz) => Vector3::from_fn(|axis, _| {
                let turn = std::f64::consts::TAU * rate_hz * (1.0 + 0.1 * axis as f64);
                2_f64.sqrt() * (turn * time_s + self.phases[axis]).sin()
            }),
        }
    }
}

pub fn stamp(time_s: f64) -> Stamp {
    Stamp(1_700_000_000_000_000_000 + (time_s * 1e9).round() as i64)
}

pub fn sample(time_s: f64, position_m: Vector3<f64>, turn: &UnitQuaternion<f64>) -> PoseSample {
    PoseSample::from_pose(stamp(time_s), &Pose::from_parts(position_m.into(), *turn))
}

/// A hand's turning: slow sines about all axes, other ones for every seed.
pub struct Turning {
    terms: Vec<(f64, f64, Vector3<f64>)>,
}

impl Turning {
    pub fn new(noise: &mut Noise, amplitude_rad: f64) -> Self {
        let terms = (0..5).map(|_| {
            let turn = std::f64::consts::TAU * noise.uniform(0.2, 1.1);
            let phase = noise.uniform(0.0, 6.0);
            (turn, phase, noise.white() * amplitude_rad * 0.45)
        });
        Self {
            terms: terms.collect(),
        }
    }

    pub fn at(&self, time_s: f64) -> UnitQuaternion<f64> {
        let terms = self.terms.iter();
        let vector = terms.map(|(turn, phase, axis)| axis * (turn * time_s + phase).sin());
        exp(&vector.sum())
    }
}

pub const TIP_M: Vector3<f64> = Vector3::new(0.012, -0.005, -0.095);
pub const PLACE_M: Vector3<f64> = Vector3::new(0.3, -1.2, 0.75);

/// The tip held in a place for so long at 100 Hz, with a tracker of 0.2 mm and 0.05° and a hand of so much.
pub fn swing(seed: u64, hand: Hand, hand_m: f64, seconds: f64) -> Vec<PoseSample> {
    let mut noise = Noise::new(seed, hand);
    let turning = Turning::new(&mut noise, 0.5);
    let samples = 0..(seconds * 100.0) as usize;
    let samples = samples.map(|at| {
        let time_s = at as f64 * 0.01;
        let turn = turning.at(time_s);
        let slip_m = noise.hand(time_s, 0.01) * hand_m;
        let position_m = PLACE_M + slip_m - turn * TIP_M + noise.white() * 2e-4;
        let seen = turn * exp(&(noise.white() * 0.05_f64.to_radians()));
        sample(time_s, position_m, &seen)
    });
    samples.collect()
}

/// An object at rest, 0.1 mm and 0.02° of white noise beside the hand's or the room's.
pub fn still(
    seed: u64,
    hand: Hand,
    (hand_m, hand_rad): (f64, f64),
    seconds: f64,
) -> Vec<PoseSample> {
    let mut noise = Noise::new(seed, hand);
    let mut other = Noise::new(seed + 1_000_000, hand);
    let turn = exp(&(noise.white() * 0.8));
    let samples = 0..(seconds * 100.0) as usize;
    let samples = samples.map(|at| {
        let time_s = at as f64 * 0.01;
        let position_m = PLACE_M + noise.white() * 1e-4 + noise.hand(time_s, 0.01) * hand_m;
        let error = noise.white() * 0.02_f64.to_radians() + other.hand(time_s, 0.01) * hand_rad;
        sample(time_s, position_m, &(turn * exp(&error)))
    });
    samples.collect()
}

/// Gravity of a tracker whose floor is tilted.
pub const GRAVITY_M_S2: Vector3<f64> = Vector3::new(0.15, -0.08, -9.70);

/// A flight of so many samples at 150 Hz from a time, with noise per axis \[m\], scaled by a factor.
pub fn flight(
    noise: &mut Noise,
    from_s: f64,
    samples: usize,
    (noise_m, scale): (f64, f64),
    centre_m: &Vector3<f64>,
) -> Vec<PoseSample> {
    let velocity = noise.white() * 0.7 + Vector3::new(0.0, 0.0, 1.0);
    let spin = noise.white() * 5.0;
    let begin = exp(&(noise.white() * 0.8));
    let readings = (0..samples).map(|at| {
        let time_s = at as f64 / 150.0;
        let fall = GRAVITY_M_S2 * (0.5 * time_s * time_s);
        let turn = begin * exp(&(spin * time_s));
        let shake = noise.hand(time_s, 1.0 / 150.0) * noise_m;
        let place = PLACE_M + (velocity * time_s + fall) * scale - turn * centre_m;
        let position_m = place + shake + noise.white() * noise_m;
        sample(from_s + time_s, position_m, &turn)
    });
    readings.collect()
}

/// What the second clock of [`turned`] is behind by \[s\] when it begins, and by how much it is slow.
pub const OFFSET_S: f64 = 0.137;
pub const RATE: f64 = 2e-4;

/// Two trackers on one object that is turned, at 100 and 120 Hz, with 0.05° of white noise and a mount's
/// wobble of so much.
pub fn turned(seed: u64, hand: Hand, wobble_rad: f64, seconds: f64) -> [Vec<PoseSample>; 2] {
    let mut noise = Noise::new(seed, hand);
    let turning = Turning::new(&mut noise, 0.6);
    let mount = exp(&noise.white());
    let white_rad = 0.05_f64.to_radians();
    let first = (0..(seconds * 100.0) as usize).map(|at| {
        let time_s = at as f64 * 0.01;
        let turn = turning.at(time_s) * exp(&(noise.white() * white_rad));
        sample(time_s, PLACE_M, &turn)
    });
    let first: Vec<PoseSample> = first.collect();
    let second = (0..(seconds * 120.0) as usize).map(|at| {
        let stamp_s = at as f64 / 120.0;
        let time_s = stamp_s + OFFSET_S + RATE * stamp_s;
        let wobble = noise.hand(stamp_s, 1.0 / 120.0) * wobble_rad;
        let error = exp(&(wobble + noise.white() * white_rad));
        sample(stamp_s, PLACE_M, &(turning.at(time_s) * mount * error))
    });
    let second: Vec<PoseSample> = second.collect();
    [first, second]
}
