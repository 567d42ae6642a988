//! Whether a motion explains its performance.

use super::scene::Quantity;

/// Whether the samples agree with the motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Fits {
    /// To within the noise, or a wander of the hand.
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
    /// What noise makes of it.
    pub noise: [f64; 2],
    /// The test of white noise alone against noise and a wander,
    pub by_noise: Tested,
    /// and whether noise alone explains all residuals.
    pub is_noise: bool,
    /// Whether the motion was found with the errors of a hand.
    pub is_of_hand: bool,
    /// How far the place of any joint must be off to be suspected \[m\]: less hides behind noise and wander. None without
    /// joints.
    pub shown_m: Option<f64>,
    /// What samples would tell nothing of, were it wrong.
    pub untold: Vec<Quantity>,
}

/// A ratio of likelihoods and how it is distributed under the narrower model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tested {
    /// Twice the logarithm of the ratio.
    pub statistic: f64,
    /// By how many numbers the wider model has more.
    pub freedom: usize,
    /// Probability of a larger statistic (χ²).
    pub probability: f64,
}

impl Fit {
    /// Whether two motions explain their performances: both must. Of the tests that is kept which tells less. `counts` are the
    /// numbers of their samples.
    pub fn with(&self, other: &Self, counts: [usize; 2]) -> Self {
        let [own, others] = counts.map(|count| count as f64);
        let both = |own_rms: f64, other_rms: f64| {
            let sum = own * own_rms.powi(2) + others * other_rms.powi(2);
            (sum / (own + others)).sqrt()
        };
        let of_kinds = |a: [f64; 2], b: [f64; 2]| [both(a[0], b[0]), both(a[1], b[1])];
        let is_first = self.by_noise.probability <= other.by_noise.probability;
        let untold = self.untold.iter().chain(&other.untold);
        let shown_m = self.shown_m.into_iter().chain(other.shown_m);
        Self {
            fits: self.fits.max(other.fits),
            joint: of_kinds(self.joint, other.joint),
            noise: of_kinds(self.noise, other.noise),
            by_noise: if is_first {
                self.by_noise
            } else {
                other.by_noise
            },
            is_noise: self.is_noise && other.is_noise,
            is_of_hand: self.is_of_hand || other.is_of_hand,
            shown_m: shown_m.reduce(f64::max),
            untold: untold.copied().collect(),
        }
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
    /// Samples whose times are not known are too many for their errors to be told.
    ManySamples,
    /// Joined bodies move in a tempo that is not known: there too many right scenes would be said not to fit.
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
            FitUntold::ManySamples => {
                "samples in a tempo that is not known are too many to tell whether the motion fits"
            }
            FitUntold::UnknownTempo => {
                "of joined bodies in a tempo that is not known nothing tells whether the motion fits"
            }
        }
    }
}
