//! Equations `M x = τ` with a tree's mass matrix `M`, in a time that grows with the number of links, by
//! articulated-body inertias (Featherstone, "Rigid Body Dynamics Algorithms", 2008, chapter 7). One
//! factorisation serves any number of right sides.
//!
//! From the tips to the root each column `S` is eliminated from the inertia `A` of all that hangs on it,
//!
//! ```text
//! U = A S,   D = Sᵀ U,   A ← A − U Uᵀ/D
//! ```
//!
//! and what is left is added to the parent's; a ball's three columns come one after the other. Since
//! all is in one frame nothing is transformed.

use nalgebra::{Matrix3, Vector3};

use super::model::Tree;
use super::spatial::{Force, Inertia, Motion};

/// Right sides that are solved at a time.
pub const LANES: usize = 4;

/// The factors of a mass matrix.
#[derive(Clone, Debug)]
pub struct Articulated {
    /// Per node: articulated inertia, as blocks `[[aa, al], [alᵀ, ll]]`.
    inertias: Vec<InertiaBlock>,
    /// Per column: `S`, `U` and `1/D`.
    columns: Vec<(Motion, Force, f64)>,
    /// Inverse of what a free base's translation meets.
    root: Matrix3<f64>,
    /// Per node: accelerations and forces of one right side, and of [`LANES`].
    accelerations: Vec<Motion>,
    forces: Vec<Force>,
    lanes: Vec<[[f64; LANES]; 6]>,
}

#[derive(Clone, Copy, Debug)]
struct InertiaBlock {
    aa: Matrix3<f64>,
    al: Matrix3<f64>,
    ll: Matrix3<f64>,
}

impl InertiaBlock {
    #[inline(always)]
    fn of(inertia: &Inertia) -> Self {
        Self {
            aa: inertia.second,
            al: inertia.first.cross_matrix(),
            ll: Matrix3::from_diagonal_element(inertia.mass),
        }
    }

    #[inline(always)]
    fn apply(&self, motion: &Motion) -> Force {
        Force {
            moment: self.aa * motion.angular + self.al * motion.linear,
            force: self.al.tr_mul(&motion.angular) + self.ll * motion.linear,
        }
    }

    /// `A − U Uᵀ s`.
    #[inline(always)]
    fn reduce(&mut self, force: &Force, scale: f64) {
        let scaled = *force * scale;
        for j in 0..3 {
            for i in 0..3 {
                self.aa[(i, j)] -= force.moment[i] * scaled.moment[j];
                self.al[(i, j)] -= force.moment[i] * scaled.force[j];
                self.ll[(i, j)] -= force.force[i] * scaled.force[j];
            }
        }
    }
}

impl Articulated {
    /// Room for a tree.
    pub fn new(tree: &Tree) -> Self {
        let nodes = tree.nodes.len();
        Self {
            inertias: vec![InertiaBlock::of(&Inertia::ZERO); nodes],
            columns: vec![(Motion::ZERO, Force::ZERO, 0.0); tree.columns],
            root: Matrix3::zeros(),
            accelerations: vec![Motion::ZERO; nodes],
            forces: vec![Force::ZERO; nodes],
            lanes: vec![[[0.0; LANES]; 6]; nodes],
        }
    }

    /// Factors the mass matrix of the nodes' inertias and the columns' axes.
    pub fn factor(&mut self, tree: &Tree, inertias: &[Inertia], axes: &[Motion]) {
        for (block, inertia) in self.inertias.iter_mut().zip(inertias) {
            *block = InertiaBlock::of(inertia);
        }
        let mut root = Matrix3::zeros();
        for (index, node) in tree.nodes.iter().enumerate().rev() {
            let mut block = self.inertias[index];
            for column in node.columns().rev() {
                let axis = axes[column];
                let force = block.apply(&axis);
                let inverse = 1.0 / axis.dot(&force);
                block.reduce(&force, inverse);
                self.columns[column] = (axis, force, inverse);
            }
            match node.parent {
                Some(parent) => {
                    let sum = &mut self.inertias[parent];
                    sum.aa += block.aa;
                    sum.al += block.al;
                    sum.ll += block.ll;
                }
                None => root += block.ll,
            }
        }
        if tree.is_free {
            // It is positive definite: no other column moves the base along.
            self.root = root.try_inverse().unwrap_or(Matrix3::zeros());
        }
    }

