//! Recordings: MCAP files that hold a take.

use std::path::{Path, PathBuf};
use std::time::Instant;

use super::error::IngestError;
use super::report::TakeReport;
use super::route::{self, RouteFormat};
use super::source::{RecordingSource, Source};
use super::survey::{Survey, cameras, choose_frames};
use crate::motion::{Scene, SketchRow, Stamp, TakeEvent};
use crate::wire::container::{Channel, Reading};
use crate::wire::decode::PoseFormat;
use crate::wire::{Container, ContainerError, DecodeError, decode_keyframe, read_whole};

/// Name of the attachment that holds the scene.
pub const SCENE_NAME: &str = "scene.toml";

/// An MCAP file in memory. Of its attachments only the scene is accessible: a made recording may
/// also carry the true motion, which an estimation must not see.
#[derive(Clone, Debug)]
pub struct Recording {
    path: PathBuf,
    container: Container,
}

/// The events of a scene in a recording.
#[derive(Clone, Debug, PartialEq)]
pub struct Take {
    /// Events in file order.
    pub events: Vec<TakeEvent>,
    /// Counts of what was found.
    pub report: TakeReport,
}

/// Most samples and marks that are read of a file of that size: a sample takes some hundred bytes in
/// memory in each of the stages, and a bomb of 50 kB can hold millions. A hundred thousand are 100 s
/// at 1 kHz; files that are no bombs have more than sixteen bytes for each of theirs.
fn sample_limit(bytes: usize) -> u64 {
    100_000 + bytes as u64 / 16
}

impl Recording {
    /// Reads a file, or [stdin](crate::wire::is_pipe), and walks through it once. A damaged or cut-off file is no error as long
    /// as it begins as MCAP: see [`Container::damages`].
    pub fn open(path: &Path) -> Result<Self, IngestError> {
        Self::open_until(path, None)
    }

    /// [`Recording::open`], which stops reading at a deadline, wherever it is
    /// ([`Damage::Late`](crate::wire::container::Damage::Late)).
    pub fn open_until(path: &Path, deadline: Option<Instant>) -> Result<Self, IngestError> {
        if path.is_dir() {
            return Err(IngestError::Folder {
                path: path.to_owned(),
            });
        }
        let bytes = read_whole(path).map_err(|source| IngestError::Read {
            path: path.to_owned(),
            source,
        })?;
        let reading = Reading {
            deadline,
            ..Reading::default()
        };
        Self::of(path, Container::read(bytes, reading))
    }

    /// [`Recording::open`] for bytes in memory; `path` is their name in errors.
    pub fn from_bytes(path: &Path, bytes: Vec<u8>) -> Result<Self, IngestError> {
        Self::of(path, Container::new(bytes))
    }

    fn of(path: &Path, container: Result<Container, ContainerError>) -> Result<Self, IngestError> {
        let path = path.to_owned();
        match container {
            Ok(container) => Ok(Self { path, container }),
            Err(source) => Err(IngestError::Container { path, source }),
        }
    }

    /// Where it was read from.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The MCAP file: channels, counts, damage; [`crate::write`] copies it.
    pub fn container(&self) -> &Container {
        &self.container
    }

    /// The scene it carries: the last attachment named [`SCENE_NAME`]. [`Recording::only_scene`] asks whether there is
    /// another.
    pub fn scene_toml(&self) -> Option<&[u8]> {
        self.scenes().last()
    }

    /// [`Recording::scene_toml`]; fails where several are attached that differ.
    pub fn only_scene(&self) -> Result<Option<&[u8]>, IngestError> {
        let last = self.scene_toml();
        if self.scenes().all(|scene| Some(scene) == last) {
            return Ok(last);
        }
        Err(IngestError::ManyScenes {
            path: self.path.clone(),
            count: self.scenes().count(),
        })
    }

    fn scenes(&self) -> impl Iterator<Item = &[u8]> {
        let attachments = self.container.attachments().iter();
        let scenes = attachments.filter(|attachment| attachment.name == SCENE_NAME);
        scenes.map(|attachment| self.container.attachment_data(attachment))
    }

