//! What checks found, and what became of the samples.

use super::markup::{known, list};
use super::svg::escaped;
use crate::report::EstimateReport;
use crate::report::units::{angle, length, seconds};

/// What independent checks found, how it goes on, what is in the hand, and what became of the samples.
pub(super) fn checks(said: &EstimateReport) -> String {
    let mut lines: Vec<String> = Vec::new();
    match &said.verification {
        None => lines.push("No independent checks were made.".to_owned()),
        Some(checked) => {
            lines.push(match &checked.deepest {
                None => format!(
                    "No overlap beyond {}.",
                    escaped(&length(checked.tolerance_m))
                ),
                Some(deepest) => format!(
                    "<bdi>{}</bdi> is {} inside <bdi>{}</bdi> at {}.",
                    escaped(&deepest.body),
                    escaped(&length(deepest.depth_m)),
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
                    escaped(&length(wrong.lead_m))
                )
            }));
            if let Some(shot) = &checked.single_shot {
                let [m, rad] = [
                    known(shot.position_m).map(length),
                    known(shot.orientation_rad).map(angle),
                ]
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
            if let Some(imbalance) = known(checked.imbalance) {
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
        let number = |of: f64| known(of).map_or("?".to_owned(), |of| format!("{of:.2}"));
        let does = match held.motion.as_str() {
            "tumble" => "tumbles, which nothing explains,",
            _ => "is in the hand",
        };
        let span = match (held.start_s, held.end_s) {
            (Some(from), Some(to)) => format!(" from {} to {}", seconds(from), seconds(to)),
            _ => String::new(),
        };
        format!(
            "<bdi>{}</bdi> {}{}: {} samples, smoothed, with noise of {} mm, {}°; at its {} events the motion \
             is up to {} mm, {}° from that.",
            escaped(&held.body),
            does,
            span,
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

fn samples(said: &EstimateReport) -> String {
    let of = &said.samples;
    let mut words = format!("{} samples read, {} used", of.read, of.used);
    let counted = |(reason, count): &(String, usize)| {
        format!("{count} {}", escaped(&reason.replace('_', " ")))
    };
    let dropped: Vec<String> = of.dropped.0.iter().map(counted).collect();
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
