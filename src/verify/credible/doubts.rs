//! All doubts about one estimate.

use super::flights::flights;
use super::{fit, kinematics, marks, outside, parameters};
use crate::motion::{Doubt, Estimate, Scene, Sketch};

/// What speaks against an estimated motion, apart from what its shapes run into.
///
/// `marks_made_s` are the acted times of the scene's events as the performer marked them, `None`
/// where nobody did. The estimate's arcs must be finite; it must be of this sketch. Costs a few sums per
/// sample.
pub fn doubts(
    scene: &Scene,
    sketch: &Sketch,
    marks_made_s: &[Option<f64>],
    estimate: &Estimate,
) -> Vec<Doubt> {
    let flights = flights(sketch, estimate);
    let mut doubts = kinematics::doubts(scene, estimate, &flights);
    doubts.extend(fit::doubts(scene, estimate, &flights));
    doubts.extend(marks::doubts(scene, sketch, marks_made_s, estimate));
    doubts.extend(outside::doubts(scene, &flights));
    doubts.extend(parameters::doubts(scene, estimate));
    doubts
}
