//! The motion until an event, by the samples before it alone: what is known of the event before it is known what
//! touches there.

use super::continuation::{Continuation, Intervals, KICK_RAD_S, continuation, continued};
use super::goal::TreeGoal;
use super::part::Part;
use super::point::TreePoint;
use super::problem::TreeProblem;
use super::program::TreeProgram;
use super::sample::TreeSample;
use super::trajectory::{Stop, Trajectory};
use crate::estimate::constraint::quantity;
use crate::math::random::Random;
use crate::motion::{GoalUnit, LinkIndex, Observer, Scene};
use crate::optimise::{Program, Work};
use crate::physics::State;
use crate::physics::tree::{ForestSnapshot, TreeState};

/// How the part until the event grows: as a rule, and where that leads to a lost motion.
const CONTINUATIONS: [Continuation; 2] = [
    continuation(1.5, Intervals::One, KICK_RAD_S),
    continuation(1.25, Intervals::One, KICK_RAD_S),
];
/// Samples tell how uncertain the motion is at the event that are at most so long before it \[s\].
const LATE_S: f64 = 0.15;

/// The motion that the samples before an event say.
pub struct Before {
    problem: TreeProblem,
    point: TreePoint,
    cost: f64,
    work: Work,
    /// When the event is marked, in physical time \[s\].
    event_s: f64,
    /// The state there.
    state: TreeState,
}

impl Before {
    /// Fits the samples before the mark of an event (index into `Scene::events`), through what touches earlier. From the
    /// pace in which they cost least where the tempo is unknown; `None` where nothing finite is found, or no sample is
    /// before the event.
    pub fn new(
        problem: &TreeProblem,
        event: usize,
        starts: &[(f64, TreeState)],
        observer: &mut dyn Observer,
    ) -> Option<Self> {
        let until = problem.given().until(event)?;
        let mut work = Work::default();
        let mut least: Option<(f64, TreeProblem, TreePoint)> = None;
        for by in CONTINUATIONS {
            for (pace, start) in starts {
                let mut paced = until.clone();
                if let Some(tempo) = &mut paced.tempo {
                    tempo.guess = *pace;
                }
                let led = continued(
                    &paced,
                    start.clone(),
                    by,
                    &mut Random::default(),
                    &mut work,
                    observer,
                );
                let program = TreeProgram::new(&led.problem, led.point.clone());
                let cost = program.evaluated(&Part::whole(), &led.point).cost;
                let is_less = least.as_ref().is_none_or(|(other, ..)| cost < *other);
                if led.point.is_finite() && cost.is_finite() && is_less {
                    least = Some((cost, led.problem, led.point));
                }
                if !led.is_lost && problem.tempo.is_none() {
                    return Self::of(least?, work);
                }
            }
        }
        Self::of(least?, work)
    }

    fn of(led: (f64, TreeProblem, TreePoint), work: Work) -> Option<Self> {
        let (cost, problem, point) = led;
        let line = point.time_line(&problem);
        let [_, event_s] = line.physical_span_s();
        let state = problem.state_at(&point, problem.span_s[1]);
        Some(Self {
            event_s,
            state,
            cost,
            work,
            problem,
            point,
        })
    }

    /// What each sample costs.
    pub fn cost_each(&self) -> f64 {
        self.cost / self.problem.samples.len() as f64
    }

    /// Work done.
    pub fn work(&self) -> &Work {
        &self.work
    }

    /// The state of a link so long after the event \[s\], as if nothing touched there.
    pub fn state(&self, scene: &Scene, link: LinkIndex, after_s: f64) -> State {
        let line = self.point.time_line(&self.problem);
        let mut trajectory = Trajectory::plain(&self.problem, &line, &self.state, self.event_s);
        trajectory.advance(Stop::known(self.event_s + after_s));
        let mut snapshot = ForestSnapshot::new(&self.problem.forest, &self.problem.gravity_m_s2);
        snapshot.set(&trajectory.state());
        snapshot.link_state(scene.place_of(link))
    }

    /// Root mean square distance of a link's samples shortly before the event from the motion, plus the root mean
    /// square angle times the link's radius \[m\]; of all links' where it has none.
    pub fn spread_m(&self, scene: &Scene, link: LinkIndex) -> f64 {
        let place = scene.place_of(link);
        let radius_m = scene.links[link].radius_m();
        let offs = match self.offs(Some(place)) {
            [None, None] => self.offs(None),
            offs => offs,
        };
        let [places_m, turns_rad] = offs.map(Option::unwrap_or_default);
        places_m + radius_m * turns_rad
    }

    /// Root mean squares of places \[m\] and of turns \[rad\] by which late samples of a link, or of all, are off.
    fn offs(&self, place: Option<usize>) -> [Option<f64>; 2] {
        let problem = &self.problem;
        let line = self.point.time_line(problem);
        let knots = problem.knots(&self.point);
        let mut snapshot = ForestSnapshot::new(&problem.forest, &problem.gravity_m_s2);
        let mut sums = [(0.0, 0.0); 2];
        let late_s = problem.span_s[1] - LATE_S;
        let is_of =
            |of: &&TreeSample| of.acted_s >= late_s && place.is_none_or(|place| place == of.place);
        for sample in problem.samples.iter().filter(is_of) {
            let time_s = line.time_s(sample.acted_s);
            let at = knots.partition_point(|knot| knot.time_s < time_s);
            snapshot.set(&knots[at.min(knots.len() - 1)].state);
            let link = snapshot.link_state(sample.place);
            let valued = quantity::valued(&sample.quantity, &link, None, &sample.point_m);
            let kind = usize::from(sample.quantity.unit() != GoalUnit::Metre);
            sums[kind].0 += (valued.value - sample.seen).norm_squared();
            sums[kind].1 += 1.0;
        }
        sums.map(|(sum, count)| (count > 0.0).then(|| f64::sqrt(sum / count)))
    }
}

impl TreeProblem {
    /// The problem until an event; `None` where no sample is before it.
    fn until(&self, event: usize) -> Option<Self> {
        let within = self.events.iter().position(|of| of.event == event)?;
        let until_s = self.events[within].about_s;
        let mut until = self.clone();
        until.samples.retain(|of| of.acted_s < until_s);
        until.events.truncate(within);
        let kept = |of: &TreeGoal| self.about_s(of) < until_s;
        until.goals.retain(kept);
        until.span_s[1] = until_s;
        until.nodes_s.truncate(1);
        (!until.samples.is_empty()).then_some(until)
    }
}
