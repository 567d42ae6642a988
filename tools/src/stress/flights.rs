//! Hard motions: many bounces, grazing contacts, extreme restitution, two bounces at once.

use enact::math::so3;
use enact::motion::{Collision, ContactLaw, Event, EventKind, LinkIndex};
use enact::physics::{Body, State};
use nalgebra::{UnitQuaternion, Vector3};

use super::hit::{PENCIL, at_impact, hit, normal3, rng, wall};
use super::{Timing, Trouble, add_both};
use crate::case::Case;
use crate::perform::truth::Flight;
use crate::perform::{Style, Truth, bounces, simulate};

/// Adds them.
pub fn add(all: &mut Vec<Trouble>) {
    for approach_m_s in [1.0, 0.3, 0.1, 0.03, 0.01] {
        let name = format!("{approach_m_s} m/s against a wall");
        add_both(all, "approach", &name, move |acting, seed| {
            Ok(Case::new(
                &wall(approach_m_s, 0.75, PENCIL, seed)?,
                acting,
                seed,
            ))
        });
    }
    for restitution in [0.0, 1.0] {
        let name = format!("{restitution} at a wall");
        add_both(all, "restitution", &name, move |acting, seed| {
            Ok(Case::new(
                &wall(1.0, restitution, PENCIL, seed)?,
                acting,
                seed,
            ))
        });
    }
    add_both(all, "restitution", "1, tip first", |acting, seed| {
        let mut scene = Style::Tip.truth().scene;
        for law in &mut scene.contact_laws {
            law.restitution = 1.0;
        }
        let truth = Style::Tip.truth_in(&scene).map_err(|e| e.to_string())?;
        Ok(Case::new(&truth, acting, seed))
    });
    add_both(all, "drop", "vertical, no rotation", |acting, seed| {
        Ok(Case::new(&vertical_drop()?, acting, seed))
    });
    for between_s in [0.004, 0.02] {
        let name = format!("{} ms apart", 1e3 * between_s);
        add_both(all, "two bounces", &name, move |acting, seed| {
            Ok(Case::new(&both_ends(between_s, seed)?, acting, seed))
        });
    }
}

/// Adds many bounces.
pub fn add_bounces(all: &mut Vec<Trouble>) {
    for timing in Timing::ALL {
        for distortion in [0.25, 1.0] {
            for count in [1, 2, 4, 6, 8, 12, 16, 20] {
                all.push(Trouble {
                    theme: "bounces",
                    name: format!("{count} of a cube, {distortion}×"),
                    timing,
                    make: Box::new(move |seed| {
                        let truth = bounces(count, seed).map_err(|error| error.to_string())?;
                        Ok(Case::new(&truth, &timing.acting(distortion), seed))
                    }),
                });
            }
        }
    }
}

/// A pencil that stands on its tip in the air, falls and jumps back without turning.
pub fn vertical_drop() -> Result<Truth, String> {
    let scene = Style::Tip.truth().scene;
    let state = State {
        position_m: Vector3::new(0.0, 0.0, 0.095),
        orientation: UnitQuaternion::identity(),
        velocity_m_s: Vector3::new(0.0, 0.0, -3.4),
        angular_velocity_rad_s: Vector3::zeros(),
    };
    hit(&scene, &state, 0.35, 0.4)
}

/// A stick with heavy ends that falls nearly flat: its tip, then so much later its eraser, hit the
/// table. One end's impact does not move the other, or they would rattle.
fn both_ends(between_s: f64, seed: u64) -> Result<Truth, String> {
    let mut scene = Style::Tip.truth().scene;
    let features = scene.links[LinkIndex(0)].features.clone();
    let named = |name: &str| features.iter().position(|f| f.name == name);
    let (tip, eraser) = (
        named("tip").ok_or("no tip")?,
        named("eraser").ok_or("none")?,
    );
    let body = &mut scene.links[LinkIndex(0)].body;
    let heavy_ends = body.mass_kg() * 0.095 * 0.095;
    let moments_kg_m2 = Vector3::new(heavy_ends, heavy_ends, body.moments_kg_m2().z);
    *body = Body::new(body.mass_kg(), moments_kg_m2).map_err(|e| e.to_string())?;
    let law = scene.add_law(ContactLaw::frictionless("pencil", 0.7));
    let bounce = |name: &str, feature: usize| {
        let bounce = Collision::bounce(LinkIndex(0), feature, 0, law);
        Event::new(name, EventKind::Collision(bounce))
    };
    let end = scene.events.pop().ok_or("no events")?;
    scene.events = vec![bounce("tip", tip), bounce("eraser", eraser), end];
    scene.goals.clear();
    let mut rng = rng(seed);
    let mut speed_m_s = 3.0;
    // The eraser falls faster after the tip has hit: by iteration.
    for _ in 0..20 {
        let tilt_rad = (speed_m_s * between_s / 0.19_f64).asin();
        let flat = UnitQuaternion::rotation_between(&Vector3::z(), &Vector3::x());
        let orientation = so3::exp(&(Vector3::y() * -tilt_rad)) * flat.ok_or("opposite axes")?;
        let state = State {
            position_m: -(orientation * Vector3::new(0.0, 0.0, -0.095)),
            orientation,
            velocity_m_s: Vector3::new(0.2, 0.1, -2.5),
            angular_velocity_rad_s: Vector3::zeros(),
        };
        let flight = Flight::of(&scene, LinkIndex(0));
        let initial = flight.advance(&state, -0.3);
        let mut truth = simulate(&scene, &[], &[initial], 0.45).map_err(|e| e.to_string())?;
        let found_s = truth.event_times_s[1] - truth.event_times_s[0];
        if (found_s / between_s - 1.0).abs() < 1e-3 {
            end_above_the_table(&mut truth);
            let turn = so3::exp(&(Vector3::z() * normal3(&mut rng).x));
            return Ok(turned(&truth, &turn));
        }
        speed_m_s *= between_s / found_s;
    }
    Err("no such fall".into())
}

/// Ends it before either end of the pencil is in the table.
fn end_above_the_table(truth: &mut Truth) {
    let lowest_m = |time_s: f64| {
        let state = truth.state(LinkIndex(0), time_s);
        state.position_m.z - 0.095 * (state.orientation * Vector3::z()).z.abs()
    };
    let mut end_s = truth.event_times_s[1] + 0.01;
    while end_s + 0.01 < truth.duration_s && lowest_m(end_s + 0.01) > 0.0 {
        end_s += 0.01;
    }
    truth.duration_s = end_s;
    truth.event_times_s[2] = end_s;
    truth.arcs[2].end_s = end_s;
}

/// The motion turned about the vertical.
fn turned(truth: &Truth, turn: &UnitQuaternion<f64>) -> Truth {
    let mut truth = truth.clone();
    for arc in &mut truth.arcs {
        arc.state.position_m = turn * arc.state.position_m;
        arc.state.velocity_m_s = turn * arc.state.velocity_m_s;
        arc.state.orientation = turn * arc.state.orientation;
    }
    truth
}

/// The pencil of the tip-first scene with another spin about its own axis, the same before.
pub fn spinning(spin_rad_s: f64) -> Result<Truth, String> {
    let truth = Style::Tip.truth();
    let mut state = at_impact(&truth);
    state.angular_velocity_rad_s.z = spin_rad_s;
    let after_s = truth.event_times_s[1] - truth.event_times_s[0];
    hit(&truth.scene, &state, truth.event_times_s[0], after_s)
}
