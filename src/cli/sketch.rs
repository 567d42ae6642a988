//! `sketch`: written sketches and recordings, one made of the other.

use super::arguments::{Format, SketchArguments};
use super::exit::Exit;
use super::output::{self, printable};
use super::process::print_failure;
use crate::service::{self, Density, SketchJob, Sketched};

pub(super) fn run(arguments: SketchArguments) -> anyhow::Result<Exit> {
    let input = arguments.input.display().to_string();
    let density = match (arguments.per_flight, arguments.per_second) {
        (Some(count), _) => Density::PerFlight(count.into()),
        (None, Some(rate_hz)) => Density::PerSecond(rate_hz),
        (None, None) => Density::All,
    };
    let job = SketchJob {
        input: arguments.input,
        output: arguments.output,
        scene: arguments.scene,
        density,
        is_estimated: arguments.estimated,
    };
    let sketched = match service::sketch(&job) {
        Ok(sketched) => sketched,
        Err(error) => {
            print_failure(&input, &error, arguments.format)?;
            return Ok(Exit::Error);
        }
    };
    match arguments.format {
        Format::Ndjson => output::print_json(&sketched)?,
        Format::Text => output::print(&text(&sketched))?,
    }
    Ok(if sketched.lost.is_empty() {
        Exit::Done
    } else {
        Exit::NotWhole
    })
}

fn text(sketched: &Sketched) -> String {
    let mut text = format!(
        "{}: {}\n",
        printable(&sketched.input),
        printable(&sketched.scene)
    );
    for loss in &sketched.lost {
        text += &format!("  lost: {}\n", printable(loss));
    }
    for warning in &sketched.warnings {
        text += &format!("  note: {}\n", printable(warning));
    }
    text += &format!(
        "  keyframes {}, marks {}\n  written   {}\n",
        sketched.keyframes,
        sketched.marks,
        printable(&sketched.output)
    );
    text
}
