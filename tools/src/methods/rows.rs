//! Rows of the lifted problem, picked out of its blocks.

use enact::estimate::unknowns::layout::Layout;
use enact::optimise::block::{Block, BlockPattern};
use enact::physics::state::DIMENSION as STATE;
use nalgebra::DMatrix;

use super::columns::GAP;
use super::parts::Part;

/// Unknowns of the lifted problem in some groups.
pub fn unknowns(layout: &Layout, parts: &[Part]) -> Vec<usize> {
    let of = |part: &Part| match *part {
        Part::Piece(piece) => layout.arcs[piece]..layout.arcs[piece] + STATE,
        Part::Event(event) => {
            let at = layout.events[event].expect("a free event");
            at..at + 1
        }
        Part::Parameter(p) => layout.parameters[p]..layout.parameters[p] + 1,
    };
    parts.iter().flat_map(of).collect()
}

/// Some rows of a block, by some unknowns.
pub fn rows_of(
    (block, pattern): (&Block, &BlockPattern),
    rows: &[usize],
    columns: &[usize],
) -> DMatrix<f64> {
    let mut result = DMatrix::zeros(rows.len(), columns.len());
    for (index, row) in rows.iter().enumerate() {
        let derivatives = block.derivatives(pattern, *row).iter();
        for (unknown, derivative) in pattern.unknowns(*row).iter().zip(derivatives) {
            if let Some(column) = columns.iter().position(|column| column == unknown) {
                result[(index, column)] = *derivative;
            }
        }
    }
    result
}

/// Some rows of a lifted block with other derivatives.
pub fn fill_block(
    lifted: &Block,
    rows: &[usize],
    by: &DMatrix<f64>,
    (out, pattern): (&mut Block, &BlockPattern),
) {
    out.reset(pattern);
    for (index, row) in rows.iter().enumerate() {
        out.values[index] = lifted.values[*row];
        out.bounds[index] = lifted.bounds[*row];
    }
    fill_derivatives(by, (out, pattern));
}

/// All derivatives of a block whose rows touch all of its unknowns.
pub fn fill_derivatives(by: &DMatrix<f64>, (out, pattern): (&mut Block, &BlockPattern)) {
    for (row, by) in by.row_iter().enumerate() {
        let to = out.derivatives_mut(pattern, row);
        assert_eq!(to.len(), by.len());
        to.iter_mut().zip(by.iter()).for_each(|(to, by)| *to = *by);
    }
}

/// Rows of a body's continuity: closed ones, then those that have a price.
pub fn continuity(
    (block, pattern): (&Block, &BlockPattern),
    (gaps, gap_pattern): (&Block, &BlockPattern),
    body: usize,
    columns: &[usize],
) -> DMatrix<f64> {
    let first = block.leads.end;
    if gaps.values.is_empty() {
        let rows: Vec<usize> = (0..STATE).map(|row| first + STATE * body + row).collect();
        return rows_of((block, pattern), &rows, columns);
    }
    let half = |from: usize| {
        (0..GAP)
            .map(|row| from + GAP * body + row)
            .collect::<Vec<_>>()
    };
    let poses = rows_of((block, pattern), &half(first), columns);
    let velocities = rows_of((gaps, gap_pattern), &half(0), columns);
    DMatrix::from_fn(STATE, columns.len(), |row, column| {
        if row < GAP {
            poses[(row, column)]
        } else {
            velocities[(row - GAP, column)]
        }
    })
}
