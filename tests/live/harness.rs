//! A house for one test: its iceoryx2, its takes, its daemon, its trackers.

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use clap::Parser;
use serde_json::Value;
use tempfile::TempDir;

use enact::ingest::live::{Token, token_of_daemon};
use enact_tools::tracker;

/// Not a test: the tracker, when a test starts its binary again as another process.
#[test]
#[ignore = "a process of other tests"]
fn tracker_process() {
    let Ok(line) = std::env::var("ENACT_TEST_TRACKER") else {
        return;
    };
    let arguments = tracker::Arguments::parse_from(line.split('\n'));
    let sent = tracker::run(&arguments).expect("publish");
    println!("\n{}", serde_json::to_string(&sent).expect("json"));
}

/// Longer than anything takes, even on a busy machine.
const PATIENCE: Duration = Duration::from_secs(60);

/// How long a process of a test lives at the most, whatever became of the test.
pub const LIFETIME: Duration = Duration::from_secs(300);

/// A loop's deadline: what is waited for comes, or the test fails.
pub struct Patience {
    begun: Instant,
}

impl Patience {
    pub fn new() -> Self {
        Self {
            begun: Instant::now(),
        }
    }

    /// Fails when it is at its end; `what` is waited for.
    pub fn check(&self, what: &str) {
        assert!(self.begun.elapsed() < PATIENCE, "waited in vain: {what}");
    }

    fn left(&self) -> Duration {
        PATIENCE.saturating_sub(self.begun.elapsed())
    }
}

/// Waits for the end of a process; if it does not come, kills it and fails.
pub fn ended(child: Child) -> Output {
    let id = child.id().to_string();
    let (sender, output) = channel();
    // What it says is read while it runs: a full pipe would hold it up.
    std::thread::spawn(move || sender.send(child.wait_with_output()));
    output.recv_timeout(PATIENCE).map_or_else(
        |_| {
            let _ = Command::new("kill").args(["-s", "KILL", &id]).status();
            panic!("process {id} does not end")
        },
        |output| output.expect("wait"),
    )
}

/// Kills a process without a word.
pub fn kill(mut child: Child) {
    child.kill().expect("kill");
    child.wait().expect("wait");
}

/// Runs a process to its end.
fn run(mut command: Command) -> std::io::Result<Output> {
    let piped = command.stdout(Stdio::piped()).stderr(Stdio::piped());
    piped.spawn().map(ended)
}

