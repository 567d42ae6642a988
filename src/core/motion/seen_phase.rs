//! What a stream shows of a body besides flights: that it rests, slides, rolls, or is carried.

use super::index::LinkIndex;
use super::scene::Scene;
use super::take::Stamp;
use crate::physics::Sustained;

/// A stretch in which a body does not fly, as its samples show it, on the clock of the samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeenPhase {
    /// The body.
    pub link: LinkIndex,
    /// What it does.
    pub motion: SeenMotion,
    /// When it begins to.
    pub from: Stamp,
    /// When it ends.
    pub until: Stamp,
    /// Whether it does so where the motion is looked at begins, and where that ends.
    pub is_at_end: [bool; 2],
}

/// What a body does that does not fly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SeenMotion {
    /// It stays on a surface.
    On(SeenOnSurface),
    /// It is where it is, and no surface carries it.
    Still,
    /// It goes where another body goes.
    With(LinkIndex),
    /// Gravity is not what moves it, and nothing of the scene touches it.
    InHand,
    /// It touches things now and then, and neither flies nor stays on any for long.
    Tumble,
}

/// How a body stays on a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeenOnSurface {
    /// How it moves.
    pub sustained: Sustained,
    /// Index into `Scene::surfaces`.
    pub surface: usize,
    /// By what it is on it (index into the body's features).
    pub feature: usize,
    /// Its friction as a phase has it, as it is slowed down; `None` where nothing tells.
    pub friction: Option<f64>,
}

impl SeenPhase {
    /// What the body does, where: "rests on `table`".
    pub fn words(&self, scene: &Scene) -> String {
        match self.motion {
            SeenMotion::On(on) => {
                let verb = match on.sustained {
                    Sustained::Slide => "slides",
                    Sustained::Roll => "rolls",
                    Sustained::Rest => "rests",
                };
                format!("{verb} on `{}`", scene.surfaces[on.surface].name)
            }
            SeenMotion::Still => "is held still".into(),
            SeenMotion::With(other) => format!("moves with `{}`", scene.links[other].name),
            SeenMotion::InHand => "is held".into(),
            SeenMotion::Tumble => "tumbles".into(),
        }
    }
}
