//! Which phase a mechanism is in, and what supports it there.

use super::phase::{InHand, SupportPhase, SupportedBy};
use super::whole::Scene;
use crate::motion::estimate::{ArcEstimate, EventEstimate};
use crate::motion::index::MechanismIndex;
use crate::physics::contact::Feature;
use crate::physics::{Body, OnPlane, PlaneSupport, Support};

impl Scene {
    /// The phase in which a mechanism is between two of its events that follow each other; `None` of a flight.
    pub fn phase_between(
        &self,
        mechanism: MechanismIndex,
        ends: [Option<usize>; 2],
    ) -> Option<&SupportPhase> {
        self.phases.iter().find(|phase| {
            let [from, until] = phase.events.map(Some);
            let is_within = from <= ends[0] && ends[1].is_some() && ends[1] <= until;
            self.mechanism_of(phase.link) == mechanism && is_within
        })
    }

    /// The phase that begins, or ends, for a mechanism at an event.
    pub fn phase_beside(
        &self,
        mechanism: MechanismIndex,
        event: usize,
        is_after: bool,
    ) -> Option<&SupportPhase> {
        let at = usize::from(!is_after);
        self.phases
            .iter()
            .find(|phase| self.mechanism_of(phase.link) == mechanism && phase.events[at] == event)
    }

    /// The phase in which what moves on an arc is between events at these times \[s\]; `None` of a flight.
    pub fn phase_of(&self, arc: &ArcEstimate, events: &[EventEstimate]) -> Option<&SupportPhase> {
        let middle_s = 0.5 * (arc.start_s + arc.end_s);
        let time_s = |index: usize| {
            let event = events.iter().find(|event| event.event == index);
            event.map(|event| event.time_s)
        };
        self.phases.iter().find(|phase| {
            let [from, until] = phase.events.map(time_s);
            self.mechanism_of(phase.link) == arc.mechanism
                && from.is_some_and(|from_s| from_s <= middle_s)
                && until.is_none_or(|until_s| middle_s <= until_s)
        })
    }

    /// Whether a mechanism is in a hand between two of its events that follow each other: it does not move by itself there.
    pub fn is_in_hand(&self, mechanism: MechanismIndex, ends: [Option<usize>; 2]) -> bool {
        let phase = self.phase_between(mechanism, ends);
        phase.is_some_and(|phase| phase.in_hand().is_some())
    }

    /// The phase (index into [`Scene::phases`]) of which a hand moves a mechanism after an event, or before it.
    pub fn grip_beside(
        &self,
        mechanism: MechanismIndex,
        event: usize,
        is_after: bool,
    ) -> Option<usize> {
        let at = usize::from(!is_after);
        self.phases.iter().position(|phase| {
            let is_its = self.mechanism_of(phase.link) == mechanism;
            is_its && phase.events[at] == event && phase.in_hand().is_some()
        })
    }

    /// Whether a hand lets go of a mechanism at an event, or takes it.
    pub fn hand_beside(&self, mechanism: MechanismIndex, event: usize, is_after: bool) -> bool {
        self.grip_beside(mechanism, event, is_after).is_some()
    }

    /// How a body's own tracker sees it in a hand in a phase; `None` where the hand is tracked instead, and in no hand.
    pub fn seen_in_hand<'s>(&self, phase: &'s SupportPhase) -> Option<&'s InHand> {
        let is_own = |hand: &&InHand| self.tracks[hand.track].link == phase.link;
        phase.in_hand().filter(is_own)
    }

    /// What supports the body in a phase; `None` in a hand, and of what is stuck where nothing has told how.
    ///
    /// # Panics
    /// Of a surface that is no plane, and of a rim on one: `config` refuses both.
    pub fn support(&self, phase: &SupportPhase) -> Option<Support> {
        let on = match &phase.by {
            SupportedBy::Surface(on) => on,
            SupportedBy::Pivot(at) => return Some(Support::Pivot(at.pivot)),
            SupportedBy::Hand(_) => return None,
            SupportedBy::Body(stuck) => return stuck.part.map(Support::Stuck),
        };
        let Feature::Face { normal, .. } = self.surfaces[on.surface].geometry else {
            panic!("a phase on a plane");
        };
        let touching = match self.links[phase.link].features[on.feature].geometry {
            Feature::Face { point_m, normal } => OnPlane::Face { point_m, normal },
            Feature::Line {
                direction,
                radius_m,
                ..
            } => OnPlane::Side {
                radius_m,
                axis: direction,
            },
            Feature::Point { radius_m, .. } => OnPlane::Ball { radius_m },
            Feature::Rim { .. } => panic!("a ball, a face or a side"),
        };
        Some(Support::Plane(PlaneSupport {
            normal,
            sustained: on.sustained,
            // What rests needs no law.
            friction: self
                .contact_laws
                .get(on.law)
                .map_or(0.0, |law| law.friction),
            touching,
        }))
    }

    /// The phase in which a body is tied to the world, held still or stuck to another, up to an event at least: what follows there
    /// is not known, or not computed.
    pub fn tied_at(&self, event: usize) -> Option<&SupportPhase> {
        let mut phases = self.phases.iter();
        phases.find(|phase| {
            let [from, until] = phase.events;
            let is_begun = from < event || from == event && phase.stuck_to().is_some();
            phase.on_surface().is_none() && is_begun && event <= until
        })
    }

    /// The equations of motion of a mechanism between two of its events that follow each other.
    pub fn body_between(&self, mechanism: MechanismIndex, ends: [Option<usize>; 2]) -> Body {
        let phase = self.phase_between(mechanism, ends);
        self.body_of(mechanism)
            .with_support(phase.and_then(|phase| self.support(phase)))
    }
}
