//! Infers the contacts that a scene with joints leaves open (paper §5.1): candidates are ranked by the motion that the
//! samples before each collision say, the likeliest are solved and checked, and of those that pass the one nearest to
//! the performance is kept.
//!
//! A choice has a candidate at each open collision. How unlikely it is by the ranking is `√Σ d²`, with `d` how much
//! farther each candidate is from touching than the first, in spreads. The first choice is solved as a scene that names
//! it would be, so that it leads to the same motion; further ones from where that led. A choice that was not solved to an
//! optimum, or not tried, is a rival that is not ruled out, and the estimate says so.

use super::rivals::Standings;
use super::tried::{AttemptOutcome, Tried, TriedField};
use crate::estimate::tree::{Before, TreeProblem};
use crate::initialise::{self, contact};
use crate::motion::{Contacts, Counters, LinkIndex, Observer, Phase, Scene, Sketch};
use crate::physics::State;
use crate::pipeline::infer::NoContact;
use crate::pipeline::search::SearchWork;

/// Choices that are farther from the first than this are ruled out by the ranking, in spreads,
const LIKELY: f64 = 4.0;
/// and where no other is nearer than this, the first is taken if it is sound.
const CLEAR: f64 = 2.0;
/// Greatest number of choices that are solved.
const SOLVED_MOST: usize = 5;
/// A motion of which each sample costs so many times what it does before the first open collision is far from its
/// performance: others are tried.
const FAR: f64 = 4.0;
/// What a sample costs at least: a hundredth of a weight is no distance.
const LEAST_EACH: f64 = 1e-4;

/// Candidates of all open collisions, ranked.
pub(super) struct Ranked {
    /// The scene with the likeliest.
    pub(super) scene: Scene,
    /// The collisions, each with its candidates.
    rankings: Vec<contact::Ranking>,
    /// What each sample costs before the first.
    cost_each: f64,
    /// Work done.
    counters: Counters,
}

/// The motion until a collision, for the ranking.
struct RivalFit<'a> {
    scene: &'a Scene,
    before: Before,
}

impl contact::Fitted for RivalFit<'_> {
    fn state(&self, link: LinkIndex, is_after: bool, after_s: f64) -> Option<State> {
        (!is_after).then(|| self.before.state(self.scene, link, after_s))
    }

    fn spread_m(&self, link: LinkIndex) -> f64 {
        self.before.spread_m(self.scene, link)
    }
}

/// Ranks the candidates of every open collision, in order of time: through the likeliest of those before.
pub(super) fn rank(
    scene: &Scene,
    sketch: &Sketch,
    observer: &mut dyn Observer,
) -> Result<Ranked, NoContact> {
    let open = scene.open_events();
    let mut understood = scene.clone();
    for event in &open {
        let any = scene.candidates(*event).into_iter().next();
        let any = any.ok_or(NoContact { event: *event })?;
        understood.set_contacts(*event, &any);
    }
    let mut ranked = Ranked {
        scene: understood,
        rankings: Vec::new(),
        cost_each: 0.0,
        counters: Counters::default(),
    };
    for event in open {
        observer.phase(Phase::Sequence);
        let problem = TreeProblem::new(&ranked.scene, sketch);
        let starts = initialise::tree::starts(&ranked.scene, sketch, &problem.forest);
        let Some(before) = Before::new(&problem, event, &starts, observer) else {
            // Nothing is known of the motion before it: all are as likely.
            let candidates = scene.candidates(event).into_iter();
            let candidates = candidates.map(|contacts| contact::Reach {
                contacts,
                reach_m: 0.0,
            });
            ranked.rankings.push(contact::Ranking {
                event,
                candidates: candidates.collect(),
                spread_m: 1.0,
            });
            continue;
        };
        let work = before.work();
        ranked.counters.iterations += work.iterations;
        ranked.counters.evaluations += work.evaluations;
        ranked.counters.factorisations += work.factorisations;
        if ranked.rankings.is_empty() {
            ranked.cost_each = before.cost_each();
        }
        let fit = RivalFit { scene, before };
        let ranking = contact::ranked(scene, event, &fit);
        let first = ranking.candidates.first();
        let first = first.ok_or(NoContact { event })?;
        ranked.scene.set_contacts(event, &first.contacts);
        ranked.rankings.push(ranking);
    }
    Ok(ranked)
}

