//! What the program says of a performance, and what that is worth.

use std::panic::{AssertUnwindSafe, catch_unwind};

use enact::motion::{Estimate, Verdict};
use enact::physics::flow;
use enact::pipeline::{Outcome, PipelineError};
use enact::report::reason_text;

use super::check::{Finding, check};
use crate::case::Case;
use crate::starts::{Optimum, is_best, lowest, starts};

/// What the program says.
pub enum Answer {
    /// An outcome, whatever its verdict.
    Outcome(Box<Outcome>),
    /// Nothing to estimate from.
    Refused(PipelineError),
    /// A bug.
    Panicked(String),
}

/// One performance, judged.
#[derive(Clone, Debug)]
pub struct Judged {
    /// What it says, numbers left out: `physical`, `failed: …`, `refused: …`.
    pub said: String,
    /// The same with its numbers.
    pub reason: String,
    /// Whether it ends at the lowest objective any start found.
    pub is_best: bool,
    /// Sum of squared residuals.
    pub objective: f64,
    /// The lowest one found, and from where.
    pub lowest: Option<(f64, String)>,
    /// Whether a number in the outcome is not finite.
    pub has_nan: bool,
    /// Of a verdict `physical`: what an independent look finds.
    pub finding: Option<Finding>,
    /// Whether the program's own checks find it too, and take the verdict back.
    pub is_caught: bool,
    /// Names of what is undetermined.
    pub undetermined: usize,
    /// Solver's iterations.
    pub iterations: usize,
    /// Largest distance from the true motion at the middle of an arc \[m\]; NaN where the arcs are
    /// not those of the truth.
    pub off_m: f64,
}

/// Asks the program; a panic is an answer too.
pub fn answer(case: &Case) -> Answer {
    match catch_unwind(AssertUnwindSafe(|| case.estimated(&mut ()))) {
        Ok(Ok(outcome)) => Answer::Outcome(Box::new(outcome)),
        Ok(Err(error)) => Answer::Refused(error),
        Err(panic) => Answer::Panicked(message(&*panic)),
    }
}

