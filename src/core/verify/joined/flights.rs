//! Flights of bodies by themselves beside joined ones: how far they are from what was acted, and how fast.

use super::{RESIDUAL, in_weights};
use crate::motion::{About, Doubt, Estimate, Place, Scene};
use crate::verify::bound::spin_bound_rad_s;
use crate::verify::credible::kinematics::{SPEED_M_S, SPIN_RAD_S};
use crate::verify::meeting::World;

/// Doubts about each flight.
pub(super) fn doubts(scene: &Scene, world: &World, estimate: &Estimate) -> Vec<Doubt> {
    let mut doubts = Vec::new();
    for (index, arc) in estimate.arcs.iter().enumerate() {
        let place = Place::Flight {
            mechanism: arc.mechanism,
            start_s: arc.start_s,
        };
        let link = &world.links[scene.free_link(arc.mechanism)];
        let body = &link.of_scene.body;
        let mut say = |about, value, bound| {
            doubts.extend(Doubt::beyond(about, place.clone(), value, bound));
        };
        let residuals = estimate.residuals.iter().filter(|of| of.arc == index);
        for residual in residuals {
            let rms = [residual.position_rms_m, residual.orientation_rms_rad];
            say(
                About::Residual,
                in_weights(scene, residual.track, rms),
                RESIDUAL,
            );
        }
        let speed_m_s = link.speed_bound_m_s(arc, arc.start_s, arc.end_s);
        say(About::Speed, speed_m_s, SPEED_M_S);
        let spin_rad_s = spin_bound_rad_s(body, &arc.state.angular_velocity_rad_s);
        say(About::Spin, spin_rad_s, SPIN_RAD_S);
    }
    doubts
}
