//! Arc fits of bodies by themselves about a collision.

use super::fitted::Fitted;
use crate::math::{Pose, so3};
use crate::motion::held::Mounted;
use crate::motion::{Goal, GoalTarget, Guess, HeldMotion, LinkIndex, Scene, Seen, Segment, Sketch};
use crate::physics::contact::Frame;
use crate::physics::{State, flow};

/// The arc fits that end or begin at a collision.
pub(super) struct ContactFlights<'a> {
    pub(super) scene: &'a Scene,
    pub(super) sketch: &'a Sketch,
    pub(super) segments: &'a [Segment],
    pub(super) guess: &'a Guess,
    pub(super) event: usize,
}

impl Fitted for ContactFlights<'_> {
    fn state(&self, link: LinkIndex, is_after: bool, after_s: f64) -> Option<State> {
        if self.scene.is_held(link) {
            let held = (!is_after).then(|| HeldSolid::new(self, link))??;
            return Some(held.state(after_s));
        }
        Some(self.state_on(self.arc(link, !is_after)?, after_s))
    }

    /// Root mean square distance of fits from samples near the event, plus the rms angle times the
    /// radius.
    fn spread_m(&self, link: LinkIndex) -> f64 {
        if self.goal(link).is_some() {
            return 0.0;
        }
        let radius_m = self.scene.links[link].shape.radius_m();
        let body = self.scene.body_of(self.scene.mechanism_of(link));
        let (mut shift_m2, mut turn_rad2, mut count) = (0.0, 0.0, 0.0);
        for arc in [true, false]
            .map(|ends| self.arc(link, ends))
            .into_iter()
            .flatten()
        {
            let samples = self.sketch.samples_in(&self.segments[arc]);
            let fit = &self.guess.arcs[arc];
            for (sample, time_s) in samples.zip(&fit.sample_times_s) {
                // What is not seen whole says less of what is near.
                let Seen::Pose {
                    position_m,
                    orientation,
                } = sample.seen
                else {
                    continue;
                };
                let gravity = &self.scene.gravity_m_s2;
                let duration_s = time_s - fit.epoch_s;
                let state = flow::advance(body, gravity, &fit.state, duration_s);
                shift_m2 += (state.position_m - position_m).norm_squared();
                let turn = so3::log(&(orientation.inverse() * state.orientation));
                turn_rad2 += turn.norm_squared();
                count += 1.0;
            }
        }
        if count == 0.0 {
            return 0.0;
        }
        (shift_m2 / count).sqrt() + radius_m * (turn_rad2 / count).sqrt()
    }
}

impl ContactFlights<'_> {
    /// What hits.
    fn first_link(&self) -> Option<LinkIndex> {
        let collision = self.scene.events[self.event].kind.collision()?;
        collision.links().next()
    }

    /// The link's arcs that end (or begin) at the event.
    fn arc(&self, link: LinkIndex, ends: bool) -> Option<usize> {
        let mechanism = self.scene.mechanism_of(link);
        self.segments.iter().position(|segment| {
            let event = if ends {
                segment.end_event
            } else {
                segment.start_event
            };
            segment.mechanism == mechanism && event == Some(self.event)
        })
    }

    /// The pose that a goal requires of a link at the event.
    fn goal(&self, link: LinkIndex) -> Option<Frame> {
        let at = |goal: &&Goal| goal.event == self.event && goal.link == link;
        let mut goals = self.scene.goals.iter().filter(at);
        goals.find_map(|goal| match &goal.target {
            GoalTarget::Pose { world_from_body } => Some(Frame {
                position_m: world_from_body.translation.vector,
                orientation: world_from_body.rotation,
            }),
            GoalTarget::PositionWithin { .. } | GoalTarget::Condition(_) => None,
        })
    }

    /// The state by the fit of an arc, a time after the event; moved through the pose of a goal
    /// there.
    fn state_on(&self, arc: usize, after_s: f64) -> State {
        let fit = &self.guess.arcs[arc];
        let mechanism = self.segments[arc].mechanism;
        let link = self.scene.free_link(mechanism);
        let body = self.scene.body_of(mechanism);
        let advance = |state: &State, duration_s: f64| {
            flow::advance(body, &self.scene.gravity_m_s2, state, duration_s)
        };
        let duration_s = self.guess.event_times_s[self.event] - fit.epoch_s;
        let mut at_event = advance(&fit.state, duration_s);
        if let Some(goal) = self.goal(link) {
            at_event.position_m = goal.position_m;
            at_event.orientation = goal.orientation;
        }
        advance(&at_event, after_s)
    }
}

/// A held body near an event.
struct HeldSolid<'a> {
    motion: &'a HeldMotion,
    link_from_tracker: Pose,
    /// Acted time of the event \[s\].
    acted_s: f64,
    /// Acted time that passes in a second, in the mean over the flight before the event.
    rate: f64,
}

impl<'a> HeldSolid<'a> {
    fn new(view: &ContactFlights<'a>, link: LinkIndex) -> Option<Self> {
        let mut tracks = view.scene.tracks.iter_enumerated();
        let (track, of) = tracks.find(|(_, track)| track.link == link)?;
        let before = view.arc(view.first_link()?, true)?;
        let flight = &view.segments[before];
        let shown = flight.views.first().map(|of| view.sketch.samples_of(of));
        let times_s = &view.guess.arcs[before].sample_times_s;
        let rate = match shown {
            Some(samples @ [first, .., last]) => {
                let lasts_s = times_s[samples.len() - 1] - times_s[0];
                (last.acted_s - first.acted_s) / lasts_s
            }
            _ => 1.0,
        };
        Some(Self {
            motion: view.sketch.tracks[track].held.as_ref()?,
            link_from_tracker: of.link_from_tracker,
            acted_s: view.sketch.marks_s[view.event],
            rate,
        })
    }

    fn state(&self, after_s: f64) -> State {
        let tracker = self.motion.at(self.acted_s + after_s * self.rate);
        let mounted = Mounted::new(&tracker, &self.link_from_tracker);
        mounted.driven.at_rate(self.rate).state
    }
}
