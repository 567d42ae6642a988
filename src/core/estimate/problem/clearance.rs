//! Two solids that must stay out of each other about a moment at which they would not.

use super::arc_condition::ActingParameter;
use crate::motion::held::HeldEstimate;
use crate::motion::{Against, LinkIndex};
use crate::physics::contact::{Contact, Frame};

/// Two solids whose distance must not be less than a bound near a moment of their motion.
///
/// Their distance about that moment is that of one pair of features, or of one pair before and of another after the
/// moment at which both are as far: where a corner passes an edge it leaves one face for the next. The moment of the
/// least distance is no unknown, but found anew at every point.
#[derive(Clone, Debug)]
pub struct ClearSolids {
    /// The first body.
    pub link: LinkIndex,
    /// What it must stay out of.
    pub against: Against,
    /// How that moves.
    pub from: KeptFrom,
    /// The features of both that are nearest.
    pub touches: ClearanceTouches,
    /// The moment about which they are \[s\].
    pub around_s: f64,
    /// How far from it they may be nearest \[s\].
    pub reach_s: f64,
    /// The least distance \[m\]; negative where solids may overlap by so much.
    pub least_m: f64,
    /// How deep the solids were in each other when it was first asked for \[m\].
    pub depth_m: f64,
}

impl ClearSolids {
    /// Whether it is of the same solids as another one, at about the same time.
    pub fn is_beside(&self, other: &Self) -> bool {
        (self.link, self.against) == (other.link, other.against)
            && (self.around_s - other.around_s).abs() <= self.reach_s.max(other.reach_s)
    }

    /// Whether both are of one pair of features, at the same face.
    pub fn shares_face(&self, other: &Self) -> bool {
        match (&self.touches, &other.touches) {
            (ClearanceTouches::One(one), ClearanceTouches::One(another)) => {
                one.shares_face(another)
            }
            _ => false,
        }
    }

    /// When features may be nearest between both ends of the motion \[s\].
    pub fn window_s(&self, [start_s, end_s]: [f64; 2]) -> [f64; 2] {
        // A step that is tried may lead to times that are none: what follows of them is none either.
        let clamped = |time_s: f64| time_s.max(start_s).min(end_s);
        [
            clamped(self.around_s - self.reach_s),
            clamped(self.around_s + self.reach_s),
        ]
    }

    /// The pairs of features.
    pub fn contacts(&self) -> &[Contact] {
        match &self.touches {
            ClearanceTouches::One(contact) => std::slice::from_ref(contact),
            ClearanceTouches::Switching(both) => both.as_slice(),
        }
    }
}

/// What keeps two solids apart, of whatever moves.
pub trait Clears {
    /// The solids.
    fn solids(&self) -> &ClearSolids;

    /// The same, to be changed.
    fn solids_mut(&mut self) -> &mut ClearSolids;

    /// Whether it is of the same solids as another one, at about the same time of the same motion.
    fn is_beside(&self, other: &Self) -> bool {
        self.solids().is_beside(other.solids())
    }
}

/// Two solids that must stay out of each other of which one flies.
#[derive(Clone, Debug)]
pub struct Clearance {
    /// What is kept apart.
    pub solids: ClearSolids,
    /// The arc of the first body and, where the other flies too, that of the other.
    pub arcs: Vec<usize>,
    /// What ends the flights on either side: the later start and the earlier end.
    pub ends: [FlightEnd; 2],
    /// Parameters that act on its flights.
    pub acting: Vec<ActingParameter>,
}

impl Clears for Clearance {
    fn solids(&self) -> &ClearSolids {
        &self.solids
    }

    fn solids_mut(&mut self) -> &mut ClearSolids {
        &mut self.solids
    }
}

/// How what a body must stay out of moves.
#[derive(Clone, Debug)]
pub enum KeptFrom {
    /// What stands still.
    Still(Frame),
    /// A body in the hand.
    Held(Box<HeldEstimate>),
    /// What moves as the unknowns say, too: the second body.
    Flying,
}

/// The features that tell a distance, of the first body and of the other.
#[derive(Clone, Debug, PartialEq)]
pub enum ClearanceTouches {
    /// One pair all the time.
    One(Box<Contact>),
    /// One pair until both are as far, then another: the distance is the greater of both.
    Switching(Box<[Contact; 2]>),
}

/// An end of a flight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FlightEnd {
    /// At an event whose time is an unknown (index into [`Problem::event_is_free`](super::Problem::event_is_free)).
    Event(usize),
    /// At a share of the interval from a node to the next (index into
    /// [`Problem::nodes_acted_s`](super::Problem::nodes_acted_s)), where times are unknown.
    Node(usize, f64),
    /// At a time \[s\].
    At(f64),
}
