//! `inspect`: lists the contents of recordings.

use std::path::Path;

use super::arguments::{Format, InspectArguments};
use super::exit::Exit;
use super::output::{self, push_line, push_notes};
use super::process::print_failure;
use super::table::table;
use crate::service::{self, Inspection, MarkLine};

pub(super) fn run(arguments: InspectArguments) -> anyhow::Result<Exit> {
    let mut exit = Exit::Done;
    for input in service::recordings_in(&arguments.inputs)? {
        exit = exit.max(one(&input, &arguments)?);
    }
    Ok(exit)
}

fn one(input: &Path, arguments: &InspectArguments) -> anyhow::Result<Exit> {
    let (scene, deadline) = (arguments.scene.as_deref(), arguments.limits.deadline);
    let inspection = match service::inspect(input, scene, deadline) {
        Ok(inspection) => inspection,
        Err(error) => {
            let recording = input.display().to_string();
            print_failure(&recording, &error, arguments.format)?;
            return Ok(Exit::Error);
        }
    };
    match arguments.format {
        Format::Ndjson => output::print_json("enact.inspection/1", &inspection)?,
        Format::Text => output::print(&text(&inspection))?,
    }
    Ok(if inspection.lost.is_empty() {
        Exit::Done
    } else {
        Exit::NotWhole
    })
}

fn text(inspection: &Inspection) -> String {
    let mut text = String::new();
    let order = if inspection.sorted {
        ""
    } else {
        ", not sorted"
    };
    let end = if inspection.truncated {
        ", truncated"
    } else {
        ""
    };
    push_line(
        &mut text,
        format!(
            "{}: {} bytes, {} messages, {:.3} s{order}{end}",
            inspection.recording, inspection.bytes, inspection.messages, inspection.duration_s
        ),
    );
    if let Some(scene) = &inspection.scene {
        push_line(&mut text, format!("  scene: {scene}"));
    }
    if let Some(complaint) = &inspection.complaint {
        push_line(&mut text, format!("  scene: {complaint}"));
    }
    push_notes(&mut text, &inspection.lost, &inspection.warnings);
    if !inspection.attachments.is_empty() {
        let names = inspection.attachments.join(", ");
        push_line(&mut text, format!("  attached: {names}"));
    }
    if !inspection.topics.is_empty() {
        text.push('\n');
        text.push_str(&topics(inspection));
        let more = inspection.topics_in_all - inspection.topics.len();
        if more > 0 {
            push_line(&mut text, format!("  and {more} more topics"));
        }
    }
    if !inspection.poses.is_empty() {
        text.push('\n');
        text.push_str(&poses(inspection));
    }
    if !inspection.marks.is_empty() {
        text.push('\n');
        text.push_str(&marks(&inspection.marks));
    }
    text
}

fn poses(inspection: &Inspection) -> String {
    let rows: Vec<Vec<String>> = inspection
        .poses
        .iter()
        .map(|of| {
            let extent = |axis: usize| {
                let shown = of.extent_m.map(|extent| range(extent[axis], 3));
                shown.unwrap_or_else(|| "-".into())
            };
            let norms = of.norms.map(|norms| range(norms, 4));
            let frames = of.frame_ids.join(", ");
            vec![
                of.topic.clone(),
                extent(0),
                extent(1),
                extent(2),
                norms.unwrap_or_else(|| "-".into()),
                of.not_finite.to_string(),
                if frames.is_empty() {
                    "-".into()
                } else {
                    frames
                },
            ]
        })
        .collect();
    let head = [
        "poses",
        "x [m]",
        "y [m]",
        "z [m]",
        "norm",
        "not finite",
        "frame",
    ];
    table("  ", &head, &rows)
}

/// From the least to the greatest.
pub(super) fn range([least, greatest]: [f64; 2], decimals: usize) -> String {
    format!("{least:.decimals$} to {greatest:.decimals$}")
}

fn topics(inspection: &Inspection) -> String {
    let shown = |number: Option<f64>, unit: &str, decimals: usize| {
        number.map_or_else(|| "-".into(), |n| format!("{n:.decimals$} {unit}"))
    };
    let rows: Vec<Vec<String>> = inspection
        .topics
        .iter()
        .map(|topic| {
            vec![
                topic.topic.clone(),
                format!("{} ({})", topic.schema, topic.encoding),
                topic.messages.to_string(),
                shown(topic.rate_hz, "Hz", 1),
                topic.gaps.to_string(),
                shown(topic.longest_gap_s, "s", 3),
            ]
        })
        .collect();
    table(
        "  ",
        &["topic", "schema", "messages", "rate", "gaps", "longest"],
        &rows,
    )
}

/// The marks by number, as `mark` takes them.
pub(super) fn marks(marks: &[MarkLine]) -> String {
    let rows: Vec<Vec<String>> = marks
        .iter()
        .enumerate()
        .map(|(index, mark)| {
            vec![
                (index + 1).to_string(),
                format!("{:.3} s", mark.time_s),
                mark.event.clone().unwrap_or_else(|| "(next)".into()),
            ]
        })
        .collect();
    table("  ", &["mark", "time", "event"], &rows)
}
