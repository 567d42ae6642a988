//! The daemon: starts the threads, connects their queues, and ends them in order.

use std::net::{Ipv4Addr, SocketAddr};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, SyncSender};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use anyhow::{Context, bail};
use tokio::sync::watch;

use super::acting::page::{ActingPage, page_text};
use super::acting::pairing::Pairing;
use super::acting::{ActingParts, ActingStage};
use super::certificate::{Certificate, own_address};
use super::director::Director;
use super::estimator::finals;
use super::event::{CaptureEvent, HttpsLink, Status};
use super::gate::GatePlaces;
use super::http::{self, Pages};
use super::listen::{Listen, OpenedStream};
use super::metrics::Metrics;
use super::notice::{self, Notice, Shown, Speaker};
use super::notify::tell;
use super::origin::Origins;
use super::previewer::{PreviewInput, Previewer};
use super::publisher::Publisher;
use super::recorder::Recorder;
use super::seldom::Seldom;
use super::signals::EndSignals;
use super::syncer::sync_all;
use super::viewer::{self, Feed};
use crate::config::{CaptureSettings, capture_from_toml};
use crate::ingest::live::{Arrival, StreamTopic, Token, stream_topics};
use crate::ingest::read_text;
use crate::motion::Scene;
use crate::service::direct::operators_link;
use crate::write::{abandoned, remove_unfinished};

/// Name of the thread that journals.
const RECORD: &str = "record";

/// Bounds of the queues except the publisher's; what happens when one is full is in the
/// documentation of this module.
const BATCHES: usize = 1024;
const SO_FAR: usize = 1;
const FINALS: usize = 8;
const SAID: usize = 1024;

/// Interval of showing the status while nothing happens.
const SHOWN: Duration = Duration::from_millis(500);

/// Interval of looking whether all threads have ended.
const CHECKED: Duration = Duration::from_millis(20);

/// How long the end waits for whoever reads the account.
const LAST_WORDS: Duration = Duration::from_secs(2);

/// How long the end waits for the estimates of takes that are over, and how long then for them to stop.
const LAST_ESTIMATES: Duration = Duration::from_secs(4);
const STOPPED: Duration = Duration::from_secs(2);

/// Bound of the queue of what the operator's page directs.
const ORDERS: usize = 64;

/// Bound of the queue of what the acting page sends: two seconds of what it may send.
const ACTED: usize = 2048;

/// Port of the pages where the acting page is wanted and none is said.
const PAGES_PORT: u16 = 9464;

/// The input of [`capture`].
#[derive(Clone, Debug)]
pub struct CaptureJob {
    /// The scene file, with its `[capture]`.
    pub scene: PathBuf,
    /// Folder of the takes; the scene's by default.
    pub folder: Option<PathBuf>,
    /// Configuration of iceoryx2; by default where iceoryx2 looks for it.
    pub iceoryx2: Option<PathBuf>,
    /// Begin a take at once.
    pub start_now: bool,
    /// Port of the WebSocket for viewers, 0 for any; by default the scene's.
    pub viewer_port: Option<u16>,
    /// Port of health and metrics, 0 for any; by default the scene's.
    pub metrics_port: Option<u16>,
    /// The acting page, if it is to be served: at the port of health and metrics, 9464 if none is said.
    pub acting: Option<ActingPage>,
    /// Port at which other devices get it by HTTPS, 0 for any.
    pub https_port: Option<u16>,
}

