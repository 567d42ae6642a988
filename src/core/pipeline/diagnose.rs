//! Which mistake in what is said of a performance is the likely one.
//!
//! A take that has no motion, or one that is far from its samples, is tried again with
//! remedies: other axes, units, meanings of stamps, mounts, orders of quaternions, heights of
//! surfaces. Which ones is told by cheap signs ([`fall`], a body's height where it bounces). A remedy is
//! believed only if it explains: with it there is a motion against which nothing speaks, several
//! times as near to the samples as without. Where none does, nothing is said.

mod budget;
mod facts;
mod fall;
mod frames;
mod missed;
pub(super) mod motion;
mod mount;
mod quaternions;
mod remedied;
mod times;
mod turned;
mod units;
mod world;

use nalgebra::Vector3;

use self::budget::Budget;
use self::facts::Facts;
use self::fall::falls;
use self::motion::{TriedMotion, as_delivered, flights_by_stamps, misfit};
use self::remedied::remedied;
use super::outcome::Outcome;
use crate::motion::{
    About, Diagnosis, Fits, Observer, Phase, Quantity, Remedy, Scene, TakeEvent, Timing, Verdict,
};
use crate::physics::contact;

/// Greatest distance from the samples in the scene's weights of a motion that is not looked into: a hand
/// leaves 1.5 usually, and 3.2 where it strays twice as far.
const NEAR: f64 = 2.5;
/// The same, up to which nothing but a tracker's mount is looked into where nothing speaks against the
/// motion: other mistakes leave more.
const FAR: f64 = 3.5;
/// Least ratio of the distances without and with a remedy.
const GAIN: f64 = 2.0;
/// The same that a remedy must leave at least: one that leaves less of next to nothing explains nothing.
const LEAST: f64 = 0.01;
/// Greatest distance with a remedy, in the scene's weights.
const EXPLAINED: f64 = 5.0;
/// Remedies whose distances differ by less than this ratio explain alike; the simplest of them is said.
const ALIKE: f64 = 1.25;
/// A motion this many times as far as its flights one by one leaves nothing to explain.
const ALL: f64 = 1.3;
/// Least and greatest step of a remedy's value \[m\].
const LEAST_STEP_M: f64 = 1e-3;
const FARTHEST_M: f64 = 0.3;
/// How much farther from its samples a motion may be at first where a turn is known roughly.
const ABOUT: f64 = 3.0;
/// Rounds in which a mount is fitted again.
const ROUNDS: usize = 3;

/// Likely mistakes about a take, that which explains most first; `outcome` is what is estimated as
/// things are said, and took so much work.
pub(super) fn diagnose(
    scene: &Scene,
    events: &[TakeEvent],
    outcome: Option<&Outcome>,
    work: usize,
    observer: &mut dyn Observer,
) -> Vec<Diagnosis> {
    // Bodies that part a little where they stay together are near all the same.
    let is_near_all = outcome.is_some_and(|outcome| is_well(outcome, NEAR));
    let is_apart = outcome.is_some_and(|outcome| outcome.estimate.fits() == Fits::No)
        && stuck_together(scene).next().is_some();
    let is_settled = outcome.is_some_and(is_explained) || is_near_all && !is_apart;
    if is_settled || observer.should_stop() {
        return Vec::new();
    }
    observer.phase(Phase::Diagnose);
    let mut budget = Budget::beside(work, scene, events, observer);
    let motion = outcome
        .filter(|outcome| is_motion(outcome))
        .map(|outcome| TriedMotion {
            scene: outcome.scene.clone(),
            sketch: outcome.sketch.clone(),
            estimate: outcome.estimate.clone(),
            is_credible: false,
            alone: 0.0,
        });
    // Remedies are tried with samples that count one by one, and so is what they are compared with.
    let one_by_one = outcome
        .filter(|outcome| is_of_hand(outcome))
        .and_then(|_| TriedMotion::of(scene, events, f64::INFINITY, &mut budget));
    let is_near = |motion: &TriedMotion| motion.misfit() <= NEAR;
    let fits = outcome.is_some_and(|outcome| outcome.estimate.fits() == Fits::Yes);
    if fits && one_by_one.as_ref().is_some_and(is_near) {
        return Vec::new();
    }
    let motion = one_by_one.or(motion);
    let seen = flights_by_stamps(scene, events, &mut budget);
    let flights = match (&motion, scene.timing) {
        (_, Timing::Known | Timing::Edited) => seen.clone(),
        (Some(motion), Timing::Unknown { .. }) => motion.flights(),
        (None, Timing::Unknown { .. }) => Vec::new(),
    };
    let facts = Facts {
        scene,
        events,
        falls: falls(scene, events),
        flights,
        seen,
    };
    let without = motion.as_ref().map(TriedMotion::distance);
    let most = without.map_or(f64::INFINITY, |without| misfit(scene, &without) / GAIN);
    if most < LEAST {
        return Vec::new();
    }
    let mut found: Vec<(f64, Diagnosis)> = Vec::new();
    let remedies = if is_near_all {
        stuck_together(scene).collect()
    } else if outcome.is_some_and(|outcome| is_well(outcome, FAR)) {
        let turned = mount::turned(&facts);
        let mounts = mount::remedies(&facts).into_iter().chain(turned);
        stuck_together(scene).chain(mounts).collect()
    } else {
        remedies(&facts)
    };
    for remedy in remedies {
        if budget.is_over() {
            break;
        }
        // A contact that lasts looks like a surface that is lower: which it is the data do not tell.
        if matches!(remedy, Remedy::Surface { .. } | Remedy::Origin { .. }) && may_last(outcome) {
            continue;
        }
        let Some((remedy, with)) = best(remedy, &facts, most, &mut budget) else {
            continue;
        };
        let distance = with.distance();
        let left = misfit(scene, &as_delivered(&remedy, &distance));
        if !(with.is_credible && with.misfit() <= EXPLAINED && left <= most) {
            continue;
        }
        let explains_all = with.misfit() <= ALL * with.alone;
        found.push((
            left,
            Diagnosis {
                remedy,
                source: facts.source(),
                without,
                with: distance,
            },
        ));
        if explains_all {
            break;
        }
    }
    likeliest(found)
}

