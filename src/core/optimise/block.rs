//! Rows of constraints: values, bounds and the rows of the Jacobian.
//!
//! Most rows depend on few unknowns, and always on the same: [`BlockPattern`] lists them once per
//! problem. Rows that depend on the same unknowns form panels, dense over these; products with the
//! Jacobian go panel by panel, over runs of consecutive unknowns.

use std::ops::Range;

use nalgebra::DVector;

use super::envelope::{Envelope, Pattern};

/// Rows of a full panel. A panel has this many rows or one, so that loops have fixed lengths.
const PANEL: usize = 3;

/// Columns that are consecutive both in a panel and among the unknowns.
#[derive(Clone, Copy, Debug)]
struct Run {
    column: usize,
    unknown: usize,
    length: usize,
}

impl Run {
    fn of<'s>(&self, row: &'s [f64]) -> &'s [f64] {
        &row[self.column..self.column + self.length]
    }
}

/// Rows that depend on the same unknowns; their derivatives are stored row by row.
#[derive(Clone, Debug)]
struct Panel {
    rows: usize,
    width: usize,
    /// Index of its first derivative among all of the block.
    first: usize,
    /// Its runs among all runs of the pattern, sorted by unknown.
    runs: Range<usize>,
}

/// Which unknowns the rows of a block depend on.
#[derive(Clone, Debug, Default)]
pub struct BlockPattern {
    panels: Vec<Panel>,
    runs: Vec<Run>,
    /// For every row, the index of its first derivative and that of its first entry in `columns`.
    rows: Vec<(usize, usize)>,
    /// Unknowns of the panels, in the order in which their derivatives are stored.
    columns: Vec<usize>,
    /// Number of derivatives.
    stored: usize,
}

impl BlockPattern {
    /// Rows that all depend on the same unknowns, each listed once.
    pub fn dense(rows: usize, columns: Vec<usize>) -> Self {
        let mut pattern = Self::default();
        pattern.push(rows, columns);
        pattern
    }

    /// Adds rows that depend on the same unknowns, each listed once, in any order.
    pub fn push(&mut self, rows: usize, columns: impl IntoIterator<Item = usize>) {
        let first_column = self.columns.len();
        self.columns.extend(columns);
        let columns = &self.columns[first_column..];
        let mut runs: Vec<Run> = Vec::new();
        for (column, unknown) in columns.iter().enumerate() {
            match runs.last_mut() {
                Some(run) if run.unknown + run.length == *unknown => run.length += 1,
                _ => runs.push(Run {
                    column,
                    unknown: *unknown,
                    length: 1,
                }),
            }
        }
        runs.sort_by_key(|run| run.unknown);
        let first_run = self.runs.len();
        self.runs.extend(runs);
        let width = columns.len();
        let mut left = rows;
        while left > 0 {
            let rows = if left < PANEL { 1 } else { PANEL };
            self.panels.push(Panel {
                rows,
                width,
                first: self.stored,
                runs: first_run..self.runs.len(),
            });
            for _ in 0..rows {
                self.rows.push((self.stored, first_column));
                self.stored += width;
            }
            left -= rows;
        }
    }

    /// Unknowns of each panel: those that the rows couple with each other.
    pub fn cliques(&self) -> impl Iterator<Item = impl Iterator<Item = usize> + Clone> {
        self.panels.iter().map(|panel| {
            let runs = self.runs[panel.runs.clone()].iter();
            runs.flat_map(|run| run.unknown..run.unknown + run.length)
        })
    }

    /// Unknowns that a row depends on, in the order of its derivatives.
    pub fn unknowns(&self, row: usize) -> &[usize] {
        let (first, column) = self.rows[row];
        let end = self.rows.get(row + 1).map_or(self.stored, |next| next.0);
        &self.columns[column..column + end - first]
    }

    /// Number of rows.
    pub fn row_count(&self) -> usize {
        self.rows.len()
    }

    fn derivatives(&self, row: usize) -> Range<usize> {
        let first = self.rows[row].0;
        first..self.rows.get(row + 1).map_or(self.stored, |next| next.0)
    }
}

/// A second derivative of a row, with its mirror where the two unknowns differ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SecondDerivative {
    /// Which row.
    pub row: usize,
    /// Places of the two unknowns among [`BlockPattern::unknowns`] of the row.
    pub by: [usize; 2],
    /// Its value, in units.
    pub value: f64,
}

