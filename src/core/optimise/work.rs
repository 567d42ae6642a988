//! Counts of the work of a solve.

/// Counts of the work of a solve.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Work {
    /// Steps computed, in descents and in finishes.
    pub iterations: usize,
    /// Evaluations of cost, constraints and derivatives.
    pub evaluations: usize,
    /// Matrix factorisations.
    pub factorisations: usize,
}

impl Work {
    /// Adds the counts of another solve.
    pub fn add(&mut self, other: &Self) {
        self.iterations += other.iterations;
        self.evaluations += other.evaluations;
        self.factorisations += other.factorisations;
    }
}
