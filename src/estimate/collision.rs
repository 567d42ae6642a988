//! The rows of a collision: contact, approach and continuity through the impact (paper eq. 3, 8,
//! §5.2), for one body or two.
//!
//! Rows come in this order: gaps of the contacts, their approach speeds, then for every body what
//! position, orientation, velocity and angular velocity after it differ from the impact's. Where
//! velocity gaps are priced instead of closed, the last two are rows of a block of their own.

use nalgebra::{Matrix3, Vector3};

use super::arc_end::{ArcEnd, ByState};
use super::block::{Block, BlockPattern};
use super::layout::{Layout, STATE};
use super::point::Point;
use super::problem::{Collision, Problem, unit};
use crate::math::so3;
use crate::motion::Gap;
use crate::physics::State;
use crate::physics::contact::Feature;
use crate::physics::impact::{self, Impact, ImpactDerivative};
use crate::physics::state::part;

/// Rows of a body's pose, and of its velocities.
const HALF: usize = STATE / 2;

/// Where rows and columns of a collision are.
struct Places {
    contacts: usize,
    approaches: usize,
    /// Rows of every body in the constraints.
    rows_per_body: usize,
    bodies: usize,
    /// The first part of the states before that the velocities after hang on: one body bounces off
    /// a face alike wherever it touches.
    first_part: usize,
}

impl Places {
    fn new(problem: &Problem, collision: &Collision) -> Self {
        let bodies = collision.sides.len();
        let contacts = collision.meeting.contacts();
        let is_face = |feature: &Feature| matches!(feature, Feature::Face { .. });
        let is_alike = bodies == 1 && contacts.iter().all(|contact| is_face(contact.b()));
        Self {
            contacts: if collision.touches_by_goal {
                0
            } else {
                contacts.len()
            },
            approaches: contacts.len(),
            rows_per_body: if problem.velocity_gap_weight.is_some() {
                HALF
            } else {
                STATE
            },
            bodies,
            first_part: if is_alike {
                part::ORIENTATION
            } else {
                part::POSITION
            },
        }
    }

    /// First row of a body.
    fn of_body(&self, body: usize) -> usize {
        self.contacts + self.approaches + body * self.rows_per_body
    }
}

/// What the rows of a collision touch, and those of its velocity gaps where these are priced. In
/// the order of a row's columns: states before, the event's time, the state after, gravity,
/// restitution, friction, tilts, as far as they go.
pub fn patterns(
    problem: &Problem,
    layout: &Layout,
    collision: &Collision,
) -> (BlockPattern, BlockPattern) {
    let places = Places::new(problem, collision);
    let (mut block, mut gaps) = (BlockPattern::default(), BlockPattern::default());
    let time = layout.events[collision.event];
    let parts = |arc: usize, parts: &[usize]| -> Vec<usize> {
        let first = parts.iter().map(|part| layout.arcs[arc] + part);
        first.flat_map(|first| first..first + 3).collect()
    };
    let before = |first_part: usize| -> Vec<usize> {
        let arcs = collision.sides.iter().map(|side| layout.arcs[side.before]);
        let states = arcs.flat_map(|at| at + first_part..at + STATE);
        states.chain(time).collect()
    };
    let gravity = layout.gravity(problem);
    let touching = [before(part::POSITION), gravity.clone()].concat();
    block.push(places.contacts, touching.clone());
    block.push(places.approaches, touching);
    let law = [
        collision.restitution_parameter,
        collision.friction_parameter,
    ];
    let tilts = collision.tilts.iter().map(|(_, p)| *p);
    let law = law.into_iter().flatten().chain(tilts);
    let law: Vec<usize> = law.map(|p| layout.parameters[p]).collect();
    for side in &collision.sides {
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
        let velocities = if places.rows_per_body == STATE {
            &mut block
        } else {
            &mut gaps
        };
        for part in [part::VELOCITY, part::ANGULAR_VELOCITY] {
            let (before, after) = (before(places.first_part), parts(side.after, &[part]));
            velocities.push(3, [before, after, gravity.clone(), law.clone()].concat());
        }
    }
    (block, gaps)
}

