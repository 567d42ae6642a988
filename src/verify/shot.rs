//! The single shot: the whole motion simulated from the first states alone.
//!
//! Flights go by [`super::series`], the time of a collision is where parry's distance of the
//! expected feature from its partner becomes zero, and impacts go by the law of impact with the
//! estimated parameters. A point that is expected to touch is followed as the ball that it is;
//! of other features the whole solid. Where the estimate leaves a velocity gap, or the outcome
//! of a collision does not follow, the simulation goes on from the estimate's own state.

use nalgebra::Point3;

use super::law::Law;
use super::meeting::{Partner, World};
use super::series;
use crate::math::Pose;
use crate::motion::{
    Against, Collision, Deviation, EventEstimate, Partner as Hit, SingleShot, Touching,
};
use crate::physics::State;
use crate::physics::contact::Feature;
use crate::physics::shape::Solid;

/// Velocity gaps beyond these are bent physics, not rounding.
const GAP_M_S: f64 = 1e-6;
const GAP_RAD_S: f64 = 1e-5;

/// First half width of the interval in which a contact is looked for \[s\]; it grows.
const FIRST_REACH_S: f64 = 1e-9;
const GROWTH: f64 = 8.0;

/// Farther from its estimated time no contact is looked for \[s\].
const LAST_REACH_S: f64 = 0.05;

/// Halvings of that interval at most.
const HALVINGS: usize = 60;

/// Where a body is in the simulation.
#[derive(Clone, Copy)]
struct Flight {
    time_s: f64,
    state: State,
}

struct Shot<'w> {
    world: &'w World<'w>,
    /// One per body with arcs.
    flights: Vec<Option<Flight>>,
    result: SingleShot,
}

/// Simulates all bodies, and compares at every collision and at the end.
pub(super) fn shoot<'w>(world: &'w World<'w>) -> SingleShot {
    let flights = world.tracks.iter().map(|track| {
        let first = track.arcs.first()?;
        Some(Flight {
            time_s: first.start_s,
            state: track.state(first, first.start_s),
        })
    });
    let mut shot = Shot {
        world,
        flights: flights.collect(),
        result: SingleShot::default(),
    };
    for event in &world.estimate.events {
        if let Some(collision) = world.scene.events[event.event].kind.collision() {
            shot.collide(event, collision);
        }
    }
    shot.end();
    shot.result
}

