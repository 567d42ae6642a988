//! One answer from many takes: reads each, asks it what it says of what all share until the answer stands, and tells it.

mod apart;
mod block;
mod blocks;
mod job;
mod keys;
mod members;
mod names;
mod take;
mod tell;
mod written;

use std::path::PathBuf;

use anyhow::ensure;
use nalgebra::DVector;
use rayon::prelude::*;

use super::output::refuse_present;
use super::working::Working;
use crate::jointly::{JointParameter, JointSearch, SearchTurn};
use crate::motion::TakeShare;

pub use self::apart::{JoinedBlocks, join, reduce};
pub use self::block::{FitQuestion, TakeBlock};
pub use self::blocks::{ReduceJob, ReducedLine, SolveJob, reduce_files, solve_files};
pub use self::job::{FitInput, FitJob, FitStop, HoldOut};
use self::members::{agreed, in_order};
pub use self::names::AskedNames;
use self::take::{Member, NEARER, UsualResidual, far};
use self::tell::{ToldFit, no_optimum};
pub use self::written::FittedTakes;
use self::written::written;

/// Greatest number of times that takes which had no motion, or are far from it, are tried from the answer on.
const AGAIN: usize = 4;

/// Why a fit that was told to end has no answer.
const STOPPED: &str = "it was told to end before it had an answer";

/// How many takes are asked from where to begin.
const SOME: usize = 32;

/// Finds what takes share. The answer is the same for any order of the files and any number of threads.
///
/// Fails where names mean nothing in the scenes, where no take says anything, and where the takes have no joint optimum.
pub fn fit(job: &FitJob) -> anyhow::Result<FittedTakes> {
    if let Some(output) = &job.output {
        refuse_present(output)?;
    }
    let names = AskedNames::new(&job.shared, &job.drawn)?;
    let mut members = read(job, &names)?;
    let parameters = agreed(&members, &names)?;
    let held_out = hold_out(job, &members)?;
    for (member, held_out) in members.iter_mut().zip(&held_out) {
        member.is_held_out = *held_out;
    }
    let (joint, shares) = solved(parameters, &mut members, &job.stop)?;
    let misfits = misfits(&joint, &mut members);
    ensure!(!job.stop.is_set(), STOPPED);
    let told = ToldFit::of(job, &joint, &shares, &mut members, &misfits)?;
    written(job, told)
}

/// All inputs, in the order of their contents, so that sums have one order.
fn read(job: &FitJob, names: &AskedNames) -> anyhow::Result<Vec<Member>> {
    let working = Working::of(job.inputs.len());
    let listed = match &job.hold_out {
        Some(HoldOut::Files(files)) => &files[..],
        _ => &[],
    };
    let is_other = |file: &&PathBuf| job.inputs.iter().all(|input| input.name() != *file);
    let others = listed.iter().filter(is_other).cloned().map(FitInput::File);
    let inputs: Vec<FitInput> = job.inputs.iter().cloned().chain(others).collect();
    let members: Vec<Member> = inputs
        .par_iter()
        .enumerate()
        .map(|(place, input)| {
            let mut member = Member::read(place, input, job.scene.as_deref(), names);
            if let Ok(asked) = &mut member.asked
                && !job.stop.is_set()
            {
                asked.find();
            }
            working.done();
            member
        })
        .collect();
    Ok(in_order(members))
}

/// Which takes are held out. By a share these are evenly spread in the order of the contents, which is as good as drawn.
fn hold_out(job: &FitJob, members: &[Member]) -> anyhow::Result<Vec<bool>> {
    let held: Vec<bool> = match &job.hold_out {
        None => vec![false; members.len()],
        Some(HoldOut::Files(files)) => {
            let is_listed = |of: &Member| files.contains(&of.path);
            members.iter().map(is_listed).collect()
        }
        Some(HoldOut::Share(share)) => {
            let mut next = 0_usize;
            let each = members.iter().map(|of| {
                if of.asked.is_err() {
                    return false;
                }
                next += 1;
                let before = ((next - 1) as f64 * share).floor();
                (next as f64 * share).floor() > before
            });
            each.collect()
        }
    };
    if job.hold_out.is_some() {
        let of = |is_held: bool| {
            let mut all = members.iter().zip(&held);
            all.any(|(of, held)| of.asked.is_ok() && *held == is_held)
        };
        ensure!(
            of(true) && of(false),
            "no take is left to hold out, or none to fit, expected some of each: more takes, or another --hold-out"
        );
    }
    Ok(held)
}

/// The joint optimum, with what the takes say there.
fn solved(
    parameters: Vec<JointParameter>,
    members: &mut [Member],
    stop: &FitStop,
) -> anyhow::Result<(JointSearch, Vec<Option<TakeShare>>)> {
    let own: Vec<Option<TakeShare>> = members
        .par_iter_mut()
        .map(|member| member.fitting()?.own())
        .collect();
    ensure!(!stop.is_set(), STOPPED);
    let own = begun_lesser(&parameters, own, members);
    let mut joint = JointSearch::new(parameters, &own);
    joint.look(&asked(&joint, members));
    for round in 0..=AGAIN {
        let shares = searched(&mut joint, members, stop)?;
        if round == AGAIN || !tried_again(&mut joint, &shares, members) {
            return Ok((joint, shares));
        }
    }
    unreachable!("the last round returns")
}

