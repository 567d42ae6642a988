//! Joints beyond the limits that the scene gives them: they are checked, and no stop is
//! simulated before the end.

use crate::motion::{About, Doubt, JointTree, Place, TreeEstimate};
use crate::physics::tree::Tree;

/// Greatest angle beyond a limit \[rad\].
const BEYOND_RAD: f64 = 0.5 * std::f64::consts::PI / 180.0;

/// A doubt for each joint that is beyond its limits at a state of the estimate, where it is farthest.
pub(super) fn doubts(joined: &JointTree, tree: &Tree, motion: &TreeEstimate) -> Vec<Doubt> {
    let mut doubts = Vec::new();
    for joint in &joined.joints {
        let place = joined.place_of(joint.child);
        let Some([_, angles]) = place.and_then(|place| tree.angles_of(place)) else {
            continue;
        };
        let offs = motion.knots.iter().flat_map(|knot| {
            let offs = tree.beyond_limits_rad(&knot.state);
            let offs = offs.filter(|(at, _)| angles.contains(at));
            offs.map(|(_, off_rad)| (off_rad, knot.time_s))
        });
        let Some((off_rad, time_s)) = offs.max_by(|a, b| a.0.total_cmp(&b.0)) else {
            continue;
        };
        let place = Place::Joint {
            child: joint.child,
            time_s,
        };
        doubts.extend(Doubt::beyond(About::Limit, place, off_rad, BEYOND_RAD));
    }
    doubts
}
