//! Pendulums that hang from a handle in the hand, through the program.

use enact::motion::held::HeldEstimate;
use enact::motion::{Scene, TakeEvent, TrackIndex, Verdict};
use enact::physics::tree::Snapshot;
use enact::pipeline::{Outcome, Pipeline};
use enact_tools::tree_hands::{self, HandActing, HandPerformance};
use enact_tools::trees::Jointed;

const JOINTS: [Jointed; 3] = [Jointed::Pin, Jointed::Universal, Jointed::Ball];

fn finished(performance: &HandPerformance) -> Outcome {
    let events = performance.events.iter().cloned();
    let outcome = Pipeline::of(performance.scene.clone(), events).finish(&mut ());
    outcome.expect("an estimate")
}

/// Root mean square distance of the rods' centres from the true ones \[m\], at all samples.
fn off_m(performance: &HandPerformance, outcome: &Outcome) -> f64 {
    let (scene, estimate) = (&outcome.scene, &outcome.estimate);
    let (_, joined) = scene.joint_trees().next().expect("a tree");
    let tree = scene.tree_model_with(joined, &estimate.held);
    let gravity = &estimate.gravity_m_s2;
    let mut found = Snapshot::new(&tree, gravity);
    let mut truth = Snapshot::new(&performance.tree, gravity);
    let mut square = 0.0;
    for state in &performance.states {
        truth.set(state);
        found.set(&estimate.trees[0].state(&tree, gravity, state.time_s));
        for link in 0..2 {
            let apart = found.link_state(link).position_m - truth.link_state(link).position_m;
            square += apart.norm_squared();
        }
    }
    (square / (2.0 * performance.states.len() as f64)).sqrt()
}

#[test]
fn probe() {
    for (name, acting) in [("exact", HandActing::EXACT), ("usual", HandActing::USUAL)] {
        for joints in JOINTS {
            for seed in 7000..7010 {
                let performance = tree_hands::perform(joints, &acting, seed);
                let begun = std::time::Instant::now();
                let outcome = finished(&performance);
                println!(
                    "{name} {joints:?} {seed}: {:?} {:.3} mm {:?} fit {:?} step {:?} {:?}",
                    outcome.estimate.verdict,
                    1e3 * off_m(&performance, &outcome),
                    outcome.estimate.doubts,
                    outcome.estimate.fit.as_ref().map(|f| f.fits),
                    outcome
                        .estimate
                        .trees
                        .first()
                        .map(|t| (t.step_s, t.knots.len())),
                    begun.elapsed(),
                );
            }
        }
    }
}
