//! Scales: weights over decades, units by mistake, tempo.

use enact::motion::{TakeEvent, Timing as Stamps};
use enact::physics::Body;

use super::{Timing, Trouble, add_both};
use crate::case::Case;
use crate::perform::{Acting, Style};

/// Adds them.
pub fn add(all: &mut Vec<Trouble>) {
    for power in [-3, -2, -1, 1, 2, 3] {
        let factor = 10f64.powi(power);
        let name = format!("both × 1e{power}");
        add_both(all, "weights", &name, move |acting, seed| {
            let mut case = Case::pencil(Style::Tip, acting, seed);
            let weights = &mut case.performance.truth.scene.weights;
            weights.position_m *= factor;
            weights.orientation_rad *= factor;
            Ok(case)
        });
        let name = format!("position × 1e{power}");
        add_both(all, "weights", &name, move |acting, seed| {
            let mut case = Case::pencil(Style::Tip, acting, seed);
            case.performance.truth.scene.weights.position_m *= factor;
            Ok(case)
        });
    }
    add_both(all, "units", "positions in mm", |acting, seed| {
        let mut case = Case::pencil(Style::Tip, acting, seed);
        for event in &mut case.performance.events {
            if let TakeEvent::Pose { sample, .. } = event {
                sample.position_m *= 1e3;
            }
        }
        Ok(case)
    });
    add_both(all, "units", "gravity in mm/s²", |acting, seed| {
        let mut case = Case::pencil(Style::Tip, acting, seed);
        case.performance.truth.scene.gravity_m_s2 *= 1e3;
        Ok(case)
    });
    for (name, mass, moments) in [
        ("mass and moments × 1000", 1e3, 1e3),
        ("moments in g mm²", 1.0, 1e9),
    ] {
        add_both(all, "units", name, move |acting, seed| {
            let mut case = Case::pencil(Style::Tip, acting, seed);
            let body = &mut case.performance.truth.scene.bodies[0].body;
            *body = Body::new(mass * body.mass_kg(), moments * body.moments_kg_m2())
                .map_err(|error| error.to_string())?;
            Ok(case)
        });
    }
    for style in Style::ALL {
        all.push(Trouble {
            theme: "tempo",
            name: format!("{} first, 10 × slower", style.as_str()),
            timing: Timing::Unknown,
            make: Box::new(move |seed| {
                let acting = Acting {
                    slowdown: 10.0,
                    ..Acting::default()
                };
                Ok(Case::pencil(style, &acting, seed))
            }),
        });
    }
    for slowdown in [1.2, 2.5, 10.0] {
        all.push(Trouble {
            theme: "tempo",
            name: format!("{slowdown} × slower, called physical by mistake"),
            timing: Timing::Known,
            make: Box::new(move |seed| {
                let acting = Acting {
                    slowdown,
                    ..Acting::default()
                };
                let mut case = Case::pencil(Style::Tip, &acting, seed);
                case.performance.truth.scene.timing = Stamps::Known;
                Ok(case)
            }),
        });
    }
}
