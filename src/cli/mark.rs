//! `mark`: lists, proposes and changes the marks of a recording.

use anyhow::bail;

use super::arguments::MarkArguments;
use super::exit::Exit;
use super::inspect::marks;
use super::output::{self, Account};
use super::process::print_failure;
use super::table::table;
use crate::service::{self, MarkEdits, MarkJob, Marked};

pub(super) fn run(arguments: MarkArguments) -> anyhow::Result<Exit> {
    let said = Account::new(arguments.format, arguments.output.as_deref());
    let inputs = service::recordings_in(&arguments.inputs)?;
    if inputs.len() > 1 && !arguments.propose {
        bail!(
            "{} recordings, expected one, or --propose: marks are changed one recording at a time",
            inputs.len()
        );
    }
    let outputs = match &arguments.output {
        None => vec![None; inputs.len()],
        Some(output) if inputs.len() == 1 => vec![Some(output.clone())],
        Some(folder) => {
            let outputs = service::beside_each(&inputs, folder, "mcap")?;
            outputs.into_iter().map(Some).collect()
        }
    };
    let edits = MarkEdits {
        from_file: arguments.from,
        from_topic: arguments.from_topic,
        remove: arguments.remove,
        moves: arguments.moves,
        add: arguments.add,
    };
    let mut exit = Exit::Done;
    for (input, output) in inputs.into_iter().zip(outputs) {
        let job = MarkJob {
            input,
            output,
            scene: arguments.scene.clone(),
            is_proposing: arguments.propose,
            count: arguments.count,
            edits: edits.clone(),
        };
        exit = exit.max(one(&job, said)?);
    }
    Ok(exit)
}

fn one(job: &MarkJob, said: Account) -> anyhow::Result<Exit> {
    let marked = match service::mark(job) {
        Ok(marked) => marked,
        Err(error) => {
            let recording = job.input.display().to_string();
            print_failure(&recording, &error, said.of_failure())?;
            return Ok(Exit::Error);
        }
    };
    said.print("enact.marks/1", &marked, |_| text(&marked))?;
    Ok(if marked.lost.is_empty() {
        Exit::Done
    } else {
        Exit::NotWhole
    })
}

/// What is seen besides flights, and the text that says it.
fn besides_flights(marked: &Marked) -> String {
    let mut text = String::new();
    let rows: Vec<Vec<String>> = marked
        .phases
        .iter()
        .map(|of| {
            let said = match (&of.phase, &of.reason) {
                (Some(phase), _) if of.is_said => format!("the scene says so: {phase}"),
                (Some(phase), _) => phase.clone(),
                (None, Some(reason)) => format!("no scene says so: {reason}"),
                (None, None) => "-".into(),
            };
            vec![of.seen.body.clone(), of.seen.text.clone(), said]
        })
        .collect();
    if !rows.is_empty() {
        text.push('\n');
        text += &table("  ", &["body", "seen besides flights", "phase"], &rows);
    }
    if let Some(toml) = &marked.toml {
        text += "\n  for the scene, with these marks:\n\n";
        let marks = marked.phase_marks.iter();
        let rows: Vec<Vec<String>> = marks
            .map(|mark| {
                let event = mark.event.clone().unwrap_or_default();
                vec![event, format!("{:.3} s", mark.time_s)]
            })
            .collect();
        text += &table("  ", &["event", "time"], &rows);
        text.push('\n');
        text += toml;
    }
    text
}

fn text(marked: &Marked) -> String {
    let mut text = String::new();
    output::push_line(&mut text, format!("{}: {}", marked.recording, marked.scene));
    output::push_notes(&mut text, &marked.lost, &marked.warnings);
    let or_dash = |word: &Option<String>| word.clone().unwrap_or_else(|| "-".into());
    let rows: Vec<Vec<String>> = marked
        .proposals
        .iter()
        .map(|proposal| {
            vec![
                or_dash(&proposal.event),
                format!("{:.3} s", proposal.time_s),
                proposal
                    .score
                    .map_or_else(|| "-".into(), |score| format!("{score:.1}")),
                or_dash(&proposal.body),
            ]
        })
        .collect();
    if !rows.is_empty() {
        text.push('\n');
        text += &table("  ", &["event", "time", "score", "body"], &rows);
    } else if marked.marks.is_empty() {
        text += "  no marks\n";
    } else {
        text.push('\n');
        text += &marks(&marked.marks);
    }
    text += &besides_flights(marked);
    if let Some(output) = &marked.output {
        output::push_line(&mut text, format!("  written   {output}"));
    }
    text
}
