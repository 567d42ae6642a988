//! A collision of one body with the static world or a held body, or of two bodies with each other
//! (paper eq. 3, 8, §5.2).
//!
//! Rows come in this order: gaps of the contacts, their approach speeds (`contact`), then for every
//! body the differences of position, orientation, velocity and angular velocity after it from the
//! impact's (`continuity`). Where velocity gaps are priced instead of closed, the last two are in
//! a block of their own. One evaluation of the impact serves all rows.

use std::ops::Range;

use nalgebra::Vector3;

use super::general;
use super::kind::{At, Constraint, Filled};
use super::rows::{CollisionRows, HALF, Half, Places, STATE};
use crate::estimate::problem::{ArcCollision, Problem, unit};
use crate::estimate::reach::arc_end::ArcEnd;
use crate::estimate::unknowns::layout::Layout;
use crate::estimate::unknowns::point::Point;
use crate::motion::Gap;
use crate::optimise::block::{Block, BlockPattern};
use crate::physics::impact;
use crate::physics::state::part;
use crate::physics::{Body, State};

impl Constraint for ArcCollision {
    /// In the order of a row's columns: states before, the event's time, the state after, gravity,
    /// restitution, friction, tangential restitution, tilts, as far as they go.
    fn patterns(&self, problem: &Problem, layout: &Layout) -> [BlockPattern; 2] {
        if !self.is_plain {
            return general::patterns(self, problem, layout);
        }
        let places = Places::new(problem, self);
        let (mut block, mut gaps) = (BlockPattern::default(), BlockPattern::default());
        let time = layout.events[self.event];
        let parts = |arc: usize, parts: &[usize]| -> Vec<usize> {
            let first = parts.iter().map(|part| layout.arcs[arc] + part);
            first.flat_map(|first| first..first + 3).collect()
        };
        let before = |first_part: usize| -> Vec<usize> {
            let arcs = self.sides.iter().map(|side| layout.arcs[side.before]);
            let arcs = arcs.chain(self.held.map(|held| layout.held[held]));
            let states = arcs.flat_map(|at| at + first_part..at + STATE);
            states.chain(time).collect()
        };
        let gravity = layout.gravity(problem);
        let touching = [before(part::POSITION), gravity.clone()].concat();
        block.push(places.contacts, touching.clone());
        block.push(places.approaches, touching);
        let law = [
            self.restitution_parameter,
            self.friction_parameter,
            self.tangential_parameter,
        ];
        let tilts = self.tilts.iter().map(|(_, p)| *p);
        let law = law.into_iter().flatten().chain(tilts);
        let law: Vec<usize> = law.map(|p| layout.parameters[p]).collect();
        for side in &self.sides {
            let [from, to] = [side.before, side.after].map(|arc| layout.arcs[arc]);
            for axis in 0..3 {
                let of = |arc: usize| [arc + part::POSITION + axis, arc + part::VELOCITY + axis];
                let gravity = problem.gravity_parameters[axis].map(|p| layout.parameters[p]);
                let states = of(from).into_iter().chain(time).chain(of(to));
                block.push(1, states.chain(gravity));
            }
            let turn = [part::ORIENTATION, part::ANGULAR_VELOCITY];
            let (from, to) = (parts(side.before, &turn), parts(side.after, &turn));
            block.push(3, from.into_iter().chain(time).chain(to));
            let velocities = if places.rows_per_side == STATE {
                &mut block
            } else {
                &mut gaps
            };
            for part in [part::VELOCITY, part::ANGULAR_VELOCITY] {
                let (before, after) = (before(places.first_part), parts(side.after, &[part]));
                velocities.push(3, [before, after, gravity.clone(), law.clone()].concat());
            }
        }
        [block, gaps]
    }

    /// In poses in which the impact is undetermined all rows are NaN.
    fn fill(&self, at: &mut At, [(pattern, block), (gap_pattern, gaps)]: [Filled; 2]) {
        let problem = at.problem;
        let places = Places::new(problem, self);
        block.reset(pattern);
        block.leads = places.contacts..places.contacts + places.approaches;
        gaps.reset(gap_pattern);
        if !self.is_plain {
            let rows = [(pattern, &mut *block), (gap_pattern, &mut *gaps)];
            if general::fill(self, at, rows).is_none() {
                block.spoil();
                gaps.spoil();
            }
            return;
        }

        let arrive = arrivals(problem, self, at.point, at.epochs_s);
        let before = before(self, at.point, &arrive);
        let [a, b] = sides(problem, self, &before);
        let a = a.expect("a first side");
        let law = self.law(&at.point.parameters);
        let derivative = &mut at.impact;
        let Ok(impact) = self.contacts.derivative(&a, b.as_ref(), &law, derivative) else {
            block.spoil();
            gaps.spoil();
            return;
        };
        let mut rows = CollisionRows {
            problem,
            collision: self,
            places,
            block: (pattern, block),
            gaps: (gap_pattern, gaps),
        };
        let limits_m_s = at.approach_limits_m_s.get(self.event);
        rows.fill_contacts(&impact, limits_m_s.copied().unwrap_or(0.0));
        rows.fill_contact_derivatives(derivative, &before);
        for (index, (side, arrival)) in self.sides.iter().zip(&before).enumerate() {
            let Some(arrival) = arrival else { continue };
            let after = arrive(side.after);
            let bounced = State {
                velocity_m_s: impact.after[index].velocity_m_s,
                angular_velocity_rad_s: impact.after[index].angular_velocity_rad_s,
                ..arrival.state
            };
            let gap = after.state.minus(&bounced);
            let turn: Vector3<f64> = gap.fixed_rows::<3>(part::ORIENTATION).into();
            rows.fill_positions(index, &gap.fixed_rows::<3>(0).into(), arrival, &after);
            rows.fill_orientations(index, &turn, arrival, &after);
            for half in [Half::Velocity, Half::Spin] {
                let gap = gap.fixed_rows::<3>(HALF + half as usize).into();
                rows.fill_velocities(index, half, &gap, derivative, &before, &after);
            }
        }
    }

