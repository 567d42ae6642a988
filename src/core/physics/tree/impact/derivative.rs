//! Derivatives of an impact of trees by the state before and by the law: those of the law of bodies, chained with
//! those of the contacts' velocities and of their response to impulses ([`Point`]).

use nalgebra::{DMatrix, DVector, Vector3};

use super::met::{stacked, thirds};
use super::point::{Moves, Point};
use super::rule::MetChange;
use super::{LinkContact, SolvedImpulses, TreeImpact};
use crate::physics::impact::{ImpactError, Law};
use crate::physics::state::{DIMENSION, part};
use crate::physics::tree::forest::snapshot::ForestSnapshot;
use crate::physics::tree::state::TreeState;

/// Step of differences by time \[s\].
const STEP_S: f64 = 1e-5;

/// Derivatives of a [`TreeImpact`](super::TreeImpact). Columns of a state are those of the forest's tangents.
///
/// Exact on each side of the switches between sticking and sliding and between approaching and receding; on a
/// switch, the derivative of the reported branch.
#[derive(Clone, Debug, PartialEq)]
pub struct TreeImpactDerivative {
    /// Of the gap of each contact, by the state before.
    pub gaps: Vec<DVector<f64>>,
    /// Of their speeds along the untilted normals, by the state before.
    pub speeds: Vec<DVector<f64>>,
    /// Of the rates after, a row each, by the state before.
    pub rates: DMatrix<f64>,
    /// Of the rates after by the restitution.
    pub by_restitution: DVector<f64>,
    /// Of the rates after by the coefficient of friction.
    pub by_friction: DVector<f64>,
    /// Of the rates after by the tangential restitution.
    pub by_tangential_restitution: DVector<f64>,
    /// Of the rates after by the two tilts; `None` where one contact has no face.
    pub by_tilt: Option<DMatrix<f64>>,
    /// Of all by time, the state before held; `None` where no tree hangs from a hand.
    pub carried: Option<CarriedImpact>,
}

/// How an impact changes with time where all coordinates and rates before stay: hands move on.
#[derive(Clone, Debug, PartialEq)]
pub struct CarriedImpact {
    /// Of each gap [m/s].
    pub gaps: Vec<f64>,
    /// Of each speed along the untilted normals before [m/s²].
    pub speeds: Vec<f64>,
    /// Of the rates after.
    pub rates: DVector<f64>,
}

