//! What a surface would have to do to a body on it, and cannot: press beyond its outline, so that it would tip, hold
//! still, or roll, what slips, or drive on what it has stopped.
//!
//! Of forces and moments per mass, with the angular momentum's rate `L̇` about the centre of mass at the height `h`, the
//! surface presses at
//!
//! ```text
//! c = n × (L̇ + h n × (v̇ − p))/(−p·n)        along the plane, from below the centre of mass
//! ```

use nalgebra::Vector3;

use super::law::CheckedLaw;
use super::meeting::{FINITE, World};
use super::moving::MovingLink;
use crate::math::Pose;
use crate::motion::{About, ArcEstimate, Doubt, Place};
use crate::physics::impact::Impact;
use crate::physics::shape::Solid;
use crate::physics::state::{StateTangent, part};
use crate::physics::{OnPlane, State, Support, Sustained, flow};

/// Greatest speed of what rests, and slip of what rolls, that is attributed to gaps of the motion [m/s].
const SLIP_MOST_M_S: f64 = 1e-3;

/// The doubts about all bodies on surfaces.
pub(super) fn doubts(world: &World) -> Vec<Doubt> {
    let links = world.links.iter().filter(|link| link.held.is_none());
    let arcs = links.flat_map(|link| {
        let supported = link.arcs.iter().filter_map(|arc| Some((arc, arc.support?)));
        supported.flat_map(move |(arc, support)| of_arc(world, link, arc, support))
    });
    arcs.collect()
}

fn of_arc(
    world: &World,
    link: &MovingLink,
    arc: &ArcEstimate,
    support: Support,
) -> impl Iterator<Item = Doubt> + use<> {
    let place = Place::Flight {
        mechanism: arc.mechanism,
        start_s: arc.start_s,
    };
    let start = link.state(arc, arc.start_s);
    let slip_m_s = slip_m_s(&support, &start, link.radius_m).max(back_m_s(world, arc));
    let slips = Doubt::beyond(About::Slips, place.clone(), slip_m_s, SLIP_MOST_M_S);
    let off_m = [arc.start_s, arc.end_s].map(|time_s| off_m(world, link, arc, &support, time_s));
    let off_m = off_m[0].max(off_m[1]);
    let tips = Doubt::beyond(About::Tips, place, off_m, world.scene.tolerance_m);
    slips.into_iter().chain(tips)
}

/// How fast what rests moves, what rolls slips, or what is tied moves where it is tied; zero of what slides.
fn slip_m_s(support: &Support, state: &State, reach_m: f64) -> f64 {
    let spin = state.orientation * state.angular_velocity_rad_s;
    let plane = match support {
        Support::Plane(plane) => plane,
        Support::Stuck(_) => return 0.0,
        Support::Pivot(pivot) => {
            let omega = state.angular_velocity_rad_s;
            let borne = omega - pivot.axes.allowed() * omega;
            let moving = state.velocity_m_s + spin.cross(&(state.orientation * pivot.at_m));
            return moving.norm() + borne.norm() * reach_m;
        }
    };
    let n = plane.normal;
    match (plane.sustained, plane.touching.radius_m()) {
        (Sustained::Slide, _) => 0.0,
        (Sustained::Roll, radius_m) => {
            let slip = state.velocity_m_s - spin.cross(&n) * radius_m.unwrap_or(0.0);
            let turned = match plane.touching {
                OnPlane::Side { axis, .. } => {
                    spin - state.orientation * axis * axis.dot(&state.angular_velocity_rad_s)
                }
                _ => Vector3::zeros(),
            };
            (slip - n * n.dot(&slip)).norm() + turned.norm() * reach_m
        }
        (Sustained::Rest, _) => state.velocity_m_s.norm() + spin.norm() * reach_m,
    }
}

/// How fast what slides or rolls goes at the end where friction would have stopped it: from there on it acts against the
/// motion that was.
fn back_m_s(world: &World, arc: &ArcEstimate) -> f64 {
    match arc.support {
        Some(Support::Plane(plane)) if plane.friction > 0.0 => {}
        _ => return 0.0,
    }
    let body = world.scene.body_on(arc);
    let gravity = world.estimate.gravity_m_s2;
    let supported = flow::Supported::new(&body, &gravity, &arc.state);
    let end = supported.map(|mut of| of.carried(arc.end_s - arc.epoch_s).slip_m_s);
    end.map_or(0.0, |slip_m_s| (-slip_m_s).max(0.0))
}

/// How far beyond its outline what lies flat would have to be pressed \[m\]; zero of a ball, and at a pivot.
fn off_m(
    world: &World,
    link: &MovingLink,
    arc: &ArcEstimate,
    support: &Support,
    time_s: f64,
) -> f64 {
    let n = match support {
        Support::Plane(plane) if plane.touching.radius_m().is_none() => plane.normal,
        _ => return 0.0,
    };
    let body = world.scene.body_on(arc);
    let gravity = world.estimate.gravity_m_s2;
    let state = link.state(arc, time_s);
    let rate: StateTangent = flow::rate(&body, &gravity, &state);
    let pull = body.pull_m_s2(&gravity);
    let acceleration: Vector3<f64> = rate.fixed_rows::<3>(part::VELOCITY).into();
    let turning: Vector3<f64> = rate.fixed_rows::<3>(part::ANGULAR_VELOCITY).into();
    let per_mass = body.gyration_m2();
    let omega = state.angular_velocity_rad_s;
    let momentum = per_mass.component_mul(&omega);
    let moment = state.orientation * (per_mass.component_mul(&turning) + omega.cross(&momentum));
    let world_from_link = Pose::from_parts(state.position_m.into(), state.orientation);
    let lowest = link.solid.lowest(&world_from_link, &state.position_m, &n);
    let height_m = -lowest.expect(FINITE).gap_m;
    let along = moment + n.cross(&(acceleration - pull)) * height_m;
    let centre_m = n.cross(&along) / -pull.dot(&n);
    outside_m(link, &state, state.position_m - n * height_m + centre_m)
}

/// Distance of a point from a body's solid \[m, world\]; zero within.
fn outside_m(link: &MovingLink, state: &State, point_m: Vector3<f64>) -> f64 {
    let world_from_link = Pose::from_parts(state.position_m.into(), state.orientation);
    let here = Pose::translation(point_m.x, point_m.y, point_m.z);
    let point = Solid::ball(0.0);
    let distance_m = link.solid.distance_m(&world_from_link, &point, &here);
    distance_m.expect(FINITE).max(0.0)
}

/// Whether a face that lands flat on the world is pressed within its outline.
pub(super) fn presses_within(
    world: &World,
    link: &MovingLink,
    state: &State,
    law: &CheckedLaw,
    impact: &Impact,
) -> bool {
    let pressed_n_s: f64 = impact.normal_impulses_n_s.iter().sum();
    if !law.contacts.is_flat() || !(pressed_n_s > 0.0) {
        return false;
    }
    let points = law
        .contacts
        .as_slice()
        .iter()
        .zip(impact.normal_impulses_n_s);
    let weighed = points.map(|(contact, n_s)| contact.a().place_m() * n_s);
    let centre_m = weighed.sum::<Vector3<f64>>() / pressed_n_s;
    let point_m = state.position_m + state.orientation * centre_m;
    outside_m(link, state, point_m) <= world.scene.tolerance_m
}
