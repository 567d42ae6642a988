//! Whether a motion with inferred contacts may be kept.

use crate::motion::{Estimate, Scene, Verdict};
use crate::verify::touches;

/// Whether the estimate is a motion, and the inferred contacts of its open collisions touch first.
pub(super) fn is_sound(scene: &Scene, estimate: &Estimate, open: &[usize]) -> bool {
    let is_wrong = || {
        let touches = touches(&scene.as_estimated(estimate), estimate);
        let mut wrong = touches.iter().filter(|touch| touch.is_wrong);
        wrong.any(|touch| open.contains(&touch.event))
    };
    estimate.verdict != Verdict::Failed && (open.is_empty() || !is_wrong())
}