/// An entry of the constraints' curvature; its mirror is the same entry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Curvature {
    /// Row of the Hessian.
    pub row: usize,
    /// Column, at most the row.
    pub column: usize,
    /// What it adds.
    pub value: f64,
}

impl Curvature {
    /// Whether it is on the diagonal and makes a matrix more positive.
    pub fn is_convex(&self) -> bool {
        self.row == self.column && self.value > 0.0
    }

    /// `y += K x`.
    pub fn multiply_add(&self, x: &DVector<f64>, y: &mut DVector<f64>) {
        y[self.row] += self.value * x[self.column];
        if self.row != self.column {
            y[self.column] += self.value * x[self.row];
        }
    }
}

impl SecondDerivative {
    /// What it adds to a Hessian where its row pulls so much.
    pub(crate) fn pulled(&self, pattern: &BlockPattern, pull: f64) -> Curvature {
        let [a, b] = self.by.map(|place| pattern.unknowns(self.row)[place]);
        Curvature {
            row: a.max(b),
            column: a.min(b),
            value: self.value * pull,
        }
    }
}

/// Values of some rows and their derivatives by the unknowns they depend on.
#[derive(Clone, Debug, Default)]
pub struct Block {
    /// Values, in units.
    pub values: Vec<f64>,
    /// Lower and upper bound, in units.
    pub bounds: Vec<(f64, f64)>,
    /// Derivatives, row by row, as the pattern says.
    jacobian: Vec<f64>,
    /// Rows to which a sweep may give a larger weight than to the others
    /// ([`leading_weight`](super::lagrangian::AugmentedLagrangian::leading_weight)).
    pub leads: Range<usize>,
    /// `κ` where the Hessian of the first row is `κ·1` over its unknowns; zero where the row is
    /// linear or its curvature is not given here.
    pub curvature: f64,
    /// Second derivatives of rows that have them in closed form; those that vanish are left out.
    pub second: Vec<SecondDerivative>,
}

impl Block {
    /// As many equalities as the pattern has rows, all zero.
    pub fn zeros(pattern: &BlockPattern) -> Self {
        let mut block = Self::default();
        block.reset(pattern);
        block
    }

    /// `c − clamp(c, lower, upper)` of a row: its signed distance from its bounds, zero inside.
    pub fn violation(&self, row: usize) -> f64 {
        let (lower, upper) = self.bounds[row];
        self.values[row] - self.values[row].clamp(lower, upper)
    }

    /// Whether a row is an equality or violates a bound.
    pub fn acts(&self, row: usize) -> bool {
        let (lower, upper) = self.bounds[row];
        lower == upper || self.violation(row) != 0.0
    }

    /// What is convex of the rows' second derivatives in closed form, each times `pull(row)`.
    pub fn convex(
        &self,
        pattern: &BlockPattern,
        pull: impl Fn(usize) -> f64,
    ) -> impl Iterator<Item = Curvature> {
        let each = self
            .second
            .iter()
            .map(move |of| of.pulled(pattern, pull(of.row)));
        each.filter(Curvature::is_convex)
    }

    /// Largest violation among `rows`.
    pub(crate) fn largest(&self, rows: Range<usize>) -> f64 {
        rows.map(|row| self.violation(row).abs())
            .fold(0.0, f64::max)
    }

    /// Makes room for the rows of a pattern, all equalities. Old values and derivatives stay: the
    /// caller sets every one.
    pub fn reset(&mut self, pattern: &BlockPattern) {
        self.values.resize(pattern.row_count(), 0.0);
        self.bounds.clear();
        self.bounds.resize(pattern.row_count(), (0.0, 0.0));
        self.jacobian.resize(pattern.stored, 0.0);
        self.leads = 0..0;
        self.curvature = 0.0;
        self.second.clear();
    }

    /// Sets every value to NaN and every derivative to zero.
    pub(crate) fn spoil(&mut self) {
        self.values.fill(f64::NAN);
        self.jacobian.fill(0.0);
    }

    /// Derivatives of a row by [`BlockPattern::unknowns`].
    pub fn derivatives(&self, pattern: &BlockPattern, row: usize) -> &[f64] {
        &self.jacobian[pattern.derivatives(row)]
    }

    /// [`Block::derivatives`], to be set.
    pub fn derivatives_mut(&mut self, pattern: &BlockPattern, row: usize) -> &mut [f64] {
        &mut self.jacobian[pattern.derivatives(row)]
    }

