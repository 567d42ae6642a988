//! Goals that cannot hold, as far as a scene tells it: those that contradict others, times that are given, and places
//! off a contact's face or out of reach.

use nalgebra::Vector3;

use super::condition::{BodyPoint, Condition, GoalQuantity};
use super::goal::{Goal, GoalTarget};
use super::goal_set::GoalSet;
use super::whole::Scene;
use crate::physics::State;

/// Greatest distance between goals that agree: what typed digits leave, in SI units.
pub(super) const DIGITS: f64 = 1e-5;
/// The same of sets of one quantity, which need not be rounded.
const ROUNDING: f64 = 1e-9;
/// Greatest distance of a contact's place from the face that it is on \[m\].
const OFF_M: f64 = 1e-3;

impl Scene {
    /// The first goal that cannot hold, with the reason.
    pub fn goal_fault(&self) -> Option<(usize, String)> {
        let goals = self.goals.iter().enumerate();
        goals.clone().find_map(|(index, goal)| {
            let name = &self.events[goal.event].name;
            let is_given = |event: usize| !self.time_is_free(event);
            let is_time = matches!(
                &goal.target,
                GoalTarget::Condition(condition) if matches!(condition.quantity, GoalQuantity::Time { .. })
            );
            if is_time && goal.events().all(is_given) {
                let message = format!(
                    "the time of {name:?} is that of its mark, expected time = \"free\" in its [[event]]"
                );
                return Some((index, message));
            }
            let misplaced = self.off_its_face(goal).or_else(|| self.out_of_reach(goal));
            if let Some(message) = misplaced {
                return Some((index, message));
            }
            let mut before = goals.clone().take(index);
            let message = before.find_map(|(_, other)| contradiction(other, goal))?;
            let body = &self.links[goal.link].name;
            let message = format!("an earlier goal for {body:?} at {name:?} contradicts this: {message}");
            Some((index, message))
        })
    }

    /// What is wrong with a hard goal for the place of a contact that is on a face.
    fn off_its_face(&self, goal: &Goal) -> Option<String> {
        let GoalTarget::Condition(condition) = &goal.target else {
            return None;
        };
        let (point_m, normal) = self.face_touched(goal, condition)?;
        let height_m = normal.dot(&point_m);
        let side = |normal: Vector3<f64>, least: f64| GoalSet::HalfSpace { normal, least };
        let sides = [
            side(normal, height_m - OFF_M),
            side(-normal, -height_m - OFF_M),
        ];
        let off_m = sides.map(|side| condition.set.gap(&side));
        let off_m = off_m[0].max(off_m[1]);
        (off_m > 0.0 && condition.sd.is_none()).then(|| {
            format!(
                "the contact is on a face {:.3} mm from there, expected a place on it",
                1e3 * (off_m + OFF_M)
            )
        })
    }
}

/// Why two goals cannot both hold.
fn contradiction(first: &Goal, second: &Goal) -> Option<String> {
    let is_time = |condition: &Condition| matches!(condition.quantity, GoalQuantity::Time { .. });
    let same_link = first.link == second.link;
    if first.event != second.event {
        return None;
    }
    let (firsts, seconds) = (first.target.conditions(), second.target.conditions());
    if same_link {
        let off = off_pose(&first.target, &seconds).or_else(|| off_pose(&second.target, &firsts));
        if off.is_some() {
            return off;
        }
    }
    // A pose leaves nothing to do for what agrees with it.
    let is_pose = |goal: &Goal| matches!(goal.target, GoalTarget::Pose { .. });
    let may_repeat = is_pose(first) || is_pose(second);
    for a in firsts.iter().filter(|a| a.sd.is_none()) {
        for b in seconds.iter().filter(|b| b.sd.is_none()) {
            let are_times = is_time(a) && is_time(b);
            if !(same_link || are_times) {
                continue;
            }
            if let Some(message) = apart(a, b, may_repeat) {
                return Some(message);
            }
        }
    }
    None
}

/// Why two hard conditions cannot both hold; unless they may, equalities must not fix the same twice.
fn apart(a: &Condition, b: &Condition, may_repeat: bool) -> Option<String> {
    use GoalQuantity::{Direction, Position, Turn};
    if a.moment != b.moment && !a.quantity.is_of_pose() {
        return None;
    }
    if a.quantity.seen_from() != b.quantity.seen_from() {
        return None;
    }
    let radius = |of: &Condition| match of.set {
        GoalSet::Ball { radius, .. } => radius,
        _ => 0.0,
    };
    let unit = a.quantity.unit().as_str();
    let gap = match (&a.quantity, &b.quantity) {
        (Turn { from, .. }, Turn { from: other, .. }) => {
            from.angle_to(other) - radius(a) - radius(b)
        }
        (
            Direction { axis, towards, .. },
            Direction {
                axis: other,
                towards: there,
                ..
            },
        ) => {
            // The angle between the directions is at most that between the axes, and both rooms.
            (axis.angle(other) - towards.angle(there)).abs() - radius(a) - radius(b)
        }
        (Turn { from, .. }, Direction { axis, towards, .. })
        | (Direction { axis, towards, .. }, Turn { from, .. }) => {
            (from * axis).angle(towards) - radius(a) - radius(b)
        }
        (x, y) if x == y => a.set.gap(&b.set),
        _ => f64::NEG_INFINITY,
    };
    let is_digits = matches!(
        (&a.quantity, &b.quantity),
        (Turn { .. }, Direction { .. }) | (Direction { .. }, Turn { .. })
    );
    if gap > if is_digits { DIGITS } else { ROUNDING } {
        return Some(format!("their sets are {gap:.6} {unit} apart"));
    }
    let are_equalities =
        !may_repeat && a.is_equality() && b.is_equality() && a.quantity != b.quantity;
    match (&a.quantity, &b.quantity) {
        (Position { .. }, Position { .. }) if are_equalities => Some(
            "two exact points fix their distance twice, expected one with within_mm or sd_mm".into(),
        ),
        (Direction { .. }, Direction { .. }) if are_equalities => Some(
            "two exact axes fix their angle twice, expected orientation_wxyz, or one with within_deg"
                .into(),
        ),
        _ => None,
    }
}

/// Which of some conditions does not hold in a pose.
fn off_pose(pose: &GoalTarget, conditions: &[Condition]) -> Option<String> {
    let GoalTarget::Pose { world_from_body } = pose else {
        return None;
    };
    let state = State {
        position_m: world_from_body.translation.vector,
        orientation: world_from_body.rotation,
        velocity_m_s: Vector3::zeros(),
        angular_velocity_rad_s: Vector3::zeros(),
    };
    conditions.iter().find_map(|condition| {
        let quantity = &condition.quantity;
        let point_m = match quantity.point() {
            Some(BodyPoint::Fixed(point_m)) => point_m,
            Some(BodyPoint::Contact(_)) => return None,
            _ => Vector3::zeros(),
        };
        let is_told =
            quantity.is_of_pose() && quantity.seen_from().is_none() && condition.sd.is_none();
        let off = condition
            .set
            .distance(&quantity.value(&state, None, &point_m));
        (is_told && off > DIGITS).then(|| {
            let unit = quantity.unit().as_str();
            format!("in the pose that one of them gives, the other is {off:.6} {unit} off")
        })
    })
}
