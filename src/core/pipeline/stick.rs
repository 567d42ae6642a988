//! Where bodies stick together, as a motion has it: the whole of both flies by that, so that it is solved again until both agree.

use super::infer::Inferred;
use crate::math::{Pose, so3};
use crate::motion::{Observer, Performance, Scene, Segment, Sketch, StuckPair, Verdict};

/// Greatest number of rounds.
const ROUNDS: usize = 12;

/// A pose stays the same where it moves by no more \[m, rad\].
const SAME: f64 = 1e-9;

/// Goes on to the motion in which bodies stick together where they meet in it.
pub(super) fn again(
    inferred: &mut Inferred,
    sketch: &Sketch,
    segments: &[Segment],
    observer: &mut dyn Observer,
) {
    let pairs: Vec<StuckPair> = inferred.scene.stuck_pairs().collect();
    let mut before: Vec<Option<Pose>> = vec![None; pairs.len()];
    for _ in 0..ROUNDS {
        let estimate = &inferred.solved.estimate;
        if pairs.is_empty() || estimate.verdict == Verdict::Failed || observer.should_stop() {
            return;
        }
        let mut scene: Scene = inferred.scene.clone();
        let mut is_same = true;
        for (pair, before) in pairs.iter().zip(&mut before) {
            let Some(pose) = scene.stuck_pose(pair, estimate) else {
                return;
            };
            let moved = before.map(|before| before.inverse() * pose);
            is_same &= moved.is_some_and(|by| {
                by.translation.vector.norm() + so3::log(&by.rotation).norm() <= SAME
            });
            *before = Some(pose);
            scene.stick(pair, &pose);
        }
        if is_same {
            return;
        }
        let performance = Performance {
            scene: &scene,
            sketch,
            segments,
        };
        let Some(solved) = inferred.solved.flown_as_said(performance, observer) else {
            return;
        };
        inferred.solved = solved;
        inferred.scene = scene;
    }
}
