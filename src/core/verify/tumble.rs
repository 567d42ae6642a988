//! What contacts cannot do to a body that tumbles: give it energy, or touch it where nothing is.
//!
//! Contacts lend what they take while they are pressed, and take some of it for good. So in a tumble the energy per weight
//!
//! ```text
//! (½ m |v|² + ½ ωᵀ I ω)/(m |p|) − p·x/|p|
//! ```
//!
//! with the pull `p` of gravity and force, is never more than when it began. Somewhere in either half something is touched.

use super::balance::kinetic_j;
use super::meeting::World;
use super::moving::MovingLink;
use crate::motion::{About, ArcEstimate, Doubt, LinkIndex, Place};
use crate::physics::State;

/// Moments at which it is looked at.
const MOMENTS: usize = 128;
/// Smoothing rounds off impacts: an energy is believed to this share of what the body has, above where its centre may be lowest.
const ENERGY_SHARE: f64 = 0.1;
/// Trackers and shapes are off by this share of the body's size, beside the scene's accuracy.
const SIZE_SHARE: f64 = 0.05;

/// The doubts about all that tumbles.
pub(super) fn doubts(world: &World) -> Vec<Doubt> {
    let mut found = Vec::new();
    for (index, link) in world.links.iter_enumerated() {
        for arc in &link.arcs {
            let grip = link.grip(arc);
            if grip.is_some_and(|of| world.scene.phases[of.phase].tumbles()) {
                found.extend(driven(world, link, arc));
                found.extend(untouched(world, index, arc));
            }
        }
    }
    found
}

fn place(arc: &ArcEstimate) -> Place {
    Place::Flight {
        mechanism: arc.mechanism,
        start_s: arc.start_s,
    }
}

/// Moments of a part of an arc, from a share of it on to another \[s\].
fn moments_s(arc: &ArcEstimate, from: f64, to: f64) -> impl Iterator<Item = f64> + '_ {
    (0..=MOMENTS).map(move |at| {
        let share = from + (to - from) * at as f64 / MOMENTS as f64;
        arc.start_s + share * (arc.end_s - arc.start_s)
    })
}

/// Energy that it has more than at its beginning.
fn driven(world: &World, link: &MovingLink, arc: &ArcEstimate) -> Option<Doubt> {
    let body = &link.of_scene.body;
    let pull = body.pull_m_s2(&world.estimate.gravity_m_s2);
    let up = -pull.try_normalize(f64::MIN_POSITIVE)?;
    let height_m = |state: &State| up.dot(&state.position_m);
    let moved_m = |state: &State| kinetic_j(body, state) / (body.mass_kg() * pull.norm());
    let energy_m = |state: &State| moved_m(state) + height_m(state);
    // At an impact at its very beginning it has what it arrives with.
    let mut begins = vec![link.state(arc, arc.start_s)];
    begins.extend(
        link.ending_at(arc.start_s)
            .map(|of| link.state(of, arc.start_s)),
    );
    let begun_m = begins.iter().map(energy_m).fold(f64::MIN, f64::max);
    let states: Vec<State> = moments_s(arc, 0.0, 1.0)
        .map(|at| link.state(arc, at))
        .collect();
    let most_m = states.iter().map(energy_m).fold(f64::MIN, f64::max);
    let lowest_m = states.iter().map(height_m).fold(f64::MAX, f64::min);
    let bound_m = world.scene.tolerance_m + ENERGY_SHARE * (begun_m - lowest_m).max(0.0);
    Doubt::beyond(About::Driven, place(arc), most_m - begun_m, bound_m)
}

/// How far it is from everything, where that is more than the scene is inaccurate.
fn untouched(world: &World, index: LinkIndex, arc: &ArcEstimate) -> Option<Doubt> {
    let link = &world.links[index];
    let pairs = world.meetings();
    let pairs: Vec<_> = pairs.filter(|of| of.concerns(index, arc)).collect();
    let nearest_m = |[from, to]: [f64; 2]| {
        let each = moments_s(arc, from, to).map(|at_s| {
            let meets = pairs
                .iter()
                .filter(|of| of.from_s <= at_s && at_s <= of.to_s);
            let gaps_m = meets.map(|of| match of.least_gap_m(at_s) {
                apart_m if apart_m > link.radius_m => apart_m,
                _ => of.closest(at_s).gap_m,
            });
            gaps_m.fold(f64::INFINITY, f64::min)
        });
        each.fold(f64::INFINITY, f64::min)
    };
    let apart_m = [[0.0, 0.5], [0.5, 1.0]].map(nearest_m);
    let bound_m = world.scene.tolerance_m + SIZE_SHARE * link.radius_m;
    Doubt::beyond(
        About::Untouched,
        place(arc),
        apart_m[0].max(apart_m[1]),
        bound_m,
    )
}
