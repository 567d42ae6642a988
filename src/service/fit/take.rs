//! A take among those of which one answer is made.

use std::path::{Path, PathBuf};

use nalgebra::DVector;

use super::block::TakeBlock;
use super::job::FitInput;
use super::names::AskedNames;
use crate::config::{SourceLine, scene_from_toml};
use crate::ingest::Take;
use crate::jointly::JointParameter;
use crate::motion::{Fits, Quantity, Scene, Stamp, TakeEvent, TakeShare};
use crate::pipeline::{Pipeline, SharedTake};
use crate::service::as_read::AsRead;
use crate::service::finish::{lost, warnings};
use crate::service::panics::guarded;
use crate::service::provenance::sha256;
use crate::service::words::words;
use crate::write::has_estimate;

/// A recording with what is asked of it.
pub(super) struct Member {
    /// Among the inputs.
    pub(super) place: usize,
    pub(super) path: PathBuf,
    /// As it was named.
    pub(super) file: String,
    /// Of its bytes; empty where it cannot be read.
    pub(super) sha256: String,
    /// What it says, or why it says nothing.
    pub(super) asked: Result<AskedTake, String>,
    /// Whether it is an output among the inputs, or the same as another: nothing is wrong with it.
    pub(super) is_left_alone: bool,
    pub(super) is_held_out: bool,
    /// Whether what is asked for means nothing in its scene.
    pub(super) is_misnamed: bool,
    /// What was lost of it, and what to know.
    pub(super) notes: Vec<String>,
}

/// A take that can be asked.
pub(super) struct AskedTake {
    /// The scene as it was read,
    pub(super) given: Scene,
    /// and with what is shared free.
    pub(super) scene: Scene,
    /// Places of these parameters in it, the shared ones first.
    pub(super) parameters: Vec<usize>,
    /// Those of them that the scene frees by itself,
    pub(super) was_free: Vec<usize>,
    /// How many are shared: the others are drawn.
    pub(super) shared: usize,
    /// What the scene says of them.
    pub(super) initial: DVector<f64>,
    /// What of the recording it is made of.
    pub(super) source: SourceLine,
    /// The text of the scene.
    pub(super) scene_toml: String,
    events: Vec<TakeEvent>,
    /// Its motion, or why it has none.
    pub(super) motion: Result<SharedTake, String>,
    /// What its scene has in its places already of the values at which that is asked.
    placed: DVector<f64>,
}

impl Member {
    /// Reads a recording. Whatever fails is said of this one alone.
    pub(super) fn read(
        place: usize,
        input: &FitInput,
        scene: Option<&Path>,
        names: &AskedNames,
    ) -> Self {
        let mut member = Self {
            place,
            path: input.name().to_owned(),
            file: input.name().display().to_string(),
            sha256: String::new(),
            asked: Err(String::new()),
            is_left_alone: false,
            is_held_out: false,
            is_misnamed: false,
            notes: Vec::new(),
        };
        let asked = guarded(|| member.asked(input, scene, names));
        member.asked = asked.map_err(|error| words(&error));
        member
    }

    fn asked(
        &mut self,
        input: &FitInput,
        scene: Option<&Path>,
        names: &AskedNames,
    ) -> anyhow::Result<AskedTake> {
        let opened = input.opened(scene)?;
        let recording = &opened.recording;
        self.sha256 = sha256(recording.container().bytes());
        if has_estimate(recording.container()) {
            self.is_left_alone = true;
            anyhow::bail!("it has an estimate already: an output among the inputs");
        }
        let take = recording.take(opened.scene.for_reading())?;
        let lost = lost(&take.report);
        let lost = lost.iter().map(|line| format!("lost: {line}"));
        self.notes = lost.chain(warnings(&take.report)).collect();
        let source = self.source(&take);
        let toml = String::from_utf8_lossy(&opened.scene_toml).into_owned();
        let given = opened.scene.for_reading().clone();
        let asked = AskedTake::new(given, toml, source, names);
        self.is_misnamed = asked.is_err();
        let mut asked = asked?;
        asked.events = take.events;
        Ok(asked)
    }

    /// What of the recording is read, for the answer's account.
    fn source(&self, take: &Take) -> SourceLine {
        let stamps = take.events.iter().filter(|event| event.mark().is_none());
        let stamps = stamps.map(TakeEvent::stamp);
        let (first, last) = (stamps.clone().min(), stamps.clone().max());
        let first = first.unwrap_or(Stamp(0));
        let topics = take.report.topics.iter();
        let named = topics.clone().filter(|topic| topic.events > 0);
        let named: Vec<&str> = named.map(|topic| topic.topic.as_str()).collect();
        SourceLine {
            file: self.file.clone(),
            sha256: Some(self.sha256.clone()),
            topic: named.join(", "),
            poses: stamps.count(),
            dropped: topics.map(|topic| topic.undecodable as usize).sum(),
            first_stamp_ns: first.0,
            from_s: 0.0,
            to_s: last.map_or(0.0, |last| last.seconds_since(first)),
        }
    }

