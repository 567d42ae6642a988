//! A motion whose samples were weighed one by one, as if they erred in time: with the errors that its residuals make likely.

use nalgebra::{DMatrix, DVector};

use super::linearised::{LinearisedSolution, free_count, free_directions};
use crate::estimate::problem::Problem;
use crate::estimate::problem::weave::{Kink, Kinks, Weave};
use crate::estimate::schedule::recipe::Solution;
use crate::estimate::terms::context::{Guidance, SolveContext};
use crate::estimate::terms::woven;
use crate::estimate::unknowns::layout::Layout;
use crate::estimate::unknowns::point::Point;
use crate::estimate::wander::Process;
use crate::estimate::wander::kink::led_off_s;
use crate::estimate::wander::likelihood::{APART_S, LikelyErrors, NoiseAlone, Restricted};
use crate::estimate::wander::series::Series;
use crate::estimate::wander::spread::spread;
use crate::optimise::Program;
use crate::optimise::kkt::Kkt;

/// What samples err by beside noise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::estimate) enum Strayed {
    /// A hand, with whose errors the motion was found.
    Hand,
    /// Perhaps a hand: each sample was weighed by itself.
    MaybeHand,
    /// No hand: flights by themselves show none.
    NoHand,
    /// A tracker alone: the scene says that there was no hand.
    Tracker,
}

impl Strayed {
    /// Whether a hand may have.
    pub(in crate::estimate) fn may_be_hand(self) -> bool {
        match self {
            Strayed::Hand | Strayed::MaybeHand => true,
            Strayed::NoHand | Strayed::Tracker => false,
        }
    }

    /// How far apart samples have to be to tell what is wrong \[s\]: nearer ones tell little more of a hand.
    pub(in crate::estimate) fn apart_s(self) -> f64 {
        match self.may_be_hand() {
            true => APART_S,
            false => 0.0,
        }
    }
}

/// The problem of a motion whose samples were weighed one by one, where they err in time.
#[derive(Clone, Debug)]
pub struct InTime {
    problem: Problem,
    layout: Layout,
    /// Where a hand may have strayed, with the samples near kinks too: the motion was found by them.
    near_kinks: Option<Problem>,
    /// Who may have strayed.
    pub(in crate::estimate) strayed: Strayed,
    /// The likeliest errors, with a wander.
    pub(in crate::estimate) wandering: LikelyErrors,
    /// The errors that samples have: noise alone where it explains them.
    errors: [Process; 2],
}

impl InTime {
    /// With errors as they are expected before anything is seen.
    pub(in crate::estimate) fn expected(
        context: &SolveContext,
        solution: &Solution,
        strayed: Strayed,
    ) -> Self {
        let kinks = match strayed.may_be_hand() {
            true => Kinks::Rounded,
            false => Kinks::Sharp,
        };
        let expected = LikelyErrors::EXPECTED;
        let (point, epochs_s) = (&solution.point, &context.epochs_s);
        let problem = context.problem.woven(&expected, kinks, point, epochs_s);
        Self {
            layout: Layout::new(&problem),
            problem,
            near_kinks: None,
            strayed,
            wandering: expected,
            errors: [Process::EXPECTED; 2],
        }
    }

    /// With the likeliest errors; `None` where residuals tell nothing of them.
    pub(in crate::estimate) fn likely(
        context: &SolveContext,
        solution: &Solution,
        strayed: Strayed,
    ) -> Option<Self> {
        let expected = Self::expected(context, solution, strayed);
        let (own, there) = expected.at(context, solution);
        let told = Told::new(&own, &there, 0.0)?;
        let restricted = told.restricted();
        if !restricted.is_told() {
            return None;
        }
        let wandering = restricted.likeliest(&LikelyErrors::EXPECTED)?;
        let alone = NoiseAlone::of(&restricted, &wandering)?;
        let is_noise = alone.explains();
        let errors = match is_noise {
            true => alone.fitted.errors,
            false => wandering.errors,
        };
        let near_kinks = (strayed.may_be_hand() && !is_noise).then(|| {
            let (point, epochs_s) = (&solution.point, &context.epochs_s);
            let errors = LikelyErrors::EXPECTED;
            context
                .problem
                .woven(&errors, Kinks::Sharp, point, epochs_s)
        });
        Some(Self {
            wandering: told.lacking(wandering.errors),
            errors: told.lacking(errors).processes,
            near_kinks,
            ..expected
        })
    }

    /// Standard deviations of noise along an axis, of positions and of turns, in units.
    pub fn noise_sds(&self) -> [f64; 2] {
        self.errors.map(|of| of.noise_sd)
    }

