//! The program as a user runs it.

use std::path::Path;
use std::process::{Command, Output};

/// What `enact` says in a folder with these arguments, without colours, whatever is set outside.
pub fn enact(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_enact"));
    command.current_dir(folder).args(arguments);
    command.env_remove("RUST_LOG").env("NO_COLOR", "1");
    command.output().expect("it runs")
}
