//! The test at one event: do the flights about it, each by itself, agree with what must hold there?
//!
//! The flights alone violate the event's constraints by `y`. With the constraints' derivative `C`, the
//! Hessian `H` of the objective and the residuals' derivative `J`, errors of the samples with covariance
//! `Σ` give `y` the covariance
//!
//! ```text
//! S = C V Cᵀ,   V = H⁻¹ (Jᵀ Σ J + H_p) H⁻¹,   H_p = H − JᵀJ from priors
//! ```
//!
//! What only the constraints depend on (the event's time, a free restitution: columns `F` of their
//! derivative) is chosen in favour of the model. Under a right model
//!
//! ```text
//! min over t   (y + F t)ᵀ S⁻¹ (y + F t)/d   ~   F(d, ν)
//! ```
//!
//! with as many degrees of freedom `d` as rows less columns of `F`, and `ν` those from which `Σ` is
//! estimated: Wald's test with a robust covariance (White 1982), and Hotelling's correction of its
//! distribution.

use nalgebra::{DMatrix, DVector};

use super::alone::Alone;
use super::hand::{Expected, ResidualKind, Wander};
use super::part::{self, Part, PartTest};
use crate::estimate::covariance::bins::{self, Bins, Residuals, Six};
use crate::estimate::covariance::noise;
use crate::estimate::covariance::trace::Design;
use crate::estimate::posing::waypoint;
use crate::estimate::problem::Problem;
use crate::estimate::terms::context::SolveContext;
use crate::estimate::terms::held;
use crate::math::span::Span;
use crate::motion::Place;
use crate::physics::state::StateTangent;

/// A pivot below this share of the largest diagonal entry belongs to a row that depends on others.
const DEPENDENT: f64 = 1e-12;
/// A pivot below which what is free at an event depends on what else is.
const FREE: f64 = 1e-9;

/// Derivative and value of one row at the flights alone.
struct EventRow {
    value: f64,
    derivative: DVector<f64>,
}

/// The test; `None` where nothing can be tested: no flight with samples there, or no more rows than
/// what they leave free.
pub(super) fn test(
    context: &SolveContext,
    alone: &Alone,
    event: usize,
    multipliers: &[f64],
) -> Option<PartTest> {
    let problem = context.problem;
    let arcs = flights(problem, event);
    let rows = rows(context, alone, event, multipliers);
    if arcs.is_empty() || rows.is_empty() {
        return None;
    }
    let bins = Bins::of(problem, &alone.point, &arcs);
    if bins.count() == 0 {
        return None;
    }
    let design = Design::of(context, &alone.point, &bins, &arcs);
    let views = arcs.iter().flat_map(|arc| problem.views_of(*arc));
    let errors: Vec<Residuals> = views.map(|view| alone.errors[view].clone()).collect();
    let white = noise::white(&errors);
    let absorbed = part::absorbed(context, alone, &bins, &design, &arcs);
    let hands = part::hands(context, &bins, &errors, &absorbed, white, Expected::Any);
    let products = Products::new(context, alone, &design, &rows);
    let free = free(alone, &rows);
    let values = DVector::from_iterator(rows.len(), rows.iter().map(|row| row.value));
    let seen = part::seen(&errors);
    let test = |covariance: &DMatrix<f64>, noise_freedom: usize| {
        let (square, freedom) = standardised(covariance, &values, &free)?;
        part::tested(square, freedom, noise_freedom)
    };
    let by_noise = test(
        &products.covariance(white, None),
        seen.saturating_sub(absorbed.len()),
    )?;
    let by_hand = test(
        &products.covariance(white, Some(&hands)),
        bins.dimension().saturating_sub(absorbed.len()),
    )?;
    Some(PartTest::new(
        Part::Event(event),
        Place::Event(event),
        white,
        &hands,
        by_noise,
        by_hand,
    ))
}

/// The flights that begin or end at an event, and those that pass through it.
pub(super) fn flights(problem: &Problem, event: usize) -> Vec<usize> {
    let passing = waypoint::flights(problem, event);
    let arcs = problem.arcs.iter().enumerate();
    let arcs = arcs.filter(|(index, arc)| {
        arc.start == Some(event) || arc.end == Some(event) || passing.contains(index)
    });
    arcs.map(|(arc, _)| arc).collect()
}

/// The event's equalities and active bounds.
fn rows(context: &SolveContext, alone: &Alone, event: usize, multipliers: &[f64]) -> Vec<EventRow> {
    let structure = &context.layout.structure;
    let mut rows = Vec::new();
    let mut first = 0;
    let blocks = alone.system.blocks.iter().zip(&structure.blocks);
    for (constraint, (block, pattern)) in context.problem.constraints().zip(blocks) {
        let count = block.values.len();
        if constraint.event() == Some(event) {
            for row in 0..count {
                let (lower, upper) = block.bounds[row];
                let multiplier = multipliers[first + row];
                let bound = match () {
                    () if lower == upper => lower,
                    () if multiplier > 0.0 => upper,
                    () if multiplier < 0.0 => lower,
                    () => continue,
                };
                let mut derivative = DVector::zeros(structure.size());
                let by = block.derivatives(pattern, row);
                for (unknown, by) in pattern.unknowns(row).iter().zip(by) {
                    derivative[*unknown] = *by;
                }
                rows.push(EventRow {
                    value: block.values[row] - bound + alone.ahead(&derivative),
                    derivative,
                });
            }
        }
        first += count;
    }
    rows
}

