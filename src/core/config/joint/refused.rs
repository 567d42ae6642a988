//! What scenes with joints cannot ask for.

use std::ops::Range;

use crate::config::error::{Fault, fault};
use crate::config::event::link_of;
use crate::config::raw::{RawEvent, RawGoal, RawScene};
use crate::config::spanned::Spanned;
use crate::motion::{Group, LinkIndex, Quantity, Scene, Timing, TreeTouch};
use crate::physics::impact::ImpactError;
use crate::physics::tree::ForestSnapshot;

/// Refuses a scene with joints that asks for what is not done of joined bodies and of what is estimated together with them.
pub(in crate::config) fn refuse(raw: &RawScene, scene: &Scene) -> Result<(), Fault> {
    if scene.joint_trees().next().is_none() {
        return Ok(());
    }
    if scene.timing == Timing::Edited {
        return fault(
            raw.timing.stamps.span(),
            "joined bodies move from start to end at once, expected stamps = \"physical\" or \"tempo\"",
        );
    }
    let joined = JoinedPart::new(scene);
    if let Some((span, said)) = joined.unused(raw).next() {
        return fault(span, said);
    }
    for hand in scene.links.keys().filter(|link| scene.is_held(*link)) {
        joined.refuse_beside(raw, hand)?;
    }
    joined.refuse_free(raw)
}

/// What of a scene is estimated together with joined bodies.
struct JoinedPart<'a> {
    scene: &'a Scene,
    /// All groups, and which of them have joined bodies.
    groups: Vec<(Group, bool)>,
}

impl<'a> JoinedPart<'a> {
    fn new(scene: &'a Scene) -> Self {
        let is_tree = |of: &Group| {
            of.mechanisms
                .iter()
                .any(|of| scene.joint_tree(*of).is_some())
        };
        let groups = scene.groups().into_iter();
        Self {
            scene,
            groups: groups.map(|of| (of.clone(), is_tree(&of))).collect(),
        }
    }

    fn has_link(&self, link: LinkIndex) -> bool {
        let mechanism = self.scene.mechanism_of(link);
        let own = self.groups.iter().find(|(group, _)| group.has(mechanism));
        own.is_none_or(|(_, is_joined)| *is_joined)
    }

    /// Of a start or an end, which are everybody's, too.
    fn has_event(&self, event: usize) -> bool {
        let mut links = self
            .scene
            .links_at(event)
            .into_iter()
            .filter(|of| !self.scene.is_held(*of));
        links.next().is_none_or(|first| self.has_link(first))
    }

    /// Whether a goal is about joined bodies, or about nobody.
    fn has_goal(&self, raw: &RawGoal) -> bool {
        let link = raw
            .body
            .as_ref()
            .and_then(|body| link_of(body, self.scene).ok());
        let mut events = self.scene.events.iter();
        match (link, events.position(|of| of.name == *raw.event.get_ref())) {
            (Some(link), _) => self.has_link(link),
            (None, Some(event)) => self.has_event(event),
            (None, None) => true,
        }
    }

    /// Refuses what is not done of joined bodies beside a held one: its motion, and theirs with it, is told by stamps.
    fn refuse_beside(&self, raw: &RawScene, hand: LinkIndex) -> Result<(), Fault> {
        let scene = self.scene;
        let name = &scene.links[hand].name;
        if matches!(scene.timing, Timing::Unknown { .. }) {
            let said = format!(
                "{name:?} is held in a scene with joints, where the tempo must be known: expected stamps = \"physical\""
            );
            return fault(raw.timing.stamps.span(), said);
        }
        for (event, index) in raw.event.iter().zip(0..) {
            let is_hit = scene.links_at(index).into_iter().any(|of| of == hand);
            let kind = &event.get_ref().kind;
            if kind.get_ref() == "collision" && is_hit && self.has_event(index) {
                let said = format!(
                    "{name:?} is held in a scene with joints, where nothing hits it: expected no collision of it"
                );
                return fault(kind.span(), said);
            }
        }
        Ok(())
    }

