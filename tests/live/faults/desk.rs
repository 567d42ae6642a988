//! A folder in which the program runs, and calls of the system fail.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::OnceLock;

/// The library that makes calls fail, built once; `None` where that cannot be, which is recorded.
pub fn shim() -> Option<&'static Path> {
    static SHIM: OnceLock<Option<PathBuf>> = OnceLock::new();
    SHIM.get_or_init(build).as_deref()
}

fn build() -> Option<PathBuf> {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/live/faults/shim.c");
    let shim =
        Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("shim{}.so", std::process::id()));
    let compiler = std::env::var_os("CC").unwrap_or_else(|| "cc".into());
    let built = Command::new(compiler)
        .args(["-shared", "-fPIC", "-O1", "-Wall", "-Werror", "-o"])
        .arg(&shim)
        .arg(source)
        .status()
        .expect("a C compiler");
    assert!(built.success(), "the library of faults cannot be built");
    let probe = Command::new("true")
        .env("LD_PRELOAD", &shim)
        .env("FAULT", "open:1000000:5")
        .env("FAULT_BELOW", "/nothing/")
        .env("FAULT_FIRED", "/nothing/fired")
        .status()
        .expect("run");
    if probe.code() == Some(98) {
        crate::skip::skip("faults", "the system lets no process filter its calls");
        return None;
    }
    assert!(probe.success(), "{probe}");
    Some(shim)
}

/// The folder; beside it another for what is noted of a run.
pub struct Desk {
    folder: tempfile::TempDir,
    notes: tempfile::TempDir,
    shim: &'static Path,
}

/// How a run ended.
pub struct Run {
    /// `None` where it was killed.
    pub code: Option<i32>,
    /// Whether a fault happened.
    pub fired: bool,
    /// All it said.
    pub said: String,
}

impl Desk {
    /// An empty one; `None` where there are no faults to be had.
    pub fn new() -> Option<Self> {
        let shim = shim()?;
        // In memory, where there is such a place: files are synced, and there are hundreds.
        let memory = Path::new("/dev/shm");
        let make = || {
            if memory.is_dir() {
                tempfile::Builder::new().prefix("faults").tempdir_in(memory)
            } else {
                tempfile::Builder::new().prefix("faults").tempdir()
            }
        };
        Some(Self {
            folder: make().expect("folder"),
            notes: make().expect("folder"),
            shim,
        })
    }

    pub fn folder(&self) -> &Path {
        self.folder.path()
    }

    pub fn put(&self, name: &str, bytes: &[u8]) {
        std::fs::write(self.folder.path().join(name), bytes).expect("write");
    }

    /// Every file, by name.
    pub fn files(&self) -> BTreeMap<String, Vec<u8>> {
        let entries = std::fs::read_dir(self.folder.path()).expect("list");
        let file = |entry: std::io::Result<std::fs::DirEntry>| {
            let entry = entry.expect("an entry");
            let name = entry.file_name().to_string_lossy().into_owned();
            (name, std::fs::read(entry.path()).expect("read"))
        };
        entries.map(file).collect()
    }

    /// Runs `enact` in it, without faults if there are none.
    pub fn run(&self, arguments: &[&str], faults: &str) -> Run {
        let mut command = Command::new(env!("CARGO_BIN_EXE_enact"));
        command.args(arguments).current_dir(self.folder.path());
        self.run_command(command, faults)
    }

    /// Runs a command, with faults in calls on files below the folder.
    pub fn run_command(&self, mut command: Command, faults: &str) -> Run {
        let fired = self.notes.path().join("fired");
        let _ = std::fs::remove_file(&fired);
        if !faults.is_empty() {
            let below = self.folder.path().join("");
            command
                .env("LD_PRELOAD", self.shim)
                .env("FAULT", faults)
                .env("FAULT_BELOW", below)
                .env("FAULT_FIRED", &fired);
        }
        let output = command
            .env_remove("RUST_LOG")
            .stdin(Stdio::null())
            .output()
            .expect("run");
        let said = [output.stdout, output.stderr].concat();
        Run {
            code: output.status.code(),
            fired: fired.exists(),
            said: String::from_utf8_lossy(&said).into_owned(),
        }
    }
}
