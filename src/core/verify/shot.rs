//! The single shot: the whole motion simulated from the first states alone.
//!
//! All links fly at once, by [`super::series`]; collisions come in the scene's order. Each
//! happens where the gap of one of its contacts ([`super::gap`]) becomes zero, and follows the
//! law of impact with the estimated parameters. Where the estimate leaves a velocity gap, or a
//! collision does not happen, the simulation continues from the estimate's own state.

use nalgebra::{Matrix3, Vector3};
use typed_index_collections::TiVec;

use super::gap::Gaps;
use super::law::CheckedLaw;
use super::meeting::World;
use super::{series, tied};
use crate::math::so3;
use crate::motion::{Deviation, EventEstimate, LinkIndex, SingleShot};
use crate::physics::impact::Velocities;
use crate::physics::{State, Support};

/// Velocity gaps above these are violations of the law, not rounding.
const GAP_M_S: f64 = 1e-6;
const GAP_RAD_S: f64 = 1e-5;

/// First half width of the interval in which a contact is searched \[s\], and its growth.
const FIRST_REACH_S: f64 = 1e-9;
const GROWTH: f64 = 8.0;

/// Greatest half width of that interval \[s\].
const LAST_REACH_S: f64 = 0.05;

/// Greatest number of halvings of that interval.
const HALVINGS: usize = 60;

/// The current state of a body in the simulation.
#[derive(Clone, Copy)]
struct SimulatedFlight {
    time_s: f64,
    state: State,
}

struct FreeShot<'w> {
    world: &'w World<'w>,
    /// One per link with arcs.
    flights: TiVec<LinkIndex, Option<SimulatedFlight>>,
    result: SingleShot,
}

/// Simulates all links, and compares at every collision and at the end.
pub(super) fn shoot<'w>(world: &'w World<'w>) -> SingleShot {
    let flights = world.links.iter().map(|link| {
        let first = link.arcs.first()?;
        // A held body follows its own motion; nothing is simulated of it.
        Some(SimulatedFlight {
            time_s: first.start_s,
            state: link.state(first, first.start_s),
        })
    });
    let mut shot = FreeShot {
        world,
        flights: flights.collect(),
        result: SingleShot::default(),
    };
    for event in &world.estimate.events {
        if world.scene.events[event.event].kind.collision().is_some() {
            shot.collide(event);
        }
        if world.scene.events[event.event].kind.change().is_some() {
            for link in world.scene.links_at(event.event) {
                shot.advance(link, event.time_s);
                shot.compare(link, Some(event.event), event.time_s);
                shot.catch(link, event.time_s);
                shot.put_down(link, event.time_s);
            }
            shot.merge(event.event);
        }
    }
    shot.end();
    shot.result
}