    /// What the errors of samples make of answers of the unknowns to them, a column each: `Yᵀ V Y` with `Y = J X`, and where a hand
    /// may have rounded kinks, as far as that leads them off together. `None` where the parameters make no body.
    pub(in crate::estimate) fn spread(
        &self,
        context: &SolveContext,
        point: &Point,
        answers: &DMatrix<f64>,
    ) -> Option<DMatrix<f64>> {
        let epochs_s = context.epochs_s.clone();
        let problem = self.near_kinks.as_ref().unwrap_or(&self.problem);
        let weave = problem.weave.as_ref().expect("it is woven");
        let own = SolveContext::new(problem, &self.layout, epochs_s, point);
        let (series, rows) = woven::rows(&own, point, weave, answers, 0.0)?;
        let changes = rows.columns(0, answers.ncols()).into_owned();
        let mut all = spread(&series, &changes, &self.errors);
        // In an unknown tempo nobody knows when a hand rounds.
        if self.near_kinks.is_some() && !problem.times_are_unknown() {
            for hand in &weave.hands {
                let is_own = |arc| hand.arcs.iter().any(|of| of.arc == arc);
                let of_hand = || series.iter().filter(|of| of.track == hand.track);
                for kink in problem.kinks(is_own, point, &own.epochs_s) {
                    let led_off = led_off(&kink, of_hand(), &changes);
                    all += &led_off * led_off.transpose();
                }
            }
        }
        Some(all)
    }

    /// Which samples err together.
    pub(in crate::estimate) fn weave(&self) -> &Weave {
        self.problem.weave.as_ref().expect("it is woven")
    }

    /// The same solution in this problem.
    pub fn at(&self, context: &SolveContext, solution: &Solution) -> (SolveContext<'_>, Solution) {
        let epochs_s = context.epochs_s.clone();
        let own = SolveContext::new(&self.problem, &self.layout, epochs_s, &solution.point);
        let system = own.evaluated(&Guidance::none(), &solution.point);
        let solution = Solution {
            system,
            ..solution.clone()
        };
        (own, solution)
    }
}

/// How far answers are led off where a hand rounds a kink: by its samples, of which `changes` has the rows, a column for each
/// answer.
fn led_off<'s>(
    kink: &Kink,
    series: impl Iterator<Item = &'s Series>,
    changes: &DMatrix<f64>,
) -> DVector<f64> {
    let mut sum = DVector::zeros(changes.ncols());
    for of in series {
        for (taken, row) in of.taken.iter().zip(&of.rows) {
            let by = led_off_s(taken.time_s - kink.time_s) / of.unit;
            sum += changes.rows(*row, 3).tr_mul(&kink.jumps[of.kind]) * by;
        }
    }
    sum
}

/// Residuals of a motion whose samples err in time, along what it may follow. Where that are too many directions, residuals are
/// taken as they are, and errors made greater by what they lack for having been fitted.
struct Told {
    linearised: LinearisedSolution,
    lacking: f64,
}

impl Told {
    /// Of samples at least so far apart \[s\].
    fn new(context: &SolveContext, solution: &Solution, apart_s: f64) -> Option<Self> {
        let (point, system) = (&solution.point, &solution.system);
        let kkt = Kkt::new(context, system, &solution.multipliers)?;
        let free = free_directions(context, system, &kkt);
        let is_told = free.is_some();
        let directions = free.unwrap_or_else(|| DMatrix::zeros(context.layout.size(), 0));
        let count = directions.ncols();
        // What many directions lack is told of all samples.
        let kept_s = if is_told { apart_s } else { 0.0 };
        let linearised = LinearisedSolution::new(context, point, &directions, count, kept_s)?;
        let rows = (3 * linearised.restricted().rows.samples()) as f64;
        let left = rows - free_count(context, system) as f64;
        Some(Self {
            lacking: match is_told {
                true => 1.0,
                false => (rows / left.max(1.0)).sqrt(),
            },
            linearised,
        })
    }

    fn restricted(&self) -> Restricted<'_> {
        self.linearised.restricted()
    }

    fn lacking(&self, errors: LikelyErrors) -> LikelyErrors {
        errors.times(self.lacking)
    }
}

/// The errors that a motion's residuals make likeliest, of samples at least so far apart \[s\]; `None` where they tell nothing of
/// them.
pub(in crate::estimate) fn likely(
    context: &SolveContext,
    solution: &Solution,
    from: &LikelyErrors,
    apart_s: f64,
) -> Option<LikelyErrors> {
    let told = Told::new(context, solution, apart_s)?;
    let likely = told.restricted().likely(from, apart_s)?;
    Some(told.lacking(likely))
}
