//! Whether a motion explains its performance.

use super::scene::Quantity;

/// Whether the samples agree with the motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Fits {
    /// To within the noise, or a wander of the hand that the flights themselves show.
    Yes,
    /// Beyond the noise: a wander of the hand may explain it, or a wrong model; the performance does
    /// not tell.
    Unknown,
    /// Not: neither noise nor a wander explains it.
    No,
}

impl Fits {
    /// Its name in files and reports.
    pub fn as_str(self) -> &'static str {
        match self {
            Fits::Yes => "yes",
            Fits::Unknown => "unknown",
            Fits::No => "no",
        }
    }
}

/// How well a motion explains its performance.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// The conclusion.
    pub fits: Fits,
    /// Root mean square residual of the motion: position \[m\], orientation \[rad\].
    pub joint: [f64; 2],
    /// The same of every flight by itself, without contacts, impacts and goals; of joined bodies, what white noise makes.
    pub alone: [f64; 2],
    /// The test at each event where flights meet or goals hold, in order of time.
    pub events: Vec<EventFit>,
    /// The test of the motion as a whole, of joined bodies.
    pub whole: Option<WholeFit>,
}

/// The test of whether the samples' errors explain what a motion of joined bodies leaves.
#[derive(Clone, Debug, PartialEq)]
pub struct WholeFit {
    /// Under white noise alone,
    pub by_noise: Tested,
    /// and whether that explains them.
    pub is_noise: bool,
    /// Logarithm of the odds that residuals show a wander.
    pub log_odds_of_wander: f64,
    /// How far the place of any joint must be off to be suspected \[m\]: less hides behind noise and wander.
    pub shown_m: f64,
    /// What samples would tell nothing of, were it wrong.
    pub untold: Vec<Quantity>,
}

/// The test of whether the flights about an event, each by itself, agree with what must hold there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EventFit {
    /// Index into `Scene::events`.
    pub event: usize,
    /// Under white noise alone.
    pub by_noise: Tested,
    /// Under white noise and a wander of the hand.
    pub by_hand: Tested,
    /// Logarithm of the odds that flights by themselves show a wander.
    pub log_odds_of_wander: f64,
}

/// A statistic and how it is distributed under a right model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tested {
    /// Mean square of the standardised disagreements; one is expected.
    pub statistic: f64,
    /// Their number.
    pub freedom: usize,
    /// Degrees of freedom of the noise's estimate.
    pub noise_freedom: usize,
    /// Probability of a larger statistic under a right model (Fisher's distribution).
    pub probability: f64,
}

impl Fit {
    /// Whether the flights show a wander of the hand at an event, with so great a logarithm of the odds.
    pub fn shows_wander(&self, log_odds: f64) -> bool {
        let mut events = self.events.iter();
        events.any(|event| event.log_odds_of_wander > log_odds)
    }

    /// Probability that some event's statistic is as improbable under a right model (Bonferroni),
    /// by noise and by a hand's wander; one without events.
    pub fn probabilities(&self) -> [f64; 2] {
        let count = self.events.len() as f64;
        let least = |of: fn(&EventFit) -> f64| {
            let least = self.events.iter().map(of).fold(1.0, f64::min);
            (least * count).min(1.0)
        };
        [
            least(|event| event.by_noise.probability),
            least(|event| event.by_hand.probability),
        ]
    }
}
