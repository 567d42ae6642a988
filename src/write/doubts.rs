//! What speaks against an estimate, with the scene's names, for its report.

use serde::Serialize;

use crate::motion::{Doubt, Scene};

#[derive(Clone, Debug, PartialEq, Serialize)]
pub(super) struct DoubtLine {
    quantity: &'static str,
    value: f64,
    bound: f64,
    unit: &'static str,
    at: Option<String>,
    time_s: Option<f64>,
    best: &'static str,
}

impl DoubtLine {
    pub(super) fn new(scene: &Scene, doubt: &Doubt) -> Self {
        Self {
            quantity: doubt.about.as_str(),
            value: doubt.value,
            bound: doubt.bound,
            unit: doubt.about.unit(),
            at: doubt.place.name(scene).map(str::to_owned),
            time_s: doubt.place.time_s(),
            best: doubt.about.best().as_str(),
        }
    }
}
