//! Hard bodies: thin rods, moments that are nearly equal, fast spin.

use enact::motion::{Goal, GoalTarget};
use enact::physics::Body;
use nalgebra::Vector3;

use super::flights::spinning;
use super::hit::{PENCIL, wall};
use super::{Trouble, add_both};
use crate::case::Case;
use crate::perform::{Style, Truth, hat_box, simulate};

/// Adds them.
pub fn add(all: &mut Vec<Trouble>) {
    for ratio in [1e-2, 1e-4, 1e-6] {
        let name = format!("1 : {ratio:.0e}");
        add_both(all, "inertia ratio", &name, move |acting, seed| {
            let truth = with_moments([1.0, 1.0, ratio])?;
            Ok(Case::new(&truth, acting, seed))
        });
    }
    for (heavy, name) in [(0, "hat : box"), (1, "box : hat")] {
        for ratio in [1e3, 1e6] {
            let name = format!("{name}, {ratio:.0e} : 1");
            add_both(all, "mass ratio", &name, move |acting, seed| {
                Ok(Case::new(&heavier(heavy, ratio)?, acting, seed))
            });
        }
    }
    for power in [3, 6, 9, 12, 15] {
        let delta = 10f64.powi(-power);
        let name = format!("pencil, 1e-{power}");
        add_both(all, "nearly equal moments", &name, move |acting, seed| {
            let truth = with_moments([1.0, 1.0 + delta, PENCIL[2]])?;
            Ok(Case::new(&truth, acting, seed))
        });
        let name = format!("sphere, 1e-{power}");
        add_both(all, "nearly equal moments", &name, move |acting, seed| {
            let truth = wall(1.0, 0.75, [1.0, 1.0 + delta, 1.0 - delta], seed)?;
            Ok(Case::new(&truth, acting, seed))
        });
    }
    for spin_rad_s in [0.0, 50.0, 200.0, 1000.0] {
        let name = format!("{spin_rad_s} rad/s about the pencil");
        add_both(all, "spin", &name, move |acting, seed| {
            Ok(Case::new(&spinning(spin_rad_s)?, acting, seed))
        });
    }
}

/// The tip-first motion of a pencil with other moments, of the same size.
pub fn with_moments(shares: [f64; 3]) -> Result<Truth, String> {
    let mut scene = Style::Tip.truth().scene;
    let body = scene.bodies[0].body;
    let moments_kg_m2 = Vector3::from(shares) * body.moments_kg_m2().x;
    scene.bodies[0].body =
        Body::new(body.mass_kg(), moments_kg_m2).map_err(|error| error.to_string())?;
    Style::Tip
        .truth_in(&scene)
        .map_err(|error| error.to_string())
}

/// Hat and box, one of them so many times heavier than the other: thrown as ever, so that they
/// meet as ever, and part in another way. Their poses then are the goals.
pub fn heavier(heavy: usize, ratio: f64) -> Result<Truth, String> {
    let usual = hat_box::truth();
    let mut scene = usual.scene.clone();
    let bodies = &mut scene.bodies;
    let now = bodies[heavy].body.mass_kg() / bodies[1 - heavy].body.mass_kg();
    let factor = ratio / now;
    let body = &mut bodies[heavy].body;
    *body = Body::new(factor * body.mass_kg(), factor * body.moments_kg_m2())
        .map_err(|error| error.to_string())?;
    let initial = [usual.state(0, 0.0), usual.state(1, 0.0)];
    let mut truth = simulate(&scene, &usual.parameters, &initial, usual.duration_s)
        .map_err(|error| error.to_string())?;
    let landing = scene.events.len() - 1;
    truth.scene.goals = (0..2)
        .map(|body| Goal {
            event: landing,
            body,
            target: GoalTarget::Pose {
                world_from_body: truth.world_from_body(body, truth.duration_s),
            },
        })
        .collect();
    Ok(truth)
}
