//! Where takes begin: some of them say by themselves what is shared, and all others begin from what these come to.

use anyhow::ensure;
use nalgebra::DVector;
use rayon::prelude::*;

use super::job::FitStop;
use super::members::evenly;
use super::search::{STOPPED, settled};
use super::take::{Member, NEARER, far};
use crate::jointly::{JointParameter, JointSearch};
use crate::motion::TakeShare;
use crate::service::working::Working;

/// How many takes begin where the scene does.
const SOME: usize = 32;

/// What each take says by itself, from where it begins; `None` of those that are held out or say nothing.
pub(super) fn begun(
    parameters: &[JointParameter],
    members: &mut [Member],
    stop: &FitStop,
) -> anyhow::Result<Vec<Option<TakeShare>>> {
    let are_fitted: Vec<bool> = members
        .iter_mut()
        .map(|of| of.fitting().is_some())
        .collect();
    let count = are_fitted.iter().filter(|is| **is).count();
    let working = Working::of(count);
    // Up to so many of those that are to be fitted.
    let upto = |number: usize| number * SOME.min(count) / count;
    let is_some = evenly(are_fitted, upto);
    let mut own: Vec<Option<TakeShare>> = of_each(members, &is_some, |member| {
        let asked = member.fitting().filter(|_| !stop.is_set())?;
        asked.find();
        let share = asked.own();
        working.done();
        share
    });
    ensure!(!stop.is_set(), STOPPED);
    begun_lesser(parameters, members, &mut own);
    if count <= SOME {
        return Ok(own);
    }
    let values = answer(parameters, members, &own, &is_some, stop)?;
    let is_other: Vec<bool> = is_some.iter().map(|is| !is).collect();
    let others = of_each(members, &is_other, |member| {
        let asked = member.fitting().filter(|_| !stop.is_set())?;
        let share = asked.begun_at(values.as_ref());
        working.done();
        share
    });
    ensure!(!stop.is_set(), STOPPED);
    for (own, other) in own.iter_mut().zip(others) {
        *own = own.take().or(other);
    }
    Ok(own)
}

/// What the takes that have begun come to together; none where that is nothing.
fn answer(
    parameters: &[JointParameter],
    members: &mut [Member],
    own: &[Option<TakeShare>],
    is_asked: &[bool],
    stop: &FitStop,
) -> anyhow::Result<Option<DVector<f64>>> {
    if own.iter().all(Option::is_none) {
        return Ok(None);
    }
    let mut joint = JointSearch::new(parameters.to_vec(), own);
    let found = settled(&mut joint, members, is_asked, stop);
    ensure!(!stop.is_set(), STOPPED);
    Ok(found.is_ok().then(|| joint.values()))
}

fn of_each<T: Send>(
    members: &mut [Member],
    is_asked: &[bool],
    of: impl Fn(&mut Member) -> Option<T> + Sync,
) -> Vec<Option<T>> {
    let each = members.par_iter_mut().zip(is_asked);
    each.map(|(member, is_asked)| is_asked.then(|| of(member)).flatten())
        .collect()
}

/// Finds motions anew from lesser values of a parameter of which most takes by themselves tell nothing, as of friction where
/// they stick: what is wrong of it is then blamed on others. Each keeps the motion that is nearest to its samples.
fn begun_lesser(
    parameters: &[JointParameter],
    members: &mut [Member],
    own: &mut [Option<TakeShare>],
) {
    for (at, parameter) in parameters.iter().enumerate() {
        let said = || own.iter().flatten();
        let untold = said().filter(|of| parameter.is_untold_by(of, at)).count();
        if 2 * untold <= said().count() {
            continue;
        }
        for value in parameter.lesser() {
            let each = members.par_iter_mut().zip(&mut *own);
            each.for_each(|(member, own)| {
                let (Some(asked), Some(here)) = (member.fitting(), &own) else {
                    return;
                };
                let found = asked.begun(at, value);
                if let Some((motion, share)) = found.filter(|(_, of)| far(of) < far(here) - NEARER)
                {
                    (asked.motion, *own) = (Ok(motion), Some(share));
                }
            });
        }
    }
}
