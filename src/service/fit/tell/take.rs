//! What is said of one take.

use nalgebra::DVector;

use super::compared::{Compared, pooled};
use crate::jointly::{JointSearch, Standout, TakeJudged};
use crate::motion::TakeShare;
use crate::report::units::for_people;
use crate::report::{FitTakeLine, InfluenceLine, OwnLine, ResidualLine};
use crate::service::fit::take::Member;

pub(super) const FITTED: &str = "fitted";
const HELD_OUT: &str = "held_out";
pub(super) const LEFT_OUT: &str = "left_out";
const LEFT_ALONE: &str = "left_alone";

/// What became of one take.
pub(super) fn line(
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

fn residual(share: &TakeShare) -> ResidualLine {
    pooled(std::iter::once(share))
}