impl Ranked {
    /// The collisions whose contacts are open.
    pub(super) fn events(&self) -> Vec<usize> {
        self.rankings.iter().map(|of| of.event).collect()
    }

    /// Choices that are not ruled out, the likeliest first, with how unlikely they are.
    fn choices(&self) -> Vec<(f64, Vec<usize>)> {
        let mut choices: Vec<(f64, Vec<usize>)> = vec![(0.0, Vec::new())];
        for ranking in &self.rankings {
            let first_m = ranking.candidates[0].reach_m;
            let spread_m = ranking.spread_m.max(f64::MIN_POSITIVE);
            choices = choices
                .iter()
                .flat_map(|(unlikely, chosen)| {
                    let candidates = ranking.candidates.iter().enumerate();
                    candidates.map(move |(at, reach)| {
                        let farther = (reach.reach_m - first_m) / spread_m;
                        (unlikely.hypot(farther), [&chosen[..], &[at]].concat())
                    })
                })
                .filter(|(unlikely, _)| *unlikely <= LIKELY)
                .collect();
        }
        choices.sort_by(|a, b| a.0.total_cmp(&b.0));
        choices
    }

    fn contacts(&self, choice: &[usize]) -> Vec<(usize, Contacts)> {
        let both = self.rankings.iter().zip(choice);
        both.map(|(ranking, at)| (ranking.event, ranking.candidates[*at].contacts.clone()))
            .collect()
    }
}

/// The motion with the contacts that fit best of those that are likely, and the work of finding it.
pub(super) fn infer(
    ranked: &Ranked,
    field: &TriedField,
    observer: &mut dyn Observer,
) -> (Tried, SearchWork) {
    let choices = ranked.choices();
    let scene_of = |choice: &[usize]| {
        let mut scene = field.scene.clone();
        for (event, contacts) in ranked.contacts(choice) {
            scene.set_contacts(event, &contacts);
        }
        scene
    };
    let mut standings = Standings::default();
    let likeliest = || scene_of(&choices[0].1);
    let is_clear = choices.get(1).is_none_or(|(unlikely, _)| *unlikely > CLEAR);
    let first = match is_clear {
        true => AttemptOutcome::Tried(Box::new(field.named(likeliest(), observer))),
        false => field.rival(likeliest(), None, observer),
    };
    let is_near = |of: &Tried| of.cost_each() <= FAR * ranked.cost_each.max(LEAST_EACH);
    standings.add(ranked.contacts(&choices[0].1), first);
    let is_answer = |of: &Tried| is_clear && is_near(of) && of.is_sound();
    if !standings.motion().is_some_and(is_answer) {
        for (index, (_, choice)) in choices.iter().enumerate().skip(1) {
            observer.phase(Phase::Sequence);
            let outcome = match index >= SOLVED_MOST || observer.should_stop() {
                true => AttemptOutcome::Left,
                false => field.rival(scene_of(choice), standings.motion(), observer),
            };
            standings.add(ranked.contacts(choice), outcome);
        }
    }
    if standings.motion().is_none() {
        let named = field.named(likeliest(), observer);
        standings.add(
            ranked.contacts(&choices[0].1),
            AttemptOutcome::Tried(Box::new(named)),
        );
    }
    let solves = standings.count();
    let mut best = standings.best(field, observer);
    best.estimate.counters.add(&ranked.counters);
    let sequences = ranked.rankings.iter().map(|of| of.candidates.len() as f64);
    let work = SearchWork {
        sequences: sequences.product(),
        nodes: choices.len(),
        bounds: 0,
        solves,
        is_proven: best.estimate.contact_rivals.is_empty(),
    };
    (best, work)
}
