//! Performances as tasks for methods: what the program's segmentation makes of them, and the best
//! optimum known.

use std::time::Instant;

use enact::estimate::schedule::recipe::{self, Recipe};
use enact::motion::{Guess, Sketch, Stamp, TakeEvent};
use enact::optimise::Schedule;
use enact::optimise::finish::Tolerances;
use enact::physics::{State, flow};
use nalgebra::Vector3;

use enact_tools::case::{Case, Posed, is_bent};
use enact_tools::methods::{Answer, Task};
use enact_tools::starts::{Start, optimum, starts};

/// A performance as a task.
pub struct Posing {
    /// The task.
    pub task: Task,
    /// After the program's segmentation.
    pub sketch: Sketch,
    /// Whether velocities may jump: no motion is true.
    pub is_bent: bool,
    /// Of the whole estimate: time \[s\], and distance from the truth \[mm\].
    pub whole_s: f64,
    pub whole_off_mm: Option<f64>,
    truth: Guess,
}

/// The task of a performance, its best optimum from so many starts, the truth among them; why
/// there is none, where segmentation refuses.
pub fn posing(case: &Case, seed: u64, starts_max: usize) -> Result<Posing, String> {
    let pipeline = case.pipeline();
    let begin = Instant::now();
    let outcome = pipeline
        .estimate(&mut ())
        .map_err(|error| error.to_string())?;
    let whole_s = begin.elapsed().as_secs_f64();
    let (posed, truth) = case.posed_without_marks(&outcome);
    let mut from = starts(&posed, &truth, seed);
    from.truncate(starts_max);
    // What is best is solved again, far tighter.
    let best = from
        .iter()
        .filter_map(|start| Some((optimum(&posed, start)?.objective, start)))
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(objective, start)| tight(&posed, start).unwrap_or(objective).min(objective));
    let mut posing = Posing {
        task: Task {
            problem: posed.problem,
            layout: posed.layout,
            guesses: posed.guesses,
            best,
            seed,
        },
        is_bent: is_bent(case.scene()),
        whole_s,
        whole_off_mm: None,
        truth,
        sketch: outcome.sketch,
    };
    let arcs = &outcome.estimate.arcs;
    let gravity_m_s2 = outcome.estimate.gravity_m_s2;
    let states = arcs.iter().map(|arc| (arc.epoch_s, arc.state));
    posing.whole_off_mm = posing.apart_mm(states, &gravity_m_s2);
    Ok(posing)
}

impl Posing {
    /// Largest distance of an answer from the true motion at the middle of a flight \[mm\].
    pub fn off_mm(&self, answer: &Answer) -> Option<f64> {
        let states = answer
            .epochs_s
            .iter()
            .copied()
            .zip(answer.point.arcs.iter().copied());
        let gravity_m_s2 = self.task.problem.gravity(&answer.point.parameters);
        self.apart_mm(states, &gravity_m_s2)
    }

    /// None where no motion is true, or the states are not finite.
    fn apart_mm(
        &self,
        states: impl Iterator<Item = (f64, State)>,
        gravity_m_s2: &Vector3<f64>,
    ) -> Option<f64> {
        if self.is_bent {
            return None;
        }
        let problem = &self.task.problem;
        let true_gravity_m_s2 = problem.gravity(&self.truth.parameters);
        let apart = states.zip(&self.truth.arcs).zip(&problem.arcs);
        let apart = apart.map(|(((epoch_s, state), truth), arc)| {
            let body = &problem.bodies[arc.mechanism];
            let middle_s = truth.sample_times_s[truth.sample_times_s.len() / 2];
            let own = flow::advance(body, gravity_m_s2, &state, middle_s - epoch_s);
            let there = middle_s - truth.epoch_s;
            let other = flow::advance(body, &true_gravity_m_s2, &truth.state, there);
            1e3 * (own.position_m - other.position_m).norm()
        });
        let largest = apart.fold(0.0, f64::max);
        largest.is_finite().then_some(largest)
    }
}

/// The objective at tolerances near rounding.
fn tight(posed: &Posed, start: &Start) -> Option<f64> {
    let schedule = Schedule {
        tolerances: Tolerances {
            violation: 1e-12,
            decrease: 1e-14,
            ..Tolerances::default()
        },
        ..start.recipe.schedule.clone()
    };
    let recipe = Recipe {
        schedule,
        ..start.recipe.clone()
    };
    let solution = recipe::solve(
        &posed.problem,
        &posed.layout,
        &start.guess,
        &recipe,
        &mut (),
    );
    let converged = solution.finished.converged;
    converged.then_some(2.0 * solution.system.cost)
}

/// The sketch with the performer's marks as they are, in the order of the events; `None` where
/// there are not as many.
pub fn with_marks_as_they_are(case: &Case, sketch: &Sketch) -> Option<Sketch> {
    let events = &case.performance.events;
    let marks = events.iter().filter_map(|event| match event {
        TakeEvent::Mark(mark) => Some(mark.stamp),
        TakeEvent::Pose { .. } => None,
    });
    let mut marks: Vec<Stamp> = marks.collect();
    marks.sort();
    let sample = sketch
        .tracks
        .iter()
        .flat_map(|track| &track.samples)
        .next()?;
    let mut as_they_are = sketch.clone();
    if marks.len() != as_they_are.marks_s.len() {
        return None;
    }
    for (mark_s, stamp) in as_they_are.marks_s.iter_mut().zip(marks) {
        *mark_s = sample.acted_s + (stamp.0 - sample.stamp.0) as f64 * 1e-9;
    }
    Some(as_they_are)
}
