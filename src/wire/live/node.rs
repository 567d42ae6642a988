//! Joins iceoryx2 and opens services with the quality of service of the contract.

use std::path::Path;
use std::time::Duration;

use iceoryx2::config::Config;
use iceoryx2::node::NodeBuilder;
use iceoryx2::prelude::{
    FilePath, SemanticString, ServiceName, SignalHandlingMode, ZeroCopySend, ipc,
};
use iceoryx2::service::port_factory::publish_subscribe::PortFactory;
use iceoryx2::service::static_config::publish_subscribe::StaticConfig;

use super::error::LiveError;

/// The variant of iceoryx2 in use: between processes, with ports bound to the thread that made
/// them.
pub type LiveService = ipc::Service;

/// A service that was made or opened.
pub type Factory<T> = PortFactory<LiveService, T, ()>;

/// Quality of service: capacities of a service, fixed by the process that creates it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Quality {
    /// Samples kept for a subscriber until it reads them.
    pub buffer: usize,
    /// Greatest number of publishers at a time.
    pub publishers: usize,
    /// Greatest number of subscribers at a time.
    pub subscribers: usize,
    /// Samples that a subscriber receives from before it joined.
    pub history: usize,
}

impl Quality {
    /// For poses: two seconds at 1 kHz.
    pub const POSES: Self = Self {
        buffer: 2048,
        publishers: 4,
        subscribers: 8,
        history: 0,
    };
    /// For marks, control commands and takes.
    pub const NOTES: Self = Self {
        buffer: 256,
        publishers: 16,
        subscribers: 16,
        history: 0,
    };
    /// For frames of estimates: half a minute at 120 Hz.
    pub const FRAMES: Self = Self {
        buffer: 4096,
        publishers: 4,
        subscribers: 8,
        history: 0,
    };
    /// For answers in words, which are long.
    pub const TEXTS: Self = Self {
        buffer: 64,
        publishers: 4,
        subscribers: 16,
        history: 0,
    };
}

/// The payloads of the contract, with the quality of the services that carry them.
pub const CONTRACT: [(&str, Quality); 8] = [
    ("enact.Pose.1", Quality::POSES),
    ("enact.Mark.1", Quality::NOTES),
    ("enact.Control.2", Quality::NOTES),
    ("enact.Take.1", Quality::NOTES),
    ("enact.Estimate.1", Quality::NOTES),
    ("enact.EstimatedPose.1", Quality::FRAMES),
    ("enact.Label.1", Quality::NOTES),
    ("enact.Answer.1", Quality::TEXTS),
];

/// Greatest number of nodes on one service at a time.
const NODES: usize = 64;

/// Service of take control.
pub const CONTROL_SERVICE: &str = "enact/control";

/// Service of the states of takes.
pub const TAKE_SERVICE: &str = "enact/take";

/// Service of estimates.
pub const ESTIMATE_SERVICE: &str = "enact/estimate";

/// Service of what directors say of takes.
pub const LABEL_SERVICE: &str = "enact/label";

/// Service of answers in words.
pub const ANSWER_SERVICE: &str = "enact/answer";

/// The name of the service that carries a topic of the scene. iceoryx2 has names in ASCII only: every
/// other byte of a topic in UTF-8, and `%`, is written as `%` and two hexadecimal digits.
pub fn service_name(topic: &str) -> String {
    let separator = if topic.starts_with('/') { "" } else { "/" };
    let mut name = format!("enact{separator}");
    for byte in topic.bytes() {
        match byte {
            b'%' | 0..=31 | 127.. => name.push_str(&format!("%{byte:02X}")),
            _ => name.push(char::from(byte)),
        }
    }
    name
}

/// The topic of a service of that name: [`service_name`] backwards.
pub fn topic_of_service(name: &str) -> Option<String> {
    let topic = name.strip_prefix("enact")?;
    let mut bytes = Vec::with_capacity(topic.len());
    let mut rest = topic.as_bytes();
    while let [first, others @ ..] = rest {
        let digit = |at: usize| char::from(*others.get(at)?).to_digit(16);
        match (first, digit(0), digit(1)) {
            (b'%', Some(high), Some(low)) => {
                bytes.push((16 * high + low) as u8);
                rest = &others[2..];
            }
            _ => {
                bytes.push(*first);
                rest = others;
            }
        }
    }
    String::from_utf8(bytes).ok()
}

