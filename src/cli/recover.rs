//! `recover`: makes recordings of journals that a crash left.

use super::arguments::{Format, RecoverArguments};
use super::exit::Exit;
use super::output::{self, push_line, push_notes};
use super::process::print_failure;
use crate::service::{RecoveredLine, recover_all};

/// Greatest number of unread ranges in the text output; JSON has all.
const SHOWN: usize = 16;

/// Greatest number of topics in it.
const TOPICS_SHOWN: usize = 500;

pub(super) fn run(arguments: RecoverArguments) -> anyhow::Result<Exit> {
    let mut exit = Exit::Done;
    let mut count = 0;
    recover_all(&arguments.paths, |journal, result| {
        count += 1;
        match result {
            Ok(line) => {
                match arguments.format {
                    Format::Ndjson => output::print_json("enact.recovery/1", &line)?,
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
    let mut text = String::new();
    let (messages, duration_s) = (line.messages, line.duration_s);
    push_line(
        &mut text,
        format!(
            "{}: {messages} messages, {duration_s:.3} s, in {}",
            line.journal, line.recording
        ),
    );
    for (topic, messages) in line.topics.iter().take(TOPICS_SHOWN) {
        push_line(&mut text, format!("  {topic}: {messages}"));
    }
    if line.topics.len() > TOPICS_SHOWN {
        let more = line.topics.len() - TOPICS_SHOWN;
        push_line(&mut text, format!("  and {more} more topics"));
    }
    push_notes(&mut text, &line.lost, &line.notes);
    if line.unread_bytes > 0 {
        let shown = line.unread.iter().take(SHOWN);
        let mut ranges: Vec<String> = shown.map(|(from, to)| format!("{from} to {to}")).collect();
        if line.unread.len() > SHOWN {
            ranges.push(format!("and {} more ranges", line.unread.len() - SHOWN));
        }
        let (unread, bytes, ranges) = (line.unread_bytes, line.bytes, ranges.join(", "));
        push_line(
            &mut text,
            format!("  {unread} of {bytes} bytes were not read: {ranges}"),
        );
    }
    push_line(&mut text, format!("  the journal is kept as {}", line.kept));
    text
}
