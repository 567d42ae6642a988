//! Groups of mechanisms whose motions say nothing of each other's: each is estimated by itself, so that it costs what it
//! costs alone, and comes out as it does alone.
//!
//! Two mechanisms are tied where they hit each other or begin to stick together, a goal is about both, one event has goals of both, or a free quantity
//! acts on both; all are where the tempo is unknown, since they share it. What is held moves as it was tracked and ties
//! nothing, but where joined bodies hang from it and something hits it. Bodies by themselves that nothing ties to joined
//! ones are one group together.

use super::event::EventKind;
use super::goal::{Goal, GoalTarget};
use super::link::Mechanism;
use super::quantity::Quantity;
use super::whole::{Scene, Timing};
use crate::motion::index::{ContactLawIndex, LinkIndex, MechanismIndex};

/// Mechanisms that are estimated together.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Group {
    /// In order; none is held.
    pub mechanisms: Vec<MechanismIndex>,
}

impl Group {
    /// Whether a mechanism is of it.
    pub fn has(&self, mechanism: MechanismIndex) -> bool {
        self.mechanisms.contains(&mechanism)
    }
}

impl Scene {
    /// All that [moves](Scene::moving), group by group: bodies by themselves first, then trees in their order.
    pub fn groups(&self) -> Vec<Group> {
        let moving: Vec<MechanismIndex> = self.moving().map(|(index, _)| index).collect();
        let is_tree = |of: &MechanismIndex| self.joint_tree(*of).is_some();
        if !moving.iter().any(is_tree) {
            return vec![Group { mechanisms: moving }];
        }
        let mut groups: Vec<Vec<MechanismIndex>> = moving.iter().map(|of| vec![*of]).collect();
        let mut tie = |tied: &[MechanismIndex]| {
            let is_tied = |group: &Vec<MechanismIndex>| group.iter().any(|of| tied.contains(of));
            let (one, others) = groups.drain(..).partition(is_tied);
            let one: Vec<Vec<MechanismIndex>> = one;
            groups = others;
            groups.push(one.concat());
        };
        for tied in self.ties(&moving).filter(|tied| tied.len() > 1) {
            tie(&tied);
        }
        let (trees, bodies): (Vec<_>, Vec<_>) = groups
            .into_iter()
            .partition(|group| group.iter().any(is_tree));
        let mut groups = trees;
        if !bodies.is_empty() {
            groups.push(bodies.concat());
        }
        groups.iter_mut().for_each(|group| group.sort());
        groups.sort_by_key(|group| (group.iter().any(is_tree), group[0]));
        let groups = groups.into_iter().map(|mechanisms| Group { mechanisms });
        groups.collect()
    }

