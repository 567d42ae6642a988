//! Whether a motion explains its performance.

use super::doubt::Place;
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
    /// The test at each event where flights meet or goals hold, in order of time, then that of each
    /// flight that ends at none of them.
    pub parts: Vec<PartFit>,
    /// The test of the motion as a whole, of joined bodies, and where errors are a process in time.
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
    /// How far the place of any joint must be off to be suspected \[m\]: less hides behind noise and wander. None without
    /// joints.
    pub shown_m: Option<f64>,
    /// What samples would tell nothing of, were it wrong.
    pub untold: Vec<Quantity>,
}

/// The test of a part of a motion: whether the flights about an event, each by itself, agree with what must
/// hold there; or whether what is left of a flight by itself has the shape of errors.
#[derive(Clone, Debug, PartialEq)]
pub struct PartFit {
    /// The event or the flight.
    pub place: Place,
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

impl WholeFit {
    /// The tests of two motions as one: that which tells less of each quantity.
    fn with(&self, other: &Self) -> Self {
        let is_first = self.by_noise.probability <= other.by_noise.probability;
        let untold = self.untold.iter().chain(&other.untold);
        Self {
            by_noise: if is_first {
                self.by_noise
            } else {
                other.by_noise
            },
            is_noise: self.is_noise && other.is_noise,
            log_odds_of_wander: self.log_odds_of_wander.min(other.log_odds_of_wander),
            shown_m: self
                .shown_m
                .into_iter()
                .chain(other.shown_m)
                .reduce(f64::max),
            untold: untold.copied().collect(),
        }
    }
}

impl Fit {
    /// Whether two motions explain their performances: both must. `counts` are the numbers of their samples.
    pub fn with(&self, other: &Self, counts: [usize; 2]) -> Self {
        let [own, others] = counts.map(|count| count as f64);
        let both = |own_rms: f64, other_rms: f64| {
            let sum = own * own_rms.powi(2) + others * other_rms.powi(2);
            (sum / (own + others)).sqrt()
        };
        let of_kinds = |a: [f64; 2], b: [f64; 2]| [both(a[0], b[0]), both(a[1], b[1])];
        let wholes = [&self.whole, &other.whole].into_iter().flatten().cloned();
        Self {
            fits: self.fits.max(other.fits),
            joint: of_kinds(self.joint, other.joint),
            alone: of_kinds(self.alone, other.alone),
            parts: self.parts.iter().chain(&other.parts).cloned().collect(),
            whole: wholes.reduce(|one, other| one.with(&other)),
        }
    }

    /// Whether the flights show a wander of the hand somewhere, with so great a logarithm of the odds.
    pub fn shows_wander(&self, log_odds: f64) -> bool {
        let mut parts = self.parts.iter();
        parts.any(|part| part.log_odds_of_wander > log_odds)
    }

    /// Probability that some part's statistic is as improbable under a right model (Bonferroni),
    /// by noise and by a hand's wander; one without parts.
    pub fn probabilities(&self) -> [f64; 2] {
        let count = self.parts.len() as f64;
        let least = |of: fn(&PartFit) -> f64| {
            let least = self.parts.iter().map(of).fold(1.0, f64::min);
            (least * count).min(1.0)
        };
        [
            least(|part| part.by_noise.probability),
            least(|part| part.by_hand.probability),
        ]
    }
}

/// Why nothing tells whether a motion explains its performance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FitUntold {
    /// Nobody asked.
    NotAsked,
    /// There is no motion.
    NoMotion,
    /// The observer ended it before it was told.
    Stopped,
    /// Samples are too few, or tell too little of what may move.
    FewSamples,
    /// Joined bodies move beside others: how often the answer would be right is not known.
    SeveralMove,
    /// Joined bodies move in a tempo that is not known: how often the answer would be right is not known.
    UnknownTempo,
}

impl FitUntold {
    /// The reason, as a sentence without its end.
    pub fn sentence(self) -> &'static str {
        match self {
            FitUntold::NotAsked => "nobody asked whether the motion fits",
            FitUntold::NoMotion => "there is no motion that could fit",
            FitUntold::Stopped => "time ended before it was told whether the motion fits",
            FitUntold::FewSamples => "samples are too few to tell whether the motion fits",
            FitUntold::SeveralMove => {
                "joined bodies move beside others, and of these nothing tells whether the motion fits"
            }
            FitUntold::UnknownTempo => {
                "of joined bodies in a tempo that is not known nothing tells whether the motion fits"
            }
        }
    }
}
