//! Studies of the estimator on performances whose truth is known, and on real tosses.
//!
//! ```text
//! cargo run --release -p enact-tools --bin measure -- study answer --seeds 200
//! cargo run --release -p enact-tools --bin measure -- study all
//! ```
//!
//! Every study prints its tables and leaves a page with them and its raw numbers in
//! `tools/study/results/`. One thread; run them on a machine that does nothing else if times matter.

use std::time::Instant;

use clap::{Args, Subcommand};

use crate::results::Options;
use crate::run::Run;
use crate::*;

/// Studies of the estimator.
#[derive(Args)]
pub struct Cli {
    #[command(flatten)]
    options: Options,
    #[command(subcommand)]
    study: Study,
}

#[derive(Clone, Copy, Subcommand)]
pub enum Study {
    /// How often the best known optimum is found, and what it takes.
    Answer,
    /// The same in scenes of several bodies and of many bounces.
    Scenes,
    /// Bodies of any size and speed, and how marks are made.
    Scales,
    /// How exactly exact performances are recovered.
    Accuracy,
    /// Whether errors are as large as the estimate says.
    Covariance,
    /// How often reported intervals hold the truth.
    Coverage,
    /// What more samples and more segments cost.
    Scaling,
    /// What touches, where scenes leave that open.
    Sequences,
    /// The same as sampled simulations propose it.
    Proposals,
    /// Where the time goes.
    Phases,
    /// Where methods fail: what is said then.
    Stress,
    /// Real tosses of a cube, if they are there.
    Tosses,
    /// Durations of real tosses told slowly.
    Durations,
    /// Outliers, wrong units, marks that are off or absent.
    Damage,
    /// Wrong models, right ones, and real recordings of no flight: what is called physical.
    Nonsense,
    /// All of them.
    All,
}

pub fn run(Cli { options, study }: Cli) -> anyhow::Result<()> {
    let all = [
        Study::Answer,
        Study::Scenes,
        Study::Scales,
        Study::Accuracy,
        Study::Covariance,
        Study::Coverage,
        Study::Scaling,
        Study::Sequences,
        Study::Proposals,
        Study::Phases,
        Study::Stress,
        Study::Tosses,
        Study::Durations,
        Study::Damage,
        Study::Nonsense,
    ];
    let one = [study];
    let chosen: &[Study] = if matches!(study, Study::All) {
        &all
    } else {
        &one
    };
    for study in chosen {
        let run = Run::here(false);
        let started = Instant::now();
        match study {
            Study::Answer => answer::run(&options)?,
            Study::Scenes => scenes::run(&options)?,
            Study::Scales => scales::run(&options)?,
            Study::Accuracy => accuracy::run(&options)?,
            Study::Covariance => covariance::run(&options)?,
            Study::Coverage => coverage::run(&options)?,
            Study::Scaling => scaling::run(&options)?,
            Study::Sequences => sequences::run(&options)?,
            Study::Proposals => proposals::run(&options)?,
            Study::Phases => phases::run(&options)?,
            Study::Stress => stress_table::run(&options)?,
            Study::Tosses => tosses::run(&options)?,
            Study::Durations => durations::run(&options)?,
            Study::Damage => damage::run(&options)?,
            Study::Nonsense => nonsense_table::run(&options)?,
            Study::All => {}
        }
        let seconds = started.elapsed().as_secs_f64();
        options.write_page(study.name(), study.about(), &Run { seconds, ..run })?;
    }
    Ok(())
}
