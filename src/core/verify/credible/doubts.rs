//! All doubts about one estimate.

use super::flights::flights;
use super::{brief, fit, kinematics, marks, open_times, outside, parameters};
use crate::motion::{About, Doubt, Estimate, Place, Scene, Sketch};

/// All doubts about an estimated motion, except those from overlaps of its shapes.
///
/// `marks_made_s` are the acted times of the scene's events as the performer marked them, `None`
/// for unmarked ones. The scene is the one as estimated, then the one of which it is the estimate. The estimate's arcs must be finite and belong to this sketch. Costs a few
/// sums per sample.
pub fn doubts(
    scene: &Scene,
    given: &Scene,
    sketch: &Sketch,
    marks_made_s: &[Option<f64>],
    estimate: &Estimate,
) -> Vec<Doubt> {
    let flights = flights(scene, sketch, estimate);
    let mut doubts = kinematics::doubts(scene, estimate, &flights);
    doubts.extend(fit::doubts(scene, sketch, estimate, &flights));
    doubts.extend(brief::doubts(scene, sketch, estimate, &flights));
    doubts.extend(marks::doubts(scene, sketch, marks_made_s, estimate));
    doubts.extend(open_times::doubts(&flights));
    doubts.extend(outside::doubts(scene, &flights));
    doubts.extend(parameters::doubts(given, estimate));
    let rivals = estimate.rivals as f64;
    doubts.extend(Doubt::beyond(About::Rivals, Place::Motion, rivals, 0.0));
    doubts
}
