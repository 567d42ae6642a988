//! Energy and momentum over flights and impacts.
//!
//! A frictionless impact along `n` at the arm `c = p × Rᵀn`, approached with `u`, takes
//!
//! ```text
//! ½ (1 − e²) u² / (1/m + cᵀ I⁻¹ c)
//! ```
//!
//! of the kinetic energy, and nothing of the angular momentum about the point of contact.

use nalgebra::Vector3;

use super::law::Law;
use super::meeting::World;
use super::track::Track;
use crate::motion::Balance;
use crate::physics::{Body, State};

pub(super) fn balance(world: &World) -> Balance {
    let mut balance = Balance::default();
    for track in &world.tracks {
        for arc in &track.arcs {
            let ends = [arc.start_s, arc.end_s].map(|time_s| track.state(arc, time_s));
            flight(world, track, &ends, arc.end_s - arc.start_s, &mut balance);
        }
    }
    for event in &world.estimate.events {
        let Some(law) = Law::new(world.scene, world.estimate, event.event) else {
            continue;
        };
        let track = &world.tracks[law.body];
        let (Some(before), Some(after)) = (
            track.ending_at(event.time_s),
            track.starting_at(event.time_s),
        ) else {
            continue;
        };
        let states = [before, after].map(|arc| track.state(arc, event.time_s));
        impact(&law, &track.of_scene.body, &states, &mut balance);
    }
    balance
}

fn flight(
    world: &World,
    track: &Track,
    [start, end]: &[State; 2],
    duration_s: f64,
    balance: &mut Balance,
) {
    let body = &track.of_scene.body;
    let gravity = world.estimate.gravity_m_s2;
    let potential = -body.mass_kg() * gravity.dot(&(end.position_m - start.position_m));
    let (before, after) = (kinetic_j(body, start), kinetic_j(body, end));
    let of_energy = relative(
        (after + potential - before).abs(),
        before.max(after).max(potential.abs()),
    );
    let speed = start.velocity_m_s.norm().max(end.velocity_m_s.norm());
    let change = end.velocity_m_s - start.velocity_m_s - gravity * duration_s;
    let (spin, spin_after) = (spin_of(body, start), spin_of(body, end));
    balance.flight_energy = balance.flight_energy.max(of_energy);
    balance.flight_momentum = balance.flight_momentum.max(relative(change.norm(), speed));
    balance.flight_angular_momentum = balance
        .flight_angular_momentum
        .max(relative((spin_after - spin).norm(), spin.norm()));
}

fn impact(law: &Law, body: &Body, [before, after]: &[State; 2], balance: &mut Balance) {
    let contact = law.contact(before);
    let arm = contact.arm_m(before, &law.normal);
    let speed = law.normal.dot(&before.velocity_m_s) + arm.dot(&before.angular_velocity_rad_s);
    let inertia = 1.0 / body.mass_kg() + arm.dot(&arm.component_div(&body.moments_kg_m2()));
    let taken = 0.5 * (1.0 - law.restitution * law.restitution) * speed * speed / inertia;
    let energy = kinetic_j(body, before);
    let lost = energy - kinetic_j(body, after);
    balance.impact_energy = balance
        .impact_energy
        .max(relative((lost - taken).abs(), energy));
    let about = |state: &State| {
        let arm = state.orientation * contact.point_m;
        spin_of(body, state) - arm.cross(&(state.velocity_m_s * body.mass_kg()))
    };
    let (l_before, l_after) = (about(before), about(after));
    balance.impact_angular_momentum = balance
        .impact_angular_momentum
        .max(relative((l_after - l_before).norm(), l_before.norm()));
}

fn kinetic_j(body: &Body, state: &State) -> f64 {
    let omega = state.angular_velocity_rad_s;
    0.5 * body.mass_kg() * state.velocity_m_s.norm_squared()
        + 0.5 * body.moments_kg_m2().dot(&omega.component_mul(&omega))
}

/// Angular momentum about the centre of mass [kg m²/s, world].
fn spin_of(body: &Body, state: &State) -> Vector3<f64> {
    let moments = body.moments_kg_m2();
    state.orientation * moments.component_mul(&state.angular_velocity_rad_s)
}

/// Of nothing, nothing can be missing.
fn relative(difference: f64, whole: f64) -> f64 {
    if whole > 0.0 { difference / whole } else { 0.0 }
}