/// A node of iceoryx2: this process as its user.
pub struct Node {
    node: iceoryx2::node::Node<LiveService>,
    config: Config,
}

/// An open service, and where its quality is less than was asked for.
pub struct Served<T: core::fmt::Debug + ZeroCopySend + 'static> {
    /// Its name.
    pub name: String,
    /// Makes publishers and subscribers.
    pub factory: Factory<T>,
    /// Where another process made it with less quality than wanted, in words with figures.
    pub shortcomings: Vec<String>,
}

/// The configuration in a file, or the one that iceoryx2 finds by itself. Fails where it cannot be
/// read.
pub(super) fn config(file: Option<&Path>) -> Result<Config, LiveError> {
    let Some(path) = file else {
        return Ok(Config::global_config().clone());
    };
    let error = |reason: String| LiveError::Config {
        path: path.to_owned(),
        reason,
    };
    let name = path.to_str().ok_or_else(|| error("not UTF-8".into()))?;
    let name = FilePath::new(name.as_bytes()).map_err(|reason| error(format!("{reason:?}")))?;
    Config::from_file(&name).map_err(|reason| error(format!("{reason:?}")))
}

/// Where iceoryx2's files are, and the beginning of their names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct IpcFiles {
    /// The folder.
    pub root: std::path::PathBuf,
    /// What names begin with.
    pub prefix: String,
}

/// Those of a configuration.
pub(super) fn place(config: &Config) -> IpcFiles {
    IpcFiles {
        root: config.global.root_path().to_string().into(),
        prefix: config.global.prefix.to_string(),
    }
}

impl Node {
    /// Joins iceoryx2 under a name that others see. Does not change how the process handles
    /// signals.
    pub fn join(name: &str, config_file: Option<&Path>) -> Result<Self, LiveError> {
        let config = config(config_file)?;
        let root = config.global.root_path().to_string();
        let error = |reason: String| LiveError::Node {
            root: root.clone(),
            reason,
        };
        let name = name
            .try_into()
            .map_err(|reason| error(format!("{reason:?}")))?;
        let node = NodeBuilder::new()
            .name(&name)
            .config(&config)
            .signal_handling_mode(SignalHandlingMode::Disabled)
            .create::<LiveService>()
            .map_err(|reason| error(format!("{reason:?}; `enact doctor` says more")))?;
        Ok(Self { node, config })
    }

    /// Makes the service with the wanted quality, or opens the existing one and lists where its
    /// quality is less. Fails for a service with another payload.
    pub fn service<T>(&self, name: &str, wanted: Quality) -> Result<Served<T>, LiveError>
    where
        T: core::fmt::Debug + ZeroCopySend + 'static,
    {
        let service_name = ServiceName::new(name).map_err(|reason| LiveError::Name {
            name: name.to_owned(),
            reason: format!("{reason:?}"),
        })?;
        let create = || {
            self.node
                .service_builder(&service_name)
                .publish_subscribe::<T>()
                .enable_safe_overflow(true)
                .subscriber_max_buffer_size(wanted.buffer)
                .subscriber_max_borrowed_samples(2)
                .history_size(wanted.history)
                .max_publishers(wanted.publishers)
                .max_subscribers(wanted.subscribers)
                .max_nodes(NODES)
                .create()
        };
        let open = || {
            let builder = self.node.service_builder(&service_name);
            builder.publish_subscribe::<T>().open()
        };
        // Between the two calls another process may make it, or its last user may leave.
        let mut reason = String::new();
        for _ in 0..3 {
            match open() {
                Ok(factory) => return Ok(Served::new(name, factory, wanted)),
                Err(error) => reason = format!("cannot be opened: {error:?}"),
            }
            match create() {
                Ok(factory) => return Ok(Served::new(name, factory, wanted)),
                Err(error) if format!("{error:?}") == "AlreadyExists" => {}
                Err(error) => reason = format!("{reason}, cannot be made: {error:?}"),
            }
        }
        Err(LiveError::Service {
            service: name.to_owned(),
            reason,
        })
    }

