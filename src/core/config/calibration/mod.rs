//! Calibration files: what `enact calibrate` found, and scenes with it.

mod apply;
mod file;

pub use apply::{CalibratedScene, scene_calibrated};
pub use file::{
    BodyValues, CalibratedQuantity, Calibration, CalibrationError, EventValues, FreeValue,
    SceneValues, SourceLine, SurfaceValue, TrackValues, TrackerValue, body_axis,
};
