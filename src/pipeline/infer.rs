//! What touches where a scene leaves that open: read off the arc fits, solved, checked; searched
//! where the fits do not tell or the check fails.

use super::search::{Field, Found, SearchWork, search};
use crate::estimate::problem::Problem;
use crate::estimate::{self, Recipe};
use crate::initialise::contact;
use crate::motion::{
    Contacts, Estimate, Guess, Observer, Partner, Scene, Segment, Sketch, Touching, VelocityGaps,
    Verdict,
};
use crate::physics::contact::{Feature, Frame};
use crate::physics::flow;

/// By how much another feature may lead one that touches \[m\]: as much as solids may overlap.
const LEAD_M: f64 = 1e-3;

/// An estimate in a scene that says everything.
pub(super) struct Inferred {
    pub(super) scene: Scene,
    pub(super) estimate: Estimate,
    /// Collisions whose contacts the scene left open.
    pub(super) events: Vec<usize>,
    /// If there was a search.
    pub(super) search: Option<SearchWork>,
}

/// Estimates, and infers on the way what the scene leaves open.
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
    let all = |ranking: &contact::Ranking| -> Vec<Contacts> {
        let candidates = ranking.candidates.iter();
        candidates.map(|reach| reach.contacts.clone()).collect()
    };
    let mut understood = scene.clone();
    for ranking in &rankings {
        understood.set_contacts(ranking.event, &ranking.candidates[0].contacts);
    }
    // Where physics is bent a wrong contact costs little, and the objective says less than the
    // pose.
    let is_bent = scene.velocity_gaps == VelocityGaps::Always
        || Problem::new(&understood, sketch, segments).is_overconstrained();
    let mut first = None;
    if is_bent || !rankings.iter().any(contact::Ranking::is_ambiguous) {
        let estimate = solve(&understood, observer);
        let is_clear = rankings.iter().all(|ranking| {
            let leader = leads(&understood, &estimate, ranking.event, &all(ranking));
            leader.is_none()
        });
        let is_good = estimate.verdict != Verdict::Failed && is_clear;
        if is_good || events.is_empty() || observer.should_stop() {
            return Ok(Inferred {
                scene: understood,
                estimate,
                events,
                search: None,
            });
        }
        first = Some(estimate);
    }
    let open: Vec<(usize, Vec<Contacts>)> = rankings
        .iter()
        .map(|ranking| (ranking.event, all(ranking)))
        .collect();
    let field = Field {
        scene,
        sketch,
        segments,
        guesses,
        is_bent,
        open: &open,
    };
    let Found {
        choice,
        mut estimate,
        work,
    } = search(&field, recipe, observer).expect("every collision has a candidate");
    if let Some(first) = first {
        estimate.counters.add(&first.counters);
    }
    let mut understood = scene.clone();
    for ((event, candidates), chosen) in open.iter().zip(&choice) {
        understood.set_contacts(*event, &candidates[*chosen]);
    }
    for (event, candidates) in &open {
        if let Some(lead) = leads(&understood, &estimate, *event, candidates) {
            object(&understood, &lead, *event, &mut estimate);
        }
    }
    if !work.is_proven {
        estimate.reason = format!(
            "the search ended after {} bounds: other contacts may fit better; {}",
            work.bounds, estimate.reason
        );
    }
    Ok(Inferred {
        scene: understood,
        estimate,
        events,
        search: Some(work),
    })
}

/// No pair of features may touch at an open collision.
pub(super) struct NoContact {
    pub(super) event: usize,
}

/// A motion in which another feature would have touched first is not physical.
fn object(scene: &Scene, lead: &Lead, event: usize, estimate: &mut Estimate) {
    let name = &scene.events[event].name;
    let mut other = scene.clone();
    other.set_contacts(event, &lead.contacts);
    let words = other.contact_words(event).unwrap_or_default();
    estimate.reason = format!(
        "at `{name}` {words} would touch first, by {:.1} mm; {}",
        1e3 * lead.by_m,
        estimate.reason
    );
    if estimate.verdict == Verdict::Physical {
        estimate.verdict = Verdict::Plausible;
    }
}

/// What would have touched before what is said to.
pub(super) struct Lead {
    pub(super) contacts: Contacts,
    pub(super) by_m: f64,
}

/// The candidate that is deepest inside what is hit when the contacts of the scene touch it, if
/// any is beyond the tolerance. Planes and faces of bodies only: whether solids are inside one
/// another is for a verification to say.
pub(super) fn leads(
    scene: &Scene,
    estimate: &Estimate,
    event: usize,
    candidates: &[Contacts],
) -> Option<Lead> {
    let collision = scene.events[event].kind.collision()?;
    let other = collision.contacts.first()?.other?;
    let (geometry, there) = match collision.partner {
        Partner::World if scene.surfaces[other].obstacle.is_some() => return None,
        Partner::World => (scene.surfaces[other].geometry, Frame::world()),
        Partner::Body(body) => (
            scene.bodies[body].features[other].geometry,
            frame_at(scene, estimate, event, body)?,
        ),
    };
    if !matches!(geometry, Feature::Face { .. }) {
        return None;
    }
    let frame = frame_at(scene, estimate, event, collision.body)?;
    let gap_m = |touching: &Touching| {
        let meeting = scene.meeting_of(event, &[*touching]).ok()??;
        Some(meeting.contacts()[0].touch(&frame, &there).ok()?.gap_m)
    };
    let lowest_m = |contacts: &Contacts| {
        let gaps = contacts.iter().filter_map(gap_m);
        gaps.fold(f64::INFINITY, f64::min)
    };
    let on_it = candidates.iter().filter(|c| c[0].other == Some(other));
    let lowest = on_it.min_by(|a, b| lowest_m(a).total_cmp(&lowest_m(b)))?;
    let by_m = lowest_m(&collision.contacts) - lowest_m(lowest);
    (by_m > LEAD_M).then(|| Lead {
        contacts: lowest.clone(),
        by_m,
    })
}

/// Where a body is just before an event.
fn frame_at(scene: &Scene, estimate: &Estimate, event: usize, body: usize) -> Option<Frame> {
    let time_s = estimate.events[event].time_s;
    let mut arcs = estimate.arcs.iter();
    let arc = arcs.find(|arc| arc.body == body && arc.end_s == time_s)?;
    let gravity = &estimate.gravity_m_s2;
    let of_scene = &scene.bodies[body].body;
    let state = flow::advance(of_scene, gravity, &arc.state, time_s - arc.epoch_s);
    Some(Frame::of(&state))
}
