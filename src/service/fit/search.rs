//! The search among takes: where each is asked next, until the optimum stands and none is nearer to its samples elsewhere.

use anyhow::ensure;
use nalgebra::DVector;
use rayon::prelude::*;

use super::job::FitStop;
use super::take::{Member, UsualResidual};
use super::tell::no_optimum;
use crate::jointly::{JointSearch, SearchTurn};
use crate::motion::TakeShare;

/// Greatest number of times that takes which had no motion, or are far from it, are tried from the answer on.
const AGAIN: usize = 4;

/// Why a fit that was told to end has no answer.
pub(super) const STOPPED: &str = "it was told to end before it had an answer";

/// The optimum of those that are asked, in which none is nearer to its samples from there on; what they say there.
pub(super) fn settled(
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

/// Rounds until the optimum is found; what takes say there.
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
