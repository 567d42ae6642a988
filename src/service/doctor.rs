//! Checks what a capture needs: services, processes, permissions, disk and memory.

use std::path::{Path, PathBuf};

use serde::Serialize;

use crate::config::capture_from_toml;
use crate::ingest::live::census::{Census, HiddenService, Liveness, ServiceEntry, census};
use crate::ingest::live::{
    ANSWER_SERVICE, CONTROL_SERVICE, ESTIMATE_SERVICE, LABEL_SERVICE, TAKE_SERVICE, running_daemon,
    service_name, stream_topics, topic_of_service,
};
use crate::ingest::read_text;
use crate::motion::Scene;
use crate::write::{abandoned, topics};

/// Version of iceoryx2 in this build; other versions are not compatible.
const ICEORYX2: &str = "0.10";

/// Free space below which a recording is in danger \[bytes\]: on disk, in shared memory.
const DISK_BYTES: u64 = 1 << 30;
const MEMORY_BYTES: u64 = 64 << 20;

/// The input of [`doctor`].
#[derive(Clone, Debug, Default)]
pub struct DoctorJob {
    /// A scene whose services and folder are checked too.
    pub scene: Option<PathBuf>,
    /// Configuration of iceoryx2; by default where iceoryx2 looks for it.
    pub iceoryx2: Option<PathBuf>,
}

/// The result of a check.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Health {
    /// As it should be.
    Well,
    /// Works, but something may get lost.
    Poor,
    /// Does not work.
    Bad,
}

/// One check.
#[derive(Clone, Debug, Serialize)]
pub struct Finding {
    /// What was checked.
    pub subject: String,
    /// The result.
    pub health: Health,
    /// The result in words with figures.
    pub text: String,
}

/// Runs all checks without changing anything. Fails where the scene is wrong.
pub fn doctor(job: &DoctorJob) -> anyhow::Result<Vec<Finding>> {
    let mut findings = Vec::new();
    let mut say = |subject: &str, health, text: String| {
        let subject = subject.to_owned();
        findings.push(Finding {
            subject,
            health,
            text,
        });
    };
    let found = census(job.iceoryx2.as_deref());
    match &found {
        Ok(found) => {
            look_at_iceoryx2(found, &mut say);
            look_for_daemon(job, &mut say);
        }
        Err(error) => {
            let advice = "are its files another user's? Run all as one user";
            say("iceoryx2", Health::Bad, format!("{error}; {advice}"));
        }
    }
    room("/dev/shm", Path::new("/dev/shm"), MEMORY_BYTES, &mut say);
    if let Some(path) = &job.scene {
        let text = read_text(path)
            .map_err(|error| anyhow::anyhow!("{}: cannot read: {error}", path.display()))?;
        let in_file = |error: crate::config::SceneError| error.in_file(path.display().to_string());
        let (scene, settings) = capture_from_toml(&text).map_err(in_file)?;
        if let Ok(found) = &found {
            look_for_services(&scene, found, &mut say);
            look_for_strangers(&scene, found, &mut say);
        }
        look_at_folder(&settings.folder, &mut say);
    }
    Ok(findings)
}

/// What trackers publish.
const POSE: &str = "enact.Pose.1";

/// Says which daemon runs.
fn look_for_daemon(job: &DoctorJob, say: &mut impl FnMut(&str, Health, String)) {
    match running_daemon(job.iceoryx2.as_deref()) {
        Ok(Some(daemon)) => say(
            "daemon",
            Health::Well,
            format!(
                "process {} records scene {:?}",
                daemon.process, daemon.scene
            ),
        ),
        Ok(None) => say(
            "daemon",
            Health::Poor,
            "no daemon runs: start `enact capture SCENE`".into(),
        ),
        Err(error) => say("daemon", Health::Poor, error.to_string()),
    }
}

/// Looks for trackers of bodies that the scene does not have, and for performers on other topics.
fn look_for_strangers(scene: &Scene, found: &Census, say: &mut impl FnMut(&str, Health, String)) {
    let known = services_of(scene);
    for service in &found.services {
        let (what, wanted) = match service.payload.as_str() {
            POSE => (
                "poses",
                stream_topics(scene)
                    .into_iter()
                    .map(|of| of.topic)
                    .collect(),
            ),
            "enact.Mark.1" => ("marks", vec![scene.marks_topic.clone()]),
            _ => continue,
        };
        let is_known = known.iter().any(|(name, _)| *name == service.name);
        let is_published = service.ports.is_some_and(|(publishers, _)| publishers > 0);
        if is_known || !is_published {
            continue;
        }
        let topic = topic_of_service(&service.name).unwrap_or_else(|| service.name.clone());
        let text = format!(
            "somebody publishes {what} on {topic:?}, which scene {:?} does not have; it has {}",
            scene.name,
            wanted.join(", ")
        );
        say(&service.name, Health::Poor, text);
    }
}

/// Checks whether the services of the scene exist or can be made.
fn look_for_services(scene: &Scene, found: &Census, say: &mut impl FnMut(&str, Health, String)) {
    let is_hidden = |name: &String| found.hidden.iter().any(|h| h.name.as_ref() == Some(name));
    for (name, payload) in services_of(scene) {
        match found.services.iter().find(|service| service.name == name) {
            None if is_hidden(&name) => {}
            None if payload == POSE => say(
                &name,
                Health::Poor,
                "not there, so no tracker publishes: start its driver; the daemon will make it"
                    .into(),
            ),
            None => say(
                &name,
                Health::Well,
                "not there: the daemon will make it".into(),
            ),
            Some(service) if service.payload != payload => say(
                &name,
                Health::Bad,
                format!(
                    "carries {}, wanted {payload}: whoever made it speaks another version",
                    service.payload
                ),
            ),
            Some(_) => {}
        }
    }
}

