//! Quantities set free for a trial: where a value is far off, the slope at the scene's own no longer ranks it.

use nalgebra::DVector;

use super::asked::Trials;
use super::wider::Wider;
use crate::estimate::covariance::in_time::{InTime, Strayed};
use crate::estimate::covariance::linearised::{LinearisedSolution, free_directions};
use crate::estimate::schedule::recipe::{self, Recipe, Solution};
use crate::estimate::terms::context::SolveContext;
use crate::estimate::wander::likelihood::FittedErrors;
use crate::estimate::wander::wrong::{FreedQuantity, WrongQuantity};
use crate::motion::{Observer, Performance, Quantity, Quiet};
use crate::optimise::Schedule;
use crate::optimise::finish::Tolerances;
use crate::optimise::kkt::Kkt;

/// Length of a derivative that is none.
const LIMIT: f64 = 1e-12;
/// Least gain of `−2 log L` that tells a width.
const GAIN: f64 = 1e-9;

/// A motion whose samples were weighed one by one, and that no hand acted.
pub(super) struct BodyTrials<'a> {
    pub(super) context: &'a SolveContext<'a>,
    pub(super) solution: &'a Solution,
    pub(super) performance: Performance<'a>,
}

impl Trials for BodyTrials<'_> {
    fn tried(
        &self,
        quantity: Quantity,
        near: &WrongQuantity,
        fixed: &FittedErrors,
        observer: &mut dyn Observer,
    ) -> Option<WrongQuantity> {
        let Self {
            context,
            solution,
            performance,
        } = self;
        let scene = performance.scene;
        let [lower, upper] = scene.limits_of(quantity);
        let given = scene.value_of(quantity);
        let from = (given + near.change).clamp(lower, upper);
        let wider = Wider::new(context, *performance, vec![scene.freed(quantity, from)]);
        let found = recipe::solve_from(
            &wider.problem,
            &wider.layout,
            wider.point(&solution.point),
            context.epochs_s.clone(),
            &Recipe::of(schedule()),
            &mut Quiet(observer),
        );
        if !found.finished.converged {
            return None;
        }
        let epochs_s = context.epochs_s.clone();
        let own = SolveContext::new(&wider.problem, &wider.layout, epochs_s, &found.point);
        let in_time = InTime::expected(&own, &found, Strayed::NoHand);
        let (own, there) = in_time.at(&own, &found);
        let kkt = Kkt::new(&own, &there.system, &there.multipliers)?;
        let free = free_directions(&own, &there.system, &kkt)?;
        let linearised = LinearisedSolution::new(&own, &there.point, &free, free.ncols(), 0.0)?;
        let restricted = linearised.restricted();
        let fitted = restricted.likeliest(&fixed.errors)?;
        let along: DVector<f64> = free.row(own.layout.parameters[wider.first]).transpose();
        let value = there.point.parameters[wider.first];
        let change = value - given;
        let (sd, sd_per_length) = match along.norm() < LIMIT {
            // It stays at its limit: what it gains tells how wide it is.
            true => (
                change.abs() / (fixed.merit - fitted.merit).max(GAIN).sqrt(),
                1.0,
            ),
            false => {
                let sd = along.dot(&fitted.information.solve(&along)).sqrt();
                (sd, sd / along.norm())
            }
        };
        let freed = FreedQuantity {
            change,
            sd,
            sd_per_length,
            typical: quantity.typical(),
        };
        Some(near.found(&freed, [&fitted, fixed]))
    }
}

/// To compare likelihoods a few digits are enough, and what needs more steps than this is no explanation.
fn schedule() -> Schedule {
    Schedule {
        multiplier_rounds: (4, 10),
        retries: 0,
        tolerances: Tolerances {
            violation: 1e-6,
            decrease: 1e-6,
            steps: 15,
        },
        ..Schedule::default()
    }
}