/// Captures until SIGTERM, SIGINT or SIGHUP, or until `each` fails; returns whether everything that came in
/// a take is in its file. `each` is called with every event, `show` with the status at intervals, both
/// on a thread of their own: where they wait, for a terminal or a pipe that nobody reads, nothing else
/// does. At the end the running take is closed, estimates have four seconds to be completed, and what is left to say
/// is said within two seconds; a second signal does not wait for estimates, but one that a terminal sends when it is
/// closed is no second one.
///
/// Fails before it listens where the scene is wrong, the folder cannot be made or the services
/// cannot be opened, by another daemon for example.
pub fn capture(
    job: &CaptureJob,
    each: impl FnMut(&CaptureEvent) -> anyhow::Result<()> + Send + 'static,
    show: impl FnMut(&Status) + Send + 'static,
) -> anyhow::Result<bool> {
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .worker_threads(2)
        .enable_all()
        .build()
        .context("no tokio runtime")?;
    let result = runtime.block_on(async {
        // Before anything is opened, so that no signal is missed.
        let mut signals = EndSignals::begin()?;
        let mut running = Running::start(job).await?;
        let mut account = DaemonAccount::begin(&mut running, each, show)?;
        tell("READY=1");
        let mut checks = tokio::time::interval(CHECKED);
        let mut is_enough = None;
        loop {
            let (is_signal, may_end_it) = tokio::select! {
                _ = checks.tick() => (false, false),
                may_end_it = signals.next() => (true, may_end_it),
            };
            if is_signal {
                tell("STOPPING=1");
                if running.stop.swap(true, Ordering::Relaxed) && may_end_it {
                    bail!("ended by a second signal: some estimates were not waited for");
                }
            }
            if running.is_over(&mut is_enough) {
                break;
            }
        }
        if running.join()? {
            return account.end().await;
        }
        tracing::error!(
            "an estimate does not stop, and is not waited for: `enact process` makes it of the recording"
        );
        remove_unfinished(|| ());
        Ok(account.is_whole.load(Ordering::Relaxed))
    });
    // A task that waits for a peer is not waited for.
    runtime.shutdown_background();
    result
}

/// The thread that says what happens.
struct DaemonAccount {
    said: tokio::sync::oneshot::Receiver<anyhow::Result<bool>>,
    /// Whether nothing is lost so far.
    is_whole: Arc<AtomicBool>,
}

impl DaemonAccount {
    fn begin(
        running: &mut Running,
        mut each: impl FnMut(&CaptureEvent) -> anyhow::Result<()> + Send + 'static,
        mut show: impl FnMut(&Status) + Send + 'static,
    ) -> anyhow::Result<Self> {
        let events = running.said.take().context("the account begins twice")?;
        let (status, stop) = (running.status.clone(), Arc::clone(&running.stop));
        let (sender, said) = tokio::sync::oneshot::channel();
        let is_whole_so_far = Arc::new(AtomicBool::new(true));
        let so_far = Arc::clone(&is_whole_so_far);
        // Not joined: it may wait for somebody who never reads.
        spawn("account", move || {
            let mut result = Ok(true);
            loop {
                match events.recv_timeout(SHOWN) {
                    Ok(event) => {
                        if let Ok(is_whole) = &mut result {
                            *is_whole &= !event.is_loss();
                            so_far.store(*is_whole, Ordering::Relaxed);
                            if let Err(error) = each(&event) {
                                // The reader of the account has gone, so nothing that follows would
                                // be seen.
                                result = Err(error);
                                stop.store(true, Ordering::Relaxed);
                            }
                        }
                    }
                    Err(RecvTimeoutError::Timeout) => show(&status.borrow()),
                    Err(RecvTimeoutError::Disconnected) => break,
                }
            }
            let _ = sender.send(result);
        })?;
        Ok(Self {
            said,
            is_whole: is_whole_so_far,
        })
    }

    /// Waits for the last words, if somebody reads them.
    async fn end(&mut self) -> anyhow::Result<bool> {
        match tokio::time::timeout(LAST_WORDS, &mut self.said).await {
            Ok(said) => said.context("the account panicked, which is a bug")?,
            Err(_) => {
                tracing::error!("nobody reads what is said on stdout: the rest is not waited for");
                Ok(false)
            }
        }
    }
}

/// The threads, and the daemon's ends of their queues.
struct Running {
    said: Option<Receiver<CaptureEvent>>,
    status: watch::Receiver<Status>,
    stop: Arc<AtomicBool>,
    threads: Vec<JoinHandle<()>>,
    /// Told when estimates must stop.
    enough: &'static AtomicBool,
}

