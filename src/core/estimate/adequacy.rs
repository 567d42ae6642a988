//! Adequacy: whether the motion explains the performance, and what in the scene is wrong where it does not.
//!
//! Residuals are taken for errors that are a process in time: noise, and what a hand strays ([`wander`](super::wander)). A
//! quantity that the scene keeps fixed is wrong where the same residuals are much likelier with it free (`asked`). Where
//! samples were weighed one by one, the errors are told at that motion, and the flights by themselves (`alone`) tell whether
//! there was a hand at all.

mod alone;
pub(super) mod asked;
mod candidates;
mod direction;
mod leaning;
mod trial;
mod wider;

use std::collections::BTreeSet;

use nalgebra::{DMatrix, Vector3};

pub use self::leaning::leanings;

use self::alone::errors_alone;
use self::asked::{Asked, FitAsked, Trials};
use self::candidates::candidates;
use self::trial::BodyTrials;
use self::wider::{Wider, unbounded};
use crate::estimate::covariance::in_time::{InTime, Strayed};
use crate::estimate::covariance::linearised::{LinearisedSolution, free_directions};
use crate::estimate::covariance::residuals::{self, Residuals, Six, mean_squares};
use crate::estimate::outcome;
use crate::estimate::problem::weave::Weave;
use crate::estimate::problem::{Problem, View};
use crate::estimate::schedule::recipe::Solution;
use crate::estimate::terms::context::{Guidance, SolveContext};
use crate::estimate::terms::woven;
use crate::estimate::wander::Process;
use crate::estimate::wander::likelihood::{LikelyErrors, Restricted};
use crate::estimate::wander::series::SeriesRows;
use crate::motion::{Fit, FitUntold, Observer, Performance, Performer, Suspect};
use crate::optimise::Program;
use crate::optimise::kkt::Kkt;

/// Duration of flights that go along with any wander of a hand \[s\].
const SHORT_S: f64 = 0.15;
/// Deviations of a ratio of variances that are no chance.
const CHANCES: f64 = 3.0;
/// A motion that is nearer to its samples than this share of the distance of bodies that rest is not compared with these.
const FAR_SHARE: f64 = 0.5;
/// By how much `−2 log` of the likelihood of what rests may be less by chance: odds of a thousand.
const BY_CHANCE: f64 = 13.8;

/// Whether samples show a hand: flights by themselves are farther from them than differences of neighbours tell, by more than
/// chance. Flights so short that they go along with any wander show it together: noise does not explain how they agree then, but
/// errors as great as the scene expects do.
pub(super) fn show_hand(context: &SolveContext, solution: &Solution) -> bool {
    let (point, system) = (&solution.point, &solution.system);
    let Some(alone) = errors_alone(context, point, system) else {
        return false;
    };
    if stray_alone(context, &alone) {
        return true;
    }
    let mut arcs = context.problem.arcs.iter();
    let longest_s = arcs.try_fold(0.0, |longest_s: f64, arc| {
        let [first, last] = arc.ends()?.map(|sample| sample.time_s(&point.node_times_s));
        Some(longest_s.max(last - first))
    });
    if longest_s.is_none_or(|longest_s| longest_s > SHORT_S) {
        return false;
    }
    let white = residuals::white(&alone);
    let errors = outcome::errors(context.problem, context, point);
    let squares = mean_squares(&errors);
    let is_noise = (0..2).all(|kind| {
        let rows = row_count(&errors, kind) as f64;
        !is_beyond_noise(squares[kind] * rows, white[kind], rows)
    });
    squares.iter().all(|square| *square <= 1.0) && !is_noise
}

/// Whether flights by themselves are farther from their samples than noise makes them.
fn stray_alone(context: &SolveContext, alone: &[Residuals]) -> bool {
    let white = residuals::white(alone);
    let squares = mean_squares(alone);
    let flights = context.problem.seen_arcs();
    (0..2).any(|kind| {
        let rows = row_count(alone, kind);
        // Of each flight a place and a velocity are fitted, or a turn and a spin.
        let freedom = rows.saturating_sub(6 * flights) as f64;
        is_beyond_noise(squares[kind] * rows as f64, white[kind], freedom)
    })
}

/// Number of residuals of a kind.
fn row_count(errors: &[Residuals], kind: usize) -> usize {
    let of_kind = errors.iter().filter(|of| of.kinds[kind]);
    3 * of_kind.map(|of| of.each.len()).sum::<usize>()
}

