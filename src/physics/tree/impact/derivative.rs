//! Derivatives of an impact of trees by the state before and by the law: those of the law of bodies, chained with
//! those of the contact's velocity and of its response to impulses ([`Point`]).

use nalgebra::{DMatrix, DVector, Vector3};

use super::point::{Moves, Point};
use super::{LinkContact, Solved, TreeImpact};
use crate::physics::impact::{CoulombChange, ImpactError, Law};
use crate::physics::state::{DIMENSION, part};
use crate::physics::tree::forest::snapshot::ForestSnapshot;
use crate::physics::tree::state::TreeState;

/// Derivatives of a [`TreeImpact`](super::TreeImpact). Columns of a state are those of the forest's tangents.
///
/// Exact on each side of the switches between sticking and sliding and between approaching and receding; on a
/// switch, the derivative of the reported branch.
#[derive(Clone, Debug, PartialEq)]
pub struct TreeImpactDerivative {
    /// Of the gap, by the state before.
    pub gap: DVector<f64>,
    /// Of the speed along the untilted normal, by the state before.
    pub speed: DVector<f64>,
    /// Of the rates after, a row each, by the state before.
    pub rates: DMatrix<f64>,
    /// Of the rates after by the restitution.
    pub by_restitution: DVector<f64>,
    /// Of the rates after by the coefficient of friction.
    pub by_friction: DVector<f64>,
    /// Of the rates after by the two tilts; `None` where no face is touched.
    pub by_tilt: Option<DMatrix<f64>>,
}

