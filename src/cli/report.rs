//! `report`: an estimate as a page and a picture for people.

use std::path::PathBuf;

use super::arguments::{Format, ReportArguments, Seen};
use super::exit::Exit;
use super::output;
use super::process::print_failure;
use crate::service::{self, Destination, ReportJob, ReportMade, View, is_pipe};

pub(super) fn run(arguments: ReportArguments) -> anyhow::Result<Exit> {
    let input = arguments.input.display().to_string();
    let picture = arguments.svg.map(destination);
    // Who asks for a picture alone gets that alone.
    let page = match (arguments.output, &picture) {
        (Some(output), _) => Some(destination(output)),
        (None, Some(_)) => None,
        (None, None) => Some(Destination::Beside),
    };
    let is_caller = |to: &Destination| *to == Destination::Caller;
    let is_piped = page.iter().chain(&picture).any(is_caller);
    let format = arguments.format.of_failure(is_piped);
    let job = ReportJob {
        input: arguments.input,
        page,
        picture: picture.map(|to| (to, view(arguments.view))),
        command: output::command_line(),
    };
    let made = match service::report(&job) {
        Ok(made) => made,
        Err(error) => {
            print_failure(&input, &error, format)?;
            return Ok(Exit::Error);
        }
    };
    if is_piped {
        output::pipe(&made.bytes, &made.lost, &made.warnings)?;
    } else {
        match format {
            Format::Ndjson => output::print_json("enact.page/1", &made)?,
            Format::Text => output::print(&text(&made))?,
        }
    }
    let is_whole = made.lost.is_empty() && made.verdict == "physical";
    Ok(if is_whole { Exit::Done } else { Exit::NotWhole })
}

pub(super) fn destination(path: PathBuf) -> Destination {
    match is_pipe(&path) {
        true => Destination::Caller,
        false => Destination::File(path),
    }
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