fn message(panic: &(dyn std::any::Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().cloned();
    let text = text.or_else(|| panic.downcast_ref::<&str>().map(|text| (*text).to_owned()));
    text.unwrap_or_else(|| "no message".into())
}

/// Asks the program, checks what it says, and looks for the best optimum from many starts.
pub fn judged(case: &Case, seed: u64) -> Judged {
    let answer = answer(case);
    let mut judged = weighed(case, &answer);
    if let Answer::Outcome(outcome) = &answer {
        let found = catch_unwind(AssertUnwindSafe(|| best_known(case, outcome, seed)));
        match found {
            Ok((known, off_m)) => {
                let is_physical = outcome.estimate.verdict == Verdict::Physical;
                judged.off_m = off_m;
                judged.is_best = is_physical
                    && known
                        .as_ref()
                        .is_none_or(|known| is_best(judged.objective, known.objective));
                judged.lowest = known.map(|known| (known.objective, known.start));
            }
            Err(panic) => judged.said = format!("panic from a start: {}", message(&*panic)),
        }
    }
    judged
}

/// Asks the program and checks what it says.
pub fn asked(case: &Case) -> Judged {
    weighed(case, &answer(case))
}

fn weighed(case: &Case, answer: &Answer) -> Judged {
    let mut judged = Judged {
        said: String::new(),
        reason: String::new(),
        is_best: false,
        objective: f64::NAN,
        lowest: None,
        has_nan: false,
        finding: None,
        is_caught: false,
        undetermined: 0,
        iterations: 0,
        off_m: f64::NAN,
    };
    match answer {
        Answer::Panicked(message) => {
            judged.said = format!("panic: {}", without_numbers(message));
            judged.reason.clone_from(message);
        }
        Answer::Refused(error) => {
            judged.reason = error.to_string();
            judged.said = format!("refused: {}", without_numbers(&judged.reason));
        }
        Answer::Outcome(outcome) => {
            let estimate = &outcome.estimate;
            judged.reason = reason_text(&outcome.scene, &estimate.reason);
            judged.objective = estimate.objective;
            judged.has_nan = has_nan(outcome);
            judged.undetermined = estimate.undetermined.len();
            judged.iterations = estimate.counters.iterations;
            judged.said = if estimate.verdict == Verdict::Physical {
                let finding = check(case.scene(), estimate);
                judged.is_caught =
                    finding != Finding::Agrees && case.checked() != Some(Verdict::Physical);
                judged.finding = Some(finding);
                estimate.verdict.as_str().to_owned()
            } else {
                let reason = judged.reason.split(": largest violation").next();
                let reason = reason.unwrap_or_default();
                format!("{}: {}", estimate.verdict.as_str(), without_numbers(reason))
            };
        }
    }
    judged
}

/// The lowest optimum, and how far the estimate is from the truth. Eight starts at known times
/// of up to three segments, fewer of what is larger.
fn best_known(case: &Case, outcome: &Outcome, seed: u64) -> (Option<Optimum>, f64) {
    let (posed, guess) = case.posed(outcome);
    let mut starts = starts(&posed, &guess, seed);
    // The truth, swept too, the program's own and the truth shaken come first.
    starts.truncate(
        match (posed.segments.len(), posed.problem.times_are_unknown()) {
            (..=3, false) => 8,
            (..=3, true) => 6,
            (_, false) => 6,
            (_, true) => 3,
        },
    );
    let known = lowest(&posed, &starts);
    let offset_s = case.offset_s(&posed, &outcome.sketch);
    (known, off_m(case, &outcome.estimate, offset_s))
}

fn off_m(case: &Case, estimate: &Estimate, offset_s: f64) -> f64 {
    let truth = &case.performance.truth;
    if truth.scene.links.len() > 1 || estimate.arcs.len() != truth.arcs.len() {
        return f64::NAN;
    }
    let arcs = estimate.arcs.iter().enumerate();
    let off_m = arcs.map(|(index, arc)| {
        let body = truth.scene.body_of(arc.mechanism);
        let time_s = 0.5 * (arc.start_s + arc.end_s);
        let gravity = &estimate.gravity_m_s2;
        let at_s = time_s - arc.epoch_s;
        let own = flow::advance(body, gravity, &arc.state, at_s);
        (own.position_m - case.true_state(index, time_s, offset_s).position_m).norm()
    });
    off_m.fold(0.0, f64::max)
}

/// Whether any number of an outcome is not finite.
fn has_nan(outcome: &Outcome) -> bool {
    let estimate = &outcome.estimate;
    let mut numbers = vec![estimate.objective];
    numbers.extend(estimate.gravity_m_s2.iter());
    for arc in &estimate.arcs {
        numbers.extend([arc.epoch_s, arc.start_s, arc.end_s]);
        let state = &arc.state;
        numbers.extend(state.position_m.iter().chain(state.velocity_m_s.iter()));
        numbers.extend(state.angular_velocity_rad_s.iter());
        numbers.extend(state.orientation.coords.iter());
    }
    for event in &estimate.events {
        let gap = &event.gap;
        numbers.extend([
            event.time_s,
            event.acted_s,
            gap.position_m,
            gap.orientation_rad,
        ]);
        numbers.extend([gap.velocity_m_s, gap.angular_velocity_rad_s]);
        numbers.extend(event.sd_s);
    }
    for parameter in &estimate.parameters {
        numbers.push(parameter.value);
        numbers.extend(parameter.sd);
    }
    for residual in &estimate.residuals {
        numbers.extend(residual.position_rms_m);
        numbers.extend(residual.orientation_rms_rad);
    }
    numbers.extend(estimate.sample_times.iter().map(|sample| sample.time_s));
    numbers.extend(&outcome.sketch.marks_s);
    numbers.iter().any(|number| !number.is_finite())
}

/// Text with `#` in place of every number, so that like reasons count as one.
fn without_numbers(text: &str) -> String {
    let mut out = String::new();
    let mut last = ' ';
    for c in text.chars() {
        let is_number = c.is_ascii_digit()
            || ".-".contains(c) && (last == '#' || c == '-' && last == ' ')
            || c == 'e' && last == '#';
        if is_number {
            if last != '#' {
                out.push('#');
            }
            last = '#';
        } else {
            out.push(c);
            last = c;
        }
    }
    out
}
