//! Motions of joined bodies with one choice of contacts or another, and which of them is kept.

use crate::estimate::tree::{self, Rival, Solved, TreeProblem};
use crate::initialise;
use crate::motion::{
    About, ContactRival, Contacts, Counters, Estimate, Observer, Scene, Sketch, Standing, Verdict,
};
use crate::verify;

/// Logarithm of the odds within which two contacts are not told from each other: of twenty.
const ALIKE: f64 = 3.0;

/// What all choices are tried for.
pub(super) struct Field<'a> {
    /// The scene, with its open collisions.
    pub(super) scene: &'a Scene,
    /// The performance.
    pub(super) sketch: &'a Sketch,
    /// See [`Outcome::marks_made_s`](crate::pipeline::Outcome::marks_made_s).
    pub(super) marks_made_s: &'a [Option<f64>],
}

/// A motion with all contacts known.
pub(super) struct Tried {
    pub(super) scene: Scene,
    pub(super) estimate: Estimate,
    pub(super) solved: Solved,
}

/// Choices of contacts, each with what came of it.
#[derive(Default)]
pub(super) struct Standings {
    all: Vec<(Vec<(usize, Contacts)>, Option<Tried>)>,
    left: Vec<Vec<(usize, Contacts)>>,
    /// Work on all of them.
    counters: Counters,
}

impl Field<'_> {
    /// The motion of a scene whose contacts are known, as it is found where the scene names them.
    pub(super) fn tried_whole(&self, scene: Scene, observer: &mut dyn Observer) -> Tried {
        let problem = TreeProblem::new(&scene, self.sketch);
        let starts = initialise::tree::starts(&scene, self.sketch, &problem.forest);
        let solved = tree::solved(&problem, &starts, observer);
        self.checked(scene, solved, observer)
    }

    /// The motion of such a scene, looked for once; `None` where none is found.
    pub(super) fn tried(
        &self,
        scene: &Scene,
        how: Rival,
        observer: &mut dyn Observer,
    ) -> Option<Tried> {
        let problem = TreeProblem::new(scene, self.sketch);
        let starts = initialise::tree::starts(scene, self.sketch, &problem.forest);
        let solved = tree::rival(&problem, &starts, how, observer)?;
        Some(self.checked(scene.clone(), solved, observer))
    }

    fn checked(&self, scene: Scene, solved: Solved, observer: &mut dyn Observer) -> Tried {
        let mut estimate = tree::estimate((&scene, self.sketch), &solved, observer);
        let performed = (self.sketch, self.marks_made_s);
        let doubts = verify::joined::doubts(&scene, performed, &estimate);
        estimate.doubt(doubts);
        Tried {
            scene,
            estimate,
            solved,
        }
    }
}

impl Tried {
    /// What each sample costs.
    pub(super) fn cost_each(&self) -> f64 {
        let samples = self.solved.problem.samples.len() as f64;
        0.5 * self.estimate.objective / samples
    }

    /// Whether it is an optimum, and its contacts touch as they should: nothing else touches before, or overlaps, and what is done again
    /// from the first state agrees.
    pub(super) fn is_sound(&self) -> bool {
        let is_of_contacts = |about: About| {
            matches!(
                about,
                About::WrongFeature
                    | About::Overlap
                    | About::Gap
                    | About::Receding
                    | About::Energy
                    | About::Steps
            )
        };
        let mut doubts = self.estimate.doubts.iter();
        self.has_ended() && !doubts.any(|doubt| is_of_contacts(doubt.about))
    }

    /// Whether it is an optimum of its problem: what else is said of it is said of that choice.
    fn has_ended(&self) -> bool {
        self.solved.solution.finished.converged && self.estimate.objective.is_finite()
    }

    /// How good it is: the least is kept.
    fn rank(&self) -> (bool, Verdict, bool, f64) {
        let is_sound = self.is_sound();
        let objective = self.estimate.objective;
        (
            !is_sound,
            self.estimate.verdict,
            !self.has_ended(),
            objective,
        )
    }

    fn is_better(&self, other: &Self) -> bool {
        let (a, b) = (self.rank(), other.rank());
        let order = (a.0, a.1, a.2).cmp(&(b.0, b.1, b.2));
        order.then(a.3.total_cmp(&b.3)).is_lt()
    }

    /// The better of two.
    pub(super) fn better(one: Option<Self>, other: Option<Self>) -> Option<Self> {
        match (one, other) {
            (Some(one), Some(other)) => Some(if other.is_better(&one) { other } else { one }),
            (one, other) => one.or(other),
        }
    }
}

impl Standings {
    /// Adds what came of a choice, in the place of what is known of it; `None` where no motion was found.
    pub(super) fn add(&mut self, contacts: Vec<(usize, Contacts)>, tried: Option<Tried>) {
        if let Some(tried) = &tried {
            self.counters.add(&tried.estimate.counters);
        }
        self.all.retain(|(other, _)| *other != contacts);
        self.all.push((contacts, tried));
    }

    /// Adds a choice that is not tried.
    pub(super) fn leave(&mut self, contacts: Vec<(usize, Contacts)>) {
        self.left.push(contacts);
    }

    /// How many were tried.
    pub(super) fn count(&self) -> usize {
        self.all.len()
    }

    /// Whether a sound motion is among them.
    pub(super) fn has_sound(&self) -> bool {
        self.best_at().is_some_and(|(_, best)| best.is_sound())
    }

    /// The best of those that are an optimum.
    pub(super) fn motion(&self) -> Option<&Tried> {
        let (_, best) = self.best_at()?;
        best.has_ended().then_some(best)
    }

    fn best_at(&self) -> Option<(usize, &Tried)> {
        let all = self.all.iter().enumerate();
        let all = all.filter_map(|(at, (_, tried))| Some((at, tried.as_ref()?)));
        all.reduce(|least, other| match other.1.is_better(least.1) {
            true => other,
            false => least,
        })
    }

    /// The best one, with what of the others is not ruled out by it: what is as likely by their evidence, what led to no
    /// optimum, what was not tried.
    ///
    /// # Panics
    /// Where no choice led to a motion, be it none that has ended.
    pub(super) fn best(mut self) -> Tried {
        let (at, _) = self.best_at().expect("one was tried as if it were named");
        let (contacts, best) = self.all.swap_remove(at);
        let mut best = best.expect("it was tried");
        let of_best = (!self.all.is_empty())
            .then(|| tree::evidence(&best.solved))
            .flatten();
        let mut rivals: Vec<ContactRival> = Vec::new();
        let mut add = |others: &[(usize, Contacts)], standing: Standing| {
            for ((event, own), (_, other)) in contacts.iter().zip(others) {
                let rival = ContactRival {
                    event: *event,
                    contacts: other.clone(),
                    standing,
                };
                if own != other && !rivals.contains(&rival) {
                    rivals.push(rival);
                }
            }
        };
        for (others, tried) in &self.all {
            match tried {
                Some(tried) if tried.has_ended() => {
                    let told = of_best.zip(tree::evidence(&tried.solved));
                    let is_alike = told.is_none_or(|(best, other)| other > best - ALIKE);
                    if tried.is_sound() && is_alike {
                        add(others, Standing::Alike);
                    }
                }
                _ => add(others, Standing::Lost),
            }
        }
        for others in &self.left {
            add(others, Standing::Untried);
        }
        best.estimate.is_rivalled_by(rivals);
        best.estimate.counters = self.counters;
        best
    }
}
