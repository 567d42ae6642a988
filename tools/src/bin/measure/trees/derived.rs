//! What the program's own steps come to, and what derivatives cost.

use std::hint::black_box;

use enact::estimate::tree::{EXACTLY, ROUGHLY};
use enact::physics::tree::tableau::DORMAND_PRINCE;
use enact::physics::tree::{Flow, TreeState};
use nalgebra::DMatrix;
use serde::Serialize;

use super::Known;
use super::cases::Case;
use crate::flow::time_s;
use crate::statistics::median;

/// Samples per second at which states are told.
const SAMPLES_HZ: f64 = 120.0;
/// How many times as short steps are of which states at samples are told for comparison.
const FINER: f64 = 16.0;
/// How often plain flows and those with derivatives are timed.
const TURNS: usize = 3;

/// A motion in the steps that the estimator makes, told at every sample: medians.
#[derive(Serialize)]
pub struct Steps {
    /// Number of steps.
    pub steps: f64,
    /// The greatest at any sample.
    pub error: f64,
    /// Of the energy.
    pub drift: f64,
    /// Without derivatives \[s\].
    pub plain_s: f64,
    /// With them \[s\].
    pub derived_s: f64,
    /// Of the two times, seed by seed.
    pub ratio: f64,
}

/// Both that the estimator has.
#[derive(Serialize)]
pub struct Derived {
    /// Of what is kept.
    pub exact: Steps,
    /// On the way there.
    pub rough: Steps,
}

impl Derived {
    /// Of motions.
    pub fn of(known: &[Known], quick: bool) -> Self {
        Self {
            exact: derived(known, EXACTLY, quick),
            rough: derived(known, ROUGHLY, quick),
        }
    }
}

/// How long the estimator's steps are \[s\].
fn step_s(case: &Case, [most_s, turn_rad]: [f64; 2]) -> f64 {
    let flight = case.tree.translations();
    let mut flow = Flow::new(&case.tree, &case.gravity_m_s2, DORMAND_PRINCE);
    flow.begin(&case.start, false);
    let mut fastest_rad_s = 0.0_f64;
    for _ in 0..=samples(case) {
        let state = flow.state();
        let rates = state.rates[flight..].iter();
        fastest_rad_s = rates.fold(fastest_rad_s, |most, rate| most.max(rate.abs()));
        flow.advance(1.0 / SAMPLES_HZ, 8);
    }
    case.duration_s / (case.duration_s / most_s.min(turn_rad / fastest_rad_s)).ceil()
}

fn samples(case: &Case) -> usize {
    (case.duration_s * SAMPLES_HZ).round() as usize
}

/// The motion plain and with derivatives by the start, at every sample.
fn derived(known: &[Known], rule: [f64; 2], quick: bool) -> Steps {
    let mut of = [(); 6].map(|()| Vec::new());
    for one in known {
        let case = &one.case;
        let step_s = step_s(case, rule);
        let mut flow = Flow::new(&case.tree, &case.gravity_m_s2, DORMAND_PRINCE);
        let size = 2 * case.tree.freedoms();
        let mut jacobian = DMatrix::zeros(size, size);
        let mut timed = |has_derivatives: bool| {
            time_s(quick, || {
                flow.begin(black_box(&case.start), has_derivatives);
                for sample in 1..=samples(case) {
                    flow.reach(sample as f64 / SAMPLES_HZ, step_s);
                    black_box(flow.state());
                    if has_derivatives {
                        flow.jacobian(&mut jacobian);
                        black_box(&jacobian);
                    }
                }
            })[0]
        };
        // In turns, for what else the machine does.
        let (mut plain_s, mut derived_s) = (f64::INFINITY, f64::INFINITY);
        for _ in 0..TURNS {
            plain_s = plain_s.min(timed(false));
            derived_s = derived_s.min(timed(true));
        }
        let (told, finer) = (told(case, step_s), told(case, step_s / FINER));
        let apart = told.iter().zip(&finer).map(|(a, b)| case.apart(a, b));
        let numbers = [
            (case.duration_s / step_s).round(),
            apart.fold(0.0, f64::max),
            one.drift(&told[told.len() - 1]),
            plain_s,
            derived_s,
            derived_s / plain_s,
        ];
        for (to, number) in of.iter_mut().zip(numbers) {
            to.push(number);
        }
    }
    let [steps, error, drift, plain_s, derived_s, ratio] =
        of.each_ref().map(|numbers| median(numbers));
    Steps {
        steps,
        error,
        drift,
        plain_s,
        derived_s,
        ratio,
    }
}

/// States at every sample.
fn told(case: &Case, step_s: f64) -> Vec<TreeState> {
    let mut flow = Flow::new(&case.tree, &case.gravity_m_s2, DORMAND_PRINCE);
    flow.begin(&case.start, false);
    let mut state = |sample: usize| {
        flow.reach(sample as f64 / SAMPLES_HZ, step_s);
        flow.state()
    };
    (1..=samples(case)).map(&mut state).collect()
}
