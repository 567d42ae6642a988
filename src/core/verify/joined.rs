//! What speaks against a motion of bodies joined in trees, and of bodies by themselves beside them.
//!
//! | quantity | bound | origin |
//! |---|---|---|
//! | residual of a track, of a body by itself in each flight, in weights | 3 | 2 of a hand that wanders by 20 mm, with weights of 10 mm |
//! | speed of a link's fastest point, its angular speed | as [`credible`](super::credible) | |
//! | distance from the same start integrated with half the steps, through impacts by their law | 1 µm | errors at the end of 2 to 5 links, in `tools/results/trees.md`: up to 10⁻⁸ rad |
//! | distance of what touches at an impact, speed at which it recedes, kinetic energy gained | 1 µm, 1 µm/s, 10⁻⁹ | the same |
//! | impulse by which one of several contacts pulls, of the greatest | 10⁻⁶ | rounding |
//! | angle of a joint beyond its limits | 0.5° | what a hinge yields and a drawing rounds |
//! | time of an event from its mark | as of bodies | |
//! | overlap of links that no joint ties, and with the world; parts that touch before what is named | as of bodies ([`Scene::tolerance_m`]) | |

mod again;
mod energy;
mod flights;
mod limits;

use super::credible::kinematics::{SPEED_M_S, SPIN_RAD_S};
use super::credible::marks;
use super::meeting::World;
use super::{overlap, touch};
use crate::motion::{
    About, Balance, Doubt, Estimate, Observer, Place, Pull, Scene, SingleShot, Sketch, TrackIndex,
    Verdict, Verification,
};
use crate::physics::tree::Snapshot;

/// Greatest root mean square residual of a track, in units of its weights: a usual hand strays by two, and a motion is farther from
/// it where it need not follow it slowly.
const RESIDUAL: f64 = 5.0;
/// Greatest distance by halved steps \[m\].
const STEPS_M: f64 = 1e-6;
/// Greatest distance of a contact from touching at its impact \[m\],
pub(super) const GAP_M: f64 = 1e-6;
/// greatest speed at which it recedes before [m/s], and share of the kinetic energy that is gained.
const RECEDING_M_S: f64 = 1e-6;
const ENERGY: f64 = 1e-9;

/// What checks found of a motion of joined bodies.
#[derive(Clone, Debug)]
pub struct JoinedCheck {
    /// What speaks against it.
    pub doubts: Vec<Doubt>,
    /// What was measured; `None` of what is no motion.
    pub verification: Option<Verification>,
}

/// Doubts about all that moves of a scene with joined bodies as estimated, given when marks of events were made \[s, acted\].
pub fn doubts(
    scene: &Scene,
    sketch: &Sketch,
    marks_made_s: &[Option<f64>],
    estimate: &Estimate,
) -> Vec<Doubt> {
    let found = check_until(scene, sketch, marks_made_s, estimate, &mut ());
    found.expect("nobody ends it").doubts
}

/// The checks for as long as the observer lets them; `None` where it ended them.
pub fn check_until(
    scene: &Scene,
    sketch: &Sketch,
    marks_made_s: &[Option<f64>],
    estimate: &Estimate,
    observer: &mut dyn Observer,
) -> Option<JoinedCheck> {
    if observer.should_stop() {
        return None;
    }
    let mut doubts = marks::doubts(scene, sketch, marks_made_s, estimate);
    for motion in &estimate.trees {
        let Some(joined) = scene.mechanisms[motion.mechanism].tree() else {
            continue;
        };
        for residual in &motion.residuals {
            let rms = [residual.position_rms_m, residual.orientation_rms_rad];
            let off = in_weights(scene, residual.track, rms);
            doubts.extend(Doubt::beyond(About::Residual, Place::Motion, off, RESIDUAL));
        }
        let tree = scene.tree_model_with(joined, &estimate.held);
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
        doubts.extend(
            [
                beyond(About::Speed, fastest_m_s, SPEED_M_S),
                beyond(About::Spin, fastest_rad_s, SPIN_RAD_S),
            ]
            .into_iter()
            .flatten(),
        );
    }
    let off = again::off(scene, estimate);
    doubts.extend(
        [
            beyond(About::Steps, off.position_m, STEPS_M),
            beyond(About::Gap, off.gap_m, GAP_M),
            beyond(About::Receding, off.receding_m_s, RECEDING_M_S),
            beyond(About::Energy, off.energy, ENERGY),
        ]
        .into_iter()
        .flatten(),
    );
    let is_finite = estimate.trees.iter().all(|motion| motion.is_finite())
        && estimate.arcs.iter().all(|arc| arc.state.is_finite());
    // What failed is no motion that could be called physical; joints that whirl take long to follow from all sides.
    let is_motion = is_finite && estimate.verdict != Verdict::Failed;
    let mut verification = None;
    if is_motion && !estimate.trees.is_empty() {
        let world = World::new(scene, estimate);
        doubts.extend(flights::doubts(scene, &world, estimate));
        let mut touches = touch::touches(&world);
        let deepest = overlap::deepest(&world, &mut touches, observer);
        if observer.should_stop() {
            return None;
        }
        let found = verification.insert(Verification {
            tolerance_m: scene.tolerance_m,
            deepest,
            touches,
            pulls: off.pulls,
            of_contacts: Vec::new(),
            single_shot: SingleShot {
                deviations: off.ends,
                ..SingleShot::default()
            },
            balance: Balance {
                flight_energy: energy::largest_change(scene, estimate),
                impact_energy: off.energy.max(0.0),
                ..Balance::default()
            },
        });
        doubts.extend(found.doubts());
    } else {
        doubts.extend(off.pulls.iter().filter_map(Pull::doubt));
    }
    Some(JoinedCheck {
        doubts,
        verification,
    })
}

fn beyond(about: About, value: f64, bound: f64) -> Option<Doubt> {
    Doubt::beyond(about, Place::Motion, value, bound)
}

/// The larger residual of a track \[m\] \[rad\] in units of its weights.
fn in_weights(scene: &Scene, track: TrackIndex, rms: [Option<f64>; 2]) -> f64 {
    let weights = scene.tracks[track].weights(&scene.weights);
    let units = [weights.position_m, weights.orientation_rad];
    let seen = rms.into_iter().zip(units);
    let seen = seen.filter_map(|(rms, unit)| Some(rms? / unit));
    seen.fold(0.0, larger)
}

/// The larger of two; infinite where the other is no number, so that nothing unknown looks small.
fn larger(most: f64, other: f64) -> f64 {
    most.max(if other.is_nan() { f64::INFINITY } else { other })
}
