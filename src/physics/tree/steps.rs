//! How many steps a flow needs: chosen once and kept while something is solved for, so that the flow stays
//! one smooth function.

use super::flow::Flow;

/// Most steps that are tried.
const MOST: usize = 1 << 14;

impl Flow<'_> {
    /// Number of steps with which `duration_s` from the state now errs by less than `tolerance` in
    /// every angular coordinate \[rad\] and rate [rad/s], by comparing each number with its double; none
    /// where no number of steps up to thousands does. The flow stays where it is.
    pub fn steps(&mut self, duration_s: f64, tolerance: f64) -> Option<usize> {
        let kept = (self.state.clone(), self.has_derivatives);
        self.has_derivatives = false;
        let mut run = |steps: usize| {
            self.state.copy_from_slice(&kept.0);
            self.turn(duration_s, steps, 0.0);
            self.state.clone()
        };
        let mut steps = 1;
        let mut coarse = run(steps);
        let mut found = None;
        while steps <= MOST {
            let fine = run(2 * steps);
            let differs = |(a, b): (&f64, &f64)| !((a - b).abs() < tolerance);
            if !coarse.iter().zip(&fine).any(differs) {
                found = Some(steps);
                break;
            }
            (steps, coarse) = (2 * steps, fine);
        }
        (self.state, self.has_derivatives) = kept;
        found
    }
}