/// Fills the block with the rows of a collision, and `gaps` with its velocity gaps where those are
/// priced, each with its pattern. `approach_limit_m_s` is the greatest normal speed contacts may
/// have on arrival (zero: they must not recede). In poses in which the impact has no answer all rows
/// are NaN. The impact's derivatives are left in `derivative`.
pub fn fill(
    problem: &Problem,
    collision: &Collision,
    (point, epochs_s): (&Point, &[f64]),
    approach_limit_m_s: f64,
    derivative: &mut ImpactDerivative,
    [(pattern, block), (gap_pattern, gaps)]: [(&BlockPattern, &mut Block); 2],
) {
    let places = Places::new(problem, collision);
    block.reset(pattern);
    block.approach = places.contacts..places.contacts + places.approaches;
    gaps.reset(gap_pattern);

    let arrive = arrivals(problem, collision, point, epochs_s);
    let before = before(collision, &arrive);
    let [a, b] = sides(problem, collision, &before);
    let a = a.expect("a first body");
    let law = collision.law(&point.parameters);
    let Ok(impact) = collision
        .meeting
        .derivative(&a, b.as_ref(), &law, derivative)
    else {
        block.spoil();
        gaps.spoil();
        return;
    };
    let mut rows = Rows {
        problem,
        collision,
        places,
        block: (pattern, block),
        gaps: (gap_pattern, gaps),
    };
    rows.fill_contacts(&impact, approach_limit_m_s);
    rows.fill_contact_derivatives(derivative, &before);
    for (body, side) in collision.sides.iter().enumerate() {
        let Some(arrival) = &before[body] else {
            continue;
        };
        let after = arrive(side.body, side.after);
        let bounced = State {
            velocity_m_s: impact.after[body].velocity_m_s,
            angular_velocity_rad_s: impact.after[body].angular_velocity_rad_s,
            ..arrival.state
        };
        let gap = after.state.minus(&bounced);
        let turn: Vector3<f64> = gap.fixed_rows::<3>(part::ORIENTATION).into();
        rows.fill_positions(body, &gap.fixed_rows::<3>(0).into(), (arrival, &after));
        rows.fill_orientations(body, &turn, (arrival, &after));
        for half in [Half::Velocity, Half::Spin] {
            let gap = gap.fixed_rows::<3>(HALF + half as usize).into();
            rows.fill_velocities(body, half, &gap, derivative, (&before, &after));
        }
    }
}

/// How states arrive at the collision's event: of a body, by the arc.
fn arrivals<'a>(
    problem: &'a Problem,
    collision: &Collision,
    point: &'a Point,
    epochs_s: &'a [f64],
) -> impl Fn(usize, usize) -> ArcEnd + use<'a> {
    let gravity = problem.gravity(&point.parameters);
    let time_s = point.event_times_s[collision.event];
    move |body, arc| {
        let flight = (&point.arcs[arc], epochs_s[arc]);
        ArcEnd::new(&problem.bodies[body], &gravity, flight, time_s)
    }
}

/// How every body arrives.
fn before(collision: &Collision, arrive: &impl Fn(usize, usize) -> ArcEnd) -> [Option<ArcEnd>; 2] {
    [0, 1].map(|side| {
        let side = collision.sides.get(side);
        side.map(|side| arrive(side.body, side.before))
    })
}

fn sides<'a>(
    problem: &'a Problem,
    collision: &Collision,
    before: &'a [Option<ArcEnd>; 2],
) -> [Option<impact::Side<'a>>; 2] {
    [0, 1].map(|side: usize| {
        let state = &before[side].as_ref()?.state;
        let body = &problem.bodies[collision.sides[side].body];
        Some(impact::Side { body, state })
    })
}

/// The fastest approach of the contacts, as a negative speed [m/s]; zero where none approaches or
/// the impact has no answer.
pub fn fastest_approach_m_s(
    problem: &Problem,
    collision: &Collision,
    point: &Point,
    epochs_s: &[f64],
) -> f64 {
    let arrive = arrivals(problem, collision, point, epochs_s);
    let before = before(collision, &arrive);
    let [a, b] = sides(problem, collision, &before);
    let a = a.expect("a first body");
    let law = collision.law(&point.parameters);
    let impact = collision.meeting.impact(&a, b.as_ref(), &law);
    impact.map_or(0.0, |impact| {
        let speeds = impact.speeds_m_s.into_iter();
        speeds.fold(0.0, f64::min)
    })
}

/// A body's velocities, by their first row among both.
#[derive(Clone, Copy)]
enum Half {
    Velocity = 0,
    Spin = 3,
}