    fn event(&self) -> Option<usize> {
        Some(self.event)
    }

    fn gap(&self, problem: &Problem, [block, gaps]: [&Block; 2]) -> Gap {
        let places = Places::new(problem, self);
        let contacts = block.largest(0..places.contacts) * unit::POSITION_M;
        let approach = block.largest(block.leads.clone()) * unit::VELOCITY_M_S;
        let mut gap = Gap {
            position_m: contacts,
            velocity_m_s: approach,
            ..Gap::default()
        };
        for side in 0..places.sides {
            let at = places.of_side(side);
            let (velocities, from) = if places.rows_per_side == STATE {
                (block, at + HALF)
            } else {
                (gaps, side * HALF)
            };
            gap = gap.max(&Gap {
                position_m: block.largest(at..at + 3) * unit::POSITION_M,
                orientation_rad: block.largest(at + 3..at + HALF) * unit::ORIENTATION_RAD,
                velocity_m_s: velocities.largest(from..from + 3) * unit::VELOCITY_M_S,
                angular_velocity_rad_s: velocities.largest(from + 3..from + HALF)
                    * unit::ANGULAR_VELOCITY_RAD_S,
            });
        }
        gap
    }

    /// Contacts and poses.
    fn places(&self, block: &Block) -> Vec<Range<usize>> {
        let (contacts, approach) = (0..block.leads.start, block.leads.end);
        let per_side = (block.values.len() - approach) / self.sides.len();
        let poses = (0..self.sides.len()).map(|side| {
            let first = approach + side * per_side;
            first..first + HALF
        });
        std::iter::once(contacts).chain(poses).collect()
    }

    fn is_curved(&self) -> bool {
        true
    }
}

/// The states of arcs at the collision's event, with their derivatives.
fn arrivals<'a>(
    problem: &'a Problem,
    collision: &ArcCollision,
    point: &'a Point,
    epochs_s: &'a [f64],
) -> impl Fn(usize) -> ArcEnd + use<'a> {
    let gravity = problem.gravity(&point.parameters);
    let time_s = point.event_times_s[collision.event];
    move |arc| {
        let body = problem.body_of(arc);
        ArcEnd::new(body, &gravity, point, arc, [epochs_s[arc], time_s])
    }
}

/// The states of all bodies before the collision, a held one last.
fn before(
    collision: &ArcCollision,
    point: &Point,
    arrive: &impl Fn(usize) -> ArcEnd,
) -> [Option<ArcEnd>; 2] {
    [0, 1].map(|index| match collision.sides.get(index) {
        Some(side) => Some(arrive(side.before)),
        None => {
            let held = collision.held.filter(|_| index > 0)?;
            Some(ArcEnd::given(&point.held[held]))
        }
    })
}

fn sides<'a>(
    problem: &'a Problem,
    collision: &ArcCollision,
    before: &'a [Option<ArcEnd>; 2],
) -> [Option<impact::Side<'a>>; 2] {
    [0, 1].map(|side: usize| {
        let state = &before[side].as_ref()?.state;
        let body = match collision.sides.get(side) {
            Some(side) => problem.body_of(side.before),
            None => &Body::IMMOVABLE,
        };
        Some(impact::Side { body, state })
    })
}

/// The fastest approach of the contacts, as a negative speed [m/s]; zero where none approaches or
/// the impact is undetermined.
pub fn fastest_approach_m_s(
    problem: &Problem,
    collision: &ArcCollision,
    point: &Point,
    epochs_s: &[f64],
) -> f64 {
    let arrive = arrivals(problem, collision, point, epochs_s);
    let before = before(collision, point, &arrive);
    let [a, b] = sides(problem, collision, &before);
    let a = a.expect("a first side");
    let law = collision.law(&point.parameters);
    let impact = collision.contacts.impact(&a, b.as_ref(), &law);
    impact.map_or(0.0, |impact| {
        let speeds = impact.speeds_m_s.into_iter();
        speeds.fold(0.0, f64::min)
    })
}
