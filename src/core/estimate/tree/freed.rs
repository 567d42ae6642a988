//! What of a scene is unknown beyond the laws of impacts: gravity, masses and moments, centres of mass, where trackers and
//! surfaces are.
//!
//! They are let go once the motion with given ones is found.

use std::borrow::Cow;
use std::sync::Arc;

use super::law::is_of_law;
use super::optimum::{Solved, finished};
use super::point::TreePoint;
use super::problem::TreeProblem;
use crate::motion::{GoalQuantity, GoalUnit, Observer, Quantity, Scene};
use crate::optimise::Schedule;

impl TreeProblem {
    /// The problem of what the parameters of a point say, in which no more is freed; `None` where no body is so.
    pub(super) fn at(&self, point: &TreePoint) -> Option<Cow<'_, Self>> {
        self.at_values(&point.parameters)
    }

    fn at_values(&self, parameters: &[f64]) -> Option<Cow<'_, Self>> {
        let Some(scene) = &self.freed else {
            return Some(Cow::Borrowed(self));
        };
        let values = self.moving().map(|at| {
            let quantity = self.parameters[at].quantity;
            // A bound is met but for rounding, beyond which there is no such body.
            let [least, most] = quantity.limits();
            (quantity, parameters[at].clamp(least, most))
        });
        let there = self.with(scene, &values.collect::<Vec<_>>())?;
        Some(Cow::Owned(Self {
            freed: None,
            ..there
        }))
    }

    /// Parameters that are no numbers of laws.
    pub(super) fn moving(&self) -> impl Iterator<Item = usize> + '_ {
        let all = self.parameters.iter().enumerate();
        all.filter_map(|(at, of)| (!is_of_law(of.quantity)).then_some(at))
    }

    /// The problem in which these stay at their first values.
    pub(super) fn given(&self) -> Cow<'_, Self> {
        let first: Vec<f64> = self.parameters.iter().map(|of| of.initial).collect();
        self.at_values(&first).unwrap_or(Cow::Borrowed(self))
    }

    /// [`TreeProblem::at`], the problem as it is given where no body is so.
    pub(super) fn as_told(&self, point: &TreePoint) -> Cow<'_, Self> {
        self.at(point).unwrap_or(Cow::Borrowed(self))
    }

    /// The same problem where quantities of the scene have these values; `None` where no body is so, or no impact: at
    /// several contacts there is no friction.
    pub(super) fn with(&self, scene: &Scene, values: &[(Quantity, f64)]) -> Option<Self> {
        let scene = self.freed.as_deref().unwrap_or(scene);
        // A step that is no number leads to no tree.
        let are_numbers = values.iter().all(|(_, value)| value.is_finite());
        let other = are_numbers.then(|| scene.with_values(values).ok())??;
        let mut with = self.clone();
        with.forest = other.forest_with(&self.hands);
        with.gravity_m_s2 = other.gravity_m_s2;
        for event in &mut with.events {
            if event.touch.is_some() {
                event.touch = Some(other.tree_touch(event.event)?);
            }
        }
        for goal in &mut with.goals {
            goal.set_from(&other);
        }
        for clearance in &mut with.clearances {
            clearance.set_from(&other);
        }
        for sample in &mut with.samples {
            let [before, after] =
                [scene, &other].map(|of| of.tracks[sample.track].link_from_tracker);
            if sample.quantity.unit() == GoalUnit::Metre {
                sample.point_m += after.translation.vector - before.translation.vector;
            }
            if let GoalQuantity::Turn { from, .. } = &mut sample.quantity {
                *from *= before.rotation * after.rotation.inverse();
            }
        }
        with.freed = self.freed.as_ref().map(|_| Arc::new(other));
        Some(with)
    }
}

impl Solved {
    /// Lets quantities go that a problem frees, of a motion with given ones: with these it may be none.
    pub(super) fn let_go(self, problem: &TreeProblem, observer: &mut dyn Observer) -> Self {
        if problem.freed.is_none() || self.solution.stopped {
            return self;
        }
        let mut freed = problem.clone();
        freed.nodes_s.clone_from(&self.problem.nodes_s);
        freed.step_s = self.problem.step_s;
        for (event, found) in freed.events.iter_mut().zip(&self.problem.events) {
            event.about_s = found.about_s;
        }
        let near_by = Schedule::default().from_the_last();
        let mut work = self.solution.work;
        finished(&freed, &self.solution.point, &near_by, &mut work, observer)
    }
}