/// Runs `enact` and returns what it says; it must finish, whatever the verdict.
pub fn enact(arguments: &[&str]) -> String {
    let mut command = Command::new(env!("CARGO_BIN_EXE_enact"));
    command.args(arguments);
    let output = run(command).expect("enact");
    let (said, error) = (text(&output.stdout), text(&output.stderr));
    let is_finished = matches!(output.status.code(), Some(0 | 3));
    assert!(is_finished, "{arguments:?}: {said}{error}");
    said
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

pub fn bytes(path: &Path) -> Vec<u8> {
    std::fs::read(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Everything that a test leaves is in here, but for shared memory of what was killed, which
/// goes with the house.
pub struct House {
    whole: TempDir,
    takes: PathBuf,
    iceoryx2: PathBuf,
    prefix: String,
}

impl House {
    pub fn new() -> Self {
        let folder = tempfile::tempdir().expect("folder");
        let name = folder.path().file_name().expect("name").to_string_lossy();
        let prefix = format!("enact{}_", name.replace(['.', '-'], ""));
        let root = folder.path().join("iceoryx2");
        let iceoryx2 = folder.path().join("iceoryx2.toml");
        let toml = format!(
            "[global]\nroot-path = \"{}/\"\nprefix = \"{prefix}\"\n",
            root.display()
        );
        std::fs::write(&iceoryx2, toml).expect("write");
        let takes = folder.path().join("takes");
        std::fs::create_dir(&takes).expect("make");
        Self {
            whole: folder,
            takes,
            iceoryx2,
            prefix,
        }
    }

    /// Folder of the user's data.
    pub fn data(&self) -> PathBuf {
        self.whole.path().join("data")
    }

    pub fn iceoryx2(&self) -> &Path {
        &self.iceoryx2
    }

    /// The token of the daemon, once it has one.
    pub fn token(&self) -> Token {
        let patience = Patience::new();
        loop {
            patience.check("a token");
            if let Ok(Some(token)) = token_of_daemon(Some(&self.iceoryx2)) {
                return token;
            }
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    /// Where takes go.
    pub fn folder(&self) -> &Path {
        &self.takes
    }

    pub fn path(&self, text: &str) -> PathBuf {
        PathBuf::from(text)
    }

    pub fn text<'a>(&self, path: &'a Path) -> &'a str {
        path.to_str().expect("UTF-8")
    }

    fn named(&self, is_it: impl Fn(&str) -> bool) -> Vec<PathBuf> {
        let entries = std::fs::read_dir(self.folder()).expect("list");
        let mut paths: Vec<PathBuf> = entries.map(|entry| entry.expect("entry").path()).collect();
        paths.retain(|path| is_it(&path.to_string_lossy()));
        paths.sort();
        paths
    }

    pub fn parts(&self) -> Vec<PathBuf> {
        self.named(|name| name.ends_with(".part"))
    }

    pub fn recordings(&self) -> Vec<PathBuf> {
        self.named(|name| name.ends_with(".mcap"))
    }

    pub fn spawn_enact(&self, arguments: &[&str]) -> Child {
        let mut command = self.command(arguments);
        command.stdout(Stdio::null()).spawn().expect("enact")
    }

    /// Runs `enact`; its output, whatever its end.
    pub fn enact(&self, arguments: &[&str]) -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_enact"));
        command.args(arguments);
        run(command).expect("enact")
    }

    /// Directs the daemon; its exit code, and what is said on stdout and on stderr.
    pub fn take(&self, arguments: &[&str]) -> (Option<i32>, String, String) {
        let output = self.enact_with_iceoryx2(&[&["take"], arguments].concat());
        (
            output.status.code(),
            text(&output.stdout),
            text(&output.stderr),
        )
    }

    pub fn enact_with_iceoryx2(&self, arguments: &[&str]) -> Output {
        run(self.command(arguments)).expect("enact")
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_enact"));
        command.args(arguments);
        command.arg("--iceoryx2").arg(&self.iceoryx2);
        command
    }

    /// The same as another user, who may look and not touch; `None` where that cannot be done.
    pub fn enact_as_nobody(&self, arguments: &[&str]) -> Option<Output> {
        use std::os::unix::fs::{MetadataExt, PermissionsExt};
        use std::os::unix::process::CommandExt;
        const NOBODY: u32 = 65_534;
        let is_root = std::fs::metadata("/proc/self").is_ok_and(|of_self| of_self.uid() == 0);
        if !is_root {
            return None;
        }
        let open_to_all = std::fs::Permissions::from_mode(0o755);
        std::fs::set_permissions(self.whole.path(), open_to_all).expect("permissions");
        let mut command = self.command(arguments);
        command.uid(NOBODY).gid(NOBODY);
        run(command).ok()
    }

    /// Runs a daemon that must fail; what it says.
    pub fn daemon_fails(&self, scene: &str) -> String {
        let takes = self.text(self.folder());
        let output = self.enact_with_iceoryx2(&["capture", scene, "-o", takes]);
        assert_eq!(output.status.code(), Some(1));
        text(&output.stderr)
    }

    /// The tracker as another process: this binary again.
    pub fn spawn_tracker(&self, arguments: &[&str]) -> Child {
        let line = [
            &["tracker"],
            arguments,
            &["--iceoryx2", self.text(&self.iceoryx2)],
        ]
        .concat();
        Command::new(std::env::current_exe().expect("this binary"))
            .args([
                "--ignored",
                "--exact",
                "harness::tracker_process",
                "--nocapture",
            ])
            .env("ENACT_TEST_TRACKER", line.join("\n"))
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("spawn")
    }

    /// Runs a tracker to its end; what it says it has sent.
    pub fn tracker(&self, arguments: &[&str]) -> Value {
        let output = ended(self.spawn_tracker(arguments));
        let said = text(&output.stdout);
        let error = text(&output.stderr);
        assert!(output.status.success(), "{arguments:?}: {said}{error}");
        let line = said
            .lines()
            .find(|line| line.starts_with('{'))
            .expect("a line");
        serde_json::from_str(line).expect("json")
    }

    /// Runs a tracker that is to be killed.
    pub fn tracker_that_dies(&self, arguments: &[&str]) {
        let output = ended(self.spawn_tracker(arguments));
        assert!(!output.status.success(), "it lives");
    }
}

impl Drop for House {
    fn drop(&mut self) {
        let Ok(entries) = std::fs::read_dir("/dev/shm") else {
            return;
        };
        for entry in entries.flatten() {
            if entry
                .file_name()
                .to_string_lossy()
                .starts_with(&self.prefix)
            {
                let _ = std::fs::remove_file(entry.path());
            }
        }
    }
}

/// A daemon, and what it says.
pub struct Daemon {
    child: Child,
    said: Receiver<Value>,
    /// CaptureEvent and not asked for yet.
    kept: Vec<Value>,
    house: (PathBuf, PathBuf),
    /// What it said first.
    pub ready: Value,
}

impl Daemon {
    /// Starts one and waits until it is ready.
    pub fn start(house: &House, scene: &str, arguments: &[&str]) -> Self {
        let mut command = Command::new(env!("CARGO_BIN_EXE_enact"));
        command.env("XDG_DATA_HOME", house.data());
        command.args(["capture", scene, "-o", house.text(house.folder())]);
        command.args(arguments);
        command.arg("--iceoryx2").arg(house.iceoryx2());
        command.args(["--format", "ndjson"]);
        Self::read(house, command)
    }

    /// Starts one whose account nobody reads.
    pub fn start_unread(house: &House, scene: &str) -> Self {
        let mut command = Command::new(env!("CARGO_BIN_EXE_enact"));
        command.args(["capture", scene, "-o", house.text(house.folder())]);
        command.arg("--iceoryx2").arg(house.iceoryx2());
        command.args(["--format", "ndjson"]);
        let child = command.stdout(Stdio::piped()).spawn().expect("daemon");
        let (_, said) = channel();
        Self {
            child,
            said,
            kept: Vec::new(),
            house: (house.folder().to_owned(), house.iceoryx2().to_owned()),
            ready: Value::Null,
        }
    }

    /// The same with that many descriptors.
    pub fn start_with_descriptors(
        house: &House,
        scene: &str,
        arguments: &[&str],
        descriptors: usize,
    ) -> Self {
        let mut command = Command::new("sh");
        let script = format!("ulimit -n {descriptors} && exec \"$0\" \"$@\"");
        command.args(["-c", &script, env!("CARGO_BIN_EXE_enact"), "capture", scene]);
        command.arg("-o").arg(house.folder());
        command.args(arguments);
        command.arg("--iceoryx2").arg(house.iceoryx2());
        command.args(["--format", "ndjson"]);
        Self::read(house, command)
    }

    /// The same with a file system of that size for its takes, if one may be mounted.
    pub fn start_on_small_disk(
        house: &House,
        scene: &str,
        size: &str,
        arguments: &str,
    ) -> Option<Self> {
        let unshared = |script: &str| {
            let mut command = Command::new("unshare");
            command.args(["--user", "--map-root-user", "--mount", "sh", "-c", script]);
            command.arg("sh").arg(house.folder());
            command
        };
        let mount = format!("mount -t tmpfs -o size={size} tmpfs \"$1\"");
        let may = run(unshared(&mount)).is_ok_and(|output| output.status.success());
        if !may {
            return None;
        }
        let enact = env!("CARGO_BIN_EXE_enact");
        let script = format!(
            "{mount} && exec {enact} capture {scene} -o \"$1\" --iceoryx2 {} --format ndjson {arguments}",
            house.iceoryx2().display()
        );
        Some(Self::read(house, unshared(&script)))
    }

    fn read(house: &House, mut command: Command) -> Self {
        let mut child = command.stdout(Stdio::piped()).spawn().expect("daemon");
        let lines = BufReader::new(child.stdout.take().expect("piped")).lines();
        let (sender, said) = channel();
        std::thread::spawn(move || {
            for line in lines.map_while(Result::ok) {
                let value = serde_json::from_str(&line).expect("json");
                if sender.send(value).is_err() {
                    return;
                }
            }
        });
        let mut daemon = Self {
            child,
            said,
            kept: Vec::new(),
            house: (house.folder().to_owned(), house.iceoryx2().to_owned()),
            ready: Value::Null,
        };
        daemon.ready = daemon.wait_for("ready");
        daemon
    }

    /// The next thing of that kind that it says.
    pub fn wait_for(&mut self, what: &str) -> Value {
        if let Some(at) = self.kept.iter().position(|said| said["what"] == what) {
            return self.kept.remove(at);
        }
        let patience = Patience::new();
        loop {
            let said = self.said.recv_timeout(patience.left());
            let said = said.unwrap_or_else(|_| panic!("no {what:?}, only {:?}", self.kept));
            if said["what"] == what {
                return said;
            }
            self.kept.push(said);
        }
    }

    /// How many things of that kind it said before what was waited for last, and nobody asked for.
    pub fn kept(&self, what: &str) -> usize {
        self.kept.iter().filter(|said| said["what"] == what).count()
    }

    /// Waits until that many samples are in the journal: the daemon says nothing of each.
    pub fn wait_until_journalled(&mut self, samples: u64) {
        let begun = Instant::now();
        while self.journalled() < samples {
            assert!(begun.elapsed() < PATIENCE, "{} samples", self.journalled());
            std::thread::sleep(Duration::from_millis(2));
        }
    }

    /// The journal that is being written.
    fn journal(&self) -> Option<PathBuf> {
        let entries = std::fs::read_dir(&self.house.0).expect("list").flatten();
        let mut parts = entries.map(|entry| entry.path());
        parts.find(|path| path.to_string_lossy().ends_with(".part"))
    }

    /// Waits until the journal grows, then for that long. The longest that this thread was kept
    /// from running meanwhile: a machine so busy may have kept the daemon, too.
    pub fn wait_after_growth(&self, after: Duration) -> Duration {
        const STEP: Duration = Duration::from_millis(1);
        let part = self.journal().expect("a journal");
        let length = || std::fs::metadata(&part).expect("there").len();
        let (patience, before) = (Patience::new(), length());
        while length() == before {
            patience.check("the journal grows");
            std::thread::sleep(STEP);
        }
        let grown = Instant::now();
        let mut stalled = Duration::ZERO;
        while grown.elapsed() < after {
            let begun = Instant::now();
            std::thread::sleep(STEP);
            stalled = stalled.max(begun.elapsed() - STEP);
        }
        stalled
    }

    /// Samples in the journal that is being written.
    fn journalled(&self) -> u64 {
        let Some(part) = self.journal() else {
            return 0;
        };
        let Ok(recording) = enact::ingest::Recording::open(&part) else {
            return 0;
        };
        let channels = recording.container().channels().values();
        let raw = channels.filter(|channel| channel.topic.starts_with("/capture/tracker"));
        raw.map(|channel| channel.messages).sum()
    }

    /// Kills it without a word; when [ns since 1970].
    pub fn kill(&mut self) -> i64 {
        let now = std::time::SystemTime::now();
        let since = now
            .duration_since(std::time::UNIX_EPOCH)
            .expect("after 1970");
        self.child.kill().expect("kill");
        self.child.wait().expect("wait");
        since.as_nanos() as i64
    }

    pub fn terminate(&self) {
        self.signal("TERM");
    }

    pub fn signal(&self, name: &str) {
        let id = self.child.id().to_string();
        let killed = Command::new("kill").args(["-s", name, &id]).status();
        assert!(killed.expect("kill").success());
    }

    /// Stops it, all its threads: a signal alone may reach it later.
    pub fn stop(&self) {
        self.signal("STOP");
        let tasks = format!("/proc/{}/task", self.child.id());
        let is_stopped = |task: std::fs::DirEntry| {
            let stat = std::fs::read_to_string(task.path().join("stat")).unwrap_or_default();
            // The state follows the name in parentheses.
            stat.rsplit(')')
                .next()
                .is_some_and(|rest| rest.trim_start().starts_with('T'))
        };
        let begun = Instant::now();
        while !std::fs::read_dir(&tasks)
            .expect("its threads")
            .flatten()
            .all(is_stopped)
        {
            assert!(begun.elapsed() < PATIENCE, "it does not stop");
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    /// Waits for its end; its exit code.
    pub fn finished(&mut self) -> Option<i32> {
        let begun = Instant::now();
        loop {
            if let Some(status) = self.child.try_wait().expect("wait") {
                return status.code();
            }
            assert!(begun.elapsed() < PATIENCE, "it does not end");
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    /// Ends it: everything that came is in the files.
    pub fn end(&mut self) {
        self.end_with(0);
    }

    /// Ends it, with an exit code.
    pub fn end_with(&mut self, expected: i32) {
        self.terminate();
        assert_eq!(self.finished(), Some(expected));
    }

    /// Its process id.
    pub fn id(&self) -> u32 {
        self.child.id()
    }

    /// Where it sees a path.
    pub fn seen(&self, path: &Path) -> PathBuf {
        PathBuf::from(format!("/proc/{}/root{}", self.child.id(), path.display()))
    }

    /// Memory that it holds itself \[bytes\].
    pub fn memory_bytes(&self) -> u64 {
        let status = format!("/proc/{}/status", self.child.id());
        let status = std::fs::read_to_string(status).expect("status");
        let line = status
            .lines()
            .find_map(|line| line.strip_prefix("RssAnon:"));
        let words = line.expect("RssAnon").split_whitespace().next();
        1024 * words.expect("kB").parse::<u64>().expect("number")
    }

    /// Copies a file that only it can see.
    pub fn copy_out(&self, from: &str, to: &Path) {
        let seen = format!("/proc/{}/root{from}", self.child.id());
        std::fs::copy(seen, to).expect("copy");
    }

    /// Waits until nothing killed is left on iceoryx2.
    pub fn wait_until_cleared(&mut self, patience: Duration) {
        use enact::ingest::live::census::{Liveness, census};
        let begun = Instant::now();
        let is_dead = || {
            let found = census(Some(&self.house.1)).expect("census");
            found.nodes.iter().any(|node| node.state != Liveness::Alive)
        };
        while is_dead() {
            assert!(begun.elapsed() < patience, "not cleared");
            std::thread::sleep(Duration::from_millis(20));
        }
    }
}

impl Drop for Daemon {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
