//! What is asked of the motion of trees: samples, goals, and where its unknown states are.

use std::ops::Range;
use std::sync::Arc;

use nalgebra::Vector3;

use super::clearance::TreeClearance;
use super::event::{self, TreeEvent};
use super::goal::{self, TouchedContact, TreeGoal};
use super::hands;
use super::law::freed;
use super::sample::{self, TreeSample};
use super::tempo::Tempo;
use crate::estimate::constraint::touched::TouchedPoint;
use crate::estimate::problem::unit;
use crate::estimate::wander::likelihood::LikelyErrors;
use crate::motion::held::HeldEstimate;
use crate::motion::{Cone, FreeParameter, GoalUnit, Scene, Sketch};
use crate::physics::State;
use crate::physics::tree::Forest;

/// Standard deviation of the rates of joints and of a free base's spin at the start [rad/s]: of two
/// motions that are as near to the sketch the one that whirls less is kept.
pub const RATE_SD_RAD_S: f64 = 10.0;

/// How many times as long steps are where they need not be exact.
const COARSER: f64 = 1.5;

/// The motion of all that moves of a scene, to be estimated.
#[derive(Clone, Debug)]
pub struct TreeProblem {
    /// The equations of motion: a tree for each mechanism that is not held.
    pub forest: Forest,
    /// Motions of bodies in the hand: given, not unknown.
    pub hands: Vec<HeldEstimate>,
    /// Gravity [m/s², world].
    pub gravity_m_s2: Vector3<f64>,
    /// Beginning and end of the motion \[s, acted\]: all times here are stamps, which are physical times but where the
    /// tempo is unknown.
    pub span_s: [f64; 2],
    /// Of stamps that are no physical times.
    pub tempo: Option<Tempo>,
    /// What of the scene is unknown, and cones about tilts.
    pub parameters: Vec<FreeParameter>,
    /// See `parameters`.
    pub cones: Vec<Cone>,
    /// The scene, where more of it is unknown than laws of impacts: this problem has what it says; that of other values is
    /// told by the parameters of a point.
    pub freed: Option<Arc<Scene>>,
    /// How samples err in time, of places and of turns, in their units; `None` where each errs by itself.
    pub errors: Option<LikelyErrors>,
    /// In order of time.
    pub samples: Vec<TreeSample>,
    /// In order of time.
    pub goals: Vec<TreeGoal>,
    /// Those within the motion, in order of time.
    pub events: Vec<TreeEvent>,
    /// Solids that must stay out of each other.
    pub clearances: Vec<TreeClearance>,
    /// Where states are unknown \[s\]: at the beginning, and where errors would grow too much.
    pub nodes_s: Vec<f64>,
    /// Step of the integrator \[s\].
    pub step_s: f64,
    /// Least and greatest information of residuals, as
    /// [`Program::information`](crate::optimise::Program::information) says.
    pub information: (f64, f64),
}

impl TreeProblem {
    /// The problem of a scene, with one node.
    pub fn new(scene: &Scene, sketch: &Sketch) -> Self {
        let span_s = sketch.whole_span_s(scene);
        let hands = hands::hands(scene, sketch, span_s);
        let samples = sample::samples(scene, sketch, span_s);
        let goals = goal::goals(scene, sketch, span_s);
        let events = event::events(scene, sketch);
        let weighs = samples.iter().map(|sample| match sample.quantity.unit() {
            GoalUnit::Metre => (unit::POSITION_M / sample.sd()).powi(2),
            _ => (unit::ORIENTATION_RAD / sample.sd()).powi(2),
        });
        let least = weighs.clone().fold(f64::INFINITY, f64::min);
        let most = weighs.fold(0.0, f64::max);
        Self {
            forest: scene.forest_with(&hands),
            hands,
            gravity_m_s2: scene.gravity_m_s2,
            span_s,
            tempo: Tempo::of_scene(scene, span_s, &samples),
            parameters: scene.parameters.clone(),
            cones: scene.cones.clone(),
            freed: freed(scene),
            errors: None,
            samples,
            goals,
            events,
            clearances: Vec::new(),
            nodes_s: vec![span_s[0]],
            step_s: f64::INFINITY,
            information: (least, most),
        }
    }

    /// The same problem read coarsely, for what need not be exact: of the samples those that are this far
    /// apart, with the weight of all, and steps of a cheaper integrator that may be as long.
    pub fn coarse(&self, apart_s: f64) -> Self {
        let mut last_s = f64::NEG_INFINITY;
        let mut kept = self.samples.clone();
        kept.retain(|sample| {
            let is_next = sample.acted_s >= last_s + apart_s;
            if is_next {
                last_s = sample.acted_s;
            }
            sample.acted_s == last_s
        });
        let share = kept.len() as f64 / self.samples.len() as f64;
        let mut errors = self.errors;
        match &mut errors {
            // A wander is the same however often it is seen.
            Some(LikelyErrors { processes, .. }) => {
                processes
                    .iter_mut()
                    .for_each(|of| of.noise_sd *= share.sqrt());
            }
            None => kept
                .iter_mut()
                .for_each(|sample| sample.widened(share.sqrt())),
        }
        Self {
            errors,
            samples: kept,
            step_s: COARSER * self.step_s,
            ..self.clone()
        }
    }

