//! Which mistake in what is said of a performance is the likely one.
//!
//! A take that has no motion, or one that is far from its samples, is tried again with
//! remedies: other axes, units, meanings of stamps, mounts, orders of quaternions, heights of
//! surfaces. Which ones is told by cheap signs ([`fall`], a body's height where it bounces). A remedy is
//! believed only if it explains: with it there is a motion against which nothing speaks, several
//! times as near to the samples as without. Where none does, nothing is said.

mod facts;
mod fall;
mod frames;
mod motion;
mod mount;
mod quaternions;
mod remedied;
mod times;
mod units;
mod world;

use self::facts::Facts;
use self::fall::fall;
use self::motion::{Motion, as_delivered, misfit};
use self::remedied::remedied;
use super::outcome::Outcome;
use crate::motion::{Diagnosis, Observer, Remedy, Scene, TakeEvent, Verdict};

/// Greatest distance from the samples in the scene's weights of a motion that is not looked into.
const FAR: f64 = 2.5;
/// Least ratio of the distances without and with a remedy.
const GAIN: f64 = 2.0;
/// Greatest distance with a remedy, in the scene's weights.
const EXPLAINED: f64 = 5.0;
/// Rounds in which a remedy's value is improved.
const ROUNDS: usize = 3;

/// Likely mistakes about a take, that which explains most first; `outcome` is what is estimated as
/// things are said.
pub(super) fn diagnose(
    scene: &Scene,
    events: &[TakeEvent],
    outcome: Option<&Outcome>,
    observer: &mut dyn Observer,
) -> Vec<Diagnosis> {
    if outcome.is_some_and(is_well) || observer.should_stop() {
        return Vec::new();
    }
    let motion = outcome
        .filter(|outcome| is_motion(outcome))
        .map(|outcome| Motion {
            scene: outcome.scene.clone(),
            sketch: outcome.sketch.clone(),
            estimate: outcome.estimate.clone(),
            is_credible: false,
        });
    let facts = Facts {
        scene,
        events,
        motion: motion.as_ref(),
        fall: fall(scene, events),
    };
    let without = motion.as_ref().map(Motion::distance);
    let mut found: Vec<(f64, Diagnosis)> = Vec::new();
    for remedy in remedies(&facts) {
        if observer.should_stop() {
            break;
        }
        let Some((remedy, with)) = best(remedy, &facts, observer) else {
            continue;
        };
        let distance = with.distance();
        let left = misfit(scene, &as_delivered(&remedy, &distance));
        let gain = without.map_or(f64::INFINITY, |without| misfit(scene, &without) / left);
        if with.is_credible && with.misfit() <= EXPLAINED && gain >= GAIN {
            found.push((
                left,
                Diagnosis {
                    remedy,
                    without,
                    with: distance,
                },
            ));
        }
    }
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    found.truncate(1);
    found.into_iter().map(|(_, diagnosis)| diagnosis).collect()
}

/// Whether nothing speaks against an outcome.
fn is_well(outcome: &Outcome) -> bool {
    let estimate = &outcome.estimate;
    let mut doubts = estimate.doubts.iter();
    let is_doubted = doubts.any(|doubt| doubt.about.best() != Verdict::Physical);
    is_motion(outcome) && !is_doubted && misfit(&outcome.scene, &motion::distance(estimate)) <= FAR
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
    [
        frames::remedies(facts),
        units::of_streams(facts),
        units::of_scenes(facts),
        times::remedies(facts),
        world::remedies(facts),
        mount::remedies(facts),
        quaternions::remedies(facts),
    ]
    .concat()
}

/// A remedy with its best value, and the motion with it.
fn best(
    mut remedy: Remedy,
    facts: &Facts,
    observer: &mut dyn Observer,
) -> Option<(Remedy, Motion)> {
    let mut best: Option<(Remedy, Motion)> = None;
    for _ in 0..ROUNDS {
        let (scene, events) = remedied(&remedy, facts.scene, facts.events)?;
        let Some(motion) = Motion::of(&scene, &events, observer) else {
            break;
        };
        if best
            .as_ref()
            .is_some_and(|(_, best)| best.misfit() <= motion.misfit())
        {
            break;
        }
        let next = refined(&remedy, &motion);
        best = Some((remedy, motion));
        let Some(next) = next else { break };
        remedy = next;
    }
    best
}

/// A remedy with a better value, by the motion with the last.
fn refined(remedy: &Remedy, motion: &Motion) -> Option<Remedy> {
    match remedy {
        Remedy::Mount { track, slip, .. } if slip.is_fitted() => Some(Remedy::Mount {
            track: *track,
            link_from_tracker: mount::fitted(motion, *track)?,
            slip: *slip,
        }),
        _ => world::refined(remedy, motion),
    }
}
