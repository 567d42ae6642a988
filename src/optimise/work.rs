//! What solving took.

/// Work done.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Work {
    /// Evaluations with a factorisation.
    pub iterations: usize,
    /// Evaluations of everything.
    pub evaluations: usize,
    /// Matrix factorisations.
    pub factorisations: usize,
}

impl Work {
    /// Adds that of another solve.
    pub fn add(&mut self, other: &Self) {
        self.iterations += other.iterations;
        self.evaluations += other.evaluations;
        self.factorisations += other.factorisations;
    }
}
