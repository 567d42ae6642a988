//! Balance of energy and momentum over flights and impacts.
//!
//! Over a flight, energy with the potential of gravity and of a constant force, less the work of
//! drag; momentum less the impulse of all of these and of lift, which does no work; and angular momentum `R I ω` are constant. Over
//! an impact the states before and after it and the contact points are checked for the following:
//!
//! - two bodies together keep their momentum; without friction, a body keeps the part of its
//!   momentum perpendicular to the contacts' normals;
//! - a held body is not deflected, and its momentum is not looked at: the hand has as much as it
//!   takes. What the hand does is the impulses on the other body times the speeds of the held one's
//!   points of contact, and is no loss or gain of the impact;
//! - each body keeps its angular momentum about a single point of contact, whatever the impulse
//!   there; with several contacts, it keeps the part about the first that the impulses along the
//!   others' normals cannot change;
//! - the energy loss follows restitution. With the contacts' relative speeds `u` along the normals
//!   and Delassus' operator `W` (speeds per impulses) of all bodies it is `½ (1 − e²) uᵀ W⁻¹ u`;
//!   friction at one contact takes between zero and `½ (vᵀ W⁻¹ v − u²/(nᵀ W n))` more, the whole
//!   energy of sliding there, and the less the more of it springs back; that of a flat landing all of what impulses along the normals leave. Of a
//!   bumper, with `e > 1`, the least loss is a gain, and a greater one is none of the law.

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

use super::law::CheckedLaw;
use super::meeting::World;
use super::moving::MovingLink;
use crate::math::so3;
use crate::motion::{Balance, LinkIndex, StuckPair};
use crate::physics::Support;
use crate::physics::contact::Frame;
use crate::physics::flow::Fall;
use crate::physics::{Body, State};

/// Sine of an angle below which directions are parallel.
const PARALLEL: f64 = 1e-9;

pub(super) fn balance(world: &World) -> Balance {
    let mut balance = Balance::default();
    for link in world.links.iter().filter(|link| link.held.is_none()) {
        for arc in link.arcs.iter().filter(|arc| link.grip(arc).is_none()) {
            let ends = [arc.start_s, arc.end_s].map(|time_s| link.state(arc, time_s));
            let duration_s = arc.end_s - arc.start_s;
            flight(world, link, &ends, duration_s, arc.support, &mut balance);
        }
    }
    for event in &world.estimate.events {
        let Some(mut law) = CheckedLaw::new(world.scene, world.estimate, event.event) else {
            continue;
        };
        let side = |link: LinkIndex| {
            let link = &world.links[link];
            let sides = [
                (link.ending_at(event.time_s)?, event.time_s),
                (link.starting_at(event.left_s())?, event.left_s()),
            ];
            Some(BeforeAfter {
                body: &link.of_scene.body,
                is_held: link.held.is_some(),
                states: sides.map(|(arc, time_s)| link.state(arc, time_s)),
            })
        };
        let links = [law.link].into_iter().chain(law.other);
        let mut sides: Option<Vec<BeforeAfter>> = links.clone().map(side).collect();
        // Of a contact that lasts, the impact whose impulse acted meanwhile.
        for (link, side) in links.zip(sides.iter_mut().flatten()) {
            if let Some(pressed) = world.scene.pressed(world.estimate, event, link) {
                let [touching, left] = &side.states;
                side.states[1] = pressed.after(touching, left).in_pose_of(touching);
                if link == law.link {
                    law.press(Some(&pressed));
                }
            }
        }
        if let Some(impact) = sides.and_then(|sides| EstimatedImpact::new(&law, sides)) {
            impact.check(&law, &mut balance);
        }
    }
    for (pair, states) in stuck(world) {
        let bodies = pair.links.map(|link| &world.links[link].of_scene.body);
        StickingImpact { bodies, states }.check(&mut balance);
    }
    balance
}

/// Two bodies that become one, with their states just before and just after.
struct StickingImpact<'a> {
    bodies: [&'a Body; 2],
    states: [[State; 2]; 2],
}

