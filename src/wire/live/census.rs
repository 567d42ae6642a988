//! Who and what is on iceoryx2: what a doctor looks at.

use std::path::{Path, PathBuf};

use iceoryx2::node::{NodeState, NodeView};
use iceoryx2::prelude::{CallbackProgression, Service as _};
use iceoryx2::service::static_config::messaging_pattern::MessagingPattern;

use super::error::LiveError;
use super::node::{LiveService, config};

/// What is there.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Census {
    /// Folder of iceoryx2's files.
    pub root: PathBuf,
    /// Processes that take part.
    pub nodes: Vec<NodeEntry>,
    /// Services whose names begin with `enact`, by name.
    pub services: Vec<ServiceEntry>,
    /// Services of others.
    pub others: usize,
}

/// A process that takes part.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NodeEntry {
    /// The name it gave itself, and its executable; what can be known of it.
    pub name: String,
    /// Process that it belongs to, if that can be known.
    pub process: Option<i32>,
    /// How it is.
    pub state: Liveness,
}

/// How a node is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Liveness {
    /// Its process runs.
    Alive,
    /// Its process was killed and left things behind.
    Dead,
    /// Another user's: we may not know.
    Inaccessible,
    /// Its files contradict one another.
    Undefined,
}

/// A publish–subscribe service.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ServiceEntry {
    /// Its name.
    pub name: String,
    /// Type of its payload.
    pub payload: String,
    /// Bytes of the payload.
    pub payload_bytes: usize,
    /// Samples that a subscriber may fall behind.
    pub buffer: usize,
    /// Publishers at a time.
    pub publishers: usize,
    /// Subscribers at a time.
    pub subscribers: usize,
    /// Whether the oldest sample makes room for a new one.
    pub has_safe_overflow: bool,
    /// Version of iceoryx2 that made it.
    pub version: String,
    /// Processes on it.
    pub nodes: usize,
    /// Those of them that were killed.
    pub dead_nodes: usize,
}

/// Looks at everything without touching it. Fails where the lists cannot be read.
pub fn census(config_file: Option<&Path>) -> Result<Census, LiveError> {
    let config = config(config_file)?;
    let root = PathBuf::from(config.global.root_path().to_string());
    let error = |reason: String| LiveError::Node {
        root: root.display().to_string(),
        reason,
    };
    let mut census = Census {
        root: root.clone(),
        ..Census::default()
    };
    iceoryx2::node::Node::<LiveService>::list(&config, |state| {
        census.nodes.push(node_entry(&state));
        CallbackProgression::Continue
    })
    .map_err(|reason| error(format!("nodes cannot be listed: {reason:?}")))?;
    LiveService::list(&config, |details| {
        let of_it = &details.static_details;
        let name = of_it.name().as_str().to_owned();
        let MessagingPattern::PublishSubscribe(quality) = of_it.messaging_pattern() else {
            census.others += 1;
            return CallbackProgression::Continue;
        };
        if !name.starts_with("enact/") {
            census.others += 1;
            return CallbackProgression::Continue;
        }
        let nodes = details
            .dynamic_details
            .as_ref()
            .map_or(&[][..], |d| &d.nodes);
        let is_dead = |state: &&NodeState<LiveService>| matches!(state, NodeState::Dead(_));
        let payload = &quality.message_type_details().payload;
        census.services.push(ServiceEntry {
            name,
            payload: payload.type_name().to_string(),
            payload_bytes: payload.size(),
            buffer: quality.subscriber_max_buffer_size(),
            publishers: quality.max_publishers(),
            subscribers: quality.max_subscribers(),
            has_safe_overflow: quality.has_safe_overflow(),
            version: of_it.iceoryx2_version().to_string(),
            nodes: nodes.len(),
            dead_nodes: nodes.iter().filter(is_dead).count(),
        });
        CallbackProgression::Continue
    })
    .map_err(|reason| error(format!("services cannot be listed: {reason:?}")))?;
    census.services.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(census)
}

fn node_entry(state: &NodeState<LiveService>) -> NodeEntry {
    let named = |view: &dyn Fn() -> Option<String>| view().unwrap_or_else(|| "unknown".into());
    match state {
        NodeState::Alive(view) => NodeEntry {
            name: named(&|| {
                let details = view.details().as_ref()?;
                Some(format!("{} ({})", details.name(), details.executable()))
            }),
            process: view.details().as_ref().map(|d| d.process_id().value()),
            state: Liveness::Alive,
        },
        NodeState::Dead(view) => NodeEntry {
            name: named(&|| {
                let details = view.details().as_ref()?;
                Some(format!("{} ({})", details.name(), details.executable()))
            }),
            process: view.details().as_ref().map(|d| d.process_id().value()),
            state: Liveness::Dead,
        },
        NodeState::Inaccessible(id) => NodeEntry {
            name: format!("{id:?}"),
            process: None,
            state: Liveness::Inaccessible,
        },
        NodeState::Undefined(id) => NodeEntry {
            name: format!("{id:?}"),
            process: None,
            state: Liveness::Undefined,
        },
    }
}
