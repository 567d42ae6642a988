//! What of a scene of joined bodies may be suspected, and how residuals change with it.

use std::collections::BTreeSet;

use super::linear::{Linear, LinearChange};
use crate::estimate::tree::point::TreePoint;
use crate::estimate::tree::problem::TreeProblem;
use crate::motion::{ContactLawIndex, Joint, Mechanism, Quantity, Scene};
use crate::optimise::active::ActiveSet;

/// Share of a typical change by which a quantity is moved to tell how residuals change.
pub(super) const STEP: f64 = 1e-3;

/// How many times as long steps are for the derivatives.
const LONGER: f64 = 2.0;

/// Quantities that the scene keeps fixed, each by itself.
pub(super) fn candidates(scene: &Scene, problem: &TreeProblem) -> Vec<Quantity> {
    let gravity = (0..3).map(|axis| Quantity::Gravity { axis });
    let masses = scene.forest_links().map(|link| Quantity::Mass { link });
    let trees = scene.moving().filter_map(|(_, of)| match of {
        Mechanism::Tree(joined) => Some(joined),
        Mechanism::Free(_) | Mechanism::Apart(_) => None,
    });
    let joints = trees.flat_map(|joined| &joined.joints);
    let joints = joints.flat_map(Joint::quantities);
    let events = problem
        .events
        .iter()
        .map(|event| &scene.events[event.event]);
    let laws: BTreeSet<ContactLawIndex> = events
        .filter_map(|event| Some(event.kind.collision()?.law))
        .collect();
    let laws = laws
        .into_iter()
        .flat_map(|law| [Quantity::Restitution { law }, Quantity::Friction { law }]);
    let surfaces = (0..scene.surfaces.len()).map(|surface| Quantity::SurfaceHeight { surface });
    let touched = surfaces.filter(|height| scene.untold(*height).is_none());
    let tracks = scene
        .tracks
        .keys()
        .filter(|track| scene.sees_moving(*track));
    let places =
        tracks.flat_map(|track| (0..3).map(move |axis| Quantity::TrackerPosition { track, axis }));
    let world = gravity.chain(laws).chain(touched);
    let all = joints.chain(masses).chain(world).chain(places);
    all.filter(|quantity| !scene.frees(*quantity)).collect()
}

/// The derivative of residuals and rows by a quantity at a value, by central differences of the whole flow, which is one
/// smooth function of it: the number of steps stays, and long steps tell derivatives well enough. A
/// formula for each of them would be the derivative of the articulated-body algorithm by each of its constants, and of no
/// other use. `None` where a motion near by is none.
pub(super) fn change(
    scene: &Scene,
    problem: &TreeProblem,
    point: &TreePoint,
    active: &ActiveSet,
    quantity: Quantity,
    value: f64,
    step: f64,
) -> Option<LinearChange> {
    let [lower, upper] = scene.limits_of(quantity);
    let [before, after] = [-step, step].map(|by| (value + by).clamp(lower, upper));
    let rough = TreeProblem {
        step_s: LONGER * problem.step_s,
        ..problem.clone()
    };
    let at = |value: f64| {
        let with = rough.with(scene, &[(quantity, value)])?;
        Linear::without_derivatives(&with, point, active)
    };
    Some(Linear::change(&at(before)?, &at(after)?, after - before))
}
