//! A report for people: short, aligned.

mod checks;
mod tables;

use std::fmt::Write;

use crate::report::units::{deviation_ms, duration, for_people, seconds};
use checks::checks;
use tables::{events, held, parameters, segments};

use super::output::push_line;
use crate::report::{RecordingReport, SuspectLine, fit_words, hint, plain};

/// A whole that is as long as this and so many times as long as the solve is told apart \[s\], in parts of this share.
const LONG_S: f64 = 0.1;
const LONGER: f64 = 2.0;
const PART: f64 = 0.01;

/// How an account looks.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Style {
    pub(super) colours: bool,
    pub(super) verbose: bool,
}

/// The account of one finished recording.
pub(super) fn account(report: &RecordingReport, style: Style) -> String {
    let estimate = &report.estimate;
    let mut grave = estimate.doubts.iter().filter(|doubt| doubt.is_grave());
    let gravest = grave.next().map(|doubt| format!(": {}", doubt.text));
    let mut text = format!(
        "{}: {}, {}, {}{}\n",
        plain(&report.recording),
        coloured(&estimate.verdict, style),
        fit_words(&estimate.fits, estimate.is_fit_tested),
        if estimate.determined {
            "determined"
        } else {
            "not determined"
        },
        plain(&gravest.unwrap_or_default())
    );
    let mut line = |words: String| {
        text.push_str("  ");
        push_line(&mut text, words.trim_end());
    };
    for diagnosis in &estimate.diagnoses {
        line(format!("likely: {}", diagnosis.sentence));
    }
    for freed in &estimate.freed {
        line(suspect_words("freed", freed, "explains"));
    }
    for suspect in &estimate.suspects {
        let what = if suspect.rivals_first {
            "or"
        } else {
            "suspect"
        };
        line(suspect_words(what, suspect, "would explain"));
    }
    if let Some(hint) = hint(&estimate.seen_phases) {
        line(format!("hint: {hint}"));
    }
    if let Some(note) = &estimate.fit_note {
        line(format!("note: {note}"));
    }
    if style.verbose && !estimate.not_told.is_empty() {
        let names = estimate.not_told.join(", ");
        line(format!(
            "note: samples would not tell were it wrong: {names}"
        ));
    }
    for doubt in grave {
        line(format!("doubt: {}", doubt.text));
    }
    line(estimate.reason.clone());
    line(format!(
        "{}: {} acted, {} physical {}",
        estimate.scene,
        seconds(estimate.acted_s),
        seconds(estimate.duration.physical_s),
        estimate
            .duration
            .physical_sd_s
            .filter(|sd_s| *sd_s > 0.0)
            .map_or_else(String::new, deviation_ms)
    ));
    if !estimate.duration.physical_is_determined {
        let how = estimate.duration.physical_sd_s.map_or_else(
            || "nothing says how long it lasts".into(),
            |sd_s| {
                format!(
                    "{} {}",
                    seconds(estimate.duration.physical_s),
                    deviation_ms(sd_s)
                )
            },
        );
        line(format!("duration not determined: {how}"));
    }
    if report.ended_early {
        line("note: ended at its deadline with the best so far, not all was tried".to_owned());
    }
    for loss in &report.lost {
        line(format!("lost: {loss}"));
    }
    for warning in &report.warnings {
        line(format!("note: {warning}"));
    }
    for doubt in estimate.doubts.iter().filter(|doubt| !doubt.is_grave()) {
        line(format!("note: {}", doubt.text));
    }
    for block in [
        events(estimate),
        segments(estimate),
        held(estimate),
        parameters(estimate),
        summary(report, style),
    ] {
        if !block.is_empty() {
            text.push('\n');
            text.push_str(&block);
        }
    }
    text
}

/// What may be wrong, its likely value and how much of the misfit goes with it.
fn suspect_words(what: &str, suspect: &SuspectLine, explains: &str) -> String {
    let values = suspect.quantities.iter().map(|(name, value)| {
        let (factor, unit) = for_people(&suspect.unit);
        format!("{name} {:.3} {unit}", value * factor)
            .trim_end()
            .to_owned()
    });
    let values: Vec<String> = values.collect();
    format!(
        "{what}: {} {explains} {:.0} % of the misfit",
        values.join(", "),
        100.0 * suspect.explains
    )
}

fn coloured(verdict: &str, style: Style) -> String {
    let code = match verdict {
        "physical" => 32,
        "plausible" => 33,
        _ => 31,
    };
    if style.colours {
        format!("\u{1b}[{code}m{verdict}\u{1b}[0m")
    } else {
        verdict.to_owned()
    }
}

/// Where the time went, where it is much longer than the solve.
fn took(report: &RecordingReport) -> Option<String> {
    let parts = &report.spent_seconds.0;
    let whole_s: f64 = parts.iter().map(|(_, seconds)| seconds).sum();
    if whole_s < LONG_S || whole_s < LONGER * report.solve_seconds {
        return None;
    }
    let parts = parts
        .iter()
        .filter(|(_, seconds)| *seconds > PART * whole_s);
    let parts = parts.map(|(what, seconds)| format!("{what} {}", duration(*seconds)));
    let parts: Vec<String> = parts.collect();
    Some(format!("{}: {}", duration(whole_s), parts.join(", ")))
}

fn summary(report: &RecordingReport, style: Style) -> String {
    let estimate = &report.estimate;
    let samples = &estimate.samples;
    let dropped: usize = samples.dropped.0.iter().map(|(_, count)| count).sum();
    let reasons: Vec<String> = samples
        .dropped
        .0
        .iter()
        .map(|(reason, count)| format!("{count} {}", reason.replace('_', " ")))
        .collect();
    let mut text = format!("  samples   {} read, {} used", samples.read, samples.used);
    if dropped > 0 {
        let _ = write!(text, ", {dropped} dropped ({})", reasons.join(", "));
    }
    let repaired: Vec<String> = [
        (samples.reordered, "sorted in"),
        (samples.normalised, "normalised"),
        (samples.flipped, "flipped"),
    ]
    .into_iter()
    .filter(|(count, _)| *count > 0)
    .map(|(count, what)| format!("{count} {what}"))
    .collect();
    if !repaired.is_empty() {
        let _ = write!(text, "; {}", repaired.join(", "));
    }
    if samples.gaps > 0 {
        let _ = write!(text, "; {} gaps", samples.gaps);
    }
    let _ = write!(
        text,
        "\n  residual  {:.2} mm, {:.2}° over all, objective {:.6}\n  solved    in {}, {} iterations",
        estimate.residual_mm,
        estimate.residual_deg,
        estimate.objective,
        duration(report.solve_seconds),
        estimate.counters.iterations
    );
    let took = took(report);
    let rounds = estimate.counters.assignment_rounds;
    if rounds > 0 {
        let plural = if rounds == 1 { "" } else { "s" };
        let _ = write!(text, ", {rounds} round{plural} of assignment");
    }
    if let Some(took) = took {
        let _ = write!(text, "\n  took      {took}");
    }
    if style.verbose {
        for (phase, seconds) in &report.phase_seconds.0 {
            let _ = write!(
                text,
                "\n              {:<12} {:>10}",
                phase.replace('_', " "),
                duration(*seconds)
            );
        }
    }
    text.push('\n');
    text.push_str(&checks(estimate));
    push_line(&mut text, format!("  written   {}", report.output));
    text
}
