//! Recoveries that are killed: the next run ends as one that was not.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use enact::write::recover;
use rand::{RngExt, SeedableRng};

use super::Desk;
use crate::journals::{Written, journal};

/// The files of a folder.
type Files = BTreeMap<String, Vec<u8>>;

fn files(folder: &Path) -> Files {
    let entries = std::fs::read_dir(folder).expect("list");
    let file = |entry: std::io::Result<std::fs::DirEntry>| {
        let entry = entry.expect("an entry");
        let name = entry.file_name().to_string_lossy().into_owned();
        (name, std::fs::read(entry.path()).expect("read"))
    };
    entries.map(file).collect()
}

/// What a run leaves that nobody kills.
fn undisturbed(written: &Written) -> Files {
    let desk = Desk::with(&written.bytes);
    assert_eq!(desk.recover().0, 0);
    let files = files(desk.folder.path());
    assert_eq!(files.len(), 2);
    assert!(files["take.mcap.part.recovered"] == written.bytes);
    files
}

/// What a kill leaves between two calls of the system, one after the other.
#[test]
fn from_every_state_that_a_kill_leaves_the_next_run_ends_alike() {
    let written = journal(4, 30);
    let expected = undisturbed(&written);
    let recording = &expected["take.mcap"];
    for part in [0, 1, recording.len() / 2, recording.len()] {
        let desk = Desk::with(&written.bytes);
        let temporary = desk.folder.path().join(".take.mcap.writing");
        std::fs::write(temporary, &recording[..part]).expect("write");
        recover(&desk.part()).expect("recovered");
        assert!(files(desk.folder.path()) == expected, "{part}");
    }
    // The recording has its name, the journal its own still.
    let desk = Desk::with(&written.bytes);
    std::fs::write(desk.recording(), recording).expect("write");
    let (code, said) = desk.recover();
    assert_eq!(
        (code, &said["messages"]),
        (0, &written.messages.len().into())
    );
    assert!(files(desk.folder.path()) == expected);
    // Where a file system cannot rename without replacing, for a moment a file has two names.
    let desk = Desk::with(&written.bytes);
    std::fs::write(desk.recording(), recording).expect("write");
    let aside = desk.folder.path().join("take.mcap.part.recovered");
    std::fs::hard_link(desk.part(), aside).expect("link");
    assert_eq!(desk.recover().0, 0);
    assert!(files(desk.folder.path()) == expected);
    // So has a journal whose recorder is closing it.
    let desk = Desk::with(recording);
    std::fs::hard_link(desk.part(), desk.recording()).expect("link");
    assert_eq!(desk.recover().0, 0);
    assert_eq!(desk.names(), ["take.mcap"]);
    assert!(files(desk.folder.path())["take.mcap"] == *recording);
}

#[test]
fn a_recording_of_other_bytes_is_never_replaced() {
    let written = journal(4, 30);
    let mut other = undisturbed(&written)["take.mcap"].clone();
    let last = other.len() - 20;
    other[last] ^= 1;
    let desk = Desk::with(&written.bytes);
    std::fs::write(desk.recording(), &other).expect("write");
    assert_eq!(desk.recover().0, 1);
    assert_eq!(desk.names(), ["take.mcap", "take.mcap.part"]);
    assert!(std::fs::read(desk.recording()).expect("read") == other);
    assert!(std::fs::read(desk.part()).expect("read") == written.bytes);
}

/// The program, without what it says.
fn program(desk: &Desk) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_enact"));
    command.arg("recover").arg(desk.folder.path());
    command.stdout(Stdio::null()).stderr(Stdio::null());
    command
}

#[test]
fn killed_at_any_moment_the_next_run_ends_alike() {
    let written = journal(30, 60);
    let expected = undisturbed(&written);
    let begun = Instant::now();
    let desk = Desk::with(&written.bytes);
    assert!(program(&desk).status().expect("run").success());
    let takes = begun.elapsed();
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(77);
    for _ in 0..40 {
        let desk = Desk::with(&written.bytes);
        let mut child = program(&desk).spawn().expect("run");
        let share: f64 = random.random_range(0.0..1.2);
        std::thread::sleep(Duration::from_secs_f64(takes.as_secs_f64() * share));
        child.kill().expect("killed");
        child.wait().expect("gone");
        let left = files(desk.folder.path());
        let journals = left.values().filter(|bytes| **bytes == written.bytes);
        assert_eq!(journals.count(), 1, "{:?}", left.keys());
        assert_eq!(desk.recover().0, 0);
        assert!(files(desk.folder.path()) == expected, "{:?}", left.keys());
    }
}

/// Calls of the system by which files and folders are read and changed.
#[cfg(target_os = "linux")]
const CALLS: [&str; 12] = [
    "openat",
    "close",
    "flock",
    "read",
    "write",
    "lseek",
    "fsync",
    "renameat2",
    "unlink",
    "newfstatat",
    "statx",
    "getdents64",
];

/// Kills before each such call, the first, the second and so on until there are no more: strace
/// counts them.
#[cfg(target_os = "linux")]
#[test]
#[ignore = "takes a minute, needs strace: cargo test --test recover -- --ignored --nocapture every_call"]
fn killed_before_every_call_the_next_run_ends_alike() {
    use std::os::unix::process::ExitStatusExt;
    const KILLED: Option<i32> = Some(9);
    let written = journal(4, 30);
    let expected = undisturbed(&written);
    let mut left: BTreeMap<Vec<String>, usize> = BTreeMap::new();
    for call in CALLS {
        for count in 1.. {
            let desk = Desk::with(&written.bytes);
            let inject = format!("inject={call}:signal=KILL:when={count}");
            let mut command = Command::new("strace");
            command.args(["-f", "-qq", "-o", "/dev/null", "-e", &inject]);
            command.arg(env!("CARGO_BIN_EXE_enact"));
            command.arg("recover").arg(desk.folder.path());
            let status = command.stdout(Stdio::null()).status().expect("strace");
            if status.signal() != KILLED {
                assert!(status.success(), "{call} {count}: {status}");
                break;
            }
            *left.entry(desk.names()).or_default() += 1;
            desk.recover();
            assert!(files(desk.folder.path()) == expected, "{call} {count}");
        }
    }
    println!(
        "killed {} times, left: {left:?}",
        left.values().sum::<usize>()
    );
    // The journal alone, a temporary beside it, the recording, and the journal renamed.
    assert_eq!(left.len(), 4, "{left:?}");
}
