//! Why an estimation ended, in words and in numbers.

use serde::{Deserialize, Serialize};

use crate::motion::{End, Measured, Progress, Reason, Scene};

/// Why an estimation ended, in numbers.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct TerminationLine {
    /// How it ended; see [`End`].
    pub kind: String,
    /// What decided, each value with what it may be.
    pub measured: Vec<MeasuredLine>,
    /// Names of the events or the body where it is; none where it is of the whole motion.
    pub at: Vec<String>,
    /// Physical time, where it is at one: the beginning of a flight.
    pub time_s: Option<f64>,
    /// Number of bounds after which the search over contacts ended without proof; none where it was
    /// complete, or where there was none.
    pub unproven_after_bounds: Option<usize>,
    /// Number of the solver's steps after which it ended before all starts were tried to their ends; none where they were.
    pub unfinished_after_steps: Option<usize>,
}

/// A measured value and what it may be.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct MeasuredLine {
    /// `violation` and `decrease` as in [`Progress`], `duration` of a flight.
    pub quantity: String,
    /// What it is; `null` where it is not finite.
    pub value: f64,
    /// What it may be: `violation` and `decrease` at most, `duration` at least.
    pub bound: f64,
    /// Unit of both; empty for the constraints' units and for ratios.
    pub unit: String,
}

impl TerminationLine {
    /// With the scene's names.
    pub fn new(scene: &Scene, reason: &Reason) -> Self {
        let event = |event: &usize| scene.events[*event].name.clone();
        let (at, time_s) = match &reason.end {
            End::VelocityJumps { events, .. } => (events.iter().map(event).collect(), None),
            End::EventsReversed { first, last, .. } => (vec![event(first), event(last)], None),
            End::FlightReversed {
                mechanism, start_s, ..
            } => {
                let name = scene.name_of_mechanism(*mechanism).to_owned();
                (vec![name], Some(*start_s))
            }
            End::Converged(_)
            | End::Simulated(_)
            | End::Stopped(_)
            | End::Unverified(_)
            | End::NoProgress(_)
            | End::NotFinite => (Vec::new(), None),
        };
        Self {
            kind: reason.end.as_str().to_owned(),
            measured: measured(&reason.end),
            at,
            time_s,
            unproven_after_bounds: reason.unproven_after_bounds,
            unfinished_after_steps: reason.unfinished_after_steps,
        }
    }
}

fn measured(end: &End) -> Vec<MeasuredLine> {
    let line = |quantity: &str, of: &Measured| MeasuredLine {
        quantity: quantity.to_owned(),
        value: of.value,
        bound: of.bound,
        unit: String::new(),
    };
    let duration = |value| MeasuredLine {
        quantity: "duration".to_owned(),
        value,
        bound: 0.0,
        unit: "s".to_owned(),
    };
    match end {
        End::EventsReversed { interval_s, .. } => vec![duration(*interval_s)],
        End::FlightReversed { start_s, end_s, .. } => vec![duration(end_s - start_s)],
        End::Simulated(progress) => vec![line("violation", &progress.violation)],
        _ => end.progress().map_or_else(Vec::new, |progress| {
            vec![
                line("violation", &progress.violation),
                line("decrease", &progress.decrease),
            ]
        }),
    }
}

/// Why an estimation ended, as a sentence with the scene's names.
pub fn reason_text(scene: &Scene, reason: &Reason) -> String {
    let event = |event: &usize| scene.events[*event].name.as_str();
    let text = match &reason.end {
        End::Converged(progress) => format!("converged: {}", progress_text(progress)),
        End::Simulated(progress) => format!(
            "simulated from a first state near the best: largest violation {:.1e} units",
            progress.violation.value
        ),
        End::Stopped(progress) => {
            format!("stopped before it converged: {}", progress_text(progress))
        }
        End::Unverified(progress) => format!(
            "stopped before it was verified: {}",
            progress_text(progress)
        ),
        End::NoProgress(progress) => format!("no further progress: {}", progress_text(progress)),
        End::VelocityJumps { events, progress } => {
            let events: Vec<&str> = events.iter().map(event).collect();
            format!(
                "velocities jump at {}; converged: {}",
                events.join(", "),
                progress_text(progress)
            )
        }
        End::NotFinite => "the motion is not finite".to_owned(),
        End::EventsReversed { first, last, .. } => format!(
            "`{}` would come before `{}`: relax the physics or change the order of collisions",
            event(last),
            event(first)
        ),
        End::FlightReversed {
            mechanism,
            start_s,
            end_s,
        } => format!(
            "a flight of `{}` would end at {end_s:.3} s, before it begins at {start_s:.3} s: relax \
             the physics or change the order of collisions",
            scene.name_of_mechanism(*mechanism)
        ),
    };
    let unproven = reason.unproven_after_bounds.map(|bounds| {
        format!("the search ended after {bounds} bounds: other contacts may fit better; ")
    });
    let unfinished = reason.unfinished_after_steps.map(|steps| {
        format!("the solver ended after {steps} steps: with more work another motion may be found that fits better; ")
    });
    let [unproven, unfinished] = [unproven, unfinished].map(Option::unwrap_or_default);
    unproven + &unfinished + &text
}

fn progress_text(progress: &Progress) -> String {
    format!(
        "largest violation {:.1e} units, next decrease {:.1e} of the objective",
        progress.violation.value, progress.decrease.value
    )
}
