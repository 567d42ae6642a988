//! Bodies that stick together.

use nalgebra::Vector3;

use super::event::{EventKind, Partner};
use super::link::{Mechanism, Sees, Track};
use super::phase::{StuckTo, SupportPhase, SupportedBy};
use super::whole::{Scene, Timing};
use crate::math::Pose;
use crate::motion::estimate::Estimate;
use crate::motion::index::{LinkIndex, MechanismIndex, TrackIndex};
use crate::physics::support::StuckPart;

/// Two bodies that stick together from an event on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StuckPair {
    /// The event.
    pub event: usize,
    /// The bodies.
    pub links: [LinkIndex; 2],
}

impl Scene {
    /// All bodies that stick together, each pair once.
    pub fn stuck_pairs(&self) -> impl Iterator<Item = StuckPair> + '_ {
        self.phases.iter().filter_map(|phase| {
            let other = phase.stuck_to()?.other;
            (other < phase.link).then_some(StuckPair {
                event: phase.events[0],
                links: [other, phase.link],
            })
        })
    }

    /// The bodies that stick together at an event.
    pub fn stuck_at(&self, event: usize) -> Option<StuckPair> {
        self.stuck_pairs().find(|pair| pair.event == event)
    }

    /// Whether a mechanism begins to stick to another one at an event.
    pub fn sticks(&self, event: usize, mechanism: MechanismIndex) -> bool {
        let pair = self.stuck_at(event);
        let links = pair.into_iter().flat_map(|pair| pair.links);
        links
            .into_iter()
            .any(|link| self.mechanism_of(link) == mechanism)
    }

    /// Whether velocities jump at an event: bodies hit something, or each other and stay together.
    pub fn jolts(&self, event: usize) -> bool {
        self.events[event].kind.collision().is_some() || self.stuck_at(event).is_some()
    }

    /// The tracks that see what an event [jolts](Self::jolts), those of what hits first.
    pub fn tracks_jolted(&self, event: usize) -> Vec<TrackIndex> {
        let stuck = self.stuck_at(event).into_iter().flat_map(|of| of.links);
        match self.events[event].kind.collision() {
            Some(collision) => self.tracks_in(collision).collect(),
            None => self.tracks_of_links(stuck).collect(),
        }
    }

    /// Sets where two bodies stick together: the pose of the second in the axes of the first. Nothing changes where that is no
    /// number.
    pub fn stick(&mut self, pair: &StuckPair, first_from_second: &Pose) {
        let bodies = pair.links.map(|link| self.links[link].body);
        let Some(parts) = StuckPart::both([&bodies[0], &bodies[1]], first_from_second) else {
            return;
        };
        for phase in &mut self.phases {
            if let SupportedBy::Body(StuckTo { part, .. }) = &mut phase.by
                && let Some(side) = pair.links.iter().position(|link| *link == phase.link)
            {
                *part = Some(parts[side]);
            }
        }
    }

    /// The scene in which two bodies stick together in place of a collision; `None` where they cannot, or something happens to them
    /// later.
    pub fn with_stuck(&self, event: usize) -> Option<Scene> {
        let collision = self.events[event].kind.collision()?;
        let Partner::Link(other) = collision.partner else {
            return None;
        };
        let links = [collision.link, other];
        let is_plain = |link: &LinkIndex| {
            let body = &self.links[*link].body;
            let has_pose = |track: &Track| track.link == *link && track.sees == Sees::Pose;
            let is_alone = matches!(
                self.mechanisms[self.mechanism_of(*link)],
                Mechanism::Free(_)
            );
            let is_driven = self.is_held(*link) || self.phases.iter().any(|of| of.link == *link);
            let is_pulled = body.force_m_s2() != Vector3::zeros() || !body.feels_no_air();
            is_alone && !is_driven && !is_pulled && self.tracks.iter().any(has_pose)
        };
        let mut later = (event + 1..self.events.len()).flat_map(|later| self.links_at(later));
        let end = self
            .events
            .iter()
            .position(|of| of.kind == EventKind::End)?;
        let is_told = self.timing == Timing::Known && self.parameters.is_empty();
        if !is_told || !links.iter().all(is_plain) || later.any(|link| links.contains(&link)) {
            return None;
        }
        let mut scene = self.clone();
        scene.events[event].kind = EventKind::Change(links[0]);
        for (link, other) in [(links[0], links[1]), (links[1], links[0])] {
            scene.phases.push(SupportPhase {
                name: self.events[event].name.clone(),
                link,
                by: SupportedBy::Body(StuckTo { other, part: None }),
                events: [event, end],
            });
        }
        Some(scene)
    }

    /// The pose of the second of two bodies in the axes of the first where they begin to stick together in an estimate.
    pub fn stuck_pose(&self, pair: &StuckPair, estimate: &Estimate) -> Option<Pose> {
        let mut events = estimate.events.iter();
        let time_s = events.find(|of| of.event == pair.event)?.time_s;
        let pose = |link: LinkIndex| {
            let mechanism = self.mechanism_of(link);
            let mut arcs = estimate.arcs.iter();
            let arc = arcs.find(|arc| arc.mechanism == mechanism && arc.start_s == time_s)?;
            let state = self.flown(arc, &estimate.gravity_m_s2, time_s);
            Some(state.world_from_body())
        };
        let [first, second] = pair.links.map(pose);
        Some(first?.inverse() * second?)
    }
}
