//! Collision sequence: which features touch at each of several collisions, by best-first search
//! (paper §5.1, §7).
//!
//! A node is a choice of features for the first `k` open collisions. Its bound is a lower bound of
//! the cost of the arcs up to the next open collision, plus lower bounds of the later arcs: alone,
//! or in pairs over a collision with the feature that suits them best ([`ahead`]). A child begins
//! with the bound of its pair of arcs. When it is the lowest in the queue, its own bound is raised
//! until it is above the next node's or cannot be raised; a complete sequence is then solved. The
//! first solved sequence to become the lowest again is the best of all: the others cost at least
//! their bounds (see [`estimate::bound`] for what these prove).
//!
//! The likeliest sequence by the fits is in the queue as a whole from the start, so that it is
//! found even where bounds of a few arcs are stuck at local minima above its cost.
//!
//! A motion in which another feature would have touched first is discarded.

mod ahead;
mod lower_bound;

use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

use self::lower_bound::LowerBound;
use super::sound::is_sound;
use crate::estimate::{self, Recipe, Solved};
use crate::motion::{
    Contacts, Counters, Guess, Observer, Phase, Scene, Segment, Sketch, VelocityGaps, Verdict,
};

/// Number of iterations of the whole problem after which the search ends with its best result;
/// iterations of a part count in proportion to its arcs.
const ITERATIONS_MAX: f64 = 1200.0;
/// Sequences without velocity gaps are searched up to so many times the cost of the best one with.
const BENT: f64 = 2.0;

/// The input of a search.
pub(super) struct SearchField<'a> {
    pub(super) scene: &'a Scene,
    pub(super) sketch: &'a Sketch,
    pub(super) segments: &'a [Segment],
    pub(super) guesses: &'a [Guess],
    /// Whether no sequence can do without velocity gaps.
    pub(super) is_bent: bool,
    /// Open collisions in order of time, each with its candidates, likeliest first.
    pub(super) open: &'a [(usize, Vec<Contacts>)],
    /// A sequence (indices into the candidates) that is already solved.
    pub(super) first: Option<(Vec<usize>, Solved)>,
}

/// The work of a search.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SearchWork {
    /// Number of possible sequences.
    pub sequences: f64,
    /// Partial sequences examined.
    pub nodes: usize,
    /// Lower bounds computed: of single arcs, of pairs, of partial sequences.
    pub bounds: usize,
    /// Sequences that were solved in full.
    pub solves: usize,
    /// Whether no other sequence can be better by the bounds.
    pub is_proven: bool,
}

impl SearchWork {
    /// The work of two searches for contacts that have nothing to do with each other.
    pub(super) fn both(one: Option<Self>, other: Option<Self>) -> Option<Self> {
        let (Some(mut both), Some(other)) = (one, other) else {
            return one.or(other);
        };
        both.add(&other);
        both.sequences *= other.sequences;
        both.is_proven &= other.is_proven;
        Some(both)
    }

    /// Adds the work of another search of the same field.
    fn add(&mut self, other: &Self) {
        self.nodes += other.nodes;
        self.bounds += other.bounds;
        self.solves += other.solves;
    }
}

/// The result of a search.
pub(super) struct Found {
    /// The choice at each open collision (indices into the candidates).
    pub(super) choice: Vec<usize>,
    pub(super) solved: Solved,
    pub(super) work: SearchWork,
    /// Sequences that no motion was found with, which does not show that there is none: what the first ones chosen are
    /// not told from.
    pub(super) lost: Vec<Vec<usize>>,
}

/// Finds the best sequence; `None` where an open collision has no candidate.
pub(super) fn search(
    field: &SearchField,
    recipe: &Recipe,
    observer: &mut dyn Observer,
) -> Option<Found> {
    if field
        .open
        .iter()
        .any(|(_, candidates)| candidates.is_empty())
    {
        return None;
    }
    observer.phase(Phase::Sequence);
    let may_bend = field.scene.velocity_gaps == VelocityGaps::WhenNeeded && !field.is_bent;
    let mut search = Search::new(field, recipe, field.is_bent);
    if let Some(first) = &field.first {
        search.work.solves += 1;
        search.counters.add(&first.1.estimate.counters);
        search.known.push(first.clone());
    }
    let failures = if may_bend { 1 } else { usize::MAX };
    search.run(f64::INFINITY, failures, observer);
    if may_bend && search.best().is_none() && !observer.should_stop() {
        // Velocity gaps may be necessary: then only sequences without them that are not much worse
        // are tried further.
        let mut bent = Search::new(field, recipe, true);
        bent.known = search.bent();
        bent.run(f64::INFINITY, usize::MAX, observer);
        let cost = bent.best().map(|best| bent.solutions[best].cost());
        search.iterations += bent.iterations;
        search.run(BENT * cost.unwrap_or(f64::INFINITY), usize::MAX, observer);
        if search.best().is_none() {
            bent.work.is_proven &= search.iterations <= ITERATIONS_MAX;
            std::mem::swap(&mut search, &mut bent);
        }
        search.work.add(&bent.work);
        search.counters.add(&bent.counters);
    }
    Some(search.conclude(observer))
}

