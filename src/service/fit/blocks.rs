//! Blocks in a folder: `round-N/question.json` says where takes are asked in a round, and each take has a file beside it. A file
//! that is there is kept, so that whatever ended in between goes on from there.

use std::path::{Path, PathBuf};

use anyhow::{Context, bail, ensure};
use rayon::prelude::*;
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::apart::{JoinedBlocks, join, reduce};
use super::block::{FitQuestion, TakeBlock};
use super::job::FitInput;
use super::names::AskedNames;
use crate::ingest::{read_text, read_whole};
use crate::service::output::{refuse_present, write_file_of, write_new_file};
use crate::service::provenance::sha256;
use crate::service::working::Working;

const QUESTION: &str = "question.json";

/// The input of [`reduce_files`].
#[derive(Clone, Debug)]
pub struct ReduceJob {
    /// The recordings.
    pub inputs: Vec<PathBuf>,
    /// Scene file for all; each recording's own scene by default.
    pub scene: Option<PathBuf>,
    /// Names of quantities that have one value in all takes,
    pub shared: Vec<String>,
    /// and of those that each take draws about a mean.
    pub drawn: Vec<String>,
    /// The folder of the blocks; made if it is not there.
    pub folder: PathBuf,
}

/// The input of [`solve_files`].
#[derive(Clone, Debug)]
pub struct SolveJob {
    /// The folder of the blocks.
    pub folder: PathBuf,
    /// Where the answer goes as a calibration; by default it is only returned.
    pub output: Option<PathBuf>,
    /// Where a page of it goes, if anywhere; a page that is there is replaced.
    pub page: Option<PathBuf>,
}

/// What [`reduce_files`] did.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct ReducedLine {
    /// The round.
    pub round: usize,
    /// Takes of which a block was made,
    pub made: usize,
    /// of which one was there,
    pub present: usize,
    /// and which are not asked in this round.
    pub not_asked: usize,
    /// Of blocks that were made: takes that say nothing, with the reason.
    pub silent: Vec<String>,
}

enum BlockMade {
    Made(Option<String>),
    Present,
    NotAsked,
}

/// Makes the block of every take in the round that the folder asks for.
pub fn reduce_files(job: &ReduceJob) -> anyhow::Result<ReducedLine> {
    let names = AskedNames::new(&job.shared, &job.drawn)?;
    let question = last_question(&job.folder)?;
    let round = question.as_ref().map_or(0, |of| of.round);
    let folder = round_folder(&job.folder, round);
    std::fs::create_dir_all(&folder)
        .with_context(|| format!("{}: cannot make the folder", folder.display()))?;
    let working = Working::of(job.inputs.len());
    let all: Vec<BlockMade> = job
        .inputs
        .par_iter()
        .map(|input| {
            let one = reduced(job, input, &names, question.as_ref(), &folder);
            working.done();
            one
        })
        .collect::<anyhow::Result<_>>()?;
    let mut line = ReducedLine {
        round,
        ..ReducedLine::default()
    };
    for (input, one) in job.inputs.iter().zip(all) {
        match one {
            BlockMade::Present => line.present += 1,
            BlockMade::NotAsked => line.not_asked += 1,
            BlockMade::Made(why) => {
                line.made += 1;
                let why = why.map(|why| format!("{}: {why}", input.display()));
                line.silent.extend(why);
            }
        }
    }
    Ok(line)
}

fn reduced(
    job: &ReduceJob,
    input: &Path,
    names: &AskedNames,
    question: Option<&FitQuestion>,
    folder: &Path,
) -> anyhow::Result<BlockMade> {
    let bytes = read_whole(input)
        .with_context(|| format!("{}: cannot read the recording", input.display()))?;
    let path = folder.join(format!("{}.json", sha256(&bytes)));
    if path.exists() {
        return Ok(BlockMade::Present);
    }
    let name = input.to_owned();
    let scene = None;
    let input = FitInput::Bytes { name, bytes, scene };
    let Some(block) = reduce(&input, job.scene.as_deref(), names, question)? else {
        return Ok(BlockMade::NotAsked);
    };
    let text = serde_json::to_vec(&block)?;
    write_file_of(&path, &text, &[input.name()])?;
    let is_silent = block.share.is_none() && !block.is_left_alone;
    let why = is_silent.then(|| match (block.why, block.notes.last()) {
        (Some(why), _) => why,
        (None, Some(note)) if block.round == 0 => note.clone(),
        (None, _) => "no motion where it is asked".to_owned(),
    });
    Ok(BlockMade::Made(why))
}

/// Joins the blocks in a folder; where takes are to be asked again, writes the question into it.
pub fn solve_files(job: &SolveJob) -> anyhow::Result<JoinedBlocks> {
    if let Some(output) = &job.output {
        refuse_present(output)?;
    }
    let mut blocks: Vec<TakeBlock> = Vec::new();
    let mut asked: Vec<FitQuestion> = Vec::new();
    for round in 0.. {
        let folder = round_folder(&job.folder, round);
        if !folder.is_dir() {
            break;
        }
        for path in files(&folder)? {
            match path.file_name() == Some(QUESTION.as_ref()) {
                true => asked.push(read(&path)?),
                false => blocks.push(read(&path)?),
            }
        }
    }
    ensure!(
        !blocks.is_empty(),
        "{}: no blocks, expected a folder that fit --reduce wrote into",
        job.folder.display()
    );
    let joined = join(&blocks, job.output.clone(), job.page.clone())?;
    if let JoinedBlocks::Asks(question) = &joined {
        let folder = round_folder(&job.folder, question.round);
        let path = folder.join(QUESTION);
        match asked.iter().find(|of| of.round == question.round) {
            Some(before) if before == question => {}
            Some(_) => bail!(
                "{}: asks elsewhere than these blocks lead, expected no takes to come once the search has begun:                  another folder",
                path.display()
            ),
            None => {
                std::fs::create_dir_all(&folder)
                    .with_context(|| format!("{}: cannot make the folder", folder.display()))?;
                write_new_file(&path, &serde_json::to_vec(question)?, &[])?;
            }
        }
    }
    Ok(joined)
}

fn round_folder(folder: &Path, round: usize) -> PathBuf {
    folder.join(format!("round-{round}"))
}

/// The question of the last round; none before the first was joined.
fn last_question(folder: &Path) -> anyhow::Result<Option<FitQuestion>> {
    let rounds = (1..).map(|round| round_folder(folder, round).join(QUESTION));
    match rounds.take_while(|path| path.is_file()).last() {
        Some(path) => Ok(Some(read(&path)?)),
        None => Ok(None),
    }
}

/// JSON files of a folder, in the order of their names.
fn files(folder: &Path) -> anyhow::Result<Vec<PathBuf>> {
    let unread = || format!("{}: cannot list the folder", folder.display());
    let entries = std::fs::read_dir(folder).with_context(unread)?;
    let paths: Result<Vec<PathBuf>, _> = entries.map(|of| Ok(of?.path())).collect();
    let mut paths = paths
        .map_err(|error: std::io::Error| error)
        .with_context(unread)?;
    paths.retain(|path| path.extension().is_some_and(|of| of == "json"));
    paths.sort();
    Ok(paths)
}

fn read<T: DeserializeOwned>(path: &Path) -> anyhow::Result<T> {
    let text = read_text(path).with_context(|| format!("{}: cannot read it", path.display()))?;
    serde_json::from_str(&text).with_context(|| {
        format!(
            "{}: expected what fit --reduce or --solve wrote",
            path.display()
        )
    })
}
