//! Where goals' quantities are at given states, and how far from their sets an estimate leaves them.

use nalgebra::Vector3;

use super::axes::Axes;
use super::condition::{BodyPoint, Condition, GoalQuantity, GoalUnit, Moment};
use super::event::Partner;
use super::goal::{Goal, GoalTarget};
use super::goal_set::GoalSet;
use super::whole::Scene;
use crate::math::{Pose, so3};
use crate::motion::estimate::{ArcEstimate, Estimate};
use crate::motion::index::LinkIndex;
use crate::physics::State;
use crate::physics::contact::{Contact, Feature, Frame};
use crate::physics::tree::Snapshot;

/// How far an estimate is from one of the scene's goals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GoalEstimate {
    /// Index into `Scene::goals`.
    pub goal: usize,
    /// Signed distance from its set, in its unit ([`GoalSet::distance`]); of a pose the larger of \[m\]
    /// and \[rad\].
    pub distance: f64,
    /// Unit of the distance.
    pub unit: GoalUnit,
}

impl GoalEstimate {
    /// Whether it is met.
    pub fn is_met(&self) -> bool {
        self.distance <= self.unit.rounding()
    }

    /// Whether it is at its bound or beyond, so that it may act on the motion.
    pub fn binds(&self) -> bool {
        self.distance >= -self.unit.rounding()
    }
}

impl GoalTarget {
    /// The target as conditions: a pose as a position and a turn.
    pub fn conditions(&self) -> Vec<Condition> {
        let hard = |quantity, set| Condition {
            quantity,
            set,
            moment: Moment::Before,
            sd: None,
        };
        let centre = GoalQuantity::Position {
            point: BodyPoint::Centre,
            seen_from: None,
        };
        match self {
            Self::Pose { world_from_body } => vec![
                hard(centre, GoalSet::point(world_from_body.translation.vector)),
                hard(
                    GoalQuantity::Turn {
                        from: world_from_body.rotation,
                        seen_from: None,
                    },
                    GoalSet::about_zero(None),
                ),
            ],
            Self::PositionWithin { lower_m, upper_m } => vec![hard(
                centre,
                GoalSet::Box {
                    lower: *lower_m,
                    upper: *upper_m,
                },
            )],
            Self::Condition(condition) => vec![condition.clone()],
        }
    }
}

impl GoalQuantity {
    /// Its value at the state of the body and of the one in whose axes it is seen; `point_m` is the
    /// point it is about [m, body axes]. Zero of a time.
    pub fn value(
        &self,
        body: &State,
        other: Option<&State>,
        point_m: &Vector3<f64>,
    ) -> Vector3<f64> {
        let frame = other.map_or_else(Pose::identity, State::world_from_body);
        match self {
            Self::Position { .. } => {
                let place = body.position_m + body.orientation * point_m;
                frame.inverse_transform_point(&place.into()).coords
            }
            Self::Turn { from, .. } => {
                so3::log(&(from.inverse() * frame.rotation.inverse() * body.orientation))
            }
            Self::Direction { axis, towards, .. } => {
                let seen = frame.rotation.inverse() * (body.orientation * axis);
                let tangents = Feature::tangents(towards);
                let along = Vector3::new(seen.dot(&tangents[0]), seen.dot(&tangents[1]), 0.0);
                let angle = along.norm().atan2(towards.dot(&seen));
                // Opposite directions are half a turn apart, any way round.
                along.try_normalize(0.0).unwrap_or_else(Vector3::x) * angle
            }
            Self::Velocity { .. } => {
                let arm = body.angular_velocity_rad_s.cross(point_m);
                body.velocity_m_s + body.orientation * arm
            }
            Self::Spin { axes: Axes::World } => body.orientation * body.angular_velocity_rad_s,
            Self::Spin { axes: Axes::Body } => body.angular_velocity_rad_s,
            Self::Angles { .. } | Self::Time { .. } => Vector3::zeros(),
        }
    }
}

impl Scene {
    /// The point that a quantity is about [m, body axes], given the states of both bodies that collide
    /// at the event; `None` where what touches is open or degenerate.
    pub fn point_of(
        &self,
        goal: &Goal,
        quantity: &GoalQuantity,
        state_of: &dyn Fn(LinkIndex) -> Option<State>,
    ) -> Option<Vector3<f64>> {
        match quantity.point() {
            None | Some(BodyPoint::Centre) => Some(Vector3::zeros()),
            Some(BodyPoint::Fixed(point_m)) => Some(point_m),
            Some(BodyPoint::Contact(index)) => {
                let collision = self.events[goal.event].kind.collision()?;
                let set = self.contact_set(goal.event).ok()??;
                let contact: &Contact = set.as_slice().get(index)?;
                let frame = |link| Some(Frame::of(&state_of(link)?));
                let other = match collision.partner {
                    Partner::World => Frame::world(),
                    Partner::Link(other) => frame(other)?,
                };
                let touch = contact.touch(&frame(collision.link)?, &other).ok()?;
                Some(if collision.link == goal.link {
                    touch.on_a_m
                } else {
                    touch.on_b_m
                })
            }
        }
    }

