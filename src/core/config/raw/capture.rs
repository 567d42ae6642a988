//! How a daemon records.

use schemars::JsonSchema;
use serde::Deserialize;

use super::value::{Number, Text};

/// How `enact capture` records.
///
/// ```toml
/// [capture]
/// folder = "takes"
/// viewer_port = 8765
/// ```
#[derive(Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a table of capture settings")]
#[schemars(rename = "capture")]
pub(in crate::config) struct RawCapture {
    /// Folder of the takes. Default: "takes".
    pub(in crate::config) folder: Option<Text>,
    /// Longest time that samples are only in memory. Default: 100.
    pub(in crate::config) chunk_ms: Option<Number>,
    /// How often the journal is written through to the disk. Default: 1000.
    pub(in crate::config) sync_ms: Option<Number>,
    /// Address of viewers and metrics. Default: "127.0.0.1".
    pub(in crate::config) listen: Option<Text>,
    /// Port for viewers, 0 for any. Default: not served.
    pub(in crate::config) viewer_port: Option<Number>,
    /// Port for health and metrics, 0 for any. Default: not served.
    pub(in crate::config) metrics_port: Option<Number>,
    /// Pages in browsers that may watch from elsewhere. Default: those of this machine and of known viewers.
    pub(in crate::config) origins: Option<Vec<Text>>,
    /// Names of this machine by which viewers and pages may ask for it. Default: "localhost" and addresses in numbers.
    pub(in crate::config) hosts: Option<Vec<Text>>,
    /// So much of what came in before its start a take begins with. Default: 0.
    pub(in crate::config) pre_roll_s: Option<Number>,
    /// Whose stamps are not chosen by what its first sample has.
    #[serde(default)]
    pub(in crate::config) tracker: Vec<RawTrackerClock>,
}

/// The stamps of a live tracker.
///
/// ```toml
/// [[capture.tracker]]
/// body = "pencil"
/// stamps = "sequence"
/// rate_hz = 120
/// ```
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a table with `body` and `stamps`")]
#[schemars(rename = "capture.tracker")]
pub(in crate::config) struct RawTrackerClock {
    /// The body, or the track as `<body>.<name>`.
    pub(in crate::config) body: Text,
    /// "sample", "device", "sequence" or "receipt". Default: "sample" if the first sample has that,
    /// else "device", else "receipt".
    pub(in crate::config) stamps: Text,
    /// Rate of "sequence".
    pub(in crate::config) rate_hz: Option<Number>,
}
