//! `scene`: makes scenes.

use super::arguments::{Format, FromUrdfArguments, SceneCommand};
use super::exit::Exit;
use super::output::{self, printable};
use super::process::print_failure;
use crate::service::{self, FromUrdfJob, UrdfImported};

pub(super) fn run(command: SceneCommand) -> anyhow::Result<Exit> {
    match command {
        SceneCommand::FromUrdf(arguments) => from_urdf(arguments),
    }
}

fn from_urdf(arguments: FromUrdfArguments) -> anyhow::Result<Exit> {
    let input = arguments.input.display().to_string();
    let job = FromUrdfJob {
        input: arguments.input,
        output: arguments.output,
    };
    let imported = match service::from_urdf(&job) {
        Ok(imported) => imported,
        Err(error) => {
            print_failure(&input, &error, arguments.format)?;
            return Ok(Exit::Error);
        }
    };
    match arguments.format {
        Format::Ndjson => output::print_json(&imported)?,
        Format::Text => output::print(&text(&imported))?,
    }
    Ok(if imported.lost.is_empty() {
        Exit::Done
    } else {
        Exit::NotWhole
    })
}

fn text(imported: &UrdfImported) -> String {
    let mut text = format!(
        "{}: {}\n",
        printable(&imported.input),
        printable(&imported.scene)
    );
    for loss in &imported.lost {
        text += &format!("  lost: {}\n", printable(loss));
    }
    for warning in &imported.warnings {
        text += &format!("  note: {}\n", printable(warning));
    }
    text += &format!(
        "  bodies {}, joints {}\n  written   {}\n",
        imported.bodies,
        imported.joints,
        printable(&imported.output)
    );
    text
}
