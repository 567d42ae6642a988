//! `fit`: one answer from many takes.

use super::arguments::{FitArguments, Format};
use super::exit::Exit;
use super::output::{self, Account};
use super::process::print_failure;
use super::table::table;
use crate::report::units::{bound, decimals, for_people};
use crate::report::{FitTakeLine, FittedLine};
use crate::service::{
    self, FitInput, FitJob, FitQuestion, FitStop, FittedTakes, JoinedBlocks, ReduceJob,
    ReducedLine, SolveJob,
};

/// Takes of a kind that are listed.
const TOLD: usize = 12;

pub(super) fn run(arguments: FitArguments) -> anyhow::Result<Exit> {
    let said = Account::new(arguments.format, arguments.output.as_deref());
    let names = match &arguments.solve {
        Some(folder) => folder.display().to_string(),
        None => format!("{} takes", arguments.inputs.len()),
    };
    match done(arguments, &said) {
        Ok(exit) => Ok(exit),
        Err(error) => {
            print_failure(&names, &error, said.of_failure())?;
            Ok(Exit::Error)
        }
    }
}

fn done(arguments: FitArguments, said: &Account) -> anyhow::Result<Exit> {
    if let Some(folder) = arguments.reduce {
        let reduced = service::reduce_files(&ReduceJob {
            inputs: service::recordings_in(&arguments.inputs)?,
            scene: arguments.scene,
            shared: arguments.shared,
            drawn: arguments.drawn,
            folder,
        })?;
        said.print("enact.fit_reduced/1", &reduced, |_| reduced_text(&reduced))?;
        return Ok(match reduced.silent.is_empty() {
            true => Exit::Done,
            false => Exit::NotWhole,
        });
    }
    let format = arguments.format;
    let fitted = match arguments.solve {
        Some(folder) => {
            let joined = service::solve_files(&SolveJob {
                folder,
                output: arguments.output,
                page: arguments.page,
            })?;
            match joined {
                JoinedBlocks::Fitted(fitted) => *fitted,
                JoinedBlocks::Asks(question) => {
                    said.print("enact.fit_question/1", &question, |_| {
                        question_text(&question)
                    })?;
                    return Ok(Exit::Done);
                }
            }
        }
        None => service::fit(&FitJob {
            inputs: service::recordings_in(&arguments.inputs)?
                .into_iter()
                .map(FitInput::File)
                .collect(),
            scene: arguments.scene,
            shared: arguments.shared,
            drawn: arguments.drawn,
            hold_out: arguments.hold_out,
            output: arguments.output,
            page: arguments.page,
            stop: FitStop::default(),
        })?,
    };
    match (format, &fitted.line.output) {
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

fn reduced_text(line: &ReducedLine) -> String {
    let mut text = String::new();
    let ReducedLine {
        round,
        made,
        present,
        not_asked,
        ..
    } = line;
    output::push_line(
        &mut text,
        format!(
            "round {round}: {made} blocks made, {present} were there, {not_asked} takes not asked"
        ),
    );
    for why in line.silent.iter().take(TOLD) {
        output::push_line(&mut text, format!("  says nothing: {why}"));
    }
    push_more(&mut text, "says nothing", line.silent.len());
    text
}

fn question_text(question: &FitQuestion) -> String {
    let mut text = String::new();
    output::push_line(
        &mut text,
        format!(
            "asks {} takes again, round {}: fit --reduce, then --solve",
            question.asked.len(),
            question.round
        ),
    );
    text
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
    push_more(text, what, takes.len());
}

/// That there are more than are listed.
fn push_more(text: &mut String, what: &str, takes: usize) {
    if takes > TOLD {
        let others = takes - TOLD;
        output::push_line(
            text,
            format!("  {what}: {others} others, which `--format ndjson` lists"),
        );
    }
}
