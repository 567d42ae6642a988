//! Lists the nodes and services of iceoryx2 on this machine, for `enact doctor`.

use std::path::{Path, PathBuf};

use iceoryx2::config::Config;
use iceoryx2::node::{NodeState, NodeView};
use iceoryx2::prelude::{CallbackProgression, Service as _};
use iceoryx2::service::static_config::messaging_pattern::MessagingPattern;

use super::error::LiveError;
use super::node::{CONTRACT, LiveService, Node, config, shortcomings};
use super::payload::{
    AnswerRecord, ControlRecord, EstimateRecord, EstimatedPoseRecord, LabelRecord, MarkRecord,
    PoseRecord, TakeRecord,
};

/// Nodes and services found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Census {
    /// Folder of iceoryx2's files.
    pub root: PathBuf,
    /// Nodes: processes that use iceoryx2.
    pub nodes: Vec<NodeEntry>,
    /// Services whose names begin with `enact`, by name.
    pub services: Vec<ServiceEntry>,
    /// Number of services with other names.
    pub others: usize,
    /// Services with a file that iceoryx2 does not list.
    pub hidden: Vec<HiddenService>,
}

/// A service with a file that iceoryx2 does not list: it was made by another version, belongs to
/// another user, or its file is broken. Name and version are read from the file where possible.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct HiddenService {
    /// Its file.
    pub file: PathBuf,
    /// Its name, if the file can be read.
    pub name: Option<String>,
    /// Version of iceoryx2 that made it.
    pub version: Option<String>,
    /// Why its file cannot be read.
    pub error: Option<String>,
}

/// A process that uses iceoryx2.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NodeEntry {
    /// The name it gave itself and its executable, as far as they can be read.
    pub name: String,
    /// Its process id, if it can be read.
    pub process: Option<i64>,
    /// Whether the process runs.
    pub state: Liveness,
}

/// The state of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Liveness {
    /// Its process runs.
    Alive,
    /// Its process was killed and left resources behind.
    Dead,
    /// It belongs to another user, so that its state cannot be read.
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
    /// Size of the payload in bytes.
    pub payload_bytes: usize,
    /// Buffer of a subscriber, in samples.
    pub buffer: usize,
    /// Greatest number of publishers at a time.
    pub publishers: usize,
    /// Greatest number of subscribers at a time.
    pub subscribers: usize,
    /// Publishers and subscribers that are there; `None` where it cannot be opened.
    pub ports: Option<(usize, usize)>,
    /// Where its quality is less than the contract requires for its payload, in words with figures.
    pub shortcomings: Vec<String>,
    /// Number of nodes that use it.
    pub nodes: usize,
    /// Number of those whose process was killed.
    pub dead_nodes: usize,
}

/// Lists nodes and services without changing any; joins them for a moment to count their ports. Fails where the lists cannot be read.
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
            ports: None,
            shortcomings: wanted.map_or(Vec::new(), |wanted| shortcomings(quality, wanted)),
            nodes: nodes.len(),
            dead_nodes: nodes.iter().filter(is_dead).count(),
        });
        CallbackProgression::Continue
    })
    .map_err(|reason| error(format!("services cannot be listed: {reason:?}")))?;
    census.services.sort_by(|a, b| a.name.cmp(&b.name));
    // Joined after the nodes are listed: it is none of those that were there.
    if !census.services.is_empty()
        && let Ok(node) = Node::join("enact doctor", config_file)
    {
        for service in &mut census.services {
            service.ports = ports(&node, service);
        }
    }
    census.hidden = hidden(&config, &shown).map_err(|reason| error(reason.to_string()))?;
    Ok(census)
}

/// Publishers and subscribers of a service of the contract.
fn ports(node: &Node, service: &ServiceEntry) -> Option<(usize, usize)> {
    let name = service.name.as_str();
    match service.payload.as_str() {
        "enact.Pose.1" => node.ports::<PoseRecord>(name),
        "enact.Mark.1" => node.ports::<MarkRecord>(name),
        "enact.Control.2" => node.ports::<ControlRecord>(name),
        "enact.Take.1" => node.ports::<TakeRecord>(name),
        "enact.Label.1" => node.ports::<LabelRecord>(name),
        "enact.Answer.1" => node.ports::<AnswerRecord>(name),
        "enact.Estimate.1" => node.ports::<EstimateRecord>(name),
        "enact.EstimatedPose.1" => node.ports::<EstimatedPoseRecord>(name),
        _ => None,
    }
}

/// Services with a file that are not among those listed.
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

/// The content of a service's file; `None` where the file has gone meanwhile.
fn hidden_service(file: PathBuf) -> Option<HiddenService> {
    let text = match super::super::pipe::read_text(&file) {
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
            process: view
                .details()
                .as_ref()
                .map(|d| i64::from(d.process_id().value())),
            state: Liveness::Alive,
        },
        NodeState::Dead(view) => NodeEntry {
            name: named(&|| {
                let details = view.details().as_ref()?;
                Some(format!("{} ({})", details.name(), details.executable()))
            }),
            process: view
                .details()
                .as_ref()
                .map(|d| i64::from(d.process_id().value())),
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
