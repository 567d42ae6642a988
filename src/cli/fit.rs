//! `fit`: one answer from many takes.

use super::arguments::{FitArguments, Format};
use super::exit::Exit;
use super::output::{self, Account};
use super::process::print_failure;
use super::table::table;
use crate::report::units::{bound, decimals, for_people};
use crate::report::{FitTakeLine, FittedLine};
use crate::service::{self, FitJob, FittedTakes};

/// Takes of a kind that are listed.
const TOLD: usize = 12;

pub(super) fn run(arguments: FitArguments) -> anyhow::Result<Exit> {
    let said = Account::new(arguments.format, arguments.output.as_deref());
    let format = arguments.format;
    let names = format!("{} takes", arguments.inputs.len());
    let job = FitJob {
        inputs: arguments.inputs,
        scene: arguments.scene,
        shared: arguments.shared,
        drawn: arguments.drawn,
        hold_out: arguments.hold_out,
        output: arguments.output,
        page: arguments.page,
    };
    let fitted = match service::fit(&job) {
        Ok(fitted) => fitted,
        Err(error) => {
            print_failure(&names, &error, said.of_failure())?;
            return Ok(Exit::Error);
        }
    };
    match (format, &job.output) {
        (Format::Ndjson, _) => {
            for take in &fitted.takes {
                said.print("enact.fit_take/1", take, |_| String::new())?;
            }
            said.print("enact.fit/1", &fitted.line, |_| String::new())?;
        }
        (Format::Text, Some(_)) => said.print("enact.fit/1", &fitted.line, |_| text(&fitted))?,
        (Format::Text, None) => {
            output::print(&fitted.toml)?;
            text(&fitted).lines().for_each(output::print_note);
        }
    }
    Ok(match fitted.line.is_whole() {
        true => Exit::Done,
        false => Exit::NotWhole,
    })
}

fn text(fitted: &FittedTakes) -> String {
    let line = &fitted.line;
    let mut text = String::new();
    output::push_line(
        &mut text,
        format!("{} takes, {} rounds", line.takes, line.rounds),
    );
    let rows: Vec<Vec<String>> = line.parameters.iter().flat_map(rows).collect();
    let heads = ["  parameter", "value", "95 %", "in the scene", "unit"];
    text += &table("", &heads, &rows);
    if let Some(held) = &line.held_out {
        output::push_line(
            &mut text,
            format!(
                "  held out  {} takes: residual {}; with the scene's own values {}; nearer in {}",
                held.takes,
                held.by_fit.words(),
                held.by_scene.words(),
                held.better
            ),
        );
    }
    for why in &line.against {
        output::push_line(&mut text, format!("  against: {why}"));
    }
    for note in &line.notes {
        output::push_line(&mut text, format!("  note: {note}"));
    }
    let left_out = fitted.takes.iter().filter(|of| of.part == "left_out");
    let left_out = left_out.filter_map(|of| Some((of, of.why.clone()?)));
    push_takes(&mut text, "no part", left_out);
    let standing = fitted.takes.iter().filter(|of| !of.stands_out.is_empty());
    let standing = standing.map(|of| (of, of.stands_out.join("; ")));
    push_takes(&mut text, "stands out", standing);
    for (name, file) in [("written", &line.output), ("page", &line.page)] {
        if let Some(file) = file {
            output::push_line(&mut text, format!("  {name:<9} {file}"));
        }
    }
    text
}

/// A parameter, and its spread where it has one.
fn rows(of: &FittedLine) -> Vec<Vec<String>> {
    let (factor, unit) = for_people(&of.unit);
    let digits = decimals(of.sd.map(|sd| sd * factor));
    let shown = |value: f64| format!("{:.digits$}", value * factor);
    let between = |ends: [f64; 2]| format!("{} to {}", shown(ends[0]), shown(ends[1]));
    let interval = match (of.interval, of.is_determined, of.is_at_bound) {
        (Some(ends), ..) => between(ends),
        (None, false, _) => "not determined".into(),
        (None, _, true) => "at its bound".into(),
        (None, ..) => "not told".into(),
    };
    let mean = if of.is_drawn { ", mean" } else { "" };
    let mut rows = vec![vec![
        format!("  {}{mean}", of.name),
        shown(of.value),
        interval,
        bound(of.in_scene * factor),
        unit.to_owned(),
    ]];
    if let Some(spread) = of.spread {
        rows.push(vec![
            format!("  {}, spread", of.name),
            shown(spread.sd),
            between(spread.interval),
            String::new(),
            unit.to_owned(),
        ]);
    }
    rows
}

fn push_takes<'a>(
    text: &mut String,
    what: &str,
    takes: impl Iterator<Item = (&'a FitTakeLine, String)>,
) {
    let takes: Vec<(&FitTakeLine, String)> = takes.collect();
    for (take, why) in takes.iter().take(TOLD) {
        output::push_line(text, format!("  {what}: {}: {why}", take.recording));
    }
    if takes.len() > TOLD {
        let others = takes.len() - TOLD;
        output::push_line(
            text,
            format!("  {what}: {others} others, which `--format ndjson` lists"),
        );
    }
}
