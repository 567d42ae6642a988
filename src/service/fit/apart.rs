//! Takes asked apart from each other, in other processes and on other machines.
//!
//! What a take says at values is a pure function of its recording, its scene and these values: a [`TakeBlock`], a few kilobytes.
//! Blocks are joined without the recordings. The search runs through the rounds of which blocks are there, and asks for the
//! next round ([`FitQuestion`]) or has the answer.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{bail, ensure};
use nalgebra::DVector;

use super::block::{FitQuestion, TakeBlock};
use super::job::{FitInput, FitJob, FitStop};
use super::members::{agreed, in_order};
use super::names::AskedNames;
use super::take::{AskedTake, Member};
use super::tell::{ToldFit, no_optimum};
use super::written::{FittedTakes, written};
use crate::config::SourceLine;
use crate::jointly::{JointSearch, SearchTurn};
use crate::motion::TakeShare;

/// What blocks come to.
#[derive(Clone, Debug)]
pub enum JoinedBlocks {
    /// Takes are to be asked again.
    Asks(FitQuestion),
    /// The answer.
    Fitted(Box<FittedTakes>),
}

/// What a take says where a question asks it, at its own values without one; `None` of one that is not asked. What is wrong with
/// the take is in its block; fails where the names mean nothing in its scene.
pub fn reduce(
    input: &FitInput,
    scene: Option<&Path>,
    names: &AskedNames,
    question: Option<&FitQuestion>,
) -> anyhow::Result<Option<TakeBlock>> {
    let mut member = Member::read(0, input, scene, names);
    if let (true, Err(why)) = (member.is_misnamed, &member.asked) {
        bail!("{}: {why}", member.file);
    }
    let values = match question {
        None => None,
        Some(question) => match question.asked.get(&member.sha256) {
            None => return Ok(None),
            asked => asked.cloned(),
        },
    };
    let mut block = TakeBlock {
        round: question.map_or(0, |of| of.round),
        shared: names.all[..names.shared].to_vec(),
        drawn: names.all[names.shared..].to_vec(),
        asked: values.clone(),
        share: None,
        is_misfit: false,
        why: member.asked.as_ref().err().cloned(),
        is_left_alone: member.is_left_alone,
        notes: member.notes.clone(),
        source: SourceLine {
            file: member.file.clone(),
            sha256: Some(member.sha256.clone()),
            ..SourceLine::default()
        },
        scene_toml: String::new(),
    };
    if let Ok(asked) = &mut member.asked {
        block.share = match values.map(DVector::from_vec) {
            None => {
                asked.find();
                asked.own()
            }
            Some(values) => asked_anew(asked, &values),
        };
        if let Some(share) = &block.share {
            block.is_misfit = asked.misfits(&share.values);
        } else if block.round == 0 {
            block.notes.extend(asked.motion.as_ref().err().cloned());
        }
        block.source = asked.source.clone();
        block.scene_toml = asked.scene_toml.clone();
    }
    Ok(Some(block))
}

/// What a take says at values from none of its motions on.
fn asked_anew(asked: &mut AskedTake, values: &DVector<f64>) -> Option<TakeShare> {
    if asked.again(values).is_none() {
        asked.find();
    }
    asked.at(values)
}

