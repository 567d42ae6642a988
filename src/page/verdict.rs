//! What a page says at its top, and what is to blame.

use std::fmt::Write;

use super::markup::{known, likely_values, list};
use super::svg::{escaped, worded};
use crate::report::units::{deviation_ms, seconds};
use crate::report::{EstimateReport, fit_words};

/// A fact at the top: what it is of, its sign and words, and how good it is.
pub(super) fn facts(said: &EstimateReport) -> String {
    let verdict = match said.verdict.as_str() {
        "physical" => ("good", "✓", "physical"),
        "plausible" => ("fair", "≈", "plausible"),
        "failed" => ("bad", "✗", "failed"),
        other => ("fair", "?", other),
    };
    let is_told = said.is_fit_tested;
    let words = fit_words(&said.fits, is_told);
    let fit = match said.fits.as_str() {
        "yes" => ("good", "✓", words),
        "no" => ("bad", "✗", words),
        _ if is_told => ("fair", "≈", words),
        _ => ("fair", "?", words),
    };
    let determined = match said.determined {
        true => ("good", "✓", "determined"),
        false => ("fair", "?", "not all of it"),
    };
    let mut text = "<ul class=\"facts\">".to_owned();
    for (what, (class, sign, words)) in [
        ("Does it obey physics?", verdict),
        ("Does it explain the performance?", fit),
        ("Does the performance determine it?", determined),
    ] {
        let _ = write!(
            text,
            "<li class=\"{class}\"><small>{what}</small><b><span class=\"sign\" aria-hidden=\"true\">{sign}</span>{}</b></li>",
            escaped(words)
        );
    }
    let sd = said.duration.physical_sd_s.filter(|sd_s| *sd_s > 0.0);
    let _ = write!(
        text,
        "<li><small>Duration</small><b>{} {}</b> <span class=\"note\">acted in {}</span></li>",
        seconds(said.duration.physical_s),
        sd.map_or_else(String::new, |sd_s| escaped(&deviation_ms(sd_s))),
        seconds(said.acted_s)
    );
    if let Some(mm) = known(said.residual_mm).filter(|mm| *mm > 0.0) {
        let degrees = known(said.residual_deg).filter(|deg| *deg > 0.0);
        let degrees = degrees.map_or_else(String::new, |deg| format!(", {deg:.2}°"));
        let _ = write!(
            text,
            "<li><small>Distance from the samples</small><b>{mm:.2} mm{degrees}</b></li>"
        );
    }
    text + "</ul>"
}

/// Whether it fits, and who is to blame.
pub(super) fn blame(said: &EstimateReport) -> String {
    let mut lines: Vec<String> = Vec::new();
    let mut say = |tag: &str, words: &str| {
        lines.push(format!("<li><span class=\"tag\">{tag}</span> {words}</li>"));
    };
    for doubt in said.doubts.iter().filter(|of| of.best != "physical") {
        say("speaks against it", &worded(&doubt.text));
    }
    for diagnosis in &said.diagnoses {
        say("likely mistake", &worded(&diagnosis.sentence));
    }
    for freed in &said.freed {
        let percent = 100.0 * known(freed.explains).unwrap_or(0.0);
        let words = likely_values(freed);
        say(
            "freed",
            &format!("{words}: explains {percent:.0} % of the misfit"),
        );
    }
    for suspect in &said.suspects {
        let percent = 100.0 * known(suspect.explains).unwrap_or(0.0);
        let words = likely_values(suspect);
        let tag = if suspect.rivals_first {
            "or"
        } else {
            "suspect"
        };
        say(
            tag,
            &format!("{words}: would explain {percent:.0} % of the misfit"),
        );
    }
    for doubt in said.doubts.iter().filter(|of| of.best == "physical") {
        say("to know", &worded(&doubt.text));
    }
    if let Some(note) = &said.fit_note {
        say("fit", &worded(note));
    }
    if !said.not_told.is_empty() {
        say(
            "hidden",
            &format!(
                "were it wrong, samples would not tell: {}",
                list(&said.not_told)
            ),
        );
    }
    let ended = format!("<p>The estimation {}.</p>", ended(said));
    match lines.is_empty() {
        true => {
            format!("<p>Nothing speaks against the motion, the scene or the stream.</p>{ended}")
        }
        false => format!("<ul class=\"said\">{}</ul>{ended}", lines.concat()),
    }
}

fn ended(said: &EstimateReport) -> String {
    let mut words = format!(
        "ended so: {}; {} iterations",
        escaped(&said.reason),
        said.counters.iterations
    );
    if said.counters.assignment_rounds > 0 {
        let plural = if said.counters.assignment_rounds == 1 {
            ""
        } else {
            "s"
        };
        words += &format!(
            ", {} round{plural} of assignment of times",
            said.counters.assignment_rounds
        );
    }
    if said.counters.starts > 1 {
        words += &format!(", {} starts", said.counters.starts);
    }
    if let Some(objective) = known(said.objective) {
        words += &format!(", objective {objective:.6}");
    }
    words
}
