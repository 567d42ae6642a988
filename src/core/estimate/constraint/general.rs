//! The rows of a collision in general: with drag, or with parameters that act on flights, bodies or
//! the surface. The rows are those of `collision`, which is the short form.
//!
//! With the states `q⁻`, `q⁺` of the arcs at the event and a parameter `u`,
//!
//! ```text
//! δφ = φ_q δq⁻ + φ_u δu,   δq = Φ_q δq(epoch) + q̇ δτ + Φ_u δu
//! ```
//!
//! and likewise for approach speeds and for what the impact leaves.

use nalgebra::{RowSVector, SMatrix, SVector, Vector3};

use super::kind::{At, Filled};
use super::rows::{HALF, Places, STATE};
use crate::estimate::problem::influence::{Acting, Influence};
use crate::estimate::problem::{ArcCollision, Problem, unit};
use crate::estimate::reach::arrival::{ByStates, GeneralArrival};
use crate::estimate::terms::modelled::TouchedPair;
use crate::estimate::unknowns::layout::Layout;
use crate::math::so3;
use crate::optimise::block::BlockPattern;
use crate::physics::Body;
use crate::physics::impact::{self, ImpactByModel, Pressed};
use crate::physics::state::{StateTangent, part};

/// The unknowns of all rows: states before, the event's time; for those of a side also the state
/// after and the law's parameters; acting parameters last.
pub(super) fn patterns(
    collision: &ArcCollision,
    problem: &Problem,
    layout: &Layout,
) -> [BlockPattern; 2] {
    let places = Places::new(problem, collision);
    let (mut block, mut gaps) = (BlockPattern::default(), BlockPattern::default());
    let before = collision.sides.iter().map(|side| side.before);
    let before = before.flat_map(|arc| layout.state(arc));
    let held = collision.held.map(|held| layout.held[held]);
    let held = held.into_iter().flat_map(|at| at..at + STATE);
    let arriving: Vec<usize> = before
        .chain(held)
        .chain(layout.events[collision.event])
        .collect();
    let acting = collision.acting.iter();
    let acting: Vec<usize> = acting.map(|a| layout.parameters[a.parameter]).collect();
    let touching = [arriving.clone(), acting.clone()].concat();
    block.push(places.contacts, touching.clone());
    block.push(places.approaches, touching);
    let law: Vec<usize> = law(collision).map(|p| layout.parameters[p]).collect();
    for side in &collision.sides {
        let after: Vec<usize> = layout.state(side.after).collect();
        let all = [arriving.clone(), after, law.clone(), acting.clone()].concat();
        if places.rows_per_side == STATE {
            block.push(STATE, all);
        } else {
            block.push(HALF, all.clone());
            gaps.push(HALF, all);
        }
    }
    [block, gaps]
}

/// Parameters of the law that are free, without one that acts on a support too.
fn law(collision: &ArcCollision) -> impl Iterator<Item = usize> + '_ {
    let law = [
        collision.restitution_parameter,
        collision
            .friction_parameter
            .filter(|of| !acts_too(collision, *of)),
        collision.tangential_parameter,
    ];
    let tilts = collision.tilts.iter().map(|(_, parameter)| *parameter);
    law.into_iter().flatten().chain(tilts)
}

/// Whether a parameter of the law acts on a support beside the impact too: it has one column.
fn acts_too(collision: &ArcCollision, parameter: usize) -> bool {
    let mut acting = collision.acting.iter();
    acting.any(|acting| acting.parameter == parameter)
}

