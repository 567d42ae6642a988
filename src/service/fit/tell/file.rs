//! An answer as a calibration, for its file.

use crate::config::{CalibratedQuantity, Calibration, SourceLine, Unit};
use crate::report::FitLine;
use crate::service::fit::keys::{ToldValue, keys};
use crate::service::fit::take::{AskedTake, Member};
use crate::service::provenance::{PROGRAM, file_name};

/// The answer in a file, in the units of scenes.
pub(super) fn calibration(line: &FitLine, first: &AskedTake, members: &[Member]) -> Calibration {
    let mut told = Vec::new();
    let mut quantities = Vec::new();
    for (parameter, at) in line.parameters.iter().zip(&first.parameters) {
        let quantity = first.scene.parameters[*at].quantity;
        let unit = Unit::of(quantity);
        let list = |value: Option<f64>| value.iter().map(|of| of / unit.si).collect();
        let mut push = |name: String, value: f64, interval: Option<[f64; 2]>| {
            quantities.push(CalibratedQuantity {
                name,
                unit: unit.name.trim().to_owned(),
                value: vec![value / unit.si],
                lower: list(interval.map(|of| of[0])),
                upper: list(interval.map(|of| of[1])),
            });
        };
        let mean = if parameter.is_drawn {
            ", mean over takes"
        } else {
            ""
        };
        push(
            format!("{}{mean}", parameter.name),
            parameter.value,
            parameter.interval,
        );
        if let Some(spread) = parameter.spread {
            push(
                format!("{}, spread over takes", parameter.name),
                spread.sd,
                Some(spread.interval),
            );
        }
        if parameter.is_determined {
            told.push(ToldValue {
                quantity,
                line: parameter,
                is_free: first.was_free.contains(at),
            });
        }
    }
    let mut sources: Vec<(usize, SourceLine)> = Vec::new();
    let mut notes = line.notes.clone();
    for member in members {
        let Ok(asked) = &member.asked else { continue };
        sources.push((member.place, asked.source.clone()));
    }
    sources.sort_by_key(|(place, _)| *place);
    let held: Vec<String> = members
        .iter()
        .filter(|of| of.is_held_out)
        .map(|of| file_name(&of.path))
        .collect();
    if let Some(out) = &line.held_out {
        notes.push(format!(
            "{} takes were held out ({}): residual {} with these values, {} with the scene's own",
            held.len(),
            held.join(", "),
            out.by_fit.words(),
            out.by_scene.words()
        ));
    }
    Calibration {
        kind: "fit".into(),
        program: PROGRAM.into(),
        confidence: 0.95,
        against: line.against.clone(),
        notes,
        recording: sources.into_iter().map(|(_, source)| source).collect(),
        quantity: quantities,
        scene: keys(&first.given, &told),
    }
}
