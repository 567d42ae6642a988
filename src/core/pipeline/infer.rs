//! Infers the contacts that a scene leaves open (paper §5.1): from the arc fits, solved and
//! checked; by a search where the fits are ambiguous or the check fails.

use super::search::{Found, SearchField, SearchWork, search};
use super::sound::is_sound;
use crate::estimate::problem::Problem;
use crate::estimate::{self, Recipe, Solved};
use crate::initialise::contact;
use crate::motion::{
    ContactRival, Contacts, Guess, Observer, Scene, Segment, Sketch, Standing, VelocityGaps,
};

/// Greatest cost of a motion relative to that of the fits of its arcs; above it others are
/// searched.
const FAR: f64 = 60.0;

/// A motion, with a scene in which all contacts are known.
#[derive(Clone)]
pub(super) struct Inferred {
    pub(super) scene: Scene,
    pub(super) solved: Solved,
    /// Collisions whose contacts the scene left open.
    pub(super) events: Vec<usize>,
    /// Work of the search, if there was one.
    pub(super) search: Option<SearchWork>,
    /// Contacts that are not ruled out.
    pub(super) rivals: Vec<ContactRival>,
}

/// Estimates the motion, and infers the contacts that the scene leaves open.
pub(super) fn infer(
    scene: &Scene,
    sketch: &Sketch,
    segments: &[Segment],
    guesses: &[Guess],
    recipe: &Recipe,
    observer: &mut dyn Observer,
) -> Result<Inferred, NoContact> {
    let events = scene.open_events();
    let solve = |scene: &Scene, observer: &mut dyn Observer| {
        estimate::estimate(scene, sketch, segments, guesses, recipe, observer)
    };
    let rankings: Vec<contact::Ranking> = events
        .iter()
        .map(|event| contact::rank(scene, sketch, segments, &guesses[0], *event))
        .collect();
    if let Some(lost) = rankings
        .iter()
        .find(|ranking| ranking.candidates.is_empty())
    {
        return Err(NoContact { event: lost.event });
    }
    let mut understood = scene.clone();
    for ranking in &rankings {
        understood.set_contacts(ranking.event, &ranking.candidates[0].contacts);
    }
    // With velocity gaps a wrong contact costs little, so that the objective is less informative
    // than the pose.
    let is_bent = scene.velocity_gaps == VelocityGaps::Always
        || Problem::new(&understood, sketch, segments).is_overconstrained();
    let mut first = None;
    if is_bent || !rankings.iter().any(contact::Ranking::is_ambiguous) {
        let solved = solve(&understood, observer);
        let estimate = &solved.estimate;
        let is_near = || {
            let fits = estimate::cost(&understood, sketch, segments, &guesses[0]);
            0.5 * estimate.objective < FAR * fits
        };
        let is_good = || is_sound(&understood, estimate, &events) && (is_bent || is_near());
        if events.is_empty() || is_good() || observer.should_stop() {
            return Ok(Inferred {
                scene: understood,
                solved,
                events,
                search: None,
                rivals: Vec::new(),
            });
        }
        first = Some(solved);
    }
    // Where the first candidate is clear but gives no good motion, the fits are misleading.
    let open = rankings.iter().map(|ranking| {
        let reaches = match first {
            Some(_) => &ranking.candidates,
            None => ranking.likely(),
        };
        let contacts = reaches.iter().map(|reach| reach.contacts.clone());
        (ranking.event, contacts.collect())
    });
    let open: Vec<(usize, Vec<Contacts>)> = open.collect();
    let field = SearchField {
        scene,
        sketch,
        segments,
        guesses,
        is_bent,
        open: &open,
        first: first.map(|first| (vec![0; open.len()], first)),
    };
    let Found {
        choice,
        mut solved,
        work,
        lost,
    } = search(&field, recipe, observer).expect("every collision has a candidate");
    let mut understood = scene.clone();
    for ((event, candidates), chosen) in open.iter().zip(&choice) {
        understood.set_contacts(*event, &candidates[*chosen]);
    }
    let mut rivals: Vec<ContactRival> = Vec::new();
    for other in lost {
        let both = choice.iter().zip(other).zip(&open);
        for ((_, other), (event, candidates)) in both.filter(|((own, other), _)| *own != other) {
            let rival = ContactRival {
                event: *event,
                contacts: candidates[other].clone(),
                standing: Standing::Lost,
            };
            if !rivals.contains(&rival) {
                rivals.push(rival);
            }
        }
    }
    if !work.is_proven {
        solved.estimate.reason.unproven_after_bounds = Some(work.bounds);
    }
    Ok(Inferred {
        scene: understood,
        solved,
        events,
        search: Some(work),
        rivals,
    })
}

/// No pair of features may touch at an open collision.
pub(super) struct NoContact {
    pub(super) event: usize,
}