/// Sets all values, bounds and derivatives; `None`, and nothing set, where the impact is
/// undetermined.
pub(super) fn fill(
    collision: &ArcCollision,
    at: &mut At,
    [(pattern, block), (gap_pattern, gaps)]: [Filled; 2],
) -> Option<()> {
    let (problem, parameters) = (at.problem, &at.point.parameters);
    let places = Places::new(problem, collision);
    let time_s = at.point.event_times_s[collision.event];
    let arrive = |arc: usize, time_s: f64| {
        GeneralArrival::new(problem, at.point, arc, at.epochs_s[arc], time_s)
    };
    let held = collision
        .held
        .map(|held| GeneralArrival::given(&at.point.held[held]));
    let before: Vec<GeneralArrival> = collision
        .sides
        .iter()
        .map(|side| arrive(side.before, time_s))
        .chain(held.map(Some))
        .collect::<Option<_>>()?;
    let by_state: Vec<ByStates> = before.iter().map(GeneralArrival::by_state).collect();
    let bodies: Vec<Body> = collision
        .sides
        .iter()
        .map(|side| problem.body_at(side.before, parameters))
        .collect::<Option<_>>()?;
    let side = |index: usize| {
        Some(impact::Side {
            body: bodies.get(index).unwrap_or(&Body::IMMOVABLE),
            state: &before.get(index)?.end.state,
        })
    };
    let (a, b) = (side(0)?, side(1));
    let touching = problem.touching_at(collision, parameters)?;
    let contacts = &touching.contacts;
    let law = collision.law(parameters);
    let gravity_m_s2 = problem.gravity(parameters);
    let pressed: Vec<Pressed> = match collision.contact_s(parameters) {
        None => Vec::new(),
        Some(_) => {
            let at_once = contacts.impact(&a, b.as_ref(), &law).ok()?;
            let speed_m_s = at_once.speeds_m_s[0];
            let each = bodies.iter();
            each.filter_map(|body| collision.pressed(body, &gravity_m_s2, parameters, speed_m_s))
                .collect()
        }
    };
    let law = pressed.first().map_or(law, |pressed| pressed.law(&law));
    let derivative = &mut at.impact;
    let impact = contacts.derivative(&a, b.as_ref(), &law, derivative).ok()?;
    let is_of_model = |acting: &Acting| {
        !matches!(
            acting.influence,
            Influence::Pull(_) | Influence::SupportFriction | Influence::ContactDuration
        )
    };
    let own: Vec<OfModel> = if collision.acting.iter().any(is_of_model) {
        let by = contacts.by_model(&a, b.as_ref(), &law).ok()?;
        let acting = collision.acting.iter();
        acting
            .map(|acting| OfModel::new(&by, &touching, acting, parameters[acting.parameter]))
            .collect()
    } else {
        let acting = collision.acting.iter();
        acting.map(|_| OfModel::default()).collect()
    };
    let acts = |acting: &Acting, side: usize| acting.side.is_none_or(|own| own == side);

    // Contacts and approach speeds.
    let limits_m_s = at.approach_limits_m_s.get(collision.event).copied();
    for contact in 0..places.approaches {
        let gap = (contact < places.contacts).then_some((
            contact,
            impact.gaps_m[contact],
            &derivative.gap[contact],
            unit::POSITION_M,
        ));
        let speed = (
            places.contacts + contact,
            impact.speeds_m_s[contact],
            &derivative.speed[contact],
            unit::VELOCITY_M_S,
        );
        for (row, value, by, unit) in gap.into_iter().chain([speed]) {
            block.values[row] = value / unit;
            let to = block.derivatives_mut(pattern, row);
            let mut by_time = 0.0;
            for (index, arrival) in before.iter().enumerate() {
                let chained: RowSVector<f64, 12> = by[index] * by_state[index];
                to[STATE * index..][..STATE].copy_from_slice((chained / unit).as_slice());
                by_time += (by[index] * arrival.end.rate)[0];
            }
            let rest = &mut to[STATE * before.len()..];
            let is_gap = row < places.contacts;
            let by_acting = collision.acting.iter().zip(&own).map(|(acting, own)| {
                let of_model = if is_gap { own.gap } else { own.speed };
                let value = parameters[acting.parameter];
                let flown: f64 = before
                    .iter()
                    .enumerate()
                    .filter(|(index, _)| acts(acting, *index))
                    .map(|(index, arrival)| (by[index] * arrival.by_acting(acting, value))[0])
                    .sum();
                flown + of_model[contact]
            });
            let all = std::iter::once(by_time).chain(by_acting);
            for (entry, by) in rest.iter_mut().zip(all) {
                *entry = by / unit;
            }
        }
        let row = places.contacts + contact;
        block.bounds[row] = (
            f64::NEG_INFINITY,
            limits_m_s.unwrap_or(0.0) / unit::VELOCITY_M_S,
        );
    }

    // Continuity.
    let left_s = time_s + collision.contact_s(parameters).unwrap_or(0.0);
    for (index, side) in collision.sides.iter().enumerate() {
        let after = arrive(side.after, left_s)?;
        let touching = &before[index].end.state;
        let pressed = pressed.get(index);
        let left = pressed.map(|pressed| {
            let left = pressed.left(touching, &impact.after[index]);
            left.with_law(pressed, &derivative.after_by_restitution[index])
        });
        let bounced = match &left {
            Some(left) => left.state,
            None => impact.after[index].in_pose_of(touching),
        };
        let gap = after.end.state.minus(&bounced);
        let turn: Vector3<f64> = gap.fixed_rows::<3>(part::ORIENTATION).into();
        let right = so3::right_jacobian_inverse(&turn);
        let mut by_after = ByStates::identity();
        by_after
            .fixed_view_mut::<3, 3>(part::ORIENTATION, part::ORIENTATION)
            .copy_from(&right);
        let by_bounced = {
            let mut by = ByStates::identity();
            by.fixed_view_mut::<3, 3>(part::ORIENTATION, part::ORIENTATION)
                .copy_from(&right.transpose());
            by
        };
        let by_before: Vec<ByStates> = (0..before.len())
            .map(|other| {
                if let Some((left, pressed)) = left.as_ref().zip(pressed) {
                    let weight_by = derivative.speed[0][other] * pressed.weight_by_speed;
                    let mut by = left.by_after * derivative.after[index][other];
                    by += left.by_weight * weight_by;
                    if other == index {
                        by += left.by_touching;
                    }
                    return -(by_bounced * by);
                }
                let mut by = ByStates::zeros();
                if other == index {
                    by.fixed_view_mut::<3, 3>(0, 0).fill_with_identity();
                    by.fixed_view_mut::<3, 3>(part::ORIENTATION, part::ORIENTATION)
                        .copy_from(&right.transpose());
                }
                by.fixed_view_mut::<6, 12>(part::VELOCITY, 0)
                    .copy_from(&derivative.after[index][other]);
                -by
            })
            .collect();
        let mut columns: Vec<StateTangent> = Vec::new();
        for (by, state) in by_before.iter().zip(&by_state) {
            let chained: ByStates = by * state;
            columns.extend(chained.column_iter().map(|column| column.into_owned()));
        }
        if problem.event_is_free[collision.event] {
            let mut by_time = by_after * after.end.rate;
            for (by, arrival) in by_before.iter().zip(&before) {
                by_time += by * arrival.end.rate;
            }
            columns.push(by_time);
        }
        let chained: ByStates = by_after * after.by_state();
        columns.extend(chained.column_iter().map(|column| column.into_owned()));
        // What changes the velocities after the impact.
        let velocities = |by: SMatrix<f64, 6, 1>| match &left {
            Some(left) => -(by_bounced * (left.by_after * by)),
            None => {
                let mut column = StateTangent::zeros();
                column.fixed_rows_mut::<6>(part::VELOCITY).copy_from(&-by);
                column
            }
        };
        let restitution = collision.restitution_parameter;
        let friction = collision
            .friction_parameter
            .filter(|of| !acts_too(collision, *of));
        columns.extend(restitution.map(|_| match &left {
            Some(left) => -(by_bounced * left.by_restitution),
            None => velocities(derivative.after_by_restitution[index]),
        }));
        columns.extend(friction.map(|_| velocities(derivative.after_by_friction[index])));
        let tangential = collision.tangential_parameter;
        let by_tangential = derivative.after_by_tangential_restitution[index];
        columns.extend(tangential.map(|_| velocities(by_tangential)));
        columns.extend(collision.tilts.iter().map(|(tangent, _)| {
            velocities(derivative.after_by_tilt[index].column(*tangent).into())
        }));
        columns.extend(collision.acting.iter().zip(&own).map(|(acting, own)| {
            let value = parameters[acting.parameter];
            let mut column = StateTangent::zeros();
            if acts(acting, index) {
                column += by_after * after.by_acting(acting, value);
            }
            for (other, (by, arrival)) in by_before.iter().zip(&before).enumerate() {
                if acts(acting, other) {
                    column += by * arrival.by_acting(acting, value);
                }
            }
            column += velocities(own.after[index]);
            if collision.friction_parameter == Some(acting.parameter) {
                column += velocities(derivative.after_by_friction[index]);
            }
            if let Some((left, pressed)) = left.as_ref().zip(pressed) {
                let by_weight = pressed.weight_by_speed * own.speed[0];
                column -= by_bounced * (left.by_weight * by_weight);
                match acting.influence {
                    Influence::ContactDuration => {
                        column += by_after * after.end.rate - by_bounced * left.by_duration;
                    }
                    Influence::Pull(axis) if acts(acting, index) => {
                        column -= by_bounced * left.by_pull(pressed, axis);
                    }
                    Influence::Moment(axes) if acts(acting, index) => {
                        for axis in (0..3).filter(|axis| axes[*axis]) {
                            let after = &impact.after[index];
                            let by = pressed.left_by_log_moment(touching, after, &left.state, axis);
                            column -= by_bounced * by / value;
                        }
                    }
                    _ => {}
                }
            }
            column
        }));
        for row in 0..STATE {
            let unit = [
                unit::POSITION_M,
                unit::ORIENTATION_RAD,
                unit::VELOCITY_M_S,
                unit::ANGULAR_VELOCITY_RAD_S,
            ][row / 3];
            let is_gap = row >= HALF && places.rows_per_side != STATE;
            let (to_pattern, to, at) = if is_gap {
                (gap_pattern, &mut *gaps, index * HALF + row - HALF)
            } else {
                (pattern, &mut *block, places.of_side(index) + row)
            };
            to.values[at] = gap[row] / unit;
            let entries = to.derivatives_mut(to_pattern, at);
            for (entry, column) in entries.iter_mut().zip(&columns) {
                *entry = column[row] / unit;
            }
        }
    }
    Some(())
}

