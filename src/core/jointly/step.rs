//! A step within the bounds.

use nalgebra::{DMatrix, DVector};

use super::parameter::JointParameter;
use super::part::Total;
use super::weak::without;

/// How much directions that are not determined are held, relative to the greatest information.
const HELD: f64 = 1e6;

/// From where a step goes, and what holds it; in lengths.
pub(super) struct BoundedStep<'a> {
    pub(super) parameters: &'a [JointParameter],
    pub(super) mean: &'a DVector<f64>,
    /// Directions that are not determined.
    pub(super) held: &'a DMatrix<f64>,
}

impl BoundedStep<'_> {
    /// Newton's step within the bounds; directions that are not determined stay. Bounds that the step meets hold it
    /// (Nocedal and Wright, *Numerical Optimization*, chapter 16).
    pub(super) fn newton(&self, total: &Total) -> Option<DVector<f64>> {
        let count = self.parameters.len();
        let held = self.held;
        let open = without(held);
        let most = total.information.diagonal().amax().max(1.0);
        let information =
            &open * &total.information * &open + held * held.transpose() * (HELD * most);
        let gradient = &open * &total.gradient;
        // Each bounded parameter moves to its bound, or is free.
        let mut fixed: Vec<Option<f64>> = self.at_bounds(&gradient);
        for _ in 0..=2 * count {
            let step = constrained(&information, &gradient, &fixed)?;
            let broken = self.parameters.iter().enumerate().filter_map(|(at, of)| {
                let [lower, upper] = of.bounds().map(|bound| bound - self.mean[at]);
                let beyond = (step[at] - upper).max(lower - step[at]);
                let to = if step[at] > upper { upper } else { lower };
                (fixed[at].is_none() && beyond > 1e-13).then_some((at, to, beyond))
            });
            match broken.max_by(|a, b| a.2.total_cmp(&b.2)) {
                Some((at, to, _)) => fixed[at] = Some(to),
                None => return Some(step),
            }
        }
        None
    }

    /// Parameters at a bound beyond which the objective falls: they stay there.
    fn at_bounds(&self, gradient: &DVector<f64>) -> Vec<Option<f64>> {
        let near = 1e-12;
        let each = self.parameters.iter().enumerate().map(|(at, of)| {
            let [lower, upper] = of.bounds().map(|bound| bound - self.mean[at]);
            let is_held =
                lower >= -near && gradient[at] > 0.0 || upper <= near && gradient[at] < 0.0;
            is_held.then_some(0.0)
        });
        each.collect()
    }
}

/// The least of a quadratic model where some unknowns are given.
fn constrained(
    information: &DMatrix<f64>,
    gradient: &DVector<f64>,
    fixed: &[Option<f64>],
) -> Option<DVector<f64>> {
    let given = fixed.iter().map(|of| of.unwrap_or(0.0));
    let mut step = DVector::from_iterator(fixed.len(), given);
    let free: Vec<usize> = (0..fixed.len()).filter(|at| fixed[*at].is_none()).collect();
    if free.is_empty() {
        return Some(step);
    }
    let slope = gradient + information * &step;
    let inner = information.select_rows(&free).select_columns(&free);
    let solved = inner.cholesky()?.solve(&slope.select_rows(&free));
    for (at, by) in free.iter().zip(solved.iter()) {
        step[*at] = -by;
    }
    Some(step)
}
