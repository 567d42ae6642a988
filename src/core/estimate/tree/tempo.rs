//! The tempo in which a motion of trees is acted, where stamps are no physical times (paper §4.3).
//!
//! Between knots `a_k` of acted time physical time `t` goes on at a steady *pace*, of which the logarithm `λ_k` is an
//! unknown, so that time never runs back:
//!
//! ```text
//! t(a) = t_0 + Σ_{i<k} e^{λ_i} (a_{i+1} − a_i) + e^{λ_k} (a − a_k)
//! ```
//!
//! The prior is that of bodies by themselves ([`crate::estimate::terms::tempo`]), `λ` a Brownian motion of strength `σ`. In
//! these unknowns it is linear, and where nothing is seen yet, the pace goes on as it was:
//!
//! ```text
//! r = (λ_{k+1} − λ_k) / (σ √½(Δa_k + Δa_{k+1}))
//! ```

use super::sample::TreeSample;
use crate::estimate::posing::nodes;
use crate::motion::{Scene, Timing};

/// Distance of knots \[s, acted\]: within it a hand's tempo hardly changes.
const SPACING_S: f64 = 0.1;
/// Greatest number of pieces between them: in a longer take they are farther apart.
const PIECES_MOST: usize = 64;

/// Where the pace of a motion may change, and how much it does.
#[derive(Clone, Debug)]
pub struct Tempo {
    /// Knots in order \[s, acted\]: the beginning and the end of the motion, and some between.
    pub knots_s: Vec<f64>,
    /// Standard deviation of the log-pace's change after one acted second.
    pub sd_per_sqrt_s: f64,
    /// How often it counts, where samples count once.
    pub counted: f64,
    /// First guess of the pace, physical time per acted time.
    pub guess: f64,
}

impl Tempo {
    /// That of a scene with a span \[s, acted\]; `None` where stamps are physical times.
    pub(super) fn of_scene(
        scene: &Scene,
        [from_s, to_s]: [f64; 2],
        samples: &[TreeSample],
    ) -> Option<Self> {
        let Timing::Unknown {
            tempo_sd_per_sqrt_s,
        } = scene.timing
        else {
            return None;
        };
        let lasts_s = to_s - from_s;
        let pieces = ((lasts_s / SPACING_S).ceil() as usize).clamp(1, PIECES_MOST);
        let knot_s = |knot: usize| from_s + lasts_s * knot as f64 / pieces as f64;
        let mut times_s: Vec<f64> = samples.iter().map(|sample| sample.acted_s).collect();
        times_s.dedup();
        // In a faster stream the prior weighs as many times as there are more samples, so that these do not make it say
        // less.
        let crowd = times_s.len() as f64 * nodes::SPACING_S / lasts_s;
        Some(Self {
            knots_s: (0..=pieces).map(knot_s).collect(),
            sd_per_sqrt_s: tempo_sd_per_sqrt_s,
            counted: crowd.max(1.0),
            guess: 1.0,
        })
    }

    /// Number of its unknowns.
    pub fn pieces(&self) -> usize {
        self.knots_s.len() - 1
    }

    /// Deviation of the difference of the log-paces of a piece and the next.
    pub(super) fn change_sd(&self, piece: usize) -> f64 {
        let knots_s = &self.knots_s;
        let apart_s = 0.5 * (knots_s[piece + 2] - knots_s[piece]);
        self.sd_per_sqrt_s * (apart_s / self.counted).sqrt()
    }
}
