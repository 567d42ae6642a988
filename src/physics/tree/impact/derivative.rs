//! Derivatives of a tree's impact by the state before and by the law: those of the law of bodies, chained with
//! those of the contact's velocity and of its response to impulses ([`Point`]).

use nalgebra::{DMatrix, DVector, Vector3};

use super::point::Point;
use super::{Solved, TreeImpact};
use crate::physics::contact::{Contact, Frame};
use crate::physics::impact::{CoulombChange, ImpactError, Law};
use crate::physics::state::{DIMENSION, part};
use crate::physics::tree::snapshot::Snapshot;
use crate::physics::tree::state::TreeState;

/// Derivatives of a [`TreeImpact`](super::TreeImpact). Columns of a state are those of the tree's tangents.
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

impl Snapshot<'_> {
    /// [`Snapshot::impact`] with its derivatives. Fails and panics as that does.
    pub fn impact_derivative(
        &self,
        state: &TreeState,
        (link, contact): (usize, &Contact),
        law: &Law,
    ) -> Result<(TreeImpact, TreeImpactDerivative), ImpactError> {
        let solved = self.solved(link, contact, law)?;
        let derivative = self.derivative_of(&solved, state, (link, contact))?;
        Ok((solved.impact(state), derivative))
    }

    fn derivative_of(
        &self,
        solved: &Solved,
        state: &TreeState,
        (link, contact): (usize, &Contact),
    ) -> Result<TreeImpactDerivative, ImpactError> {
        let freedoms = self.tree.freedoms();
        let frame = Frame::of(&self.link_state(link));
        let (touch, by_pose) = contact
            .touch_derivative(&frame, &Frame::world())
            .map_err(|reason| ImpactError::Degenerate { contact: 0, reason })?;
        let mut of_link = DMatrix::zeros(DIMENSION, 2 * freedoms);
        self.link_jacobian(link, &mut of_link);
        let poses = of_link.rows(part::POSITION, 6);
        let gap = (by_pose.gap.fixed_columns::<6>(0) * poses).transpose();
        let normals = by_pose.normal.fixed_columns::<6>(0) * poses;
        let slides = by_pose.on_a.fixed_columns::<6>(0) * poses;
        let point = Point::new(self, (link, &touch.on_a_m), |column| {
            slides.fixed_view::<3, 1>(0, column).into_owned()
        });

        let mut jacobian = DMatrix::zeros(3, freedoms);
        self.point_jacobian(link, &touch.on_a_m, &mut jacobian);
        let velocities = point.velocity_changes(&state.rates, self.root_velocity());
        let responses = [
            *solved.law.normal(),
            solved.law.stuck(),
            solved.law.stuck_twice(),
            solved.impulse_n_s,
        ]
        .map(|impulse| point.response(&impulse, &solved.response));
        let delassus = |of: usize, column: usize| -> Vector3<f64> {
            let (steady, changed) = &responses[of];
            let by_rates = &jacobian * changed.column(column);
            steady[column] + Vector3::new(by_rates[0], by_rates[1], by_rates[2])
        };
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
                    // A face of the world: it does not turn.
                    Some(_) => Vector3::zeros(),
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
}