impl StickingImpact<'_> {
    /// Together they keep their momenta, and lose energy.
    fn check(&self, balance: &mut Balance) {
        let [before, after] = self.states.map(|of| PairTotals::of(self.bodies, &of));
        let size: f64 = (0..2)
            .map(|side| self.bodies[side].mass_kg() * self.states[0][side].velocity_m_s.norm())
            .sum();
        let change = after.momentum - before.momentum;
        balance.impact_momentum = balance.impact_momentum.max(relative(change.norm(), size));
        let change = after.angular_momentum - before.angular_momentum;
        let turned = relative(change.norm(), before.angular_size);
        balance.impact_angular_momentum = balance.impact_angular_momentum.max(turned);
        let gained_j = (after.energy_j - before.energy_j).max(0.0);
        let gained = relative(gained_j, before.energy_j);
        balance.impact_energy = balance.impact_energy.max(gained);
    }
}

/// What two bodies have together: momentum, angular momentum about the centre of both, and energy.
struct PairTotals {
    momentum: Vector3<f64>,
    angular_momentum: Vector3<f64>,
    /// Sum of the sizes of its parts.
    angular_size: f64,
    energy_j: f64,
}

impl PairTotals {
    fn of(bodies: [&Body; 2], states: &[State; 2]) -> Self {
        let mass_kg = bodies[0].mass_kg() + bodies[1].mass_kg();
        let weighed = bodies.iter().zip(states);
        let centre_m = weighed
            .clone()
            .map(|(body, of)| of.position_m * (body.mass_kg() / mass_kg))
            .sum::<Vector3<f64>>();
        let mut all = Self {
            momentum: Vector3::zeros(),
            angular_momentum: Vector3::zeros(),
            angular_size: 0.0,
            energy_j: 0.0,
        };
        for (body, state) in weighed {
            let momentum = state.velocity_m_s * body.mass_kg();
            let (spin, orbit) = (
                spin_of(body, state),
                (state.position_m - centre_m).cross(&momentum),
            );
            all.momentum += momentum;
            all.angular_momentum += spin + orbit;
            all.angular_size += spin.norm() + orbit.norm();
            all.energy_j += kinetic_j(body, state);
        }
        all
    }
}

/// Bodies that stick together in a motion, with their states just before that and just after.
fn stuck<'a>(world: &'a World) -> impl Iterator<Item = (StuckPair, [[State; 2]; 2])> + 'a {
    world.scene.stuck_pairs().filter_map(|pair| {
        let mut events = world.estimate.events.iter();
        let time_s = events.find(|of| of.event == pair.event)?.time_s;
        let state = |link: LinkIndex, is_after: bool| {
            let link = &world.links[link];
            let arc = match is_after {
                true => link.starting_at(time_s)?,
                false => link.ending_at(time_s)?,
            };
            Some(link.state(arc, time_s))
        };
        let both = |is_after: bool| {
            let [one, other] = pair.links.map(|link| state(link, is_after));
            Some([one?, other?])
        };
        Some((pair, [both(false)?, both(true)?]))
    })
}

fn flight(
    world: &World,
    link: &MovingLink,
    [start, end]: &[State; 2],
    duration_s: f64,
    support: Option<Support>,
    balance: &mut Balance,
) {
    // What is stuck to another body gives to that and takes from it: both together keep what a flight keeps.
    if let Some(part) = support.and_then(|support| support.stuck()) {
        let ends = [part.of_whole(start), part.of_whole(end)];
        return flown(world, &part.whole(), &ends, duration_s, balance);
    }
    let body = &link.of_scene.body.with_support(support);
    let gravity = world.estimate.gravity_m_s2;
    let pull = body.pull_m_s2(&gravity);
    if support.is_some() {
        // Friction takes energy and momentum, and gives none; what a pivot bears does no work.
        let potential = -body.mass_kg() * pull.dot(&(end.position_m - start.position_m));
        let (before, after) = (kinetic_j(body, start), kinetic_j(body, end));
        let gained = (after + potential - before).max(0.0);
        let gained = relative(gained, before.max(after).max(potential.abs()));
        balance.flight_energy = balance.flight_energy.max(gained);
        return;
    }
    flown(world, body, &[*start, *end], duration_s, balance);
}

