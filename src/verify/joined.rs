//! What speaks against a motion of bodies joined in a tree.
//!
//! | quantity | bound | origin |
//! |---|---|---|
//! | residual of a track, in weights | 3 | 2 of a hand that wanders by 20 mm, with weights of 10 mm |
//! | speed of a link's fastest point, its angular speed | as [`credible`](super::credible) | |
//! | distance from the same start integrated with half the steps, through impacts by their law | 1 µm | errors at the end of 2 to 5 links, in `tools/results/trees.md`: up to 10⁻⁸ rad |
//! | distance of what touches at an impact, speed at which it recedes, kinetic energy gained | 1 µm, 1 µm/s, 10⁻⁹ | the same |
//! | angle of a joint beyond its limits | 0.5° | what a hinge yields and a drawing rounds |
//! | time of an event from its mark | as of bodies | |
//! | overlap of links that no joint ties, and with the world; parts that touch before what is named | as of bodies ([`TOLERANCE_M`]) | |

mod again;
mod limits;
mod link;

pub(super) use link::JoinedLink;

use super::credible::kinematics::{SPEED_M_S, SPIN_RAD_S};
use super::credible::marks;
use super::meeting::World;
use super::{TOLERANCE_M, overlap, touch};
use crate::motion::{About, Doubt, Estimate, Place, Scene, Sketch, TrackResidual};
use crate::physics::tree::Snapshot;

/// Greatest root mean square residual of a track, in units of its weights.
const RESIDUAL: f64 = 3.0;
/// Greatest distance by halved steps \[m\].
const STEPS_M: f64 = 1e-6;
/// Greatest distance of a contact from touching at its impact \[m\],
const GAP_M: f64 = 1e-6;
/// greatest speed at which it recedes before [m/s], and share of the kinetic energy that is gained.
const RECEDING_M_S: f64 = 1e-6;
const ENERGY: f64 = 1e-9;

/// Doubts about all joined bodies of an estimate, given when marks of events were made \[s, acted\].
pub fn doubts(
    scene: &Scene,
    (sketch, marks_made_s): (&Sketch, &[Option<f64>]),
    estimate: &Estimate,
) -> Vec<Doubt> {
    let mut doubts = marks::doubts(scene, sketch, marks_made_s, estimate);
    for motion in &estimate.trees {
        let Some(joined) = scene.mechanisms[motion.mechanism].tree() else {
            continue;
        };
        for residual in &motion.residuals {
            let rms = in_weights(scene, residual);
            doubts.extend(Doubt::beyond(About::Residual, Place::Motion, rms, RESIDUAL));
        }
        let tree = scene.tree_model(joined);
        let mut snapshot = Snapshot::new(&tree, &estimate.gravity_m_s2);
        let (mut fastest_m_s, mut fastest_rad_s): (f64, f64) = (0.0, 0.0);
        for knot in &motion.knots {
            snapshot.set(&knot.state);
            for (place, link) in joined.links().enumerate() {
                let state = snapshot.link_state(place);
                let spin_rad_s = state.angular_velocity_rad_s.norm();
                let rim_m_s = spin_rad_s * scene.links[link].radius_m();
                fastest_m_s = larger(fastest_m_s, state.velocity_m_s.norm() + rim_m_s);
                fastest_rad_s = larger(fastest_rad_s, spin_rad_s);
            }
        }
        doubts.extend(limits::doubts(joined, &tree, motion));
        let off = again::off((scene, joined, &tree), estimate, motion);
        doubts.extend(
            [
                (About::Speed, fastest_m_s, SPEED_M_S),
                (About::Spin, fastest_rad_s, SPIN_RAD_S),
                (About::Steps, off.position_m, STEPS_M),
                (About::Gap, off.gap_m, GAP_M),
                (About::Receding, off.receding_m_s, RECEDING_M_S),
                (About::Energy, off.energy, ENERGY),
            ]
            .into_iter()
            .filter_map(|(about, value, bound)| Doubt::beyond(about, Place::Motion, value, bound)),
        );
    }
    if estimate.trees.iter().all(|motion| motion.is_finite()) && !estimate.trees.is_empty() {
        let world = World::new(scene, estimate);
        let mut touches = touch::touches(&world);
        let deepest = overlap::deepest(&world, &mut touches);
        doubts.extend(deepest.map(|deepest| deepest.doubt(TOLERANCE_M)));
        let wrong = touches.iter().filter(|touch| touch.is_wrong);
        doubts.extend(wrong.map(|touch| touch.doubt(TOLERANCE_M)));
    }
    doubts
}

/// The larger residual of a track in units of its weights.
fn in_weights(scene: &Scene, residual: &TrackResidual) -> f64 {
    let weights = scene.tracks[residual.track].weights(&scene.weights);
    let position = residual
        .position_rms_m
        .map(|rms_m| rms_m / weights.position_m);
    let turn = residual
        .orientation_rms_rad
        .map(|rms_rad| rms_rad / weights.orientation_rad);
    position.into_iter().chain(turn).fold(0.0, larger)
}

/// The larger of two; infinite where the other is no number, so that nothing unknown looks small.
fn larger(most: f64, other: f64) -> f64 {
    most.max(if other.is_nan() { f64::INFINITY } else { other })
}