    /// Refuses free clocks of joined bodies.
    fn refuse_free(&self, raw: &RawScene) -> Result<(), Fault> {
        let scene = self.scene;
        let is_undone = |quantity: Quantity| match quantity {
            Quantity::ClockRate { .. }
            | Quantity::ClockOffset { .. }
            | Quantity::FlightClock { .. }
            | Quantity::SampleTime { .. }
            | Quantity::ContactDuration { .. } => {
                let told = scene.told_by(quantity);
                let mut joined = self.groups.iter().filter(|(_, is_joined)| *is_joined);
                joined.any(|(group, _)| told.iter().any(|of| group.has(*of)))
            }
            Quantity::Restitution { .. }
            | Quantity::Friction { .. }
            | Quantity::TangentialRestitution { .. }
            | Quantity::Tilt { .. }
            | Quantity::Force { .. }
            | Quantity::LinearDrag { .. }
            | Quantity::QuadraticDrag { .. }
            | Quantity::Lift { .. }
            | Quantity::Gravity { .. }
            | Quantity::Moment { .. }
            | Quantity::Mass { .. }
            | Quantity::Centre { .. }
            | Quantity::TrackerPosition { .. }
            | Quantity::TrackerOrientation { .. }
            | Quantity::SurfaceHeight { .. }
            | Quantity::SurfaceTilt { .. }
            | Quantity::JointPlace { .. }
            | Quantity::JointTurn { .. } => false,
        };
        let Some(other) = scene.parameters.iter().find(|of| is_undone(of.quantity)) else {
            return Ok(());
        };
        let mut named = raw.free.iter().map(|free| &free.quantity);
        let place = named.find(|name| other.name.starts_with(name.get_ref().as_str()));
        let said = format!(
            "of joined bodies clocks are given, expected another quantity than {:?}",
            other.name
        );
        fault(place.map_or(0..0, Spanned::span), said)
    }

    /// Keys that a motion with joints does not heed, and what is expected instead.
    fn unused<'r>(
        &'r self,
        raw: &'r RawScene,
    ) -> impl Iterator<Item = (Range<usize>, &'static str)> + 'r {
        let is_end = |event: &&RawEvent| ["start", "end"].contains(&event.kind.get_ref().as_str());
        let ends = raw.event.iter().map(Spanned::get_ref).filter(is_end);
        let of_events = ends.flat_map(unused_of_end);
        let goals = raw.goal.iter().map(Spanned::get_ref);
        let of_goals = goals
            .filter(|goal| self.has_goal(goal))
            .flat_map(unused_of_goal);
        let all = of_events.chain(of_goals);
        all.filter_map(|(span, said)| Some((span?, said)))
    }
}

/// A key that is not heeded, where it is there, and what is expected instead.
type Unused = (Option<Range<usize>>, &'static str);

fn span<T>(of: &Option<Spanned<T>>) -> Option<Range<usize>> {
    of.as_ref().map(Spanned::span)
}

fn unused_of_end(event: &RawEvent) -> Vec<Unused> {
    let said = "a motion with joints begins and ends at the marks, expected no other time of a start or an end";
    let times = [&event.time_sd_ms, &event.earliest_ms, &event.latest_ms].map(span);
    let all = times.into_iter().chain([span(&event.time)]);
    all.map(|span| (span, said)).collect()
}

fn unused_of_goal(goal: &RawGoal) -> Vec<Unused> {
    let said = "joined bodies are not led to how they rest, expected no face_up";
    vec![(span(&goal.face_up), said)]
}

/// Refuses collisions of two bodies that a joint ties to each other: whether they overlap beside it is not looked at.
pub(super) fn refuse_neighbours(raw: &RawScene, scene: &Scene) -> Result<(), Fault> {
    for spanned in &raw.event {
        let event = spanned.get_ref();
        let (Some(body), Some(other)) = (&event.body, &event.other) else {
            continue;
        };
        let [one, other] = [link_of(body, scene)?, link_of(other, scene)?];
        if scene.are_joined(one, other) {
            let said = format!(
                "a joint ties {:?} to {:?}, expected bodies that no joint ties to each other",
                scene.links[one].name, scene.links[other].name
            );
            return fault(spanned.span(), said);
        }
    }
    Ok(())
}

/// Refuses several contacts at once of which the joints let one follow from the others, whatever the pose: their impulses
/// would not be determined.
pub(in crate::config) fn refuse_dependent(raw: &RawScene, scene: &Scene) -> Result<(), Fault> {
    if scene.joint_trees().next().is_none() {
        return Ok(());
    }
    for (event, spanned) in raw.event.iter().enumerate() {
        let several = spanned.get_ref().features.as_ref();
        let several = several.filter(|features| features.get_ref().len() > 1);
        if let Some((several, touch)) = several.zip(scene.tree_touch(event))
            && depends(scene, &touch)
        {
            let said = "by the joints these features always touch together: expected one of them";
            return fault(several.span(), said);
        }
    }
    Ok(())
}

/// Whether contacts depend on each other in some poses that have nothing in common.
fn depends(scene: &Scene, touch: &TreeTouch) -> bool {
    let forest = scene.forest();
    let mut snapshot = ForestSnapshot::new(&forest, &scene.gravity_m_s2);
    let poses = [0.4, 0.7, 1.1].map(|step: f64| {
        let delta = (0..2 * forest.freedoms()).map(|at| (1.0 + step * at as f64).sin());
        forest.retract(&forest.at_rest(), &delta.collect::<Vec<f64>>())
    });
    poses.iter().all(|pose| {
        snapshot.set(pose);
        let impact = snapshot.impact(pose, &touch.at, &touch.law);
        matches!(impact, Err(ImpactError::Dependent { .. }))
    })
}
