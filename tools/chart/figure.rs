//! What a chart shows, as data: every figure is kept as JSON, and its drawing is made from that
//! alone.

use serde::{Deserialize, Serialize};

/// One chart.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Figure {
    /// Name of its files.
    pub name: String,
    /// What it shows, as a sentence.
    pub title: String,
    /// On what, how often, from which revision and machine.
    pub note: String,
    /// Across.
    pub x: Axis,
    /// Up.
    pub y: Axis,
    /// What is compared.
    pub curves: Vec<Curve>,
}

/// An axis.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Axis {
    /// Quantity and unit.
    pub label: String,
    /// Whether it is logarithmic.
    pub logarithmic: bool,
}

/// One method, one point per setting.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Curve {
    /// The method.
    pub name: String,
    /// In the order in which a line joins them.
    pub points: Vec<Mark>,
}

/// One setting of a method.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
pub struct Mark {
    /// Across.
    pub x: f64,
    /// Up.
    pub y: f64,
    /// Spread of `y` over repeats: least and greatest.
    pub spread: Option<[f64; 2]>,
    /// The setting, where it has a name.
    pub setting: Option<String>,
    /// Whether the method failed here: drawn, as a cross, and never left out.
    pub failed: bool,
}