/// Whether a sum of squares with so many degrees of freedom is greater than noise of a variance makes it, by more than chance.
fn is_beyond_noise(square: f64, variance: f64, freedom: f64) -> bool {
    let beyond_chance = CHANCES * (4.0 / freedom.max(1.0)).sqrt();
    square > (1.0 + beyond_chance) * variance * freedom && freedom > 0.0
}

/// Most times of nodes that are unknown beside errors that samples share: all of a flight are told of together, which takes memory in
/// proportion to the square of their number.
const NODES_MOST: usize = 3000;

/// Whether there are more.
fn has_many_nodes(problem: &Problem) -> bool {
    problem.times_are_unknown() && problem.nodes_acted_s.len() > NODES_MOST
}

/// A motion whose samples were weighed one by one with the errors that they show; `None` where errors of a hand were told as it
/// was found, and where residuals tell nothing of them.
pub fn in_time(context: &SolveContext, solution: &Solution) -> Option<InTime> {
    if context.problem.weave.is_some() || has_many_nodes(context.problem) {
        return None;
    }
    let strayed = match context.problem.performer {
        Performer::Nobody => Strayed::Tracker,
        Performer::Unsaid if !show_hand(context, solution) => Strayed::NoHand,
        Performer::Hand | Performer::Unsaid => Strayed::MaybeHand,
    };
    InTime::likely(context, solution, strayed)
}

/// How well a solution explains its samples, of which `errors` are the residuals, arc by arc; and where it does not, what in
/// the scene may be wrong. Fails where samples tell too little, and where the observer stops it.
pub(super) fn judge(
    (context, solution, in_time): (&SolveContext, &Solution, Option<&InTime>),
    errors: &[Residuals],
    performance: Performance,
    of_fit: FitAsked,
    observer: &mut dyn Observer,
) -> Result<(Fit, Vec<Suspect>), FitUntold> {
    if let Some(weave) = &context.problem.weave {
        let told = ToldMotion {
            context,
            weave,
            solution,
            likely: &weave.errors,
            strayed: Strayed::Hand,
            trials: None,
            of_fit,
        };
        return told.judged(errors, performance, observer);
    }
    let in_time = in_time.ok_or(match has_many_nodes(context.problem) {
        true => FitUntold::ManySamples,
        false => FitUntold::FewSamples,
    })?;
    let (own, there) = in_time.at(context, solution);
    let told = ToldMotion {
        context: &own,
        weave: in_time.weave(),
        solution: &there,
        likely: &in_time.wandering,
        strayed: in_time.strayed,
        trials: (!in_time.strayed.may_be_hand()).then_some(BodyTrials {
            context,
            solution,
            performance,
        }),
        of_fit,
    };
    told.judged(errors, performance, observer)
}

/// A motion with the errors of its samples.
struct ToldMotion<'a> {
    context: &'a SolveContext<'a>,
    weave: &'a Weave,
    solution: &'a Solution,
    likely: &'a LikelyErrors,
    strayed: Strayed,
    trials: Option<BodyTrials<'a>>,
    of_fit: FitAsked,
}

