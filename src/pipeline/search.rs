//! Which features hit at each of several collisions: best-first search (paper §5.1, §7).
//!
//! A node is what hits at the first `k` open collisions. Its bound is that of the arcs up to the
//! next ([`estimate::bound`]), plus what the arcs after that cost at the least: fits by
//! themselves, or in pairs over a collision with whatever feature suits them best. A child begins
//! with a bound that is there already, by its pair of arcs, and gets its own when its turn comes;
//! a complete sequence is solved when its turn comes. The first solved one to come up again is
//! the best of all: none that is left can cost less, as far as bounds are (see
//! [`mod@estimate::bound`]).
//!
//! A motion in which another feature would have touched first is none, and is passed over.

use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

use super::infer::leads;
use crate::estimate::{self, Recipe};
use crate::motion::{
    Contacts, Counters, Estimate, Guess, Observer, Phase, Scene, Segment, Sketch, VelocityGaps,
    Verdict,
};

/// Bounds, and solves, after which the search ends with what it has.
const BOUNDS_MAX: usize = 4000;
const SOLVES_MAX: usize = 40;

/// What is searched, and in what.
pub(super) struct Field<'a> {
    pub(super) scene: &'a Scene,
    pub(super) sketch: &'a Sketch,
    pub(super) segments: &'a [Segment],
    pub(super) guesses: &'a [Guess],
    /// Whether no sequence can do without velocity gaps.
    pub(super) is_bent: bool,
    /// Open collisions in order of time, each with what may touch, likeliest first.
    pub(super) open: &'a [(usize, Vec<Contacts>)],
}

/// The work of a search.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SearchWork {
    /// Sequences that there are.
    pub sequences: f64,
    /// Partial sequences that came up.
    pub nodes: usize,
    /// Lower bounds computed: of single arcs, of pairs, of partial sequences.
    pub bounds: usize,
    /// Sequences that were solved in full.
    pub solves: usize,
    /// Whether no other sequence can be better, as far as bounds are.
    pub is_proven: bool,
}

impl SearchWork {
    /// Adds what another search of the same field took.
    fn add(&mut self, other: &Self) {
        self.nodes += other.nodes;
        self.bounds += other.bounds;
        self.solves += other.solves;
    }
}

/// What a search found.
pub(super) struct Found {
    /// What touches at each open collision (indices into the candidates).
    pub(super) choice: Vec<usize>,
    pub(super) estimate: Estimate,
    pub(super) work: SearchWork,
}

/// Finds the best sequence; `None` where an open collision has no candidate.
pub(super) fn search(field: &Field, recipe: &Recipe, observer: &mut dyn Observer) -> Option<Found> {
    if field
        .open
        .iter()
        .any(|(_, candidates)| candidates.is_empty())
    {
        return None;
    }
    observer.phase(Phase::Sequence);
    let mut search = Search::new(field, recipe, field.is_bent);
    search.run(observer);
    let may_bend = field.scene.velocity_gaps == VelocityGaps::WhenNeeded && !field.is_bent;
    if search.best().is_none() && may_bend && !observer.should_stop() {
        // No sequence does without: then the best that bends physics.
        let (work, counters) = (search.work, search.counters);
        search = Search::new(field, recipe, true);
        search.work.add(&work);
        search.counters.add(&counters);
        search.run(observer);
    }
    Some(search.conclude(observer))
}

/// A partial sequence.
#[derive(Clone, Debug)]
struct Node {
    cost: f64,
    stage: Stage,
    /// Number in order of making, for ties.
    number: usize,
    choice: Vec<usize>,
    /// Bounds of the first arcs, without the last choice and without the one before.
    before: [f64; 2],
}

/// What a node's cost is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    /// At least that, by what was known.
    Made,
    /// At least that, by its own bound.
    Bounded,
    /// That: all is known, and it is solved. Index into the solutions.
    Solved(usize),
}

impl Ord for Node {
    fn cmp(&self, other: &Self) -> Ordering {
        self.cost
            .total_cmp(&other.cost)
            .then_with(|| other.choice.len().cmp(&self.choice.len()))
            .then_with(|| self.number.cmp(&other.number))
    }
}

impl PartialOrd for Node {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Node {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Node {}

struct Solution {
    choice: Vec<usize>,
    estimate: Estimate,
    /// Whether it is a motion, in which nothing else would have touched first.
    is_sound: bool,
}

struct Search<'a> {
    field: &'a Field<'a>,
    recipe: &'a Recipe,
    /// The scene, with velocity gaps only where it always has them: costs must compare.
    scene: Scene,
    queue: BinaryHeap<Reverse<Node>>,
    solutions: Vec<Solution>,
    best: Option<usize>,
    made: usize,
    /// Least cost of all arcs that begin at or after an open collision.
    tails: Vec<f64>,
    /// Least cost of the arcs on both sides of an open collision, by candidate; together with
    /// other arcs that neighbouring groups have besides.
    pairs: Vec<Option<Vec<f64>>>,
    work: SearchWork,
    counters: Counters,
}

impl<'a> Search<'a> {
    fn new(field: &'a Field<'a>, recipe: &'a Recipe, is_bent: bool) -> Self {
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
            best: None,
            made: 0,
            tails: Vec::new(),
            pairs: Vec::new(),
            work: SearchWork {
                sequences: counts.product(),
                ..SearchWork::default()
            },
            counters: Counters::default(),
        };
        search.look_ahead();
        search
    }