impl Running {
    /// Whether all threads have ended, or those that record have and estimates that were told to stop do not; `since` is
    /// when recording was over.
    fn is_over(&self, since: &mut Option<Instant>) -> bool {
        if self.threads.iter().all(JoinHandle::is_finished) {
            return true;
        }
        let is_recording = |thread: &&JoinHandle<()>| thread.thread().name() == Some(RECORD);
        let is_recorded = || {
            let mut recording = self.threads.iter().filter(is_recording);
            recording.all(JoinHandle::is_finished)
        };
        if since.is_none() && self.stop.load(Ordering::Relaxed) && is_recorded() {
            *since = Some(Instant::now());
        }
        let waited = since.map_or(Duration::ZERO, |since| since.elapsed());
        if waited > LAST_ESTIMATES {
            self.enough.store(true, Ordering::Relaxed);
        }
        waited > LAST_ESTIMATES + STOPPED
    }

    async fn start(job: &CaptureJob) -> anyhow::Result<Self> {
        let (scene, scene_toml, mut settings) = read_scene(&job.scene)?;
        if let Some(folder) = &job.folder {
            settings.folder.clone_from(folder);
        }
        settings.viewer_port = job.viewer_port.or(settings.viewer_port);
        settings.metrics_port = job.metrics_port.or(settings.metrics_port);
        let acting_html = job.acting.as_ref().map(page_text).transpose()?;
        if acting_html.is_some() {
            settings.metrics_port = settings.metrics_port.or(Some(PAGES_PORT));
        }
        let folder = settings.folder.as_path();
        std::fs::create_dir_all(folder)
            .with_context(|| format!("{}: cannot make the folder", folder.display()))?;
        let left = abandoned(folder)?;
        let (batches, batch_queue) = mpsc::sync_channel(BATCHES);
        let (tellers, said) = mpsc::sync_channel(SAID);
        let stop = Arc::new(AtomicBool::new(false));
        // For as long as the process: an estimate that does not stop may outlive everything here.
        let enough: &'static AtomicBool = Box::leak(Box::default());
        let mut threads = Vec::new();
        let metrics = Arc::new(Metrics::default());
        let (speaker, notices) = notice::queue(&metrics);

        let (opened, is_open) = mpsc::channel();
        let listen = Listen {
            scene: scene.clone(),
            scene_file: std::path::absolute(&job.scene).unwrap_or_else(|_| job.scene.clone()),
            iceoryx2: job.iceoryx2.clone(),
            queue: batches,
            metrics: Arc::clone(&metrics),
            stop: Arc::clone(&stop),
            opened,
        };
        threads.push(spawn("listen", move || listen.run())?);
        let OpenedStream {
            shortcomings,
            token,
        } = is_open.recv().context("the listener is gone")??;
        let (opened, is_open) = mpsc::channel();
        let publisher = Publisher {
            scene: scene.clone(),
            iceoryx2: job.iceoryx2.clone(),
            said: tellers,
            metrics: Arc::clone(&metrics),
            complaint: Seldom::default(),
            opened,
        };
        threads.push(spawn("publisher", move || publisher.run(&notices))?);
        let opened = is_open.recv().context("the publisher is gone")?;
        if opened.is_err() {
            stop.store(true, Ordering::Relaxed);
        }
        opened?;
        let topics = stream_topics(&scene);
        let (status_sender, status) = watch::channel(Status::default());
        let (shown_sender, shown) = watch::channel(None);
        let (order_sender, orders) = mpsc::sync_channel(ORDERS);
        let (acted_sender, acted) = mpsc::sync_channel(ACTED);
        let doors = Doors {
            places: GatePlaces::of_process(),
            origins: Origins::new(&settings.origins, &settings.hosts),
            token,
            scene: &scene,
            scene_toml: &String::from_utf8_lossy(&scene_toml),
            settings: &settings,
            topics: &topics,
            metrics: &metrics,
            stop: &stop,
            acting_html,
            https_port: job.https_port,
        };
        // Nothing has started yet except threads that wait on their queues.
        let served = match doors
            .open(status.clone(), shown, [order_sender, acted_sender])
            .await
        {
            Ok(served) => served,
            Err(error) => {
                stop.store(true, Ordering::Relaxed);
                return Err(error);
            }
        };
        speaker.say(Notice::of(CaptureEvent::Ready {
            viewer: served.viewer,
            page: served
                .metrics
                .as_ref()
                .map(|address| operators_link(address, &token)),
            metrics: served.metrics.clone(),
            acting: served.acting.clone(),
            https: served.https.clone(),
            topics: topics.iter().map(|topic| topic.topic.clone()).collect(),
            shortcomings,
            abandoned: left.iter().map(|path| path.display().to_string()).collect(),
        }));
        let previewer = Previewer {
            scene: scene.clone(),
            publisher: speaker.clone(),
            shown: shown_sender.clone(),
            metrics: Arc::clone(&metrics),
            enough,
        };
        let recorder = Recorder {
            so_far: spawn_previewer(previewer, &mut threads)?,
            finals: spawn_finals(&speaker, shown_sender, &metrics, enough, &mut threads)?,
            syncer: spawn_syncer(&speaker, &mut threads)?,
            scene,
            scene_toml,
            settings,
            topics,
            publisher: speaker,
            status: status_sender,
            metrics,
            feed: served.feed,
            token,
            page: served.metrics,
            orders,
            acted,
        };
        let (watched, to_watch) = (
            Arc::clone(&recorder.metrics),
            recorder.settings.folder.clone(),
        );
        let until = Arc::clone(&stop);
        // Not joined: a file system that does not answer would hold it up.
        let remembered = (Arc::clone(&watched), to_watch.clone());
        spawn("history", move || remembered.0.history.read(&remembered.1))?;
        spawn("watch", move || watched.health.watch(&to_watch, &until))?;
        let start_now = job.start_now;
        threads.push(spawn(RECORD, move || {
            recorder.run(&batch_queue, start_now)
        })?);
        Ok(Self {
            said: Some(said),
            status,
            stop,
            threads,
            enough,
        })
    }

