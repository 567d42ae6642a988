//! One answer from many takes as a page.

use std::fmt::Write;

use super::chart::{Chart, ChartMark};
use super::html::STYLE;
use super::markup::{shown_in, table};
use super::svg::escaped;
use super::theme;
use crate::report::units::{bound, decimals};
use crate::report::{FitLine, FitTakeLine, FittedLine, HeldOutLine, ResidualLine};

/// Takes of which each has a row, those that stand out before the others.
const ROWS: usize = 400;

/// The page, complete in itself.
pub fn fit_page(fit: &FitLine, takes: &[FitTakeLine]) -> String {
    let mut text = format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" \
         content=\"width=device-width, initial-scale=1\">\n<meta name=\"color-scheme\" content=\"light dark\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src 'unsafe-inline'\">\n\
         <title>{} takes: one answer</title>\n<style>\n{STYLE}{}</style>\n</head>\n<body>\n<main>\n\
         <p class=\"over\">One answer from many takes</p>\n<h1>{} takes</h1>\n{}\n",
        fit.takes,
        theme::style(0..=theme::IN_HAND),
        fit.takes,
        facts(fit)
    );
    let lines = fit.against.iter().map(|line| ("against", line));
    for (tag, line) in lines.chain(fit.notes.iter().map(|line| ("note", line))) {
        let line = escaped(line);
        let _ = writeln!(text, "<p><span class=\"tag\">{tag}</span> {line}</p>");
    }
    let sections = [
        ("Parameters", parameters(&fit.parameters)),
        ("Takes that were held out", held_out(fit.held_out.as_ref())),
        ("Correlations", correlations(fit)),
        ("Residuals", residuals(takes)),
        ("Takes", rows(fit, takes)),
    ];
    for (title, content) in sections.iter().filter(|(_, content)| !content.is_empty()) {
        let _ = writeln!(text, "<section>\n<h2>{title}</h2>\n{content}\n</section>");
    }
    text += "</main>\n</body>\n</html>\n";
    text
}

fn facts(fit: &FitLine) -> String {
    let fact = |class: &str, name: &str, value: String| {
        format!("<li class=\"{class}\"><small>{name}</small><b>{value}</b></li>")
    };
    let is_good = |good: bool| if good { "good" } else { "fair" };
    let mut facts = vec![
        fact("", "takes that were fitted", fit.takes.to_string()),
        fact(
            is_good(fit.left_out == 0),
            "takes that took no part",
            fit.left_out.to_string(),
        ),
        fact(
            is_good(fit.undetermined.is_empty()),
            "combinations that are not determined",
            fit.undetermined.len().to_string(),
        ),
    ];
    if let Some(held) = &fit.held_out {
        let class = if held.gain > 0.0 { "good" } else { "bad" };
        let words = format!("nearer in {} of {}", held.better, held.takes);
        facts.push(fact(class, "held out", words));
    }
    format!("<ul class=\"facts\">{}</ul>", facts.concat())
}

fn parameters(all: &[FittedLine]) -> String {
    let rows = all.iter().map(|of| {
        let (factor, unit) = shown_in(&of.unit);
        let digits = decimals(of.sd.map(|sd| sd * factor));
        let shown = |value: f64| format!("{:.digits$}", value * factor);
        let between = |ends: [f64; 2]| format!("{} to {} {unit}", shown(ends[0]), shown(ends[1]));
        let interval = match (of.interval, of.is_determined, of.is_at_bound) {
            (Some(ends), ..) => between(ends),
            (None, false, _) => "not determined".to_owned(),
            (None, _, true) => "at its bound".to_owned(),
            (None, ..) => "not told".to_owned(),
        };
        let spread = of.spread.map_or_else(String::new, |spread| {
            format!("{} {unit} ({})", shown(spread.sd), between(spread.interval))
        });
        let kind = if of.is_drawn { "mean over takes" } else { "shared" };
        format!(
            "<tr><th scope=\"row\"><bdi>{}</bdi> <span class=\"tag\">{kind}</span></th><td class=\"n\">{} {unit}</td>\
             <td>{interval}</td><td class=\"n\">{:.1}</td><td>{spread}</td><td class=\"n\">{} {unit}</td></tr>",
            escaped(&of.name),
            shown(of.value),
            of.freedom,
            escaped(&bound(of.in_scene * factor))
        )
    });
    let heads = [
        "parameter",
        "value*",
        "95 % interval",
        "degrees of freedom*",
        "spread over takes",
        "in the scene*",
    ];
    table(&heads, &rows.collect::<String>())
}

