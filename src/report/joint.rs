//! What an answer from many takes says of itself.

use std::collections::BTreeMap;

use serde::Serialize;

use super::units::for_people;

/// One answer from many takes.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct FitLine {
    /// Takes by which it was made,
    pub takes: usize,
    /// and those that took no part though something was asked of them.
    pub left_out: usize,
    /// What was asked for.
    pub parameters: Vec<FittedLine>,
    /// Correlations of the parameters, row by row, by how takes differ.
    pub correlations: Vec<Vec<f64>>,
    /// Combinations of parameters that the takes together do not determine, in words: these stay where they began.
    pub undetermined: Vec<String>,
    /// Number of rounds in which the takes were asked.
    pub rounds: usize,
    /// How well it does on takes that were held out, if there were any.
    pub held_out: Option<HeldOutLine>,
    /// What speaks against it.
    pub against: Vec<String>,
    /// What to know.
    pub notes: Vec<String>,
    /// The calibration that was written.
    pub output: Option<String>,
    /// The page that was written.
    pub page: Option<String>,
}

/// A parameter that takes share.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct FittedLine {
    /// Its name in scenes.
    pub name: String,
    /// SI unit of all its numbers; empty for ratios.
    pub unit: String,
    /// Whether each take draws its own value: then the others are those of the mean.
    pub is_drawn: bool,
    /// Its value.
    pub value: f64,
    /// Its standard deviation by how takes differ; none where it is not determined, or at a bound.
    pub sd: Option<f64>,
    /// Its interval at 95 %.
    pub interval: Option<[f64; 2]>,
    /// Degrees of freedom of the interval.
    pub freedom: f64,
    /// Whether it is at a bound.
    pub is_at_bound: bool,
    /// Whether the takes together determine it.
    pub is_determined: bool,
    /// What the scene says of it.
    pub in_scene: f64,
    /// How far takes differ in it, where each draws its own.
    pub spread: Option<TakeSpreadLine>,
}

/// A standard deviation over takes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct TakeSpreadLine {
    /// The likeliest.
    pub sd: f64,
    /// Its interval at 95 %, by the likelihood.
    pub interval: [f64; 2],
}

/// The answer on takes that were held out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct HeldOutLine {
    /// Takes that have a motion both with the answer and with the scene's own values.
    pub takes: usize,
    /// Root mean square residuals with the answer,
    pub by_fit: ResidualLine,
    /// and with the scene's own values.
    pub by_scene: ResidualLine,
    /// In how many of them the answer is nearer to the samples, in their weights.
    pub better: usize,
    /// By how much half the sum of squares, in those weights, is less with the answer in the mean,
    pub gain: f64,
    /// with the standard deviation of that mean.
    pub gain_sd: Option<f64>,
    /// Takes that have a motion with the answer alone,
    pub only_by_fit: usize,
    /// and those that have one with the scene's own values alone.
    pub only_by_scene: usize,
}

/// Root mean square residuals per axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct ResidualLine {
    /// Of positions; none where none are seen.
    pub position_m: Option<f64>,
    /// Of orientations.
    pub orientation_rad: Option<f64>,
}

/// What became of a take.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct FitTakeLine {
    /// The file, as it was named.
    pub recording: String,
    /// SHA-256 of it; none where it could not be read.
    pub sha256: Option<String>,
    /// `fitted`, `held_out`, `left_out` where something keeps it from taking part, or `left_alone` where nothing is wrong with
    /// it.
    pub part: &'static str,
    /// Why it takes no part.
    pub why: Option<String>,
    /// What was lost of it, and what to know.
    pub notes: Vec<String>,
    /// Its residual with the answer.
    pub residual: Option<ResidualLine>,
    /// The same with the scene's own values, where it was held out.
    pub residual_by_scene: Option<ResidualLine>,
    /// What it says by itself of what it determines.
    pub own: BTreeMap<String, OwnLine>,
    /// By how much each parameter would change without it.
    pub influence: BTreeMap<String, f64>,
    /// The greatest of these in standard deviations of the answer, and of which parameter.
    pub most_influence: Option<InfluenceLine>,
    /// How far off it is, in robust standard deviations of how far takes are; none where it takes no part.
    pub score: Option<f64>,
    /// Why it stands out, in words.
    pub stands_out: Vec<String>,
}

/// A value that a take says by itself.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct OwnLine {
    /// The value.
    pub value: f64,
    /// Its standard deviation by the take's own residuals.
    pub sd: f64,
}

/// What a take does to the answer.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct InfluenceLine {
    /// Which parameter.
    pub parameter: String,
    /// How many standard deviations.
    pub times: f64,
}

impl FitLine {
    /// Whether nothing speaks against it.
    pub fn is_whole(&self) -> bool {
        self.against.is_empty()
    }
}

impl ResidualLine {
    /// In words for people.
    pub fn words(&self) -> String {
        let parts = [(self.position_m, "m"), (self.orientation_rad, "rad")];
        let parts = parts.iter().filter_map(|(value, unit)| {
            let (factor, unit) = for_people(unit);
            Some(format!("{:.3} {unit}", (*value)? * factor))
        });
        let words = parts.collect::<Vec<_>>().join(", ");
        words.replace(" °", "°")
    }
}
