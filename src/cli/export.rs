//! `export`: the motion of an estimate for other programs.

use super::arguments::{ExportArguments, Format, Target};
use super::exit::Exit;
use super::output;
use super::process::print_failure;
use super::report::destination;
use crate::service::{self, Destination, ExportFormat, ExportJob, Exported};

pub(super) fn run(arguments: ExportArguments) -> anyhow::Result<Exit> {
    let input = arguments.input.display().to_string();
    let to = arguments.output.map_or(Destination::Beside, destination);
    let is_piped = to == Destination::Caller;
    let format = arguments.format.of_failure(is_piped);
    let job = ExportJob {
        input: arguments.input,
        to,
        format: match arguments.to {
            Target::Glb => ExportFormat::Glb,
            Target::Csv => ExportFormat::Csv,
            Target::Tum => ExportFormat::Tum,
            Target::Bvh => ExportFormat::Bvh,
            Target::Ros2 => ExportFormat::Ros2,
        },
        frame_rate_hz: arguments.fps,
        with_acted: arguments.ghost,
        command: output::command_line(),
    };
    let exported = match service::export(&job) {
        Ok(exported) => exported,
        Err(error) => {
            print_failure(&input, &error, format)?;
            return Ok(Exit::Error);
        }
    };
    if is_piped {
        output::pipe(&exported.bytes, &exported.lost, &exported.warnings)?;
    } else {
        match format {
            Format::Ndjson => output::print_json("enact.export/1", &exported)?,
            Format::Text => output::print(&text(&exported))?,
        }
    }
    let is_whole = exported.lost.is_empty() && exported.verdict == "physical";
    Ok(if is_whole { Exit::Done } else { Exit::NotWhole })
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
    let mut text = String::new();
    output::push_line(&mut text, format!("{input}: {scene}, {verdict}"));
    output::push_notes(&mut text, &exported.lost, &exported.warnings);
    output::push_line(&mut text, format!("  bodies {bodies}, keys {keys}"));
    for written in &exported.outputs {
        output::push_line(&mut text, format!("  written   {written}"));
    }
    text
}
