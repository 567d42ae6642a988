//! What slides after an impact.

use super::*;
use crate::motion::{OnSurface, SupportPhase, SupportedBy};
use crate::physics::Sustained;

/// The rod lands flat, with friction, and slides on.
pub(super) fn sliding(timing: Timing) -> Scene {
    let mut scene = landing(timing);
    scene.contact_laws[LAW].friction = 0.3;
    let free = parameter("f", Quantity::Friction { law: LAW }, 0.2, (0.0, 20.0));
    scene.parameters.push(free);
    let face = Feature {
        name: "below".into(),
        geometry: contact::Feature::face(Vector3::new(0.0, 0.0, -0.1), -Vector3::z()),
    };
    let features = &mut scene.links[LinkIndex(0)].features;
    features.push(face);
    let feature = features.len() - 1;
    scene.phases.push(SupportPhase {
        name: "sliding".into(),
        link: LinkIndex(0),
        by: SupportedBy::Surface(OnSurface {
            sustained: Sustained::Slide,
            surface: 0,
            feature,
            law: LAW,
        }),
        events: [0, 1],
    });
    scene
}
