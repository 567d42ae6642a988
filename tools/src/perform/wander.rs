//! How a hand wanders: smooth random functions with the spectrum of a real hand.
//!
//! Measured on a hand-held camera body (Vicon at 100 Hz, 38 s; speeds 3 to 29 cm/s, turning
//! 4 to 46 °/s), Welch periodogram of velocity and body rate, divided by (2πf)², mean per axis:
//!
//! | band \[Hz\] | 0.29–0.40 | 0.40–0.57 | 0.57–0.80 | 0.80–1.12 | 1.12–1.57 | 1.57–2.20 | 2.20–3.09 | 3.09–4.34 |
//! |---|---|---|---|---|---|---|---|---|
//! | position [cm²/Hz] | 19 | 3.5 | 1.0 | 0.24 | 0.031 | 0.0063 | 0.0014 | 0.00021 |
//! | orientation [deg²/Hz] | 22 | 7.7 | 2.3 | 0.91 | 0.20 | 0.083 | 0.050 | 0.014 |
//!
//! There is no corner above 0.2 Hz: both are power laws, position with exponent −4 up to 1.2 Hz
//! (−5 from there to 4 Hz), orientation with −3 (fits over 0.3–1 Hz: −3.9 and −3.1; over 0.3–3
//! Hz: −4.8 and −3.0). What is slower than 0.2 Hz is taken to be intended. The rest is 24 mm and
//! 2.6° rms per axis; its part above 1 Hz is 2.1 mm and 0.55°, that is 9 % and 21 %, where a
//! pure power law from 0.2 Hz has 0.2^1.5 = 9 % and 0.2^1 = 20 %. Beyond 5 Hz the tracker's
//! own noise takes over: 0.03 mm and 0.005° per axis, from third to fifth differences.

use rand::Rng;
use rand_distr::{Distribution, StandardNormal};

/// Sinusoids per function: enough that no two takes look alike, log-spaced over the band.
const LINES: usize = 40;

/// A power law in a band.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spectrum {
    /// Lower end \[Hz\].
    pub low_hz: f64,
    /// Upper end \[Hz\].
    pub high_hz: f64,
    /// Power per Hz goes as frequency to minus this.
    pub slope: f64,
}

/// A hand's position, as measured above.
pub const HAND_POSITION: Spectrum = Spectrum {
    low_hz: 0.2,
    high_hz: 4.0,
    slope: 4.0,
};

/// A hand's orientation, as measured above.
pub const HAND_ORIENTATION: Spectrum = Spectrum {
    low_hz: 0.2,
    high_hz: 4.0,
    slope: 3.0,
};

/// The logarithm of the tempo: Brownian motion in a band (not measured). With a standard
/// deviation of 0.3 its strength is 0.64 per √s; in takes of 2 s, 0.27 of it is variation within
/// the take and 0.14 of the take's mean.
pub const TEMPO: Spectrum = Spectrum {
    low_hz: 0.2,
    high_hz: 1.5,
    slope: 2.0,
};

impl Spectrum {
    /// Power between two frequencies, up to a factor.
    fn power(&self, from_hz: f64, to_hz: f64) -> f64 {
        let exponent = 1.0 - self.slope;
        if exponent == 0.0 {
            (to_hz / from_hz).ln()
        } else {
            (to_hz.powf(exponent) - from_hz.powf(exponent)) / exponent
        }
    }
}

/// A smooth Gaussian random function of mean 0 and variance 1 over seeds.
#[derive(Clone, Debug)]
pub struct Wander {
    /// Angular frequency [rad/s], amplitude of cosine and of sine.
    lines: Vec<[f64; 3]>,
}

impl Wander {
    /// Draws one: every line has random amplitudes and a random place in its part of the band.
    pub fn draw(spectrum: &Spectrum, rng: &mut impl Rng) -> Self {
        let total = spectrum.power(spectrum.low_hz, spectrum.high_hz);
        let ratio = (spectrum.high_hz / spectrum.low_hz).powf(1.0 / LINES as f64);
        let lines = (0..LINES)
            .map(|line| {
                let from_hz = spectrum.low_hz * ratio.powi(line as i32);
                let to_hz = from_hz * ratio;
                let place = rand::RngExt::random::<f64>(rng);
                let frequency_hz = from_hz + place * (to_hz - from_hz);
                let sd = (spectrum.power(from_hz, to_hz) / total).sqrt();
                let mut amplitude = || {
                    let normal: f64 = StandardNormal.sample(rng);
                    sd * normal
                };
                [
                    std::f64::consts::TAU * frequency_hz,
                    amplitude(),
                    amplitude(),
                ]
            })
            .collect();
        Self { lines }
    }

    /// Its value at a time \[s\].
    pub fn at(&self, time_s: f64) -> f64 {
        self.lines
            .iter()
            .map(|[omega_rad_s, cosine, sine]| {
                let (s, c) = (omega_rad_s * time_s).sin_cos();
                cosine * c + sine * s
            })
            .sum()
    }
}
