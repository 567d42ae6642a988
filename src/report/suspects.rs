//! What may be wrong in a scene.

use serde::{Deserialize, Serialize};

use crate::motion::{Scene, Suspect};

/// A quantity that the scene keeps fixed and that would explain some of a misfit. Several of one
/// thing (the components of an offset) are listed together.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct SuspectLine {
    /// Name of the first quantity, as `[[free]]` takes it.
    pub quantity: String,
    /// Its likely value.
    pub value: f64,
    /// Unit of the value; empty for ratios and factors.
    pub unit: String,
    /// Names and likely values of all quantities.
    pub quantities: Vec<(String, f64)>,
    /// Share of the misfit that goes with them, 0 to 1.
    pub explains: f64,
    /// Decrease of Schwarz's criterion (BIC).
    pub gain: f64,
    /// Probability that right values score as high.
    pub probability: f64,
    /// Whether it explains the performance as well as the first, which does not tell which it is.
    pub rivals_first: bool,
}

/// Suspects, the first being the likeliest.
pub(super) fn suspect_lines(scene: &Scene, suspects: &[Suspect]) -> Vec<SuspectLine> {
    let first = suspects.first();
    let suspects = suspects.iter().filter_map(|suspect| {
        let (quantity, value) = *suspect.values.first()?;
        let all = suspect.values.iter();
        let quantities = all.map(|(quantity, value)| (scene.name_of_quantity(*quantity), *value));
        Some(SuspectLine {
            quantity: scene.name_of_quantity(quantity),
            value,
            unit: quantity.unit().to_owned(),
            quantities: quantities.collect(),
            explains: suspect.explains,
            gain: suspect.gain,
            probability: suspect.probability,
            rivals_first: first.is_some_and(|first| first.is_rivalled_by(suspect)),
        })
    });
    suspects.collect()
}
