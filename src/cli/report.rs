//! `report`: an estimate as a page and a picture for people.

use std::path::PathBuf;

use super::arguments::{ReportArguments, Seen};
use super::exit::Exit;
use super::output::{self, Account};
use super::process::print_failure;
use crate::service::{self, ReportJob, ReportMade, View, is_pipe};

pub(super) fn run(arguments: ReportArguments) -> anyhow::Result<Exit> {
    let input = arguments.input.display().to_string();
    let picture = arguments.svg;
    // Who asks for a picture alone gets that alone.
    let page = match (arguments.output, &picture) {
        (Some(output), _) => Some(output),
        (None, Some(_)) => None,
        (None, None) => Some(service::beside(&arguments.input, "html")?),
    };
    let piped = page.iter().chain(&picture).find(|to| is_pipe(to));
    let said = Account::new(arguments.format, piped.map(PathBuf::as_path));
    let job = ReportJob {
        input: arguments.input,
        page,
        picture: picture.map(|to| (to, view(arguments.view))),
        command: output::command_line(),
    };
    let made = match service::report(&job) {
        Ok(made) => made,
        Err(error) => {
            print_failure(&input, &error, said.of_failure())?;
            return Ok(Exit::Error);
        }
    };
    if said.is_piped() {
        output::print_notes(&made.lost, &made.warnings);
    } else {
        said.print("enact.page/1", &made, |_| text(&made))?;
    }
    let is_whole = made.lost.is_empty() && made.verdict == "physical";
    Ok(if is_whole { Exit::Done } else { Exit::NotWhole })
}

fn view(seen: Seen) -> View {
    match seen {
        Seen::Front => View::Front,
        Seen::Side => View::Side,
        Seen::Top => View::Top,
        Seen::ThreeQuarter => View::ThreeQuarter,
    }
}

fn text(made: &ReportMade) -> String {
    let mut text = String::new();
    let (input, scene, verdict) = (&made.input, &made.scene, &made.verdict);
    output::push_line(&mut text, format!("{input}: {scene}, {verdict}"));
    output::push_notes(&mut text, &made.lost, &made.warnings);
    for written in &made.outputs {
        output::push_line(&mut text, format!("  written   {written}"));
    }
    text
}