/// A partial sequence.
#[derive(Clone, Debug)]
struct PartialSequence {
    cost: f64,
    /// Its lower bound when it was made.
    made_at: f64,
    stage: NodeState,
    /// Serial number, for ties.
    number: usize,
    choice: Vec<usize>,
    /// Bounds of the first arcs, without the last choice and without the one before.
    before: [f64; 2],
}

/// What is known of a node's cost.
#[derive(Clone, Debug)]
enum NodeState {
    /// A lower bound that can still be raised.
    Rising(LowerBound),
    /// A lower bound that cannot be raised.
    Bounded,
    /// The exact cost of a solved complete sequence. Index into the solutions.
    Solved(usize),
}

impl Ord for PartialSequence {
    fn cmp(&self, other: &Self) -> Ordering {
        self.cost
            .total_cmp(&other.cost)
            .then_with(|| other.choice.len().cmp(&self.choice.len()))
            .then_with(|| self.number.cmp(&other.number))
    }
}

impl PartialOrd for PartialSequence {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for PartialSequence {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for PartialSequence {}

impl SolvedSequence {
    /// Half the sum of squared residuals.
    fn cost(&self) -> f64 {
        0.5 * self.solved.estimate.objective
    }
}

struct SolvedSequence {
    choice: Vec<usize>,
    solved: Solved,
    /// Whether it is a motion in which no other feature would have touched first.
    is_sound: bool,
}

struct Search<'a> {
    field: &'a SearchField<'a>,
    recipe: &'a Recipe,
    /// The scene, with velocity gaps only where it always has them, so that costs are comparable.
    scene: Scene,
    queue: BinaryHeap<Reverse<PartialSequence>>,
    solutions: Vec<SolvedSequence>,
    /// Sequences that were solved before.
    known: Vec<(Vec<usize>, Solved)>,
    best: Option<usize>,
    made: usize,
    /// Lower bound of all arcs that begin at or after an open collision.
    tails: Vec<f64>,
    /// Lower bound of the arcs on both sides of an open collision, by candidate, including the
    /// other arcs of the neighbouring groups.
    pairs: Vec<Option<Vec<f64>>>,
    work: SearchWork,
    counters: Counters,
    /// Iterations so far, in those of the whole problem.
    iterations: f64,
}

impl<'a> Search<'a> {
    fn new(field: &'a SearchField<'a>, recipe: &'a Recipe, is_bent: bool) -> Self {
        let mut scene = field.scene.clone();
        if scene.velocity_gaps == VelocityGaps::WhenNeeded {
            scene.velocity_gaps = if is_bent {
                VelocityGaps::Always
            } else {
                VelocityGaps::Never
            };
        }
        let counts = field.open.iter().map(|(_, all)| all.len() as f64);
        let mut search = Self {
            field,
            recipe,
            scene,
            queue: BinaryHeap::new(),
            solutions: Vec::new(),
            known: Vec::new(),
            best: None,
            made: 0,
            tails: Vec::new(),
            pairs: Vec::new(),
            work: SearchWork {
                sequences: counts.product(),
                ..SearchWork::default()
            },
            counters: Counters::default(),
            iterations: 0.0,
        };
        search.look_ahead();
        search
    }

    fn with(&self, known: &[(usize, usize)]) -> Scene {
        let mut scene = self.scene.clone();
        for (place, candidate) in known {
            let (event, candidates) = &self.field.open[*place];
            scene.set_contacts(*event, &candidates[*candidate]);
        }
        scene
    }

