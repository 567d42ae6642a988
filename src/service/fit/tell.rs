//! What is said of an answer from many takes.

mod compared;
mod file;
mod take;

use self::compared::{compared, held_out};
use self::file::calibration;
use self::take::{FITTED, LEFT_OUT, line};
use super::job::FitJob;
use super::take::{AskedTake, Member};
use crate::config::Calibration;
use crate::jointly::{JointInterval, JointSearch};
use crate::motion::TakeShare;
use crate::report::{FitLine, FitTakeLine, FittedLine, TakeSpreadLine};

/// An answer, and all that is said of it.
pub(super) struct ToldFit {
    pub(super) line: FitLine,
    /// In the order of the inputs.
    pub(super) takes: Vec<FitTakeLine>,
    pub(super) calibration: Calibration,
}

impl ToldFit {
    /// What is said of an optimum, with what the takes say there.
    pub(super) fn of(
        job: &FitJob,
        joint: &JointSearch,
        shares: &[Option<TakeShare>],
        members: &mut [Member],
        misfits: &[bool],
    ) -> anyhow::Result<Self> {
        let compared = compared(joint, shares, members);
        let (intervals, correlations) = joint.intervals(shares);
        let judged = joint.judged(shares, &intervals);
        let first = members.iter().find_map(|of| of.asked.as_ref().ok());
        let Some(first) = first else {
            anyhow::bail!("no take says anything");
        };
        let parameters = lines(joint, &intervals, first);
        let mut takes: Vec<(usize, FitTakeLine)> = members
            .iter()
            .enumerate()
            .map(|(take, member)| {
                let taking = joint.is_taking_part(take);
                let share = shares[take].as_ref().filter(|_| taking);
                let judged = judged[take].as_ref();
                let mut line = line(joint, member, share, judged, &compared[take]);
                if misfits[take] {
                    line.stands_out
                        .push("its motion does not explain its samples".to_owned());
                }
                (member.place, line)
            })
            .collect();
        takes.sort_by_key(|(place, _)| *place);
        let takes: Vec<FitTakeLine> = takes.into_iter().map(|(_, line)| line).collect();
        let held_out = job.hold_out.is_some().then(|| held_out(&compared));
        let rows = correlations.row_iter();
        let mut line = FitLine {
            takes: takes.iter().filter(|of| of.part == FITTED).count(),
            left_out: takes.iter().filter(|of| of.part == LEFT_OUT).count(),
            correlations: rows.map(|row| row.iter().copied().collect()).collect(),
            undetermined: undetermined(joint),
            rounds: joint.rounds(),
            held_out,
            output: job.output.as_ref().map(|of| of.display().to_string()),
            page: job.page.as_ref().map(|of| of.display().to_string()),
            parameters,
            ..FitLine::default()
        };
        line.against = against(&line);
        match misfits.iter().filter(|misfits| **misfits).count() {
            0 => {}
            misfits => line.against.push(format!(
                "of {misfits} takes the motion does not explain the samples: the model, or an optimum of theirs, is a wrong one"
            )),
        }
        if let Some(moved) = joint.near_only() {
            line.against.push(format!(
                "the answer is near the optimum only, the last step was {moved:.1e} of a typical change: takes change abruptly \
                 there, as where friction begins to stick"
            ));
        }
        line.notes = notes(&line, &takes);
        let calibration = calibration(&line, first, members);
        Ok(Self {
            line,
            takes,
            calibration,
        })
    }
}

/// That there is none.
pub(super) fn no_optimum<T>(joint: &JointSearch) -> anyhow::Result<T> {
    anyhow::bail!(
        "no joint optimum was found in {} rounds: too few takes have a motion at the same values, expected \
         fewer --shared quantities, or each take's own by --drawn",
        joint.rounds()
    )
}

fn lines(joint: &JointSearch, intervals: &[JointInterval], first: &AskedTake) -> Vec<FittedLine> {
    let units = first.parameters.iter();
    let units = units.map(|of| first.scene.parameters[*of].quantity.unit());
    let each = joint.parameters().iter().zip(intervals).zip(units);
    let each = each.map(|((parameter, of), unit)| FittedLine {
        name: parameter.name.clone(),
        unit: unit.to_owned(),
        is_drawn: parameter.is_drawn,
        value: of.value,
        sd: of.sd,
        interval: of.ends,
        freedom: of.freedom,
        is_at_bound: of.is_at_bound,
        is_determined: !of.is_weak,
        in_scene: parameter.initial,
        spread: of.spread.map(|spread| TakeSpreadLine {
            sd: spread.sd,
            interval: spread.ends,
        }),
    });
    each.collect()
}

/// Directions that are not determined, in words.
fn undetermined(joint: &JointSearch) -> Vec<String> {
    let parameters = joint.parameters();
    let each = joint.weak().iter().map(|direction| {
        let parts = direction.parts.iter().map(|(at, _)| &parameters[*at].name);
        let names: Vec<&str> = parts.map(String::as_str).collect();
        match direction.parts.as_slice() {
            [_] => names.concat(),
            parts => {
                let sum = parts.iter().map(|(at, part)| {
                    let sign = if *part < 0.0 { "−" } else { "+" };
                    format!("{sign} {:.2} {}", part.abs(), parameters[*at].name)
                });
                let sum = sum.collect::<Vec<_>>().join(" ");
                let sum = sum.trim_start_matches("+ ");
                format!(
                    "{} change together ({sum}, each in units of a typical change)",
                    names.join(" and ")
                )
            }
        }
    });
    each.collect()
}

fn against(line: &FitLine) -> Vec<String> {
    let mut against = Vec::new();
    for combination in &line.undetermined {
        against.push(format!(
            "these takes together do not determine {combination}: it stays where it began; fix it, give it a prior_sd, or \
             add takes that move otherwise"
        ));
    }
    for parameter in &line.parameters {
        if parameter.is_at_bound {
            against.push(format!(
                "{} is at its bound: the takes ask for more than it allows, or the model is another",
                parameter.name
            ));
        }
    }
    if line.left_out > 0 {
        against.push(format!("{} takes took no part", line.left_out));
    }
    if line.takes < 2 {
        against.push("one take tells nothing of how takes differ: there are no intervals".into());
    }
    match &line.held_out {
        Some(held) if held.takes == 0 => {
            against.push(
                "no take that was held out has a motion both ways: nothing is compared".into(),
            );
        }
        Some(held) if !(held.gain > 0.0) => {
            against.push(
                "no gain: takes that were held out are no nearer with these values than with the scene's own".into(),
            );
        }
        _ => {}
    }
    against
}

fn notes(line: &FitLine, takes: &[FitTakeLine]) -> Vec<String> {
    let mut notes = Vec::new();
    let standing = takes.iter().filter(|of| !of.stands_out.is_empty());
    let standing: Vec<&FitTakeLine> = standing.collect();
    if !standing.is_empty() {
        notes.push(format!(
            "{} of {} takes stand out; they took part: the intervals are wider for it",
            standing.len(),
            line.takes
        ));
    }
    notes
}
