//! Phases in which something carries a body.

use nalgebra::Vector3;

use crate::math::Pose;
use crate::motion::index::{ContactLawIndex, LinkIndex, TrackIndex};
use crate::physics::Sustained;
use crate::physics::support::{Pivot, StuckPart};

/// A body is carried between two events.
#[derive(Clone, Debug, PartialEq)]
pub struct SupportPhase {
    /// Unique name.
    pub name: String,
    /// The body.
    pub link: LinkIndex,
    /// By what.
    pub by: SupportedBy,
    /// The events at which it begins and ends.
    pub events: [usize; 2],
}

/// What carries a body in a phase.
#[derive(Clone, Debug, PartialEq)]
pub enum SupportedBy {
    /// A surface on which it stays.
    Surface(OnSurface),
    /// A place of the world that a point of it does not leave.
    Pivot(AtPivot),
    /// A hand, or contacts that nothing explains: it goes where that was tracked.
    Hand(InHand),
    /// Another body, with which it is one from then on.
    Body(StuckTo),
}

/// How a body is stuck to another one.
#[derive(Clone, Debug, PartialEq)]
pub struct StuckTo {
    /// The other one.
    pub other: LinkIndex,
    /// What part of both it is, once samples have told where they stick.
    pub part: Option<StuckPart>,
}

/// How a body is tracked in a hand, or where it tumbles.
#[derive(Clone, Debug, PartialEq)]
pub struct InHand {
    /// What sees it, or the hand.
    pub track: TrackIndex,
    /// How that tracker is mounted on the body, or on the hand that holds it.
    pub link_from_tracker: Pose,
    /// Whether no hand moves it, but contacts that nothing explains.
    pub tumbles: bool,
}

/// How a body stays on a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct OnSurface {
    /// How it moves.
    pub sustained: Sustained,
    /// What it is on (index into `Scene::surfaces`): a plane.
    pub surface: usize,
    /// By what it is on it (index into the body's features): a ball, or a face.
    pub feature: usize,
    /// Its friction.
    pub law: ContactLawIndex,
}

/// How a body turns about a place.
#[derive(Clone, Debug, PartialEq)]
pub struct AtPivot {
    /// Its point, and the axis about which it turns.
    pub pivot: Pivot,
    /// The place [m, world]; `None`: where the body is then.
    pub place_m: Option<Vector3<f64>>,
    /// A unit vector along the axis \[world\], where there is one.
    pub axis: Option<Vector3<f64>>,
}

impl SupportPhase {
    /// How it stays on a surface, if it does.
    pub fn on_surface(&self) -> Option<&OnSurface> {
        match &self.by {
            SupportedBy::Surface(on) => Some(on),
            SupportedBy::Pivot(_) | SupportedBy::Hand(_) | SupportedBy::Body(_) => None,
        }
    }

    /// How it is tracked in a hand, or where it tumbles.
    pub fn in_hand(&self) -> Option<&InHand> {
        match &self.by {
            SupportedBy::Hand(hand) => Some(hand),
            SupportedBy::Surface(_) | SupportedBy::Pivot(_) | SupportedBy::Body(_) => None,
        }
    }

    /// Whether contacts move it that nothing explains.
    pub fn tumbles(&self) -> bool {
        self.in_hand().is_some_and(|hand| hand.tumbles)
    }

    /// To what it is stuck, if it is.
    pub fn stuck_to(&self) -> Option<&StuckTo> {
        match &self.by {
            SupportedBy::Body(stuck) => Some(stuck),
            SupportedBy::Surface(_) | SupportedBy::Pivot(_) | SupportedBy::Hand(_) => None,
        }
    }

    /// The friction that counts in it.
    pub fn friction_law(&self) -> Option<ContactLawIndex> {
        let on = self.on_surface()?;
        (on.sustained != Sustained::Rest).then_some(on.law)
    }

    /// What the body does, as a word of a sentence.
    pub fn verb(&self) -> &'static str {
        match &self.by {
            SupportedBy::Surface(on) => match on.sustained {
                Sustained::Slide => "slides",
                Sustained::Roll => "rolls",
                Sustained::Rest => "rests",
            },
            SupportedBy::Pivot(_) => "is tied to the world",
            SupportedBy::Hand(hand) if hand.tumbles => "tumbles",
            SupportedBy::Hand(_) => "is in the hand",
            SupportedBy::Body(_) => "is stuck to another body",
        }
    }
}