    /// Arcs that begin after `from` open collisions and before the next.
    fn group(&self, from: usize) -> Vec<usize> {
        let open = |index: usize| self.field.open.get(index).map(|(event, _)| *event);
        let least = from.checked_sub(1).and_then(open);
        let most = open(from).unwrap_or(usize::MAX);
        let is_in = |index: &usize| match self.field.segments[*index].start_event {
            Some(start) => least.is_none_or(|least| start >= least) && start < most,
            None => least.is_none(),
        };
        (0..self.field.segments.len()).filter(is_in).collect()
    }

    /// Bounds of single arcs and of pairs, and from these of all that comes after a node.
    fn look_ahead(&mut self) {
        let depth = self.field.open.len();
        let groups: Vec<Vec<usize>> = (0..=depth).map(|from| self.group(from)).collect();
        let singles: Vec<f64> = (0..self.field.segments.len())
            .map(|arc| self.bound(&[], &[arc], false))
            .collect();
        let sum = |arcs: &[usize]| arcs.iter().map(|arc| singles[*arc]).sum::<f64>();
        for index in 0..depth {
            let event = self.field.open[index].0;
            let is_beside = |arc: &usize| {
                let segment = &self.field.segments[*arc];
                segment.end_event == Some(event) || segment.start_event == Some(event)
            };
            let near: Vec<usize> = [&groups[index][..], &groups[index + 1]].concat();
            let arcs: Vec<usize> = (0..self.field.segments.len()).filter(is_beside).collect();
            let others: Vec<usize> = near.iter().copied().filter(|arc| !is_beside(arc)).collect();
            let is_near = arcs.iter().all(|arc| near.contains(arc));
            let candidates = self.field.open[index].1.len();
            let pair = is_near.then(|| {
                let of = |candidate| self.bound(&[(index, candidate)], &arcs, false);
                let costs: Vec<f64> = (0..candidates).map(of).collect();
                costs
                    .iter()
                    .map(|cost| cost.max(sum(&arcs)) + sum(&others))
                    .collect()
            });
            self.pairs.push(pair);
        }
        self.tails = vec![0.0; depth + 2];
        for from in (1..=depth).rev() {
            let alone = sum(&groups[from]) + self.tails[from + 1];
            let pair = self.pairs.get(from).and_then(|pair| pair.as_ref());
            let paired = pair.map_or(0.0, |costs| {
                costs.iter().copied().fold(f64::INFINITY, f64::min) + self.tails[from + 2]
            });
            self.tails[from] = alone.max(paired);
        }
    }

    /// Bound of arcs with some open collisions known: places in the list, and candidates.
    fn bound(&mut self, known: &[(usize, usize)], arcs: &[usize], own_priors: bool) -> f64 {
        let scene = self.with(known);
        self.work.bounds += 1;
        let mut least = f64::INFINITY;
        let mut tried: Vec<Vec<usize>> = Vec::new();
        for (index, guess) in self.field.guesses.iter().enumerate() {
            // Guesses may differ in other arcs only.
            let is_tried = tried.iter().flatten().any(|other| {
                let same = |arc: &usize| self.field.guesses[*other].arcs[*arc] == guess.arcs[*arc];
                arcs.iter().all(same)
            });
            if is_tried {
                continue;
            }
            tried.push(vec![index]);
            let parts = (self.field.segments, arcs);
            let bound = estimate::bound(&scene, self.field.sketch, parts, guess, own_priors);
            self.counters.add(&bound.counters);
            least = least.min(bound.cost);
        }
        least
    }

    fn with(&self, known: &[(usize, usize)]) -> Scene {
        let mut scene = self.scene.clone();
        for (place, candidate) in known {
            let (event, candidates) = &self.field.open[*place];
            scene.set_contacts(*event, &candidates[*candidate]);
        }
        scene
    }

    fn run(&mut self, observer: &mut dyn Observer) {
        self.expand(&[], 0.0, [0.0; 2]);
        while let Some(Reverse(node)) = self.queue.pop() {
            if let Stage::Solved(index) = node.stage {
                self.best = Some(index);
                self.work.is_proven = true;
                return;
            }
            let is_enough = self.work.bounds >= BOUNDS_MAX || self.solutions.len() >= SOLVES_MAX;
            if is_enough || observer.should_stop() {
                return;
            }
            self.work.nodes += 1;
            self.advance(node, observer);
        }
    }