/// Of remedies with what they leave the one that leaves least, or another that leaves hardly more and has fewer numbers
/// that were fitted to the performance.
fn likeliest(mut found: Vec<(f64, Diagnosis)>) -> Vec<Diagnosis> {
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    let most = ALIKE * found.first().map_or(0.0, |(left, _)| *left);
    let alike = found.into_iter().take_while(|(left, _)| *left <= most);
    let diagnoses = alike.map(|(_, diagnosis)| diagnosis);
    diagnoses
        .min_by_key(|diagnosis| diagnosis.remedy.fitted())
        .into_iter()
        .collect()
}

/// Whether a contact that lasts is suspected.
fn may_last(outcome: Option<&Outcome>) -> bool {
    let mut suspects = outcome.iter().flat_map(|of| &of.estimate.suspects);
    suspects.any(|of| matches!(of.quantity(), Some(Quantity::ContactDuration { .. })))
}

/// Whether a motion is near its samples and leaves nothing of them to explain, whatever else is doubted.
fn is_explained(outcome: &Outcome) -> bool {
    is_near(outcome, NEAR) && outcome.estimate.fits() == Fits::Yes
}

/// Whether nothing speaks against an outcome, and its motion is not too far from the samples, in the scene's
/// weights.
fn is_well(outcome: &Outcome, farthest: f64) -> bool {
    let mut doubts = outcome.estimate.doubts.iter();
    // Of other motions that are as near no mistake is to blame.
    let is_doubted =
        doubts.any(|doubt| doubt.about != About::Rivals && doubt.about.best() != Verdict::Physical);
    !is_doubted && is_near(outcome, farthest)
}

/// Whether there is a motion, at most so far from its samples, in the scene's weights.
fn is_near(outcome: &Outcome, farthest: f64) -> bool {
    let distance = motion::distance(&outcome.estimate);
    is_motion(outcome) && misfit(&outcome.scene, &distance) <= farthest
}

/// Whether an outcome's motion was found with the errors of a hand, from which it is farther than one that follows it.
fn is_of_hand(outcome: &Outcome) -> bool {
    let fit = outcome.estimate.fit.as_ref();
    is_motion(outcome) && fit.is_ok_and(|fit| fit.is_of_hand)
}

/// Whether an outcome's gaps are closed.
fn is_motion(outcome: &Outcome) -> bool {
    let estimate = &outcome.estimate;
    let is_absurd = estimate
        .doubts
        .iter()
        .any(|doubt| doubt.about.best() == Verdict::Failed);
    estimate.verdict != Verdict::Failed || is_absurd
}

