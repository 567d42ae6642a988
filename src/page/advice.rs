//! What to try next, by what an estimate says of itself.

use super::input::Page;
use super::markup::{known, likely_values};
use super::svg::{escaped, worded};
use crate::report::{EstimateReport, SuspectLine};

/// The most that is advised at once.
const MOST: usize = 7;

/// Why samples are left out of any performance.
const EXPECTED: [&str; 3] = ["before_start", "after_end", "near_collision"];

/// A share of samples that are left out otherwise, beyond which it is said.
const LEFT_OUT: f64 = 0.1;

/// Advice as HTML, the most urgent first.
pub(super) fn advice(page: &Page, said: &EstimateReport) -> Vec<String> {
    let mut all = Vec::new();
    if !page.lost.is_empty() {
        all.push(format!(
            "Some of the file could not be read. {} says what; estimate the recording again if it is whole.",
            code("enact inspect")
        ));
    }
    let likely = said.diagnoses.iter().take(2);
    all.extend(likely.map(|of| {
        let set = format!("{} = {}", of.key, of.value);
        format!(
            "Change what is likely mistaken: {} ({}).",
            worded(&of.sentence),
            code(&set)
        )
    }));
    if said.verdict == "failed" {
        all.push(
            "Nothing that physics allows came near. Check units, axes and the order of events first, then take \
             goals away one by one until a motion is found."
                .to_owned(),
        );
    }
    all.extend(suspicion(&said.suspects));
    if said.termination.kind == "velocity_jumps" {
        all.push(format!(
            "Physics had to be bent at {}: relax the goals there, or free restitution, friction or the tilt of \
             those contacts with {}.",
            names(&said.termination.at),
            code("[[free]]")
        ));
    }
    for wrong in said
        .verification
        .iter()
        .flat_map(|of| &of.wrong_features)
        .take(2)
    {
        all.push(format!(
            "At {} another part touches first than {}: name that part, or leave {} out and let it be inferred.",
            code(&wrong.event),
            names(&wrong.expected),
            code("feature")
        ));
    }
    if !said.undetermined.is_empty() {
        all.push(format!(
            "Nothing tells {}. What decides is a goal, a tracker that sees it, or a performance in which it \
             matters; until then the value shown is one of many.",
            names(&said.undetermined)
        ));
    }
    let at_bounds = said
        .parameters
        .0
        .iter()
        .filter(|(_, of)| of.at_bound.is_some());
    let at_bounds: Vec<String> = at_bounds.map(|(name, _)| name.clone()).collect();
    if !at_bounds.is_empty() {
        all.push(format!(
            "{} went to the end of what is allowed. Widen that if it was a guess; if it was measured, something else is off.",
            names(&at_bounds)
        ));
    }
    if let Some(bounds) = said.termination.unproven_after_bounds {
        all.push(format!(
            "The search over contacts ended after {bounds} bounds without proof: name one of the contacts that \
             you know, and it has less to search."
        ));
    }
    if let Some(steps) = said.termination.unfinished_after_steps {
        all.push(format!(
            "The solver ended after {steps} steps: act fewer events in one take, or have fewer samples a second."
        ));
    }
    let missed = said
        .rest
        .iter()
        .flat_map(|of| &of.goals)
        .filter(|of| !of.is_met);
    all.extend(missed.take(1).map(|lie| {
        format!(
            "{} does not rest with {} up: act its last turns nearer to it, or free the labels of its faces.",
            code(&lie.body),
            code(&lie.asked)
        )
    }));
    let left_out = said.samples.dropped.0.iter();
    let left_out = left_out.filter(|(reason, _)| !EXPECTED.contains(&reason.as_str()));
    let left_out = left_out.fold(0usize, |sum, (_, count)| sum.saturating_add(*count));
    if left_out as f64 > LEFT_OUT * said.samples.read as f64 {
        all.push(format!(
            "{left_out} of {} samples could not be used; at the end of this page it says why. {} shows where the \
             stream is at fault.",
            said.samples.read,
            code("enact inspect")
        ));
    }
    all.truncate(MOST);
    let file = &page.provenance.recording;
    all.push(format!(
        "Take the motion along: {} for Blender, or open the file itself in Foxglove, Lichtblick or Rerun.",
        code(&crate::report::command_line(&[
            "enact".to_owned(),
            "export".to_owned(),
            file.clone(),
            "--to".to_owned(),
            "glb".to_owned(),
            "--ghost".to_owned(),
        ]))
    ));
    all
}

/// What to do about suspects: measure, or free.
fn suspicion(suspects: &[SuspectLine]) -> Option<String> {
    let first = suspects.first()?;
    let rivals: Vec<String> = suspects[1..]
        .iter()
        .filter(|of| of.rivals_first)
        .map(|of| of.quantity.clone())
        .collect();
    let values = likely_values(first);
    let free = format!("or let {} decide", code("enact replay --free auto"));
    Some(match rivals.is_empty() {
        true => format!(
            "Measure <code>{}</code> again: {values} would explain {:.0} % of the misfit. Or free it with {}, {free}.",
            escaped(&first.quantity),
            100.0 * known(first.explains).unwrap_or(0.0),
            code("[[free]]")
        ),
        false => format!(
            "Measure <code>{}</code> ({values}) or {}: they explain the same, and the performance does not tell \
             which it is. Or free one of them with {}, {free}.",
            escaped(&first.quantity),
            names(&rivals),
            code("[[free]]")
        ),
    })
}

fn code(words: &str) -> String {
    format!("<code>{}</code>", escaped(words))
}

/// Names one after the other.
fn names(all: &[String]) -> String {
    let all: Vec<String> = all.iter().map(|name| code(name)).collect();
    all.join(", ")
}
