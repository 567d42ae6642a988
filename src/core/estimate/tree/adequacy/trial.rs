//! A quantity set free for a trial: where its value is far off, the slope at the scene's own no longer ranks it.

use nalgebra::{DMatrix, DVector};

use super::candidates::{STEP, change};
use super::linear::{Linear, LinearChange};
use super::linearised::Linearised;
use crate::estimate::adequacy::asked::Trials;
use crate::estimate::tree::program::REGULARISER;
use crate::estimate::wander::likelihood::{FittedErrors, Restricted};
use crate::estimate::wander::series::SeriesRows;
use crate::estimate::wander::wrong::{FreedQuantity, WrongQuantity};
use crate::motion::{Observer, Quantity, Scene};

/// Greatest number of steps of Gauss and Newton,
const STEPS: usize = 12;
/// and of halvings of one.
const HALVINGS: usize = 4;
/// Steps end where one gains less than this share of the objective.
const GAIN: f64 = 1e-3;
/// Weight of rows that do not hold, per unit and information.
const ROWS: f64 = 1e3;

/// A motion of joined bodies.
pub(super) struct TreeTrials<'a> {
    pub(super) scene: &'a Scene,
    pub(super) of: &'a Linearised<'a>,
    /// How far apart samples have to be \[s\].
    pub(super) apart_s: f64,
}

/// The motion with a quantity at its likely value.
struct TriedQuantity {
    value: f64,
    linear: Linear,
    /// By the quantity, there.
    change: LinearChange,
}

impl Trials for TreeTrials<'_> {
    fn tried(
        &self,
        quantity: Quantity,
        near: &WrongQuantity,
        fixed: &FittedErrors,
        _observer: &mut dyn Observer,
    ) -> Option<WrongQuantity> {
        let given = self.scene.value_of(quantity);
        // The slope is followed from where it is told.
        let from = if near.is_told() { 0.0 } else { near.change };
        let tried = self.found(quantity, given + from)?;
        let held = tried.linear.held();
        let free = held.free.ncols() + 1;
        let mut columns: DMatrix<f64> = held.free.clone().resize_horizontally(free + 1, 0.0);
        columns.set_column(free - 1, &tried.linear.total(&held, &tried.change));
        columns.set_column(free, &tried.linear.residuals);
        let first = tried.linear.sample_rows();
        let priors = columns.rows(first, columns.nrows() - first);
        let rows = SeriesRows::new(&tried.linear.series, &columns);
        let with = Restricted {
            rows: &rows.thinned(self.apart_s),
            free,
            priors: &priors.tr_mul(&priors),
            least: REGULARISER * self.of.problem.information.0,
        };
        let fitted = with.likeliest(&fixed.errors)?;
        let change = tried.value - given;
        let sd = fitted.deviation(free - 1);
        let freed = FreedQuantity {
            change,
            sd,
            // It is the last direction itself.
            sd_per_length: sd,
            typical: quantity.typical(),
        };
        Some(near.found(&freed, [&fitted, fixed]))
    }
}

impl TreeTrials<'_> {
    /// Moves motion and quantity, from a value, to where both fit best; `None` where that leads to no motion.
    fn found(&self, quantity: Quantity, mut value: f64) -> Option<TriedQuantity> {
        let Self { scene, of, .. } = self;
        let (problem, active) = (of.problem, &of.active);
        let [lower, upper] = scene.limits_of(quantity);
        let step = STEP * quantity.typical();
        let information = problem.information;
        let merit = |of: &Linear| {
            let (cost, off) = of.merit();
            cost + ROWS * information.1 * off
        };
        let mut point = of.point.clone();
        let there = problem.with(scene, &[(quantity, value)])?;
        let mut linear = Linear::new(&there, &point, active)?;
        let mut by = change(scene, problem, &point, active, quantity, value, step)?;
        for _ in 0..STEPS {
            let (delta, off) = linear.step(&by, information.0)?;
            let mut gain = 0.0;
            let mut share = 1.0;
            for _ in 0..=HALVINGS {
                let there_value = (value + share * off).clamp(lower, upper);
                let mut there_point = point.clone();
                let delta: DVector<f64> = &delta * share;
                point.retract(problem, &delta, &mut there_point);
                let there = Linear::new(
                    &problem.with(scene, &[(quantity, there_value)])?,
                    &there_point,
                    active,
                );
                if let Some(there) = there.filter(|there| merit(there) < merit(&linear)) {
                    gain = (merit(&linear) - merit(&there)) / merit(&there);
                    (point, value, linear) = (there_point, there_value, there);
                    break;
                }
                share *= 0.5;
            }
            if gain > 0.0 {
                by = change(scene, problem, &point, active, quantity, value, step)?;
            }
            if gain < GAIN {
                break;
            }
        }
        Some(TriedQuantity {
            value,
            linear,
            change: by,
        })
    }
}