impl Shot<'_> {
    fn collide(&mut self, event: &EventEstimate, collision: &Collision) {
        let bodies: Vec<usize> = collision
            .bodies()
            .filter(|&body| self.world.tracks[body].ending_at(event.time_s).is_some())
            .collect();
        if bodies.is_empty() {
            return;
        }
        for &body in &bodies {
            self.advance(body, event.time_s);
        }
        let offset_s = self.contact_offset_s(event, collision);
        let time_s = event.time_s + offset_s.unwrap_or(0.0);
        for &body in &bodies {
            self.advance(body, time_s);
            self.compare(body, Some(event.event), event.time_s);
        }
        if offset_s.is_none() {
            self.result.missed.push(event.event);
        }
        let gap = &event.gap;
        let is_bent = gap.velocity_m_s > GAP_M_S || gap.angular_velocity_rad_s > GAP_RAD_S;
        let law = Law::new(self.world.scene, self.world.estimate, event.event);
        match (law, offset_s) {
            (Some(law), Some(_)) if !is_bent => {
                let body = &self.world.scene.bodies[law.body].body;
                if let Some(flight) = &mut self.flights[law.body] {
                    flight.state = law.after(body, &flight.state);
                }
            }
            _ => {
                self.result.restarts.push(event.event);
                for body in bodies {
                    self.restart(body, event.time_s);
                }
            }
        }
    }

    fn advance(&mut self, body: usize, time_s: f64) {
        if let Some(flight) = &mut self.flights[body] {
            flight.state = series::advance(
                &self.world.scene.bodies[body].body,
                &self.world.estimate.gravity_m_s2,
                &flight.state,
                time_s - flight.time_s,
            );
            flight.time_s = time_s;
        }
    }

    fn restart(&mut self, body: usize, time_s: f64) {
        let track = &self.world.tracks[body];
        if let Some(arc) = track.starting_at(time_s) {
            let state = track.state(arc, time_s);
            self.flights[body] = Some(Flight { time_s, state });
        }
    }

    /// How much later than the flights' time the expected features touch \[s\].
    fn contact_offset_s(&self, event: &EventEstimate, collision: &Collision) -> Option<f64> {
        let gap_m = |offset_s: f64| self.gap_m(event, collision, offset_s);
        let mut reach_s = FIRST_REACH_S;
        while !(gap_m(-reach_s)? > 0.0 && gap_m(reach_s)? < 0.0) {
            reach_s *= GROWTH;
            if reach_s > LAST_REACH_S {
                return None;
            }
        }
        let (mut apart_s, mut inside_s) = (-reach_s, reach_s);
        for _ in 0..HALVINGS {
            let middle_s = 0.5 * (apart_s + inside_s);
            if inside_s - apart_s <= f64::EPSILON * event.time_s.abs() {
                break;
            }
            if gap_m(middle_s)? > 0.0 {
                apart_s = middle_s;
            } else {
                inside_s = middle_s;
            }
        }
        Some(0.5 * (apart_s + inside_s))
    }

    /// Least distance of the expected features from their partners; `None` where the scene
    /// leaves all of them open.
    fn gap_m(&self, event: &EventEstimate, collision: &Collision, offset_s: f64) -> Option<f64> {
        let pose = |body: usize| {
            let flight = self.flights[body]?;
            let body = &self.world.scene.bodies[body].body;
            let gravity = &self.world.estimate.gravity_m_s2;
            let state = series::advance(body, gravity, &flight.state, offset_s);
            Some(state.world_from_body())
        };
        let world_from_body = pose(collision.body)?;
        let world_from_other = match collision.partner {
            Hit::World => None,
            Hit::Body(other) => Some((other, pose(other)?)),
        };
        collision
            .contacts
            .iter()
            .filter_map(|contact| match world_from_other {
                None => self.gap_from_world_m(collision.body, &world_from_body, contact),
                Some((other, world_from_other)) => {
                    let first = (collision.body, &world_from_body, contact.feature);
                    let second = (other, &world_from_other, contact.other);
                    self.gap_of_bodies_m(event.time_s, first, second)
                }
            })
            .reduce(f64::min)
    }

    fn gap_from_world_m(
        &self,
        body: usize,
        world_from_body: &Pose,
        contact: &Touching,
    ) -> Option<f64> {
        let surface = contact.other?;
        let against = match self.world.scene.surfaces[surface].obstacle {
            Some(obstacle) => Against::Obstacle(obstacle),
            None => Against::Surface(surface),
        };
        let partner = self.world.partner(against, None)?;
        Some(match self.ball(body, contact.feature, world_from_body) {
            Some((ball, pose)) => partner.gap_m(&ball, &pose, None),
            None => partner.gap_m(&self.world.tracks[body].solid, world_from_body, None),
        })
    }

    fn gap_of_bodies_m(
        &self,
        time_s: f64,
        (body, world_from_body, feature): (usize, &Pose, Option<usize>),
        (other, world_from_other, other_feature): (usize, &Pose, Option<usize>),
    ) -> Option<f64> {
        let partner = |index| self.world.partner(Against::Body(index), Some(time_s));
        let (first, second): (Partner, Partner) = (partner(body)?, partner(other)?);
        if let Some((ball, pose)) = self.ball(body, feature, world_from_body) {
            return Some(second.gap_m(&ball, &pose, Some(world_from_other)));
        }
        if let Some((ball, pose)) = self.ball(other, other_feature, world_from_other) {
            return Some(first.gap_m(&ball, &pose, Some(world_from_body)));
        }
        let solid = &self.world.tracks[body].solid;
        Some(second.gap_m(solid, world_from_body, Some(world_from_other)))
    }

    /// A point feature as the ball that it is.
    fn ball(&self, body: usize, feature: Option<usize>, pose: &Pose) -> Option<(Solid, Pose)> {
        let feature = &self.world.scene.bodies[body].features[feature?];
        let Feature::Point { point_m, radius_m } = feature.geometry else {
            return None;
        };
        let centre_m = pose * Point3::from(point_m);
        Some((Solid::ball(radius_m), Pose::from(centre_m.coords)))
    }

    fn end(&mut self) {
        for body in 0..self.flights.len() {
            let Some(last) = self.world.tracks[body].arcs.last() else {
                continue;
            };
            let time_s = last.end_s;
            // What ends with a collision was compared before it.
            let is_compared = self.world.estimate.events.iter().any(|event| {
                let kind = &self.world.scene.events[event.event].kind;
                let hits = kind.collision().is_some_and(|hit| hit.concerns(body));
                hits && event.time_s == time_s
            });
            if !is_compared {
                self.advance(body, time_s);
                self.compare(body, None, time_s);
            }
        }
    }

    /// Compares a flight with the estimate's state at the end of an arc.
    fn compare(&mut self, body: usize, event: Option<usize>, time_s: f64) {
        let track = &self.world.tracks[body];
        let (Some(flight), Some(arc)) = (self.flights[body], track.ending_at(time_s)) else {
            return;
        };
        let difference = flight.state.minus(&track.state(arc, time_s));
        let norm = |part: usize| difference.fixed_rows::<3>(part).norm();
        use crate::physics::state::part;
        self.result.deviations.push(Deviation {
            body,
            event,
            time_s: (flight.time_s - time_s).abs(),
            position_m: norm(part::POSITION),
            orientation_rad: norm(part::ORIENTATION),
            velocity_m_s: norm(part::VELOCITY),
            angular_velocity_rad_s: norm(part::ANGULAR_VELOCITY),
        });
    }
}
