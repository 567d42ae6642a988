//! Events within the motion of trees, whose times are unknown: impacts of links, and waypoints.

use super::law::FreeLaw;
use crate::motion::{EventKind, MarkTime, Scene, Sketch, TreeTouch};

/// An event of the scene with the stamp of its mark.
#[derive(Clone, Copy, Debug)]
pub struct StampedEvent {
    /// Index into `Scene::events`.
    pub event: usize,
    /// \[s, acted\].
    pub acted_s: f64,
}

/// An event within the motion.
#[derive(Clone, Debug)]
pub struct TreeEvent {
    /// Index into `Scene::events`.
    pub event: usize,
    /// About when it is \[s, acted\]: samples before belong to the motion before it, later ones to that after it,
    /// wherever its estimated time is.
    pub about_s: f64,
    /// Earliest and latest acted time \[s\]; equal where its time is given, `None` where it is free.
    pub window_s: Option<[f64; 2]>,
    /// When it was marked.
    pub mark: Option<MarkTime>,
    /// What hits what; none at a waypoint, where the motion goes on as it was.
    pub touch: Option<TreeTouch>,
    /// What of its law is unknown.
    pub free: FreeLaw,
}

/// The events of what moves here between the start and the end, in the scene's order.
///
/// # Panics
/// Where [`Scene::tree_touch`] says nothing of a collision: what reads scenes refuses those.
pub(super) fn events(scene: &Scene, sketch: &Sketch) -> Vec<TreeEvent> {
    let within = scene.events.iter().enumerate();
    let is_here = |kind: &EventKind| match kind {
        EventKind::Start | EventKind::End => false,
        EventKind::Change(_) => false,
        EventKind::Waypoint(link) => scene.moves(scene.mechanism_of(*link)),
        EventKind::Collision(_) | EventKind::Collisions { .. } => true,
    };
    let within = within.filter(|(_, of)| is_here(&of.kind));
    within
        .map(|(event, of)| TreeEvent {
            event,
            about_s: sketch.marks_s[event],
            window_s: window_s(scene, sketch, event),
            mark: sketch.marks[event],
            touch: of.kind.collision().map(|_| {
                let touch = scene.tree_touch(event);
                touch.expect("what touches is named")
            }),
            free: FreeLaw::of(scene, event),
        })
        .collect()
}

/// What the scene lets the acted time of an event be \[s\].
fn window_s(scene: &Scene, sketch: &Sketch, event: usize) -> Option<[f64; 2]> {
    let mark_s = sketch.marks[event].map_or(sketch.marks_s[event], |mark| mark.acted_s);
    let time = &scene.events[event].time;
    let after_s = match scene.time_is_free(event) {
        true => time.is_bounded().then_some(time.window_s)?,
        false => [0.0; 2],
    };
    Some(after_s.map(|after_s| mark_s + after_s))
}

impl TreeEvent {
    /// Numbers of its rows of touch: of approach, and of gaps.
    pub(super) fn touch_row_counts(&self) -> [usize; 2] {
        let Some(touch) = &self.touch else {
            return [0; 2];
        };
        let count = touch.at.contacts.as_slice().len();
        [count, if touch.is_by_goal { 0 } else { count }]
    }

    /// Number of both.
    pub(super) fn touch_row_count(&self) -> usize {
        self.touch_row_counts().into_iter().sum()
    }
}
