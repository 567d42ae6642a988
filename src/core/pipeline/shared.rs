//! A take among others: what it says of quantities that all of them share.

use thiserror::Error;

use super::outcome::PipelineError;
use super::perform::{Performed, Prepared};
use crate::estimate::SharedMotion;
use crate::motion::{Cone, Observer, Scene, TakeEvent, Verdict};

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

/// The motion of a take in a scene, to be asked what it says of `parameters` of the scene.
pub(super) fn shared(
    scene: &Scene,
    events: &[TakeEvent],
    parameters: &[usize],
    observer: &mut dyn Observer,
) -> Result<SharedMotion, NoShare> {
    if scene.joint_trees().next().is_some() {
        return Err(NoShare::Joined);
    }
    let mut performed = Prepared::new(scene, events, observer)?.performed(observer)?;
    performed.judge(observer);
    let Performed { inferred, .. } = performed;
    let found = inferred.solved.sharing(parameters);
    found.ok_or(NoShare::NotPhysical(inferred.solved.estimate.verdict))
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