/// The two blocks of a collision on their way.
struct Rows<'a> {
    problem: &'a Problem,
    collision: &'a Collision,
    places: Places,
    block: (&'a BlockPattern, &'a mut Block),
    gaps: (&'a BlockPattern, &'a mut Block),
}

impl Rows<'_> {
    fn fill_contacts(&mut self, impact: &Impact, approach_limit_m_s: f64) {
        let (_, block) = &mut self.block;
        for contact in 0..self.places.approaches {
            if contact < self.places.contacts {
                block.values[contact] = impact.gaps_m[contact] / unit::POSITION_M;
            }
            let row = self.places.contacts + contact;
            block.values[row] = impact.speeds_m_s[contact] / unit::VELOCITY_M_S;
            block.bounds[row] = (f64::NEG_INFINITY, approach_limit_m_s / unit::VELOCITY_M_S);
        }
    }

    /// Derivatives of gaps and approach speeds by the arrivals.
    fn fill_contact_derivatives(
        &mut self,
        derivative: &ImpactDerivative,
        before: &[Option<ArcEnd>; 2],
    ) {
        let (contacts, approaches) = (self.places.contacts, self.places.approaches);
        let gaps = derivative.gap[..contacts].iter();
        let speeds = derivative.speed[..approaches].iter();
        let units = [unit::POSITION_M, unit::VELOCITY_M_S];
        let gaps = gaps.map(|by| (by, 1.0 / units[0]));
        let speeds = speeds.map(|by| (by, 1.0 / units[1]));
        for (row, (by_arrivals, scale)) in gaps.chain(speeds).enumerate() {
            let (pattern, block) = &mut self.block;
            let (states, rest) = block
                .derivatives_mut(pattern, row)
                .split_at_mut(STATE * self.places.bodies);
            rest.fill(0.0);
            for (body, arrival) in before.iter().enumerate() {
                let Some(arrival) = arrival else { continue };
                let by = ByState::<1>::of(&by_arrivals[body], 0);
                let state = &mut states[STATE * body..][..STATE];
                arrival.chain(&by).put(0, scale, part::POSITION, state);
                rest[0] += arrival.by_time(&by)[0] * scale;
                for (axis, entry) in self.problem.free_gravity().zip(&mut rest[1..]) {
                    *entry += arrival.by_gravity(&by, axis)[0] * scale;
                }
            }
        }
    }

    /// What the position of a body after differs from that before, and its derivatives.
    fn fill_positions(
        &mut self,
        body: usize,
        gap: &Vector3<f64>,
        (before, after): (&ArcEnd, &ArcEnd),
    ) {
        let (pattern, block) = &mut self.block;
        let (s, t) = (before.duration_s, after.duration_s);
        let scale = 1.0 / unit::POSITION_M;
        for axis in 0..3 {
            let row = self.places.of_body(body) + axis;
            block.values[row] = gap[axis] * scale;
            let speed = after.rate[axis] - before.rate[axis];
            let all = [-1.0, -s, speed, 1.0, t, 0.5 * (t * t - s * s)];
            let to = block.derivatives_mut(pattern, row);
            for (entry, by) in to.iter_mut().zip(all) {
                *entry = by * scale;
            }
        }
    }

    /// What the orientation of a body after is turned from that before, and its derivatives.
    fn fill_orientations(
        &mut self,
        body: usize,
        turn: &Vector3<f64>,
        (before, after): (&ArcEnd, &ArcEnd),
    ) {
        let (pattern, block) = &mut self.block;
        let scale = 1.0 / unit::ORIENTATION_RAD;
        let by_after = so3::right_jacobian_inverse(turn) * scale;
        let by_before = -by_after.transpose();
        let rate = |arrival: &ArcEnd| -> Vector3<f64> {
            arrival.rate.fixed_rows::<3>(part::ORIENTATION).into()
        };
        let by_time = by_before * rate(before) + by_after * rate(after);
        let chained = [(&by_before, before), (&by_after, after)]
            .map(|(by, arrival)| [by * arrival.by_orientation, by * arrival.turn_by_spin]);
        for axis in 0..3 {
            let row = self.places.of_body(body) + part::ORIENTATION + axis;
            block.values[row] = turn[axis] * scale;
            let to = block.derivatives_mut(pattern, row);
            for ([by_orientation, by_spin], first) in chained.iter().zip([0, HALF + 1]) {
                for other in 0..3 {
                    to[first + other] = by_orientation[(axis, other)];
                    to[first + 3 + other] = by_spin[(axis, other)];
                }
            }
            to[HALF] = by_time[axis];
        }
    }

    /// What the velocity or the angular velocity of a body after differs from the impact's, and its
    /// derivatives.
    fn fill_velocities(
        &mut self,
        body: usize,
        half: Half,
        gap: &Vector3<f64>,
        derivative: &ImpactDerivative,
        (before, after): (&[Option<ArcEnd>; 2], &ArcEnd),
    ) {
        let scale = match half {
            Half::Velocity => 1.0 / unit::VELOCITY_M_S,
            Half::Spin => 1.0 / unit::ANGULAR_VELOCITY_RAD_S,
        };
        let first = half as usize;
        let mut by_time: Vector3<f64> = after.rate.fixed_rows::<3>(HALF + first).into();
        let (by_after, mut by_gravity) = match half {
            Half::Velocity => (
                Matrix3::identity(),
                Matrix3::from_diagonal_element(after.duration_s),
            ),
            Half::Spin => (after.spin_by_spin, Matrix3::zeros()),
        };
        let from = self.places.first_part;
        let ((pattern, block), row) = if self.places.rows_per_body == STATE {
            (&mut self.block, self.places.of_body(body) + HALF + first)
        } else {
            (&mut self.gaps, body * HALF + first)
        };
        for (other, arrival) in before.iter().enumerate() {
            let Some(arrival) = arrival else { continue };
            let by = ByState::<3>::of(&derivative.after[body][other], first);
            let chained = arrival.chain(&by);
            for axis in 0..3 {
                let to = block.derivatives_mut(pattern, row + axis);
                let to = &mut to[(STATE - from) * other..][..STATE - from];
                chained.put(axis, -scale, from, to);
            }
            by_time -= arrival.by_time(&by);
            for axis in self.problem.free_gravity() {
                let mut column = by_gravity.column_mut(axis);
                column -= arrival.by_gravity(&by, axis);
            }
        }
        for axis in 0..3 {
            block.values[row + axis] = gap[axis] * scale;
            let to = block.derivatives_mut(pattern, row + axis);
            let states = (STATE - from) * self.places.bodies;
            let by_law = by_law(self.collision, derivative, body, first + axis);
            let gravity = self.problem.free_gravity();
            let rest = std::iter::once(by_time[axis])
                .chain((0..3).map(|other| by_after[(axis, other)]))
                .chain(gravity.map(|other| by_gravity[(axis, other)]))
                .chain(by_law.map(|by| -by));
            for (entry, by) in to[states..].iter_mut().zip(rest) {
                *entry = by * scale;
            }
        }
    }
}