    /// `x = M⁻¹ τ` where the nodes' own forces are given along with the moments in `x`: solves
    /// `M x = τ − Σ Jᵀ f`. Returns the acceleration of a free base's translation.
    pub fn solve(&mut self, tree: &Tree, forces: &[Force], x: &mut [f64]) -> Vector3<f64> {
        self.forces.copy_from_slice(forces);
        let mut root = Vector3::zeros();
        for (index, node) in tree.nodes.iter().enumerate().rev() {
            let mut sum = self.forces[index];
            for column in node.columns().rev() {
                let (axis, force, inverse) = &self.columns[column];
                let rest = (x[column] - axis.dot(&sum)) * inverse;
                sum += *force * rest;
                x[column] = rest;
            }
            match node.parent {
                Some(parent) => self.forces[parent] += sum,
                None => root -= sum.force,
            }
        }
        let base = if tree.is_free {
            self.root * root
        } else {
            Vector3::zeros()
        };
        for (index, node) in tree.nodes.iter().enumerate() {
            let mut sum = match node.parent {
                Some(parent) => self.accelerations[parent],
                None => Motion {
                    angular: Vector3::zeros(),
                    linear: base,
                },
            };
            for column in node.columns() {
                let (axis, force, inverse) = &self.columns[column];
                x[column] -= sum.dot(force) * inverse;
                sum += *axis * x[column];
            }
            self.accelerations[index] = sum;
        }
        base
    }

    /// Accelerations of the nodes in the last [`Self::solve`].
    pub fn accelerations(&self) -> &[Motion] {
        &self.accelerations
    }

    /// `X ← M⁻¹ X` of a matrix stored by rows of `stride` numbers, a multiple of [`LANES`]: a row per
    /// column of the tree, then three for a free base's translation.
    pub fn solve_many(&mut self, tree: &Tree, x: &mut [f64], stride: usize) {
        for from in (0..stride).step_by(LANES) {
            self.solve_lanes(tree, &mut x[from..], stride);
        }
    }

    fn solve_lanes(&mut self, tree: &Tree, x: &mut [f64], stride: usize) {
        self.lanes.fill([[0.0; LANES]; 6]);
        let mut root = [[0.0; LANES]; 6];
        for (index, node) in tree.nodes.iter().enumerate().rev() {
            let mut sum = self.lanes[index];
            for column in node.columns().rev() {
                let (axis, force, inverse) = &self.columns[column];
                let row = &mut x[column * stride..column * stride + LANES];
                let along = dot(&six(axis.angular, axis.linear), &sum);
                for lane in 0..LANES {
                    row[lane] = (row[lane] - along[lane]) * inverse;
                }
                add(&mut sum, &six(force.moment, force.force), row);
            }
            let above = match node.parent {
                Some(parent) => &mut self.lanes[parent],
                None => &mut root,
            };
            for (above, own) in above.iter_mut().zip(&sum) {
                for lane in 0..LANES {
                    above[lane] += own[lane];
                }
            }
        }
        let mut base = [[0.0; LANES]; 6];
        if tree.is_free {
            let from = tree.columns * stride;
            for lane in 0..LANES {
                let right = [0, 1, 2].map(|i| x[from + i * stride + lane] - root[3 + i][lane]);
                let moved = self.root * Vector3::from(right);
                for i in 0..3 {
                    base[3 + i][lane] = moved[i];
                    x[from + i * stride + lane] = moved[i];
                }
            }
        }
        for (index, node) in tree.nodes.iter().enumerate() {
            let mut sum = match node.parent {
                Some(parent) => self.lanes[parent],
                None => base,
            };
            for column in node.columns() {
                let (axis, force, inverse) = &self.columns[column];
                let row = &mut x[column * stride..column * stride + LANES];
                let along = dot(&six(force.moment, force.force), &sum);
                for lane in 0..LANES {
                    row[lane] -= along[lane] * inverse;
                }
                add(&mut sum, &six(axis.angular, axis.linear), row);
            }
            self.lanes[index] = sum;
        }
    }
}

#[inline(always)]
fn six(a: Vector3<f64>, b: Vector3<f64>) -> [f64; 6] {
    [a.x, a.y, a.z, b.x, b.y, b.z]
}

#[inline(always)]
fn dot(vector: &[f64; 6], lanes: &[[f64; LANES]; 6]) -> [f64; LANES] {
    let mut sum = [0.0; LANES];
    for (number, row) in vector.iter().zip(lanes) {
        for lane in 0..LANES {
            sum[lane] += number * row[lane];
        }
    }
    sum
}

#[inline(always)]
fn add(lanes: &mut [[f64; LANES]; 6], vector: &[f64; 6], row: &[f64]) {
    for (sum, number) in lanes.iter_mut().zip(vector) {
        for lane in 0..LANES {
            sum[lane] += number * row[lane];
        }
    }
}
