//! The rows of a collision: contact, approach and continuity through the impact (paper eq. 3, 8,
//! §5.2), for one body or two.
//!
//! Rows come in this order: gaps of the contacts, their approach speeds, then for every body what
//! position, orientation, velocity and angular velocity after it differ from the impact's. Where
//! velocity gaps are priced instead of closed, the last two are rows of a block of their own.

use nalgebra::{RowSVector, SMatrix, SVector, Vector3};

use super::constraint::{Arrival, Block, add_gravity};
use super::layout::STATE;
use super::point::Point;
use super::problem::{Collision, Problem, unit};
use crate::math::so3;
use crate::motion::Gap;
use crate::physics::State;
use crate::physics::impact::{self, Impact, ImpactDerivative};
use crate::physics::state::part;

/// Units of a state's tangent.
const STATE_UNITS: [f64; STATE] = {
    let (x, r) = (unit::POSITION_M, unit::ORIENTATION_RAD);
    let (v, w) = (unit::VELOCITY_M_S, unit::ANGULAR_VELOCITY_RAD_S);
    [x, x, x, r, r, r, v, v, v, w, w, w]
};
/// Rows of a body's pose, and of its velocities.
const HALF: usize = STATE / 2;

/// Where rows and columns of a collision are.
struct Places {
    contacts: usize,
    approaches: usize,
    /// Rows of every body in the constraints.
    rows_per_body: usize,
    bodies: usize,
    /// Of the event's time; gravity and the other parameters follow.
    time_column: usize,
    columns: usize,
}

impl Places {
    fn new(problem: &Problem, collision: &Collision) -> Self {
        let bodies = collision.sides.len();
        let approaches = collision.meeting.contacts().len();
        let time_column = 2 * STATE * bodies;
        let parameters = usize::from(collision.restitution_parameter.is_some())
            + usize::from(collision.friction_parameter.is_some())
            + collision.tilts.len();
        Self {
            contacts: if collision.touches_by_goal {
                0
            } else {
                approaches
            },
            approaches,
            rows_per_body: if problem.velocity_gap_weight.is_some() {
                HALF
            } else {
                STATE
            },
            bodies,
            time_column,
            columns: time_column + 1 + problem.gravity_count() + parameters,
        }
    }

    fn rows(&self) -> usize {
        self.contacts + self.approaches + self.bodies * self.rows_per_body
    }

    /// First row of a body.
    fn of_body(&self, body: usize) -> usize {
        self.contacts + self.approaches + body * self.rows_per_body
    }

    fn before(body: usize) -> usize {
        2 * STATE * body
    }

    fn after(body: usize) -> usize {
        2 * STATE * body + STATE
    }
}