    /// Brings a node to its next stage.
    fn advance(&mut self, mut node: Node, observer: &mut dyn Observer) {
        let depth = node.choice.len();
        if node.stage == Stage::Made {
            let own = self.prefix(&node.choice).max(node.before[0]);
            node.before = [own, node.before[0]];
            node.cost = node.cost.max(own + self.tails[depth + 1]);
            node.stage = Stage::Bounded;
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
            let node = Node {
                cost: cost.max(by_pair),
                stage: Stage::Made,
                number: self.made,
                choice: [choice, &[candidate]].concat(),
                before,
            };
            self.made += 1;
            self.queue.push(Reverse(node));
        }
    }

    fn solve(&mut self, node: Node, observer: &mut dyn Observer) {
        let scene = self.with(&node.choice.iter().copied().enumerate().collect::<Vec<_>>());
        let estimate = self.estimate(&scene, observer);
        observer.phase(Phase::Sequence);
        let is_leading = |(event, candidates): &(usize, Vec<Contacts>)| {
            leads(&scene, &estimate, *event, candidates).is_none()
        };
        let is_motion = estimate.verdict != Verdict::Failed;
        let is_sound = is_motion && self.field.open.iter().all(is_leading);
        let cost = 0.5 * estimate.objective;
        self.solutions.push(Solution {
            choice: node.choice.clone(),
            estimate,
            is_sound,
        });
        if is_sound {
            self.queue.push(Reverse(Node {
                cost,
                stage: Stage::Solved(self.solutions.len() - 1),
                ..node
            }));
        }
    }

    fn estimate(&mut self, scene: &Scene, observer: &mut dyn Observer) -> Estimate {
        self.work.solves += 1;
        let Field {
            sketch,
            segments,
            guesses,
            ..
        } = self.field;
        estimate::estimate(scene, sketch, segments, guesses, self.recipe, observer)
    }

    /// The best sound solution: the one that came up first, or else of those that wait.
    fn best(&self) -> Option<usize> {
        let sound = (0..self.solutions.len()).filter(|index| self.solutions[*index].is_sound);
        let objective = |index: &usize| self.solutions[*index].estimate.objective;
        self.best
            .or_else(|| sound.min_by(|a, b| objective(a).total_cmp(&objective(b))))
    }

    /// The best that was found, or the best that is known where none is sound.
    fn conclude(mut self, observer: &mut dyn Observer) -> Found {
        let rank = |solution: &Solution| {
            let is_failed = solution.estimate.verdict == Verdict::Failed;
            (!solution.is_sound, is_failed, solution.estimate.objective)
        };
        let best = self.best.or_else(|| {
            let all = 0..self.solutions.len();
            all.min_by(|a, b| {
                let (a, b) = (rank(&self.solutions[*a]), rank(&self.solutions[*b]));
                (a.0, a.1).cmp(&(b.0, b.1)).then(a.2.total_cmp(&b.2))
            })
        });
        let (choice, mut estimate) = match best {
            Some(best) => {
                let solution = self.solutions.swap_remove(best);
                (solution.choice, Some(solution.estimate))
            }
            None => (self.likeliest(), None),
        };
        let is_failed = |e: &Estimate| e.verdict == Verdict::Failed;
        if estimate.as_ref().is_none_or(is_failed) {
            // With velocity gaps, where the scene allows them.
            let mut scene = self.with(&choice.iter().copied().enumerate().collect::<Vec<_>>());
            scene.velocity_gaps = self.field.scene.velocity_gaps;
            estimate = Some(self.estimate(&scene, observer));
        }
        let mut estimate = estimate.expect("just solved");
        estimate.counters.add(&self.counters);
        Found {
            choice,
            estimate,
            work: self.work,
        }
    }

    /// The longest sequence that was looked into, completed one by one: by the least bound among
    /// what suits each next pair of arcs best.
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
            let bounds: Vec<(f64, usize)> = next
                .into_iter()
                .map(|candidate| {
                    (
                        self.prefix(&[&choice[..], &[candidate]].concat()),
                        candidate,
                    )
                })
                .collect();
            let best = bounds.iter().min_by(|a, b| a.0.total_cmp(&b.0));
            choice.push(best.map_or(0, |(_, candidate)| *candidate));
        }
        choice
    }

    /// Bound of the arcs up to the first collision that is open still.
    fn prefix(&mut self, choice: &[usize]) -> f64 {
        let arcs: Vec<usize> = (0..=choice.len())
            .flat_map(|from| self.group(from))
            .collect();
        let known: Vec<(usize, usize)> = choice.iter().copied().enumerate().collect();
        self.bound(&known, &arcs, true)
    }
}