    /// The services among these that are no longer there for others to find: somebody has removed
    /// their files.
    pub fn gone<'a>(&self, names: impl IntoIterator<Item = &'a str>) -> Vec<String> {
        use iceoryx2::prelude::{MessagingPattern, Service as _};
        let is_gone = |name: &&str| {
            ServiceName::new(name).is_ok_and(|name| {
                let pattern = MessagingPattern::PublishSubscribe;
                !matches!(
                    LiveService::does_exist(&name, &self.config, pattern),
                    Ok(true)
                )
            })
        };
        let gone = names.into_iter().filter(is_gone);
        gone.map(str::to_owned).collect()
    }

    /// Publishers and subscribers of a service that is there and carries `T`.
    pub fn ports<T>(&self, name: &str) -> Option<(usize, usize)>
    where
        T: core::fmt::Debug + ZeroCopySend + 'static,
    {
        use iceoryx2::service::port_factory::PortFactory as _;
        let name = ServiceName::new(name).ok()?;
        let builder = self.node.service_builder(&name).publish_subscribe::<T>();
        let factory = builder.open().ok()?;
        let found = factory.dynamic_config();
        Some((found.number_of_publishers(), found.number_of_subscribers()))
    }

    /// Where iceoryx2's files are, and the beginning of their names.
    pub fn place(&self) -> IpcFiles {
        place(&self.config)
    }

    /// Removes the resources that killed processes left on services. Returns how many such
    /// processes there were, and for how many it failed.
    pub fn bury(&self) -> (u64, u64) {
        let state = self
            .node
            .blocking_cleanup_dead_nodes(Duration::from_millis(200));
        (state.cleanups, state.failed_cleanups)
    }
}

/// Where the quality of a service is less than wanted, in words with figures.
pub(super) fn shortcomings(found: &StaticConfig, wanted: Quality) -> Vec<String> {
    let rows = [
        (
            "buffer of a subscriber",
            found.subscriber_max_buffer_size(),
            wanted.buffer,
        ),
        ("publishers", found.max_publishers(), wanted.publishers),
        ("subscribers", found.max_subscribers(), wanted.subscribers),
        ("history", found.history_size(), wanted.history),
    ];
    let mut shortcomings: Vec<String> = rows
        .into_iter()
        .filter(|(_, found, wanted)| found < wanted)
        .map(|(what, found, wanted)| format!("{what}: {found}, wanted {wanted}"))
        .collect();
    if !found.has_safe_overflow() {
        shortcomings.push("full buffers make publishers wait: safe overflow is off".into());
    }
    shortcomings
}

impl<T: core::fmt::Debug + ZeroCopySend + 'static> Served<T> {
    fn new(name: &str, factory: Factory<T>, wanted: Quality) -> Self {
        use iceoryx2::service::port_factory::PortFactory as _;
        let shortcomings = shortcomings(factory.static_config(), wanted);
        Self {
            name: name.to_owned(),
            factory,
            shortcomings,
        }
    }

    /// Buffer of a subscriber, in samples.
    pub fn buffer(&self) -> usize {
        use iceoryx2::service::port_factory::PortFactory as _;
        self.factory.static_config().subscriber_max_buffer_size()
    }
}

#[cfg(test)]
mod tests {
    use super::{service_name, topic_of_service};

    #[test]
    fn every_topic_has_a_name_of_its_own_in_ascii() {
        for (topic, name) in [
            ("/tracker/mug/pose", "enact/tracker/mug/pose"),
            ("marks", "enact/marks"),
            ("/tracker/Stift ü/pose", "enact/tracker/Stift %C3%BC/pose"),
            ("/100%", "enact/100%25"),
            ("/a\nb", "enact/a%0Ab"),
        ] {
            assert_eq!(service_name(topic), name);
            let back = topic_of_service(name).expect("UTF-8");
            assert_eq!(back.trim_start_matches('/'), topic.trim_start_matches('/'));
        }
        assert_eq!(topic_of_service("other"), None);
        assert_eq!(topic_of_service("enact/%FF"), None);
        assert_eq!(topic_of_service("enact/%F"), Some("/%F".to_owned()));
    }

    proptest::proptest! {
        #[test]
        fn names_lead_back_to_topics(topic in "/.{0,40}") {
            let name = service_name(&topic);
            proptest::prop_assert!(name.is_ascii());
            proptest::prop_assert_eq!(topic_of_service(&name), Some(topic));
        }
    }
}
