//! One answer from many takes: reads each, asks it what it says of what all share until the answer stands, and tells it.

mod apart;
mod begun;
mod block;
mod blocks;
mod job;
mod keys;
mod members;
mod names;
mod search;
mod take;
mod tell;
mod written;

use std::path::PathBuf;

use anyhow::{bail, ensure};
use rayon::prelude::*;

use super::output::refuse_present;
use crate::jointly::{JointParameter, JointSearch};
use crate::motion::TakeShare;

pub use self::apart::{JoinedBlocks, join, reduce};
use self::begun::begun;
pub use self::block::{FitQuestion, TakeBlock};
pub use self::blocks::{ReduceJob, ReducedLine, SolveJob, reduce_files, solve_files};
pub use self::job::{FitInput, FitJob, FitStop, HoldOut};
use self::members::{agreed, evenly, in_order};
pub use self::names::AskedNames;
use self::search::{STOPPED, settled};
use self::take::Member;
use self::tell::ToldFit;
pub use self::written::FittedTakes;
use self::written::written;

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
            let upto = |number: usize| (number as f64 * share).floor() as usize;
            evenly(members.iter().map(|of| of.asked.is_ok()), upto)
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
    if own.iter().all(Option::is_none) {
        let mut fitted = members.iter().filter(|of| !of.is_held_out);
        let why =
            fitted.find_map(|of| Some((&of.file, of.asked.as_ref().ok()?.motion.as_ref().err()?)));
        bail!(
            "no take has a motion that can be asked{}",
            why.map_or(String::new(), |(file, why)| format!(": {file}: {why}"))
        );
    }
    let mut joint = JointSearch::new(parameters, &own);
    let all = vec![true; members.len()];
    let shares = settled(&mut joint, members, &all, stop)?;
    Ok((joint, shares))
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
