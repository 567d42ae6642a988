//! Accepts connections of others so that they cannot take what recording needs.
//!
//! Everybody who connects is accepted at once. Until a peer has said what it wants it is *waiting*;
//! only so many may wait, and where one more comes the one that has waited longest is closed: a
//! thousand peers that say nothing do not keep out the next one that speaks. Together with the
//! limits on those who have spoken this bounds the descriptors that others can make the daemon hold;
//! the rest of the process's limit stays for trackers and takes ([`GatePlaces`]). Where nothing is left of it
//! all the same, a port may keep one descriptor to go on with ([`Gate::with_spare`]).

use std::collections::VecDeque;
use std::fs::File;
use std::future::Future;
use std::io;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use rustix::io::Errno;
use tokio::net::{TcpListener, TcpStream};
use tokio::task::AbortHandle;

use super::metrics::Metrics;
use super::seldom::Seldom;

/// Descriptors that connections never get: iceoryx2 takes a few for every service and peer, a take
/// three, an estimate two.
const RESERVED: usize = 256;

/// Pause after a connection that could not be accepted.
const PAUSE: Duration = Duration::from_millis(50);

/// How many connections there may be at a time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct GatePlaces {
    /// Peers of one port that have not said yet what they want.
    pub(super) waiting: usize,
    /// Viewers.
    pub(super) viewers: usize,
    /// Peers that take their answer.
    pub(super) answered: usize,
}

impl GatePlaces {
    /// As many as are wanted, or as the process may have descriptors for after the reserve. Raises
    /// the process's limit as far as it may.
    pub(super) fn of_process() -> Self {
        Self::of_limit(descriptors())
    }

    fn of_limit(descriptors: usize) -> Self {
        // Three ports with peers that wait, two shares each; viewers; peers of two ports that are answered.
        let share = descriptors.saturating_sub(RESERVED) / 9;
        Self {
            waiting: (2 * share).clamp(8, 128),
            viewers: share.clamp(2, 32),
            answered: share.clamp(2, 32),
        }
    }
}

/// One port.
#[derive(Debug)]
pub(super) struct Gate {
    name: &'static str,
    places: usize,
    waiting: Mutex<VecDeque<(u64, AbortHandle)>>,
    metrics: Arc<Metrics>,
    complaint: Seldom,
    /// Held so that it can be let go of; none where a port does without.
    spare: Option<Mutex<Option<File>>>,
}

/// A peer that waits, until this is dropped.
pub(super) struct Waiting {
    gate: Arc<Gate>,
    number: u64,
}

impl Gate {
    pub(super) fn new(name: &'static str, places: usize, metrics: &Arc<Metrics>) -> Arc<Self> {
        Arc::new(Self::of(name, places, metrics, None))
    }

    fn of(
        name: &'static str,
        places: usize,
        metrics: &Arc<Metrics>,
        spare: Option<Mutex<Option<File>>>,
    ) -> Self {
        Self {
            name,
            places,
            waiting: Mutex::default(),
            metrics: Arc::clone(metrics),
            complaint: Seldom::default(),
            spare,
        }
    }

    /// One that goes on where the process has no descriptors left, a connection at a time: who asks how the daemon
    /// is must be told just then.
    pub(super) fn with_spare(
        name: &'static str,
        places: usize,
        metrics: &Arc<Metrics>,
    ) -> Arc<Self> {
        Arc::new(Self::of(name, places, metrics, Some(Mutex::default())))
    }

    /// Accepts the next connection, in the place of the spare descriptor if there is no other.
    async fn accept(&self, listener: &TcpListener) -> io::Result<TcpStream> {
        loop {
            let is_ready = self.hold_spare();
            tokio::select! {
                accepted = listener.accept() => return match accepted {
                    Err(error) if is_exhausted(&error) && self.let_go() => {
                        listener.accept().await.map(|(stream, _)| stream)
                    }
                    accepted => accepted.map(|(stream, _)| stream),
                },
                // It may be had again once a connection is closed.
                () = tokio::time::sleep(PAUSE), if !is_ready => {}
            }
        }
    }

    /// Takes a descriptor to spare, if one is wanted and missing; whether none is missing then.
    fn hold_spare(&self) -> bool {
        let Some(Ok(mut spare)) = self.spare.as_ref().map(Mutex::lock) else {
            return true;
        };
        if spare.is_none() {
            *spare = File::open("/dev/null").ok();
        }
        spare.is_some()
    }

    /// Closes the spare descriptor; whether there was one.
    fn let_go(&self) -> bool {
        let spare = self.spare.as_ref().and_then(|spare| spare.lock().ok());
        spare.is_some_and(|mut spare| spare.take().is_some())
    }

