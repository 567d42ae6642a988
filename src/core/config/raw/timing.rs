//! What stamps mean, and how far a performance is from what was meant.

use schemars::JsonSchema;
use serde::Deserialize;

use super::value::{Number, Text};

/// What the stamps of samples mean.
///
/// ```toml
/// [timing]
/// stamps = "tempo"
/// mark_sd_ms = 30
/// ```
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a table with `stamps`")]
#[schemars(rename = "timing")]
pub(in crate::config) struct RawTiming {
    /// "physical": the times are those of the motion; "tempo": it was acted in a tempo that is not
    /// known; "edited": every flight is on a topic of its own, `<topic>/1`, `<topic>/2`, …, with times
    /// from any zero.
    pub(in crate::config) stamps: Text,
    /// How much a tempo wavers, as the standard deviation of its logarithm after one second. Default:
    /// 0.5.
    pub(in crate::config) tempo_sd_per_sqrt_s: Option<Number>,
    /// Standard deviation of marks. Default: of collisions where stamps are physical half a sample's interval, and
    /// at least 4.2; of others 50.
    pub(in crate::config) mark_sd_ms: Option<Number>,
}

/// How far a performance is from what was meant, per axis, as standard deviations.
///
/// ```toml
/// [weights]
/// position_mm = 10
/// orientation_deg = 5
/// ```
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a table of weights")]
#[schemars(rename = "weights")]
pub(in crate::config) struct RawWeights {
    /// Of positions. Default: 10, or 1 where `hand = "none"`.
    pub(in crate::config) position_mm: Option<Number>,
    /// Of orientations. Default: 5.73 (0.1 rad), or a tenth of it where `hand = "none"`.
    pub(in crate::config) orientation_deg: Option<Number>,
}
