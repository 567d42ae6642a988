//! `completion`: writes completions of the arguments for a shell.

use clap::CommandFactory;

use super::arguments::Arguments;
use super::exit::Exit;
use super::output;

pub(super) fn run(shell: clap_complete::Shell) -> anyhow::Result<Exit> {
    let mut script = Vec::new();
    let mut command = Arguments::command();
    clap_complete::generate(shell, &mut command, "enact", &mut script);
    output::print(std::str::from_utf8(&script)?)?;
    Ok(Exit::Done)
}