    /// Mechanisms that something ties to each other, once for each such thing.
    fn ties<'s>(
        &'s self,
        moving: &'s [MechanismIndex],
    ) -> impl Iterator<Item = Vec<MechanismIndex>> + 's {
        let tempo = match self.timing {
            Timing::Known => None,
            Timing::Edited | Timing::Unknown { .. } => Some(moving.to_vec()),
        };
        let events = (0..self.events.len()).map(|event| self.told_by_event(event));
        let goals = self.goals.iter().map(|goal| self.told_by_goal(goal));
        let quantities = self.parameters.iter().map(|of| self.told_by(of.quantity));
        let hands = self.links.keys().filter(|link| self.carries(*link));
        let hands = hands.filter_map(move |hand| {
            let hangs = self
                .joint_trees()
                .filter(|(_, tree)| self.hand_of(tree) == Some(hand));
            let hits = (0..self.events.len()).filter(|of| self.links_at(*of).contains(&hand));
            let hits = hits.flat_map(|event| self.told_by_event(event));
            let hits: Vec<MechanismIndex> = hits.collect();
            (!hits.is_empty()).then(|| hangs.map(|(of, _)| of).chain(hits).collect())
        });
        let all = tempo.into_iter().chain(events).chain(goals);
        all.chain(quantities).chain(hands)
    }

    /// The links that an event is about: none of a start or an end, which are everybody's.
    pub fn links_at(&self, event: usize) -> Vec<LinkIndex> {
        match &self.events[event].kind {
            EventKind::Collision(of) | EventKind::Collisions { each: of, .. } => {
                of.links().collect()
            }
            EventKind::Change(link) => match self.stuck_at(event) {
                Some(pair) => pair.links.to_vec(),
                None => vec![*link],
            },
            EventKind::Waypoint(link) => vec![*link],
            EventKind::Start | EventKind::End => Vec::new(),
        }
    }

    /// The mechanisms that move by themselves, of links.
    fn moving_of(&self, links: impl IntoIterator<Item = LinkIndex>) -> Vec<MechanismIndex> {
        let all = links.into_iter().map(|link| self.mechanism_of(link));
        all.filter(|of| self.moves(*of)).collect()
    }

    /// The mechanisms of which the time of an event tells: what takes part in it and what has goals there; all, of a
    /// start or an end whose time is free.
    fn told_by_event(&self, event: usize) -> Vec<MechanismIndex> {
        if matches!(self.events[event].kind, EventKind::Start | EventKind::End) {
            return match self.time_is_free(event) {
                true => self.moving().map(|(of, _)| of).collect(),
                false => Vec::new(),
            };
        }
        let goals = self.goals.iter().filter(|goal| goal.event == event);
        let goals = goals.flat_map(|goal| self.links_of_goal(goal));
        self.moving_of(self.links_at(event).into_iter().chain(goals))
    }

    /// The links whose states a goal is about: none of a time.
    fn links_of_goal(&self, goal: &Goal) -> Vec<LinkIndex> {
        match &goal.target {
            GoalTarget::Condition(of) if of.quantity.is_time() => Vec::new(),
            GoalTarget::Condition(of) => {
                let other = of.quantity.seen_from();
                [goal.link].into_iter().chain(other).collect()
            }
            GoalTarget::Pose { .. } | GoalTarget::PositionWithin { .. } => vec![goal.link],
        }
    }

    /// The mechanisms that a goal is about.
    fn told_by_goal(&self, goal: &Goal) -> Vec<MechanismIndex> {
        let mut all = self.moving_of(self.links_of_goal(goal));
        if all.is_empty() {
            all.extend(goal.events().flat_map(|event| self.told_by_event(event)));
        }
        all
    }

    /// The mechanisms on which a quantity acts: of an event's those that take part in it.
    pub fn told_by(&self, quantity: Quantity) -> Vec<MechanismIndex> {
        let of_events = |is_its: &dyn Fn(usize) -> bool| {
            let events = (0..self.events.len()).filter(|event| is_its(*event));
            events.flat_map(|event| self.told_by_event(event)).collect()
        };
        let has_law = |event: usize, law: ContactLawIndex| match &self.events[event].kind {
            EventKind::Collision(of) | EventKind::Collisions { each: of, .. } => of.law == law,
            _ => false,
        };
        let may_touch = |event: usize, surface: usize| match &self.events[event].kind {
            EventKind::Collision(of) | EventKind::Collisions { each: of, .. } => {
                let mut others = of.contacts.iter().map(|touching| touching.other);
                others.any(|other| other.is_none_or(|other| other == surface))
            }
            _ => false,
        };
        match quantity {
            Quantity::Gravity { .. } => self.moving().map(|(of, _)| of).collect(),
            Quantity::Restitution { law }
            | Quantity::Friction { law }
            | Quantity::TangentialRestitution { law } => of_events(&|event| has_law(event, law)),
            Quantity::Tilt { event, .. } | Quantity::ContactDuration { event } => {
                self.told_by_event(event)
            }
            Quantity::SurfaceHeight { surface } | Quantity::SurfaceTilt { surface, .. } => {
                of_events(&|event| may_touch(event, surface))
            }
            Quantity::Force { link, .. }
            | Quantity::LinearDrag { link }
            | Quantity::QuadraticDrag { link }
            | Quantity::Lift { link }
            | Quantity::Moment { link, .. }
            | Quantity::Mass { link }
            | Quantity::Centre { link, .. }
            | Quantity::JointPlace { child: link, .. }
            | Quantity::JointTurn { child: link, .. } => self.moving_of([link]),
            Quantity::TrackerPosition { track, .. }
            | Quantity::TrackerOrientation { track, .. }
            | Quantity::ClockRate { track }
            | Quantity::ClockOffset { track }
            | Quantity::FlightClock { track, .. }
            | Quantity::SampleTime { track, .. } => match self.sees_held(track) {
                // The times at which others hit it.
                true => of_events(&|event| self.links_at(event).contains(&self.tracks[track].link)),
                false => self.moving_of([self.tracks[track].link]),
            },
        }
    }

    /// The scene of one of its groups. All indices mean the same: what others do is set apart ([`Mechanism::Apart`]), their
    /// events are moments at which nothing happens, and their goals and free quantities are not in it.
    pub fn only(&self, group: &Group) -> Self {
        let is_its = |told: Vec<MechanismIndex>| told.iter().any(|of| group.has(*of));
        let mut scene = self.clone();
        scene.goals.retain(|goal| is_its(self.told_by_goal(goal)));
        scene
            .rest_goals
            .retain(|goal| is_its(self.moving_of([goal.link])));
        scene.keep_parameters(|quantity| is_its(self.told_by(quantity)));
        for (event, of) in scene.events.iter_mut().enumerate() {
            let moving = self.moving_of(self.links_at(event));
            if let Some(other) = moving
                .first()
                .filter(|_| !is_its(self.told_by_event(event)))
            {
                let link = self.mechanisms[*other].links().next();
                of.kind = EventKind::Waypoint(link.expect("a mechanism has links"));
            }
        }
        for (index, mechanism) in scene.mechanisms.iter_mut_enumerated() {
            if self.moves(index) && !group.has(index) {
                *mechanism = Mechanism::Apart(mechanism.links().collect());
            }
        }
        scene
    }

    /// The group that estimates an event, of the scene's groups: the first one, of what is everybody's.
    pub fn group_of_event(&self, groups: &[Group], event: usize) -> usize {
        let told = self.moving_of(self.links_at(event));
        let own = groups
            .iter()
            .position(|group| told.iter().any(|of| group.has(*of)));
        own.unwrap_or(0)
    }
}