    /// One of which what it says is known, and the recording is not here.
    pub(super) fn of_block(place: usize, block: &TakeBlock, names: &AskedNames) -> Self {
        let asked = match &block.why {
            Some(why) => Err(why.clone()),
            None => guarded(|| {
                let scene = scene_from_toml(&block.scene_toml)?;
                let given = AsRead::of(scene).for_reading().clone();
                AskedTake::new(given, block.scene_toml.clone(), block.source.clone(), names)
            })
            .map_err(|error| words(&error)),
        };
        Self {
            place,
            path: PathBuf::from(&block.source.file),
            file: block.source.file.clone(),
            sha256: block.source.sha256.clone().unwrap_or_default(),
            asked,
            is_left_alone: block.is_left_alone,
            is_held_out: false,
            is_misnamed: false,
            notes: block.notes.clone(),
        }
    }

    /// By the contents, then by the name: the order of the inputs does not matter.
    pub(super) fn order(&self) -> (&str, &Path) {
        (&self.sha256, &self.path)
    }

    /// Leaves it alone: its contents are those of another.
    pub(super) fn is_the_same_as(&mut self, other: &str) {
        self.is_left_alone = true;
        self.asked = Err(format!("the same recording as {other}"));
    }

    /// What is asked of it, unless it is held out.
    pub(super) fn fitting(&mut self) -> Option<&mut AskedTake> {
        let is_held_out = self.is_held_out;
        self.asked.as_mut().ok().filter(|_| !is_held_out)
    }
}

impl AskedTake {
    /// With what is asked for free in its scene, and no motion yet.
    pub(super) fn new(
        given: Scene,
        scene_toml: String,
        source: SourceLine,
        names: &AskedNames,
    ) -> anyhow::Result<Self> {
        let mut scene = given.clone();
        let (parameters, shared) = names.free(&mut scene)?;
        let is_free = |at: &usize| *at < given.parameters.len();
        let initial = parameters.iter().map(|at| scene.parameters[*at].initial);
        Ok(Self {
            initial: DVector::from_iterator(parameters.len(), initial),
            placed: DVector::zeros(parameters.len()),
            was_free: parameters.iter().copied().filter(is_free).collect(),
            parameters,
            shared,
            source,
            scene_toml,
            given,
            scene,
            events: Vec::new(),
            motion: Err("its motion was not looked for".to_owned()),
        })
    }

    pub(super) fn parameters(&self) -> Vec<JointParameter> {
        let all = self.parameters.iter().enumerate();
        all.map(|(at, of)| JointParameter::new(&self.scene.parameters[*of], at >= self.shared))
            .collect()
    }

    fn pipeline(&self, scene: &Scene) -> Pipeline {
        Pipeline::of(scene.clone(), self.events.iter().cloned())
    }

    /// Its motion with some of what is asked held where the scene begins.
    fn held(&self, pipeline: &Pipeline, held: &[usize]) -> anyhow::Result<SharedTake> {
        guarded(|| Ok(pipeline.shared_held(&self.parameters, held, &mut ())?))
    }

    /// Places of what is shared.
    fn shared(&self) -> &[usize] {
        &self.parameters[..self.shared]
    }

    /// Finds its motion at its own values.
    pub(super) fn find(&mut self) {
        let pipeline = self.pipeline(&self.scene);
        let found = guarded(|| Ok(pipeline.shared(&self.parameters, &mut ())?));
        self.motion = found.map_err(|error| words(&error));
    }

    /// What it says at its own values.
    pub(super) fn own(&mut self) -> Option<TakeShare> {
        let values = self.motion.as_ref().ok()?.values() + &self.placed;
        self.at(&values)
    }

    /// Its motion found with what is shared held at values that others tell, and what it says there; from where its scene begins
    /// where there are none, or it has no motion there.
    pub(super) fn begun_at(&mut self, values: Option<&DVector<f64>>) -> Option<TakeShare> {
        if let Some((scene, placed)) = values.and_then(|values| self.scene_at(values))
            && let Ok(mut motion) = self.held(&self.pipeline(&scene), self.shared())
        {
            let there = motion.values() + &placed;
            if let Some(share) = share(&mut motion, &there, &placed) {
                (self.motion, self.placed) = (Ok(motion), placed);
                return Some(share);
            }
        }
        self.find();
        self.own()
    }

    /// Its motion found from another value of one of the parameters on, with what it says at its own values then.
    pub(super) fn begun(&self, at: usize, value: f64) -> Option<(SharedTake, TakeShare)> {
        let mut scene = self.scene.clone();
        scene.parameters[self.parameters[at]].initial = value;
        let pipeline = self.pipeline(&scene);
        let found = guarded(|| Ok(pipeline.shared(&self.parameters, &mut ())?));
        let mut motion = found.ok()?;
        let values = motion.values();
        let share = share(&mut motion, &values, &self.placed)?;
        Some((motion, share))
    }

