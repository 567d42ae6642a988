//! Results of calibrations in the units of their files.

use crate::calibrate::{CONFIDENCE, Measured, Spread};
use crate::config::{CalibratedQuantity, Calibration, SceneValues};

use super::streams::Read;

/// Digits after the point of numbers in millimetres, degrees and the like.
const DIGITS: f64 = 1e6;

/// Rounded to a millionth: less than any tracker knows.
pub(super) fn rounded(number: f64) -> f64 {
    let round = (number * DIGITS).round() / DIGITS;
    if round.is_finite() {
        round + 0.0
    } else {
        number
    }
}

/// Three numbers, rounded.
pub(super) fn triple(numbers: impl IntoIterator<Item = f64>) -> [f64; 3] {
    let mut numbers = numbers.into_iter();
    std::array::from_fn(|_| numbers.next().map_or(0.0, rounded))
}

/// What was measured, with its interval where it has one.
pub(super) fn measured(name: &str, unit: &str, of: &Measured) -> CalibratedQuantity {
    let ends = |sign: f64| -> Vec<f64> {
        let ends = of.value.iter().zip(&of.half);
        ends.map(|(value, half)| rounded(value + sign * half))
            .collect()
    };
    CalibratedQuantity {
        name: name.to_owned(),
        unit: unit.to_owned(),
        value: of.value.iter().map(|value| rounded(*value)).collect(),
        lower: ends(-1.0),
        upper: ends(1.0),
    }
}

/// Numbers without an interval.
pub(super) fn plain(name: &str, unit: &str, value: &[f64]) -> CalibratedQuantity {
    CalibratedQuantity {
        name: name.to_owned(),
        unit: unit.to_owned(),
        value: value.iter().map(|value| rounded(*value)).collect(),
        lower: Vec::new(),
        upper: Vec::new(),
    }
}

/// A calibration that says nothing yet.
pub(super) fn begun(kind: &str, reads: &[Read]) -> Calibration {
    Calibration {
        kind: kind.to_owned(),
        program: concat!("enact ", env!("CARGO_PKG_VERSION")).to_owned(),
        confidence: CONFIDENCE,
        against: Vec::new(),
        notes: reads.iter().flat_map(Read::notes).collect(),
        recording: reads.iter().flat_map(Read::sources).collect(),
        quantity: Vec::new(),
        scene: SceneValues::default(),
    }
}

/// Says where blocks of time are not independent.
pub(super) fn say_spread(calibration: &mut Calibration, spread: &Spread) {
    calibration.quantity.push(plain(
        "correlation time of the residuals",
        "samples",
        &[spread.correlation],
    ));
    if spread.is_slow {
        calibration.against.push(format!(
            "the residuals are correlated over {:.0} samples, too much of the recording: intervals \
             are too narrow; record for longer, or hold the tip more firmly",
            spread.correlation
        ));
    }
}
