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
//! and `w = M⁻¹ Jᵀ p` changes by `M⁻¹ (δ(Jᵀ) p − δM w)`. A coordinate of another tree only lets the point slide on
//! its link.

use std::ops::Range;

use nalgebra::{DMatrix, Vector3};

use crate::physics::tree::articulated::LANES;
use crate::physics::tree::snapshot::Snapshot;
use crate::physics::tree::spatial::{Force, Inertia, Motion};

/// What moves with a coordinate.
struct PointColumn {
    axis: Motion,
    /// The first node that moves; none: everything, with a free base's place.
    node: Option<usize>,
}

/// A tree of the forest, and what moves in it with each of its coordinates.
pub(super) struct Moves<'a> {
    snapshot: &'a Snapshot<'a>,
    /// Its place among the trees,
    pub(super) tree: usize,
    /// and those of its rates among all.
    pub(super) rates: Range<usize>,
    columns: Vec<PointColumn>,
}

/// The contact point on a link of a tree, and what its place changes with.
pub(super) struct Point<'a> {
    moves: &'a Moves<'a>,
    node: Option<usize>,
    /// In the frame \[m\].
    place_m: Vector3<f64>,
    /// Change of the place with each coordinate of the forest.
    moved: Vec<Vector3<f64>>,
}

