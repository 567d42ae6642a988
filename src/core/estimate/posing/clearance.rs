//! The clearances that a motion's overlaps ask for.

pub(in crate::estimate) mod again;
pub(in crate::estimate) mod met;

use self::met::{OverlapMeeting, given_state, keeping_out, kept_from};
use super::conditions::acting;
use crate::estimate::covariance::timing;
use crate::estimate::problem::Problem;
use crate::estimate::problem::clearance::{Clearance, FlightEnd, KeptFrom};
use crate::motion::{Against, ArcEstimate, Estimate, LinkIndex, Penetration, Scene};
use crate::physics::{State, flow};

/// A motion whose solids overlap.
pub(in crate::estimate) struct Overlapping<'a> {
    /// The scene as estimated.
    pub(in crate::estimate) scene: &'a Scene,
    /// The motion.
    pub(in crate::estimate) estimate: &'a Estimate,
    /// The problem that it solves.
    pub(in crate::estimate) problem: &'a Problem,
}

impl<'a> Overlapping<'a> {
    /// What keeps the two solids of an overlap out of each other about its moment; `None` where no features tell.
    pub(in crate::estimate) fn clearance(&'a self, found: &Penetration) -> Option<Clearance> {
        let (link, against) = keeping_out(self.scene, found);
        let time_s = found.time_s;
        let (arc, flight) = self.flight(link, time_s)?;
        let from = kept_from(self.scene, self.estimate, against);
        let other = match (&from, against) {
            (KeptFrom::Flying, Against::Link(other)) => Some((other, self.flight(other, time_s)?)),
            _ => None,
        };
        let own = [(arc, flight)].into_iter();
        let flights = own.chain(other.map(|(_, flown)| flown));
        let from_s = flights.clone().map(|(_, of)| of.start_s);
        let to_s = flights.clone().map(|(_, of)| of.end_s);
        let ends_s = [
            from_s.fold(f64::NEG_INFINITY, f64::max),
            to_s.fold(f64::INFINITY, f64::min),
        ];
        let states = |at_s: f64| {
            let met = match other {
                Some((other, _)) => self.state(other, self.flight(other, at_s)?.1, at_s),
                None => given_state(&from, at_s)?,
            };
            Some([self.state(link, flight, at_s), met])
        };
        let meeting = OverlapMeeting::new(self.scene, link, against, from.clone(), &states)?;
        let solids = meeting.solids(time_s, found.depth_m, ends_s)?;
        let end = |side: usize| {
            let at_s = ends_s[side];
            let mut ended = flights
                .clone()
                .filter(|(_, flight)| [flight.start_s, flight.end_s][side] == at_s);
            ended
                .next()
                .map_or(FlightEnd::At(at_s), |(arc, _)| self.end(arc, side, at_s))
        };
        let arcs: Vec<usize> = flights.clone().map(|(arc, _)| arc).collect();
        let problem = self.problem;
        Some(Clearance {
            solids,
            ends: [end(0), end(1)],
            acting: acting(&problem.arcs, &arcs, &problem.gravity_parameters, &[]),
            arcs,
        })
    }

    /// The arc of a link at a time, in the problem and as estimated: of two that meet there the first.
    fn flight(&self, link: LinkIndex, time_s: f64) -> Option<(usize, &'a ArcEstimate)> {
        let mechanism = self.scene.mechanism_of(link);
        let mut flown = self.estimate.arcs.iter();
        let flown = flown.find(|arc| {
            arc.mechanism == mechanism && arc.start_s <= time_s && time_s <= arc.end_s
        })?;
        // Arcs of a mechanism are in order of time in both.
        let of_it = |of: &&ArcEstimate| of.mechanism == mechanism && of.start_s < flown.start_s;
        let place = self.estimate.arcs.iter().filter(of_it).count();
        let arcs = self.problem.arcs.iter().enumerate();
        let mut arcs = arcs.filter(|(_, arc)| arc.mechanism == mechanism);
        Some((arcs.nth(place)?.0, flown))
    }

    fn state(&self, link: LinkIndex, flight: &ArcEstimate, time_s: f64) -> State {
        let body = &self.scene.links[link].body;
        let since_s = time_s - flight.epoch_s;
        flow::advance(body, &self.estimate.gravity_m_s2, &flight.state, since_s)
    }

    /// How an end of an arc, which is at a time, moves.
    fn end(&self, arc: usize, side: usize, at_s: f64) -> FlightEnd {
        let problem = self.problem;
        let arc = &problem.arcs[arc];
        let event = [arc.start, arc.end][side];
        if let Some(event) = event.filter(|event| problem.event_is_free[*event]) {
            return FlightEnd::Event(event);
        }
        if !problem.times_are_unknown() {
            return FlightEnd::At(at_s);
        }
        if let Some(event) = event {
            let (node, share) = timing::place(problem, event);
            return FlightEnd::Node(node, share);
        }
        let sample = arc.ends().map(|ends| ends[side]);
        sample.map_or(FlightEnd::At(at_s), |of| FlightEnd::Node(of.node, of.share))
    }
}
