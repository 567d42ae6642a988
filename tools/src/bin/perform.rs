//! Makes recordings of acted motions whose truth is known.
//!
//! `cargo run --release -p enact-tools --bin perform -- --style tip --seed 7 -o pencil.mcap`

use std::path::PathBuf;

use anyhow::Context;
use clap::Parser;
use enact_tools::perform::recording;
use enact_tools::perform::wish::{Manner, Motion, Wanted};
use enact_tools::trees;

/// Make recordings of acted motions whose truth is known.
#[derive(Parser)]
struct Arguments {
    /// Make all recordings that the repository keeps, in the folder given by -o
    #[arg(long, conflicts_with_all = ["style", "bounces", "preset"])]
    all: bool,
    /// The motion
    #[arg(long, value_enum, required_unless_present_any = ["all", "bounces"])]
    style: Option<Motion>,
    /// Or a cube with this many bounces
    #[arg(long, conflicts_with = "style")]
    bounces: Option<usize>,
    /// The recording, or the folder with --all
    #[arg(short, long)]
    output: PathBuf,
    #[command(flatten)]
    manner: Manner,
}

fn main() -> anyhow::Result<()> {
    let arguments = Arguments::parse();
    if arguments.all {
        std::fs::create_dir_all(&arguments.output)
            .with_context(|| format!("making {}", arguments.output.display()))?;
        for kept in recording::kept() {
            let path = arguments.output.join(kept.name);
            kept.write(&path)?;
            println!("{}", path.display());
        }
        let (name, performance) = trees::kept();
        let path = arguments.output.join(name);
        performance.write(&path)?;
        println!("{}", path.display());
        return Ok(());
    }
    let wanted = match arguments.bounces {
        Some(count) => Wanted::Bounces(count),
        None => Wanted::Motion(arguments.style.unwrap_or(Motion::Tip)),
    };
    let (performance, scene_toml) = arguments.manner.perform(wanted)?;
    recording::write(&performance, &scene_toml, &arguments.output)?;
    println!("{}", arguments.output.display());
    Ok(())
}
