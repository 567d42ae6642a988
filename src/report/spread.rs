//! How far a prediction may be off.

use serde::{Deserialize, Serialize};

use crate::motion::{LinkSpread, Scene, Spread};

/// Where repeated predictions come to rest, from states and with materials as they may be as well.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct SpreadLine {
    /// Number of predictions.
    pub draws: usize,
    /// Number of them in which all came to rest.
    pub at_rest: usize,
    /// Bodies whose material is the same in all, for the scene states no deviation of it: the distances then leave out most of what
    /// a prediction may be off.
    pub exact: Vec<String>,
    /// Where the bodies lie at the end.
    pub bodies: Vec<BodySpreadLine>,
}

/// Where a body lies at the end.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct BodySpreadLine {
    /// Its name.
    pub body: String,
    /// Median of each coordinate of its centre of mass.
    pub median_m: [f64; 3],
    /// Distance from there within which nine in ten lie.
    pub radius_m: f64,
    /// What is up, the likeliest first.
    pub up: Vec<UpLine>,
    /// Centre of mass of the prediction that most others are like.
    pub likely_m: [f64; 3],
    /// Its orientation, world from body, Hamilton.
    pub likely_wxyz: [f64; 4],
    /// The share that have its orientation to within 20°.
    pub likely_share: f64,
}

/// A part of a body that is up.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct UpLine {
    /// A declared face, or an axis of the body, such as `+z`.
    pub up: String,
    /// Share of the predictions.
    pub share: f64,
}

impl SpreadLine {
    /// With the scene's names.
    pub fn new(scene: &Scene, spread: &Spread) -> Self {
        let bodies = spread.links.iter();
        Self {
            draws: spread.draws,
            at_rest: spread.at_rest,
            exact: spread.exact.clone(),
            bodies: bodies.map(|of| BodySpreadLine::new(scene, of)).collect(),
        }
    }
}

impl BodySpreadLine {
    fn new(scene: &Scene, of: &LinkSpread) -> Self {
        let q = of.likely.rotation;
        let up = of.up.iter();
        Self {
            body: scene.links[of.link].name.clone(),
            median_m: of.median_m.into(),
            radius_m: of.radius_m,
            up: up
                .map(|(up, share)| UpLine {
                    up: up.clone(),
                    share: *share,
                })
                .collect(),
            likely_m: of.likely.translation.vector.into(),
            likely_wxyz: [q.w, q.i, q.j, q.k],
            likely_share: of.likely_share,
        }
    }
}
