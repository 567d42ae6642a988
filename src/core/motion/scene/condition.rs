//! Conditions on a motion at an event: a *quantity* of its state must be in a *set*, exactly or as
//! nearly as a weight asks.
//!
//! Every quantity is a vector of one to three numbers of one unit, so that every set serves every
//! quantity:
//!
//! | quantity | numbers | unit |
//! |---|---|---|
//! | position of a point, in the world or in another body's axes | 3 | m |
//! | orientation: `Log(R₀ᵀ R)`, the turn from a given one | 3 | rad |
//! | direction of a body axis: the angle from a given direction, along two tangents of it | 2 | rad |
//! | velocity of a point | 3 | m/s |
//! | angular velocity, in world or body axes | 3 | rad/s |
//! | time since another event or since the first sample | 1 | s |
//!
//! A turn of zero is a given orientation, turns within a ball are those within an angle, directions
//! within a ball are those within a cone.

use nalgebra::{UnitQuaternion, Vector3};

use super::axes::Axes;
use super::goal_set::GoalSet;
use crate::motion::index::LinkIndex;

/// A quantity at an event that must be in a set.
#[derive(Clone, Debug, PartialEq)]
pub struct Condition {
    /// What must be in the set.
    pub quantity: GoalQuantity,
    /// Where it must be.
    pub set: GoalSet,
    /// At which side of a collision.
    pub moment: Moment,
    /// Standard deviation of the distance from the set, in the quantity's unit: half the squared
    /// distance in it is part of the objective. `None`: the condition is hard.
    pub sd: Option<f64>,
}

/// A side of an event; they differ in velocities at a collision.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Moment {
    /// Just before it; of a start, just after it.
    #[default]
    Before,
    /// Just after it.
    After,
}

/// What a condition is about.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GoalQuantity {
    /// Where a point of the body is \[m\].
    Position {
        /// The point.
        point: BodyPoint,
        /// The body in whose axes it is seen; `None`: the world's.
        seen_from: Option<LinkIndex>,
    },
    /// How the body is turned from an orientation: `Log(R₀ᵀ R)` [rad, body axes].
    Turn {
        /// That orientation `R₀`, from body axes to those in which it is seen.
        from: UnitQuaternion<f64>,
        /// The body in whose axes it is seen; `None`: the world's.
        seen_from: Option<LinkIndex>,
    },
    /// How far an axis of the body points from a direction: the angle \[rad\] along two tangents of it
    /// ([`Feature::tangents`](crate::physics::contact::Feature::tangents)), the shortest way.
    Direction {
        /// Unit axis in body axes.
        axis: Vector3<f64>,
        /// Unit direction.
        towards: Vector3<f64>,
        /// The body in whose axes it is seen; `None`: the world's.
        seen_from: Option<LinkIndex>,
    },
    /// Velocity of a point of the body [m/s, world].
    Velocity {
        /// The point.
        point: BodyPoint,
    },
    /// Angular velocity [rad/s].
    Spin {
        /// In which axes.
        axes: Axes,
    },
    /// Angles of the joint from which the body hangs, a pin's or a universal joint's \[rad\].
    Angles {
        /// How many it has.
        count: usize,
    },
    /// Time of the event \[s\].
    Time {
        /// The event since which it is counted (index into `Scene::events`); `None`: the first
        /// sample.
        since: Option<usize>,
    },
}

/// A point of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BodyPoint {
    /// The centre of mass.
    Centre,
    /// One that is fixed in it [m, body axes].
    Fixed(Vector3<f64>),
    /// Where it touches what it collides with at the event: this one of the collision's contacts.
    Contact(usize),
}

/// The kinds of quantity by their units.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GoalUnit {
    /// \[m\].
    Metre,
    /// \[rad\].
    Radian,
    /// [m/s].
    MetrePerSecond,
    /// [rad/s].
    RadianPerSecond,
    /// \[s\].
    Second,
}

