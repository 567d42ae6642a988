//! Events, flights and parameters, a table of each.

use crate::cli::output::push_line;
use crate::cli::table::table;
use crate::report::units::{angle, bound, decimals, deviation_ms, for_people, length, seconds};
use crate::report::{EstimateReport, EventLine};

pub(super) fn events(report: &EstimateReport) -> String {
    let rows: Vec<Vec<String>> = report
        .events
        .iter()
        .map(|event| {
            vec![
                event.name.clone(),
                event.kind.clone(),
                seconds(event.acted_s),
                seconds(event.time_s),
                deviation(event),
            ]
        })
        .collect();
    if rows.is_empty() {
        return String::new();
    }
    table("  ", &["event", "kind", "acted", "physical", ""], &rows)
        + &leanings(report)
        + &inferred(report)
        + &goals(report)
        + &largest_gaps(report)
}

/// How far the motion is from the goals that it does not meet.
fn goals(report: &EstimateReport) -> String {
    let mut text = String::new();
    for goal in report.goals.iter().filter(|goal| !goal.is_met) {
        let (factor, unit) = for_people(&goal.unit);
        let weight = goal.sd.map_or_else(String::new, |sd| {
            format!(", which weighs {:.3} {unit}", factor * sd)
        });
        let body = goal
            .body
            .as_ref()
            .map_or_else(String::new, |body| format!("{body}, "));
        push_line(
            &mut text,
            format!(
                "  goal      {}: {body}{} {:.3} {unit} off{weight}",
                goal.event,
                goal.what,
                factor * goal.distance
            ),
        );
    }
    text
}

/// How certain an event's time is.
fn deviation(event: &EventLine) -> String {
    let deviation = event
        .time_sd_s
        .map_or_else(|| event.time_is.clone(), deviation_ms);
    match event.time_at_bound.as_deref() {
        Some("lower") => format!("{deviation}, at its earliest"),
        Some(_) => format!("{deviation}, at its latest"),
        None => deviation,
    }
}

/// The guesses on which times lean, each with how much later events are with another value.
fn leanings(report: &EstimateReport) -> String {
    let mut guesses: Vec<(String, Vec<String>)> = Vec::new();
    for event in &report.events {
        let Some(on) = &event.time_leans_on else {
            continue;
        };
        let guess = format!("with {} = {}", on.quantity, on.other);
        let later = format!("{} {:+.0} ms", event.name, 1e3 * on.later_s);
        match guesses.iter_mut().find(|(known, _)| *known == guess) {
            Some((_, events)) => events.push(later),
            None => guesses.push((guess, vec![later])),
        }
    }
    let mut text = String::new();
    for (guess, events) in guesses {
        push_line(
            &mut text,
            format!("  guessed   {guess}: {}", events.join(", ")),
        );
    }
    text
}

/// What touches where the scene leaves that open.
fn inferred(report: &EstimateReport) -> String {
    let words: Vec<String> = report
        .events
        .iter()
        .filter(|event| event.contact_inferred)
        .filter_map(|event| Some(format!("{} {}", event.name, event.contact.as_ref()?)))
        .collect();
    if words.is_empty() {
        return String::new();
    }
    let mut text = String::new();
    push_line(&mut text, format!("  inferred  {}", words.join(", ")));
    for event in &report.events {
        let rivals = event.contact_rivals.iter();
        let rivals = rivals.map(|of| format!("{} ({})", of.contact, of.standing));
        let rivals: Vec<String> = rivals.collect();
        if !rivals.is_empty() {
            let rivals = rivals.join(", ");
            push_line(&mut text, format!("  or        {} {rivals}", event.name));
        }
    }
    text
}