    /// Adds `Jᵀ diag(w) J` to a matrix. Panels of zero weight are skipped.
    pub(crate) fn add_square(
        &self,
        pattern: &BlockPattern,
        weight: impl Fn(usize) -> f64,
        within: &Pattern,
        matrix: &mut Envelope,
    ) {
        let mut row = 0;
        for panel in &pattern.panels {
            let runs = &pattern.runs[panel.runs.clone()];
            match self.rows(panel) {
                PanelRows::One(of) => {
                    let weight = weight(row);
                    if weight != 0.0 {
                        add_square_of_one(runs, of, weight, within, matrix);
                    }
                }
                PanelRows::Three(of) => {
                    let weights = [weight(row), weight(row + 1), weight(row + 2)];
                    if weights != [0.0; PANEL] {
                        add_square_of_three(runs, of, weights, within, matrix);
                    }
                }
            }
            row += panel.rows;
        }
    }

    /// Adds `Jᵀ p` to `gradient`, with `p = pull(row)`.
    pub(crate) fn add_pull(
        &self,
        pattern: &BlockPattern,
        pull: impl Fn(usize) -> f64,
        gradient: &mut DVector<f64>,
    ) {
        let gradient = gradient.as_mut_slice();
        let mut row = 0;
        for panel in &pattern.panels {
            let runs = &pattern.runs[panel.runs.clone()];
            match self.rows(panel) {
                PanelRows::One(of) => {
                    let pull = pull(row);
                    for run in runs {
                        let to = &mut gradient[run.unknown..run.unknown + run.length];
                        add_one(to, pull, run.of(of));
                    }
                }
                PanelRows::Three([a, b, c]) => {
                    let pulls = [pull(row), pull(row + 1), pull(row + 2)];
                    for run in runs {
                        let to = &mut gradient[run.unknown..run.unknown + run.length];
                        add_three(to, pulls, run.of(a), run.of(b), run.of(c));
                    }
                }
            }
            row += panel.rows;
        }
    }

    /// `J δ`, the linearised change of every row, into `change`.
    pub(crate) fn along(&self, pattern: &BlockPattern, delta: &DVector<f64>, change: &mut [f64]) {
        let delta = delta.as_slice();
        let mut row = 0;
        for panel in &pattern.panels {
            let runs = &pattern.runs[panel.runs.clone()];
            let moved = |run: &Run| &delta[run.unknown..run.unknown + run.length];
            match self.rows(panel) {
                PanelRows::One(of) => {
                    let mut sum = 0.0;
                    for run in runs {
                        let terms = run.of(of).iter().zip(moved(run));
                        sum = terms.fold(sum, |sum, (d, by)| sum + d * by);
                    }
                    change[row] = sum;
                }
                PanelRows::Three([a, b, c]) => {
                    let mut sums = [0.0; PANEL];
                    for run in runs {
                        let (a, b, c) = (run.of(a).iter(), run.of(b), run.of(c));
                        for (by, ((a, b), c)) in moved(run).iter().zip(a.zip(b).zip(c)) {
                            sums[0] += a * by;
                            sums[1] += b * by;
                            sums[2] += c * by;
                        }
                    }
                    change[row..row + PANEL].copy_from_slice(&sums);
                }
            }
            row += panel.rows;
        }
    }

    fn rows(&self, panel: &Panel) -> PanelRows<'_> {
        let row = |row: usize| &self.jacobian[panel.first + row * panel.width..][..panel.width];
        if panel.rows == 1 {
            PanelRows::One(row(0))
        } else {
            PanelRows::Three([row(0), row(1), row(2)])
        }
    }
}

