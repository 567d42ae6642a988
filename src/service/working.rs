//! Says on a terminal what goes on, for jobs over a second.

use std::borrow::Cow;
use std::io::{IsTerminal, stderr};
use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Jobs that are over sooner say nothing.
const PATIENCE: Duration = Duration::from_secs(1);

/// A line with what is done and for how long, until it is dropped: of how much is left it says only what is counted.
pub(super) struct Working {
    bar: ProgressBar,
    shown: Option<(Sender<()>, JoinHandle<()>)>,
}

impl Working {
    /// One that goes to stderr, if that is a terminal.
    pub(super) fn begin(doing: &'static str) -> Self {
        Self::with(None, "{spinner} {elapsed_precise} {wide_msg}", doing)
    }

    /// The same, of so many jobs: [`Working::done`] counts them.
    pub(super) fn of(jobs: usize) -> Self {
        Self::with(
            Some(jobs as u64),
            "{bar:30} {pos}/{len} {elapsed_precise} {wide_msg}",
            "",
        )
    }

    /// One that nobody sees.
    pub(super) fn hidden() -> Self {
        Self {
            bar: ProgressBar::hidden(),
            shown: None,
        }
    }

    fn with(jobs: Option<u64>, template: &str, doing: &'static str) -> Self {
        let bar = ProgressBar::with_draw_target(jobs, ProgressDrawTarget::hidden());
        match ProgressStyle::with_template(template) {
            Ok(style) => bar.set_style(style),
            Err(error) => unreachable!("the template is constant: {error}"),
        }
        bar.set_message(doing);
        let shown = stderr().is_terminal().then(|| {
            let (end, ended) = mpsc::channel();
            let bar = bar.clone();
            let shown = thread::spawn(move || {
                if ended.recv_timeout(PATIENCE) == Err(RecvTimeoutError::Timeout) {
                    bar.set_draw_target(ProgressDrawTarget::stderr());
                    bar.enable_steady_tick(Duration::from_millis(100));
                    let _ = ended.recv();
                }
            });
            (end, shown)
        });
        Self { bar, shown }
    }

    /// What is done from now on.
    pub(super) fn now(&self, doing: impl Into<Cow<'static, str>>) {
        self.bar.set_message(doing);
    }

    /// One more of the jobs is done.
    pub(super) fn done(&self) {
        self.bar.inc(1);
    }

    /// Prints something without the line between.
    pub(super) fn around<T>(&self, print: impl FnOnce() -> T) -> T {
        self.bar.suspend(print)
    }
}

impl Drop for Working {
    fn drop(&mut self) {
        if let Some((end, shown)) = self.shown.take() {
            drop(end);
            // It cannot panic: it waits and draws.
            let _ = shown.join();
        }
        self.bar.finish_and_clear();
    }
}
