//! Takes that are held out: how near they are with the answer, and with the scene's own values.

use rayon::prelude::*;

use crate::jointly::JointSearch;
use crate::motion::TakeShare;
use crate::report::{HeldOutLine, ResidualLine};
use crate::service::fit::take::{Member, UsualResidual};

/// A take that was held out: what it says with the answer, and with the scene's own values.
pub(super) struct Compared {
    pub(super) by_fit: Option<TakeShare>,
    pub(super) by_scene: Option<TakeShare>,
}

/// What the takes that are held out say.
pub(super) fn compared(
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

pub(super) fn held_out(compared: &[Option<Compared>]) -> HeldOutLine {
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
pub(super) fn pooled<'a>(shares: impl Iterator<Item = &'a TakeShare> + Clone) -> ResidualLine {
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