/// What a free flight keeps.
fn flown(
    world: &World,
    body: &Body,
    [start, end]: &[State; 2],
    duration_s: f64,
    balance: &mut Balance,
) {
    let gravity = world.estimate.gravity_m_s2;
    let pull = body.pull_m_s2(&gravity);
    let drag = DragSum::over(body, &gravity, start, duration_s);
    let potential = -body.mass_kg() * pull.dot(&(end.position_m - start.position_m));
    let (before, after) = (kinetic_j(body, start), kinetic_j(body, end));
    let of_energy = relative(
        (after + potential - before - body.mass_kg() * drag.work_m2_s2).abs(),
        before.max(after).max(potential.abs()),
    );
    let speed = start.velocity_m_s.norm().max(end.velocity_m_s.norm());
    let change = end.velocity_m_s - start.velocity_m_s - pull * duration_s - drag.impulse_m_s;
    let (spin, spin_after) = (spin_of(body, start), spin_of(body, end));
    balance.flight_energy = balance.flight_energy.max(of_energy);
    balance.flight_momentum = balance.flight_momentum.max(relative(change.norm(), speed));
    balance.flight_angular_momentum = balance
        .flight_angular_momentum
        .max(relative((spin_after - spin).norm(), spin.norm()));
}

/// What drag and lift do over a flight, per mass.
#[derive(Default)]
struct DragSum {
    work_m2_s2: f64,
    impulse_m_s: Vector3<f64>,
}

/// Length of an interval of the sum over a flight \[s\].
const DRAG_INTERVAL_S: f64 = 1.0 / 128.0;
/// Greatest number of such intervals.
const DRAG_INTERVALS: f64 = 1e5;

impl DragSum {
    /// Sums by Gauss and Legendre's rule of three points.
    fn over(body: &Body, gravity_m_s2: &Vector3<f64>, start: &State, duration_s: f64) -> Self {
        let mut sum = Self::default();
        if body.is_ballistic() {
            return sum;
        }
        let mut fall = Fall::new(body, gravity_m_s2, start);
        // Only a ball is lifted, whose spin stays as it is.
        let spin = start.orientation * start.angular_velocity_rad_s;
        let intervals = (duration_s / DRAG_INTERVAL_S).ceil().min(DRAG_INTERVALS);
        let interval_s = duration_s / intervals.max(1.0);
        let off = 0.6_f64.sqrt();
        for interval in 0..intervals as usize {
            for (place, weight) in [(-off, 5.0), (0.0, 8.0), (off, 5.0)] {
                let since_s = (interval as f64 + 0.5 + 0.5 * place) * interval_s;
                let velocity = fall.position_and_velocity(since_s).1;
                let acceleration = body.air_m_s2(&velocity, &spin);
                let weight_s = interval_s * weight / 18.0;
                sum.work_m2_s2 += acceleration.dot(&velocity) * weight_s;
                sum.impulse_m_s += acceleration * weight_s;
            }
        }
        sum
    }
}

/// A body just before an impact and just after.
struct BeforeAfter<'a> {
    body: &'a Body,
    is_held: bool,
    states: [State; 2],
}

/// An impact with its states and contact geometry.
struct EstimatedImpact<'a> {
    sides: Vec<BeforeAfter<'a>>,
    /// Unit, tilted, towards the first side \[world\]; contact by contact.
    normals: Vec<Vector3<f64>>,
    /// From the sides' centres to the points of contact [m, world].
    arms_m: Vec<Vec<Vector3<f64>>>,
}

impl<'a> EstimatedImpact<'a> {
    /// `None` where a contact is degenerate.
    fn new(law: &CheckedLaw, sides: Vec<BeforeAfter<'a>>) -> Option<Self> {
        let frame =
            |side: Option<&BeforeAfter>| side.map_or(Frame::world(), |s| Frame::of(&s.states[0]));
        let frames = [frame(sides.first()), frame(sides.get(1))];
        let (mut normals, mut arms_m) = (Vec::new(), vec![Vec::new(); sides.len()]);
        for contact in law.contacts.as_slice() {
            let touch = contact.touch(&frames[0], &frames[1]).ok()?;
            let tilt: Vector3<f64> = contact
                .tilt_axes()
                .into_iter()
                .flatten()
                .zip(law.law.tilt_rad)
                .map(|(axis, angle_rad)| frames[1].orientation * axis * angle_rad)
                .sum();
            normals.push(so3::exp(&tilt) * touch.normal);
            for (side, on_side_m) in [touch.on_a_m, touch.on_b_m].iter().enumerate() {
                if let Some(arms_m) = arms_m.get_mut(side) {
                    arms_m.push(frames[side].orientation * on_side_m);
                }
            }
        }
        Some(Self {
            sides,
            normals,
            arms_m,
        })
    }

