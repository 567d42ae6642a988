//! Runs the program and watches what it costs.

use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// How a run of the program ended, and what it cost.
#[derive(Debug)]
pub struct Cost {
    /// `None` where a signal ended it.
    pub code: Option<i32>,
    pub stdout: String,
    pub stderr: String,
    /// Greatest resident size.
    pub peak_bytes: u64,
    /// Time of all its threads on the processors.
    pub processor_s: f64,
}

/// Runs the program, which is killed after a minute on the processors.
pub fn run(arguments: &[&str], folder: &Path) -> Cost {
    let (out, err) = (folder.join("stdout"), folder.join("stderr"));
    let create = |path: &Path| std::fs::File::create(path).expect("create");
    let mut child = Command::new(env!("CARGO_BIN_EXE_enact"))
        .args(arguments)
        .env_remove("RUST_LOG")
        .stdin(Stdio::null())
        .stdout(create(&out))
        .stderr(create(&err))
        .spawn()
        .expect("run");
    let (mut peak_bytes, mut processor_s) = (0, 0.0);
    let begun = Instant::now();
    let status = loop {
        // Read before it is asked whether it has ended: a process that has shows nothing.
        peak_bytes = peak(&child).unwrap_or(0).max(peak_bytes);
        processor_s = processor(&child).unwrap_or(0.0).max(processor_s);
        if let Some(status) = child.try_wait().expect("wait") {
            break status;
        }
        if processor_s > 60.0 || begun.elapsed() > Duration::from_secs(400) {
            child.kill().expect("kill");
        }
        std::thread::sleep(Duration::from_millis(2));
    };
    let read = |path: &Path| String::from_utf8(std::fs::read(path).expect("read")).expect("UTF-8");
    Cost {
        code: status.code(),
        stdout: read(&out),
        stderr: read(&err),
        peak_bytes,
        processor_s,
    }
}

fn peak(child: &Child) -> Option<u64> {
    let status = std::fs::read_to_string(format!("/proc/{}/status", child.id())).ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    let kilobytes: u64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kilobytes << 10)
}

/// In clock ticks, which are hundredths of a second on Linux.
fn processor(child: &Child) -> Option<f64> {
    let stat = std::fs::read_to_string(format!("/proc/{}/stat", child.id())).ok()?;
    let mut fields = stat.rsplit_once(')')?.1.split_whitespace().skip(11);
    let user: f64 = fields.next()?.parse().ok()?;
    let system: f64 = fields.next()?.parse().ok()?;
    Some((user + system) / 100.0)
}