impl GoalUnit {
    /// Its symbol in files and reports.
    pub fn as_str(self) -> &'static str {
        match self {
            GoalUnit::Metre => "m",
            GoalUnit::Radian => "rad",
            GoalUnit::MetrePerSecond => "m/s",
            GoalUnit::RadianPerSecond => "rad/s",
            GoalUnit::Second => "s",
        }
    }

    /// Greatest distance from a set that is rounding, in this unit: that of gaps of a physical motion.
    pub fn rounding(self) -> f64 {
        match self {
            GoalUnit::Metre | GoalUnit::Radian | GoalUnit::Second => 1e-9,
            GoalUnit::MetrePerSecond => 1e-8,
            GoalUnit::RadianPerSecond => 1e-7,
        }
    }
}

impl GoalQuantity {
    /// Its unit.
    pub fn unit(&self) -> GoalUnit {
        match self {
            GoalQuantity::Position { .. } => GoalUnit::Metre,
            GoalQuantity::Turn { .. }
            | GoalQuantity::Direction { .. }
            | GoalQuantity::Angles { .. } => GoalUnit::Radian,
            GoalQuantity::Velocity { .. } => GoalUnit::MetrePerSecond,
            GoalQuantity::Spin { .. } => GoalUnit::RadianPerSecond,
            GoalQuantity::Time { .. } => GoalUnit::Second,
        }
    }

    /// How many numbers it has; further components of its vector are zero.
    pub fn dimension(&self) -> usize {
        match self {
            GoalQuantity::Direction { .. } => 2,
            GoalQuantity::Angles { count } => *count,
            GoalQuantity::Time { .. } => 1,
            _ => 3,
        }
    }

    /// Whether it is of poses alone, which are the same at both sides of a collision.
    pub fn is_of_pose(&self) -> bool {
        matches!(self.unit(), GoalUnit::Metre | GoalUnit::Radian)
    }

    /// Whether it is a time, which is about no body.
    pub fn is_time(&self) -> bool {
        matches!(self, GoalQuantity::Time { .. })
    }

    /// The body in whose axes it is seen, unless that is the world.
    pub fn seen_from(&self) -> Option<LinkIndex> {
        match self {
            GoalQuantity::Position { seen_from, .. }
            | GoalQuantity::Turn { seen_from, .. }
            | GoalQuantity::Direction { seen_from, .. } => *seen_from,
            _ => None,
        }
    }

    /// The event since which a time is counted.
    pub fn since(&self) -> Option<usize> {
        match self {
            GoalQuantity::Time { since } => *since,
            _ => None,
        }
    }

    /// The point of the body that it is about, if it is about one.
    pub fn point(&self) -> Option<BodyPoint> {
        match self {
            GoalQuantity::Position { point, .. } | GoalQuantity::Velocity { point } => Some(*point),
            _ => None,
        }
    }
}

impl Condition {
    /// Whether it is hard and leaves none of its numbers any room.
    pub fn is_equality(&self) -> bool {
        self.sd.is_none() && self.set.is_point(self.quantity.dimension())
    }

    /// Whether it is an orientation, exactly.
    pub fn is_turn_equality(&self) -> bool {
        matches!(self.quantity, GoalQuantity::Turn { .. }) && self.is_equality()
    }

    /// The condition after the axes of a body have moved along to a centre of mass elsewhere [m, its old
    /// axes]: it is about the same points of the object.
    pub fn with_centre_moved(
        mut self,
        is_own: bool,
        is_seen_from: bool,
        by_m: &Vector3<f64>,
    ) -> Self {
        if is_own
            && let GoalQuantity::Position { point, .. } | GoalQuantity::Velocity { point } =
                &mut self.quantity
            && let BodyPoint::Fixed(point_m) = point
        {
            *point_m -= by_m;
        }
        if is_seen_from && matches!(self.quantity, GoalQuantity::Position { .. }) {
            self.set = self.set.shifted(&-by_m);
        }
        self
    }

    /// The condition with all lengths multiplied; velocities are given in a unit of their own.
    pub fn with_lengths_scaled(mut self, factor: f64) -> Self {
        if let GoalQuantity::Position { point, .. } | GoalQuantity::Velocity { point } =
            &mut self.quantity
            && let BodyPoint::Fixed(point_m) = point
        {
            *point_m *= factor;
        }
        if self.quantity.unit() == GoalUnit::Metre {
            self.set = self.set.scaled(factor);
            self.sd = self.sd.map(|sd| sd * factor);
        }
        self
    }
}
