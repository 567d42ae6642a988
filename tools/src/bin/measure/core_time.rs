//! Time that a thread had a core: what other work on the machine takes does not count.

use std::fs;
use std::time::Instant;

use enact::motion::Observer;

/// After which an answer about joined bodies is told to stop, where its subject says nothing else \[s on a core\]; it has
/// failed then.
pub const ANSWER_S: f64 = 10.0;

/// Time of this thread on a core since it began; where the system does not say, time by the clock.
pub struct CoreTime {
    begin: Instant,
    begin_ns: Option<u64>,
}

impl CoreTime {
    /// From now on.
    pub fn begin() -> Self {
        Self {
            begin: Instant::now(),
            begin_ns: on_core_ns(),
        }
    }

    /// So far \[s\]; the system counts in milliseconds.
    pub fn seconds(&self) -> f64 {
        match self.begin_ns.zip(on_core_ns()) {
            Some((begin_ns, now_ns)) => 1e-9 * (now_ns - begin_ns) as f64,
            None => self.begin.elapsed().as_secs_f64(),
        }
    }
}

/// Linux counts it: the first number of the file.
fn on_core_ns() -> Option<u64> {
    let text = fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    text.split_whitespace().next()?.parse().ok()
}

/// Stops an answer that has had a core for so long \[s\] since it began.
pub struct CoreLimit<'t>(pub &'t CoreTime, pub f64);

impl Observer for CoreLimit<'_> {
    fn should_stop(&mut self) -> bool {
        self.0.seconds() > self.1
    }
}

/// How long a call has a core \[s\]: of several by the clock the fastest, or the mean on a core, whichever is less.
pub fn call_s(quick: bool, mut call: impl FnMut()) -> f64 {
    let (least_s, least) = if quick { (0.01, 1) } else { (0.1, 3) };
    let whole = CoreTime::begin();
    let (mut calls, mut fastest_s) = (0, f64::INFINITY);
    while calls < least || whole.seconds() < least_s {
        let begin = Instant::now();
        call();
        fastest_s = fastest_s.min(begin.elapsed().as_secs_f64());
        calls += 1;
    }
    fastest_s.min(whole.seconds() / f64::from(calls))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sleep is no time on a core, and work is.
    #[test]
    fn what_sleeps_has_no_core() {
        let time = CoreTime::begin();
        std::thread::sleep(std::time::Duration::from_millis(300));
        let slept_s = time.seconds();
        let mut sum = 0.0_f64;
        while time.begin.elapsed().as_secs_f64() < 3.0 && time.seconds() < slept_s + 0.05 {
            sum += std::hint::black_box(1.0_f64).sqrt();
        }
        assert!(sum > 0.0);
        if time.begin_ns.is_some() {
            assert!(slept_s < 0.2, "{slept_s}");
            assert!(time.seconds() >= slept_s + 0.05);
        }
    }
}