    fn check(&self, law: &CheckedLaw, balance: &mut Balance) {
        let is_smooth = !law.contacts.has_friction();
        let momentum =
            |side: &BeforeAfter, at: usize| side.states[at].velocity_m_s * side.body.mass_kg();
        let (mut sum, mut size) = (Vector3::zeros(), 0.0);
        for (index, side) in self.deflected() {
            let change = momentum(side, 1) - momentum(side, 0);
            let own = momentum(side, 0).norm().max(momentum(side, 1).norm());
            if is_smooth {
                let across = relative(across(&self.normals, change).norm(), own);
                balance.impact_momentum = balance.impact_momentum.max(across);
            }
            sum += change;
            size += own;
            // Friction of a face turns about every point of it.
            if !law.contacts.is_landing() {
                let turned = self.turned(index);
                balance.impact_angular_momentum = balance.impact_angular_momentum.max(turned);
            }
        }
        if self.deflected().count() > 1 {
            balance.impact_momentum = balance.impact_momentum.max(relative(sum.norm(), size));
        }
        let energy_j = |at: usize| -> f64 {
            let sides = self.deflected();
            sides
                .map(|(_, side)| kinetic_j(side.body, &side.states[at]))
                .sum()
        };
        let done_j = self.done_j();
        let lost_j = energy_j(0) + done_j - energy_j(1);
        let off_j = self.taken_j(law).map_or(0.0, |[least_j, most_j]| {
            (least_j - lost_j).max(lost_j - most_j).max(0.0)
        });
        balance.impact_energy = balance
            .impact_energy
            .max(relative(off_j, energy_j(0).max(done_j.abs())));
    }

    /// The sides that an impact deflects, with their places.
    fn deflected(&self) -> impl Iterator<Item = (usize, &BeforeAfter<'a>)> {
        let sides = self.sides.iter().enumerate();
        sides.filter(|(_, side)| !side.is_held)
    }

    /// Work of the hand that holds the second side \[J\]; zero where none does.
    fn done_j(&self) -> f64 {
        let [hit, held] = self.sides.as_slice() else {
            return 0.0;
        };
        if !held.is_held {
            return 0.0;
        }
        let [before, after] = &hit.states;
        let pushed = (after.velocity_m_s - before.velocity_m_s) * hit.body.mass_kg();
        let holds = &held.states[0];
        let spin = holds.orientation * holds.angular_velocity_rad_s;
        let speed = |at: usize| holds.velocity_m_s + spin.cross(&self.arms_m[1][at]);
        if self.normals.len() == 1 {
            return pushed.dot(&speed(0));
        }
        // Impulses along the normals, from the changes of momentum and of angular momentum.
        let turned = spin_of(hit.body, after) - spin_of(hit.body, before);
        let mut by = DMatrix::zeros(6, self.normals.len());
        for (at, normal) in self.normals.iter().enumerate() {
            by.fixed_view_mut::<3, 1>(0, at).copy_from(normal);
            let moment = self.arms_m[0][at].cross(normal);
            by.fixed_view_mut::<3, 1>(3, at).copy_from(&moment);
        }
        let change = pushed.iter().chain(&turned).copied();
        let change = DVector::from_iterator(6, change);
        let impulses = by.svd(true, true).solve(&change, PARALLEL);
        let impulses = impulses.expect("both factors were computed");
        let each = self.normals.iter().enumerate();
        each.map(|(at, normal)| impulses[at] * normal.dot(&speed(at)))
            .sum()
    }

    /// Relative change of a side's angular momentum about its first contact, without the directions
    /// that the other contacts can change.
    fn turned(&self, index: usize) -> f64 {
        let (side, arms_m) = (&self.sides[index], &self.arms_m[index]);
        let about = |state: &State| {
            let momentum = state.velocity_m_s * side.body.mass_kg();
            spin_of(side.body, state) - arms_m[0].cross(&momentum)
        };
        let [before, after] = [0, 1].map(|at| about(&side.states[at]));
        let others: Vec<_> = (1..arms_m.len())
            .map(|other| (arms_m[other] - arms_m[0]).cross(&self.normals[other]))
            .collect();
        relative(across(&others, after - before).norm(), before.norm())
    }