    /// Topics with messages that hold poses, in alphabetical order, but for those of an estimate.
    pub fn pose_topics(&self) -> Vec<&str> {
        let is_pose = |channel: &&Channel| {
            let schema = self.container.schema_of(channel);
            let schema = schema.map_or("", |schema| schema.name.as_str());
            PoseFormat::of(schema, &channel.message_encoding).is_some()
        };
        let channels = self.container.channels().values().filter(is_pose);
        let mut topics: Vec<&str> = channels.map(|channel| channel.topic.as_str()).collect();
        let is_ours =
            |topic: &str| topic.starts_with("/estimate/") || topic.starts_with("/sketch/");
        topics.retain(|topic| !is_ours(topic));
        topics.sort_unstable();
        topics.dedup();
        topics
    }

    /// Whether its end is missing; everything before is read.
    pub fn is_truncated(&self) -> bool {
        self.container.damages().is_truncated()
    }

    /// The events on the scene's topics, one by one in file order.
    ///
    /// Fails where a topic is absent or its messages cannot be read; while reading, fails where a
    /// topic carries several frames and the scene does not say which.
    pub fn source(&self, scene: &Scene) -> Result<RecordingSource, IngestError> {
        let mut notes = Vec::new();
        let (mut routes, feeds) = route::routes(&self.path, &self.container, scene, &mut notes)?;
        let survey = Survey::of(&self.container, &routes, &feeds);
        let along = scene.gravity_m_s2.normalize();
        choose_frames(&self.path, &survey, &mut routes, &mut notes)?;
        notes.extend(cameras(&survey, &routes, along));
        let report = TakeReport {
            notes,
            messages: self.container.message_count(),
            bytes: self.container.byte_count(),
            is_truncated: self.is_truncated(),
            damages: self.container.damages().clone(),
            sample_limit: sample_limit(self.container.byte_count()),
            ..TakeReport::default()
        };
        Ok(RecordingSource::new(
            self.path.clone(),
            self.container.walk(),
            routes,
            feeds,
            survey,
            report,
        ))
    }

    /// The rows of the written sketch that the recording was made of: its keyframes topic by topic,
    /// with its marks among them in order of time; `None` where it has no keyframes.
    pub fn sketch(&self, scene: &Scene) -> Result<Option<Vec<SketchRow>>, IngestError> {
        let (routes, feeds) = route::routes(&self.path, &self.container, scene, &mut Vec::new())?;
        let mut rows: Vec<(usize, Stamp, SketchRow)> = Vec::new();
        let mut walk = self.container.walk();
        while let Some(message) = walk.next_message() {
            let log_time = Stamp(i64::try_from(message.log_time).unwrap_or(i64::MAX));
            let Some(feed) = feeds.get(&message.channel_id) else {
                continue;
            };
            let failed = |source: DecodeError| IngestError::Keyframe {
                path: self.path.clone(),
                topic: routes[feed.routes[0]].topic.clone(),
                source,
            };
            match feed.format {
                RouteFormat::Poses(_) => {}
                RouteFormat::Keyframes => {
                    let keyframe = decode_keyframe(message.data).map_err(failed)?;
                    for route in feed.routes.iter().map(|route| &routes[*route]) {
                        if let Some(track) = route.track {
                            let row = SketchRow::Keyframe {
                                track,
                                flight: route.stream,
                                keyframe: keyframe.clone(),
                            };
                            rows.push((route.stream, log_time, row));
                        }
                    }
                }
                RouteFormat::Marks(format) => {
                    let mark = format.decode(message.data).map_err(failed)?.mark(log_time);
                    rows.push((0, log_time, SketchRow::Mark(mark)));
                }
            }
        }
        let is_keyframe =
            |(.., row): &(usize, Stamp, SketchRow)| matches!(row, SketchRow::Keyframe { .. });
        if !rows.iter().any(is_keyframe) {
            return Ok(None);
        }
        rows.sort_by_key(|(flight, time, _)| (*flight, *time));
        Ok(Some(rows.into_iter().map(|(.., row)| row).collect()))
    }

    /// All events on the scene's topics; fails as [`Recording::source`] does.
    pub fn take(&self, scene: &Scene) -> Result<Take, IngestError> {
        let mut source = self.source(scene)?;
        let mut events = Vec::new();
        while let Some((_, event)) = source.next()? {
            events.push(event);
        }
        Ok(Take {
            events,
            report: source.report().clone(),
        })
    }
}
