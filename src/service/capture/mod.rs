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
//! | listen → record | 1024 batches of at most 512 arrivals, one or more a millisecond | the listener waits, and samples with it in their buffers; `/health` says when the recorder is a second behind |
//! | record → sync | 1 | that sync is left out: the next one is for both |
//! | record → preview | 1 | events wait with the recorder and go with what comes next: one estimate is made of all; beyond 200 000 a take has no more previews |
//! | record → finals | 8 takes | the take is not estimated, and the account says so |
//! | record → viewers | 256 poses, 60 a second and stream | not shown, and counted |
//! | preview, finals → viewers | 1 estimate | the newest replaces it |
//! | server → all viewers | 512 messages, and 4 great ones | who is slower than that misses the oldest, and they are counted |
//! | operator's page → record | 64 orders | refused |
//! | acting pages → record | 2048 readings and orders | dropped: the hole in the sequence is counted as missing |
//! | → publisher | 256 | recorder: dropped and logged; estimators wait |
//! | publisher → account | 1024 | dropped and logged |
//!
//! Samples that come while no take runs are counted ([`Status::outside`]); those of the last
//! `pre_roll_s` are kept in memory, and a take begins with them. Without that key a take
//! begins with the samples of the same poll as its start, at most 1 ms before it while samples
//! come. It ends with those sent before its stop. Numbers that are missing between the last sample
//! before a take and its first are counted in the take: it began somewhere among them.
//!
//! # What the daemon knows
//!
//! Of every tracker, take or no take: its rate, when its last sample came, and how much of it is valid
//! ([`TrackerState`]). One that sent at least three samples and then none for five of its mean intervals,
//! and for half a second, is silent: that is an event ([`CaptureEvent::Silent`]), in the line of the
//! terminal, in `enact take status`, in `/metrics`, and a warning in viewers.
//!
//! There is one daemon per iceoryx2: it holds a lock beside iceoryx2's files, and a second one refuses
//! and names the first. Takes are numbered through the life of their folder, and their files carry the
//! number: `take-0012-20261121T171000Z.mcap`. Name, note and rating of a take are the metadata record
//! `take` of its recording, and of its estimate.
//!
//! The account is written on a thread of its own: where nobody reads it nothing waits but the account.
//! At the end two seconds are left for it. A daemon that is told to end does so with exit code 0, or
//! with 3 where a take could not be recorded or the account not be written.
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
//! metrics_port = 9464    # http://127.0.0.1:9464: the operator's page, /health, /metrics
//! listen = "127.0.0.1"   # the default; others only reach what is opened to them here
//! origins = ["https://viewer.example"]   # further pages that may watch; "*": all
//! ```
//!
//! There is no encryption. Off loopback, everybody who reaches the ports sees the performance. Pages in browsers
//! say where they are from: those of this machine and of known viewers may watch, and others that are listed in
//! `origins`. Who directs takes must know the token that the daemon makes at its start: it is in the link to the
//! operator's page, and in a file that only the user can read. Who asks must ask for `localhost`, an address in
//! numbers, or one of `hosts`. A port that is in use is an error at the start. Lichtblick supports `foxglove.sdk.v1` since the end of 2025 (its pull request
//! 819); earlier versions are refused.
//!
//! With `--acting` a page in a browser may be a tracker: `acting` says how, and what it may not.
//!
//! Nothing that happens at the ports reaches recording. There may be 128 connections at each port that have
//! not said yet what they want, the oldest of which makes room for one more, and 32 viewers; fewer
//! where the process may have fewer than about 550 descriptors, of which 256 are left for trackers and
//! takes. All viewers together take at most 64 MiB; one that takes ten seconds for a message, or answers
//! no ping for thirty, is sent away, and of one that does not read what is sent to it nothing more is taken.
//! What others can make the daemon log is logged every ten seconds at most, with how often it happened.
//!
//! `/health` is 200 while a take could be begun and written, else 503 with the reasons: the last take
//! could not be recorded, less than 1 MiB is free, no file can be made in the folder or no descriptor be
//! had (looked at twice a second), the services' files are gone (every second), a thread has not
//! moved for 1.5 s, or the recorder is more than a second behind. It answers where the process has no descriptor left, too: its port keeps one to spare.
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

mod acting;
mod certificate;
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
#[cfg_attr(not(unix), path = "no_manager.rs")]
mod notify;
mod origin;
#[cfg(any(test, fuzzing))]
pub mod peers;
mod preroll;
mod presence;
mod previewer;
mod publisher;
mod recorder;
mod seldom;
mod signals;
mod syncer;
mod take;
mod viewer;

pub use acting::page::ActingPage;
pub use daemon::{CaptureJob, capture};
pub use event::{CaptureEvent, CountsLine, HttpsLink, MarkCounts, Status, TrackerLine};
pub use label::TakeLabel;
pub use latency::LatencyLine;
pub use presence::{Presence, TrackerState};
pub(super) use take::now_ns;
