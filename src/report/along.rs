//! Quantities along a flight or a phase, in a few numbers.

use serde::{Deserialize, Serialize};

use crate::motion::ArcEstimate;

/// Instants of a flight that count for a line: at equal steps, its ends among them.
const INSTANTS: usize = 21;

/// Those instants \[s\].
pub(super) fn instants_s(arc: &ArcEstimate) -> impl Iterator<Item = f64> + use<> {
    let (from_s, length_s) = (arc.start_s, arc.end_s - arc.start_s);
    let last = (INSTANTS - 1) as f64;
    (0..INSTANTS).map(move |step| from_s + length_s * (step as f64 / last))
}

/// Significant digits.
const DIGITS: i32 = 4;

/// A quantity along a flight or a phase; none where it is not known all the way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct AlongLine {
    /// Half of the time it is less.
    pub median: Option<f64>,
    /// The largest.
    pub largest: Option<f64>,
    /// At the beginning,
    pub at_start: Option<f64>,
    /// and at the end.
    pub at_end: Option<f64>,
}

impl AlongLine {
    pub(super) fn new(values: Option<Vec<f64>>) -> Self {
        let Some(values) = values else {
            return Self::default();
        };
        let mut sorted = values.clone();
        sorted.sort_by(f64::total_cmp);
        let of = |values: &[f64], at: usize| values.get(at).copied().and_then(rounded);
        let last = values.len().saturating_sub(1);
        Self {
            median: of(&sorted, sorted.len() / 2),
            largest: of(&sorted, last),
            at_start: of(&values, 0),
            at_end: of(&values, last),
        }
    }
}

/// To [`DIGITS`] digits; none of what is no number.
pub(super) fn rounded(value: f64) -> Option<f64> {
    if value == 0.0 || !value.is_finite() {
        return value.is_finite().then_some(value);
    }
    let text = format!("{value:.*e}", (DIGITS - 1) as usize);
    text.parse().ok()
}
