//! What is estimated beside the motion.

use schemars::JsonSchema;
use serde::Deserialize;

use super::value::{Number, Text};

/// A quantity that is estimated. Its numbers are in the unit of the quantity: places in mm, turns and tilts in °, times in ms,
/// the rate of a clock in %, accelerations in m/s², drags in 1/s and 1/m, and coefficients and factors as they are. The
/// documentation of `enact::config` lists all quantities.
///
/// ```toml
/// [[free]]
/// quantity = "bounce.restitution"
/// lower = 0.5
/// upper = 0.9
/// ```
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a free quantity")]
#[schemars(rename = "free")]
pub(in crate::config) struct RawFree {
    /// Its name, such as `bounce.restitution` or `table.height`.
    pub(in crate::config) quantity: Text,
    /// Where it begins. Default: what the scene says, or 0, or of a factor 1.
    pub(in crate::config) initial: Option<Number>,
    /// Least value. Default: the least there is.
    pub(in crate::config) lower: Option<Number>,
    /// Greatest value. Default: the greatest there is.
    pub(in crate::config) upper: Option<Number>,
    /// How well it is known beforehand, as a standard deviation about where it begins. Default: not at all.
    pub(in crate::config) prior_sd: Option<Number>,
    /// Half the opening of a cone in which both tilts of a normal are.
    pub(in crate::config) cone_deg: Option<Number>,
}
