//! What [`replay`](super::replay()) does, step by step and without files: for programs that call this one.

use std::path::{Path, PathBuf};

use anyhow::Context;

use super::as_read::AsRead;
use super::deadline::Deadline;
use super::finish::{Opened, lost, opened, reported, warnings, with_recording, write_outcome};
use super::guard::Inputs;
use super::panics::guarded;
use super::provenance::provenance;
use super::refusal::Refusal;
use crate::ingest::{Recording, SCENE_NAME, Take};
use crate::motion::{Mark, Observer, PoseSample, SampleSource, Scene, TrackIndex};
use crate::pipeline::{KeptMotion, MarkProposal, Outcome, Pipeline, Preview};
use crate::report::{Provenance, Reported};
use crate::write::{DEFAULT_WORLD_FRAME, RecordingWriter};

/// A scene with its text.
#[derive(Clone, Debug)]
pub struct SceneInMemory {
    /// The scene.
    pub scene: Scene,
    /// Its text.
    pub toml: String,
    /// The file that it was read from.
    pub file: Option<PathBuf>,
}

/// A recording, the scene with which it is read, and what it has of that.
pub struct TakeInMemory {
    opened: Opened,
    take: Take,
}

/// An estimate of such a take.
#[derive(Clone, Debug)]
pub struct EstimateInMemory {
    /// The estimate, and what belongs to it.
    pub outcome: Outcome,
    /// The time after which it was ended before all was tried \[s\]; whoever ended it says it here, for the file.
    pub ended_after_s: Option<f64>,
    pipeline: Pipeline,
}

impl EstimateInMemory {
    fn new(outcome: Outcome, pipeline: Pipeline) -> Self {
        Self {
            outcome,
            ended_after_s: None,
            pipeline,
        }
    }
}

impl TakeInMemory {
    /// Reads a file as `replay` does; the scene is its own unless another one is given.
    pub fn read(path: &Path, scene: Option<&SceneInMemory>) -> anyhow::Result<Self> {
        with_recording(path, Deadline::begin(None), |of| Self::of(of, scene))
    }

    /// The same of bytes; `name` is that of the file which they would be.
    pub fn of_bytes(
        name: &Path,
        bytes: Vec<u8>,
        scene: Option<&SceneInMemory>,
    ) -> anyhow::Result<Self> {
        Self::of(Recording::from_bytes(name, bytes)?, scene)
    }

    fn of(recording: Recording, scene: Option<&SceneInMemory>) -> anyhow::Result<Self> {
        let opened = match scene {
            None => opened(recording, None, Deadline::begin(None))?,
            Some(scene) => opened_with(recording, scene),
        };
        let take = opened.recording.take(opened.scene.for_reading())?;
        Ok(Self { opened, take })
    }

    /// The bytes of the recording.
    pub fn bytes(&self) -> &[u8] {
        self.opened.recording.container().bytes()
    }

    /// The scene with which it is read.
    pub fn scene(&self) -> &Scene {
        self.opened.scene.for_reading()
    }

    /// The text of the scene.
    pub fn scene_toml(&self) -> &[u8] {
        &self.opened.scene_toml
    }

    /// Parts of the recording that could not be read, and what to know of the others.
    pub fn notes(&self) -> Vec<String> {
        [lost(&self.take.report), warnings(&self.take.report)].concat()
    }

    /// Marks that its streams show, as [`mark`](super::mark()) proposes them.
    pub fn propose(&self, count: Option<usize>) -> anyhow::Result<Vec<MarkProposal>> {
        let pipeline = self.opened.scene.pipeline(self.take.events.iter().cloned());
        guarded(|| Ok(pipeline.propose(count)?))
    }

    /// Estimates the motion; whether it is freed and diagnosed is as [`ReplayJob`](super::ReplayJob) says. A bug is an error. With it
    /// comes the motion for further questions; joined bodies, and several groups, have none.
    pub fn estimate(
        &self,
        is_free_auto: bool,
        is_diagnosing: bool,
        observer: &mut dyn Observer,
    ) -> anyhow::Result<(EstimateInMemory, Option<KeptMotion>)> {
        let pipeline = self.opened.scene.pipeline(self.take.events.iter().cloned());
        let pipeline = pipeline.with_free_auto(is_free_auto);
        let pipeline = pipeline.with_diagnoses(is_diagnosing);
        let outcome = guarded(|| {
            let outcome = pipeline.finish_kept(observer);
            outcome.map_err(|error| Refusal::new(&pipeline, error, observer).into())
        });
        let recording = || self.opened.recording.path().display().to_string();
        let (outcome, kept) = outcome.with_context(recording)?;
        Ok((EstimateInMemory::new(outcome, pipeline), kept))
    }

