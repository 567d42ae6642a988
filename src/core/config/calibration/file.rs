//! The calibration file as it is written and read.

use nalgebra::Vector3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::super::counted;
use super::super::error::SceneError;
use super::super::rest::axis;
use crate::motion::Link;

/// A calibration that cannot be written or read.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum CalibrationError {
    /// The text is no calibration.
    #[error(transparent)]
    File(SceneError),
    /// It cannot be written as TOML.
    #[error("cannot be written as TOML: {0}")]
    Write(String),
    /// An axis that the body does not have.
    #[error("{0}")]
    Axis(String),
}

/// What a calibration found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Calibration {
    /// `pivot`, `plane`, `rest`, `gravity`, `clock` or `fit`.
    pub kind: String,
    /// Program and version that made it.
    pub program: String,
    /// How often intervals contain the truth.
    pub confidence: f64,
    /// What speaks against it.
    pub against: Vec<String>,
    /// What to know.
    pub notes: Vec<String>,
    /// What it was made of.
    pub recording: Vec<SourceLine>,
    /// What was found.
    pub quantity: Vec<CalibratedQuantity>,
    /// The same as keys of a scene, where a scene has such.
    #[serde(default, skip_serializing_if = "SceneValues::is_empty")]
    pub scene: SceneValues,
}

/// A stream that a calibration was made of.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SourceLine {
    /// The recording.
    pub file: String,
    /// SHA-256 of it, in hexadecimal digits.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sha256: Option<String>,
    /// The topic in it.
    pub topic: String,
    /// Poses that were used.
    pub poses: usize,
    /// Messages that hold no pose, or one at the time of another.
    pub dropped: usize,
    /// Stamp of the first pose used \[ns\].
    pub first_stamp_ns: i64,
    /// From the first sample of the stream to the first one used \[s\].
    pub from_s: f64,
    /// From the first sample of the stream to the last one used \[s\].
    pub to_s: f64,
}

/// A quantity with its interval, number by number.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CalibratedQuantity {
    /// What it is, with its axes.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// The estimate.
    pub value: Vec<f64>,
    /// Lower ends of the intervals; empty where it has none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub lower: Vec<f64>,
    /// Upper ends of the intervals.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub upper: Vec<f64>,
}

/// Keys of a scene, as the scene has them.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct SceneValues {
    /// `gravity_m_s2`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gravity_m_s2: Option<[f64; 3]>,
    /// `[[body]]`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub body: Vec<BodyValues>,
    /// `[[surface]]`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub surface: Vec<SurfaceValue>,
    /// `[[event]]`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub event: Vec<EventValues>,
    /// `[[free]]`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub free: Vec<FreeValue>,
}

impl SceneValues {
    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

/// Keys of a `[[body]]` that has this name.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct BodyValues {
    /// Which body.
    pub name: String,
    /// `restitution`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub restitution: Option<f64>,
    /// `friction`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub friction: Option<f64>,
    /// `tangential_restitution`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tangential_restitution: Option<f64>,
    /// `tracker_sd_mm`, of a held body.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tracker_sd_mm: Option<f64>,
    /// `tracker_sd_deg`, of a held body.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tracker_sd_deg: Option<f64>,
    /// `tracker`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tracker: Option<TrackerValue>,
    /// `[[body.track]]`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub track: Vec<TrackValues>,
}

/// Keys of an `[[event]]` that has this name.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct EventValues {
    /// Which event.
    pub name: String,
    /// `restitution`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub restitution: Option<f64>,
    /// `friction`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub friction: Option<f64>,
    /// `tangential_restitution`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tangential_restitution: Option<f64>,
}

/// Keys of a `[[body.track]]` that has this name.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TrackValues {
    /// Which track of the body.
    pub name: String,
    /// `tracker`.
    pub tracker: TrackerValue,
}

/// Where a tracker is mounted.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct TrackerValue {
    /// `position_mm`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub position_mm: Option<[f64; 3]>,
    /// `orientation_wxyz`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub orientation_wxyz: Option<[f64; 4]>,
}

/// A `[[surface]]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SurfaceValue {
    /// Its name.
    pub name: String,
    /// `point_mm`.
    pub point_mm: [f64; 3],
    /// `normal`.
    pub normal: [f64; 3],
}

/// A `[[free]]` quantity, whose prior is how well it was found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FreeValue {
    /// Its name.
    pub quantity: String,
    /// `initial`, in the unit of the quantity in scenes: of an offset milliseconds, of a rate percent.
    pub initial: f64,
    /// `prior_sd`, in the same unit.
    pub prior_sd: f64,
}

impl Calibration {
    /// The calibration in a text. Fails with the place of the first error.
    pub fn from_toml(text: &str) -> Result<Self, CalibrationError> {
        counted::read(text).map_err(CalibrationError::File)
    }

    /// Its text. Fails where a number cannot be written, such as a stamp beyond 64 bits.
    pub fn to_toml(&self) -> Result<String, CalibrationError> {
        let text = toml::to_string(self);
        let text = text.map_err(|error| CalibrationError::Write(error.to_string()))?;
        Ok(format!(
            "# A calibration. `enact scene calibrated SCENE THIS -o NEW` makes a scene with it; the keys\n\
             # under [scene] are those of a scene.\n\n{text}"
        ))
    }
}

/// An axis of a body by name, `+z`, or the normal of one of its faces: unit, body axes.
pub fn body_axis(link: &Link, name: &str) -> Result<Vector3<f64>, CalibrationError> {
    axis("the axis", link, name, 0..0).map_err(|fault| CalibrationError::Axis(fault.message))
}
