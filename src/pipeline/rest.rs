//! Goals at rest: a motion whose continuation comes to rest as the scene asks.
//!
//! Where the motion that fits best does not, labels that are free are turned ([`labels`]); else the
//! nearest motion that does is searched for ([`search`]).

mod labels;
mod search;

use nalgebra::UnitQuaternion;

use self::labels::{relabelled, turns};
use self::search::search;
use super::perform::{Performed, Prepared};
use crate::motion::{
    Lie, Observer, Phase, Quiet, RestGoal, RestWork, Scene, Settled, TakeEvent, Verdict,
};
use crate::settle::settle_until;
use crate::verify::{is_met, lies};

/// What was done for the goals at rest.
pub(super) struct Sought {
    pub(super) work: RestWork,
    /// See [`Rest::labels`](crate::motion::Rest::labels).
    pub(super) labels: Vec<Option<UnitQuaternion<f64>>>,
}

/// Replaces the motion by one that comes to rest as the scene asks, where its own does not and
/// another is found; `None` where nothing is asked, or where there is no motion.
pub(super) fn seek(
    take: &mut Performed,
    events: &[TakeEvent],
    observer: &mut dyn Observer,
) -> Option<Sought> {
    let scene = &take.inferred.scene;
    let limit_s = scene.settle_s.filter(|_| !scene.rest_goals.is_empty())?;
    let estimate = &take.inferred.solved.estimate;
    if estimate.verdict == Verdict::Failed {
        return None;
    }
    observer.phase(Phase::Rest);
    let mut sought = Sought {
        work: RestWork {
            continuations: 1,
            motions: 0,
            best_objective: estimate.objective,
        },
        labels: vec![None; scene.rest_goals.len()],
    };
    let settled = settle_until(&scene.as_estimated(estimate), estimate, limit_s, observer);
    if settled
        .as_ref()
        .is_some_and(|settled| is_met(scene, settled))
    {
        return Some(sought);
    }
    for choice in choices(scene, settled.as_ref()?) {
        if observer.should_stop() {
            break;
        }
        let again = turned(scene, &choice)
            .and_then(|scene| Prepared::new(&scene, events, &mut Quiet(observer)).ok())
            .and_then(|prepared| prepared.performed(&mut Quiet(observer)).ok());
        let Some(again) = again else { continue };
        let (scene, estimate) = (&again.inferred.scene, &again.inferred.solved.estimate);
        sought.work.motions += 1;
        sought.work.continuations += 1;
        let settled = settle_until(&scene.as_estimated(estimate), estimate, limit_s, observer);
        if settled
            .as_ref()
            .is_some_and(|settled| is_met(scene, settled))
        {
            sought.labels = choice;
            *take = again;
            return Some(sought);
        }
    }
    if let Some(found) = search(take, limit_s, &mut sought.work, &mut Quiet(observer)) {
        take.inferred.solved = found;
    }
    Some(sought)
}

/// Turns of the labels, goal by goal, with which the motion would end right: none where a goal is
/// missed whose labels are not free.
fn choices(scene: &Scene, settled: &Settled) -> Vec<Vec<Option<UnitQuaternion<f64>>>> {
    let lies = lies(scene, settled);
    let goals = scene.rest_goals.iter().zip(&lies);
    let of_goal = |(goal, lie): (&RestGoal, &Lie)| {
        if lie.is_met() {
            return vec![None];
        }
        let last = settled.links[goal.link].poses.last();
        let shows = |turn: &UnitQuaternion<f64>| {
            last.is_some_and(|last| {
                let axis = last.rotation * (turn * goal.axis);
                axis.angle(&goal.direction) <= goal.within_rad
            })
        };
        let link = &scene.links[goal.link];
        let free = if goal.labels_are_free {
            turns(link)
        } else {
            Vec::new()
        };
        free.into_iter().filter(shows).map(Some).collect()
    };
    let each: Vec<Vec<Option<UnitQuaternion<f64>>>> = goals.map(of_goal).collect();
    let most = each.iter().map(Vec::len).max().unwrap_or(0);
    if each.iter().any(Vec::is_empty) {
        return Vec::new();
    }
    let choice = |at: usize| each.iter().map(|turns| turns[at % turns.len()]).collect();
    (0..most).map(choice).collect()
}

/// The scene with its labels turned so.
fn turned(scene: &Scene, turns: &[Option<UnitQuaternion<f64>>]) -> Option<Scene> {
    let mut turned = scene.clone();
    for (goal, turn) in scene.rest_goals.iter().zip(turns) {
        if let Some(turn) = turn {
            turned = relabelled(&turned, goal.link, turn)?;
        }
    }
    Some(turned)
}
