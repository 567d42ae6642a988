//! The motion that the unknowns say, walked through without derivatives.

use nalgebra::Vector3;

use super::point::TreePoint;
use super::problem::TreeProblem;
use super::trajectory::{Stop, Trajectory};
use crate::motion::TreeKnot;
use crate::physics::tree::{ForestSnapshot, TreeState};

/// Longest step of the integrator \[s\], and the greatest turn of any joint in it \[rad\]: on the way,
pub const ROUGHLY: [f64; 2] = [1.0 / 15.0, 0.8];
/// and at most in the end, where steps are as long as halving them tells.
pub const EXACTLY: [f64; 2] = [1.0 / 20.0, 0.4];
/// By how much a motion changes at most where the steps that are exact enough are halved \[m\]: of what verification lets
/// pass, a thirtieth.
const EXACT_M: f64 = 3e-8;
/// The method's errors are as this power of its steps.
const ORDER: f64 = 8.0;
/// How often steps are shortened, by at most which factor, and by how much more than their errors ask.
const SHORTENED: (usize, f64, f64) = (3, 0.3, 0.9);

/// Fastest joint for which steps are shortened [rad/s]: faster ones are far from any hand's.
const RATE_MOST_RAD_S: f64 = 400.0;

impl TreeProblem {
    /// States at the beginning, at every sample, goal and event and at the end: at an event the one before it, then
    /// the one after.
    pub(super) fn knots(&self, point: &TreePoint) -> Vec<TreeKnot> {
        let mut knots = Vec::new();
        let this = &*self.as_told(point);
        let line = &point.time_line(this);
        for (node, state) in point.nodes.iter().enumerate() {
            let [from_s, to_s] = self.interval_s(node).map(|end_s| line.time_s(end_s));
            let mut trajectory = Trajectory::plain(this, line, state, from_s);
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
                    trajectory.advance(Stop::known(event_s));
                    knot(event_s, trajectory.state());
                    if this.pass(event, point, &mut trajectory) {
                        knot(event_s, trajectory.state());
                    }
                }
                trajectory.advance(Stop::known(time_s));
                knot(time_s, trajectory.state());
            }
        }
        knots
    }

    /// Goes on from a physical time to a later one \[s\], through the events after that and until this.
    pub(super) fn follow(
        &self,
        point: &TreePoint,
        from_s: f64,
        to_s: f64,
        trajectory: &mut Trajectory,
    ) {
        for (event, event_s) in point.event_times_s.iter().enumerate() {
            if *event_s > from_s && *event_s <= to_s {
                trajectory.advance(Stop::known(*event_s));
                self.pass(event, point, trajectory);
            }
        }
        trajectory.advance(Stop::known(to_s));
    }

    /// Goes through an event; whether the rates jump there.
    fn pass(&self, event: usize, point: &TreePoint, trajectory: &mut Trajectory) -> bool {
        let touch = self.events[event].touch_at(point);
        touch.is_some_and(|touch| trajectory.bounce(&touch).is_ok())
    }

    /// Step of the integrator for the whole motion, whose half leads every link to the same place within [`EXACT_M`]; at most
    /// as [`TreeProblem::step_for`] has it.
    pub(super) fn exact_step_s(&self, point: &TreePoint, at_most: [f64; 2]) -> f64 {
        let (times, least, margin) = SHORTENED;
        let mut problem = self.clone();
        problem.step_s = self.step_for(point, self.span_s[1], at_most);
        for _ in 0..times {
            let off_m = problem.off_by_halving_m(point);
            if off_m <= EXACT_M {
                break;
            }
            let by = margin * (EXACT_M / off_m).powf(ORDER.recip());
            // At least so much where nothing is known.
            problem.step_s *= by.max(least);
        }
        problem.step_s
    }

    /// How far centres of links are at most from where they are with steps of half the length \[m\].
    fn off_by_halving_m(&self, point: &TreePoint) -> f64 {
        let half = Self {
            step_s: 0.5 * self.step_s,
            ..self.clone()
        };
        let this = &*self.as_told(point);
        let mut snapshot = ForestSnapshot::new(&this.forest, &this.gravity_m_s2);
        let mut places_m = |problem: &Self| -> Vec<Vector3<f64>> {
            let mut places_m = Vec::new();
            for knot in problem.knots(point) {
                snapshot.set(&knot.state);
                let links = 0..self.forest.link_count();
                places_m.extend(links.map(|link| snapshot.link_state(link).position_m));
            }
            places_m
        };
        let (here_m, there_m) = (places_m(self), places_m(&half));
        let off_m = here_m.iter().zip(&there_m).map(|(a, b)| (a - b).norm());
        off_m.fold(0.0, |most: f64, off_m| match off_m.is_nan() {
            true => f64::INFINITY,
            false => most.max(off_m),
        })
    }

    /// Step of the integrator for the motion from its first node to a stamp \[s\]: not longer than `most_s` \[s\] nor than a hand
    /// moves smoothly, and no joint turns by more than `turn_rad` \[rad\] in it.
    pub(super) fn step_for(
        &self,
        point: &TreePoint,
        until_s: f64,
        [most_s, turn_rad]: [f64; 2],
    ) -> f64 {
        let this = &*self.as_told(point);
        let line = &point.time_line(this);
        let [begin_s, last_s] = line.physical_span_s();
        let most_s = most_s.min(self.forest.smooth_s(begin_s));
        let mut trajectory = Trajectory::plain(this, line, &point.nodes[0], begin_s);
        let mut events = (0..self.events.len()).peekable();
        let mut fastest_rad_s: f64 = 0.0;
        let mut now_s = begin_s;
        let end_s = line.time_s(until_s).min(last_s);
        let step_s = |fastest_rad_s: f64| most_s.min(turn_rad / fastest_rad_s.max(1e-9));
        loop {
            let rates = trajectory.state().rates;
            let turning = rates.iter().enumerate();
            let turning = turning.filter(|(at, _)| !self.forest.is_translation(*at));
            let here = turning.fold(0.0, |most: f64, (_, rate)| most.max(rate.abs()));
            fastest_rad_s = fastest_rad_s.max(here.min(RATE_MOST_RAD_S));
            if now_s >= end_s || !here.is_finite() {
                break;
            }
            now_s += step_s(fastest_rad_s).min(end_s - now_s);
            while let Some(event) = events.next_if(|of| point.event_times_s[*of] <= now_s) {
                trajectory.step(point.event_times_s[event]);
                this.pass(event, point, &mut trajectory);
            }
            trajectory.step(now_s);
        }
        // As many as fit.
        let span_s = last_s - begin_s;
        span_s / (span_s / step_s(fastest_rad_s)).ceil()
    }
}
