//! What stays on a surface, or is in a hand.

use schemars::JsonSchema;
use serde::Deserialize;

use super::value::{Number, Text};

/// A body stays on a surface from one event to another: it slides, rolls or rests; or it is held (docs/phases.md).
///
/// ```toml
/// [[event]]
/// name = "pushed"
/// kind = "start"
///
/// [[event]]
/// name = "still"
/// kind = "change"
/// body = "pencil"
///
/// [[event]]
/// name = "landing"
/// kind = "end"
///
/// [[phase]]
/// name = "sliding"
/// motion = "slide"
/// body = "pencil"
/// surface = "table"
/// feature = "end -z"
/// friction = 0.2
/// from = "pushed"
/// until = "still"
///
/// [[phase]]
/// name = "standing"
/// motion = "rest"
/// body = "pencil"
/// surface = "table"
/// feature = "end -z"
/// from = "still"
/// until = "landing"
/// ```
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a phase")]
#[schemars(rename = "phase")]
pub(in crate::config) struct RawPhase {
    /// Its name.
    pub(in crate::config) name: Text,
    /// "slide", "roll", "rest", or "held" or "tumble": it goes where its tracker saw it, in a hand, or knocked about by contacts that no
    /// law explains.
    pub(in crate::config) motion: Text,
    /// The body.
    pub(in crate::config) body: Text,
    /// What it stays on: a plane, a board or a face. Default: it is held still where it is, with motion = "rest", or moved, with "held" and "tumble".
    pub(in crate::config) surface: Option<Text>,
    /// The face on which it lies. Default: a ball has none.
    pub(in crate::config) feature: Option<Text>,
    /// Coefficient of friction of what slides, by default that of the body; of what rolls, its deceleration on a
    /// level surface over gravity.
    pub(in crate::config) friction: Option<Number>,
    /// The event at which it begins: a start, a collision without rebound, a change.
    pub(in crate::config) from: Text,
    /// The event at which it ends.
    pub(in crate::config) until: Text,
}
