//! Events and goals as tables.

use std::fmt::Write;

use super::markup::{known, shown_in, table};
use super::svg::escaped;
use crate::report::units::{angle, deviation_ms, length, seconds};
use crate::report::{EstimateReport, EventLine};

/// Events with their times and gaps, and goals.
pub(super) fn events(said: &EstimateReport) -> String {
    if said.events.is_empty() {
        return "<p>The scene has no events.</p>".to_owned();
    }
    let mut rows = String::new();
    for event in &said.events {
        let contact = event.contact.as_ref().map_or_else(String::new, |contact| {
            let inferred = if event.contact_inferred {
                " <span class=\"tag\">inferred</span>"
            } else {
                ""
            };
            let rivals = event.contact_rivals.iter().map(|of| {
                let [contact, standing] = [&of.contact, &of.standing].map(|of| escaped(of));
                format!("<br>or <bdi>{contact}</bdi> ({standing})")
            });
            let rivals: String = rivals.collect();
            format!(
                "<br><span class=\"note\"><bdi>{}</bdi>{inferred}{rivals}</span>",
                escaped(contact)
            )
        });
        let _ = write!(
            rows,
            "<tr><th scope=\"row\"><bdi>{}</bdi>{contact}</th><td>{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td>\
             <td>{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td></tr>",
            escaped(&event.name),
            escaped(&event.kind),
            seconds(event.acted_s),
            seconds(event.time_s),
            deviation(event),
            gaps([
                known(event.gap_m).map(length),
                known(event.gap_rad).map(angle)
            ]),
            gaps([
                known(event.gap_m_s).map(|of| format!("{}/s", length(of))),
                known(event.gap_rad_s).map(|of| format!("{}/s", angle(of))),
            ])
        );
    }
    let table = table(
        &[
            "event",
            "kind",
            "acted*",
            "physical*",
            "",
            "gap of the pose*",
            "gap of the velocity*",
        ],
        &rows,
    );
    table + &goals(said)
}

fn deviation(event: &EventLine) -> String {
    let words = event.time_sd_s.map_or_else(
        || escaped(&event.time_is),
        |sd_s| escaped(&deviation_ms(sd_s)),
    );
    match event.time_at_bound.as_deref() {
        Some("lower") => words + ", at its earliest",
        Some(_) => words + ", at its latest",
        None => words,
    }
}

fn gaps(gaps: [Option<String>; 2]) -> String {
    let gaps: Vec<String> = gaps.into_iter().flatten().map(|of| escaped(&of)).collect();
    gaps.join("<br>")
}

fn goals(said: &EstimateReport) -> String {
    let mut rows = String::new();
    for goal in &said.goals {
        let (factor, unit) = shown_in(&goal.unit);
        let off = match (goal.is_met, known(goal.distance)) {
            (true, _) if goal.binds => "met, and binds".to_owned(),
            (true, _) => "met".to_owned(),
            (false, Some(distance)) => format!("{:.3} {unit} off", distance * factor),
            (false, None) => "not met".to_owned(),
        };
        let sign = if goal.is_met { "✓" } else { "✗" };
        let kind = goal.sd.map_or_else(
            || "hard".to_owned(),
            |sd| format!("weighs {:.3} {unit}", sd * factor),
        );
        let body = goal.body.as_deref().unwrap_or_default();
        let _ = write!(
            rows,
            "<tr><th scope=\"row\"><bdi>{}</bdi></th><td><bdi>{}</bdi></td><td>{}</td><td>{kind}</td><td>{sign} {off}</td></tr>",
            escaped(&goal.event),
            escaped(body),
            escaped(&goal.what)
        );
    }
    match rows.is_empty() {
        true => String::new(),
        false => format!(
            "<h3>Goals</h3>{}",
            table(&["at", "body", "what", "how", "is it met"], &rows)
        ),
    }
}