/// The services of a daemon for the scene, with their payloads.
fn services_of(scene: &Scene) -> Vec<(String, &'static str)> {
    let streams = stream_topics(scene).into_iter();
    let mut services: Vec<_> = streams
        .map(|stream| (service_name(&stream.topic), POSE))
        .collect();
    services.push((service_name(&scene.marks_topic), "enact.Mark.1"));
    services.push((CONTROL_SERVICE.to_owned(), "enact.Control.2"));
    services.push((TAKE_SERVICE.to_owned(), "enact.Take.1"));
    services.push((LABEL_SERVICE.to_owned(), "enact.Label.1"));
    services.push((ANSWER_SERVICE.to_owned(), "enact.Answer.1"));
    services.push((ESTIMATE_SERVICE.to_owned(), "enact.Estimate.1"));
    services.extend(scene.links.iter().map(|body| {
        let topic = topics::estimate_pose(&body.name);
        (service_name(&topic), "enact.EstimatedPose.1")
    }));
    services
}

fn look_at_iceoryx2(found: &Census, say: &mut impl FnMut(&str, Health, String)) {
    let root = found.root.display();
    say(
        "iceoryx2",
        Health::Well,
        format!("{ICEORYX2}, files below {root}"),
    );
    if found.root.exists() {
        let (health, text) = match tempfile::tempfile_in(&found.root) {
            Ok(_) => (Health::Well, "may be written".to_owned()),
            Err(error) => (Health::Bad, format!("may not be written: {error}")),
        };
        say(&root.to_string(), health, text);
    }
    for node in &found.nodes {
        let process = node
            .process
            .map_or(String::new(), |id| format!(", process {id}"));
        let (health, what) = match node.state {
            Liveness::Alive => (Health::Well, "runs"),
            Liveness::Dead => (Health::Poor, "was killed; the daemon clears it away"),
            Liveness::Inaccessible => (Health::Poor, "is another user's: run all as one user"),
            Liveness::Undefined => (Health::Poor, "has files that contradict one another"),
        };
        say(
            &format!("process {}", node.name),
            health,
            format!("{what}{process}"),
        );
    }
    for service in &found.services {
        let (health, text) = of_service(service);
        say(&service.name, health, text);
    }
    for service in &found.hidden {
        let file = service.file.display().to_string();
        let subject = service.name.as_ref().unwrap_or(&file);
        say(subject, Health::Bad, of_hidden(service));
    }
}

fn of_hidden(service: &HiddenService) -> String {
    match (&service.version, &service.error) {
        (_, Some(error)) => format!("may not be read: {error}; run all as one user"),
        (Some(version), None) => format!(
            "made by iceoryx2 {version}, ours is {ICEORYX2} and opens nothing else; or its rights \
             or shared memory are not for us"
        ),
        (None, None) => "its file is broken".to_owned(),
    }
}

fn of_service(service: &ServiceEntry) -> (Health, String) {
    let present = |of: fn((usize, usize)) -> usize| {
        let count = service.ports.map(|ports| of(ports).to_string());
        count.unwrap_or_else(|| "?".to_owned())
    };
    let mut text = format!(
        "{} of {} bytes, buffer {}, {} of {} publishers, {} of {} subscribers, {} processes",
        service.payload,
        service.payload_bytes,
        service.buffer,
        present(|(publishers, _)| publishers),
        service.publishers,
        present(|(_, subscribers)| subscribers),
        service.subscribers,
        service.nodes
    );
    let mut health = Health::Well;
    if service.payload == POSE && service.ports.is_some_and(|(publishers, _)| publishers == 0) {
        health = Health::Poor;
        text.push_str("; no tracker publishes: start its driver");
    }
    let is_full = service.ports.is_some_and(|(publishers, subscribers)| {
        publishers >= service.publishers || subscribers >= service.subscribers
    });
    if is_full {
        health = Health::Poor;
        text.push_str(", no place is left");
    }
    if service.dead_nodes > 0 {
        health = Health::Poor;
        text.push_str(&format!(", {} of them killed", service.dead_nodes));
    }
    if !service.shortcomings.is_empty() {
        health = Health::Poor;
        text.push_str(&format!(
            "; {}: start the daemon first",
            service.shortcomings.join(", ")
        ));
    }
    (health, text)
}

fn look_at_folder(folder: &Path, say: &mut impl FnMut(&str, Health, String)) {
    let name = folder.display().to_string();
    if !folder.exists() {
        return say(
            &name,
            Health::Well,
            "not there: the daemon will make it".into(),
        );
    }
    match tempfile::tempfile_in(folder) {
        Ok(_) => say(&name, Health::Well, "may be written".into()),
        Err(error) => say(&name, Health::Bad, format!("may not be written: {error}")),
    }
    room(&name, folder, DISK_BYTES, say);
    match abandoned(folder) {
        Ok(left) if left.is_empty() => {}
        Ok(left) => say(
            &name,
            Health::Poor,
            format!(
                "{} journals of takes that were cut short: enact recover {name}",
                left.len()
            ),
        ),
        Err(error) => say(&name, Health::Bad, error.to_string()),
    }
}

fn room(name: &str, folder: &Path, wanted: u64, say: &mut impl FnMut(&str, Health, String)) {
    match fs4::available_space(folder) {
        Ok(free) => {
            let health = if free < wanted {
                Health::Poor
            } else {
                Health::Well
            };
            say(name, health, format!("{} MiB free", free >> 20));
        }
        Err(error) => say(
            name,
            Health::Poor,
            format!("free space is not known: {error}"),
        ),
    }
}
