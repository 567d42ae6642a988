//! Performances as tasks for methods: what the program's segmentation makes of them, and the best
//! optimum known.

use enact::estimate::layout::Layout;
use enact::estimate::recipe::{self, Recipe};
use enact::motion::{Guess, Sketch, Stamp, TakeEvent, VelocityGaps};
use enact::optimise::Schedule;
use enact::optimise::finish::Tolerances;
use enact::pipeline::Outcome;

use enact_tools::case::{Case, Posed};
use enact_tools::methods::Task;
use enact_tools::starts::{Start, optimum, starts};

/// A performance as a task.
pub struct Posing {
    /// The task.
    pub task: Task,
    /// After the program's segmentation.
    pub sketch: Sketch,
}

/// The task of a performance, its best optimum from so many starts, the truth among them; why
/// there is none, where segmentation refuses.
pub fn posing(case: &Case, seed: u64, starts_max: usize) -> Result<Posing, String> {
    let outcome = case.estimated(&mut ()).map_err(|error| error.to_string())?;
    let (posed, guess) = posed_with_truth(case, &outcome);
    let sketch = outcome.sketch;
    let mut from = starts(&posed, &guess, seed);
    from.truncate(starts_max);
    // What is best is solved again, far tighter.
    let best = from
        .iter()
        .filter_map(|start| Some((optimum(&posed, start)?.objective, start)))
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(objective, start)| tight(&posed, start).unwrap_or(objective).min(objective));
    Ok(Posing {
        task: Task {
            problem: posed.problem,
            layout: posed.layout,
            guesses: posed.guesses,
            best,
            seed,
        },
        sketch,
    })
}

/// The problem that an outcome's sketch poses, and the truth as a guess for it: the program's own where
/// velocities may jump, for then no motion is true.
pub fn posed_with_truth(case: &Case, outcome: &Outcome) -> (Posed, Guess) {
    let mut posed = Posed::without_marks(&outcome.scene, &outcome.sketch);
    if is_bent(outcome) {
        posed.problem = posed.problem.with_velocity_gaps();
        posed.layout = Layout::new(&posed.problem);
        let guess = posed.guesses[0].clone();
        return (posed, guess);
    }
    let mut guess = case.true_guess(&posed, &outcome.sketch);
    if !posed.problem.times_are_unknown() {
        // Stamps are rounded to nanoseconds: at the true times it would be another problem, by 1e-10.
        for (arc, own) in guess.arcs.iter_mut().zip(&posed.guesses[0].arcs) {
            arc.sample_times_s.clone_from(&own.sample_times_s);
        }
    }
    (posed, guess)
}

/// Whether its velocities may jump.
pub fn is_bent(outcome: &Outcome) -> bool {
    outcome.scene.velocity_gaps == VelocityGaps::Always
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
    let sample = sketch.bodies.iter().flat_map(|body| &body.samples).next()?;
    let mut as_they_are = sketch.clone();
    if marks.len() != as_they_are.marks_s.len() {
        return None;
    }
    for (mark_s, stamp) in as_they_are.marks_s.iter_mut().zip(marks) {
        *mark_s = sample.acted_s + (stamp.0 - sample.stamp.0) as f64 * 1e-9;
    }
    Some(as_they_are)
}
