//! What a report is about.

use crate::motion::{
    Diagnosis, Estimate, Rest, SampleCounts, Scene, SeenPhase, Settled, Sketch, Suspect,
    Verification,
};

/// What a report is about.
#[derive(Clone, Copy)]
pub struct Reported<'a> {
    /// What it was estimated for.
    pub scene: &'a Scene,
    /// Collisions whose contacts were inferred (indices into `Scene::events`).
    pub inferred: &'a [usize],
    /// The performance.
    pub sketch: &'a Sketch,
    /// What became of its samples.
    pub counts: &'a SampleCounts,
    /// The motion.
    pub estimate: &'a Estimate,
    /// What independent checks say of it, if there were any.
    pub verification: Option<&'a Verification>,
    /// How it goes on, if it does.
    pub settled: Option<&'a Settled>,
    /// Likely mistakes in what is said of the performance.
    pub diagnoses: &'a [Diagnosis],
    /// What is seen besides flights and not said by the scene.
    pub seen: &'a [SeenPhase],
    /// What was set free because it explains a misfit, in order.
    pub freed: &'a [Suspect],
    /// How it rests, if the scene asks that.
    pub rest: Option<&'a Rest>,
}
