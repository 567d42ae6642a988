//! `export`: the motion of an estimate for other programs.

use std::path::Path;

use super::arguments::{ExportArguments, Format, Target};
use super::exit::Exit;
use super::output::{self, printable};
use super::process::print_failure;
use crate::service::{self, ExportFormat, ExportJob, ExportTo, Exported};

pub(super) fn run(arguments: ExportArguments) -> anyhow::Result<Exit> {
    let input = arguments.input.display().to_string();
    let to = match arguments.output {
        None => ExportTo::Beside,
        Some(path) if path == Path::new("-") => ExportTo::Caller,
        Some(path) => ExportTo::File(path),
    };
    let is_piped = to == ExportTo::Caller;
    let job = ExportJob {
        input: arguments.input,
        to,
        format: match arguments.to {
            Target::Glb => ExportFormat::Glb,
            Target::Csv => ExportFormat::Csv,
            Target::Tum => ExportFormat::Tum,
        },
        frame_rate_hz: arguments.fps,
        with_acted: arguments.ghost,
        command: command_line(),
    };
    let exported = match service::export(&job) {
        Ok(exported) => exported,
        Err(error) => {
            // A pipe carries the motion or nothing.
            let format = if is_piped {
                Format::Text
            } else {
                arguments.format
            };
            print_failure(&input, &error, format)?;
            return Ok(Exit::Error);
        }
    };
    if is_piped {
        output::print_bytes(&exported.bytes)?;
        for note in exported.lost.iter().chain(&exported.warnings) {
            output::print_note(note);
        }
    } else {
        match arguments.format {
            Format::Ndjson => output::print_json(&exported)?,
            Format::Text => output::print(&text(&exported))?,
        }
    }
    let is_whole = exported.lost.is_empty() && exported.verdict == "physical";
    Ok(if is_whole { Exit::Done } else { Exit::NotWhole })
}

/// The program by its name, and its arguments.
fn command_line() -> String {
    let arguments = std::env::args_os().skip(1);
    let arguments = arguments.map(|argument| argument.to_string_lossy().into_owned());
    let words: Vec<String> = ["enact".to_owned()].into_iter().chain(arguments).collect();
    words.join(" ")
}

fn text(exported: &Exported) -> String {
    let Exported {
        input,
        scene,
        verdict,
        bodies,
        keys,
        ..
    } = exported;
    let mut text = format!("{}: {}, {verdict}\n", printable(input), printable(scene));
    for loss in &exported.lost {
        text += &format!("  lost: {}\n", printable(loss));
    }
    for warning in &exported.warnings {
        text += &format!("  note: {}\n", printable(warning));
    }
    text += &format!("  bodies {bodies}, keys {keys}\n");
    for output in &exported.outputs {
        text += &format!("  written   {}\n", printable(output));
    }
    text
}