/// Products of the rows' answers `X = H⁻¹ Cᵀ`, of which `S` consists.
struct Products {
    /// `Xᵀ J_kᵀ J_k X` of positions and of orientations.
    squares: [DMatrix<f64>; 2],
    /// `Xᵀ H_p X`.
    priors: DMatrix<f64>,
    /// `J X` summed over the bins, row by row.
    sums: Vec<Vec<Six>>,
}

impl Products {
    fn new(context: &SolveContext, alone: &Alone, design: &Design, rows: &[EventRow]) -> Self {
        let answers = rows.iter().map(|row| {
            let mut answer = row.derivative.clone();
            alone.solve(context, &mut answer);
            answer
        });
        let answers: Vec<DVector<f64>> = answers.collect();
        let changes = answers.iter().map(|answer| {
            let mut changes = Vec::new();
            design.each_change(answer, |change| changes.push(*change));
            changes
        });
        let changes: Vec<Vec<Six>> = changes.collect();
        let mut squares = [0, 1].map(|_| DMatrix::zeros(rows.len(), rows.len()));
        let mut priors = DMatrix::zeros(rows.len(), rows.len());
        // What residuals of held bodies have beyond the variance of a prior.
        let of_held = answers.iter().map(|answer| {
            let changes = held::changes(context, &alone.point, answer);
            changes
                .map(|(of, change)| (of.counted() - 1.0, change))
                .collect()
        });
        let of_held: Vec<Vec<(f64, StateTangent)>> = of_held.collect();
        for i in 0..rows.len() {
            for j in 0..=i {
                let products = bins::products(&changes[i], &changes[j]);
                let left = rows[i].derivative.dot(&answers[j]) - products[0] - products[1];
                let left = if i == j { left.max(0.0) } else { left };
                let both = of_held[i].iter().zip(&of_held[j]);
                let beyond: f64 = both.map(|((beyond, a), (_, b))| beyond * a.dot(b)).sum();
                let left = left + beyond;
                for at in [(i, j), (j, i)] {
                    squares[0][at] = products[0];
                    squares[1][at] = products[1];
                    priors[at] = left;
                }
            }
        }
        Self {
            squares,
            priors,
            sums: answers.iter().map(|answer| design.sums(answer)).collect(),
        }
    }

    /// `S` under white noise, and a hand's wander if there is one.
    fn covariance(&self, white: [f64; 2], hands: Option<&[Wander; 2]>) -> DMatrix<f64> {
        let [positions, orientations] = &self.squares;
        let mut covariance = positions * white[0] + orientations * white[1] + &self.priors;
        for (kind, hand) in ResidualKind::ALL
            .into_iter()
            .zip(hands.into_iter().flatten())
        {
            for (i, y) in self.sums.iter().enumerate() {
                for (j, z) in self.sums[..=i].iter().enumerate() {
                    let value = hand.covariance(kind, y, z);
                    covariance[(i, j)] += value;
                    if i != j {
                        covariance[(j, i)] += value;
                    }
                }
            }
        }
        covariance
    }
}

/// Columns of the rows' derivative by what the objective does not depend on.
fn free(alone: &Alone, rows: &[EventRow]) -> DMatrix<f64> {
    let size = rows[0].derivative.len();
    let is_free = |unknown: &usize| {
        alone.is_unseen(*unknown) && rows.iter().any(|row| row.derivative[*unknown] != 0.0)
    };
    let unknowns: Vec<usize> = (0..size).filter(is_free).collect();
    DMatrix::from_fn(rows.len(), unknowns.len(), |row, column| {
        rows[row].derivative[unknowns[column]]
    })
}

/// The least `(y + F t)ᵀ S⁻¹ (y + F t)` and its degrees of freedom.
fn standardised(
    covariance: &DMatrix<f64>,
    values: &DVector<f64>,
    free: &DMatrix<f64>,
) -> Option<(f64, usize)> {
    // Rows in units of their deviations; those that depend on others are left out by the eigenvalues.
    let scale = covariance.diagonal().map(|variance| variance.sqrt());
    if !scale.iter().all(|sd| sd.is_finite() && *sd > 0.0) {
        return None;
    }
    let scaled = DMatrix::from_fn(scale.len(), scale.len(), |i, j| {
        covariance[(i, j)] / (scale[i] * scale[j])
    });
    let eigen = scaled.symmetric_eigen();
    let largest = eigen.eigenvalues.max();
    let kept: Vec<usize> = (0..scale.len())
        .filter(|at| eigen.eigenvalues[*at] > DEPENDENT * largest)
        .collect();
    let whiten = DMatrix::from_fn(kept.len(), scale.len(), |row, column| {
        let at = kept[row];
        eigen.eigenvectors[(column, at)] / (eigen.eigenvalues[at].sqrt() * scale[column])
    });
    let left = &whiten * values;
    let columns = free.column_iter().map(|column| &whiten * column);
    let columns: Vec<DVector<f64>> = columns.collect();
    let left = Span::of(&columns, kept.len(), FREE).beyond(DMatrix::from_columns(&[left]));
    let (square, freedom) = (left.norm_squared(), left.nrows());
    (square.is_finite() && freedom > 0).then_some((square, freedom))
}