/// How a contact changes with the coordinates of the forest.
struct MovedContact<'a> {
    /// Its gap,
    gap: DMatrix<f64>,
    /// its untilted normal [world],
    normal: DMatrix<f64>,
    /// how B's face turns [rad, world],
    turn: DMatrix<f64>,
    /// its relative velocity, all rates held [m/s, world],
    velocities: Vec<Vector3<f64>>,
    /// and its points on both sides, with their signs.
    points: Vec<(f64, Point<'a>)>,
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
        let derivative = TreeImpactDerivative {
            carried: self.carried(state, contact, law)?,
            ..self.derivative_of(&solved, state, contact)?
        };
        Ok((solved.impact(state), derivative))
    }

    /// By central differences: a hand's path is smooth.
    fn carried(
        &self,
        state: &TreeState,
        of: &LinkContact,
        law: &Law,
    ) -> Result<Option<CarriedImpact>, ImpactError> {
        if !self.forest.is_in_hand() {
            return Ok(None);
        }
        let mut snapshot = self.clone();
        let mut at = |by_s: f64| {
            let there = TreeState {
                time_s: state.time_s + by_s,
                ..state.clone()
            };
            snapshot.set(&there);
            snapshot.impact(&there, of, law)
        };
        let (before, after) = (at(-STEP_S)?, at(STEP_S)?);
        let change = |after: &[f64], before: &[f64]| -> Vec<f64> {
            let both = after.iter().zip(before);
            both.map(|(after, before)| (after - before) / (2.0 * STEP_S))
                .collect()
        };
        Ok(Some(CarriedImpact {
            gaps: change(&after.gaps_m, &before.gaps_m),
            speeds: change(&after.speeds_m_s, &before.speeds_m_s),
            rates: change(&after.rates, &before.rates).into(),
        }))
    }

    fn derivative_of(
        &self,
        solved: &SolvedImpulses,
        state: &TreeState,
        of: &LinkContact,
    ) -> Result<TreeImpactDerivative, ImpactError> {
        let freedoms = self.forest.freedoms();
        let trees = self.moves(solved);
        let moved = (0..solved.met.len()).map(|at| self.moved(solved, at, of, state, &trees));
        let moved: Vec<MovedContact> = moved.collect::<Result<_, ImpactError>>()?;
        let response = |impulses: &DVector<f64>| response(solved, &trees, &moved, impulses);
        let own = response(&solved.impulses_n_s);
        let tried = solved.rule.tried(&solved.met);
        let tried: Vec<_> = tried.iter().map(response).collect();
        let (met, jacobian) = (&solved.met, &solved.jacobian);
        let mut speeds = vec![DVector::zeros(2 * freedoms); met.len()];
        let mut after = DMatrix::zeros(freedoms, 2 * freedoms);
        for column in 0..freedoms {
            let by = moved.iter().zip(met).map(|(moved, met)| MetChange {
                velocity: moved.velocities[column],
                normal: match met.normal_by_tilt {
                    // It turns with the face.
                    Some(_) => third(&moved.turn, 0, column).cross(&met.normal),
                    None => third(&moved.normal, 0, column),
                },
            });
            let by: Vec<MetChange> = by.collect();
            let tried = tried.iter().map(|(steady, changed)| {
                let by_rates = jacobian * changed.column(column);
                stacked(steady.iter().map(|of| of[column])) + by_rates
            });
            let tried: Vec<DVector<f64>> = tried.collect();
            let impulses = solved
                .rule
                .change(met.as_slice(), &solved.delassus, &by, &tried);
            let mut to = after.column_mut(column);
            to.copy_from(&own.1.column(column));
            to += &solved.response * impulses;
            for (speed, (moved, met)) in speeds.iter_mut().zip(moved.iter().zip(met)) {
                let normal = third(&moved.normal, 0, column);
                let velocity = &moved.velocities[column];
                speed[column] = met.touch.normal.dot(velocity) + met.velocity_m_s.dot(&normal);
            }
        }
        for rate in 0..freedoms {
            let column = freedoms + rate;
            let velocities = (0..met.len()).map(|at| third(jacobian, at, rate));
            let velocities: Vec<Vector3<f64>> = velocities.collect();
            let impulses = solved.rule.by_velocities(met, &velocities);
            let mut to = after.column_mut(column);
            to[rate] = 1.0;
            to += &solved.response * impulses;
            for (speed, (met, velocity)) in speeds.iter_mut().zip(met.iter().zip(&velocities)) {
                speed[column] = met.touch.normal.dot(velocity);
            }
        }
        let gap = |of: &MovedContact| of.gap.transpose().resize_vertically(2 * freedoms, 0.0);
        Ok(TreeImpactDerivative {
            gaps: moved
                .iter()
                .map(|of| gap(of).column(0).into_owned())
                .collect(),
            speeds,
            rates: after,
            by_restitution: &solved.response * solved.rule.by_restitution(met),
            by_friction: &solved.response * solved.rule.by_friction(met),
            by_tangential_restitution: &solved.response
                * solved.rule.by_tangential_restitution(met),
            by_tilt: solved.by_tilt(tried.len()),
            carried: None,
        })
    }

    fn moved<'m>(
        &self,
        solved: &SolvedImpulses,
        contact: usize,
        of: &LinkContact,
        state: &TreeState,
        trees: &'m [Moves<'m>],
    ) -> Result<MovedContact<'m>, ImpactError> {
        let freedoms = self.forest.freedoms();
        let [a, b] = &solved.frames;
        let (_, by_pose) = of.contacts.as_slice()[contact]
            .touch_derivative(a, b)
            .map_err(|reason| ImpactError::Degenerate { contact, reason })?;
        let sides = &solved.met[contact].sides;
        let (mut gap, mut normal) = (DMatrix::zeros(1, freedoms), DMatrix::zeros(3, freedoms));
        let mut slides = [DMatrix::zeros(3, freedoms), DMatrix::zeros(3, freedoms)];
        let mut turn = DMatrix::zeros(3, freedoms);
        let mut of_link = DMatrix::zeros(DIMENSION, 2 * freedoms);
        for (index, side) in sides.iter().enumerate() {
            self.link_jacobian(side.place, &mut of_link);
            let poses = of_link.view((part::POSITION, 0), (6, freedoms));
            let of_side = 6 * index;
            gap += by_pose.gap.fixed_columns::<6>(of_side) * poses;
            normal += by_pose.normal.fixed_columns::<6>(of_side) * poses;
            slides[0] += by_pose.on_a.fixed_columns::<6>(of_side) * poses;
            slides[1] += by_pose.on_b.fixed_columns::<6>(of_side) * poses;
            if index == 1 {
                let turns = of_link.view((part::ORIENTATION, 0), (3, freedoms));
                turn += b.orientation.to_rotation_matrix().matrix() * turns;
            }
        }
        let points = sides.iter().zip(&slides).map(|(side, slides)| {
            let (tree, link) = self.forest.tree_of(side.place);
            let moves = trees.iter().find(|of| of.tree == tree);
            let moves = moves.expect("all trees of the sides");
            (side.sign, Point::new(moves, link, &side.point_m, slides))
        });
        let points: Vec<(f64, Point)> = points.collect();
        Ok(MovedContact {
            gap,
            normal,
            turn,
            velocities: sum(&points, &state.rates, freedoms, true),
            points,
        })
    }

    /// The trees that take part, each once.
    fn moves(&self, solved: &SolvedImpulses) -> Vec<Moves<'_>> {
        let mut trees: Vec<usize> = Vec::new();
        // The sides of all contacts are the same links.
        for side in &solved.met[0].sides {
            let (tree, _) = self.forest.tree_of(side.place);
            if !trees.contains(&tree) {
                trees.push(tree);
            }
        }
        let trees = trees.into_iter();
        trees
            .map(|tree| Moves::new(&self.trees[tree], tree, self.forest.rates_of(tree)))
            .collect()
    }
}

