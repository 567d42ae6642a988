//! The live daemon: takes of running trackers are journalled, estimated and published.
//!
//! ```text
//! iceoryx2 ──> listen ──> record ──> journal (a recording, when the take is over)
//!                            ├──> sync        the journal, on a timer
//!                            ├──> preview     the estimate so far       ──┬────────> viewers
//!                            ├──> finals      estimates of whole takes  ──┼──> publisher ──> iceoryx2
//!                            └────────────────────────────────────────────┘       └──> the account
//! ```
//!
//! Each node is a thread, each arrow a bounded queue. tokio handles the signals, the timer, the
//! account and the servers: a WebSocket for viewers, health and metrics by HTTP. Both servers are
//! off unless they are given a port, and on loopback unless another address is configured.
//!
//! | queue | bound | when it is full |
//! |---|---|---|
//! | a service's buffer | 2048 samples a publisher | the oldest goes; the hole in the sequence is counted as an overflow |
//! | listen → record | 1024 batches, one a millisecond | the listener waits, and samples with it in their buffers |
//! | record → sync | 1 | that sync is left out: the next one is for both |
//! | record → preview | 1 | events wait with the recorder and go with what comes next: one estimate is made of all; beyond 200 000 a take has no more previews |
//! | record → finals | 8 takes | the take is not estimated, and the account says so |
//! | record → viewers | 256 poses, 60 a second and stream | not shown, and counted |
//! | preview, finals → viewers | 1 estimate | the newest replaces it |
//! | server → one viewer | 1024 messages | the oldest are dropped |
//! | → publisher | 256 | recorder: dropped and logged; estimators wait |
//! | publisher → account | 1024 | dropped and logged |
//!
//! Samples that come while no take runs are counted ([`Status::outside`]) and not kept. A take
//! begins with the samples of the same poll as its start, at most 1 ms before it while samples
//! come, and ends with those sent before its stop. There is no pre-roll: to record what leads up to
//! a motion, start the take before it, and discard the take if nothing follows.
//!
//! A process that is killed loses at most what came in the last `chunk_ms`, a machine that fails what
//! came in the last `chunk_ms + sync_ms`. The journal being written is left as `….mcap.part`;
//! `enact recover` makes a recording of everything readable in it, even if it is damaged, and keeps
//! the journal as `….mcap.part.recovered`: journals are removed by hand only. It says which bytes were
//! not read, and its exit code is 3 if there are any. A recovery that is killed is run again, and
//! ends as if it had not been. A take that is closed, or recovered, never replaces a file: where one
//! has come by its name, the journal stays as it is.
//!
//! Take after take can be recorded while earlier ones are estimated. A journal of more than two
//! million messages is left to `enact process`.
//!
//! Previews are estimated during the performance ([`Preview`](crate::pipeline::Preview)): one after
//! every mark is published on iceoryx2 and in the account, those in between are shown to viewers
//! only. The thread rests as long as it works, or longer.
//!
//! # Watching
//!
//! ```toml
//! [capture]
//! viewer_port = 8765     # Foxglove and Lichtblick: ws://127.0.0.1:8765; 0: any free port
//! metrics_port = 9464    # /health and /metrics
//! listen = "127.0.0.1"   # the default; others only reach what is opened to them here
//! ```
//!
//! There is neither encryption nor a password. Off loopback, everybody who reaches the port sees
//! the performance; on loopback, every page in a browser on this machine does, since no origin is
//! refused. Clients can only read. A port that is in use is an error at the start. Lichtblick
//! supports `foxglove.sdk.v1` since the end of 2025 (its pull request 819); earlier versions are
//! refused.
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
//! in `logind.conf`, or the shared memory is removed when that user logs out; `PrivateTmp=` must be
//! off. Started first, the daemon makes the services with its own quality; `enact doctor` lists
//! existing ones.

mod daemon;
mod director;
mod estimator;
mod event;
mod gate;
mod health;
mod history;
mod http;
mod label;
mod latency;
mod listen;
mod metrics;
mod naming;
mod notice;
mod notify;
mod origin;
mod preroll;
mod presence;
mod previewer;
mod publisher;
mod recorder;
mod seldom;
mod syncer;
mod take;
mod viewer;

pub use daemon::{CaptureJob, capture};
pub use event::{CaptureEvent, CountsLine, MarkCounts, Status, TrackerLine, TrackerState};
pub use label::TakeLabel;
pub use latency::LatencyLine;
pub use presence::Presence;
pub(super) use take::now_ns;
