//! A contact point on a tree: how its Jacobian and the answer to an impulse there change with the coordinates.
//!
//! All motions are about the origin of one frame that is held still at this instant. A change of coordinate `j`
//! moves all that hangs on its joint by the motion `S_j`, a free base's place moves everything. With motions `ν` of
//! the nodes for some rates `w`, those of what a joint hangs from `λ`, momenta `h = I ν` and sums `C` over all
//! that hangs on a node,
//!
//! ```text
//! δ_j ν = S_j × (ν − ν_λj)                           beyond j
//! δ_j (M w)_i = S_i·Iᶜ_i (ν_λj × S_j)                i at or beyond j
//! δ_j (M w)_i = S_i·(S_j ×* hᶜ_j + Iᶜ_j (ν_λj × S_j))    i before j
//! ```
//!
//! and `w = M⁻¹ Jᵀ p` changes by `M⁻¹ (δ(Jᵀ) p − δM w)`.

use nalgebra::{DMatrix, Vector3};

use crate::physics::tree::articulated::LANES;
use crate::physics::tree::snapshot::Snapshot;
use crate::physics::tree::spatial::{Force, Inertia, Motion};

/// What moves with a coordinate.
struct Column {
    axis: Motion,
    /// The first node that moves; none: everything, with a free base's place.
    node: Option<usize>,
}

/// The contact and what its place changes with.
pub(super) struct Point<'a> {
    snapshot: &'a Snapshot<'a>,
    columns: Vec<Column>,
    node: Option<usize>,
    /// In the frame \[m\].
    place_m: Vector3<f64>,
    /// Change of the place with each coordinate.
    moved: Vec<Vector3<f64>>,
}

impl<'a> Point<'a> {
    /// The point of a link [m, link]; `slide` says how it moves on the link with each coordinate.
    pub(super) fn new(
        snapshot: &'a Snapshot<'a>,
        (link, on_link_m): (usize, &Vector3<f64>),
        slide: impl Fn(usize) -> Vector3<f64>,
    ) -> Self {
        let tree = snapshot.tree;
        let shift = tree.shift();
        let translations = (0..shift).map(|axis| Column {
            axis: Motion {
                angular: Vector3::zeros(),
                linear: snapshot.turn.tr_mul(&Vector3::ith(axis, 1.0)),
            },
            node: None,
        });
        let turns = tree.nodes.iter().enumerate().flat_map(|(index, node)| {
            let axes = &snapshot.field.kinematics.axes;
            node.columns().map(move |column| Column {
                axis: axes[column],
                node: Some(index),
            })
        });
        let world_from_link = snapshot.world_from_link(link);
        let mut point = Self {
            snapshot,
            columns: translations.chain(turns).collect(),
            node: tree.links[link].0,
            place_m: snapshot
                .turn
                .tr_mul(&(snapshot.point(link, on_link_m) - snapshot.origin_m)),
            moved: Vec::new(),
        };
        let moved = point.columns.iter().enumerate().map(|(index, column)| {
            let own = world_from_link.rotation * slide(index);
            let slid = snapshot.turn.tr_mul(&own);
            match point.carries(column.node, point.node) {
                true => slid + column.axis.at(&point.place_m),
                false => slid,
            }
        });
        point.moved = moved.collect();
        point
    }

    /// Whether a node moves with another; none as the first: with a free base's place.
    fn carries(&self, node: Option<usize>, other: Option<usize>) -> bool {
        let Some(node) = node else { return true };
        let mut above = other;
        while let Some(index) = above {
            if index == node {
                return true;
            }
            above = self.snapshot.tree.nodes[index].parent;
        }
        false
    }

    /// Motions of the nodes at these rates; the last is that of what the first hang from.
    fn motions(&self, rates: &[f64], root: Motion) -> Vec<Motion> {
        let tree = self.snapshot.tree;
        let moving = |range: std::ops::Range<usize>| {
            let both = self.columns[range.clone()].iter().zip(&rates[range]);
            both.fold(Motion::ZERO, |sum, (column, rate)| {
                sum + column.axis * *rate
            })
        };
        let shift = tree.shift();
        let base = root + moving(0..shift);
        let mut motions: Vec<Motion> = Vec::new();
        for node in &tree.nodes {
            let above = node.parent.map_or(base, |parent| motions[parent]);
            let own = node.columns();
            motions.push(above + moving(shift + own.start..shift + own.end));
        }
        motions.push(base);
        motions
    }

    /// Of what a column's node hangs from; zero of a free base's place, which hangs from nothing.
    fn above(&self, column: &Column, motions: &[Motion]) -> Motion {
        let Some(node) = column.node else {
            return Motion::ZERO;
        };
        let last = motions.len() - 1;
        motions[self.snapshot.tree.nodes[node].parent.unwrap_or(last)]
    }

