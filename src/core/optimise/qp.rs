//! The quadratic programme of one step, solved by clarabel to find the active set:
//!
//! ```text
//! min ½ δᵀHδ + gᵀδ   s.t.  lower ≤ c + Jδ ≤ upper, row by row;  |p + δ_p| ≤ limit
//! ```
//!
//! with `p` the two unknowns of a curved row (a second-order cone). The interior-point method
//! is accurate to about eight digits; the finish takes the active set from its multipliers
//! and solves for the step exactly.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT};

use super::system::{Structure, System};

/// Relative shift of the diagonal: clarabel does not report an indefinite matrix.
const CONVEX: f64 = 1e-9;
/// Multipliers below this share of the largest are zero up to the interior-point tolerance.
const ZERO: f64 = 1e-6;

/// Multipliers of all rows at the programme's optimum, zero for inactive rows; `None`
/// where clarabel does not solve it.
pub fn multipliers(structure: &Structure, system: &System) -> Option<Vec<f64>> {
    let size = structure.size();
    let (mut rows, mut columns, mut values) = (Vec::new(), Vec::new(), Vec::new());
    for (row, column, value) in system.hessian.triplets(&structure.pattern) {
        // Clarabel reads the upper triangle only, hence rows and columns exchanged.
        let diagonal = if row == column {
            CONVEX * (1.0 + value.abs())
        } else {
            0.0
        };
        rows.push(column);
        columns.push(row);
        values.push(value + diagonal);
    }
    let p = CscMatrix::new_from_triplets(size, size, rows, columns, values);

    let sides = sides(system);
    let circles = circles(structure, system);
    let (mut rows, mut columns, mut values) = (Vec::new(), Vec::new(), Vec::new());
    for (index, side) in sides.iter().enumerate() {
        let (block, pattern) = (&system.blocks[side.block], &structure.blocks[side.block]);
        let derivatives = block.derivatives(pattern, side.row);
        for (at, derivative) in pattern.unknowns(side.row).iter().zip(derivatives) {
            rows.push(index);
            columns.push(*at);
            values.push(side.sign * derivative);
        }
    }
    let mut b: Vec<f64> = sides.iter().map(|side| side.room).collect();
    let equalities = sides.iter().filter(|side| side.is_equality).count();
    let mut cones = vec![
        SupportedConeT::ZeroConeT(equalities),
        SupportedConeT::NonnegativeConeT(sides.len() - equalities),
    ];
    for circle in &circles {
        for (axis, at) in structure.blocks[circle.block]
            .unknowns(0)
            .iter()
            .enumerate()
        {
            rows.push(b.len() + 1 + axis);
            columns.push(*at);
            values.push(-1.0);
        }
        b.extend([circle.limit, circle.values[0], circle.values[1]]);
        cones.push(SupportedConeT::SecondOrderConeT(3));
    }
    let a = CscMatrix::new_from_triplets(b.len(), size, rows, columns, values);
    let settings = DefaultSettings {
        verbose: false,
        ..DefaultSettings::default()
    };
    let gradient = system.gradient.as_slice();
    let mut solver = DefaultSolver::new(&p, gradient, &a, &b, &cones, settings).ok()?;
    solver.solve();
    if !matches!(
        solver.solution.status,
        SolverStatus::Solved | SolverStatus::AlmostSolved
    ) {
        return None;
    }
    let z = &solver.solution.z;
    let largest = z.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
    let mut multipliers = vec![0.0; system.row_count()];
    for (side, value) in sides.iter().zip(z) {
        if side.is_equality || *value > ZERO * largest {
            multipliers[side.index] += side.sign * value;
        }
    }
    for (circle, z) in circles.iter().zip(z[sides.len()..].chunks_exact(3)) {
        // The cone's force along the radius is |z|, the curved row's is its multiplier times
        // 2/limit.
        if z[0] > ZERO * largest {
            multipliers[circle.index] = 0.5 * circle.limit * z[1].hypot(z[2]);
        }
    }
    Some(multipliers)
}

/// A curved row as a second-order cone: `(limit, p + δ_p)` with two unknowns `p`.
struct RowCircle {
    /// Index of its row among all rows.
    index: usize,
    block: usize,
    limit: f64,
    values: [f64; 2],
}

/// The cones of all curved rows `(p₀² + p₁²)/limit² ≤ 1`, whose derivatives are `2p/limit²` and
/// whose curvature is `2/limit²`.
fn circles(structure: &Structure, system: &System) -> Vec<RowCircle> {
    let mut circles = Vec::new();
    let mut index = 0;
    let blocks = system.blocks.iter().zip(&structure.blocks);
    for (number, (block, pattern)) in blocks.enumerate() {
        if block.curvature > 0.0 {
            let derivatives = block.derivatives(pattern, 0);
            circles.push(RowCircle {
                index,
                block: number,
                limit: (2.0 / block.curvature).sqrt(),
                values: [0, 1].map(|axis: usize| derivatives[axis] / block.curvature),
            });
        }
        index += block.values.len();
    }
    circles
}

/// One bound of a row: `sign·Jδ ≤ room`, or `= room` for an equality.
struct RowSide {
    /// Index among all rows.
    index: usize,
    block: usize,
    row: usize,
    is_equality: bool,
    sign: f64,
    room: f64,
}

/// All finite bounds, equalities first.
fn sides(system: &System) -> Vec<RowSide> {
    let mut sides = Vec::new();
    let mut index = 0;
    for (number, block) in system.blocks.iter().enumerate() {
        // Curved rows become cones.
        if block.curvature > 0.0 {
            index += block.values.len();
            continue;
        }
        for (row, (value, (lower, upper))) in block.values.iter().zip(&block.bounds).enumerate() {
            let is_equality = lower == upper;
            let mut push = |sign: f64, room: f64| {
                sides.push(RowSide {
                    index,
                    block: number,
                    row,
                    is_equality,
                    sign,
                    room,
                });
            };
            if upper.is_finite() {
                push(1.0, upper - value);
            }
            if lower.is_finite() && !is_equality {
                push(-1.0, value - lower);
            }
            index += 1;
        }
    }
    sides.sort_by_key(|side| !side.is_equality);
    sides
}
