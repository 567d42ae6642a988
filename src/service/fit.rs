//! One answer from many takes: reads each, asks it what it says of what all share until the answer stands, and tells it.

mod apart;
mod begun;
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
use crate::jointly::{JointParameter, JointSearch, SearchTurn};
use crate::motion::TakeShare;

pub use self::apart::{JoinedBlocks, join, reduce};
use self::begun::begun;
pub use self::block::{FitQuestion, TakeBlock};
pub use self::blocks::{ReduceJob, ReducedLine, SolveJob, reduce_files, solve_files};
pub use self::job::{FitInput, FitJob, FitStop, HoldOut};
use self::members::{agreed, in_order};
pub use self::names::AskedNames;
use self::take::{Member, UsualResidual};
use self::tell::{ToldFit, no_optimum};
pub use self::written::FittedTakes;
use self::written::written;

/// Greatest number of times that takes which had no motion, or are far from it, are tried from the answer on.
const AGAIN: usize = 4;

/// Why a fit that was told to end has no answer.
const STOPPED: &str = "it was told to end before it had an answer";

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
        .map(|(place, input)| Member::read(place, input, job.scene.as_deref(), names))
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
    let own = begun(&parameters, members, stop)?;
    let mut joint = JointSearch::new(parameters, &own);
    let all = vec![true; members.len()];
    let shares = settled(&mut joint, members, &all, stop)?;
    Ok((joint, shares))
}

/// The optimum of those that are asked, in which none is nearer to its samples from there on; what they say there.
fn settled(
    joint: &mut JointSearch,
    members: &mut [Member],
    is_asked: &[bool],
    stop: &FitStop,
) -> anyhow::Result<Vec<Option<TakeShare>>> {
    joint.look(&asked(joint, members));
    for round in 0..=AGAIN {
        let shares = searched(joint, members, stop)?;
        if round == AGAIN || !tried_again(joint, &shares, members, is_asked) {
            return Ok(shares);
        }
    }
    unreachable!("the last round returns")
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
    is_asked: &[bool],
) -> bool {
    let usual = UsualResidual::of(shares);
    let asked = &*joint;
    let found: Vec<Option<DVector<f64>>> = members
        .par_iter_mut()
        .zip(shares.par_iter().zip(is_asked))
        .enumerate()
        .map(|(take, (member, (share, is_asked)))| {
            let is_far = share.as_ref().is_none_or(|share| usual.is_far(share));
            if !is_asked || !is_far {
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
