//! What speaks against a motion of bodies joined in a tree.
//!
//! | quantity | bound | origin |
//! |---|---|---|
//! | residual of a track, in weights | 3 | 2 of a hand that wanders by 20 mm, with weights of 10 mm |
//! | speed of a link's fastest point, its angular speed | as [`credible`](super::credible) | |
//! | distance from the same start integrated with half the steps | 1 µm | errors at the end of 2 to 5 links, in `tools/results/trees.md`: up to 10⁻⁸ rad |

use super::credible::kinematics::{SPEED_M_S, SPIN_RAD_S};
use crate::motion::{About, Doubt, Estimate, Place, Scene, TrackResidual, TreeEstimate};
use crate::physics::tree::{Flow, Snapshot, Tree, tableau};

/// Greatest root mean square residual of a track, in units of its weights.
const RESIDUAL: f64 = 3.0;
/// Greatest distance by halved steps \[m\].
const STEPS_M: f64 = 1e-6;

/// Doubts about all joined bodies of an estimate.
pub fn doubts(scene: &Scene, estimate: &Estimate) -> Vec<Doubt> {
    let mut doubts = Vec::new();
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
                fastest_m_s = fastest_m_s.max(state.velocity_m_s.norm() + rim_m_s);
                fastest_rad_s = fastest_rad_s.max(spin_rad_s);
            }
        }
        let off_m = off_by_steps_m(estimate, motion, &tree);
        doubts.extend(
            [
                (About::Speed, fastest_m_s, SPEED_M_S),
                (About::Spin, fastest_rad_s, SPIN_RAD_S),
                (About::Steps, off_m, STEPS_M),
            ]
            .into_iter()
            .filter_map(|(about, value, bound)| Doubt::beyond(about, Place::Motion, value, bound)),
        );
    }
    doubts
}

/// Greatest distance of a link's centre, at any knot, from where the first knot leads with steps of half the
/// length \[m\].
fn off_by_steps_m(estimate: &Estimate, motion: &TreeEstimate, tree: &Tree) -> f64 {
    let [first, rest @ ..] = motion.knots.as_slice() else {
        return 0.0;
    };
    let gravity_m_s2 = &estimate.gravity_m_s2;
    let mut flow = Flow::new(tree, gravity_m_s2, tableau::DORMAND_PRINCE);
    flow.begin(&first.state, false);
    let (mut here, mut again) = (
        Snapshot::new(tree, gravity_m_s2),
        Snapshot::new(tree, gravity_m_s2),
    );
    let mut now_s = first.time_s;
    let mut most_m: f64 = 0.0;
    for knot in rest {
        let interval_s = knot.time_s - now_s;
        let steps = (interval_s / motion.step_s).ceil().max(1.0) as usize;
        flow.advance(interval_s, 2 * steps, 0.0);
        now_s = knot.time_s;
        here.set(&knot.state);
        again.set(&flow.state());
        for place in 0..tree.link_count() {
            let [a, b] = [&here, &again].map(|of| of.link_state(place).position_m);
            let off_m = (a - b).norm();
            let is_told = off_m.is_finite();
            most_m = most_m.max(if is_told { off_m } else { f64::INFINITY });
        }
    }
    most_m
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
    position.into_iter().chain(turn).fold(0.0, f64::max)
}
