//! `recover`: journals that a crash left become recordings.

use super::arguments::{Format, RecoverArguments};
use super::exit::Exit;
use super::output;
use super::process::print_failure;
use crate::service::{RecoveredLine, recover_all};

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
                // A missing end is what a crash leaves: nothing else is lost then.
                if !line.removed {
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
        line.journal, line.messages, line.duration_s, line.recording
    );
    for (topic, messages) in &line.topics {
        text.push_str(&format!("  {topic}: {messages}\n"));
    }
    for lost in &line.lost {
        text.push_str(&format!("  lost: {lost}\n"));
    }
    if !line.removed {
        text.push_str("  the journal is kept, for it has damage in the middle\n");
    }
    text
}