/// All remedies whose signs are there.
fn remedies(facts: &Facts) -> Vec<Remedy> {
    let mut remedies = Vec::new();
    for fall in &facts.falls {
        remedies.extend(frames::remedies(facts, fall));
        remedies.extend(units::of_streams(facts, fall));
        remedies.extend(times::remedies(facts, fall));
    }
    remedies.extend(units::of_scenes(facts));
    remedies.extend(missed::remedies(facts));
    remedies.extend(stuck_together(facts.scene));
    remedies.extend(world::remedies(facts));
    remedies.extend(quaternions::remedies(facts));
    remedies.extend(mount::remedies(facts));
    remedies.extend(mount::turned(facts));
    let all = remedies.iter().enumerate();
    let first = all.filter(|(index, remedy)| !remedies[..*index].contains(remedy));
    first.map(|(_, remedy)| remedy.clone()).collect()
}

/// Collisions of two bodies that may stick together.
fn stuck_together(scene: &Scene) -> impl Iterator<Item = Remedy> {
    (0..scene.events.len()).filter_map(|event| {
        let [link, other] = scene.links_at(event).try_into().ok()?;
        scene.with_stuck(event)?;
        Some(Remedy::StuckTogether {
            event,
            links: [link, other],
        })
    })
}

/// A remedy with its best value, and the motion with it.
fn best(
    remedy: Remedy,
    facts: &Facts,
    most: f64,
    budget: &mut Budget,
) -> Option<(Remedy, TriedMotion)> {
    let farthest = match remedy {
        // Lengths in another unit are compared as they came.
        Remedy::PositionUnit(_) => EXPLAINED,
        // A turn that is known roughly comes nearer as it is fitted.
        Remedy::Mount { slip, .. } if slip.is_turned() => ABOUT * EXPLAINED,
        _ => most.min(EXPLAINED),
    };
    let mut tried = |remedy: Remedy| {
        let (scene, events) = remedied(&remedy, facts.scene, facts.events)?;
        let motion = TriedMotion::of(&scene, &events, farthest, budget)?;
        Some((remedy, motion))
    };
    let mut best = tried(remedy)?;
    for _ in 0..ROUNDS {
        let Some(next) = fitted(&best).and_then(&mut tried) else {
            break;
        };
        if next.1.misfit() >= best.1.misfit() {
            break;
        }
        best = next;
    }
    for along in directions(&best) {
        // The square of the misfit is a parabola about its least.
        let step_m = best.1.distance().position_m.max(LEAST_STEP_M);
        let moved = |by_m: f64| best.0.moved(&(along * by_m));
        let sides = [-step_m, step_m].map(|by_m| moved(by_m).and_then(&mut tried));
        let [Some(low), Some(high)] = &sides else {
            continue;
        };
        let [low, middle, high] = [&low.1, &best.1, &high.1].map(|motion| motion.misfit().powi(2));
        let by_m = 0.5 * step_m * (low - high) / (low + high - 2.0 * middle);
        if !(by_m.abs() < FARTHEST_M && low + high > 2.0 * middle) {
            continue;
        }
        let next = moved(by_m).and_then(&mut tried);
        best = sides
            .into_iter()
            .chain([next])
            .flatten()
            .fold(best, |best, next| {
                if next.1.misfit() < best.1.misfit() {
                    next
                } else {
                    best
                }
            });
    }
    Some(best)
}

/// A mount fitted again, at the times of the last motion.
fn fitted((remedy, motion): &(Remedy, TriedMotion)) -> Option<Remedy> {
    let Remedy::Mount { track, slip, .. } = remedy else {
        return None;
    };
    let mut scene = motion.scene.clone();
    if slip.is_turned() {
        scene.tracks[*track].link_from_tracker = mount::aligned(motion, *track)?;
    }
    let offset = slip
        .is_fitted()
        .then(|| mount::fitted(&scene, &motion.flights(), *track));
    let link_from_tracker = match offset.flatten() {
        Some(pose) => pose,
        None if slip.is_turned() => scene.tracks[*track].link_from_tracker,
        None => return None,
    };
    Some(Remedy::Mount {
        track: *track,
        link_from_tracker,
        slip: *slip,
    })
}

/// Directions in which a remedy's value is still to be found: what impacts show and flights do not.
fn directions((remedy, motion): &(Remedy, TriedMotion)) -> Vec<Vector3<f64>> {
    match remedy {
        Remedy::Surface { surface, .. } => match motion.scene.surfaces[*surface].geometry {
            contact::Feature::Face { normal, .. } => vec![normal],
            _ => Vec::new(),
        },
        Remedy::Origin { higher_m } => higher_m.try_normalize(0.0).into_iter().collect(),
        Remedy::Mount { track, slip, .. } if slip.is_fitted() && !slip.is_turned() => {
            mount::unseen(&motion.scene, &motion.flights(), *track)
        }
        _ => Vec::new(),
    }
}