    /// Continues the search until a sequence is proven the best, all others cost more than `limit`,
    /// so many `failures` to find a motion have occurred, or the search is too long.
    fn run(&mut self, limit: f64, failures: usize, observer: &mut dyn Observer) {
        if self.made == 0 {
            self.begin();
        }
        while let Some(Reverse(node)) = self.queue.pop() {
            if let NodeState::Solved(index) = node.stage {
                self.best = Some(index);
                self.work.is_proven = true;
                return;
            }
            let is_failed = |s: &&SolvedSequence| s.solved.estimate.verdict != Verdict::Physical;
            let failed = self.solutions.iter().filter(is_failed).count();
            let is_over =
                self.iterations > ITERATIONS_MAX || node.cost > limit || failed >= failures;
            if is_over || observer.should_stop() {
                self.queue.push(Reverse(node));
                return;
            }
            self.work.nodes += 1;
            self.advance(node, observer);
        }
    }

    /// Puts the root and the likeliest complete sequence in the queue: where that is the best, all
    /// others only need to be shown worse.
    fn begin(&mut self) {
        self.expand(&[], 0.0, [0.0; 2]);
        let choice = vec![0; self.field.open.len()];
        let stage = NodeState::Rising(self.prefix(&choice));
        let node = PartialSequence {
            cost: self.tails[0],
            made_at: self.tails[0],
            stage,
            number: self.made,
            choice,
            before: [0.0; 2],
        };
        self.made += 1;
        self.queue.push(Reverse(node));
        for (choice, solved) in std::mem::take(&mut self.known) {
            self.keep(choice, solved);
        }
    }

    /// Solutions with velocity gaps.
    fn bent(&self) -> Vec<(Vec<usize>, Solved)> {
        let jumps = |s: &&SolvedSequence| s.solved.estimate.verdict == Verdict::Plausible;
        let solutions = self.solutions.iter().filter(jumps);
        solutions
            .map(|s| (s.choice.clone(), s.solved.clone()))
            .collect()
    }

    /// Brings a node to its next state, or its bound above that of the next node.
    fn advance(&mut self, mut node: PartialSequence, observer: &mut dyn Observer) {
        let depth = node.choice.len();
        if let NodeState::Rising(bound) = &mut node.stage {
            let next = self.queue.peek();
            let next = next.map_or(f64::INFINITY, |Reverse(next)| next.cost);
            let tail = self.tails[depth + 1];
            self.tighten(bound, (next - tail).max(bound.cost()));
            let own = bound.cost().max(node.before[0]);
            node.cost = node.made_at.max(own + tail);
            if bound.is_done() {
                node.before = [own, node.before[0]];
                node.stage = NodeState::Bounded;
            }
            self.queue.push(Reverse(node));
        } else if depth < self.field.open.len() {
            self.expand(&node.choice, node.cost, node.before);
        } else {
            self.solve(node, observer);
        }
    }

    fn expand(&mut self, choice: &[usize], cost: f64, before: [f64; 2]) {
        let place = choice.len();
        for candidate in 0..self.field.open[place].1.len() {
            let by_pair = self.pairs[place].as_ref().map_or(0.0, |pairs| {
                before[1] + pairs[candidate] + self.tails[place + 2]
            });
            let made_at = cost.max(by_pair);
            let choice = [choice, &[candidate]].concat();
            let node = PartialSequence {
                cost: made_at,
                made_at,
                stage: NodeState::Rising(self.prefix(&choice)),
                number: self.made,
                choice,
                before,
            };
            self.made += 1;
            self.queue.push(Reverse(node));
        }
    }

    fn solve(&mut self, node: PartialSequence, observer: &mut dyn Observer) {
        if self.solutions.iter().any(|s| s.choice == node.choice) {
            return;
        }
        let scene = self.with(&places(&node.choice));
        let solved = self.estimate(&scene, observer);
        observer.phase(Phase::Sequence);
        self.keep(node.choice, solved);
    }

    fn keep(&mut self, choice: Vec<usize>, solved: Solved) {
        let scene = self.with(&places(&choice));
        let open: Vec<usize> = self.field.open.iter().map(|(event, _)| *event).collect();
        let may_jump = self.scene.velocity_gaps == VelocityGaps::Always;
        let solution = SolvedSequence {
            is_sound: (may_jump || solved.estimate.verdict == Verdict::Physical)
                && is_sound(&scene, &solved.estimate, &open),
            choice,
            solved,
        };
        if solution.is_sound {
            self.queue.push(Reverse(PartialSequence {
                cost: solution.cost(),
                made_at: solution.cost(),
                stage: NodeState::Solved(self.solutions.len()),
                number: self.made,
                choice: solution.choice.clone(),
                before: [0.0; 2],
            }));
            self.made += 1;
        }
        self.solutions.push(solution);
    }

