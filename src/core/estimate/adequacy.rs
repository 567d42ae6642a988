//! Adequacy: whether the motion explains the performance.
//!
//! Contacts, impacts and goals tie flights that could each fit their samples better alone
//! (`alone`). How much worse they fit together is compared with what errors of the samples explain:
//! white noise and a wander of the hand, as the flights by themselves show it
//! ([`noise`]). Each event is tested (`event`), so that the answer names
//! where flights and model disagree. A flight that ends at no such event is tested by itself (`flight`).

mod alone;
mod event;
mod flight;
pub(super) mod hand;
mod leaning;
mod part;
mod score;
mod suspects;
pub(super) mod wandering;

use std::collections::BTreeSet;

use nalgebra::Vector3;

pub use self::leaning::leanings;

use self::alone::Alone;
use self::part::{Part, PartTest};
use self::suspects::{Errors, Which};
use crate::estimate::covariance::bins::{Bins, Residuals, Six};
use crate::estimate::covariance::noise::{self, mean_squares};
use crate::estimate::outcome;
use crate::estimate::problem::{Problem, View};
use crate::estimate::schedule::recipe::Solution;
use crate::estimate::terms::context::SolveContext;
use crate::estimate::unknowns::point::Point;
use crate::motion::{Fit, FitUntold, Fits, Observer, Performance, Performer, Suspect, Tested};

/// Below this probability of the data under the model they do not fit; above, they may.
const NOT: f64 = 1e-9;
/// Above this one they fit.
const WELL: f64 = 1e-3;
/// Above this one a wander explains so well that few are suspected.
const LIKELY: f64 = 0.1;
/// Logarithm of the odds above which the flights show a wander.
const SHOWN: f64 = 3.0;
/// Duration of flights that go along with any wander of a hand \[s\].
const SHORT_S: f64 = 0.15;
/// Deviations of a ratio of variances that are no chance.
const CHANCES: f64 = 3.0;

/// How well a solution explains its samples.
pub struct Judged {
    /// The answer and what it rests on.
    pub fit: Fit,
    /// What in the scene may be wrong where it does not fit, the likeliest first.
    pub suspects: Vec<Suspect>,
    /// From where a better optimum may be found, if something hints at one.
    pub start: Option<Point>,
}

impl From<Fit> for Judged {
    /// An answer without suspects.
    fn from(fit: Fit) -> Self {
        Self {
            fit,
            suspects: Vec::new(),
            start: None,
        }
    }
}