    /// Waits for the threads, once all queues are closed, but for an estimate that does not stop and those that
    /// wait for it; whether all have ended.
    fn join(self) -> anyhow::Result<bool> {
        let mut have_ended = true;
        for thread in self.threads {
            if !thread.is_finished() {
                have_ended = false;
                continue;
            }
            let name = thread.thread().name().unwrap_or_default().to_owned();
            if thread.join().is_err() {
                bail!("thread {name} panicked, which is a bug");
            }
        }
        Ok(have_ended)
    }
}

/// The inputs of the servers for viewers and metrics.
struct Doors<'a> {
    scene: &'a Scene,
    scene_toml: &'a str,
    settings: &'a CaptureSettings,
    topics: &'a [StreamTopic],
    metrics: &'a Arc<Metrics>,
    stop: &'a Arc<AtomicBool>,
    places: GatePlaces,
    origins: Origins,
    token: Token,
    /// The acting page, if it is to be served.
    acting_html: Option<String>,
    https_port: Option<u16>,
}

/// Addresses of the servers, and the recorder's end of the viewers' queue.
struct Servers {
    viewer: Option<String>,
    metrics: Option<String>,
    /// Link to the acting page, with the pairing code,
    acting: Option<String>,
    /// and for other devices.
    https: Option<HttpsLink>,
    feed: Option<Feed>,
}

