//! Nonsense and sense: takes whose model is wrong in a known way, the same takes with the right one,
//! and real recordings of what is no free flight.
//!
//! [`faults`] makes the first two from `tools/perform`, [`real`] reads the last; [`slips`] are mistakes in what is
//! said of a performance that the program should name; a [`racket`] is held all the time.

pub mod faults;
pub mod racket;
pub mod real;
pub mod slips;
pub mod thrown;
pub mod wrong;

use std::path::Path;

use enact::motion::{Diagnosis, Scene, TakeEvent};
use enact::pipeline::{Outcome, Pipeline, PipelineError};
use enact::write::{RecordingWriter, WriteError};

use crate::perform::recording::write_events;

/// A scene and what is taken for a performance of it.
#[derive(Clone)]
pub struct Asked {
    /// What is said of it.
    pub scene: Scene,
    /// What came.
    pub events: Vec<TakeEvent>,
}

impl Asked {
    /// What the program makes of it, with all checks.
    pub fn answered(&self) -> Result<Outcome, PipelineError> {
        self.pipeline().finish(&mut ())
    }

    /// What it says of the take where it has no answer.
    pub fn diagnosed(&self) -> Vec<Diagnosis> {
        self.pipeline().diagnose(&mut ())
    }

    /// The same with what explains a misfit set free.
    pub fn freed(&self) -> Result<Outcome, PipelineError> {
        self.pipeline().with_free_auto(true).finish(&mut ())
    }

    /// Writes it as a recording with that scene file; what comes arrives at once.
    pub fn write(&self, scene_toml: &str, path: &Path) -> Result<(), WriteError> {
        let mut writer = RecordingWriter::create(path)?;
        writer.attach("scene.toml", "application/toml", scene_toml.as_bytes())?;
        let events = self.events.iter().map(|event| match event {
            TakeEvent::Pose { sample, .. } => (event, sample.stamp),
            TakeEvent::Mark(mark) => (event, mark.stamp),
        });
        write_events(&mut writer, &self.scene, events)?;
        writer.finish()
    }

    fn pipeline(&self) -> Pipeline {
        Pipeline::of(self.scene.clone(), self.events.clone())
    }
}

/// A kind of take.
pub struct Row {
    /// Unique.
    pub name: String,
    /// Whether the model is right, so that a doubt is a false alarm.
    pub is_right: bool,
    /// The take of a seed, or why there is none.
    pub make: Make,
}

/// From a seed.
pub type Make = Box<dyn Fn(u64) -> Result<Asked, String> + Send + Sync>;
