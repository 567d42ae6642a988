//! What is performed.

use enact_tools::case::Case;
use enact_tools::perform::{Acting, Style, Truth, bounces, hat_box};

use super::SEEDS;
use crate::options::Options;

/// Marks are off by no more than a sample at this rate, whatever the tracker's.
const MARK_RATE_HZ: f64 = 120.0;

/// A scene, acted in one way.
#[derive(Clone, Copy)]
pub struct Scene {
    /// In words.
    pub name: &'static str,
    pub is_timing_known: bool,
    truth: fn(u64) -> Option<Truth>,
}

/// All of them.
pub const SCENES: [Scene; 4] = [
    Scene {
        name: "pencil, timing known",
        is_timing_known: true,
        truth: |_| Some(Style::Tip.truth()),
    },
    Scene {
        name: "pencil, timing unknown",
        is_timing_known: false,
        truth: |_| Some(Style::Tip.truth()),
    },
    Scene {
        name: "cube, four bounces, timing known",
        is_timing_known: true,
        truth: |seed| bounces(4, seed).ok(),
    },
    Scene {
        name: "hat and box, timing known",
        is_timing_known: true,
        truth: |_| Some(hat_box::truth()),
    },
];

impl Scene {
    /// All performances before such a tracker, by such a hand.
    pub fn cases(&self, options: &Options, (rate_hz, distortion): (f64, f64)) -> Vec<Case> {
        let seeds = options.seeds(SEEDS);
        let cases = seeds.filter_map(|seed| self.case(rate_hz, distortion, seed));
        cases.collect()
    }

    /// A performance before a tracker of that rate, by a hand that wanders so many times as usual.
    fn case(&self, rate_hz: f64, distortion: f64, seed: u64) -> Option<Case> {
        let mut truth = (self.truth)(seed)?;
        let acting = if self.is_timing_known {
            let acting = Acting::timing_known();
            // What is said of marks does not depend on the tracker.
            truth.scene.mark_sd_s = Some(0.5 / MARK_RATE_HZ);
            acting
        } else {
            Acting::default()
        };
        let acting = Acting {
            rate_hz,
            distortion,
            stamp_jitter_s: acting.stamp_jitter_s.min(0.05 / rate_hz),
            ..acting
        };
        Some(Case::new(&truth, &acting, seed))
    }
}
