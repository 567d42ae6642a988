//! A report for people: short, aligned.

use std::fmt::Write;

use super::table::table;
use crate::report::{EstimateReport, EventLine, RecordingReport};

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
        "{}: {}{}\n",
        report.recording,
        coloured(estimate.verdict, style),
        gravest.unwrap_or_default()
    );
    let mut line = |words: String| {
        text.push_str("  ");
        text.push_str(words.trim_end());
        text.push('\n');
    };
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

fn events(report: &EstimateReport) -> String {
    let rows: Vec<Vec<String>> = report
        .events
        .iter()
        .map(|event| {
            vec![
                event.name.clone(),
                event.kind.to_owned(),
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
        + &inferred(report)
        + &largest_gaps(report)
}

/// How certain an event's time is.
fn deviation(event: &EventLine) -> String {
    match event.time_sd_s {
        Some(sd_s) => deviation_ms(sd_s),
        None if !event.time_is_determined => "undetermined".into(),
        None => "fixed".into(),
    }
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
    format!("  inferred  {}\n", words.join(", "))
}

/// The largest gap of each kind, with the event where it is.
fn largest_gaps(report: &EstimateReport) -> String {
    type Kind = (fn(&EventLine) -> f64, fn(f64) -> String);
    let kinds: [Kind; 4] = [
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
    format!("  largest gaps  {}\n", words.join(", "))
}

fn segments(report: &EstimateReport) -> String {
    let rows: Vec<Vec<String>> = report
        .segments
        .iter()
        .map(|segment| {
            vec![
                segment.body.clone(),
                seconds(segment.start_s),
                seconds(segment.end_s),
                segment.samples.to_string(),
                format!("{:.2} mm", segment.residual_mm),
                format!("{:.2}°", segment.residual_deg),
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

fn parameters(report: &EstimateReport) -> String {
    let rows: Vec<Vec<String>> = report
        .parameters
        .0
        .iter()
        .map(|(name, parameter)| {
            // Radians are for machines.
            let (factor, unit) = match parameter.unit {
                "rad" => (1f64.to_degrees(), "°"),
                other => (1.0, other),
            };
            let [lower, upper] = parameter.bounds.map(|bound| bound * factor);
            let decimals = decimals(parameter.sd.map(|sd| sd * factor));
            vec![
                name.clone(),
                format!("{:.decimals$}", parameter.value * factor),
                parameter.sd.map_or_else(
                    || "undetermined".into(),
                    |sd| format!("± {:.decimals$}", sd * factor),
                ),
                unit.to_owned(),
                format!("[{}, {}]", bound(lower), bound(upper)),
            ]
        })
        .collect();
    let mut text = String::new();
    if !rows.is_empty() {
        text = table("  ", &["parameter", "value", "", "", "bounds"], &rows);
    }
    if !report.undetermined.is_empty() {
        let _ = writeln!(
            text,
            "  not determined by the performance: {}",
            report.undetermined.join(", ")
        );
    }
    text
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
    let rounds = estimate.counters.assignment_rounds;
    if rounds > 0 {
        let plural = if rounds == 1 { "" } else { "s" };
        let _ = write!(text, ", {rounds} round{plural} of assignment");
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
    let _ = writeln!(text, "  written   {}", report.output);
    text
}

/// What independent checks found, and how the motion goes on.
fn checks(report: &EstimateReport) -> String {
    let mut text = String::new();
    if let Some(checked) = &report.verification {
        let overlap = match &checked.deepest {
            Some(deepest) => format!(
                "{} is {} inside {} at {}",
                deepest.body,
                length(deepest.depth_m),
                deepest.against,
                seconds(deepest.time_s)
            ),
            None => format!("no overlap beyond {}", length(checked.tolerance_m)),
        };
        let _ = write!(text, "  checked   {overlap}");
        for wrong in &checked.wrong_features {
            let _ = write!(
                text,
                "; at {} {} leads {} by {}",
                wrong.event,
                wrong.found.as_deref().unwrap_or("an unnamed part"),
                wrong.expected.join(", "),
                length(wrong.lead_m)
            );
        }
        if checked.simplified_m > checked.tolerance_m {
            let deep = length(checked.simplified_m);
            let _ = write!(text, "; about touching features shapes go {deep} deeper");
        }
        text.push('\n');
        if let Some(shot) = &checked.single_shot {
            let _ = write!(
                text,
                "            simulated from its first state it ends within {}, {}",
                length(shot.position_m),
                angle(shot.orientation_rad)
            );
            if !checked.restarts.is_empty() {
                let _ = write!(text, ", begun anew after {}", checked.restarts.join(", "));
            }
            text.push('\n');
        }
    }
    if let Some(settled) = &report.settled {
        let took = seconds(settled.end_s - settled.from_s);
        let _ = if settled.at_rest {
            writeln!(
                text,
                "  settled   at rest {took} after the end, by simulation"
            )
        } else {
            writeln!(
                text,
                "  settled   still moving {took} after the end, by simulation"
            )
        };
    }
    text
}

/// Decimals that show two digits of a standard deviation, from none to eight.
fn decimals(sd: Option<f64>) -> usize {
    match sd {
        // Rounded down, log₁₀ is where the first digit stands.
        Some(sd) if sd > 0.0 && sd < 10.0 => (1.0 - sd.log10().floor()).min(8.0) as usize,
        Some(sd) if sd >= 10.0 => 0,
        _ => 4,
    }
}

fn deviation_ms(sd_s: f64) -> String {
    if sd_s < 5e-5 {
        "± < 0.1 ms".into()
    } else {
        format!("± {:.1} ms", sd_s * 1e3)
    }
}

fn seconds(seconds: f64) -> String {
    format!("{seconds:.3} s")
}

fn duration(seconds: f64) -> String {
    if seconds < 1.0 {
        format!("{:.2} ms", seconds * 1e3)
    } else {
        format!("{seconds:.2} s")
    }
}

fn length(m: f64) -> String {
    if m < 1e-6 {
        "< 1 µm".into()
    } else if m < 1e-3 {
        format!("{:.0} µm", m * 1e6)
    } else {
        format!("{:.1} mm", m * 1e3)
    }
}

fn angle(rad: f64) -> String {
    let degrees = rad.to_degrees();
    if degrees < 1e-3 {
        "< 0.001°".into()
    } else {
        format!("{degrees:.3}°")
    }
}

fn bound(value: f64) -> String {
    match value {
        f64::INFINITY => "∞".into(),
        f64::NEG_INFINITY => "-∞".into(),
        _ => format!("{value:.4}")
            .trim_end_matches('0')
            .trim_end_matches('.')
            .to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_digits_of_a_deviation_are_shown() {
        for (sd, expected) in [
            (Some(0.0213), 3),
            (Some(0.1), 2),
            (Some(2.5), 1),
            (Some(37.0), 0),
            (Some(1e-30), 8),
            (Some(0.0), 4),
            (Some(f64::NAN), 4),
            (None, 4),
        ] {
            assert_eq!(decimals(sd), expected, "{sd:?}");
        }
    }

    #[test]
    fn gaps_have_units_for_people() {
        assert_eq!(length(3e-9), "< 1 µm");
        assert_eq!(length(4.2e-5), "42 µm");
        assert_eq!(length(0.0394), "39.4 mm");
        assert_eq!(angle(0.1), "5.730°");
        assert_eq!(bound(f64::NEG_INFINITY), "-∞");
        assert_eq!(bound(-12.0), "-12");
        assert_eq!(bound(0.25), "0.25");
    }
}