    /// The face on which a contact lies whose place is asked, a point of it and its normal in the axes in
    /// which that is seen; `None` where it lies on none, is seen from elsewhere or is open.
    pub fn face_touched(
        &self,
        goal: &Goal,
        condition: &Condition,
    ) -> Option<(Vector3<f64>, Vector3<f64>)> {
        let Some(BodyPoint::Contact(index)) = condition.quantity.point() else {
            return None;
        };
        let collision = self.events[goal.event].kind.collision()?;
        let set = self.contact_set(goal.event).ok()??;
        let contact = set.as_slice().get(index)?;
        let (other, feature) = match collision.partner {
            Partner::World => (None, contact.b()),
            Partner::Link(other) if collision.link == goal.link => (Some(other), contact.b()),
            Partner::Link(_) => (Some(collision.link), contact.a()),
        };
        match feature {
            Feature::Face { point_m, normal } if condition.quantity.seen_from() == other => {
                Some((*point_m, *normal))
            }
            _ => None,
        }
    }

    /// How far an estimate of this scene, whose quantities are in their places
    /// ([`Scene::as_estimated`]), is from each goal; goals that no flight meets are left out.
    pub fn goals_attained(&self, estimate: &Estimate) -> Vec<GoalEstimate> {
        let goals = self.goals.iter().enumerate();
        goals
            .filter_map(|(index, goal)| {
                let conditions = goal.target.conditions();
                let each = conditions.iter().map(|condition| {
                    let distance = self.distance(estimate, goal, condition)?;
                    Some((distance, condition.quantity.unit()))
                });
                let each: Vec<(f64, GoalUnit)> = each.collect::<Option<_>>()?;
                let farthest = each.into_iter().max_by(|a, b| a.0.total_cmp(&b.0))?;
                Some(GoalEstimate {
                    goal: index,
                    distance: farthest.0,
                    unit: farthest.1,
                })
            })
            .collect()
    }

    fn distance(&self, estimate: &Estimate, goal: &Goal, condition: &Condition) -> Option<f64> {
        let time_of = |event: usize| {
            let mut events = estimate.events.iter();
            Some(events.find(|of| of.event == event)?.time_s)
        };
        let left_of = |event: usize| {
            let mut events = estimate.events.iter();
            Some(events.find(|of| of.event == event)?.left_s())
        };
        let time_s = time_of(goal.event)?;
        if matches!(condition.quantity, GoalQuantity::Angles { .. }) {
            let mechanism = self.mechanism_of(goal.link);
            let joined = self.joint_tree(mechanism)?;
            let tree = self.tree_model_with(joined, &estimate.held);
            let motion = estimate.tree_motion(mechanism)?;
            let state = motion.state(&tree, &estimate.gravity_m_s2, time_s);
            let [_, angles] = tree.angles_of(joined.place_of(goal.link)?)?;
            let angles = &state.coordinates[angles];
            let value = Vector3::from_fn(|axis, _| angles.get(axis).copied().unwrap_or(0.0));
            return Some(condition.set.distance(&value));
        }
        let state_of = |link: LinkIndex| {
            let mechanism = self.mechanism_of(link);
            if let Some(joined) = self.joint_tree(mechanism) {
                let tree = self.tree_model_with(joined, &estimate.held);
                let state =
                    estimate
                        .tree_motion(mechanism)?
                        .state(&tree, &estimate.gravity_m_s2, time_s);
                let mut snapshot = Snapshot::new(&tree, &estimate.gravity_m_s2);
                snapshot.set(&state);
                return Some(snapshot.link_state(joined.place_of(link)?));
            }
            let arcs = estimate
                .arcs
                .iter()
                .filter(|arc| arc.mechanism == mechanism);
            let ends = |arc: &&ArcEstimate| arc.end_s == time_s;
            let begins = |arc: &&ArcEstimate| arc.start_s == time_s;
            let spans = |arc: &&ArcEstimate| arc.start_s <= time_s && time_s <= arc.end_s;
            // A waypoint is on the flight that its place among the events says, also at an end of it.
            let through = || {
                let before = (0..goal.event)
                    .rev()
                    .find(|other| self.concerns(*other, mechanism));
                let mut arcs = arcs.clone();
                match before {
                    Some(event) => {
                        let start_s = left_of(event)?;
                        arcs.find(|arc| arc.start_s == start_s)
                    }
                    None => arcs.next(),
                }
            };
            let is_waypoint = self.events[goal.event].kind.waypoint().is_some();
            let at_its_side = match condition.moment {
                _ if is_waypoint => through(),
                Moment::Before => arcs.clone().find(ends),
                Moment::After => arcs.clone().find(begins),
            };
            let arc = at_its_side.or_else(|| arcs.clone().find(spans))?;
            Some(self.flown(arc, &estimate.gravity_m_s2, time_s))
        };
        self.condition_distance(goal, condition, &time_of, &state_of)
    }

    /// How far a condition of a goal is from its set ([`GoalSet::distance`]), given the times of events
    /// and the states of links at the goal's event; `None` where these are not known, or what touches is
    /// open or degenerate.
    pub fn condition_distance(
        &self,
        goal: &Goal,
        condition: &Condition,
        time_of: &dyn Fn(usize) -> Option<f64>,
        state_of: &dyn Fn(LinkIndex) -> Option<State>,
    ) -> Option<f64> {
        let quantity = &condition.quantity;
        let value = if let GoalQuantity::Time { since } = quantity {
            let since_s = since.map_or(Some(0.0), time_of)?;
            Vector3::new(time_of(goal.event)? - since_s, 0.0, 0.0)
        } else {
            let point_m = self.point_of(goal, quantity, state_of)?;
            let other = match quantity.seen_from() {
                Some(other) => Some(state_of(other)?),
                None => None,
            };
            quantity.value(&state_of(goal.link)?, other.as_ref(), &point_m)
        };
        Some(condition.set.distance(&value))
    }
}
