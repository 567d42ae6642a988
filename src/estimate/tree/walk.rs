//! The motion that the unknowns say, walked through without derivatives.

use super::course::{Course, Stop};
use super::point::TreePoint;
use super::problem::TreeProblem;
use crate::motion::TreeKnot;
use crate::physics::tree::TreeState;

/// Fastest joint for which steps are shortened [rad/s]: faster ones are far from any hand's.
const RATE_MOST_RAD_S: f64 = 400.0;

impl TreeProblem {
    /// States at the beginning, at every sample, goal and event and at the end: at an event the one before it, then
    /// the one after.
    pub(super) fn knots(&self, point: &TreePoint) -> Vec<TreeKnot> {
        let mut knots = Vec::new();
        let line = &point.time_line(self);
        for (node, state) in point.nodes.iter().enumerate() {
            let [from_s, to_s] = self.leg_s(node).map(|end_s| line.time_s(end_s));
            let mut course = Course::plain((self, line), (state, from_s));
            let mut knot = |time_s: f64, state: TreeState| knots.push(TreeKnot { time_s, state });
            knot(from_s, state.clone());
            let mut times_s: Vec<f64> = self.samples.iter().map(|sample| sample.acted_s).collect();
            let known = self
                .goals
                .iter()
                .filter(|goal| self.event_within(goal).is_none());
            times_s.extend(known.map(|goal| goal.acted_s));
            times_s
                .iter_mut()
                .for_each(|at_s| *at_s = line.time_s(*at_s));
            times_s.retain(|time_s| *time_s > from_s && *time_s <= to_s);
            times_s.push(to_s);
            times_s.sort_by(f64::total_cmp);
            times_s.dedup();
            let mut events = self.events_of(node).peekable();
            for time_s in times_s.into_iter().filter(|time_s| *time_s > from_s) {
                while let Some(event) = events.next_if(|of| point.event_times_s[*of] <= time_s) {
                    let event_s = point.event_times_s[event];
                    course.advance(Stop::known(event_s));
                    knot(event_s, course.state());
                    if self.pass((event, point), &mut course) {
                        knot(event_s, course.state());
                    }
                }
                course.advance(Stop::known(time_s));
                knot(time_s, course.state());
            }
        }
        knots
    }

    /// Goes through an event; whether the rates jump there.
    fn pass(&self, (event, point): (usize, &TreePoint), course: &mut Course) -> bool {
        let touch = self.events[event].touch_at(point);
        touch.is_some_and(|touch| course.hit_plainly(&touch).is_ok())
    }

    /// Step of the integrator for the motion from its first node to a stamp \[s\]: not longer than `most_s` \[s\], and
    /// no joint turns by more than `turn_rad` \[rad\] in it.
    pub(super) fn step_for(
        &self,
        point: &TreePoint,
        until_s: f64,
        [most_s, turn_rad]: [f64; 2],
    ) -> f64 {
        let line = &point.time_line(self);
        let [begin_s, last_s] = line.physical_span_s();
        let mut course = Course::plain((self, line), (&point.nodes[0], begin_s));
        let mut events = (0..self.events.len()).peekable();
        let mut fastest_rad_s: f64 = 0.0;
        let mut now_s = begin_s;
        let end_s = line.time_s(until_s).min(last_s);
        let step_s = |fastest_rad_s: f64| most_s.min(turn_rad / fastest_rad_s.max(1e-9));
        loop {
            let rates = course.state().rates;
            let turning = rates.iter().enumerate();
            let turning = turning.filter(|(at, _)| !self.forest.is_translation(*at));
            let here = turning.fold(0.0, |most: f64, (_, rate)| most.max(rate.abs()));
            fastest_rad_s = fastest_rad_s.max(here.min(RATE_MOST_RAD_S));
            if now_s >= end_s || !here.is_finite() {
                break;
            }
            now_s += step_s(fastest_rad_s).min(end_s - now_s);
            while let Some(event) = events.next_if(|of| point.event_times_s[*of] <= now_s) {
                course.step(point.event_times_s[event]);
                self.pass((event, point), &mut course);
            }
            course.step(now_s);
        }
        // As many as fit.
        let span_s = last_s - begin_s;
        span_s / (span_s / step_s(fastest_rad_s)).ceil()
    }
}
