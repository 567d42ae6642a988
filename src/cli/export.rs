//! `export`: the motion of an estimate for other programs.

use super::arguments::{ExportArguments, Target};
use super::exit::Exit;
use super::output::{self, Account};
use super::process::print_failure;
use crate::service::{self, ExportFormat, ExportJob, Exported};

pub(super) fn run(arguments: ExportArguments) -> anyhow::Result<Exit> {
    let input = arguments.input.display().to_string();
    let said = Account::new(arguments.format, arguments.output.as_deref());
    let job = ExportJob {
        input: arguments.input,
        output: arguments.output,
        format: match arguments.to {
            Target::Glb => ExportFormat::Glb,
            Target::Csv => ExportFormat::Csv,
            Target::Tum => ExportFormat::Tum,
            Target::Bvh => ExportFormat::Bvh,
            Target::Ros2 => ExportFormat::Ros2,
            Target::Events => ExportFormat::Events,
        },
        frame_rate_hz: arguments.fps,
        with_acted: arguments.ghost,
        command: output::command_line(),
    };
    let exported = match service::export(&job) {
        Ok(exported) => exported,
        Err(error) => {
            print_failure(&input, &error, said.of_failure())?;
            return Ok(Exit::Error);
        }
    };
    if said.is_piped() {
        output::print_notes(&exported.lost, &exported.warnings);
    } else {
        said.print("enact.export/1", &exported, |_| text(&exported))?;
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