    /// The least and the greatest energy loss of the impact by the law \[J\]; `None` where the
    /// contacts depend on each other.
    fn taken_j(&self, law: &CheckedLaw) -> Option<[f64; 2]> {
        let (count, elastic) = (self.normals.len(), law.law.restitution.powi(2));
        // Rows: a speed along a normal; with friction, along the world's axes at the one contact.
        let is_landing = law.contacts.is_landing();
        let has_friction = law.contacts.has_friction() && !is_landing;
        let directions: Vec<(usize, Vector3<f64>)> = match has_friction {
            true => (0..3).map(|axis| (0, Vector3::ith(axis, 1.0))).collect(),
            false => (0..count).map(|at| (at, self.normals[at])).collect(),
        };
        let mut speeds = DVector::zeros(directions.len());
        let mut delassus = DMatrix::zeros(directions.len(), directions.len());
        for (index, (side, sign)) in self.sides.iter().zip([1.0, -1.0]).enumerate() {
            let state = &side.states[0];
            let spin = state.orientation * state.angular_velocity_rad_s;
            let turn = so3::matrix(&state.orientation);
            let inverse = side.body.moments_kg_m2().map(|moment| 1.0 / moment);
            let inverse = turn * Matrix3::from_diagonal(&inverse) * turn.transpose();
            for (row, (at, direction)) in directions.iter().enumerate() {
                let arm_m = &self.arms_m[index][*at];
                speeds[row] += sign * direction.dot(&(state.velocity_m_s + spin.cross(arm_m)));
                let turned = inverse * arm_m.cross(direction);
                for (column, (other, along)) in directions.iter().enumerate() {
                    delassus[(row, column)] += direction.dot(along) / side.body.mass_kg()
                        + self.arms_m[index][*other].cross(along).dot(&turned);
                }
            }
        }
        let whole_j = 0.5 * speeds.dot(&delassus.clone().cholesky()?.solve(&speeds));
        if !has_friction {
            let lost_j = (1.0 - elastic) * whole_j;
            let left_j = match is_landing {
                true => kinetic_j(self.sides[0].body, &self.sides[0].states[0]) - whole_j,
                false => 0.0,
            };
            return Some([lost_j, lost_j + left_j]);
        }
        let normal = DVector::from_column_slice(self.normals[0].as_slice());
        let along = normal.dot(&speeds);
        let pushed_j = 0.5 * along * along / normal.dot(&(delassus * &normal));
        let least_j = (1.0 - elastic) * pushed_j;
        Some([least_j, least_j + whole_j - pushed_j])
    }
}

/// The part of a vector perpendicular to all directions.
fn across(directions: &[Vector3<f64>], vector: Vector3<f64>) -> Vector3<f64> {
    let mut base: Vec<Vector3<f64>> = Vec::new();
    let reduced = |base: &[Vector3<f64>], vector: Vector3<f64>| {
        base.iter()
            .fold(vector, |left, axis| left - axis * axis.dot(&left))
    };
    for direction in directions {
        let left = reduced(&base, *direction);
        base.extend(left.try_normalize(PARALLEL * direction.norm()));
    }
    reduced(&base, vector)
}

/// Kinetic energy \[J\].
pub(super) fn kinetic_j(body: &Body, state: &State) -> f64 {
    let omega = state.angular_velocity_rad_s;
    0.5 * body.mass_kg() * state.velocity_m_s.norm_squared()
        + 0.5 * body.moments_kg_m2().dot(&omega.component_mul(&omega))
}

/// Angular momentum about the centre of mass [kg m²/s, world].
fn spin_of(body: &Body, state: &State) -> Vector3<f64> {
    let moments = body.moments_kg_m2();
    state.orientation * moments.component_mul(&state.angular_velocity_rad_s)
}

/// Ratio of a difference to a whole; zero where the whole is zero.
fn relative(difference: f64, whole: f64) -> f64 {
    if whole > 0.0 { difference / whole } else { 0.0 }
}
