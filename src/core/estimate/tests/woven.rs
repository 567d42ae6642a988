//! Samples that err in time, against differences and against the same without forgetting.

use nalgebra::{DMatrix, DVector};

use super::{each_case, moved};
use crate::estimate::problem::Problem;
use crate::estimate::problem::weave::Kinks;
use crate::estimate::terms::context::{Guidance, SolveContext};
use crate::estimate::terms::objective::Objective;
use crate::estimate::terms::woven;
use crate::estimate::unknowns::layout::Layout;
use crate::estimate::unknowns::point::Point;
use crate::estimate::wander::Process;
use crate::estimate::wander::likelihood::LikelyErrors;
use crate::estimate::wander::series::SeriesRows;
use crate::math::differentiate;
use crate::math::random::Random;
use crate::optimise::{Program, System};

/// A hand that errs otherwise along every kind.
const PROCESSES: [Process; 2] = [
    Process {
        smooth_sd: 1.2,
        smooth_s: 0.4,
        rough_sd: 0.2,
        rough_s: 0.1,
        noise_sd: 0.05,
    },
    Process {
        smooth_sd: 0.5,
        smooth_s: 0.2,
        rough_sd: 0.1,
        rough_s: 0.2,
        noise_sd: 0.1,
    },
];

/// Runs `check` on all cases, where samples err in time.
pub(in crate::estimate) fn each_woven(check: impl Fn(&SolveContext, &Point, &[f64])) {
    let errors = LikelyErrors::of(PROCESSES);
    each_case(1.0, |context, _, point, lengths| {
        let problem: &Problem = context.problem;
        let woven = problem.woven(&errors, Kinks::Rounded, point, &context.epochs_s);
        let layout = Layout::new(&woven);
        let context = SolveContext::new(&woven, &layout, context.epochs_s.clone(), point);
        check(&context, point, lengths);
    });
}

#[test]
fn the_gradient_is_exact_where_samples_err_in_time() {
    each_woven(|context, point, lengths| {
        let guidance = &Guidance::none();
        let size = context.layout.size();
        let exact = moved(context, guidance, point, lengths, &vec![0.0; size]).gradient;
        let numeric = differentiate::jacobian(1, size, |d| {
            vec![moved(context, guidance, point, lengths, d).cost]
        });
        let most = (0..size).fold(0.0, |most: f64, at| {
            most.max((exact[at] * lengths[at]).abs())
        });
        for at in 0..size {
            let expected = exact[at] * lengths[at];
            let error = (numeric[0][at] - expected).abs();
            assert!(
                error < 1e-6 * (1.0 + expected.abs()) + 1e-9 * most,
                "{at}: {} {expected}",
                numeric[0][at]
            );
        }
    });
}

/// A trial tells the same cost and constraints, and its derivatives when it is gone on from.
#[test]
fn a_trial_tells_what_an_evaluation_does() {
    each_woven(|context, point, _| {
        let guidance = Guidance::none();
        let here = context.evaluated(&guidance, point);
        let mut trial = System::new(context.structure());
        context.try_out(&guidance, point, &mut trial);
        assert!((trial.cost - here.cost).abs() < 1e-13 * here.cost);
        assert!(trial.values().eq(here.values()));
        assert_ne!(trial.gradient, here.gradient);
        context.differentiate(&guidance, point, &mut trial);
        assert_eq!(trial.gradient, here.gradient);
        assert_eq!(trial.cost, here.cost);
    });
}

/// What flights before tell is forgotten in the objective, and never in its rows.
#[test]
fn the_objective_has_the_products_of_its_rows() {
    let mut random = Random::default();
    let random = std::cell::RefCell::new(&mut random);
    each_woven(|context, point, lengths| {
        let size = context.layout.size();
        let directions = DMatrix::from_fn(size, 3, |row, _| {
            lengths[row] * random.borrow_mut().signed()
        });
        let weave = context.problem.weave.as_ref().expect("a weave");
        let rows = woven::rows(context, point, weave, &directions, 0.0);
        let (series, columns) = rows.expect("a body");
        let rows = SeriesRows::new(&series, &columns);
        let gram = rows.products(0, &PROCESSES[0]).gram + rows.products(1, &PROCESSES[1]).gram;
        let mut system = System::new(context.structure());
        let guidance = Guidance::none();
        Objective::new(context, &guidance, point, &mut system).add_woven(weave);
        assert!((system.cost - 0.5 * gram[(3, 3)]).abs() < 1e-9 * system.cost);
        for column in 0..3 {
            let direction: DVector<f64> = directions.column(column).into();
            let slope = direction.dot(&system.gradient);
            let scale = (gram[(column, column)] * gram[(3, 3)]).sqrt();
            assert!((slope - gram[(column, 3)]).abs() < 1e-8 * scale);
            let mut product = DVector::zeros(size);
            let pattern = &context.structure().pattern;
            system
                .hessian
                .multiply_add(pattern, &direction, &mut product);
            let square = direction.dot(&product);
            assert!((square - gram[(column, column)]).abs() < 1e-8 * square);
        }
    });
}

/// Samples near impacts are left out, and no more of a flight than a fifth at either end, to a clock's correction.
#[test]
fn samples_near_an_impact_are_left_out() {
    each_woven(|context, point, _| {
        let problem = context.problem;
        let weave = problem.weave.as_ref().expect("a weave");
        for woven in weave.hands.iter().flat_map(|hand| &hand.arcs) {
            let arc = &problem.arcs[woven.arc];
            let is_hit = |event: &usize| problem.collisions.iter().any(|of| of.event == *event);
            let hits = [arc.start, arc.end].into_iter().flatten().filter(is_hit);
            let least_s = hits.map(|event| {
                let apart = woven.samples.iter();
                let apart = apart.map(|of| {
                    let sample = &arc.views[of.view].samples[of.sample];
                    (sample.time_s(&point.node_times_s) - point.event_times_s[event]).abs()
                });
                apart.fold(f64::INFINITY, f64::min)
            });
            let lasts_s = match (arc.start, arc.end) {
                (Some(start), Some(end)) => point.event_times_s[end] - point.event_times_s[start],
                _ => f64::INFINITY,
            };
            for least_s in least_s {
                assert!(least_s >= (0.2 * lasts_s).min(0.06) - 0.002, "{least_s}");
            }
        }
    });
}
