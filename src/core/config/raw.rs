//! The scene file as it is written: all keys with their units; only types are checked.

mod body;
mod capture;
mod event;
mod free;
mod phase;
mod shape;
mod timing;
mod value;
mod world;

use schemars::JsonSchema;
use serde::Deserialize;

pub(super) use self::body::{RawBody, RawTrack, RawTracker};
pub(super) use self::capture::{RawCapture, RawTrackerClock};
pub(super) use self::event::{RawAxis, RawCount, RawEvent, RawGoal};
pub(super) use self::free::RawFree;
pub(super) use self::phase::RawPhase;
pub(super) use self::shape::RawShape;
pub(super) use self::timing::{RawTiming, RawWeights};
pub(super) use self::value::{Corners, Number, Quadruple, Text, Triple};
pub(super) use self::world::{RawJoint, RawObstacle, RawSurface};
use super::spanned::Spanned;

/// A scene: what moves, what stands, what happens, what is wanted. The least is a name, `[timing]` and
/// one `[[body]]`.
///
/// ```toml
/// name = "a ball on a table"
/// settle_s = 3
///
/// [timing]
/// stamps = "tempo"
///
/// [[body]]
/// name = "ball"
/// shape = { kind = "sphere", radius_mm = 33 }
/// mass_g = 58
/// restitution = 0.7
///
/// [[surface]]
/// name = "table"
/// point_mm = [0, 0, 0]
/// normal = [0, 0, 1]
///
/// [[event]]
/// name = "bounce"
/// kind = "collision"
/// body = "ball"
///
/// [[event]]
/// name = "landing"
/// kind = "end"
/// ```
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a scene")]
#[schemars(rename = "scene")]
pub(super) struct RawScene {
    /// Its name, in reports.
    pub(super) name: Text,
    /// Gravity, in the axes of the world, which are those of the trackers. Default: [0, 0, -9.80665].
    pub(super) gravity_m_s2: Option<Triple>,
    /// The topic of the marks. Default: "/marks".
    pub(super) marks_topic: Option<Text>,
    /// What the stamps of samples mean.
    pub(super) timing: RawTiming,
    /// Whether velocities may jump where physics has them continuous: "when needed" where no motion
    /// does without, "always" from the start, "never". Default: "when needed".
    pub(super) velocity_gaps: Option<Text>,
    /// How long the motion goes on by simulation after its end, until all rests, at most. Default: it
    /// ends where the performance does.
    pub(super) settle_s: Option<Number>,
    /// How `enact capture` records.
    pub(super) capture: Option<RawCapture>,
    /// How well the performance shows what was meant.
    pub(super) weights: Option<RawWeights>,
    /// Whether a hand acted the motion: "acted", or "none" where the motion itself was measured, as a toss is that cameras see.
    /// Default: it is not known, and what the flights show decides.
    pub(super) hand: Option<Text>,
    /// How exactly shapes and places are known: overlaps up to it are the scene's inaccuracy, and a part that is
    /// nearer to what it hits than the one that should hit, by no more than it, is not wrong. Default: a hundredth of the
    /// radius of the smallest body, 0.5 to 5.
    pub(super) tolerance_mm: Option<Number>,
    /// What moves, or is in the hand.
    #[serde(default)]
    pub(super) body: Vec<Spanned<RawBody>>,
    /// What ties bodies together (docs/joints.md).
    #[serde(default)]
    pub(super) joint: Vec<Spanned<RawJoint>>,
    /// What stands and is flat.
    #[serde(default)]
    pub(super) surface: Vec<RawSurface>,
    /// What stands and is solid.
    #[serde(default)]
    pub(super) obstacle: Vec<RawObstacle>,
    /// What happens, in order of time.
    #[serde(default)]
    pub(super) event: Vec<Spanned<RawEvent>>,
    /// What stays on surfaces between events (docs/phases.md).
    #[serde(default)]
    pub(super) phase: Vec<Spanned<RawPhase>>,
    /// What must hold at an event (docs/goals.md).
    #[serde(default)]
    pub(super) goal: Vec<Spanned<RawGoal>>,
    /// What is estimated beside the motion.
    #[serde(default)]
    pub(super) free: Vec<RawFree>,
}
