//! Errors of reading recordings.

use std::collections::BTreeSet;
use std::io;
use std::path::PathBuf;

use thiserror::Error;

use crate::wire::{ContainerError, DecodeError};

/// Why a recording cannot be used.
#[derive(Debug, Error)]
pub enum IngestError {
    /// The file cannot be opened or read.
    #[error("{}: cannot read: {source}", path.display())]
    Read {
        /// The recording.
        path: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
    /// It is a folder, as of a bag.
    #[error(
        "{}: is a folder, expected a recording; `enact import {} -o take.mcap` puts those in it together",
        path.display(), path.display()
    )]
    Folder {
        /// The folder.
        path: PathBuf,
    },
    /// A table that holds no poses, or a cell of it that is none.
    #[error(
        "{}{}: {message}",
        path.display(), if *line > 0 { format!(":{line}") } else { String::new() }
    )]
    Table {
        /// The file.
        path: PathBuf,
        /// Line, from 1; 0 for the whole.
        line: usize,
        /// What is wrong, and what was expected.
        message: String,
    },
    /// The file is not MCAP.
    #[error("{}: {source}", path.display())]
    Container {
        /// The recording.
        path: PathBuf,
        /// The cause.
        source: ContainerError,
    },
    /// A body's topic is not in the recording.
    #[error(
        "{}: no topic {topic}, which body {body:?} of the scene wants; the recording has {}{}",
        path.display(), listed(present), expected_topic(present, offered)
    )]
    TopicAbsent {
        /// The recording.
        path: PathBuf,
        /// The body.
        body: String,
        /// What the scene says.
        topic: String,
        /// The topics that are there.
        present: BTreeSet<String>,
        /// What has poses, as scenes write it.
        offered: BTreeSet<String>,
    },
    /// Several scenes are attached, and they differ.
    #[error(
        "{}: {count} attachments are named scene.toml and are not the same, expected one; --scene FILE says which scene \
         counts, `enact import --scene FILE` puts it in their place",
        path.display()
    )]
    ManyScenes {
        /// The recording.
        path: PathBuf,
        /// How many.
        count: usize,
    },
    /// Poses on a topic are given in several frames, of which nothing says how they lie.
    #[error(
        "{}: poses on {topic} are given in {} frames ({}), and no transform says how they lie in each other: are these two \
         publishers? Name one frame in the scene, as in topic = \"{topic}@{}\", or record the transforms on /tf_static",
        path.display(), frames.len(), listed(frames), frames.first().map_or("", String::as_str)
    )]
    ManyFrames {
        /// The recording.
        path: PathBuf,
        /// The topic.
        topic: String,
        /// The frames.
        frames: BTreeSet<String>,
    },
    /// The frame that the scene names never comes on its topic.
    #[error(
        "{}: poses on {topic} are given in {}, never in frame {frame:?}",
        path.display(), listed(frames)
    )]
    FrameAbsent {
        /// The recording.
        path: PathBuf,
        /// The topic.
        topic: String,
        /// What the scene names.
        frame: String,
        /// The frames.
        frames: BTreeSet<String>,
    },
    /// A topic that is asked for is not in the recording.
    #[error(
        "{}: no topic {topic}; the recording has {}",
        path.display(), listed(present)
    )]
    NoTopic {
        /// The recording.
        path: PathBuf,
        /// What was asked for.
        topic: String,
        /// The topics that are there.
        present: BTreeSet<String>,
    },
    /// An edited sketch does not have as many segments as the scene's events require.
    #[error(
        "{}: {} segments of body {body:?}, expected {expected}, which is one more than its collisions, on {topic}/1{}; the recording has {}",
        path.display(), found.len(),
        if *.expected > 1 { format!(" to {topic}/{expected}") } else { String::new() },
        listed(found)
    )]
    SegmentCount {
        /// The recording.
        path: PathBuf,
        /// The body.
        body: String,
        /// The scene's topic of it.
        topic: String,
        /// One more than its collisions.
        expected: usize,
        /// The topics of segments that are there.
        found: BTreeSet<String>,
    },
    /// The marks topic is not in the recording, but marks are, elsewhere.
    #[error(
        "{}: no marks: topic {topic} is not in the recording, which has {}",
        path.display(), listed(present)
    )]
    MarksAbsent {
        /// The recording.
        path: PathBuf,
        /// What the scene says.
        topic: String,
        /// The topics that are there.
        present: BTreeSet<String>,
    },
    /// A topic carries messages that cannot be read.
    #[error(
        "{}: topic {topic} carries {schema} ({encoding}); supported are {supported}",
        path.display()
    )]
    Unsupported {
        /// The recording.
        path: PathBuf,
        /// The topic.
        topic: String,
        /// Name of its schema.
        schema: String,
        /// Encoding of its messages.
        encoding: String,
        /// The schemas that can be read.
        supported: &'static str,
    },
    /// A message that is no keyframe, or no mark.
    #[error("{}: topic {topic}: {source}", path.display())]
    Keyframe {
        /// The recording.
        path: PathBuf,
        /// The topic.
        topic: String,
        /// What is wrong with it.
        source: DecodeError,
    },
    /// A keyframe that the estimation cannot use.
    #[error("{}: topic {topic}: keyframe {number} {reason}", path.display())]
    KeyframeNotEstimated {
        /// The recording.
        path: PathBuf,
        /// The topic.
        topic: String,
        /// Its place among the topic's, from 1.
        number: u64,
        /// What it lacks, and what to do.
        reason: &'static str,
    },
    /// A topic carries several frames or poses and the scene does not say which.
    #[error(
        "{}: topic {topic} carries {}; name one of them in the scene, as in \"{topic}#{}\"",
        path.display(), listed(children), children.first().map_or("", String::as_str)
    )]
    Ambiguous {
        /// The recording.
        path: PathBuf,
        /// The topic.
        topic: String,
        /// Some of what it carries.
        children: BTreeSet<String>,
    },
    /// The frame or pose that the scene names never comes on its topic.
    #[error(
        "{}: topic {topic} never carries {child:?}, only {}",
        path.display(), listed(children)
    )]
    ChildAbsent {
        /// The recording.
        path: PathBuf,
        /// The topic.
        topic: String,
        /// What the scene names.
        child: String,
        /// What comes instead.
        children: BTreeSet<String>,
    },
}

/// What to write in a scene, as the end of a sentence.
fn expected_topic(present: &BTreeSet<String>, offered: &BTreeSet<String>) -> String {
    match offered.len() {
        0 if present.is_empty() => String::new(),
        0 => ", none with poses that can be read".to_owned(),
        1 => format!(
            "; expected topic = {:?} in its [[body]]",
            offered.first().map_or("", String::as_str)
        ),
        _ => format!(
            "; expected one with poses as its topic: {}",
            listed(offered)
        ),
    }
}

/// Number of names that are listed in an error: a file may have thousands.
const LISTED: usize = 50;

/// The names, as part of a sentence.
pub fn listed(names: &BTreeSet<String>) -> String {
    if names.is_empty() {
        return "none".to_owned();
    }
    let shown = names.iter().take(LISTED).map(|name| match name.as_str() {
        "" => "(unnamed)",
        name => name,
    });
    let shown = shown.collect::<Vec<_>>().join(", ");
    match names.len().saturating_sub(LISTED) {
        0 => shown,
        more => format!("{shown} and {more} more"),
    }
}