/// Fills `block` with the rows of a collision, and `gaps` with its velocity gaps where those are
/// priced. `approach_limit_m_s` is the greatest normal speed contacts may have on arrival (zero:
/// they must not recede). In poses in which the impact has no answer all rows are NaN.
pub fn fill(
    problem: &Problem,
    collision: &Collision,
    point: &Point,
    epochs_s: &[f64],
    approach_limit_m_s: f64,
    (block, gaps): (&mut Block, &mut Block),
) {
    let places = Places::new(problem, collision);
    block.reset(places.rows(), places.columns);
    block.approach = places.contacts..places.contacts + places.approaches;
    let gap_rows = places.bodies * (STATE - places.rows_per_body);
    gaps.reset(gap_rows, places.columns);

    let gravity = problem.gravity(&point.parameters);
    let time_s = point.event_times_s[collision.event];
    let arrive = |body: usize, arc: usize| {
        let flight = (&point.arcs[arc], epochs_s[arc]);
        Arrival::new(&problem.bodies[body], &gravity, flight, time_s)
    };
    let first = &collision.sides[0];
    let before = [
        Some(arrive(first.body, first.before)),
        collision.sides.get(1).map(|s| arrive(s.body, s.before)),
    ];
    let side = |index: usize| {
        before[index].as_ref().map(|arrival| impact::Side {
            body: &problem.bodies[collision.sides[index].body],
            state: &arrival.state,
        })
    };
    let (a, b) = (side(0).expect("a first body"), side(1));
    let law = collision.law(&point.parameters);
    let mut derivative = ImpactDerivative::default();
    let impact = collision
        .meeting
        .derivative(&a, b.as_ref(), &law, &mut derivative);
    let Ok(impact) = impact else {
        block.values.fill(f64::NAN);
        gaps.values.fill(f64::NAN);
        return;
    };
    fill_contacts(&places, &impact, approach_limit_m_s, block);
    let mut rows = Rows {
        problem,
        places,
        block,
        gaps,
    };
    for (body, arrival) in before.iter().enumerate() {
        if let Some(arrival) = arrival {
            rows.add_contacts(&derivative, body, arrival);
        }
    }
    for (body, (side, arrival)) in collision
        .sides
        .iter()
        .zip(before.iter().flatten())
        .enumerate()
    {
        let after = arrive(side.body, side.after);
        let bounced = State {
            velocity_m_s: impact.after[body].velocity_m_s,
            angular_velocity_rad_s: impact.after[body].angular_velocity_rad_s,
            ..arrival.state
        };
        rows.add_continuity(&derivative, body, &before, (&bounced, &after));
    }
    rows.add_parameters(collision, &derivative);
}

fn fill_contacts(places: &Places, impact: &Impact, approach_limit_m_s: f64, block: &mut Block) {
    for contact in 0..places.approaches {
        if contact < places.contacts {
            block.values[contact] = impact.gaps_m[contact] / unit::POSITION_M;
        }
        let row = places.contacts + contact;
        block.values[row] = impact.speeds_m_s[contact] / unit::VELOCITY_M_S;
        block.bounds[row] = (f64::NEG_INFINITY, approach_limit_m_s / unit::VELOCITY_M_S);
    }
}

/// The two blocks of a collision on their way.
struct Rows<'a> {
    problem: &'a Problem,
    places: Places,
    block: &'a mut Block,
    gaps: &'a mut Block,
}