fn held_out(held: Option<&HeldOutLine>) -> String {
    let Some(held) = held else {
        return String::new();
    };
    let row = |name: &str, of: &ResidualLine| {
        format!(
            "<tr><th scope=\"row\">{name}</th><td>{}</td></tr>",
            escaped(&of.words())
        )
    };
    let rows = row("these values", &held.by_fit) + &row("the scene's own values", &held.by_scene);
    let gain = match held.gain_sd {
        Some(sd) => format!("{:.3} ± {sd:.3}", held.gain),
        None => format!("{:.3}", held.gain),
    };
    format!(
        "{}<p>These values are nearer to the samples in {} of {} takes; half the sum of squares is less by {gain} in the \
         mean. With these values alone {} takes have a motion, with the scene's own alone {}.</p>",
        table(&["with", "residual, rms per axis"], &rows),
        held.better,
        held.takes,
        held.only_by_fit,
        held.only_by_scene
    )
}

fn correlations(fit: &FitLine) -> String {
    if fit.parameters.len() < 2 {
        return String::new();
    }
    let names = fit.parameters.iter().map(|of| escaped(&of.name));
    let names: Vec<String> = names.collect();
    let heads = std::iter::once("parameter".to_owned());
    let heads: Vec<String> = heads
        .chain(names.iter().map(|of| format!("{of}*")))
        .collect();
    let heads: Vec<&str> = heads.iter().map(String::as_str).collect();
    let rows = names.iter().zip(&fit.correlations).map(|(name, row)| {
        let cells = row
            .iter()
            .map(|of| format!("<td class=\"n\">{of:+.2}</td>"));
        let cells = cells.collect::<String>();
        format!("<tr><th scope=\"row\"><bdi>{name}</bdi></th>{cells}</tr>")
    });
    table(&heads, &rows.collect::<String>())
}

/// Residuals of positions take by take.
fn residuals(takes: &[FitTakeLine]) -> String {
    let points = takes.iter().enumerate().filter_map(|(at, of)| {
        let residual_m = of.residual?.position_m?;
        Some([(at + 1) as f64, residual_m * 1e3])
    });
    let points: Vec<[f64; 2]> = points.collect();
    let most = points.iter().map(|[_, y]| *y).fold(0.0, f64::max);
    if points.len() < 2 || !(most > 0.0) {
        return String::new();
    }
    let chart = Chart {
        size_px: [680.0, 220.0],
        across: [0.0, (takes.len() + 1) as f64],
        up: [0.0, 1.1 * most],
        axes: ["take, in the order of the inputs", "mm"],
        label: "Residual of positions, take by take".to_owned(),
        marks: vec![ChartMark::Series {
            points,
            classes: ["no".to_owned(), "gp".to_owned()],
        }],
    };
    format!("<div class=\"chart\">{}</div>", chart.element())
}

fn rows(fit: &FitLine, takes: &[FitTakeLine]) -> String {
    let mut order: Vec<&FitTakeLine> = takes.iter().collect();
    order.sort_by_key(|of| {
        (
            of.stands_out.is_empty() && of.why.is_none(),
            of.part == "left_alone",
        )
    });
    let units: Vec<(&str, &str)> = fit
        .parameters
        .iter()
        .map(|of| (of.name.as_str(), of.unit.as_str()))
        .collect();
    let row = |of: &&FitTakeLine| {
        let own = units.iter().filter_map(|(name, unit)| {
            let own = of.own.get(*name)?;
            let (factor, unit) = shown_in(unit);
            let digits = decimals(Some(own.sd * factor));
            Some(format!(
                "<bdi>{}</bdi> {:.digits$} ± {:.digits$} {unit}",
                escaped(name),
                own.value * factor,
                own.sd * factor
            ))
        });
        let own = own.collect::<Vec<_>>().join("<br>");
        let influence = of.most_influence.as_ref().map_or_else(String::new, |most| {
            format!(
                "{:.2} of <bdi>{}</bdi>",
                most.times,
                escaped(&most.parameter)
            )
        });
        let why = of.why.iter().chain(&of.stands_out).chain(&of.notes);
        let why: Vec<String> = why.map(|line| escaped(line)).collect();
        let residual = of
            .residual
            .map_or_else(String::new, |of| escaped(&of.words()));
        let score = of
            .score
            .map_or_else(String::new, |score| format!("{score:.1}"));
        format!(
            "<tr><th scope=\"row\"><bdi>{}</bdi> <span class=\"tag\">{}</span></th><td>{residual}</td><td>{own}</td>\
             <td>{influence}</td><td class=\"n\">{score}</td><td>{}</td></tr>",
            escaped(&of.recording),
            escaped(&of.part.replace('_', " ")),
            why.join("<br>")
        )
    };
    let rows: String = order.iter().take(ROWS).map(row).collect();
    let heads = [
        "take",
        "residual",
        "by itself",
        "influence, in standard deviations",
        "how far off*",
        "what is said of it",
    ];
    let mut text = table(&heads, &rows);
    if order.len() > ROWS {
        let others = order.len() - ROWS;
        let _ = write!(text, "<p>{others} others have nothing against them.</p>");
    }
    text
}