/// Whether samples show a hand: flights by themselves are farther from them than differences of neighbours tell, by more than
/// chance. Flights so short that they go along with any wander show it together: noise does not explain how they agree then, but
/// errors as great as the scene expects do.
pub(super) fn show_hand(context: &SolveContext, solution: &Solution) -> bool {
    let (point, system) = (&solution.point, &solution.system);
    let Some(alone) = Alone::new(context, point, system) else {
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
    let tests = tests(context, &alone, solution, &mut ());
    let count = tests.len() as f64;
    let is_noise = |test: &PartTest| count * test.fit.by_noise.probability >= WELL;
    let errors = outcome::errors(context.problem, context, point);
    let is_expected = mean_squares(&errors).iter().all(|square| *square <= 1.0);
    is_expected && !tests.iter().all(is_noise)
}

/// Whether flights by themselves are farther from their samples than noise makes them.
fn stray_alone(context: &SolveContext, alone: &Alone) -> bool {
    let white = noise::white(&alone.errors);
    let squares = mean_squares(&alone.errors);
    let flights = context.problem.seen_arcs();
    (0..2).any(|kind| {
        let of_kind = alone.errors.iter().filter(|of| of.kinds[kind]);
        let rows = 3 * of_kind.map(|of| of.each.len()).sum::<usize>();
        // Of each flight a place and a velocity are fitted, or a turn and a spin.
        let freedom = rows.saturating_sub(6 * flights) as f64;
        is_beyond_noise(squares[kind] * rows as f64, white[kind], freedom)
    })
}

/// Whether a sum of squares with so many degrees of freedom is greater than noise of a variance makes it, by more than chance.
pub(in crate::estimate) fn is_beyond_noise(square: f64, variance: f64, freedom: f64) -> bool {
    let beyond_chance = CHANCES * (4.0 / freedom.max(1.0)).sqrt();
    square > (1.0 + beyond_chance) * variance * freedom && freedom > 0.0
}

/// How well a solution explains its samples, of which `errors` are the residuals, arc by arc; and
/// where it does not, what in the scene may be wrong. Fails where samples tell too little.
pub fn judge(
    context: &SolveContext,
    solution: &Solution,
    errors: &[Residuals],
    performance: Performance,
    observer: &mut dyn Observer,
) -> Result<Judged, FitUntold> {
    let problem = context.problem;
    if let Some(weave) = &problem.weave {
        return wandering::judge(context, weave, solution, errors, performance, observer);
    }
    let alone = Alone::new(context, &solution.point, &solution.system);
    let alone = alone.ok_or(FitUntold::FewSamples)?;
    let mut tests = tests(context, &alone, solution, observer);
    if observer.should_stop() {
        return Err(FitUntold::Stopped);
    }
    if tests.is_empty() {
        return Err(FitUntold::FewSamples);
    }
    let mut fit = Fit {
        fits: Fits::Yes,
        joint: rms(problem, errors),
        alone: rms(problem, &alone.errors),
        parts: tests.iter().map(|test| test.fit.clone()).collect(),
        whole: None,
    };
    let [not, well, likely] = [NOT, WELL, LIKELY].map(|bound| {
        if problem.times_are_unknown() {
            bound * bound
        } else {
            bound
        }
    });
    let is_hand = fit.shows_wander(SHOWN);
    let is_explained = |fit: &Fit| {
        let [by_noise, by_hand] = fit.probabilities();
        by_noise >= WELL || is_hand && by_hand >= likely
    };
    if problem.times_are_unknown() && !is_explained(&fit) {
        tests = kinder(context, &alone, tests, solution, observer).ok_or(FitUntold::FewSamples)?;
        fit.parts = tests.iter().map(|test| test.fit.clone()).collect();
    }
    let [by_noise, by_hand] = fit.probabilities();
    if by_noise >= WELL {
        return Ok(fit.into());
    }
    if farther_than_rest(problem, fit.joint[0]) {
        fit.fits = Fits::No;
        return Ok(fit.into());
    }
    let mean = |of: fn(&PartTest) -> [f64; 2]| {
        [0, 1].map(|kind| tests.iter().map(|test| of(test)[kind]).sum::<f64>() / tests.len() as f64)
    };
    if problem.performer == Performer::Nobody && by_hand >= WELL {
        return Ok(fit.into());
    }
    let bins = Bins::new(problem, &solution.point);
    let hands = part::hands_like(context, &bins, mean(|test| test.wander));
    let noise = Errors {
        white: mean(|test| test.white),
        hands: &hands,
        is_likely: is_hand && by_hand >= likely,
        is_hand,
        is_unlikely: by_hand < well,
        is_beyond: by_hand < not,
        bins: &bins,
    };
    let scored = |which| suspects::scored(context, solution, performance, &noise, which);
    // What is dear to look into would show in something else too, gravity or an impact's law.
    let is_open = !is_hand
        || by_hand < likely
        || problem.times_are_unknown()
        || !scored(Which::Cheap).is_empty();
    let tried = is_open.then(|| {
        let scored = scored(Which::All);
        let solved = suspects::SolvedMotion {
            context,
            solution,
            alone: &alone,
        };
        suspects::tried(&solved, performance, scored, &noise, observer)
    });
    if observer.should_stop() {
        return Err(FitUntold::Stopped);
    }
    let (suspects, start) = tried.map_or((Vec::new(), None), |of| (of.suspects, of.start));
    fit.fits = match () {
        () if by_hand < not || problem.performer == Performer::Nobody => Fits::No,
        () if is_hand && by_hand >= well && suspects.is_empty() => Fits::Yes,
        () => Fits::Unknown,
    };
    Ok(Judged {
        fit,
        suspects,
        start,
    })
}

/// The tests of events, at the flights by themselves or as predicted at the motion, and of flights that end at none of
/// these; those that are made before the run is to end.
fn tests(
    context: &SolveContext,
    alone: &Alone,
    solution: &Solution,
    observer: &mut dyn Observer,
) -> Vec<PartTest> {
    let problem = context.problem;
    let events = 0..problem.event_is_free.len();
    let test = |event| {
        let has_time = !observer.should_stop();
        has_time.then(|| event::test(context, alone, event, &solution.multipliers))?
    };
    let mut tests: Vec<PartTest> = events.filter_map(test).collect();
    let is_tested = |arc: usize| {
        let mut parts = tests.iter().map(|test| test.part);
        parts.any(|part| matches!(part, Part::Event(event) if event::flights(problem, event).contains(&arc)))
    };
    let lone: Vec<usize> = (0..problem.arcs.len())
        .filter(|arc| !is_tested(*arc))
        .collect();
    let of_flights = lone.into_iter().filter_map(|arc| {
        let has_time = !observer.should_stop();
        has_time.then(|| flight::test(context, alone, arc))?
    });
    tests.extend(of_flights);
    tests
}

/// The tests with the kinder answers of those at the flights by themselves and of those at the motion.
fn kinder(
    context: &SolveContext,
    alone: &Alone,
    mut tests_alone: Vec<PartTest>,
    solution: &Solution,
    observer: &mut dyn Observer,
) -> Option<Vec<PartTest>> {
    let predicted = Alone::predicted(context, &solution.point, &solution.system, &alone.errors)?;
    let better = |test: &mut Tested, other: Tested| {
        if other.probability > test.probability {
            *test = other
        }
    };
    let predicted = tests(context, &predicted, solution, observer);
    for test in &mut tests_alone {
        if let Some(predicted) = predicted.iter().find(|other| other.part == test.part) {
            better(&mut test.fit.by_noise, predicted.fit.by_noise);
            better(&mut test.fit.by_hand, predicted.fit.by_hand);
        }
    }
    Some(tests_alone)
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