/// Derivatives of a panel's rows.
enum PanelRows<'a> {
    One(&'a [f64]),
    Three([&'a [f64]; PANEL]),
}

fn add_square_of_one(
    runs: &[Run],
    of: &[f64],
    weight: f64,
    within: &Pattern,
    matrix: &mut Envelope,
) {
    for (count, run) in runs.iter().enumerate() {
        for (index, derivative) in run.of(of).iter().enumerate() {
            // Many derivatives vanish: a gap over a level floor has none by x and y.
            if *derivative == 0.0 {
                continue;
            }
            let scaled = weight * derivative;
            let (first, entries) = matrix.row_mut(within, run.unknown + index);
            for other in &runs[..count] {
                let to = &mut entries[other.unknown - first..][..other.length];
                add_one(to, scaled, other.of(of));
            }
            let to = &mut entries[run.unknown - first..][..=index];
            add_one(to, scaled, &run.of(of)[..=index]);
        }
    }
}

fn add_square_of_three(
    runs: &[Run],
    [a, b, c]: [&[f64]; PANEL],
    weights: [f64; PANEL],
    within: &Pattern,
    matrix: &mut Envelope,
) {
    for (count, run) in runs.iter().enumerate() {
        let (own_a, own_b, own_c) = (run.of(a), run.of(b), run.of(c));
        for index in 0..run.length {
            let scaled = [
                weights[0] * own_a[index],
                weights[1] * own_b[index],
                weights[2] * own_c[index],
            ];
            if scaled == [0.0; PANEL] {
                continue;
            }
            let (first, entries) = matrix.row_mut(within, run.unknown + index);
            for other in &runs[..count] {
                let to = &mut entries[other.unknown - first..][..other.length];
                add_three(to, scaled, other.of(a), other.of(b), other.of(c));
            }
            let to = &mut entries[run.unknown - first..][..=index];
            add_three(
                to,
                scaled,
                &own_a[..=index],
                &own_b[..=index],
                &own_c[..=index],
            );
        }
    }
}

/// Adds a scaled row.
#[inline]
fn add_one(to: &mut [f64], scale: f64, row: &[f64]) {
    for (entry, derivative) in to.iter_mut().zip(row) {
        *entry += scale * derivative;
    }
}

/// Adds three scaled rows. Never inlined: the compiler knows that the arguments of a call do not
/// overlap and need not check it before each short loop.
#[inline(never)]
fn add_three(to: &mut [f64], scales: [f64; PANEL], a: &[f64], b: &[f64], c: &[f64]) {
    for (entry, ((a, b), c)) in to.iter_mut().zip(a.iter().zip(b).zip(c)) {
        *entry += scales[0] * a + scales[1] * b + scales[2] * c;
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};

    use super::*;

    /// Nine rows of ten unknowns in panels of three and of one, some with columns out of order, with
    /// their derivatives as a dense matrix.
    fn example() -> (BlockPattern, Block, DMatrix<f64>) {
        let mut pattern = BlockPattern::default();
        pattern.push(3, [5, 6, 7, 1, 2, 9]);
        pattern.push(1, [8, 0]);
        pattern.push(5, [2, 3, 4, 5]);
        let mut block = Block::default();
        block.reset(&pattern);
        let mut dense = DMatrix::zeros(pattern.row_count(), 10);
        for row in 0..pattern.row_count() {
            let unknowns = pattern.unknowns(row).to_vec();
            let derivatives = block.derivatives_mut(&pattern, row);
            assert_eq!(derivatives.len(), unknowns.len());
            for (column, (by, at)) in derivatives.iter_mut().zip(unknowns).enumerate() {
                *by = (3 * row + column) as f64 - 7.0;
                dense[(row, at)] = *by;
            }
        }
        (pattern, block, dense)
    }

    #[test]
    fn products_are_those_of_the_dense_matrix() {
        let (pattern, block, dense) = example();
        assert_eq!(dense.shape(), (9, 10));
        let pull = DVector::from_fn(9, |row, _| row as f64 - 3.0);
        let mut gradient = DVector::repeat(10, 2.0);
        block.add_pull(&pattern, |row| pull[row], &mut gradient);
        assert_eq!(gradient, dense.tr_mul(&pull).add_scalar(2.0));

        let delta = DVector::from_fn(10, |at, _| at as f64 - 4.0);
        let mut change = vec![f64::NAN; 9];
        block.along(&pattern, &delta, &mut change);
        assert_eq!(DVector::from_vec(change), &dense * delta);
    }

    #[test]
    fn squares_are_those_of_the_dense_matrix_and_within_the_cliques() {
        let (pattern, block, dense) = example();
        let mut couplings = Vec::new();
        for members in pattern.cliques() {
            let first = members.clone().min().unwrap();
            couplings.extend(members.map(|member| (member, first)));
        }
        let within = Pattern::new(10, couplings);
        let mut matrix = Envelope::zeros(&within);
        let weights = DVector::from_fn(9, |row, _| f64::from(row != 1 && row != 3) * row as f64);
        block.add_square(&pattern, |row| weights[row], &within, &mut matrix);
        let expected = dense.transpose() * DMatrix::from_diagonal(&weights) * &dense;
        for i in 0..10 {
            for j in 0..=i {
                assert_eq!(matrix.get(&within, i, j), expected[(i, j)], "({i}, {j})");
            }
        }
    }
}