/// Joins the blocks of all rounds so far, in any order.
///
/// Fails where blocks are of other questions than those that this makes, and as [`fit`](super::fit()) does.
pub fn join(
    blocks: &[TakeBlock],
    output: Option<PathBuf>,
    page: Option<PathBuf>,
) -> anyhow::Result<JoinedBlocks> {
    let Some(first) = blocks.iter().find(|of| of.round == 0) else {
        bail!("no blocks of the first round, expected those of every take: fit --reduce");
    };
    let job = FitJob {
        inputs: Vec::new(),
        scene: None,
        shared: first.shared.clone(),
        drawn: first.drawn.clone(),
        hold_out: None,
        output,
        page,
        stop: FitStop::default(),
    };
    let names = AskedNames::new(&job.shared, &job.drawn)?;
    let is_asked_so = |of: &TakeBlock| of.shared == first.shared && of.drawn == first.drawn;
    if let Some(other) = blocks.iter().find(|of| !is_asked_so(of)) {
        bail!(
            "{}: its block has {} shared and {} drawn, expected {} and {} as in that of {}",
            other.source.file,
            other.shared.join(","),
            other.drawn.join(","),
            first.shared.join(","),
            first.drawn.join(","),
            first.source.file
        );
    }
    let rounds = BlockRounds::of(blocks);
    let begun = rounds.blocks(0);
    let mut begun: Vec<&TakeBlock> = begun.into_iter().flatten().map(|(_, of)| *of).collect();
    begun.sort_by(|a, b| a.source.file.cmp(&b.source.file));
    let members = begun.iter().enumerate();
    let members = members.map(|(place, of)| Member::of_block(place, of, &names));
    let mut members = in_order(members.collect());
    let parameters = agreed(&members, &names)?;
    let own = rounds.shares(0, &members);
    let mut joint = JointSearch::new(parameters, &own);
    for round in 1.. {
        let question = question(round, &joint, &members);
        if !rounds.answer(&question)? {
            return Ok(JoinedBlocks::Asks(question));
        }
        let shares = rounds.shares(round, &members);
        if round == 1 {
            joint.look(&shares);
        }
        match joint.turn(&shares) {
            SearchTurn::Again => {}
            SearchTurn::Found => {
                let misfits = rounds.misfits(round, &members);
                let told = ToldFit::of(&job, &joint, &shares, &mut members, &misfits)?;
                return Ok(JoinedBlocks::Fitted(Box::new(written(&job, told)?)));
            }
            SearchTurn::Lost => return no_optimum(&joint),
        }
    }
    unreachable!("rounds end")
}

fn question(round: usize, joint: &JointSearch, members: &[Member]) -> FitQuestion {
    let takes = members.iter().enumerate();
    let takes = takes.filter(|(take, _)| joint.is_taking_part(*take));
    let asked = takes.map(|(take, of)| {
        let values = joint.asked(take).iter().copied().collect();
        (of.sha256.clone(), values)
    });
    FitQuestion {
        round,
        asked: asked.collect(),
    }
}

/// Blocks by their rounds and recordings.
struct BlockRounds<'a>(BTreeMap<usize, BTreeMap<&'a str, &'a TakeBlock>>);

impl<'a> BlockRounds<'a> {
    fn of(blocks: &'a [TakeBlock]) -> Self {
        let mut rounds: BTreeMap<usize, BTreeMap<&str, &TakeBlock>> = BTreeMap::new();
        for block in blocks {
            let sha256 = block.source.sha256.as_deref().unwrap_or_default();
            rounds.entry(block.round).or_default().insert(sha256, block);
        }
        Self(rounds)
    }

    fn blocks(&self, round: usize) -> Option<&BTreeMap<&'a str, &'a TakeBlock>> {
        self.0.get(&round)
    }

    fn block(&self, round: usize, sha256: &str) -> Option<&'a TakeBlock> {
        self.blocks(round)?.get(sha256).copied()
    }

    /// Whether a question has its answers from every take.
    fn answer(&self, question: &FitQuestion) -> anyhow::Result<bool> {
        for (sha256, values) in &question.asked {
            let Some(block) = self.block(question.round, sha256) else {
                return Ok(false);
            };
            ensure!(
                block.asked.as_ref() == Some(values),
                "{}: its block of round {} was asked elsewhere, expected blocks of one fit only: another folder",
                block.source.file,
                question.round
            );
        }
        Ok(true)
    }

    fn shares(&self, round: usize, members: &[Member]) -> Vec<Option<TakeShare>> {
        let blocks = members.iter().map(|of| self.block(round, &of.sha256));
        blocks.map(|of| of?.share.clone()).collect()
    }

    fn misfits(&self, round: usize, members: &[Member]) -> Vec<bool> {
        let blocks = members.iter().map(|of| self.block(round, &of.sha256));
        blocks
            .map(|of| of.is_some_and(|block| block.is_misfit))
            .collect()
    }
}