impl Rows<'_> {
    /// Derivatives of gaps and approach speeds by a body's arrival.
    fn add_contacts(&mut self, derivative: &ImpactDerivative, body: usize, arrival: &Arrival) {
        for contact in 0..self.places.approaches {
            if contact < self.places.contacts {
                let by_state = derivative.gap[contact][body] / unit::POSITION_M;
                self.add_contact(contact, body, &by_state, arrival);
            }
            let by_state = derivative.speed[contact][body] / unit::VELOCITY_M_S;
            self.add_contact(self.places.contacts + contact, body, &by_state, arrival);
        }
    }

    fn add_contact(
        &mut self,
        row: usize,
        body: usize,
        by_arrival: &RowSVector<f64, STATE>,
        arrival: &Arrival,
    ) {
        let (by_state, by_time, by_gravity) = arrival.chain(by_arrival);
        let time = self.places.time_column;
        self.block.add((row, Places::before(body)), &by_state);
        self.block.add((row, time), &by_time);
        add_gravity(self.problem, self.block, (row, time + 1), &by_gravity);
    }

    /// What the state of a body after differs from the impact's, and its derivatives.
    fn add_continuity(
        &mut self,
        derivative: &ImpactDerivative,
        body: usize,
        before: &[Option<Arrival>; 2],
        (bounced, after): (&State, &Arrival),
    ) {
        let gap = after.state.minus(bounced);
        let units = SVector::from(STATE_UNITS);
        self.set_values(body, &gap.component_div(&units));
        let logarithm: Vector3<f64> = gap.fixed_rows::<3>(part::ORIENTATION).into();
        let by_turn = so3::right_jacobian_inverse(&logarithm);
        for (other, arrival) in before.iter().enumerate() {
            let Some(arrival) = arrival else { continue };
            let mut by_arrival = SMatrix::<f64, STATE, STATE>::zeros();
            if other == body {
                by_arrival
                    .fixed_view_mut::<3, 3>(0, part::POSITION)
                    .fill_diagonal(-1.0);
                by_arrival
                    .fixed_view_mut::<3, 3>(part::ORIENTATION, part::ORIENTATION)
                    .copy_from(&-by_turn.transpose());
            }
            by_arrival
                .fixed_rows_mut::<HALF>(HALF)
                .copy_from(&-derivative.after[body][other]);
            self.add_state(body, Places::before(other), &by_arrival, arrival);
        }
        let mut by_after = SMatrix::<f64, STATE, STATE>::identity();
        by_after
            .fixed_view_mut::<3, 3>(part::ORIENTATION, part::ORIENTATION)
            .copy_from(&by_turn);
        self.add_state(body, Places::after(body), &by_after, after);
    }

    fn set_values(&mut self, body: usize, values: &SVector<f64, STATE>) {
        let at = self.places.of_body(body);
        let closed = self.places.rows_per_body;
        for row in 0..closed {
            self.block.values[at + row] = values[row];
        }
        for row in closed..STATE {
            self.gaps.values[body * HALF + row - closed] = values[row];
        }
    }

    fn add_state(
        &mut self,
        body: usize,
        column: usize,
        by_arrival: &SMatrix<f64, STATE, STATE>,
        arrival: &Arrival,
    ) {
        let mut scaled = *by_arrival;
        for row in 0..STATE {
            scaled.row_mut(row).scale_mut(1.0 / STATE_UNITS[row]);
        }
        let (by_state, by_time, by_gravity) = arrival.chain(&scaled);
        let time = self.places.time_column;
        self.add(body, column, &by_state);
        self.add(body, time, &by_time);
        let free = (0..3).filter(|axis| self.problem.gravity_parameters[*axis].is_some());
        for (index, axis) in free.enumerate() {
            let by_axis = by_gravity.fixed_columns::<1>(axis).into_owned();
            self.add(body, time + 1 + index, &by_axis);
        }
    }

    /// Adds derivatives of a body's rows to the block or blocks they are in.
    fn add<const C: usize>(&mut self, body: usize, column: usize, by: &SMatrix<f64, STATE, C>) {
        let at = (self.places.of_body(body), column);
        if self.places.rows_per_body == STATE {
            self.block.add(at, by);
        } else {
            self.block.add(at, &by.fixed_rows::<HALF>(0).into_owned());
            let velocities = by.fixed_rows::<HALF>(HALF).into_owned();
            self.gaps.add((body * HALF, column), &velocities);
        }
    }

    /// Derivatives by restitution, friction and tilts.
    fn add_parameters(&mut self, collision: &Collision, derivative: &ImpactDerivative) {
        let mut column = self.places.time_column + 1 + self.problem.gravity_count();
        if collision.restitution_parameter.is_some() {
            self.add_parameter(column, &derivative.after_by_restitution);
            column += 1;
        }
        if collision.friction_parameter.is_some() {
            self.add_parameter(column, &derivative.after_by_friction);
            column += 1;
        }
        for (tangent, _) in &collision.tilts {
            let by_tilt = [0, 1]
                .map(|body: usize| derivative.after_by_tilt[body].column(*tangent).into_owned());
            self.add_parameter(column, &by_tilt);
            column += 1;
        }
    }

    fn add_parameter(&mut self, column: usize, after: &[SVector<f64, HALF>; 2]) {
        for body in 0..self.places.bodies {
            let mut rows = SVector::<f64, STATE>::zeros();
            for row in 0..HALF {
                rows[HALF + row] = -after[body][row] / STATE_UNITS[HALF + row];
            }
            self.add(body, column, &rows);
        }
    }
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
