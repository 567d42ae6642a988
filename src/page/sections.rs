//! The parts of a page that are words and tables.

use std::fmt::Write;

use super::said::{Event, Parameter, Said};
use super::svg::{escaped, px, worded};
use crate::report::units::{angle, bound, decimals, deviation_ms, for_people, length, seconds};

/// A standard normal deviate is within so many deviations with a probability of 95 %.
const INTERVAL: f64 = 1.96;

/// A fact at the top: what it is of, its sign and words, and how good it is.
pub(super) fn facts(said: &Said) -> String {
    let verdict = match said.verdict.as_str() {
        "physical" => ("good", "✓", "physical"),
        "plausible" => ("fair", "≈", "plausible"),
        "failed" => ("bad", "✗", "failed"),
        other => ("fair", "?", other),
    };
    let fit = match said.fits.as_str() {
        "yes" => ("good", "✓", "fits well"),
        "no" => ("bad", "✗", "does not fit"),
        _ => match said.fit_tested {
            Some(true) => ("fair", "≈", "off beyond the noise"),
            Some(false) => ("fair", "?", "fit not told"),
            None => ("fair", "?", "fit not known"),
        },
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
    let sd = said.physical_sd_s.filter(|sd_s| *sd_s > 0.0);
    let _ = write!(
        text,
        "<li><small>Duration</small><b>{} {}</b> <span class=\"note\">acted in {}</span></li>",
        seconds(said.physical_s),
        sd.map_or_else(String::new, deviation_ms),
        seconds(said.acted_s)
    );
    if let Some(mm) = said.residual_mm.filter(|mm| *mm > 0.0) {
        let degrees = said.residual_deg.filter(|deg| *deg > 0.0);
        let degrees = degrees.map_or_else(String::new, |deg| format!(", {deg:.2}°"));
        let _ = write!(
            text,
            "<li><small>Distance from the samples</small><b>{mm:.2} mm{degrees}</b></li>"
        );
    }
    text + "</ul>"
}

/// Whether it fits, and who is to blame.
pub(super) fn blame(said: &Said) -> String {
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
        let percent = 100.0 * freed.explains.unwrap_or(0.0);
        let words = freed.words();
        say(
            "freed",
            &format!("{words}: explains {percent:.0} % of the misfit"),
        );
    }
    for suspect in &said.suspects {
        let percent = 100.0 * suspect.explains.unwrap_or(0.0);
        let words = suspect.words();
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

fn ended(said: &Said) -> String {
    let mut words = format!(
        "ended so: {}; {} iterations",
        escaped(&said.reason),
        said.iterations
    );
    if said.assignment_rounds > 0 {
        let plural = if said.assignment_rounds == 1 { "" } else { "s" };
        words += &format!(
            ", {} round{plural} of assignment of times",
            said.assignment_rounds
        );
    }
    if said.starts > 1 {
        words += &format!(", {} starts", said.starts);
    }
    if let Some(objective) = said.objective {
        words += &format!(", objective {objective:.6}");
    }
    words
}

/// Events with their times and gaps, and goals.
pub(super) fn events(said: &Said) -> String {
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
            format!(
                "<br><span class=\"note\"><bdi>{}</bdi>{inferred}</span>",
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
            gaps([event.gap_m.map(length), event.gap_rad.map(angle)]),
            gaps([
                event.gap_m_s.map(|of| format!("{}/s", length(of))),
                event.gap_rad_s.map(|of| format!("{}/s", angle(of))),
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

fn deviation(event: &Event) -> String {
    let words = event
        .time_sd_s
        .map_or_else(|| escaped(&event.time_is), deviation_ms);
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

fn goals(said: &Said) -> String {
    let mut rows = String::new();
    for goal in &said.goals {
        let (factor, unit) = for_people(&goal.unit);
        let off = match (goal.is_met, goal.distance) {
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

/// Free parameters with their intervals, and what was not determined.
pub(super) fn parameters(said: &Said) -> String {
    let mut rows = String::new();
    for (name, of) in &said.parameters {
        let (factor, unit) = for_people(&of.unit);
        let digits = decimals(of.sd.map(|sd| sd * factor));
        let value = of
            .value
            .map_or("?".to_owned(), |v| format!("{:.digits$}", v * factor));
        let interval = match (of.value, of.sd) {
            (Some(value), Some(sd)) => format!(
                "{:.digits$} to {:.digits$}",
                (value - INTERVAL * sd) * factor,
                (value + INTERVAL * sd) * factor
            ),
            _ if said.undetermined.contains(name) => "undetermined".to_owned(),
            _ => "not computed".to_owned(),
        };
        let ends = [
            of.bounds[0].unwrap_or(f64::NEG_INFINITY),
            of.bounds[1].unwrap_or(f64::INFINITY),
        ]
        .map(|end| escaped(&bound(end * factor)));
        let at_bound = match of.at_bound.as_deref() {
            Some("cone") => " <span class=\"tag\">at the end of its cone</span>".to_owned(),
            Some(end) => format!(" <span class=\"tag\">at its {} bound</span>", escaped(end)),
            None => String::new(),
        };
        let _ = write!(
            rows,
            "<tr><th scope=\"row\"><bdi>{}</bdi></th><td class=\"n\">{value} {unit}</td><td>{interval} {unit}</td>\
             <td class=\"bar\">{}</td><td>{} to {} {unit}{at_bound}</td></tr>",
            escaped(name),
            bar(name, of),
            ends[0],
            ends[1]
        );
    }
    let mut text = match rows.is_empty() {
        true => "<p>The scene leaves nothing free.</p>".to_owned(),
        false => table(
            &[
                "parameter",
                "value*",
                "95 % interval",
                "within its bounds",
                "bounds",
            ],
            &rows,
        ),
    };
    text += "<h3>What the performance does not determine</h3>";
    text += &match said.undetermined.is_empty() {
        true => "<p>Nothing: everything that was asked is determined.</p>".to_owned(),
        false => format!("<p>{}.</p>", list(&said.undetermined)),
    };
    if !said.physical_is_determined {
        text += &said.physical_sd_s.map_or_else(
            || "<p>Nothing says how long the motion lasts.</p>".to_owned(),
            |sd_s| {
                format!(
                    "<p>The duration is known to {} only.</p>",
                    deviation_ms(sd_s)
                )
            },
        );
    }
    text
}

/// A value with its interval between its bounds, or about itself where it has none.
fn bar(name: &str, of: &Parameter) -> String {
    let Some(value) = of.value else {
        return String::new();
    };
    let half = INTERVAL * of.sd.unwrap_or(0.0);
    let [from, to] = match of.bounds {
        [Some(from), Some(to)] if to > from => [from, to],
        _ => [value - 1.6 * half, value + 1.6 * half],
    };
    if !(to > from && half.is_finite()) {
        return String::new();
    }
    let (factor, unit) = for_people(&of.unit);
    let at = |value: f64| 4.0 + 162.0 * ((value - from) / (to - from)).clamp(0.0, 1.0);
    let [left, middle, right] = [value - half, value, value + half].map(at);
    let label = format!(
        "{name}: {:.4} {unit}, ± {:.4} {unit}, drawn from {:.4} to {:.4}",
        value * factor,
        half * factor,
        from * factor,
        to * factor
    );
    format!(
        "<svg viewBox=\"0 0 170 20\" role=\"img\" aria-label=\"{}\"><path class=\"ax\" d=\"M4 10H166M4 6V14M166 6V14\"/>\
         <path class=\"gl\" style=\"stroke-dasharray:none\" stroke-width=\"5\" stroke-opacity=\".35\" d=\"M{} 10H{}\"/>\
         <circle class=\"gp\" cx=\"{}\" cy=\"10\" r=\"4\"/></svg>",
        escaped(&label),
        px(left),
        px(right),
        px(middle)
    )
}

/// What independent checks found, how it goes on, what is in the hand, and what became of the samples.
pub(super) fn checks(said: &Said) -> String {
    let mut lines: Vec<String> = Vec::new();
    match &said.verification {
        None => lines.push("No independent checks were made.".to_owned()),
        Some(checked) => {
            lines.push(match &checked.deepest {
                None => format!("No overlap beyond {}.", length(checked.tolerance_m)),
                Some(deepest) => format!(
                    "<bdi>{}</bdi> is {} inside <bdi>{}</bdi> at {}.",
                    escaped(&deepest.body),
                    length(deepest.depth_m),
                    escaped(&deepest.against),
                    seconds(deepest.time_s)
                ),
            });
            lines.extend(checked.wrong_features.iter().map(|wrong| {
                format!(
                    "At <bdi>{}</bdi> {} leads {} by {}.",
                    escaped(&wrong.event),
                    escaped(wrong.found.as_deref().unwrap_or("an unnamed part")),
                    list(&wrong.expected),
                    length(wrong.lead_m)
                )
            }));
            if let Some(shot) = &checked.single_shot {
                let [m, rad] = [shot.position_m.map(length), shot.orientation_rad.map(angle)]
                    .map(|of| of.map_or("?".to_owned(), |words| escaped(&words)));
                let anew = match checked.restarts.is_empty() {
                    true => String::new(),
                    false => format!(", begun anew after {}", list(&checked.restarts)),
                };
                lines.push(format!(
                    "Simulated from its first state it ends within {m}, {rad}{anew}."
                ));
            }
            if !checked.missed.is_empty() {
                let missed = list(&checked.missed);
                lines.push(format!("That simulation did not find {missed}."));
            }
            if let Some(imbalance) = checked.imbalance {
                lines.push(format!(
                    "Energy and momentum are kept to a part of {imbalance:.0e}, beside what impacts take."
                ));
            }
        }
    }
    if let Some(settled) = &said.settled {
        let how = if settled.at_rest {
            "At rest"
        } else {
            "Still moving"
        };
        lines.push(format!(
            "{how} {} after its end, by simulation.",
            seconds(settled.end_s - settled.from_s)
        ));
    }
    if let Some(rest) = &said.rest {
        lines.extend(rest.goals.iter().map(|lie| {
            let found = match (lie.is_met, lie.is_still) {
                (true, _) => "as asked".to_owned(),
                (false, true) => format!("instead {} is", escaped(&lie.face_up)),
                (false, false) => "it is not at rest".to_owned(),
            };
            format!(
                "<bdi>{}</bdi> with {} up: {found}.",
                escaped(&lie.body),
                escaped(&lie.asked)
            )
        }));
        if rest.tried > 0 {
            lines.push(format!(
                "{} motions near the best were tried for that.",
                rest.tried
            ));
        }
    }
    lines.extend(said.held.iter().map(|held| {
        let number = |of: Option<f64>| of.map_or("?".to_owned(), |of| format!("{of:.2}"));
        format!(
            "<bdi>{}</bdi> is in the hand: {} samples, smoothed, with noise of {} mm, {}°; at its {} collisions the motion \
             is up to {} mm, {}° from that.",
            escaped(&held.body),
            held.samples,
            number(held.noise_mm),
            number(held.noise_deg),
            held.collisions,
            number(held.moved_mm),
            number(held.moved_deg)
        )
    }));
    lines.push(samples(said));
    let lines = lines.iter().map(|line| format!("<li>{line}</li>"));
    format!("<ul class=\"said\">{}</ul>", lines.collect::<String>())
}

fn samples(said: &Said) -> String {
    let of = &said.samples;
    let mut words = format!("{} samples read, {} used", of.read, of.used);
    let counted =
        |(reason, count): &(String, u64)| format!("{count} {}", escaped(&reason.replace('_', " ")));
    let dropped: Vec<String> = of.dropped.iter().map(counted).collect();
    if !dropped.is_empty() {
        words += &format!("; left out: {}", dropped.join(", "));
    }
    for (count, what) in [
        (of.reordered, "sorted in"),
        (of.normalised, "normalised"),
        (of.flipped, "flipped in sign"),
        (of.gaps, "gaps"),
    ] {
        if count > 0 {
            words += &format!("; {count} {what}");
        }
    }
    words + "."
}

/// A table; columns whose name ends with `*` are numbers.
fn table(columns: &[&str], rows: &str) -> String {
    let heads = columns.iter().map(|name| match name.strip_suffix('*') {
        Some(name) => format!("<th scope=\"col\" class=\"n\">{name}</th>"),
        None => format!("<th scope=\"col\">{name}</th>"),
    });
    format!(
        "<div class=\"scroll\" tabindex=\"0\"><table><thead><tr>{}</tr></thead><tbody>{rows}</tbody></table></div>",
        heads.collect::<String>()
    )
}

/// Names one after the other.
fn list(names: &[String]) -> String {
    let names = names
        .iter()
        .map(|name| format!("<bdi>{}</bdi>", escaped(name)));
    names.collect::<Vec<_>>().join(", ")
}