    /// Accepts connections for ever and serves each in a task of its own, which drops its
    /// [`Waiting`] as soon as the peer has said what it wants.
    pub(super) async fn keep<F>(
        self: Arc<Self>,
        listener: TcpListener,
        serve: impl Fn(TcpStream, Waiting) -> F,
    ) where
        F: Future<Output = ()> + Send + 'static,
    {
        let mut number = 0;
        loop {
            let stream = match self.accept(&listener).await {
                Ok(stream) => stream,
                Err(error) => {
                    self.complain("a connection was not accepted", &error.to_string());
                    tokio::time::sleep(PAUSE).await;
                    continue;
                }
            };
            number += 1;
            let gate = Arc::clone(&self);
            let Ok(mut waiting) = self.waiting.lock() else {
                return;
            };
            while waiting.len() >= self.places
                && let Some((_, oldest)) = waiting.pop_front()
            {
                oldest.abort();
                self.metrics.connections_closed.add();
            }
            // Under the lock: it cannot leave the queue before it is in it.
            let task = tokio::spawn(serve(stream, Waiting { gate, number }));
            waiting.push_back((number, task.abort_handle()));
        }
    }

    /// A peer that came through no port.
    #[cfg(any(test, fuzzing))]
    pub(super) fn alone(self: &Arc<Self>) -> Waiting {
        Waiting {
            gate: Arc::clone(self),
            number: 0,
        }
    }

    /// Logs what peers can cause, seldom.
    pub(super) fn complain(&self, what: &str, why: &str) {
        if let Some(more) = self.complaint.due(Instant::now()) {
            tracing::warn!(port = self.name, why = ?why, more, "{what}");
        }
    }
}

impl Drop for Waiting {
    fn drop(&mut self) {
        if let Ok(mut waiting) = self.gate.waiting.lock() {
            waiting.retain(|(number, _)| *number != self.number);
        }
    }
}

/// Raises the process's limit of descriptors as far as it may; how many there are then.
#[cfg(unix)]
fn descriptors() -> usize {
    use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
    let limit = getrlimit(Resource::Nofile);
    let raised = Rlimit {
        current: limit.maximum,
        maximum: limit.maximum,
    };
    let limit = match setrlimit(Resource::Nofile, raised) {
        Ok(()) => limit.maximum,
        Err(_) => limit.current,
    };
    limit.map_or(usize::MAX, |limit| {
        usize::try_from(limit).unwrap_or(usize::MAX)
    })
}

/// Elsewhere connections are no descriptors.
#[cfg(not(unix))]
fn descriptors() -> usize {
    usize::MAX
}

fn is_exhausted(error: &io::Error) -> bool {
    let exhausted = [
        Errno::MFILE,
        #[cfg(unix)]
        Errno::NFILE,
    ];
    exhausted
        .map(Errno::raw_os_error)
        .map(Some)
        .contains(&error.raw_os_error())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn recording_keeps_its_descriptors_whatever_the_limit() {
        for (limit, waiting, viewers) in [
            (64, 8, 2),
            (400, 32, 16),
            (1024, 128, 32),
            (usize::MAX, 128, 32),
        ] {
            let places = GatePlaces::of_limit(limit);
            assert_eq!((places.waiting, places.viewers), (waiting, viewers));
            let all = 3 * places.waiting + places.viewers + 2 * places.answered;
            assert!(limit <= RESERVED || all + RESERVED <= limit, "{places:?}");
        }
    }

    #[tokio::test]
    async fn who_waits_longest_makes_room() {
        use tokio::io::{AsyncReadExt, AsyncWriteExt};
        let listener = TcpListener::bind("127.0.0.1:0").await.expect("bind");
        let address = listener.local_addr().expect("address");
        let metrics = Arc::new(Metrics::default());
        let gate = Gate::new("test", 4, &metrics);
        let task = tokio::spawn(gate.keep(listener, |mut stream, waiting| async move {
            let mut word = [0];
            if stream.read_exact(&mut word).await.is_ok() {
                drop(waiting);
                let _ = stream.write_all(b"!").await;
            }
        }));
        let mut silent = Vec::new();
        for _ in 0..20 {
            silent.push(TcpStream::connect(address).await.expect("connect"));
        }
        let mut last = TcpStream::connect(address).await.expect("connect");
        last.write_all(b"?").await.expect("write");
        let mut answer = [0];
        last.read_exact(&mut answer).await.expect("an answer");
        assert_eq!(&answer, b"!");
        // The first of them was closed.
        assert_eq!(silent[0].read(&mut answer).await.ok(), Some(0));
        task.abort();
    }
}
