//! How much memory one estimate takes, each in a process of its own: one that has estimated before
//! uses again what it has kept.

use std::process::Command;
use std::{env, fs};

use super::sweeps;

/// What [`peak_bytes`] says in another process.
pub fn of_another(curve: &str, count: usize) -> Option<u64> {
    let output = Command::new(env::current_exe().ok()?)
        .args(["--memory", &format!("{count} {curve}")])
        .output()
        .ok()?;
    String::from_utf8(output.stdout).ok()?.trim().parse().ok()
}

/// The most memory in use during one estimate beyond what was before it \[bytes\]; the size by its
/// count and the name of its curve.
pub fn peak_bytes(size: &str) -> Option<u64> {
    let (count, curve) = size.split_once(' ')?;
    let sweeps = sweeps(false);
    let sweep = sweeps.iter().find(|sweep| sweep.curve == curve)?;
    let case = (sweep.case)(count.parse().ok()?)?;
    fs::write("/proc/self/clear_refs", "5").ok()?;
    let before_bytes = status("VmRSS:")?;
    let estimated = case.estimated(&mut ());
    let peak_bytes = status("VmHWM:")?;
    estimated.ok()?;
    Some(peak_bytes.saturating_sub(before_bytes))
}

/// A figure of the process's status \[bytes\].
fn status(key: &str) -> Option<u64> {
    let text = fs::read_to_string("/proc/self/status").ok()?;
    let line = text.lines().find(|line| line.starts_with(key))?;
    let kib: u64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(1024 * kib)
}
