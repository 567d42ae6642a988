//! What a chart shows, as data: every figure is kept as JSON, and its drawing is made from that
//! alone.

use serde::{Deserialize, Deserializer, Serialize};

/// One chart.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
pub struct Figure {
    /// Name of its files.
    pub name: String,
    /// What it shows, as a sentence.
    pub title: String,
    /// On what, how often, and how to read it.
    pub note: String,
    /// Across.
    pub x: Axis,
    /// Up.
    pub y: Axis,
    /// What is compared.
    pub curves: Vec<Curve>,
}

/// An axis.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
pub struct Axis {
    /// Quantity and unit.
    pub label: String,
    /// Whether it is logarithmic.
    pub logarithmic: bool,
    /// What stands at 0, 1, 2, … where the axis is no quantity.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub names: Vec<String>,
    /// How many of them, from the first on, are steps one after another: lines join their points.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub steps: usize,
}

fn is_zero(number: &usize) -> bool {
    *number == 0
}

impl Axis {
    /// Of a quantity, evenly spaced.
    pub fn linear(label: &str) -> Self {
        Self {
            label: label.to_owned(),
            ..Self::default()
        }
    }

    /// Of a quantity, by its logarithm.
    pub fn logarithmic(label: &str) -> Self {
        Self {
            logarithmic: true,
            ..Self::linear(label)
        }
    }

    /// Of things that have no order but this.
    pub fn named(label: &str, names: Vec<String>) -> Self {
        Self {
            names,
            ..Self::linear(label)
        }
    }

    /// Of things of which all but the last are steps one after another.
    pub fn steps(label: &str, names: Vec<String>) -> Self {
        Self {
            steps: names.len() - 1,
            ..Self::named(label, names)
        }
    }
}

/// What a curve is among the others.
#[derive(Clone, Copy, Debug, Default, Deserialize, Eq, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Role {
    /// One of several.
    #[default]
    Compared,
    /// What the program does: drawn heavier than the others.
    Ours,
    /// A bound or a fit and no measurement: dashed, without points.
    Bound,
}

/// One method, one point per setting.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
pub struct Curve {
    /// The method.
    pub name: String,
    /// What it is among the others.
    #[serde(default)]
    pub role: Role,
    /// In the order in which a line joins them.
    pub points: Vec<Mark>,
}

impl Curve {
    /// One of several.
    pub fn new(name: impl Into<String>, points: Vec<Mark>) -> Self {
        Self {
            name: name.into(),
            role: Role::Compared,
            points,
        }
    }

    /// What the program does.
    pub fn ours(name: impl Into<String>, points: Vec<Mark>) -> Self {
        Self {
            role: Role::Ours,
            ..Self::new(name, points)
        }
    }

    /// A bound or a fit.
    pub fn bound(name: impl Into<String>, points: Vec<Mark>) -> Self {
        Self {
            role: Role::Bound,
            ..Self::new(name, points)
        }
    }
}

/// One setting of a method.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
pub struct Mark {
    /// Across.
    #[serde(deserialize_with = "or_nan")]
    pub x: f64,
    /// Up; where a failure has no such number, it is not one.
    #[serde(deserialize_with = "or_nan")]
    pub y: f64,
    /// Spread of `y` over repeats: least and greatest.
    #[serde(default, deserialize_with = "both_or_none")]
    pub spread: Option<[f64; 2]>,
    /// The setting, where it has a name.
    pub setting: Option<String>,
    /// Whether the method failed here: drawn, as a cross, and never left out.
    pub failed: bool,
}

impl Mark {
    /// A point.
    pub fn at(x: f64, y: f64) -> Self {
        Self {
            x,
            y,
            ..Self::default()
        }
    }
}

/// JSON has no number for what is none.
pub fn or_nan<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    Ok(Option::<f64>::deserialize(deserializer)?.unwrap_or(f64::NAN))
}

/// A spread with an end that is no number is none.
fn both_or_none<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<[f64; 2]>, D::Error> {
    let ends = Option::<[Option<f64>; 2]>::deserialize(deserializer)?;
    Ok(ends.and_then(|[least, greatest]| Some([least?, greatest?])))
}