impl Doors<'_> {
    /// Opens the servers that are wanted.
    async fn open(
        &self,
        status: watch::Receiver<Status>,
        shown: watch::Receiver<Shown>,
        [orders, acted]: [SyncSender<Arrival>; 2],
    ) -> anyhow::Result<Servers> {
        let at = |port: u16| SocketAddr::new(self.settings.listen, port);
        let mut served = Servers {
            viewer: None,
            metrics: None,
            acting: None,
            https: None,
            feed: None,
        };
        if let Some(address) = self.settings.metrics_port.map(at) {
            let acting = self.acting(&status, acted)?.map(Arc::new);
            let pages = |is_acting_alone: bool| Pages {
                acting: acting.clone(),
                is_acting_alone,
                metrics: Arc::clone(self.metrics),
                status: status.clone(),
                stop: Arc::clone(self.stop),
                director: Director::new(self.scene, orders.clone(), status.clone(), self.token),
                origins: self.origins.clone(),
            };
            let opened = http::serve(address, self.places, pages(false), None).await;
            let address = opened.with_context(|| format!("{address}: no metrics"))?;
            served.metrics = Some(format!("http://{address}"));
            if let Some(acting) = &acting {
                let code = acting.code();
                served.acting = Some(format!("http://{address}/act#code={code}"));
                if let Some(port) = self.https_port {
                    served.https = Some(self.open_elsewhere(port, pages(true), code).await?);
                }
            }
        }
        if let Some(address) = self.settings.viewer_port.map(at) {
            let what = (self.scene, self.topics);
            let metrics = Arc::clone(self.metrics);
            let rules = (self.places, self.origins.clone());
            let opened = viewer::serve(address, what, rules, (shown, status), metrics).await;
            let (feed, address) = opened.with_context(|| format!("{address}: no viewers"))?;
            served.viewer = Some(format!("ws://{address}"));
            served.feed = Some(feed);
        }
        Ok(served)
    }

    /// Serves the acting page to other devices.
    async fn open_elsewhere(
        &self,
        port: u16,
        pages: Pages,
        code: &str,
    ) -> anyhow::Result<HttpsLink> {
        let Certificate {
            acceptor,
            fingerprint,
        } = Certificate::kept()?;
        let address = SocketAddr::new(Ipv4Addr::UNSPECIFIED.into(), port);
        let opened = http::serve(address, self.places, pages, Some(acceptor)).await;
        let opened = opened.with_context(|| format!("{address}: no acting page by HTTPS"))?;
        let address = SocketAddr::new(own_address(), opened.port());
        Ok(HttpsLink {
            link: format!("https://{address}/act#code={code}"),
            fingerprint,
        })
    }

    /// What the acting page is served with, if it is.
    fn acting(
        &self,
        status: &watch::Receiver<Status>,
        acted: SyncSender<Arrival>,
    ) -> anyhow::Result<Option<ActingStage>> {
        let Some(html) = &self.acting_html else {
            return Ok(None);
        };
        let director = Director::new(self.scene, acted, status.clone(), self.token);
        Ok(Some(ActingStage::new(ActingParts {
            html: html.as_bytes().into(),
            pairing: Pairing::new().context("no random bytes for a pairing code")?,
            scene: self.scene,
            scene_toml: self.scene_toml,
            topics: self.topics,
            director,
            status: status.clone(),
            metrics: Arc::clone(self.metrics),
        })))
    }
}

fn read_scene(path: &Path) -> anyhow::Result<(Scene, Vec<u8>, CaptureSettings)> {
    let text =
        read_text(path).with_context(|| format!("{}: cannot read the scene", path.display()))?;
    let (scene, settings) =
        capture_from_toml(&text).map_err(|error| error.in_file(path.display().to_string()))?;
    Ok((scene, text.into_bytes(), settings))
}

fn spawn(name: &str, run: impl FnOnce() + Send + 'static) -> anyhow::Result<JoinHandle<()>> {
    let builder = thread::Builder::new().name(name.to_owned());
    builder.spawn(run).with_context(|| format!("thread {name}"))
}

fn spawn_previewer(
    previewer: Previewer,
    threads: &mut Vec<JoinHandle<()>>,
) -> anyhow::Result<SyncSender<PreviewInput>> {
    let (sender, queue) = mpsc::sync_channel(SO_FAR);
    threads.push(spawn("preview", move || previewer.run(&queue))?);
    Ok(sender)
}

fn spawn_finals(
    speaker: &Speaker,
    shown: watch::Sender<Shown>,
    metrics: &Arc<Metrics>,
    enough: &'static AtomicBool,
    threads: &mut Vec<JoinHandle<()>>,
) -> anyhow::Result<SyncSender<super::estimator::FinishedTake>> {
    let (sender, queue) = mpsc::sync_channel(FINALS);
    let (speaker, metrics) = (speaker.clone(), Arc::clone(metrics));
    threads.push(spawn("finals", move || {
        finals(&queue, &speaker, &shown, &metrics, enough);
    })?);
    Ok(sender)
}

fn spawn_syncer(
    speaker: &Speaker,
    threads: &mut Vec<JoinHandle<()>>,
) -> anyhow::Result<SyncSender<std::fs::File>> {
    // At most one sync waits: while one takes long, the next one serves both.
    let (sender, queue) = mpsc::sync_channel(1);
    let speaker = speaker.clone();
    threads.push(spawn("sync", move || sync_all(&queue, &speaker))?);
    Ok(sender)
}
