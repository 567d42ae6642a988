//! What is said of an answer from many takes.

use nalgebra::DVector;
use rayon::prelude::*;

use super::job::FitJob;
use super::keys::{ToldValue, keys};
use super::take::{AskedTake, Member, UsualResidual};
use crate::config::{CalibratedQuantity, Calibration, SourceLine, Unit};
use crate::jointly::{JointInterval, JointSearch, Standout, TakeJudged};
use crate::motion::TakeShare;
use crate::report::units::for_people;
use crate::report::{
    FitLine, FitTakeLine, FittedLine, HeldOutLine, InfluenceLine, OwnLine, ResidualLine,
    TakeSpreadLine,
};
use crate::service::provenance::{PROGRAM, file_name};

/// An answer, and all that is said of it.
pub(super) struct ToldFit {
    pub(super) line: FitLine,
    /// In the order of the inputs.
    pub(super) takes: Vec<FitTakeLine>,
    pub(super) calibration: Calibration,
}

/// A take that was held out: what it says with the answer, and with the scene's own values.
struct Compared {
    by_fit: Option<TakeShare>,
    by_scene: Option<TakeShare>,
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

const FITTED: &str = "fitted";
const HELD_OUT: &str = "held_out";
const LEFT_OUT: &str = "left_out";
const LEFT_ALONE: &str = "left_alone";

/// What the takes that are held out say.
fn compared(
    joint: &JointSearch,
    shares: &[Option<TakeShare>],
    members: &mut [Member],
) -> Vec<Option<Compared>> {
    let (values, usual) = (joint.values(), UsualResidual::of(shares));
    members
        .par_iter_mut()
        .map(|member| {
            if !member.is_held_out {
                return None;
            }
            let asked = member.asked.as_mut().ok()?;
            let initial = asked.initial.clone();
            let mut by_fit = asked.at(&values);
            let is_far = by_fit.as_ref().is_none_or(|share| usual.is_far(share));
            if is_far && asked.again(&values).is_some() {
                by_fit = asked.at(&values);
            }
            // The scene's own values are given the same chance.
            asked.again(&initial);
            Some(Compared {
                by_fit,
                by_scene: asked.at(&initial),
            })
        })
        .collect()
}

fn held_out(compared: &[Option<Compared>]) -> HeldOutLine {
    let all = compared.iter().flatten();
    let both: Vec<[&TakeShare; 2]> = all
        .clone()
        .filter_map(|of| Some([of.by_fit.as_ref()?, of.by_scene.as_ref()?]))
        .collect();
    let only = |a: fn(&Compared) -> bool| all.clone().filter(|of| a(of)).count();
    let gains = both.iter().map(|[fit, scene]| scene.cost - fit.cost);
    let gains: Vec<f64> = gains.collect();
    let count = gains.len() as f64;
    let gain = gains.iter().sum::<f64>() / count.max(1.0);
    let squares: f64 = gains.iter().map(|of| (of - gain).powi(2)).sum();
    HeldOutLine {
        takes: both.len(),
        by_fit: pooled(both.iter().map(|[fit, _]| *fit)),
        by_scene: pooled(both.iter().map(|[_, scene]| *scene)),
        better: gains.iter().filter(|of| **of > 0.0).count(),
        gain,
        gain_sd: (count > 1.0).then(|| (squares / (count - 1.0) / count).sqrt()),
        only_by_fit: only(|of| of.by_fit.is_some() && of.by_scene.is_none()),
        only_by_scene: only(|of| of.by_fit.is_none() && of.by_scene.is_some()),
    }
}

/// Root mean square residual of several takes.
fn pooled<'a>(shares: impl Iterator<Item = &'a TakeShare> + Clone) -> ResidualLine {
    let of = |kind: usize| {
        let samples: usize = shares.clone().map(|of| of.samples[kind]).sum();
        let squares = shares
            .clone()
            .map(|of| of.residual[kind].powi(2) * of.samples[kind] as f64);
        (samples > 0).then(|| (squares.sum::<f64>() / samples as f64).sqrt())
    };
    ResidualLine {
        position_m: of(0),
        orientation_rad: of(1),
    }
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

fn residual(share: &TakeShare) -> ResidualLine {
    pooled(std::iter::once(share))
}

/// What became of one take.
fn line(
    joint: &JointSearch,
    member: &Member,
    share: Option<&TakeShare>,
    judged: Option<&TakeJudged>,
    compared: &Option<Compared>,
) -> FitTakeLine {
    let (part, why) = match (&member.asked, share, compared) {
        (Err(why), ..) if member.is_left_alone => (LEFT_ALONE, Some(why.clone())),
        (Err(why), ..) => (LEFT_OUT, Some(why.clone())),
        (Ok(_), Some(_), _) => (FITTED, None),
        (Ok(_), None, Some(compared)) => {
            let why = compared.by_fit.is_none();
            let why = why.then(|| "it has no motion with the answer".to_owned());
            (HELD_OUT, why)
        }
        (Ok(asked), None, None) => {
            let why = asked.motion.as_ref().err().cloned();
            let why = why.unwrap_or_else(|| "it has no motion near the answer".into());
            (LEFT_OUT, Some(why))
        }
    };
    let names = || joint.parameters().iter().map(|of| of.name.clone());
    let own = judged.iter().flat_map(|of| names().zip(&of.own));
    let own = own.filter_map(|(name, own)| {
        let [value, sd] = (*own)?;
        Some((name, OwnLine { value, sd }))
    });
    let influence = judged
        .iter()
        .flat_map(|of| names().zip(of.influence.iter().copied()));
    let compared_by = |of: fn(&Compared) -> Option<&TakeShare>| compared.as_ref().and_then(of);
    FitTakeLine {
        recording: member.file.clone(),
        sha256: (!member.sha256.is_empty()).then(|| member.sha256.clone()),
        part,
        why,
        notes: member.notes.clone(),
        residual: share.or(compared_by(|of| of.by_fit.as_ref())).map(residual),
        residual_by_scene: compared_by(|of| of.by_scene.as_ref()).map(residual),
        own: own.collect(),
        influence: influence.collect(),
        most_influence: judged
            .and_then(|of| of.most)
            .map(|(at, times)| InfluenceLine {
                parameter: joint.parameters()[at].name.clone(),
                times,
            }),
        score: judged.map(|of| of.score),
        stands_out: judged.map_or_else(Vec::new, |of| standouts(joint, member, of)),
    }
}

/// Why a take stands out, in words.
fn standouts(joint: &JointSearch, member: &Member, judged: &TakeJudged) -> Vec<String> {
    let values: DVector<f64> = joint.values();
    let each = judged.standout.iter().map(|why| match *why {
        Standout::Differs { parameter, times } => {
            let name = &joint.parameters()[parameter].name;
            let unit = member.asked.as_ref().map_or("", |asked| {
                let at = asked.parameters[parameter];
                asked.scene.parameters[at].quantity.unit()
            });
            let (factor, unit) = for_people(unit);
            let [own, sd] = judged.own[parameter].unwrap_or_default().map(|x| x * factor);
            format!(
                "by itself it says {name} is {own:.4} ± {sd:.4} {unit}, all together {:.4}: {times:.0} times as far off as \
                 takes are",
                values[parameter] * factor
            )
        }
        Standout::Worse { kind, times } => {
            let what = ["positions", "orientations"][kind];
            format!("its {what} are {times:.1} times as far from the motion as those of other takes")
        }
    });
    each.collect()
}

/// The answer in a file, in the units of scenes.
fn calibration(line: &FitLine, first: &AskedTake, members: &[Member]) -> Calibration {
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
