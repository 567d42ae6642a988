//! All checks of one estimate.

use super::meeting::World;
use super::{apart, balance, carried, overlap, pull, shot, touch, tumble};
use crate::motion::{Estimate, LinkIndex, Observer, Penetration, Scene, Touch, Verification};

/// Checks an estimated motion independently of its estimation.
///
/// The estimate's arcs must be finite and the scene valid; a failed estimate need not be checked.
/// Costs about as much as an estimate: some hundred distances per arc and solid.
pub fn verify(scene: &Scene, estimate: &Estimate) -> Verification {
    verify_until(scene, estimate, &mut ()).expect("nobody ends it")
}

/// The same for as long as the observer lets it; `None` where it was ended: then nothing is known.
pub fn verify_until(
    scene: &Scene,
    estimate: &Estimate,
    observer: &mut dyn Observer,
) -> Option<Verification> {
    if observer.should_stop() {
        return None;
    }
    let world = World::new(scene, estimate);
    let mut touches = touch::touches(&world);
    let deepest = overlap::deepest(&world, &mut touches, observer);
    if observer.should_stop() {
        return None;
    }
    Some(Verification {
        tolerance_m: scene.tolerance_m,
        deepest,
        touches,
        pulls: pull::pulls(&world),
        of_contacts: carried::doubts(&world)
            .into_iter()
            .chain(tumble::doubts(&world))
            .chain(apart::doubts(&world))
            .collect(),
        single_shot: shot::shoot(&world),
        balance: balance::balance(&world),
    })
}

/// The deepest overlap of two links that move apart from each other, beyond what the scene may be inaccurate: what is found
/// until the observer ends it.
///
/// The estimate's arcs must be finite and the scene valid.
pub fn deepest_between(
    scene: &Scene,
    estimate: &Estimate,
    are_apart: &dyn Fn(LinkIndex, LinkIndex) -> bool,
    observer: &mut dyn Observer,
) -> Option<Penetration> {
    overlap::deepest_between(&World::new(scene, estimate), are_apart, observer)
}

/// Every pair of solids that a motion leads into each other, deeper than the scene may be inaccurate and than expected
/// contacts explain, flight by flight where they are deepest: what is found until the observer ends it.
///
/// The estimate's arcs must be finite and the scene valid.
pub fn overlaps(
    scene: &Scene,
    estimate: &Estimate,
    observer: &mut dyn Observer,
) -> Vec<Penetration> {
    overlap::each(&World::new(scene, estimate), observer)
}

/// When flights of a motion begin to go into something, deeper than the scene may be inaccurate \[s\], in order of time.
///
/// The estimate's arcs must be finite and the scene valid.
pub fn overlaps_begin_s(scene: &Scene, estimate: &Estimate) -> Vec<f64> {
    overlap::begin_s(&World::new(scene, estimate))
}

/// The features that touch first at every collision, as in [`verify`](verify()), without the other
/// checks: for the search, which needs them of every candidate.
///
/// The estimate's arcs must be finite and the scene valid.
pub fn touches(scene: &Scene, estimate: &Estimate) -> Vec<Touch> {
    touch::touches(&World::new(scene, estimate))
}
