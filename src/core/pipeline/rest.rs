//! Goals at rest: a motion whose continuation comes to rest as the scene asks.
//!
//! Where the motion that fits best does not, labels that are free are turned ([`labels`]); else the
//! nearest motion that does is searched for ([`search`]). Where none is found, or one that is doubted, labels that are not
//! free are turned too, and that is offered.

mod labels;
mod search;

use nalgebra::UnitQuaternion;

use self::labels::{relabelled, turns};
use self::search::search;
use super::perform::{Performed, Prepared};
use crate::motion::{
    Diagnosis, Distance, Lie, Observer, Phase, Quiet, Remedy, RestGoal, RestWork, SampleSource,
    Scene, Settled, TakeEvent, Verdict,
};
use crate::settle::settle_until;
use crate::verify::{is_met, lies};

/// Turns of labels goal by goal; `None` where they stay as acted.
type Turns = Vec<Option<UnitQuaternion<f64>>>;

/// What was done for the goals at rest.
pub(super) struct Sought {
    pub(super) work: RestWork,
    /// See [`Rest::labels`](crate::motion::Rest::labels).
    pub(super) labels: Vec<Option<UnitQuaternion<f64>>>,
    /// Goals whose labels, were they free, would let it end right.
    pub(super) offered: Vec<Diagnosis>,
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
        offered: Vec::new(),
    };
    let settled = settle_until(&scene.as_estimated(estimate), estimate, limit_s, observer);
    if settled
        .as_ref()
        .is_some_and(|settled| is_met(scene, settled))
    {
        return Some(sought);
    }
    let settled = settled?;
    let (scene, work) = (scene.clone(), &mut sought.work);
    let free = choices(&scene, &settled, |goal| goal.labels_are_free);
    if let Some((choice, again)) = relabelled_take(&scene, events, free, work, observer) {
        sought.labels = choice;
        *take = again;
        return Some(sought);
    }
    let found = search(take, limit_s, work, &mut Quiet(observer));
    let is_well = found.is_some_and(|found| {
        take.inferred.solved = found;
        let mut doubts = take.doubts().into_iter();
        doubts.all(|doubt| doubt.about.best() == Verdict::Physical)
    });
    if !is_well {
        sought.offered = offered(&scene, events, &settled, work, observer);
    }
    Some(sought)
}

/// The first choice of turned labels with which the take ends right, and its motion then; adds to the work.
fn relabelled_take(
    scene: &Scene,
    events: &[TakeEvent],
    choices: Vec<Turns>,
    work: &mut RestWork,
    observer: &mut dyn Observer,
) -> Option<(Turns, Performed)> {
    let limit_s = scene.settle_s?;
    choices.into_iter().find_map(|choice| {
        if observer.should_stop() {
            return None;
        }
        let scene = turned(scene, &choice)?;
        let prepared = Prepared::new(&scene, events, &mut Quiet(observer)).ok()?;
        let again = prepared.performed(&mut Quiet(observer)).ok()?;
        let (scene, estimate) = (&again.inferred.scene, &again.inferred.solved.estimate);
        work.motions += 1;
        work.continuations += 1;
        let settled = settle_until(&scene.as_estimated(estimate), estimate, limit_s, observer)?;
        is_met(scene, &settled).then_some((choice, again))
    })
}

/// The goals whose labels, were they free, would let the take end right; none where that helps nothing.
fn offered(
    scene: &Scene,
    events: &[TakeEvent],
    settled: &Settled,
    work: &mut RestWork,
    observer: &mut dyn Observer,
) -> Vec<Diagnosis> {
    let all = choices(scene, settled, |_| true);
    let Some((choice, again)) = relabelled_take(scene, events, all, work, observer) else {
        return Vec::new();
    };
    let (position_m, orientation_rad) = again.inferred.solved.estimate.residual_rms();
    let turned = scene.rest_goals.iter().zip(&choice).enumerate();
    let turned = turned.filter(|(_, (goal, turn))| turn.is_some() && !goal.labels_are_free);
    let offered = turned.map(|(goal, _)| Diagnosis {
        remedy: Remedy::FreeLabels { goal },
        source: SampleSource::Tracker,
        without: None,
        with: Distance {
            position_m,
            orientation_rad,
        },
    });
    offered.collect()
}

/// Turns of the labels, goal by goal, with which the motion would end right: none where a goal is
/// missed whose labels may not be turned.
fn choices(scene: &Scene, settled: &Settled, may_turn: impl Fn(&RestGoal) -> bool) -> Vec<Turns> {
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
        let free = if may_turn(goal) {
            turns(link)
        } else {
            Vec::new()
        };
        free.into_iter().filter(shows).map(Some).collect()
    };
    let each: Vec<Turns> = goals.map(of_goal).collect();
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
