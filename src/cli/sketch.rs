//! `sketch`: written sketches and recordings, one made of the other.

use super::arguments::SketchArguments;
use super::exit::Exit;
use super::output::{self, Account};
use super::process::print_failure;
use crate::service::{self, Density, SketchJob, Sketched};

pub(super) fn run(arguments: SketchArguments) -> anyhow::Result<Exit> {
    let input = arguments.input.display().to_string();
    let density = match (arguments.per_flight, arguments.per_second) {
        (Some(count), _) => Density::PerFlight(count.into()),
        (None, Some(rate_hz)) => Density::PerSecond(rate_hz),
        (None, None) => Density::All,
    };
    let said = Account::new(arguments.format, arguments.output.as_deref());
    let job = SketchJob {
        input: arguments.input,
        output: arguments.output,
        scene: arguments.scene,
        density,
        is_estimated: arguments.estimated,
        deadline: arguments.limits.deadline,
    };
    let sketched = match service::sketch(&job) {
        Ok(sketched) => sketched,
        Err(error) => {
            print_failure(&input, &error, said.of_failure())?;
            return Ok(Exit::Error);
        }
    };
    said.print("enact.sketch/1", &sketched, |_| text(&sketched))?;
    Ok(if sketched.lost.is_empty() {
        Exit::Done
    } else {
        Exit::NotWhole
    })
}

fn text(sketched: &Sketched) -> String {
    let mut text = String::new();
    output::push_line(&mut text, format!("{}: {}", sketched.input, sketched.scene));
    output::push_notes(&mut text, &sketched.lost, &sketched.warnings);
    let (keyframes, marks) = (sketched.keyframes, sketched.marks);
    output::push_line(&mut text, format!("  keyframes {keyframes}, marks {marks}"));
    output::push_line(&mut text, format!("  written   {}", sketched.output));
    text
}