    /// What it says at values; none where it has no motion.
    pub(super) fn at(&mut self, values: &DVector<f64>) -> Option<TakeShare> {
        share(self.motion.as_mut().ok()?, values, &self.placed)
    }

    /// Finds its motion anew from other values on, with what is shared held there and with it free, and keeps that if it had
    /// none or if that is nearer to the samples with the shared values: then the values at which it is so, those of what is
    /// drawn its own.
    pub(super) fn again(&mut self, values: &DVector<f64>) -> Option<DVector<f64>> {
        let (scene, placed) = self.scene_at(values)?;
        let pipeline = self.pipeline(&scene);
        let ways = [self.shared(), &[]].into_iter().filter_map(|held| {
            let mut motion = self.held(&pipeline, held).ok()?;
            // What is drawn is its own.
            let mut there = motion.values() + &placed;
            let shared = values.rows(0, self.shared);
            there.rows_mut(0, self.shared).copy_from(&shared);
            let far = far(&share(&mut motion, &there, &placed)?);
            Some((far, (motion, there)))
        });
        let best = ways.min_by(|a, b| a.0.total_cmp(&b.0));
        let before = self.at(values).map_or(f64::INFINITY, |share| far(&share));
        let (_, (motion, there)) = best.filter(|(there, _)| *there < before - NEARER)?;
        (self.motion, self.placed) = (Ok(motion), placed);
        Some(there)
    }

    /// Whether its motion at values is said not to explain its samples. Of one that was found at other values this is judged anew,
    /// with what is shared held there.
    pub(super) fn misfits(&mut self, values: &DVector<f64>) -> bool {
        let is_said = |motion: &mut SharedTake| motion.fits(&mut ()) == Fits::No;
        if !self.motion.as_mut().is_ok_and(is_said) {
            return false;
        }
        let Some((scene, _)) = self.scene_at(values) else {
            return true;
        };
        let found = self.held(&self.pipeline(&scene), self.shared());
        found.map_or(true, |mut motion| is_said(&mut motion))
    }

    /// The scene that begins at values. Trackers are put where these say, so that samples are cleaned and cut by where the body
    /// is; what is in its place so is given, too.
    fn scene_at(&self, values: &DVector<f64>) -> Option<(Scene, DVector<f64>)> {
        let mut placed = DVector::zeros(values.len());
        let mut known = Vec::new();
        for (at, parameter) in self.parameters.iter().enumerate() {
            let quantity = self.scene.parameters[*parameter].quantity;
            if matches!(quantity, Quantity::TrackerPosition { .. }) {
                placed[at] = values[at];
                known.push((quantity, values[at]));
            }
        }
        let mut scene = self.scene.with_values(&known).ok()?;
        for (at, parameter) in self.parameters.iter().enumerate() {
            let free = &mut scene.parameters[*parameter];
            free.lower -= placed[at];
            free.upper -= placed[at];
            free.initial = (values[at] - placed[at]).max(free.lower).min(free.upper);
        }
        Some((scene, placed))
    }
}

/// A motion is nearer by so much in the logarithms of its residuals.
pub(super) const NEARER: f64 = 0.1;

/// How far a motion is from its samples: the sum of the logarithms of its residuals.
pub(super) fn far(share: &TakeShare) -> f64 {
    let residuals = share.residual.iter().zip(share.samples);
    let residuals = residuals.filter(|(_, samples)| *samples > 0);
    residuals
        .map(|(residual, _)| residual.max(1e-12).ln())
        .sum()
}

/// What a motion says at values, of which its scene has some in their places.
fn share(
    found: &mut SharedTake,
    values: &DVector<f64>,
    placed: &DVector<f64>,
) -> Option<TakeShare> {
    let there = values - placed;
    let share = guarded(|| Ok(found.at(&there, &mut ()))).ok()??;
    Some(TakeShare {
        values: values.clone(),
        ..share
    })
}

/// A take is far whose residual is so many times that of the nearest quarter.
const FARTHER: f64 = 2.0;

/// The residuals of the nearest quarter of takes: positions and orientations.
pub(super) struct UsualResidual([f64; 2]);

impl UsualResidual {
    pub(super) fn of(shares: &[Option<TakeShare>]) -> Self {
        Self([0, 1].map(|kind| {
            let residuals = shares.iter().flatten().map(|of| of.residual[kind]);
            let mut residuals: Vec<f64> = residuals.collect();
            residuals.sort_by(f64::total_cmp);
            residuals.get(residuals.len() / 4).copied().unwrap_or(0.0)
        }))
    }

    /// Whether a take is so much farther from its motion that it may be near another optimum.
    pub(super) fn is_far(&self, share: &TakeShare) -> bool {
        let mut kinds = share.residual.iter().zip(self.0);
        kinds.any(|(residual, usual)| *residual > FARTHER * usual)
    }
}