    /// The motion as a preview has it: without the errors of a hand, unchecked but for overlaps, in a fraction of the time. Fails
    /// where [`estimate`](Self::estimate) does, and for joined bodies.
    pub fn preview(&self, observer: &mut dyn Observer) -> anyhow::Result<EstimateInMemory> {
        let scene = self.opened.scene.for_reading();
        let pipeline = self.opened.scene.pipeline(self.take.events.iter().cloned());
        let mut preview = Preview::new(scene.clone());
        for event in &self.take.events {
            preview.push(event.clone());
        }
        let outcome = guarded(|| {
            let previewed = preview.estimate(observer)?;
            let outcome = previewed.map(|of| of.outcome.clone());
            outcome.context("joined bodies have no preview, expected an estimate")
        })?;
        Ok(EstimateInMemory::new(outcome, pipeline))
    }

    /// The estimate from one of the same recording on, whose scene has other goals ([`KeptMotion::with_goals_of`]); `None` where
    /// that leads to none, and it must be estimated anew.
    pub fn with_goals_of(
        &self,
        before: &EstimateInMemory,
        kept: &KeptMotion,
        is_told: bool,
        observer: &mut dyn Observer,
    ) -> anyhow::Result<Option<(EstimateInMemory, KeptMotion)>> {
        let scene = self.opened.scene.for_reading();
        guarded(|| {
            let taken = &before.pipeline;
            let found = kept.with_goals_of(scene, taken.scene(), taken.marks(), is_told, observer);
            Ok(found.map(|(kept, outcome)| {
                let pipeline = taken.clone().in_scene(scene.clone());
                (EstimateInMemory::new(outcome, pipeline), kept)
            }))
        })
    }

    /// The same with a scene that has other goals, and reads the recording alike.
    pub fn in_scene(&self, scene: &SceneInMemory) -> Self {
        Self {
            opened: opened_with(self.opened.recording.clone(), scene),
            take: self.take.clone(),
        }
    }

    /// From what an estimate is made, as its file says it.
    pub fn provenance(&self, of: &EstimateInMemory) -> Provenance {
        let opened = &self.opened;
        let scene_file = opened.scene_file.as_deref();
        let made_of = provenance(
            &opened.recording,
            &opened.scene_toml,
            scene_file,
            &of.pipeline,
        );
        Provenance {
            ended_after_s: of.ended_after_s,
            ..made_of
        }
    }

    /// Writes the file that `replay` writes. Fails where that is one of those which were read.
    pub fn write(&self, of: &EstimateInMemory, output: &Path) -> anyhow::Result<()> {
        let read = [self.opened.recording.path()].into_iter();
        let read = read.chain(self.opened.scene_file.as_deref());
        Inputs::of(read).keep_from(output)?;
        write_outcome(
            &self.opened,
            &of.pipeline,
            &self.take.report,
            &of.outcome,
            of.ended_after_s,
            output,
        )
    }
}

pub(super) fn opened_with(recording: Recording, scene: &SceneInMemory) -> Opened {
    Opened {
        recording,
        scene: AsRead::of(scene.scene.clone()),
        scene_toml: scene.toml.clone().into_bytes(),
        scene_file: scene.file.clone(),
        deadline: Deadline::begin(None),
    }
}

impl EstimateInMemory {
    /// What reports of it are about.
    pub fn reported(&self) -> Reported<'_> {
        reported(&self.outcome)
    }
}

impl SceneInMemory {
    /// A recording of poses, or keyframes, and marks, in which the scene travels; what is earlier comes first.
    pub fn recording(
        &self,
        name: &Path,
        poses: &[(TrackIndex, PoseSample)],
        marks: &[Mark],
    ) -> anyhow::Result<Vec<u8>> {
        let topics: Vec<String> = self
            .scene
            .tracks
            .keys()
            .map(|track| self.scene.stream_topic(track, 0))
            .collect();
        let poses = poses
            .iter()
            .map(|(track, sample)| (sample.stamp, Ok((*track, sample))));
        let marks = marks.iter().map(|mark| (mark.stamp, Err(mark)));
        let mut entries: Vec<_> = poses.chain(marks).collect();
        entries.sort_by_key(|(stamp, _)| *stamp);
        let mut writer = RecordingWriter::in_memory(name)?;
        writer.attach(SCENE_NAME, "application/toml", self.toml.as_bytes())?;
        for (stamp, entry) in entries {
            match entry {
                Ok((track, sample)) => {
                    let topic = topics[usize::from(track)].as_str();
                    let written = (sample.from == SampleSource::Keyframe)
                        .then(|| self.scene.mount(track).keyframe_of(sample));
                    match written.flatten() {
                        Some(keyframe) => writer.keyframe(topic, stamp, &keyframe)?,
                        None => writer.pose(topic, DEFAULT_WORLD_FRAME, stamp, sample)?,
                    }
                }
                Err(mark) => writer.mark(&self.scene.marks_topic, stamp, mark)?,
            }
        }
        Ok(writer.into_bytes()?)
    }
}
