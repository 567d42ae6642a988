//! What people see on a terminal while a job takes long: each of them reads from a pipe that stays open until the
//! terminal, a pseudo-terminal, says so.

use std::fs::{self, File, OpenOptions};
use std::io::{Read, Write};
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::mpsc::{self, Receiver};
use std::thread;
use std::time::Duration;

use enact_tools::replay::Program;
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{Winsize, tcsetwinsize};
use tempfile::TempDir;

const ENACT: Program = Program(env!("CARGO_BIN_EXE_enact"));

/// Whatever is not there after so long does not come.
const LONG: Duration = Duration::from_secs(300);

/// A line of a terminal in the making.
#[derive(Default)]
struct Screen {
    lines: Vec<String>,
    line: String,
    is_at_begin: bool,
}

impl Screen {
    /// Shows what was written: text, ends of lines, and the two ways in which a line is begun again and cleared.
    fn show(&mut self, text: &str) {
        let mut rest = text;
        while let Some(next) = rest.chars().next() {
            if let Some(after) = rest.strip_prefix("\u{1b}[2K") {
                self.line.clear();
                rest = after;
                continue;
            }
            assert_ne!(next, '\u{1b}', "{rest:?}");
            match next {
                '\n' => self.lines.push(std::mem::take(&mut self.line)),
                '\r' => self.is_at_begin = true,
                _ => {
                    if std::mem::take(&mut self.is_at_begin) {
                        self.line.clear();
                    }
                    self.line.push(next);
                }
            }
            rest = &rest[next.len_utf8()..];
        }
    }
}

/// A pseudo-terminal: what is written to it, piece by piece, and what programs write to.
fn terminal() -> (Receiver<Vec<u8>>, File) {
    let controller = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).expect("a pseudo-terminal");
    grantpt(&controller).expect("granted");
    unlockpt(&controller).expect("unlocked");
    let size = Winsize {
        ws_row: 24,
        ws_col: 80,
        ws_xpixel: 0,
        ws_ypixel: 0,
    };
    tcsetwinsize(&controller, size).expect("a size");
    let name = ptsname(&controller, Vec::new()).expect("a name");
    let name = Path::new(std::ffi::OsStr::from_bytes(name.as_bytes()));
    let written = OpenOptions::new().read(true).write(true).open(name);
    let (sender, receiver) = mpsc::channel();
    thread::spawn(move || {
        let mut controller = File::from(controller);
        let mut piece = [0; 4096];
        // It fails once nobody has it open for writing.
        while let Ok(count @ 1..) = controller.read(&mut piece) {
            if sender.send(piece[..count].to_vec()).is_err() {
                return;
            }
        }
    });
    (receiver, written.expect("the terminal"))
}

/// What the terminal said while the input was awaited, what it shows in the end, and stdout.
struct Seen {
    awaiting: String,
    screen: Screen,
    stdout: String,
}

/// Runs a command that reads that from its stdin.
fn seen(arguments: &[&str], input: &[u8]) -> Seen {
    let (pieces, written) = terminal();
    let mut child = Command::new(ENACT.0)
        .args(arguments)
        .env_remove("RUST_LOG")
        .env_remove("NO_COLOR")
        .env("TERM", "xterm")
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::from(written))
        .spawn()
        .expect("it runs");
    let mut all = Vec::new();
    let is_said = |all: &[u8]| String::from_utf8_lossy(all).contains("00:00:01 ");
    while !is_said(&all) {
        let piece = pieces.recv_timeout(LONG);
        all.extend(piece.unwrap_or_else(|error| panic!("{arguments:?}: {error}, {all:?}")));
    }
    let awaiting = String::from_utf8_lossy(&all).into_owned();
    let mut stdin = child.stdin.take().expect("a pipe");
    stdin.write_all(input).expect("written");
    drop(stdin);
    let output = child.wait_with_output().expect("it ends");
    all.extend(pieces.iter().flatten());
    let mut screen = Screen::default();
    screen.show(&String::from_utf8(all).expect("UTF-8"));
    Seen {
        awaiting,
        screen,
        stdout: String::from_utf8(output.stdout).expect("UTF-8"),
    }
}

fn recording(name: &str) -> PathBuf {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    root.join("recordings").join(name)
}

#[test]
fn jobs_over_a_second_say_what_they_do_and_leave_no_trace() {
    let folder = TempDir::new().expect("folder");
    let at = |name: &str| folder.path().join(name).display().to_string();
    let acted = fs::read(recording("pencil_tip.mcap")).expect("a recording");
    let copy = folder.path().join("tip.mcap");
    fs::write(&copy, &acted).expect("copy");
    let estimate = ENACT.report(&copy, &[]).output;
    let estimated = fs::read(&estimate).expect("an estimate");
    let exported = Command::new(ENACT.0)
        .args(["export", "--to", "tum", "-o", "-"])
        .arg(&estimate)
        .output();
    let table = exported.expect("it runs").stdout;
    for name in ["in.mcap", "in.csv"] {
        symlink("/dev/stdin", folder.path().join(name)).expect("a link");
    }
    let (input, rows) = (at("in.mcap"), at("in.csv"));
    let out = at("out.mcap");
    for (arguments, bytes, said, written) in [
        (
            vec!["replay", "-", "-o", &out],
            &acted,
            "reading",
            "written",
        ),
        (
            vec!["predict", &input, "-o", &out],
            &acted,
            "reading",
            "written",
        ),
        (
            vec!["process", &input, "-o", &at("all")],
            &acted,
            "0/1",
            "written",
        ),
        (
            vec!["sketch", &input, "--estimated", "-o", &at("s.csv")],
            &acted,
            "reading",
            "written",
        ),
        (
            vec!["mark", &input, "--propose"],
            &acted,
            "proposing marks",
            "bounce",
        ),
        (
            vec!["import", &rows, "-o", &out],
            &table,
            "in.csv",
            "written",
        ),
        (vec!["inspect", &input], &acted, "reading", "pencil"),
        (
            vec!["calibrate", "gravity", &input, "-o", &at("g.toml")],
            &acted,
            "calibrating",
            "",
        ),
        (
            vec!["export", &input, "--to", "glb", "-o", &at("x.glb")],
            &estimated,
            "reading",
            "written",
        ),
        (
            vec!["report", &input, "-o", &at("x.html")],
            &estimated,
            "reading",
            "written",
        ),
    ] {
        let seen = seen(&arguments, bytes);
        assert!(
            seen.awaiting.contains(said),
            "{arguments:?}: {:?}",
            seen.awaiting
        );
        assert_eq!(seen.screen.line, "", "{arguments:?}");
        let left = seen.screen.lines.iter();
        let left: Vec<_> = left.filter(|line| line.contains("00:00:01 ")).collect();
        assert!(left.is_empty(), "{arguments:?}: {left:?}");
        assert!(
            seen.stdout.contains(written),
            "{arguments:?}: {}",
            seen.stdout
        );
        assert!(!seen.stdout.contains("00:00:01 "), "{}", seen.stdout);
    }
}
