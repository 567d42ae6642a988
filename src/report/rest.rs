//! How bodies lie at rest, against the scene's goals there.

use serde::{Deserialize, Serialize};

use crate::motion::{Rest, Scene};

/// How bodies lie at rest, and what it took.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct RestLine {
    /// Whether every goal is met.
    pub reached: bool,
    /// One per goal.
    pub goals: Vec<LieLine>,
    /// Motions near the performance that were estimated anew.
    pub tried: usize,
    /// Continuations that were simulated.
    pub continuations: usize,
    /// Objective of the motion that fits best, wherever it comes to rest.
    pub best_objective: f64,
}

/// How one body lies.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct LieLine {
    /// Name of the body.
    pub body: String,
    /// What should be up, or in the goal's direction.
    pub asked: String,
    /// What is.
    pub face_up: String,
    /// Angle of the asked from there.
    pub angle_rad: f64,
    /// Whether it lies still.
    pub is_still: bool,
    /// Whether the goal is met.
    pub is_met: bool,
    /// Turn of the body's labels from those acted, Hamilton; none: as acted.
    pub labels_wxyz: Option<[f64; 4]>,
}

impl RestLine {
    /// With the scene's names.
    pub fn new(scene: &Scene, rest: &Rest) -> Self {
        let goals = scene.rest_goals.iter().zip(&rest.goals).zip(&rest.labels);
        let goals = goals.map(|((goal, lie), labels)| LieLine {
            body: scene.links[goal.link].name.clone(),
            asked: goal.name.clone(),
            face_up: lie.shown.clone(),
            angle_rad: lie.angle_rad,
            is_still: lie.is_still,
            is_met: lie.is_met(),
            labels_wxyz: labels.map(|turn| [turn.w, turn.i, turn.j, turn.k]),
        });
        Self {
            reached: rest.is_reached(),
            goals: goals.collect(),
            tried: rest.work.motions,
            continuations: rest.work.continuations,
            best_objective: rest.work.best_objective,
        }
    }
}
