//! A take among others: what it says of quantities that all of them share.

use thiserror::Error;

use super::Pipeline;
use super::outcome::PipelineError;
use super::perform::Performed;
use crate::estimate::SharedMotion;
use crate::motion::{Cone, Observer, Scene, Verdict};

/// Why a take says nothing of what it shares.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum NoShare {
    /// It gives no motion.
    #[error(transparent)]
    NoMotion(#[from] PipelineError),
    /// Bodies are joined.
    #[error(
        "its scene joins bodies, expected bodies by themselves: what many takes share is told of these"
    )]
    Joined,
    /// A motion that obeys physics was not found.
    #[error("no physical motion: {}", .0.as_str())]
    NotPhysical(Verdict),
}

impl Pipeline {
    /// The take's motion, to be asked what it says of `parameters` of the scene (indices into its list), which are free in it.
    /// Where none is found so, they are held at their initial values.
    pub fn shared(
        &self,
        parameters: &[usize],
        observer: &mut dyn Observer,
    ) -> Result<SharedMotion, NoShare> {
        let free = self.shared_in(&self.scene, parameters, observer);
        match free {
            Err(NoShare::NotPhysical(_) | NoShare::NoMotion(_)) => {
                let held = self.shared_held(parameters, parameters, observer);
                // What is said of the take is what was found with them free.
                held.or(free)
            }
            free => free,
        }
    }

    /// The same with some of these parameters held at their initial values while the motion is found.
    pub fn shared_held(
        &self,
        parameters: &[usize],
        held: &[usize],
        observer: &mut dyn Observer,
    ) -> Result<SharedMotion, NoShare> {
        let mut scene = self.scene.clone();
        for parameter in held {
            let free = &mut scene.parameters[*parameter];
            (free.lower, free.upper) = (free.initial, free.initial);
        }
        let is_shared = |cone: &Cone| {
            let mut both = cone.parameters.iter();
            both.any(|of| held.contains(of))
        };
        scene.cones.retain(|cone| !is_shared(cone));
        self.shared_in(&scene, parameters, observer)
    }

    fn shared_in(
        &self,
        scene: &Scene,
        parameters: &[usize],
        observer: &mut dyn Observer,
    ) -> Result<SharedMotion, NoShare> {
        if scene.joint_trees().next().is_some() {
            return Err(NoShare::Joined);
        }
        let mut performed = self.solved(scene, observer)?;
        performed.judge(observer);
        let Performed { inferred, .. } = performed;
        let found = inferred.solved.sharing(parameters);
        found.ok_or(NoShare::NotPhysical(inferred.solved.estimate.verdict))
    }
}
