//! A take among others: what it says of quantities that all of them share.

use nalgebra::DVector;
use thiserror::Error;

use super::joined;
use super::outcome::PipelineError;
use super::perform::{Performed, Prepared};
use crate::estimate::tree::HeldTrees;
use crate::estimate::{HeldBodies, SharedMotion};
use crate::motion::{Cone, Fits, Observer, Scene, TakeEvent, TakeShare, Verdict};

/// Why a take says nothing of what it shares.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum NoShare {
    /// It gives no motion.
    #[error(transparent)]
    NoMotion(#[from] PipelineError),
    /// Bodies are joined, and others move apart from them.
    #[error(
        "its scene has joined bodies and others that move apart from them, expected one or the other: what many takes share is \
         told of what moves together"
    )]
    Apart,
    /// A motion that obeys physics was not found.
    #[error("no physical motion: {}", .0.as_str())]
    NotPhysical(Verdict),
}

/// A take among others.
#[derive(Clone)]
pub struct SharedTake {
    motion: MechanismMotion,
    fits: MotionFits,
}

/// Its motion, to be asked.
#[derive(Clone)]
enum MechanismMotion {
    Bodies(Box<SharedMotion<HeldBodies>>),
    Trees(Box<SharedMotion<HeldTrees>>),
}

/// Whether the motion as it was found explains its samples.
#[derive(Clone)]
enum MotionFits {
    Known(Fits),
    /// Nobody has asked: the motion of which it is to be told.
    Unasked(Box<Performed>),
}

impl SharedTake {
    /// The motion of a take in a scene, to be asked what it says of `parameters` of the scene.
    pub(super) fn new(
        scene: &Scene,
        events: &[TakeEvent],
        parameters: &[usize],
        observer: &mut dyn Observer,
    ) -> Result<Self, NoShare> {
        if scene.joint_trees().next().is_some() {
            return Self::joined(scene, events, parameters, observer);
        }
        let performed = Prepared::new(scene, events, observer)?.performed(observer)?;
        let solved = &performed.inferred.solved;
        let motion = solved.sharing(parameters);
        let motion = motion.ok_or(NoShare::NotPhysical(solved.estimate.verdict))?;
        Ok(Self {
            motion: MechanismMotion::Bodies(Box::new(motion)),
            fits: MotionFits::Unasked(Box::new(performed)),
        })
    }

    fn joined(
        scene: &Scene,
        events: &[TakeEvent],
        parameters: &[usize],
        observer: &mut dyn Observer,
    ) -> Result<Self, NoShare> {
        if scene.groups().len() > 1 {
            return Err(NoShare::Apart);
        }
        let found = joined::found(scene, events, observer)?;
        let (estimate, motion) = (found.estimate(), found.solved().sharing(parameters));
        let motion = motion.ok_or(NoShare::NotPhysical(estimate.verdict))?;
        Ok(Self {
            motion: MechanismMotion::Trees(Box::new(motion)),
            fits: MotionFits::Known(estimate.fits()),
        })
    }

    /// The values at which it is.
    pub fn values(&self) -> DVector<f64> {
        match &self.motion {
            MechanismMotion::Bodies(motion) => motion.values(),
            MechanismMotion::Trees(motion) => motion.values(),
        }
    }

    /// What it says at other values; `None` where it has no motion there. It stays where it was then.
    pub fn at(&mut self, values: &DVector<f64>, observer: &mut dyn Observer) -> Option<TakeShare> {
        match &mut self.motion {
            MechanismMotion::Bodies(motion) => motion.at(values, observer),
            MechanismMotion::Trees(motion) => motion.at(values, observer),
        }
    }

    /// Whether the motion as it was found explains its samples; of bodies by themselves this is told when it is first asked.
    pub fn fits(&mut self, observer: &mut dyn Observer) -> Fits {
        if let MotionFits::Unasked(performed) = &mut self.fits {
            let (solved, performance) = performed.parts();
            self.fits = MotionFits::Known(solved.fits(performance, observer));
        }
        match self.fits {
            MotionFits::Known(fits) => fits,
            MotionFits::Unasked(_) => unreachable!("it was asked just now"),
        }
    }
}

/// The scene with parameters held at their initial values.
pub(super) fn held(scene: &Scene, parameters: &[usize]) -> Scene {
    let mut scene = scene.clone();
    for parameter in parameters {
        let free = &mut scene.parameters[*parameter];
        (free.lower, free.upper) = (free.initial, free.initial);
    }
    let is_held = |cone: &Cone| {
        let mut both = cone.parameters.iter();
        both.any(|of| parameters.contains(of))
    };
    scene.cones.retain(|cone| !is_held(cone));
    scene
}