impl ForestSnapshot<'_> {
    /// [`ForestSnapshot::impact`] with its derivatives. Fails and panics as that does.
    pub fn impact_derivative(
        &self,
        state: &TreeState,
        contact: &LinkContact,
        law: &Law,
    ) -> Result<(TreeImpact, TreeImpactDerivative), ImpactError> {
        let solved = self.solved(contact, law)?;
        let derivative = self.derivative_of(&solved, state, contact)?;
        Ok((solved.impact(state), derivative))
    }

    fn derivative_of(
        &self,
        solved: &Solved,
        state: &TreeState,
        of: &LinkContact,
    ) -> Result<TreeImpactDerivative, ImpactError> {
        let freedoms = self.forest.freedoms();
        let [a, b] = &solved.frames;
        let (touch, by_pose) = of
            .contact
            .touch_derivative(a, b)
            .map_err(|reason| ImpactError::Degenerate { contact: 0, reason })?;
        let (mut gap, mut normals) = (DMatrix::zeros(1, freedoms), DMatrix::zeros(3, freedoms));
        let mut slides = [DMatrix::zeros(3, freedoms), DMatrix::zeros(3, freedoms)];
        // How the axes of B's face turn [rad, world].
        let mut turned = DMatrix::zeros(3, freedoms);
        let mut of_link = DMatrix::zeros(DIMENSION, 2 * freedoms);
        for (index, side) in solved.sides.iter().enumerate() {
            self.link_jacobian(side.place, &mut of_link);
            let poses = of_link.view((part::POSITION, 0), (6, freedoms));
            let of_side = 6 * index;
            gap += by_pose.gap.fixed_columns::<6>(of_side) * poses;
            normals += by_pose.normal.fixed_columns::<6>(of_side) * poses;
            slides[0] += by_pose.on_a.fixed_columns::<6>(of_side) * poses;
            slides[1] += by_pose.on_b.fixed_columns::<6>(of_side) * poses;
            if index == 1 {
                let turns = of_link.view((part::ORIENTATION, 0), (3, freedoms));
                turned += b.orientation.to_rotation_matrix().matrix() * turns;
            }
        }
        let moves = self.moves(solved);
        let of_tree = |tree: usize| moves.iter().find(|of| of.tree == tree);
        let points = solved.sides.iter().zip(&slides).map(|(side, slides)| {
            let (tree, link) = self.forest.tree_of(side.place);
            let moves = of_tree(tree).expect("all trees of the sides");
            let point = Point::new(moves, (link, &side.point_m), slides);
            (side.sign, point)
        });
        let points: Vec<(f64, Point)> = points.collect();
        let velocities = sum(&points, &state.rates, freedoms, true);
        let responses = [
            *solved.law.normal(),
            solved.law.stuck(),
            solved.law.stuck_twice(),
            solved.impulse_n_s,
        ]
        .map(|impulse| response(solved, (&moves, &points), &impulse));
        let jacobian = &solved.jacobian;
        let delassus = |of: usize, column: usize| -> Vector3<f64> {
            let (steady, changed) = &responses[of];
            let by_rates = jacobian * changed.column(column);
            steady[column] + Vector3::new(by_rates[0], by_rates[1], by_rates[2])
        };
        let gap = gap.transpose().resize_vertically(2 * freedoms, 0.0);
        let mut speed = DVector::zeros(2 * freedoms);
        let mut after = DMatrix::zeros(freedoms, 2 * freedoms);
        for column in 0..2 * freedoms {
            let is_rate = column >= freedoms;
            let (mut normal, mut velocity) = (Vector3::zeros(), Vector3::zeros());
            let impulse = if is_rate {
                let at = column - freedoms;
                velocity += jacobian.fixed_view::<3, 1>(0, at);
                after[(at, column)] = 1.0;
                solved.law.by_velocity(velocity)
            } else {
                velocity += velocities[column];
                normal += normals.fixed_view::<3, 1>(0, column);
                let tilted = match solved.normal_by_tilt {
                    // It turns with the face.
                    Some(_) => {
                        let turn = turned.fixed_view::<3, 1>(0, column).into_owned();
                        turn.cross(solved.law.normal())
                    }
                    None => normal,
                };
                let steady = &responses[3].1.column(column);
                after.column_mut(column).copy_from(steady);
                solved.law.change(&CoulombChange {
                    normal: tilted,
                    velocity,
                    delassus_normal: delassus(0, column),
                    delassus_stuck: delassus(1, column),
                    delassus_rigid: delassus(2, column),
                })
            };
            speed[column] = touch.normal.dot(&velocity) + solved.velocity_m_s.dot(&normal);
            let mut to = after.column_mut(column);
            to += &solved.response * impulse;
        }
        let by_tilt = solved.normal_by_tilt.map(|normals| {
            let columns = normals.map(|normal| {
                let impulse = solved.law.change(&CoulombChange {
                    normal,
                    velocity: Vector3::zeros(),
                    delassus_normal: Vector3::zeros(),
                    delassus_stuck: Vector3::zeros(),
                    delassus_rigid: Vector3::zeros(),
                });
                &solved.response * impulse
            });
            DMatrix::from_columns(&columns)
        });
        Ok(TreeImpactDerivative {
            gap: gap.column(0).into_owned(),
            speed,
            rates: after,
            by_restitution: &solved.response * solved.law.by_restitution(),
            by_friction: &solved.response * solved.law.by_friction(),
            by_tilt,
        })
    }

    /// The trees that take part, each once.
    fn moves(&self, solved: &Solved) -> Vec<Moves<'_>> {
        let mut trees: Vec<usize> = Vec::new();
        for side in &solved.sides {
            let (tree, _) = self.forest.tree_of(side.place);
            if !trees.contains(&tree) {
                trees.push(tree);
            }
        }
        let trees = trees.into_iter();
        trees
            .map(|tree| Moves::new(&self.trees[tree], (tree, self.forest.rates_of(tree))))
            .collect()
    }
}

/// `δ(J) w` by each coordinate, with or without the velocity of what trees hang from.
fn sum(
    points: &[(f64, Point)],
    rates: &[f64],
    freedoms: usize,
    is_state: bool,
) -> Vec<Vector3<f64>> {
    let mut all = vec![Vector3::zeros(); freedoms];
    for (sign, point) in points {
        for (sum, change) in all.iter_mut().zip(point.velocity_changes(rates, is_state)) {
            *sum += change * *sign;
        }
    }
    all
}

/// `δ(J) w` and `δw` of `w = M⁻¹ Jᵀ p` by each coordinate.
fn response(
    solved: &Solved,
    (moves, points): (&[Moves], &[(f64, Point)]),
    impulse: &Vector3<f64>,
) -> (Vec<Vector3<f64>>, DMatrix<f64>) {
    let rates = &solved.response * impulse;
    let freedoms = rates.len();
    let steady = sum(points, rates.as_slice(), freedoms, false);
    let mut changed = DMatrix::zeros(freedoms, freedoms);
    for of in moves {
        let mut right = DMatrix::zeros(of.rates.len(), freedoms);
        for (sign, point) in points.iter().filter(|(_, point)| point.is_on(of)) {
            point.push(&(impulse * *sign), &mut right);
        }
        of.take_inertia(rates.as_slice(), &mut right);
        let solved = of.solve(right);
        changed.rows_range_mut(of.rates.clone()).copy_from(&solved);
    }
    (steady, changed)
}