impl SolvedImpulses {
    /// Rates after by the two tilts, all poses held; `tried` is how many responses the law asks for.
    fn by_tilt(&self, tried: usize) -> Option<DMatrix<f64>> {
        let met = &self.met;
        let normals: Option<Vec<_>> = met.iter().map(|met| met.normal_by_tilt).collect();
        let normals = normals?;
        let steady = vec![DVector::zeros(3 * met.len()); tried];
        let columns = [0, 1].map(|tilt| {
            let by = normals.iter().map(|normals| MetChange {
                normal: normals[tilt],
                velocity: Vector3::zeros(),
            });
            let by: Vec<MetChange> = by.collect();
            &self.response
                * self
                    .rule
                    .change(met.as_slice(), &self.delassus, &by, &steady)
        });
        Some(DMatrix::from_columns(&columns))
    }
}

/// Three rows of a contact.
fn third(of: &DMatrix<f64>, contact: usize, column: usize) -> Vector3<f64> {
    of.fixed_view::<3, 1>(3 * contact, column).into_owned()
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

/// `δ(J) w` of each contact and `δw` of `w = M⁻¹ Jᵀ p` by each coordinate.
fn response(
    solved: &SolvedImpulses,
    trees: &[Moves],
    moved: &[MovedContact],
    impulses: &DVector<f64>,
) -> (Vec<Vec<Vector3<f64>>>, DMatrix<f64>) {
    let rates = &solved.response * impulses;
    let freedoms = rates.len();
    let steady = moved.iter();
    let steady = steady.map(|of| sum(&of.points, rates.as_slice(), freedoms, false));
    let mut changed = DMatrix::zeros(freedoms, freedoms);
    for tree in trees {
        let mut right = DMatrix::zeros(tree.rates.len(), freedoms);
        for (of, impulse) in moved.iter().zip(thirds(impulses)) {
            for (sign, point) in of.points.iter().filter(|(_, point)| point.is_on(tree)) {
                point.push(&(impulse * *sign), &mut right);
            }
        }
        tree.take_inertia(rates.as_slice(), &mut right);
        let solved = tree.solve(right);
        changed
            .rows_range_mut(tree.rates.clone())
            .copy_from(&solved);
    }
    (steady.collect(), changed)
}
