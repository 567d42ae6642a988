//! A motion of joined bodies with all contacts known: solved, checked, and compared with others.

use std::cell::OnceCell;

use crate::estimate::tree::{self, Detail, RivalOutcome, Solved, TreeProblem};
use crate::initialise;
use crate::motion::{
    About, Doubt, Estimate, Observer, Performer, Scene, Sketch, Verdict, Verification,
};
use crate::physics::tree::TreeState;
use crate::verify;

/// Logarithm of the odds within which two contacts are not told from each other: of twenty.
const ALIKE: f64 = 3.0;

/// What all choices are tried for.
pub(super) struct TriedField<'a> {
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
    /// What checks measured of it.
    pub(super) verification: Option<Verification>,
    pub(super) solved: Solved,
    /// How likely its samples are, once somebody asks.
    evidence: OnceCell<Option<f64>>,
}

/// What came of a choice.
pub(super) enum AttemptOutcome {
    /// A motion, which may be no optimum, or one that is not sound.
    Tried(Box<Tried>),
    /// What is farther from the performance than the best, beyond what its errors let tell.
    Worse,
    /// Nothing.
    Lost,
    /// It was not tried.
    Left,
}

impl TriedField<'_> {
    /// The motion of a scene that names its contacts, with how certain it is and how well it fits.
    pub(super) fn performed(&self, scene: Scene, observer: &mut dyn Observer) -> Tried {
        let solved = self.one_by_one(&scene, observer);
        self.refined(scene, solved, observer)
    }

    /// The motion of a scene whose contacts are known, as it is found where the scene names them, each sample by itself.
    pub(super) fn named(&self, scene: Scene, observer: &mut dyn Observer) -> Tried {
        let solved = self.one_by_one(&scene, observer);
        let estimate = self.estimate(&scene, &solved, Detail::Motion, observer);
        self.checked(scene, solved, estimate, Vec::new(), observer)
    }

    /// What comes of such a scene where another motion is the best so far.
    pub(super) fn rival(
        &self,
        scene: Scene,
        best: Option<&Tried>,
        observer: &mut dyn Observer,
    ) -> AttemptOutcome {
        let (problem, starts) = self.problem(&scene);
        let of_best = best.map(|best| &best.solved);
        let solved = match tree::rival(&problem, &starts, of_best, observer) {
            RivalOutcome::Solved(solved) => *solved,
            RivalOutcome::Worse => return AttemptOutcome::Worse,
            RivalOutcome::Lost => return AttemptOutcome::Lost,
        };
        let best = best.filter(|best| best.is_sound());
        if best.is_some_and(|best| best.beats(&solved, || tree::evidence(&solved))) {
            return AttemptOutcome::Worse;
        }
        let estimate = self.estimate(&scene, &solved, Detail::Motion, observer);
        let checked = self.checked(scene, solved, estimate, Vec::new(), observer);
        AttemptOutcome::Tried(Box::new(checked))
    }

    /// The same motion with the likeliest errors of a hand, with how certain it is and how well it fits.
    pub(super) fn told(&self, tried: Tried, observer: &mut dyn Observer) -> Tried {
        self.refined(tried.scene, tried.solved, observer)
    }

    fn one_by_one(&self, scene: &Scene, observer: &mut dyn Observer) -> Solved {
        let (problem, starts) = self.problem(scene);
        tree::solve(&problem, &starts, observer)
    }

    /// The motion that is found, with the likeliest errors of a hand unless they are told.
    pub(super) fn refined(
        &self,
        scene: Scene,
        mut solved: Solved,
        observer: &mut dyn Observer,
    ) -> Tried {
        let is_of_hand = match scene.performer {
            _ if solved.errs_in_time() => false,
            Performer::Hand => true,
            Performer::Nobody => false,
            Performer::Unsaid => solved.shows_hand(),
        };
        if is_of_hand {
            solved.refine(observer);
        }
        let passed = solved.just_passed(scene.tolerance_m);
        let estimate = self.estimate(&scene, &solved, Detail::Whole, observer);
        self.checked(scene, solved, estimate, passed, observer)
    }

    pub(super) fn estimate(
        &self,
        scene: &Scene,
        solved: &Solved,
        detail: Detail,
        observer: &mut dyn Observer,
    ) -> Estimate {
        tree::estimate(scene, self.sketch, solved, detail, observer)
    }

    fn problem(&self, scene: &Scene) -> (TreeProblem, Vec<(f64, TreeState)>) {
        let problem = TreeProblem::new(scene, self.sketch);
        let starts = initialise::tree::starts(scene, self.sketch, &problem.forest);
        (problem, starts)
    }

    fn checked(
        &self,
        scene: Scene,
        solved: Solved,
        mut estimate: Estimate,
        passed: Vec<Doubt>,
        observer: &mut dyn Observer,
    ) -> Tried {
        let found = verify::joined::check_until(
            &scene.as_estimated(&estimate),
            self.sketch,
            self.marks_made_s,
            &estimate,
            observer,
        );
        let verification = match found {
            Some(found) => {
                estimate.doubt(found.doubts.into_iter().chain(passed).collect());
                found.verification
            }
            None => {
                estimate.is_not_verified();
                None
            }
        };
        Tried {
            scene,
            estimate,
            verification,
            solved,
            evidence: OnceCell::new(),
        }
    }
}

impl Tried {
    /// What each sample costs.
    pub(super) fn cost_each(&self) -> f64 {
        self.solved.cost() / self.solved.problem.samples.len() as f64
    }

    /// Whether it is an optimum, and its contacts touch as they should: nothing else touches before, or overlaps, and
    /// what is done again from the first state agrees.
    pub(super) fn is_sound(&self) -> bool {
        let is_of_contacts = |about: About| {
            matches!(
                about,
                About::WrongFeature
                    | About::Overlap
                    | About::Gap
                    | About::Receding
                    | About::Energy
                    | About::Pull
                    | About::Steps
            )
        };
        let mut doubts = self.estimate.doubts.iter();
        self.has_ended() && !doubts.any(|doubt| is_of_contacts(doubt.about))
    }

    /// Whether it is an optimum of its problem: what else is said of it is said of that choice.
    pub(super) fn has_ended(&self) -> bool {
        self.solved.solution.finished.converged && self.estimate.objective.is_finite()
    }

    /// See [`tree::evidence`].
    pub(super) fn evidence(&self) -> Option<f64> {
        *self.evidence.get_or_init(|| tree::evidence(&self.solved))
    }

    /// Whether it is nearer to the performance than another motion, beyond what the errors of that let tell.
    pub(super) fn beats(&self, other: &Solved, evidence: impl Fn() -> Option<f64>) -> bool {
        let is_likelier = || {
            let odds = self.evidence().zip(evidence());
            odds.is_some_and(|(own, other)| own - other >= ALIKE)
        };
        self.solved.cost() <= other.cost() && is_likelier()
    }

    /// Whether it is kept rather than another one: a sound one rather than one that is not, then by its verdict, then
    /// the one nearer to the performance.
    pub(super) fn is_better(&self, other: &Self) -> bool {
        let rank = |of: &Self| -> (bool, Verdict, bool) {
            (!of.is_sound(), of.estimate.verdict, !of.has_ended())
        };
        let order = rank(self).cmp(&rank(other));
        let costs = [self, other].map(|of| of.solved.cost());
        order.then(costs[0].total_cmp(&costs[1])).is_lt()
    }
}