impl FreeShot<'_> {
    fn collide(&mut self, event: &EventEstimate) {
        let collision = self.world.scene.events[event.event].kind.collision();
        let links: Vec<LinkIndex> = collision
            .into_iter()
            .flat_map(|collision| collision.links())
            .filter(|&link| self.world.links[link].ending_at(event.time_s).is_some())
            .collect();
        if links.is_empty() {
            return;
        }
        for &link in &links {
            self.advance(link, event.time_s);
        }
        let law = CheckedLaw::new(self.world.scene, self.world.estimate, event.event);
        let offset_s = law
            .as_ref()
            .and_then(|law| self.contact_offset_s(event, law));
        let time_s = event.time_s + offset_s.unwrap_or(0.0);
        for &link in &links {
            self.advance(link, time_s);
            self.compare(link, Some(event.event), event.time_s);
        }
        if offset_s.is_none() {
            self.result.missed.push(event.event);
        }
        let gap = &event.gap;
        let is_bent = gap.velocity_m_s > GAP_M_S || gap.angular_velocity_rad_s > GAP_RAD_S;
        let after = law
            .filter(|_| offset_s.is_some() && !is_bent)
            .and_then(|mut law| self.bounce(&mut law, event));
        if after.is_none() {
            self.result.restarts.push(event.event);
            for link in links {
                self.restart(link, event.left_s());
            }
        }
    }

    /// Ends what a pivot does not allow, where one catches the body.
    fn catch(&mut self, index: LinkIndex, time_s: f64) {
        let link = &self.world.links[index];
        let arc = link.starting_at(time_s);
        if let (Some(flight), Some(Support::Pivot(pivot))) =
            (&mut self.flights[index], arc.and_then(|arc| arc.support))
        {
            flight.state = tied::caught(&link.of_scene.body, &pivot, &flight.state);
        }
    }

    /// Makes of two bodies that stick together from an event on one, which turns about the centre of mass of both with the moments that both
    /// have there.
    fn merge(&mut self, event: usize) -> Option<()> {
        let pair = self.world.scene.stuck_at(event)?;
        let [one, other] = pair.links.map(|link| {
            let body = self.world.scene.links[link].body;
            Some((body, self.flights[link]?.state))
        });
        let both = [one?, other?];
        let mass_kg: f64 = both.iter().map(|(body, _)| body.mass_kg()).sum();
        let mean = |of: fn(&State) -> Vector3<f64>| {
            let each = both.iter();
            let each = each.map(|(body, state)| of(state) * (body.mass_kg() / mass_kg));
            each.sum::<Vector3<f64>>()
        };
        let (centre_m, velocity_m_s) = (mean(|of| of.position_m), mean(|of| of.velocity_m_s));
        let (mut inertia, mut turning) = (Matrix3::zeros(), Vector3::zeros());
        for (body, state) in &both {
            let arm = so3::hat(&(state.position_m - centre_m));
            let turn = so3::matrix(&state.orientation);
            let own = turn * Matrix3::from_diagonal(&body.moments_kg_m2()) * turn.transpose();
            inertia += own - arm * arm * body.mass_kg();
            turning += own * (state.orientation * state.angular_velocity_rad_s);
            turning += arm * state.velocity_m_s * body.mass_kg();
        }
        let spin = inertia.try_inverse()? * turning;
        for link in pair.links {
            if let Some(flight) = &mut self.flights[link] {
                let of = &mut flight.state;
                of.velocity_m_s = velocity_m_s + spin.cross(&(of.position_m - centre_m));
                of.angular_velocity_rad_s = of.orientation.inverse() * spin;
            }
        }
        Some(())
    }

    /// Begins again where a hand puts a body down: that ends its velocities.
    fn put_down(&mut self, index: LinkIndex, time_s: f64) {
        let link = &self.world.links[index];
        let arcs = (link.ending_at(time_s), link.starting_at(time_s));
        let (Some(before), Some(after)) = arcs else {
            return;
        };
        let is_put = link.grip(before).is_some() && after.support.is_some();
        if is_put {
            self.restart(index, time_s);
        }
    }

    /// Changes the velocities of the bodies that collide, and presses them as long as their contact lasts; `None` where the
    /// impact is undetermined.
    fn bounce(&mut self, law: &mut CheckedLaw, event: &EventEstimate) -> Option<()> {
        let state = |link: LinkIndex| Some(self.flights[link]?.state);
        let other = match law.other {
            None => None,
            Some(other) => Some(state(other)?),
        };
        let World {
            scene, estimate, ..
        } = self.world;
        let touching = state(law.link)?;
        let speed_m_s = law.impact(&touching, other.as_ref())?.speeds_m_s[0];
        law.press(
            scene
                .pressed_at(estimate, event, law.link, speed_m_s)
                .as_ref(),
        );
        let (after_of_link, after_of_other) = law.after(&touching, other.as_ref())?;
        let others = law.other.zip(after_of_other);
        for (link, after) in [(law.link, after_of_link)].into_iter().chain(others) {
            let pressed = scene.pressed_at(estimate, event, link, speed_m_s);
            if let Some(flight) = &mut self.flights[link] {
                flight.state = match pressed {
                    None => after,
                    Some(pressed) => {
                        flight.time_s += pressed.duration_s;
                        pressed.state(&flight.state, &Velocities::of(&after), pressed.duration_s)
                    }
                };
            }
        }
        Some(())
    }

    fn advance(&mut self, link: LinkIndex, time_s: f64) {
        if let Some(state) = self.state_at(link, time_s) {
            self.flights[link] = Some(SimulatedFlight { time_s, state });
        }
    }

    /// The state to which a flight leads; of a held body, that of its motion.
    fn state_at(&self, link: LinkIndex, time_s: f64) -> Option<State> {
        let flight = self.flights[link]?;
        if let Some(held) = self.world.links[link].held {
            return Some(held.state(time_s));
        }
        let middle_s = 0.5 * (time_s + flight.time_s);
        let arcs = &self.world.links[link].arcs;
        let on = arcs.iter().rfind(|arc| arc.start_s <= middle_s);
        let in_hand = on.and_then(|arc| self.world.links[link].grip(arc));
        if let Some(grip) = in_hand {
            return Some(grip.state(time_s));
        }
        let body = &self.world.scene.links[link].body;
        let body = &body.with_support(on.and_then(|arc| arc.support));
        let gravity = &self.world.estimate.gravity_m_s2;
        let since_s = time_s - flight.time_s;
        Some(series::advance(body, gravity, &flight.state, since_s))
    }

    fn restart(&mut self, index: LinkIndex, time_s: f64) {
        let link = &self.world.links[index];
        if let Some(arc) = link.starting_at(time_s) {
            let state = link.state(arc, time_s);
            self.flights[index] = Some(SimulatedFlight { time_s, state });
        }
    }

    /// Time of contact of the expected features less the flights' current time \[s\].
    fn contact_offset_s(&self, event: &EventEstimate, law: &CheckedLaw) -> Option<f64> {
        let pose = |link: LinkIndex, offset_s: f64| {
            let now_s = self.flights[link]?.time_s;
            let state = self.state_at(link, now_s + offset_s)?;
            Some(state.world_from_body())
        };
        let poses = |offset_s: f64| {
            let other = match law.other {
                None => None,
                Some(other) => Some(pose(other, offset_s)?),
            };
            Some((pose(law.link, offset_s)?, other))
        };
        // Just before contact, where the nearest points are distinct.
        let (body, other) = poses(-FIRST_REACH_S)?;
        let gaps = Gaps::new(self.world, law, event.event, &body, other.as_ref())?;
        let gap_m = |offset_s: f64| {
            let (body, other) = poses(offset_s)?;
            gaps.least_m(&body, other.as_ref())
        };
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

    fn end(&mut self) {
        for link in self.world.links.keys() {
            let Some(last) = self.world.links[link].arcs.last() else {
                continue;
            };
            let time_s = last.end_s;
            // A flight that ends with a collision was compared before it.
            let is_compared = self.world.estimate.events.iter().any(|event| {
                let kind = &self.world.scene.events[event.event].kind;
                let hits = kind
                    .collision()
                    .is_some_and(|hit| hit.links().any(|other| other == link));
                hits && event.time_s == time_s
            });
            if !is_compared {
                self.advance(link, time_s);
                self.compare(link, None, time_s);
            }
        }
    }

    /// Compares a flight with the estimate's state at the end of an arc.
    fn compare(&mut self, index: LinkIndex, event: Option<usize>, time_s: f64) {
        let link = &self.world.links[index];
        if link.held.is_some() {
            return;
        }
        let (Some(flight), Some(arc)) = (self.flights[index], link.ending_at(time_s)) else {
            return;
        };
        let difference = flight.state.minus(&link.state(arc, time_s));
        let norm = |part: usize| difference.fixed_rows::<3>(part).norm();
        use crate::physics::state::part;
        self.result.deviations.push(Deviation {
            link: index,
            event,
            time_s: (flight.time_s - time_s).abs(),
            position_m: norm(part::POSITION),
            orientation_rad: norm(part::ORIENTATION),
            velocity_m_s: norm(part::VELOCITY),
            angular_velocity_rad_s: norm(part::ANGULAR_VELOCITY),
        });
    }
}