    /// Number of all unknowns: the nodes' tangents, then the events' times, then the log-paces, then parameters.
    pub fn unknown_count(&self) -> usize {
        self.unknown_of_parameter(self.parameters.len())
    }

    /// The place of a parameter among all unknowns.
    pub(super) fn unknown_of_parameter(&self, parameter: usize) -> usize {
        self.unknown_of_pace(self.pace_count() + parameter)
    }

    /// Number of paces of an unknown tempo.
    pub(super) fn pace_count(&self) -> usize {
        self.tempo.as_ref().map_or(0, Tempo::pieces)
    }

    /// The place of the time of an event among all unknowns.
    pub(super) fn unknown_of_event(&self, event: usize) -> usize {
        self.width() * self.nodes_s.len() + event
    }

    /// The place of a log-pace among all unknowns.
    pub(super) fn unknown_of_pace(&self, piece: usize) -> usize {
        self.unknown_of_event(self.events.len() + piece)
    }

    /// Number of unknowns of the motion from a node to the next: the node's tangent, times of events, log-paces,
    /// parameters.
    pub(super) fn interval_size(&self, node: usize) -> usize {
        self.width() + self.events_of(node).len() + self.pace_count() + self.parameters.len()
    }

    /// The first unknown with which one is coupled, of those before it.
    pub(super) fn first_coupled(&self, unknown: usize) -> usize {
        if self.errors.is_some() {
            // Errors go on from interval to interval.
            return 0;
        }
        let width = self.width();
        let node = match unknown.checked_sub(width * self.nodes_s.len()) {
            None => (unknown / width).saturating_sub(1),
            // Tempo and parameters are everywhere's.
            Some(event) if event >= self.events.len() => 0,
            Some(event) => self.node_of(self.events[event].about_s),
        };
        node * width
    }

    /// The events on the way from a node to the next.
    pub fn events_of(&self, node: usize) -> Range<usize> {
        let before = |node: usize| {
            self.events
                .partition_point(|event| self.node_of(event.about_s) < node)
        };
        before(node)..before(node + 1)
    }

    /// The block of rows that join the motion from a node to the next: blocks of goals come before.
    pub(super) fn join_block(&self, node: usize) -> usize {
        self.goals.len() + node
    }

    /// The block of rows of an event within the motion: those of joins come before.
    pub(super) fn event_block(&self, event: usize) -> usize {
        self.join_block(self.nodes_s.len() - 1) + event
    }

    /// The block of the row of a clearance: those of events come before.
    pub(super) fn clearance_block(&self, clearance: usize) -> usize {
        self.event_block(self.events.len()) + clearance
    }

    /// The block of the first bound: those of clearances come before.
    pub(super) fn bound_block(&self) -> usize {
        self.clearance_block(self.clearances.len())
    }

    /// The event within the motion at which a goal holds; none at the start and at the end.
    pub(super) fn event_within(&self, goal: &TreeGoal) -> Option<usize> {
        self.events.iter().position(|of| of.event == goal.event)
    }

    /// Where the contact is that a goal is about, at states of both its links; `None` where it is degenerate.
    pub(super) fn touched_point(
        &self,
        goal: &TreeGoal,
        touched: &TouchedContact,
        both: &[State; 2],
    ) -> Option<TouchedPoint> {
        let event = &self.events[self.event_within(goal)?];
        let contact = event.touch.as_ref()?.at.contacts.as_slice();
        let sides = 1 + usize::from(touched.other.is_some());
        TouchedPoint::new(contact.get(touched.contact)?, touched.side, &both[..sides])
    }

    /// About when a goal holds \[s, acted\].
    pub(super) fn about_s(&self, goal: &TreeGoal) -> f64 {
        self.event_within(goal)
            .map_or(goal.acted_s, |event| self.events[event].about_s)
    }

    /// The node from which the motion reaches a time.
    pub fn node_of(&self, time_s: f64) -> usize {
        let after = self.nodes_s.partition_point(|node_s| *node_s <= time_s);
        after.max(1) - 1
    }

    /// Beginning and end of the motion from a node to the next \[s\].
    pub fn interval_s(&self, node: usize) -> [f64; 2] {
        let to_s = self.nodes_s.get(node + 1).copied();
        [self.nodes_s[node], to_s.unwrap_or(self.span_s[1])]
    }

    /// One unit of a number of a tangent.
    pub fn unit_of(&self, at: usize) -> f64 {
        let freedoms = self.forest.freedoms();
        match (at / freedoms, self.forest.is_translation(at % freedoms)) {
            (0, true) => unit::POSITION_M,
            (0, false) => unit::ORIENTATION_RAD,
            (_, true) => unit::VELOCITY_M_S,
            (_, false) => unit::ANGULAR_VELOCITY_RAD_S,
        }
    }

    /// The place among all unknowns of one of an interval's: the node's tangent, then times of its events, then log-paces and
    /// parameters.
    pub(super) fn unknown_of(&self, node: usize, at: usize) -> usize {
        let events = self.events_of(node);
        match at.checked_sub(self.width()) {
            None => node * self.width() + at,
            Some(event) if event < events.len() => self.unknown_of_event(events.start + event),
            Some(pace) => self.unknown_of_pace(pace - events.len()),
        }
    }

    /// Number of unknowns of a node.
    pub fn width(&self) -> usize {
        2 * self.forest.freedoms()
    }
}
