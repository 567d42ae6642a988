//! Stages 2 to 4b as one pure state machine: event in, estimate out.
//!
//! A driver pushes what its source delivers, in whatever order that is, and calls
//! [`Pipeline::finish`] when the take is over. The result depends on the events alone; clocks,
//! files and threads are the driver's. The same take gives the same [`Outcome`] bit for bit.

use thiserror::Error;

use crate::motion::{
    ArcEstimate, Counters, Estimate, EventEstimate, Gap, Observer, ParameterEstimate, Phase,
    SampleCounts, SampleTime, Scene, Segment, SegmentResidual, Sketch, TakeEvent, Verdict,
};
use crate::physics::State;
use crate::segment::{self, SegmentError};

/// One take of one scene on its way to an estimate.
#[derive(Clone, Debug)]
pub struct Pipeline {
    scene: Scene,
    events: Vec<TakeEvent>,
}

/// What a take became.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// The performance as it was estimated from.
    pub sketch: Sketch,
    /// What became of its samples.
    pub counts: SampleCounts,
    /// The physical motion, whatever its verdict.
    pub estimate: Estimate,
}

/// Why a take has no estimate at all.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum PipelineError {
    /// It makes no sketch of the scene.
    #[error(transparent)]
    Segment(#[from] SegmentError),
}

impl Pipeline {
    /// Begins a take of that scene.
    pub fn new(scene: Scene) -> Self {
        Self {
            scene,
            events: Vec::new(),
        }
    }

    /// The scene it was begun with.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Takes in what the source delivered; in any order.
    pub fn push(&mut self, event: TakeEvent) {
        self.events.push(event);
    }

    /// The estimate from all that was pushed. A motion that is not physical is an outcome with
    /// that verdict; an error means that there is nothing to estimate from.
    pub fn finish(&self, observer: &mut dyn Observer) -> Result<Outcome, PipelineError> {
        observer.phase(Phase::Clean);
        let (sketch, counts) = segment::clean::clean(&self.scene, &self.events)?;
        let segments = segment::cut(&self.scene, &sketch)?;
        let estimate = solve(&self.scene, &sketch, &segments, observer);
        observer.phase(Phase::Done);
        Ok(Outcome {
            sketch,
            counts,
            estimate,
        })
    }
}

/// The one place where the solving stages are wired in. Until they are, every body hangs in
/// its first pose and the verdict says so.
fn solve(
    scene: &Scene,
    sketch: &Sketch,
    segments: &[Segment],
    observer: &mut dyn Observer,
) -> Estimate {
    observer.phase(Phase::ArcFits);
    let hanging = |body: usize| {
        let samples = &sketch.bodies[body].samples;
        let (first, last) = (&samples[0], &samples[samples.len() - 1]);
        ArcEstimate {
            body,
            epoch_s: first.acted_s,
            state: State {
                position_m: first.position_m,
                orientation: first.orientation,
                velocity_m_s: nalgebra::Vector3::zeros(),
                angular_velocity_rad_s: nalgebra::Vector3::zeros(),
            },
            start_s: first.acted_s,
            end_s: last.acted_s,
        }
    };
    let bodies = 0..scene.bodies.len();
    Estimate {
        verdict: Verdict::Failed,
        reason: "no solving stage is wired in".into(),
        objective: segments.iter().map(|s| s.samples.len()).sum::<usize>() as f64,
        gravity_m_s2: scene.gravity_m_s2,
        arcs: bodies.clone().map(hanging).collect(),
        events: sketch
            .marks_s
            .iter()
            .enumerate()
            .map(|(event, mark_s)| EventEstimate {
                event,
                time_s: *mark_s,
                sd_s: None,
                acted_s: *mark_s,
                gap: Gap::default(),
            })
            .collect(),
        parameters: scene
            .parameters
            .iter()
            .map(|free| ParameterEstimate {
                name: free.name.clone(),
                value: free.initial,
                sd: None,
                lower: free.lower,
                upper: free.upper,
            })
            .collect(),
        residuals: bodies
            .clone()
            .map(|body| SegmentResidual {
                body,
                samples: sketch.bodies[body].samples.len(),
                position_rms_m: 0.0,
                orientation_rms_rad: 0.0,
            })
            .collect(),
        sample_times: bodies
            .flat_map(|body| {
                sketch.bodies[body].samples.iter().map(move |s| SampleTime {
                    body,
                    stamp: s.stamp,
                    time_s: s.acted_s,
                })
            })
            .collect(),
        undetermined: scene.parameters.iter().map(|p| p.name.clone()).collect(),
        counters: Counters::default(),
    }
}