    /// `δ(J) w` by each coordinate [world].
    pub(super) fn velocity_changes(&self, rates: &[f64], root: Motion) -> Vec<Vector3<f64>> {
        let motions = self.motions(rates, root);
        let Some(node) = self.node else {
            return vec![Vector3::zeros(); self.columns.len()];
        };
        let own = motions[node];
        let changes = self.columns.iter().zip(&self.moved);
        let changes = changes.map(|(column, moved)| {
            let mut change = own.angular.cross(moved);
            if self.carries(column.node, self.node) {
                let against = own - self.above(column, &motions);
                change += column.axis.cross(&against).at(&self.place_m);
            }
            self.snapshot.turn * change
        });
        changes.collect()
    }

    /// `δ(J) w` and `δw` of `w = M⁻¹ Jᵀ p` by each coordinate.
    pub(super) fn response(
        &self,
        impulse: &Vector3<f64>,
        response: &DMatrix<f64>,
    ) -> (Vec<Vector3<f64>>, DMatrix<f64>) {
        let rates = response * impulse;
        let steady = self.velocity_changes(rates.as_slice(), Motion::ZERO);
        let right = self.right_sides(rates.as_slice(), impulse);
        (steady, self.solve(right))
    }

    /// `δ(Jᵀ) p − δM w`: a row per rate, a column per coordinate.
    fn right_sides(&self, rates: &[f64], impulse: &Vector3<f64>) -> DMatrix<f64> {
        let tree = self.snapshot.tree;
        let motions = self.motions(rates, Motion::ZERO);
        let mut inertias: Vec<Inertia> = self.snapshot.field.inertias.clone();
        let momenta = inertias.iter().zip(&motions);
        let mut momenta: Vec<Force> = momenta.map(|(of, motion)| of.of(motion)).collect();
        for index in (0..tree.nodes.len()).rev() {
            if let Some(parent) = tree.nodes[index].parent {
                let (inertia, momentum) = (inertias[index], momenta[index]);
                inertias[parent] += inertia;
                momenta[parent] += momentum;
            }
        }
        let pushed = self.snapshot.turn.tr_mul(impulse);
        let count = self.columns.len();
        let mut right = DMatrix::zeros(count, count);
        for (j, column) in self.columns.iter().enumerate() {
            let gained = self.above(column, &motions).cross(&column.axis);
            for (i, row) in self.columns.iter().enumerate() {
                let axis = &row.axis;
                let is_beyond = self.carries(column.node, row.node);
                if self.carries(row.node, self.node) {
                    let mut change = axis.angular.cross(&self.moved[j]);
                    if is_beyond {
                        change += column.axis.cross(axis).at(&self.place_m);
                    }
                    right[(i, j)] += change.dot(&pushed);
                }
                if is_beyond && let (Some(_), Some(node)) = (column.node, row.node) {
                    right[(i, j)] -= axis.dot(&inertias[node].of(&gained));
                } else if !is_beyond
                    && self.carries(row.node, column.node)
                    && let Some(node) = column.node
                {
                    let turned =
                        column.axis.cross_force(&momenta[node]) + inertias[node].of(&gained);
                    right[(i, j)] -= axis.dot(&turned);
                }
            }
        }
        right
    }

    /// `M⁻¹` of the columns.
    fn solve(&self, right: DMatrix<f64>) -> DMatrix<f64> {
        let snapshot = self.snapshot;
        let (tree, shift, count) = (snapshot.tree, snapshot.tree.shift(), self.columns.len());
        let stride = count.next_multiple_of(LANES);
        let mut rows = vec![0.0; count * stride];
        let mut result = right;
        let turn = |matrix: &mut DMatrix<f64>, is_back: bool| {
            for column in 0..if shift > 0 { count } else { 0 } {
                let world = matrix.fixed_view::<3, 1>(0, column).into_owned();
                let turned = match is_back {
                    true => snapshot.turn * world,
                    false => snapshot.turn.tr_mul(&world),
                };
                matrix.fixed_view_mut::<3, 1>(0, column).copy_from(&turned);
            }
        };
        turn(&mut result, false);
        // A free base's translation comes last there.
        let place = |row: usize| (row + count - shift) % count;
        for row in 0..count {
            for column in 0..count {
                rows[place(row) * stride + column] = result[(row, column)];
            }
        }
        let mut articulated = snapshot.field.articulated.clone();
        articulated.solve_many(tree, &mut rows, stride);
        for row in 0..count {
            for column in 0..count {
                result[(row, column)] = rows[place(row) * stride + column];
            }
        }
        turn(&mut result, true);
        result
    }
}
