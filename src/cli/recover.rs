//! `recover`: makes recordings of journals that a crash left.

use super::arguments::{Format, RecoverArguments};
use super::exit::Exit;
use super::output::{self, printable};
use super::process::print_failure;
use crate::service::{RecoveredLine, recover_all};

/// Greatest number of unread ranges in the text output; JSON has all.
const SHOWN: usize = 16;

pub(super) fn run(arguments: RecoverArguments) -> anyhow::Result<Exit> {
    let mut exit = Exit::Done;
    let mut count = 0;
    recover_all(&arguments.paths, |journal, result| {
        count += 1;
        match result {
            Ok(line) => {
                match arguments.format {
                    Format::Ndjson => output::print_json(&line)?,
                    Format::Text => output::print(&text(&line))?,
                }
                if !line.whole {
                    exit = exit.max(Exit::NotWhole);
                }
            }
            Err(error) => {
                print_failure(&journal.display().to_string(), &error, arguments.format)?;
                exit = Exit::Error;
            }
        }
        Ok(())
    })?;
    if count == 0 && arguments.format == Format::Text {
        output::print("nothing to recover\n")?;
    }
    Ok(exit)
}

fn text(line: &RecoveredLine) -> String {
    let mut text = format!(
        "{}: {} messages, {:.3} s, in {}\n",
        printable(&line.journal),
        line.messages,
        line.duration_s,
        printable(&line.recording)
    );
    for (topic, messages) in &line.topics {
        text.push_str(&format!("  {}: {messages}\n", printable(topic)));
    }
    for lost in &line.lost {
        text.push_str(&format!("  lost: {}\n", printable(lost)));
    }
    for note in &line.notes {
        text.push_str(&format!("  note: {}\n", printable(note)));
    }
    if line.unread_bytes > 0 {
        let shown = line.unread.iter().take(SHOWN);
        let mut ranges: Vec<String> = shown.map(|(from, to)| format!("{from} to {to}")).collect();
        if line.unread.len() > SHOWN {
            ranges.push(format!("and {} more ranges", line.unread.len() - SHOWN));
        }
        text.push_str(&format!(
            "  {} of {} bytes were not read: {}\n",
            line.unread_bytes,
            line.bytes,
            ranges.join(", ")
        ));
    }
    text.push_str(&format!(
        "  the journal is kept as {}\n",
        printable(&line.kept)
    ));
    text
}
