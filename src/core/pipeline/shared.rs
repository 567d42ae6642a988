//! A take among others: what it says of quantities that all of them share.

use thiserror::Error;

use super::Pipeline;
use super::outcome::PipelineError;
use super::perform::Performed;
use crate::estimate::SharedMotion;
use crate::motion::{Cone, Observer, Scene, Verdict};

/// A take whose motion can be asked at values of the quantities that it shares.
#[derive(Clone, Debug)]
pub struct SharedTake {
    /// The motion.
    pub motion: SharedMotion,
    /// Whether it was found with these quantities free; otherwise at the values from which it was looked for.
    pub is_free: bool,
}

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
    ) -> Result<SharedTake, NoShare> {
        if self.scene.joint_trees().next().is_some() {
            return Err(NoShare::Joined);
        }
        let motion = |scene: &Scene, observer: &mut dyn Observer| {
            let Performed { inferred, .. } = self.solved(scene, observer)?;
            let found = inferred.solved.sharing(parameters);
            found.ok_or(NoShare::NotPhysical(inferred.solved.estimate.verdict))
        };
        let free = motion(&self.scene, observer);
        if let Ok(motion) = free {
            return Ok(SharedTake {
                motion,
                is_free: true,
            });
        }
        let mut held = self.scene.clone();
        for parameter in parameters {
            let free = &mut held.parameters[*parameter];
            (free.lower, free.upper) = (free.initial, free.initial);
        }
        let is_shared = |cone: &Cone| {
            let mut both = cone.parameters.iter();
            both.any(|of| parameters.contains(of))
        };
        held.cones.retain(|cone| !is_shared(cone));
        // What is said of the take is what was found with them free.
        let motion = motion(&held, observer).or(free)?;
        Ok(SharedTake {
            motion,
            is_free: false,
        })
    }
}