/// Derivatives of a velocity after by restitution, friction and tilts, where they are free.
fn by_law<'a>(
    collision: &'a Collision,
    derivative: &'a ImpactDerivative,
    body: usize,
    row: usize,
) -> impl Iterator<Item = f64> + 'a {
    let restitution = collision.restitution_parameter;
    let friction = collision.friction_parameter;
    let tilts = collision.tilts.iter();
    let by_restitution = restitution.map(|_| derivative.after_by_restitution[body][row]);
    let by_friction = friction.map(|_| derivative.after_by_friction[body][row]);
    let by_tilts = tilts.map(move |(tangent, _)| derivative.after_by_tilt[body][(row, *tangent)]);
    by_restitution
        .into_iter()
        .chain(by_friction)
        .chain(by_tilts)
}

/// What a collision's rows leave, in SI units.
pub fn gap(problem: &Problem, collision: &Collision, (block, gaps): (&Block, &Block)) -> Gap {
    let places = Places::new(problem, collision);
    let contacts = block.largest(0..places.contacts) * unit::POSITION_M;
    let approach = block.largest(block.approach.clone()) * unit::VELOCITY_M_S;
    let mut gap = Gap {
        position_m: contacts,
        velocity_m_s: approach,
        ..Gap::default()
    };
    for body in 0..places.bodies {
        let at = places.of_body(body);
        let (velocities, from) = if places.rows_per_body == STATE {
            (block, at + HALF)
        } else {
            (gaps, body * HALF)
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
