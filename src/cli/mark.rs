//! `mark`: proposes marks for a recording.

use super::arguments::{Format, MarkArguments};
use super::exit::Exit;
use super::output::{self, printable};
use super::process::print_failure;
use super::table::table;
use crate::service::{self, MarkJob, Marked};

pub(super) fn run(arguments: MarkArguments) -> anyhow::Result<Exit> {
    let recording = arguments.input.display().to_string();
    let job = MarkJob {
        input: arguments.input,
        output: arguments.output,
        scene: arguments.scene,
        count: arguments.count,
    };
    let marked = match service::mark(&job) {
        Ok(marked) => marked,
        Err(error) => {
            print_failure(&recording, &error, arguments.format)?;
            return Ok(Exit::Error);
        }
    };
    match arguments.format {
        Format::Ndjson => output::print_json(&marked)?,
        Format::Text => output::print(&text(&marked))?,
    }
    Ok(if marked.lost.is_empty() {
        Exit::Done
    } else {
        Exit::NotWhole
    })
}

fn text(marked: &Marked) -> String {
    let mut text = format!(
        "{}: {}\n",
        printable(&marked.recording),
        printable(&marked.scene)
    );
    for loss in &marked.lost {
        text += &format!("  lost: {}\n", printable(loss));
    }
    for warning in &marked.warnings {
        text += &format!("  note: {}\n", printable(warning));
    }
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
    text.push('\n');
    text += &table("  ", &["event", "time", "score", "body"], &rows);
    if let Some(output) = &marked.output {
        text += &format!("  written   {}\n", printable(output));
    }
    text
}
