//! Rows of the lifted problem, picked out of its blocks.

use enact::estimate::constraint::Block;
use enact::estimate::layout::STATE;
use nalgebra::DMatrix;

use super::columns::GAP;

/// Some rows of a block, by all of its lifted columns.
pub fn rows_of(block: &Block, rows: &[usize]) -> DMatrix<f64> {
    let count = block.values.len();
    let columns = block.jacobian.len().checked_div(count).unwrap_or(0);
    DMatrix::from_fn(rows.len(), columns, |row, column| {
        block.jacobian[column * count + rows[row]]
    })
}

/// Some rows of a lifted block with other derivatives.
pub fn fill_block(lifted: &Block, rows: &[usize], by: &DMatrix<f64>, out: &mut Block) {
    out.values.clear();
    out.values
        .extend(rows.iter().map(|row| lifted.values[*row]));
    out.bounds.clear();
    out.bounds
        .extend(rows.iter().map(|row| lifted.bounds[*row]));
    out.jacobian.clear();
    out.jacobian.extend_from_slice(by.as_slice());
    out.approach = 0..0;
    out.curvature = 0.0;
}

/// Rows of a body's continuity: closed ones, then those that have a price.
pub fn continuity(block: &Block, gaps: &Block, body: usize) -> DMatrix<f64> {
    let bodies_gaps = gaps.values.len();
    let first = block.approach.end;
    if bodies_gaps == 0 {
        let rows: Vec<usize> = (0..STATE).map(|row| first + STATE * body + row).collect();
        return rows_of(block, &rows);
    }
    let half = |from: usize| {
        (0..GAP)
            .map(|row| from + GAP * body + row)
            .collect::<Vec<_>>()
    };
    let (poses, velocities) = (rows_of(block, &half(first)), rows_of(gaps, &half(0)));
    let columns = poses.ncols();
    DMatrix::from_fn(STATE, columns, |row, column| {
        if row < GAP {
            poses[(row, column)]
        } else {
            velocities[(row - GAP, column)]
        }
    })
}
