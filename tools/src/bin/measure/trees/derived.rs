//! What the program's own steps come to, and what derivatives cost.

use std::hint::black_box;

use enact::physics::tree::Flow;
use enact::physics::tree::tableau::{DORMAND_PRINCE, Tableau};
use nalgebra::DMatrix;
use serde::Serialize;

use super::Known;
use super::cases::Case;
use crate::flow::time_s;
use crate::statistics::median;

/// Samples per second that the estimator stops at, and its longest turn in a step \[rad\].
const SAMPLES_HZ: f64 = 120.0;
const STEP_RAD: f64 = 0.25;
/// How often plain flows and those with derivatives are timed.
const TURNS: usize = 3;
/// A method of the program in the steps that the estimator makes: medians.
#[derive(Serialize)]
pub struct Steps {
    /// At the end.
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
    pub order_8: Steps,
    /// Of first guesses.
    pub order_6: Steps,
}

/// How many steps the estimator makes: from sample to sample, none longer than its rule says.
pub fn steps(case: &Case) -> usize {
    let samples = (case.duration_s * SAMPLES_HZ).round() as usize;
    let flight = case.tree.freedoms() - case.tree.angular_freedoms();
    let mut flow = Flow::new(&case.tree, &case.gravity_m_s2, DORMAND_PRINCE);
    flow.begin(&case.start, false);
    let mut fastest_rad_s = 0.0_f64;
    for _ in 0..=samples {
        let state = flow.state();
        let rates = state.rates[flight..].iter();
        fastest_rad_s = rates.fold(fastest_rad_s, |most, rate| most.max(rate.abs()));
        flow.advance(1.0 / SAMPLES_HZ, 8, 0.0);
    }
    samples * (fastest_rad_s / SAMPLES_HZ / STEP_RAD).ceil().max(1.0) as usize
}

/// A method in the estimator's steps, plain and with derivatives by the start and by time.
pub fn derived(known: &[Known], tableau: Tableau, quick: bool) -> Steps {
    let mut of = [(); 5].map(|()| Vec::new());
    for one in known {
        let case = &one.case;
        let mut flow = Flow::new(&case.tree, &case.gravity_m_s2, tableau);
        let size = 2 * case.tree.freedoms();
        let mut jacobian = DMatrix::zeros(size, size + 1);
        let mut timed = |has_derivatives: bool| {
            time_s(quick, || {
                flow.begin(black_box(&case.start), has_derivatives);
                flow.advance(case.duration_s, one.steps, f64::from(has_derivatives));
                black_box(flow.state());
                if has_derivatives {
                    flow.jacobian(&mut jacobian);
                    black_box(&jacobian);
                }
            })[0]
        };
        // In turns, for what else the machine does.
        let (mut plain_s, mut derived_s) = (f64::INFINITY, f64::INFINITY);
        for _ in 0..TURNS {
            plain_s = plain_s.min(timed(false));
            derived_s = derived_s.min(timed(true));
        }
        let end = case.flown(tableau, one.steps);
        let numbers = [
            case.apart(&end, &one.end),
            one.drift(&end),
            plain_s,
            derived_s,
            derived_s / plain_s,
        ];
        for (to, number) in of.iter_mut().zip(numbers) {
            to.push(number);
        }
    }
    let [error, drift, plain_s, derived_s, ratio] = of.each_ref().map(|numbers| median(numbers));
    Steps {
        error,
        drift,
        plain_s,
        derived_s,
        ratio,
    }
}