impl ToldMotion<'_> {
    fn judged(
        &self,
        errors: &[Residuals],
        performance: Performance,
        observer: &mut dyn Observer,
    ) -> Result<(Fit, Vec<Suspect>), FitUntold> {
        let (scene, context, solution) = (performance.scene, self.context, self.solution);
        let kkt = Kkt::new(context, &solution.system, &solution.multipliers);
        let kkt = kkt.ok_or(FitUntold::FewSamples)?;
        let free = free_directions(context, &solution.system, &kkt).ok_or(FitUntold::FewSamples)?;
        let quantities = candidates(scene, self.strayed);
        let added = quantities
            .iter()
            .map(|quantity| unbounded(scene, *quantity));
        let wider = Wider::new(context, performance, added.collect());
        let point = wider.point(&solution.point);
        let epochs_s = context.epochs_s.clone();
        let extended = SolveContext::new(&wider.problem, &wider.layout, epochs_s, &point);
        let system = extended.evaluated(&Guidance::none(), &point);
        let further = direction::directions(&extended, &system, context, &kkt, wider.first);
        let count = free.ncols();
        let mut directions = DMatrix::zeros(extended.layout.size(), count + further.len());
        directions.view_mut((0, 0), free.shape()).copy_from(&free);
        for (at, direction) in further.iter().enumerate() {
            directions.set_column(count + at, direction);
        }
        let linearised = LinearisedSolution::new(&extended, &point, &directions, count, 0.0);
        let linearised = linearised.ok_or(FitUntold::FewSamples)?;
        let restricted = linearised.restricted();
        let joint = rms(context.problem, errors);
        let may_rest = farther_than_rest(context.problem, joint[0] / FAR_SHARE);
        let asked = Asked {
            of_fit: self.of_fit,
            scene,
            quantities: &quantities,
            joint,
            is_far: may_rest && self.is_likelier_at_rest(restricted.rows),
            strayed: self.strayed,
            trials: self.trials.as_ref().map(|of| of as &dyn Trials),
        };
        let fitted = restricted.at(self.likely);
        let fitted = fitted.ok_or(FitUntold::FewSamples)?;
        asked.judged(&restricted, &fitted, observer)
    }

    /// Whether places that samples show are likelier of bodies that rest, with their likeliest errors, than of the motion: no
    /// one quantity is to blame for that. How far a hand strays does not tell it, for one that strays far from small motions
    /// shows these all the same.
    fn is_likelier_at_rest(&self, rows: &SeriesRows) -> bool {
        let likeliest = || {
            let (series, columns) = woven::places(self.context, &self.solution.point, self.weave)?;
            let places = SeriesRows::new(&series, &columns);
            let size = columns.ncols();
            let at_rest = Restricted {
                rows: &places,
                free: size - 1,
                priors: &DMatrix::zeros(size, size),
                least: 0.0,
            };
            let at_rest = at_rest.likeliest(&LikelyErrors::EXPECTED)?;
            let moving = Restricted {
                rows: &rows.of_kind(0).select(&[rows.count() - 1]),
                free: 0,
                priors: &DMatrix::zeros(1, 1),
                least: 0.0,
            };
            let moving = moving.at(&LikelyErrors::of([
                self.likely.processes[0],
                Process::EXPECTED,
            ]))?;
            // Restricted likelihoods of other means are not comparable.
            let at_rest = at_rest.merit - at_rest.information.ln_determinant();
            Some(at_rest + BY_CHANCE < moving.merit)
        };
        rows.shows(0) && likeliest().unwrap_or(false)
    }
}

/// Whether motions are farther from the samples than bodies that rest at their mean places would be: no
/// one quantity is to blame for that.
fn farther_than_rest(problem: &Problem, distance_m: f64) -> bool {
    let is_placed = |(_, view): &(usize, &View)| view.kinds()[0] && !view.samples.is_empty();
    let views = problem.views().filter(is_placed).map(|(_, view)| view);
    let (mut squares_m2, mut samples) = (0.0, 0);
    for track in views
        .clone()
        .map(|view| view.track)
        .collect::<BTreeSet<_>>()
    {
        let of_track = views.clone().filter(|view| view.track == track);
        let places = of_track
            .flat_map(|view| &view.samples)
            .map(|s| s.position_m);
        let count = places.clone().count();
        let mean = places.clone().sum::<Vector3<f64>>() / count as f64;
        let squares = places.map(|place| (place - mean).norm_squared());
        squares_m2 += squares.sum::<f64>();
        samples += count;
    }
    distance_m * distance_m * samples as f64 > squares_m2
}

/// Root mean square of distances \[m\] and angles \[rad\], in the scene's units where samples are
/// whitened.
fn rms(problem: &Problem, errors: &[Residuals]) -> [f64; 2] {
    let units = [problem.position_unit_m, problem.orientation_unit_rad];
    let scaled = problem.views().zip(errors).map(|((_, view), of)| {
        let factors = [0, 1].map(|kind| match view.units[kind] {
            unit if unit.is_finite() => unit / units[kind],
            _ => 0.0,
        });
        let scale = |six: &Six| std::array::from_fn(|axis| six[axis] * factors[axis / 3]);
        Residuals {
            kinds: of.kinds,
            each: of.each.iter().map(scale).collect(),
        }
    });
    let squares = mean_squares(&scaled.collect::<Vec<_>>());
    [0, 1].map(|kind| (3.0 * squares[kind]).sqrt() * units[kind])
}
