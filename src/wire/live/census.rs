//! Who and what is on iceoryx2: what a doctor looks at.

use std::path::{Path, PathBuf};

use iceoryx2::config::Config;
use iceoryx2::node::{NodeState, NodeView};
use iceoryx2::prelude::{CallbackProgression, Service as _};
use iceoryx2::service::static_config::messaging_pattern::MessagingPattern;

use super::error::LiveError;
use super::node::{CONTRACT, LiveService, config, shortcomings};

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
    /// Services that iceoryx2 does not show, by their files.
    pub hidden: Vec<HiddenService>,
}

/// A service that is there and that iceoryx2 passes over: another version of it made it, it is
/// another user's, or its file is broken. What its name and version are is read from its file,
/// if it can be.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct HiddenService {
    /// Its file.
    pub file: PathBuf,
    /// Its name.
    pub name: Option<String>,
    /// Version of iceoryx2 that made it.
    pub version: Option<String>,
    /// Why its file cannot be read.
    pub error: Option<String>,
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
    /// In what it is less than the contract wants for its payload, in words with figures.
    pub shortcomings: Vec<String>,
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
    let mut shown = Vec::new();
    LiveService::list(&config, |details| {
        let of_it = &details.static_details;
        shown.push(of_it.service_hash().as_str().to_owned());
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
        let type_name = payload.type_name().to_string();
        let of_contract = CONTRACT.iter().find(|(payload, _)| *payload == type_name);
        let wanted = of_contract.map(|(_, quality)| *quality);
        census.services.push(ServiceEntry {
            name,
            payload: type_name,
            payload_bytes: payload.size(),
            buffer: quality.subscriber_max_buffer_size(),
            publishers: quality.max_publishers(),
            subscribers: quality.max_subscribers(),
            shortcomings: wanted.map_or(Vec::new(), |wanted| shortcomings(quality, wanted)),
            nodes: nodes.len(),
            dead_nodes: nodes.iter().filter(is_dead).count(),
        });
        CallbackProgression::Continue
    })
    .map_err(|reason| error(format!("services cannot be listed: {reason:?}")))?;
    census.services.sort_by(|a, b| a.name.cmp(&b.name));
    census.hidden = hidden(&config, &shown).map_err(|reason| error(reason.to_string()))?;
    Ok(census)
}

/// Services with a file but not among those shown.
fn hidden(config: &Config, shown: &[String]) -> std::io::Result<Vec<HiddenService>> {
    let folder = PathBuf::from(config.global.root_path().to_string())
        .join(config.global.service.directory.to_string());
    let entries = match std::fs::read_dir(folder) {
        Ok(entries) => entries,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
        Err(error) => return Err(error),
    };
    let prefix = config.global.prefix.to_string();
    let suffix = config
        .global
        .service
        .static_config_storage_suffix
        .to_string();
    let mut found = Vec::new();
    for entry in entries {
        let file = entry?.path();
        let name = file.file_name().unwrap_or_default().to_string_lossy();
        let hash = name
            .strip_prefix(&prefix)
            .and_then(|name| name.strip_suffix(&suffix));
        if hash.is_some_and(|hash| shown.iter().all(|shown| shown != hash)) {
            found.extend(hidden_service(file));
        }
    }
    found.sort_by(|a, b| a.file.cmp(&b.file));
    Ok(found)
}

/// What its file says; nothing where it has gone meanwhile.
fn hidden_service(file: PathBuf) -> Option<HiddenService> {
    let text = match std::fs::read_to_string(&file) {
        Ok(text) => text,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return None,
        Err(error) => {
            return Some(HiddenService {
                file,
                error: Some(error.to_string()),
                ..HiddenService::default()
            });
        }
    };
    let table = text.parse::<toml::Table>().unwrap_or_default();
    let version = table.get("iceoryx2_version").and_then(|version| {
        let part = |name| version.get(name)?.as_integer();
        let [major, minor, patch] = [part("major")?, part("minor")?, part("patch")?];
        Some(format!("{major}.{minor}.{patch}"))
    });
    let name = table.get("service_name").and_then(toml::Value::as_str);
    Some(HiddenService {
        file,
        name: name.map(str::to_owned),
        version,
        error: None,
    })
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