    /// Estimates with all contacts known; velocity gaps only where needed.
    fn estimate(&mut self, scene: &Scene, observer: &mut dyn Observer) -> Solved {
        self.work.solves += 1;
        let SearchField {
            sketch,
            segments,
            guesses,
            ..
        } = self.field;
        let may_bend = self.field.scene.velocity_gaps == VelocityGaps::WhenNeeded;
        let mut scene = scene.clone();
        if may_bend && scene.velocity_gaps == VelocityGaps::Never {
            scene.velocity_gaps = VelocityGaps::WhenNeeded;
        }
        let solved = estimate::estimate(&scene, sketch, segments, guesses, self.recipe, observer);
        let counters = &solved.estimate.counters;
        self.iterations += counters.iterations as f64;
        self.counters.add(counters);
        solved
    }

    /// The best sound solution: the first to become the lowest, else the best of those in the
    /// queue.
    fn best(&self) -> Option<usize> {
        let sound = (0..self.solutions.len()).filter(|index| self.solutions[*index].is_sound);
        let objective = |index: &usize| self.solutions[*index].solved.estimate.objective;
        self.best
            .or_else(|| sound.min_by(|a, b| objective(a).total_cmp(&objective(b))))
    }

    /// The best sound solution, or the best known one where none is sound.
    fn conclude(mut self, observer: &mut dyn Observer) -> Found {
        let rank = |solution: &SolvedSequence| {
            let estimate = &solution.solved.estimate;
            let is_failed = estimate.verdict == Verdict::Failed;
            (!solution.is_sound, is_failed, estimate.objective)
        };
        let best = self.best.or_else(|| {
            let all = 0..self.solutions.len();
            all.min_by(|a, b| {
                let (a, b) = (rank(&self.solutions[*a]), rank(&self.solutions[*b]));
                (a.0, a.1).cmp(&(b.0, b.1)).then(a.2.total_cmp(&b.2))
            })
        });
        let lost = best.map_or_else(Vec::new, |best| self.lost(best));
        let (choice, mut solved) = match best {
            Some(best) => {
                let solution = self.solutions.swap_remove(best);
                (solution.choice, Some(solution.solved))
            }
            None => (self.likeliest(), None),
        };
        let is_failed = |solved: &Solved| solved.estimate.verdict == Verdict::Failed;
        if solved.as_ref().is_none_or(is_failed) {
            // With velocity gaps, where the scene allows them.
            let mut scene = self.with(&places(&choice));
            scene.velocity_gaps = self.field.scene.velocity_gaps;
            solved = Some(self.estimate(&scene, observer));
        }
        let mut solved = solved.expect("just solved");
        solved.estimate.counters = self.counters;
        Found {
            choice,
            solved,
            work: self.work,
            lost,
        }
    }

    /// Other sequences than the best that were solved without finding a motion, where that one is one.
    fn lost(&self, best: usize) -> Vec<Vec<usize>> {
        let is_failed = |of: &&SolvedSequence| of.solved.estimate.verdict == Verdict::Failed;
        let others = self.solutions.iter().filter(is_failed);
        let others = others.filter(|_| self.solutions[best].is_sound);
        others.map(|of| of.choice.clone()).collect()
    }

    /// The longest partial sequence examined, completed step by step by the least bound among the
    /// best candidates of each next pair of arcs.
    fn likeliest(&mut self) -> Vec<usize> {
        const LOOKED_INTO: usize = 3;
        let deepest = self.queue.iter().min_by(|Reverse(a), Reverse(b)| {
            b.choice.len().cmp(&a.choice.len()).then_with(|| a.cmp(b))
        });
        let mut choice = deepest.map_or_else(Vec::new, |Reverse(node)| node.choice.clone());
        for place in choice.len()..self.field.open.len() {
            let mut next: Vec<usize> = (0..self.field.open[place].1.len()).collect();
            if let Some(pairs) = &self.pairs[place] {
                next.sort_by(|a, b| pairs[*a].total_cmp(&pairs[*b]));
            }
            next.truncate(LOOKED_INTO);
            let mut bounds: Vec<LowerBound> = next
                .iter()
                .map(|candidate| self.prefix(&[&choice[..], &[*candidate]].concat()))
                .collect();
            choice.push(next[self.race(&mut bounds)]);
        }
        choice
    }
}

/// A choice as pairs of a place in the list of open collisions and a candidate.
fn places(choice: &[usize]) -> Vec<(usize, usize)> {
    choice.iter().copied().enumerate().collect()
}