/// Finds motions anew from lesser values of a parameter of which most takes by themselves tell nothing, as of friction where
/// they stick: what is wrong of it is then blamed on others. That is done of takes that are farther from their samples than
/// others, and of some; of all, where most of these come nearer. Each keeps the motion that is nearest.
fn begun_lesser(
    parameters: &[JointParameter],
    mut own: Vec<Option<TakeShare>>,
    members: &mut [Member],
) -> Vec<Option<TakeShare>> {
    for (at, parameter) in parameters.iter().enumerate() {
        let untold = own
            .iter()
            .flatten()
            .filter(|of| parameter.is_untold_by(of, at));
        if 2 * untold.count() <= own.iter().flatten().count() {
            continue;
        }
        let (usual, some) = (UsualResidual::of(&own), evenly(&own));
        let is_far = own
            .iter()
            .map(|of| of.as_ref().is_none_or(|of| usual.is_far(of)));
        let asked: Vec<bool> = is_far.zip(&some).map(|(far, some)| far || *some).collect();
        let as_found: Vec<Option<f64>> = own.iter().map(|of| of.as_ref().map(far)).collect();
        let gains = parameter.lesser().into_iter().map(|value| {
            let there = begun(members, &mut own, &asked, (at, value));
            let gains = as_found.iter().zip(there).zip(&some);
            let gains = gains.filter_map(|((here, there), some)| some.then_some((*here)? - there?));
            (median(gains.collect()), value)
        });
        let gains: Vec<(f64, f64)> = gains.collect();
        let best = gains.into_iter().max_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((_, value)) = best.filter(|(gain, _)| *gain > NEARER) {
            let others: Vec<bool> = asked.iter().map(|asked| !asked).collect();
            begun(members, &mut own, &others, (at, value));
        }
    }
    own
}

/// Up to [`SOME`] of the takes that say something, evenly spread.
fn evenly(own: &[Option<TakeShare>]) -> Vec<bool> {
    let count = own.iter().flatten().count();
    let mut number = 0;
    let each = own.iter().map(|share| {
        if share.is_none() {
            return false;
        }
        number += 1;
        let upto = |number: usize| number * SOME.min(count) / count;
        upto(number) > upto(number - 1)
    });
    each.collect()
}

/// Finds motions of takes that are asked from another value of one of the parameters on, and keeps those that are nearer; how far
/// each is.
fn begun(
    members: &mut [Member],
    own: &mut [Option<TakeShare>],
    asked: &[bool],
    (at, value): (usize, f64),
) -> Vec<Option<f64>> {
    members
        .par_iter_mut()
        .zip(own)
        .zip(asked)
        .map(|((member, own), is_asked)| {
            let asked = member.fitting().filter(|_| *is_asked)?;
            let (motion, share) = asked.begun(at, value)?;
            let there = far(&share);
            if own.as_ref().is_none_or(|own| there < far(own) - NEARER) {
                (asked.motion, *own) = (Ok(motion), Some(share));
            }
            Some(there)
        })
        .collect()
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}

/// What each take says where it is asked.
fn asked(joint: &JointSearch, members: &mut [Member]) -> Vec<Option<TakeShare>> {
    members
        .par_iter_mut()
        .enumerate()
        .map(|(take, member)| match joint.is_taking_part(take) {
            true => member.fitting()?.at(&joint.asked(take)),
            false => None,
        })
        .collect()
}

fn searched(
    joint: &mut JointSearch,
    members: &mut [Member],
    stop: &FitStop,
) -> anyhow::Result<Vec<Option<TakeShare>>> {
    loop {
        ensure!(!stop.is_set(), STOPPED);
        let shares = asked(joint, members);
        match joint.turn(&shares) {
            SearchTurn::Again => {}
            SearchTurn::Found => return Ok(shares),
            SearchTurn::Lost => return no_optimum(joint),
        }
    }
}

/// Finds motions anew from the answer on of takes that had none, or that are farther from it than others: they may be near
/// another optimum of their own. Whether any is better.
fn tried_again(
    joint: &mut JointSearch,
    shares: &[Option<TakeShare>],
    members: &mut [Member],
) -> bool {
    let usual = UsualResidual::of(shares);
    let asked = &*joint;
    let found: Vec<Option<DVector<f64>>> = members
        .par_iter_mut()
        .zip(shares)
        .enumerate()
        .map(|(take, (member, share))| {
            let is_far = share.as_ref().is_none_or(|share| usual.is_far(share));
            if !is_far {
                return None;
            }
            let values = match share {
                Some(_) => asked.asked(take),
                None => asked.values(),
            };
            member.fitting()?.again(&values)
        })
        .collect();
    let is_any = found.iter().any(Option::is_some);
    for (take, there) in found.into_iter().enumerate() {
        if let Some(there) = there {
            joint.take_in(take, &there);
        }
    }
    is_any
}

/// Of which takes that take part the motion at the answer does not explain the samples.
fn misfits(joint: &JointSearch, members: &mut [Member]) -> Vec<bool> {
    members
        .par_iter_mut()
        .enumerate()
        .map(|(take, member)| {
            let fitted = member.asked.as_mut().ok();
            let fitted = fitted.filter(|_| joint.is_taking_part(take));
            fitted.is_some_and(|of| of.misfits(&joint.asked(take)))
        })
        .collect()
}
