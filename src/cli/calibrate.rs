//! `calibrate`: measures trackers and rooms; `scene calibrated` puts that into scenes.

use std::path::PathBuf;

use super::arguments::Format;
use super::arguments::{CalibrateCommand, Common, SceneCalibratedArguments};
use super::exit::Exit;
use super::output::{self, Account};
use super::process::print_failure;
use super::table::table;
use crate::service::{
    self, CalibrateChoice, CalibrateJob, CalibrateKind, CalibrateSceneJob, Calibrated,
    SceneCalibrated, TouchingPoint,
};

/// Recordings that are listed.
const TOLD: usize = 5;

/// Lines of a kind that are listed.
const LINES_TOLD: usize = 20;

pub(super) fn run(command: CalibrateCommand) -> anyhow::Result<Exit> {
    let (inputs, topics, kind, common) = match command {
        CalibrateCommand::Pivot(of) => {
            let kind = CalibrateKind::Pivot {
                feature: of.feature,
            };
            (vec![of.input], one(of.topic), kind, of.common)
        }
        CalibrateCommand::Plane(of) => {
            let point = match (of.point, of.tip, of.feature) {
                (Some(point), ..) => TouchingPoint::InTracker(point),
                (_, Some(file), _) => TouchingPoint::Pivot(file),
                (.., feature) => TouchingPoint::Feature(feature.unwrap_or_default()),
            };
            let kind = CalibrateKind::Plane {
                point,
                at_s: of.at,
                window_s: of.window_ms / 1e3,
                surface: of.surface,
            };
            (vec![of.input], one(of.topic), kind, of.common)
        }
        CalibrateCommand::Rest(of) => {
            let kind = CalibrateKind::Rest { stands: of.stands };
            (of.inputs, one(of.topic), kind, of.common)
        }
        CalibrateCommand::Gravity(of) => {
            (of.inputs, one(of.topic), CalibrateKind::Gravity, of.common)
        }
        CalibrateCommand::Clock(of) => (vec![of.input], of.topics, CalibrateKind::Clock, of.common),
    };
    calibrate(inputs, topics, kind, common)
}

fn one(topic: Option<String>) -> Vec<String> {
    topic.into_iter().collect()
}

fn calibrate(
    inputs: Vec<PathBuf>,
    topics: Vec<String>,
    kind: CalibrateKind,
    common: Common,
) -> anyhow::Result<Exit> {
    let said = Account::new(common.format, common.output.as_deref());
    let names: Vec<String> = inputs
        .iter()
        .map(|input| input.display().to_string())
        .collect();
    let job = CalibrateJob {
        inputs,
        output: common.output,
        choice: CalibrateChoice {
            topics,
            scene: common.scene,
            body: common.body,
            from_s: common.from,
            to_s: common.to,
        },
        kind,
    };
    let found = match service::calibrate(&job) {
        Ok(found) => found,
        Err(error) => {
            print_failure(&names.join(", "), &error, said.of_failure())?;
            return Ok(Exit::Error);
        }
    };
    match (common.format, &found.output) {
        (Format::Ndjson, _) | (_, Some(_)) => {
            said.print("enact.calibration/1", &found, |_| text(&found))?;
        }
        (Format::Text, None) => {
            output::print(&found.toml)?;
            for line in found.lost.iter().chain(&found.calibration.against) {
                output::print_note(line);
            }
        }
    }
    let is_whole = found.lost.is_empty() && found.calibration.against.is_empty();
    Ok(if is_whole { Exit::Done } else { Exit::NotWhole })
}

fn text(found: &Calibrated) -> String {
    let of = &found.calibration;
    let mut text = String::new();
    for source in of.recording.iter().take(TOLD) {
        let line = format!("{}: {}, {} poses", source.file, source.topic, source.poses);
        output::push_line(&mut text, line);
    }
    if let Some(others) = of.recording.get(TOLD..).filter(|others| !others.is_empty()) {
        let poses: usize = others.iter().map(|source| source.poses).sum();
        output::push_line(
            &mut text,
            format!("and {} others: {poses} poses", others.len()),
        );
    }
    let list = |numbers: &[f64]| {
        let numbers: Vec<String> = numbers.iter().map(|x| short(*x)).collect();
        numbers.join("  ")
    };
    let rows: Vec<Vec<String>> = of
        .quantity
        .iter()
        .map(|quantity| {
            let halves: Vec<f64> = quantity
                .upper
                .iter()
                .zip(&quantity.lower)
                .map(|(upper, lower)| 0.5 * (upper - lower))
                .collect();
            let interval = if halves.is_empty() {
                String::new()
            } else {
                format!("within {}", list(&halves))
            };
            vec![
                quantity.name.clone(),
                list(&quantity.value),
                interval,
                quantity.unit.clone(),
            ]
        })
        .collect();
    let percent = format!("{:.0} %", of.confidence * 100.0);
    text += &table(
        "  ",
        &[of.kind.as_str(), "value", percent.as_str(), "unit"],
        &rows,
    );
    for line in &found.lost {
        output::push_line(&mut text, format!("  lost: {line}"));
    }
    push_some(&mut text, "against", &of.against);
    push_some(&mut text, "note", &of.notes);
    if let Some(output) = &found.output {
        output::push_line(&mut text, format!("  written   {output}"));
    }
    text
}

/// The first of many lines, and how many others there are.
fn push_some(text: &mut String, what: &str, lines: &[String]) {
    for line in lines.iter().take(LINES_TOLD) {
        output::push_line(text, format!("  {what}: {line}"));
    }
    if lines.len() > LINES_TOLD {
        let others = lines.len() - LINES_TOLD;
        output::push_line(
            text,
            format!("  {what}: {others} others, which `--format ndjson` lists"),
        );
    }
}

/// Four digits, as many as an interval has use for.
fn short(number: f64) -> String {
    if number == 0.0 || !number.is_finite() {
        return number.to_string();
    }
    let digits = 3 - number.abs().log10().floor().clamp(-3.0, 3.0) as i32;
    format!("{number:.*}", digits.clamp(0, 6) as usize)
}

/// `scene calibrated`.
pub(super) fn scene(arguments: SceneCalibratedArguments) -> anyhow::Result<Exit> {
    let scene = arguments.scene.display().to_string();
    let said = Account::new(arguments.format, arguments.output.as_deref());
    let job = CalibrateSceneJob {
        scene: arguments.scene,
        calibrations: arguments.calibrations,
        output: arguments.output,
    };
    let made = match service::calibrate_scene(&job) {
        Ok(made) => made,
        Err(error) => {
            print_failure(&scene, &error, said.of_failure())?;
            return Ok(Exit::Error);
        }
    };
    match (arguments.format, &made.output) {
        (Format::Ndjson, _) | (_, Some(_)) => {
            said.print("enact.calibrated_scene/1", &made, |_| changes(&made))?;
        }
        (Format::Text, None) => {
            output::print(&made.toml)?;
            for line in &made.against {
                output::print_note(line);
            }
        }
    }
    Ok(if made.against.is_empty() {
        Exit::Done
    } else {
        Exit::NotWhole
    })
}

fn changes(made: &SceneCalibrated) -> String {
    let mut text = String::new();
    output::push_line(&mut text, format!("{}:", made.scene));
    for change in &made.changes {
        output::push_line(&mut text, format!("  {change}"));
    }
    for line in &made.against {
        output::push_line(&mut text, format!("  against: {line}"));
    }
    if let Some(output) = &made.output {
        output::push_line(&mut text, format!("  written   {output}"));
    }
    text
}
