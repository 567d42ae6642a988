//! The live daemon: takes from trackers that run now, journalled, estimated, published.
//!
//! ```text
//! iceoryx2 ──> listen ──> record ──> journal (a recording, when the take is over)
//!                            ├──> sync        the journal, on a timer
//!                            ├──> so far      estimates at marks        ──┐
//!                            ├──> finals      estimates of whole takes  ──┼──> herald ──> iceoryx2
//!                            └────────────────────────────────────────────┘       └──> the account
//! ```
//!
//! Each is a thread, each arrow a queue with a bound. tokio has the signals, the timer and the
//! account; whatever serves others (a viewer's socket, metrics) belongs there and reads
//! [`Status`] and [`Said`].
//!
//! | queue | bound | when it is full |
//! |---|---|---|
//! | a service's buffer | 2048 samples a publisher | the oldest goes; the hole in the sequence is counted as an overflow |
//! | listen → record | 1024 batches, one a millisecond | the listener waits, and samples with it in their buffers |
//! | record → sync | 1 | that sync is left out: the next one is for both |
//! | record → so far | 64 | events wait with the recorder; beyond 200 000 a take has no more estimates so far |
//! | record → finals | 8 takes | the take is not estimated, and the account says so |
//! | → herald | 256 | recorder: dropped and logged; estimators wait |
//! | herald → account | 1024 | dropped and logged |
//!
//! What comes while no take runs is counted ([`Status::outside`]) and not kept: a take begins with
//! what came by the same poll as its start, at most 1 ms before it while samples come, and ends
//! with what was sent before its stop. There is no pre-roll: who wants what led up to a motion
//! starts the take before it, and discards the take if nothing follows.
//!
//! Take after take can be recorded while earlier ones are estimated. A journal of more than two
//! million messages is left to `enact process`.
//!
//! # As a service
//!
//! ```text
//! [Service]
//! Type=notify
//! User=mocap
//! ExecStart=/usr/local/bin/enact capture /etc/enact/pencil.toml
//! WorkingDirectory=/var/lib/enact
//! KillSignal=SIGTERM
//! TimeoutStopSec=60
//! Restart=on-failure
//! ```
//!
//! iceoryx2 keeps its shared memory under `/dev/shm` and its files under `/tmp/iceoryx2`, as the
//! user of the process: trackers' drivers must run as the same user. `RemoveIPC=no` must be set
//! in `logind.conf`, or the shared memory goes when that user logs out; `PrivateTmp=` must be
//! off. Started first, the daemon makes the services with its own quality; `enact doctor` shows
//! what is there.

mod daemon;
mod estimator;
mod herald;
mod latency;
mod listen;
mod naming;
mod notify;
mod recorder;
mod said;
mod take;

pub use daemon::{CaptureJob, capture};
pub use latency::LatencyLine;
pub use said::{CountsLine, MarkCounts, Said, Status, TrackerLine};
pub(super) use take::now_ns;
