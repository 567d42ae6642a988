//! How far joined bodies reach: a point of what hangs from the world is no farther from the first joint than the ways from joint to
//! joint are long together, and no nearer than the longest of them is longer than all others.

use super::condition::{BodyPoint, Condition, GoalQuantity};
use super::contradiction::DIGITS;
use super::goal::Goal;
use super::whole::Scene;
use crate::motion::index::LinkIndex;
use crate::motion::scene::joint::JointEnd;

impl Scene {
    /// What is wrong with a hard goal for a place to which its body cannot come.
    pub(super) fn out_of_reach(&self, goal: &Goal) -> Option<String> {
        let conditions = goal.target.conditions();
        conditions.iter().find_map(|of| self.beyond(goal.link, of))
    }

    fn beyond(&self, link: LinkIndex, condition: &Condition) -> Option<String> {
        let GoalQuantity::Position {
            point,
            seen_from: None,
        } = &condition.quantity
        else {
            return None;
        };
        let mut at_m = match point {
            BodyPoint::Centre => nalgebra::Vector3::zeros(),
            BodyPoint::Fixed(at_m) => *at_m,
            BodyPoint::Contact(_) => return None,
        };
        let (mut ways_m, mut link) = (Vec::new(), link);
        let first = loop {
            // What flies reaches everywhere.
            let joint = self.joint_of(link)?;
            ways_m.push((at_m - joint.place_m(JointEnd::Child)).norm());
            match joint.parent {
                Some(parent) => (at_m, link) = (joint.place_m(JointEnd::Parent), parent),
                None => break joint,
            }
        };
        let from_m = first.place_m(JointEnd::Parent);
        let (all_m, longest_m) = (
            ways_m.iter().sum::<f64>(),
            ways_m.iter().copied().fold(0.0, f64::max),
        );
        let away_m = condition.set.distance(&from_m);
        let least_m = match condition.set.is_point(3) {
            true => 2.0 * longest_m - all_m,
            false => f64::NEG_INFINITY,
        };
        if condition.sd.is_some() || away_m <= all_m + DIGITS && away_m >= least_m - DIGITS {
            return None;
        }
        let (name, most_mm) = (&first.name, 1e3 * all_m);
        let bounds = match away_m > all_m {
            true => format!("at most {most_mm:.3}"),
            false => format!("at least {:.3}", 1e3 * least_m),
        };
        Some(format!(
            "that is {:.3} mm from {name:?}, from which what hangs reaches {bounds} mm, expected a place within its reach",
            1e3 * away_m
        ))
    }
}