/// Derivatives of an impact by one parameter of the bodies or of the surface.
#[derive(Default)]
struct OfModel {
    gap: [f64; 3],
    speed: [f64; 3],
    after: [SVector<f64, 6>; 2],
}

impl OfModel {
    fn new(by: &ImpactByModel, touching: &TouchedPair, acting: &Acting, value: f64) -> Self {
        let mut own = Self::default();
        let side = acting.side.unwrap_or(0);
        match acting.influence {
            Influence::Mass => {
                for i in 0..2 {
                    let moments = by.after_by_moments[i][side].column_sum();
                    own.after[i] = (by.after_by_mass[i][side] + moments) / value;
                }
            }
            Influence::Moment(axes) => {
                for (i, axis) in (0..2).flat_map(|i| (0..3).map(move |axis| (i, axis))) {
                    if axes[axis] {
                        own.after[i] += by.after_by_moments[i][side].column(axis) / value;
                    }
                }
            }
            Influence::Centre(axis) => {
                own.gap = by.gap_by_shift.map(|by| -by[side][axis]);
                own.speed = by.speed_by_shift.map(|by| -by[side][axis]);
                own.after = [0, 1].map(|i| -by.after_by_shift[i][side].column(axis));
            }
            Influence::SurfaceHeight => own.add_motion(by, touching, 0),
            Influence::SurfaceTilt(tangent) => own.add_motion(by, touching, 1 + tangent),
            _ => {}
        }
        own
    }

    fn add_motion(&mut self, by: &ImpactByModel, touching: &TouchedPair, column: usize) {
        for (contact, motion) in touching.motions.iter().enumerate() {
            let motion = motion.column(column);
            self.gap[contact] = (by.gap_by_place[contact] * motion)[0];
            self.speed[contact] = (by.speed_by_place[contact] * motion)[0];
            self.after[0] += by.after_by_place[contact] * motion;
        }
    }
}