/// The largest gap of each kind, with the event where it is.
fn largest_gaps(report: &EstimateReport) -> String {
    type GapKind = (fn(&EventLine) -> f64, fn(f64) -> String);
    let kinds: [GapKind; 4] = [
        (|e| e.gap_m, length),
        (|e| e.gap_rad, angle),
        (|e| e.gap_m_s, |v| format!("{}/s", length(v))),
        (|e| e.gap_rad_s, |w| format!("{}/s", angle(w))),
    ];
    let mut words = Vec::new();
    for (of, shown) in kinds {
        let largest = report.events.iter().max_by(|a, b| of(a).total_cmp(&of(b)));
        if let Some(event) = largest {
            let value = shown(of(event));
            words.push(if value.starts_with('<') {
                value
            } else {
                format!("{value} at {}", event.name)
            });
        }
    }
    let mut text = String::new();
    push_line(&mut text, format!("  largest gaps  {}", words.join(", ")));
    text
}

pub(super) fn segments(report: &EstimateReport) -> String {
    let rows: Vec<Vec<String>> = report
        .segments
        .iter()
        .map(|segment| {
            vec![
                match &segment.phase {
                    Some(phase) => format!("{}, {phase}", segment.body),
                    None => segment.body.clone(),
                },
                seconds(segment.start_s),
                seconds(segment.end_s),
                segment.samples.to_string(),
                segment
                    .residual_mm
                    .map_or("not seen".into(), |mm| format!("{mm:.2} mm")),
                segment
                    .residual_deg
                    .map_or("not seen".into(), |deg| format!("{deg:.2}°")),
            ]
        })
        .collect();
    if rows.is_empty() {
        return String::new();
    }
    table(
        "  ",
        &["flight", "from", "to", "samples", "residual", ""],
        &rows,
    )
}

/// The bodies in the hand, and those that tumble.
pub(super) fn held(report: &EstimateReport) -> String {
    let titles = [(false, "in the hand"), (true, "tumbles, unexplained")];
    let tables = titles.map(|(tumbles, title)| as_seen(report, tumbles, title));
    tables.concat()
}

/// What goes where it was seen.
fn as_seen(report: &EstimateReport, tumbles: bool, title: &str) -> String {
    let rows: Vec<Vec<String>> = report
        .held
        .iter()
        .filter(|held| (held.motion == "tumble") == tumbles)
        .map(|held| {
            vec![
                match &held.phase {
                    Some(phase) => format!("{}, {phase}", held.body),
                    None => format!("{}, held", held.body),
                },
                held.start_s.map_or(String::new(), seconds),
                held.end_s.map_or(String::new(), seconds),
                held.samples.to_string(),
                format!("{:.2} mm", held.noise_mm),
                format!("{:.2}°", held.noise_deg),
                held.collisions.to_string(),
                format!("{:.2} mm", held.moved_mm),
                format!("{:.2}°", held.moved_deg),
            ]
        })
        .collect();
    if rows.is_empty() {
        return String::new();
    }
    let columns = [
        title, "from", "to", "samples", "noise", "", "events", "moved", "",
    ];
    table("  ", &columns, &rows)
}

pub(super) fn parameters(report: &EstimateReport) -> String {
    let rows: Vec<Vec<String>> = report
        .parameters
        .0
        .iter()
        .map(|(name, parameter)| {
            let (factor, unit) = for_people(&parameter.unit);
            let [lower, upper] = parameter.bounds.map(|bound| bound * factor);
            let decimals = decimals(parameter.sd.map(|sd| sd * factor));
            vec![
                name.clone(),
                format!("{:.decimals$}", parameter.value * factor),
                match parameter.sd {
                    Some(sd) => format!("± {:.decimals$}", sd * factor),
                    None if report.undetermined.contains(name) => "undetermined".into(),
                    None => "not computed".into(),
                },
                unit.to_owned(),
                format!(
                    "[{}, {}]{}",
                    bound(lower),
                    bound(upper),
                    match parameter.at_bound.as_deref() {
                        Some("cone") => ", at the end of its cone".to_owned(),
                        Some(end) => format!(", at its {end} bound"),
                        None => String::new(),
                    }
                ),
            ]
        })
        .collect();
    let mut text = String::new();
    if !rows.is_empty() {
        text = table("  ", &["parameter", "value", "", "", "bounds"], &rows);
    }
    if !report.undetermined.is_empty() {
        let names = report.undetermined.join(", ");
        push_line(
            &mut text,
            format!("  not determined by the performance: {names}"),
        );
    }
    text
}