impl<'a> Moves<'a> {
    pub(super) fn new(snapshot: &'a Snapshot<'a>, tree: usize, rates: Range<usize>) -> Self {
        let of = snapshot.tree;
        let translations = (0..of.shift()).map(|axis| PointColumn {
            axis: Motion {
                angular: Vector3::zeros(),
                linear: snapshot.turn.tr_mul(&Vector3::ith(axis, 1.0)),
            },
            node: None,
        });
        let turns = of.nodes.iter().enumerate().flat_map(|(index, node)| {
            let axes = &snapshot.field.kinematics.axes;
            node.columns().map(move |column| PointColumn {
                axis: axes[column],
                node: Some(index),
            })
        });
        Self {
            snapshot,
            tree,
            rates,
            columns: translations.chain(turns).collect(),
        }
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

    /// Motions of the nodes at these rates of the forest; the last is that of what the first hang from.
    fn motions(&self, rates: &[f64], root: Motion) -> Vec<Motion> {
        let rates = &rates[self.rates.clone()];
        let tree = self.snapshot.tree;
        let moving = |range: Range<usize>| {
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
    fn above(&self, column: &PointColumn, motions: &[Motion]) -> Motion {
        let Some(node) = column.node else {
            return Motion::ZERO;
        };
        let last = motions.len() - 1;
        motions[self.snapshot.tree.nodes[node].parent.unwrap_or(last)]
    }

    /// Takes `δM w` by its own coordinates off right sides: a row per own rate, a column per coordinate of the forest.
    pub(super) fn take_inertia(&self, rates: &[f64], right: &mut DMatrix<f64>) {
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
        for (j, column) in self.columns.iter().enumerate() {
            let gained = self.above(column, &motions).cross(&column.axis);
            let at = self.rates.start + j;
            for (i, row) in self.columns.iter().enumerate() {
                let axis = &row.axis;
                let is_beyond = self.carries(column.node, row.node);
                if is_beyond && let (Some(_), Some(node)) = (column.node, row.node) {
                    right[(i, at)] -= axis.dot(&inertias[node].of(&gained));
                } else if !is_beyond
                    && self.carries(row.node, column.node)
                    && let Some(node) = column.node
                {
                    let turned =
                        column.axis.cross_force(&momenta[node]) + inertias[node].of(&gained);
                    right[(i, at)] -= axis.dot(&turned);
                }
            }
        }
    }

    /// `M⁻¹` of the columns of its own rates.
    pub(super) fn solve(&self, right: DMatrix<f64>) -> DMatrix<f64> {
        let snapshot = self.snapshot;
        let (tree, shift, count) = (snapshot.tree, snapshot.tree.shift(), self.columns.len());
        let width = right.ncols();
        let stride = width.next_multiple_of(LANES);
        let mut rows = vec![0.0; count * stride];
        let mut result = right;
        let turn = |matrix: &mut DMatrix<f64>, is_back: bool| {
            for column in 0..if shift > 0 { width } else { 0 } {
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
            for column in 0..width {
                rows[place(row) * stride + column] = result[(row, column)];
            }
        }
        let mut articulated = snapshot.field.articulated.clone();
        articulated.solve_many(tree, &mut rows, stride);
        for row in 0..count {
            for column in 0..width {
                result[(row, column)] = rows[place(row) * stride + column];
            }
        }
        turn(&mut result, true);
        result
    }
}

impl<'a> Point<'a> {
    /// The point of a link [m, link]; the columns of `slides` say how it moves on the link with each coordinate of
    /// the forest.
    pub(super) fn new(
        moves: &'a Moves<'a>,
        link: usize,
        on_link_m: &Vector3<f64>,
        slides: &DMatrix<f64>,
    ) -> Self {
        let snapshot = moves.snapshot;
        let world_from_link = snapshot.world_from_link(link);
        let node = snapshot.tree.links[link].0;
        let place_m = snapshot
            .turn
            .tr_mul(&(snapshot.point(link, on_link_m) - snapshot.origin_m));
        let moved = slides.column_iter().enumerate().map(|(index, slide)| {
            let own = world_from_link.rotation * slide.fixed_rows::<3>(0).into_owned();
            let slid = snapshot.turn.tr_mul(&own);
            let column = moves.rates.contains(&index);
            let column = column.then(|| &moves.columns[index - moves.rates.start]);
            match column {
                Some(column) if moves.carries(column.node, node) => slid + column.axis.at(&place_m),
                _ => slid,
            }
        });
        Self {
            moves,
            node,
            place_m,
            moved: moved.collect(),
        }
    }

    /// Whether it is on a link of that tree.
    pub(super) fn is_on(&self, moves: &Moves) -> bool {
        self.moves.tree == moves.tree
    }

    /// `δ(J) w` by each coordinate of the forest [world], of these rates of the forest; of a state, with the velocity
    /// of what the tree hangs from.
    pub(super) fn velocity_changes(&self, rates: &[f64], is_state: bool) -> Vec<Vector3<f64>> {
        let Some(node) = self.node else {
            return vec![Vector3::zeros(); self.moved.len()];
        };
        let moves = self.moves;
        let root = match is_state {
            true => moves.snapshot.root_velocity(),
            false => Motion::ZERO,
        };
        let motions = moves.motions(rates, root);
        let own = motions[node];
        let slid = |moved: &Vector3<f64>| own.angular.cross(moved);
        let mut changes: Vec<Vector3<f64>> = self.moved.iter().map(slid).collect();
        for (column, change) in moves
            .columns
            .iter()
            .zip(&mut changes[moves.rates.clone()])
            .filter(|(column, _)| moves.carries(column.node, self.node))
        {
            let against = own - moves.above(column, &motions);
            *change += column.axis.cross(&against).at(&self.place_m);
        }
        let in_world = changes.iter().map(|change| moves.snapshot.turn * change);
        in_world.collect()
    }

    /// Adds `δ(Jᵀ) p` [world] to right sides: a row per rate of its tree, a column per coordinate of the forest.
    pub(super) fn push(&self, impulse: &Vector3<f64>, right: &mut DMatrix<f64>) {
        let moves = self.moves;
        let pushed = moves.snapshot.turn.tr_mul(impulse);
        for (i, row) in moves.columns.iter().enumerate() {
            if !moves.carries(row.node, self.node) {
                continue;
            }
            let axis = &row.axis;
            for (j, moved) in self.moved.iter().enumerate() {
                let mut change = axis.angular.cross(moved);
                let own = j.checked_sub(moves.rates.start);
                let own = own.and_then(|own| moves.columns.get(own));
                if let Some(column) = own.filter(|of| moves.carries(of.node, row.node)) {
                    change += column.axis.cross(axis).at(&self.place_m);
                }
                right[(i, j)] += change.dot(&pushed);
            }
        }
    }
}
