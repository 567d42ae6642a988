//! `manual`: writes man pages of the program and each of its commands.

use std::path::Path;

use anyhow::Context;
use clap::CommandFactory;
use clap_mangen::Man;

use super::arguments::Arguments;
use super::exit::Exit;
use super::output;
use crate::service::write_file;

/// Writes `enact.1`, `enact-replay.1`, … into a folder, which is made if it is not there.
pub(super) fn run(folder: &Path) -> anyhow::Result<Exit> {
    std::fs::create_dir_all(folder)
        .with_context(|| format!("{}: cannot make the folder", folder.display()))?;
    let mut command = Arguments::command();
    command.build();
    let mut written = String::new();
    page(folder, &command, &mut written)?;
    output::print(&written)?;
    Ok(Exit::Done)
}

fn page(folder: &Path, command: &clap::Command, written: &mut String) -> anyhow::Result<()> {
    let man = Man::new(command.clone());
    let path = folder.join(man.get_filename());
    let mut text = Vec::new();
    man.render(&mut text)?;
    write_file(&path, &text)?;
    written.push_str(&format!("{}\n", path.display()));
    let commands = command.get_subcommands();
    for command in commands.filter(|of| of.get_name() != "help") {
        page(folder, command, written)?;
    }
    Ok(())
}
