//! The law of an impact of trees at its contacts: with friction at one, Newton's rule at several.

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

use super::met::{Met, stacked, thirds};
use crate::physics::impact::{Coulomb, CoulombChange, ImpactError, Law, Newton};

/// The law with its intermediate results. Impulses are those on A \[N s\], three rows of each contact along the world's
/// axes.
#[expect(
    clippy::large_enum_variant,
    reason = "one lives for one impact; a box would allocate"
)]
pub(super) enum Rule {
    /// At one contact.
    Coulomb(Coulomb),
    /// Along the normals of several.
    Newton(Newton),
}

/// How a contact changes.
pub(super) struct MetChange {
    /// Its tilted normal [world].
    pub(super) normal: Vector3<f64>,
    /// Its relative velocity [m/s, world].
    pub(super) velocity: Vector3<f64>,
}

impl Rule {
    /// Fails where the joints hold the one contact along the normal, or several depend on each other.
    pub(super) fn new(
        law: &Law,
        met: &[Met],
        delassus: &DMatrix<f64>,
    ) -> Result<Self, ImpactError> {
        if let [only] = met {
            let delassus: Matrix3<f64> = delassus.fixed_view::<3, 3>(0, 0).into_owned();
            let delassus = (delassus + delassus.transpose()) * 0.5;
            let of = Coulomb::of_joined(law, &only.normal, &only.velocity_m_s, &delassus)?;
            return Ok(Self::Coulomb(of));
        }
        assert!(law.friction == 0.0, "friction at several contacts");
        let (mut along, mut speeds) = (Matrix3::zeros(), Vector3::zeros());
        for (row, of) in met.iter().enumerate() {
            speeds[row] = of.normal.dot(&of.velocity_m_s);
            for (column, other) in met.iter().enumerate() {
                let block = delassus.fixed_view::<3, 3>(3 * row, 3 * column);
                along[(row, column)] = of.normal.dot(&(block * other.normal));
            }
        }
        let along = (along + along.transpose()) * 0.5;
        let of = Newton::new(law.restitution, met.len(), &speeds, &along)?;
        Ok(Self::Newton(of))
    }

    pub(super) fn impulses(&self, met: &[Met]) -> DVector<f64> {
        match self {
            Self::Coulomb(of) => stacked([of.impulse()]),
            Self::Newton(of) => along(met, &of.impulses()),
        }
    }

    pub(super) fn sticks(&self) -> bool {
        matches!(self, Self::Coulomb(of) if of.sticks())
    }

    /// Impulses whose response must be known, as it changes, to tell how the law's change.
    pub(super) fn tried(&self, met: &[Met]) -> Vec<DVector<f64>> {
        match self {
            Self::Coulomb(of) => {
                let tried = [*of.normal(), of.stuck(), of.stuck_twice()];
                tried.map(|impulse| stacked([impulse])).to_vec()
            }
            Self::Newton(_) => vec![self.impulses(met)],
        }
    }

    /// Changes of the impulses under changes of the velocities only.
    pub(super) fn by_velocities(&self, met: &[Met], velocities: &[Vector3<f64>]) -> DVector<f64> {
        match self {
            Self::Coulomb(of) => stacked([of.by_velocity(velocities[0])]),
            Self::Newton(of) => {
                let mut speeds = Vector3::zeros();
                for (row, (of, velocity)) in met.iter().zip(velocities).enumerate() {
                    speeds[row] = of.normal.dot(velocity);
                }
                along(met, &of.by_speeds(&speeds))
            }
        }
    }

    /// Changes of the impulses: `responses` are those of the velocities after the [tried](Self::tried) impulses, which stay
    /// as they are in the world.
    pub(super) fn change(
        &self,
        met: &[Met],
        delassus: &DMatrix<f64>,
        by: &[MetChange],
        responses: &[DVector<f64>],
    ) -> DVector<f64> {
        let of = match self {
            Self::Newton(of) => of,
            Self::Coulomb(of) => {
                let response = |tried: usize| responses[tried].fixed_rows::<3>(0).into_owned();
                return stacked([of.change(&CoulombChange {
                    normal: by[0].normal,
                    velocity: by[0].velocity,
                    delassus_normal: response(0),
                    delassus_stuck: response(1),
                    delassus_rigid: response(2),
                })]);
            }
        };
        let sizes = of.impulses();
        // The impulses turn with the normals.
        let turned = by
            .iter()
            .zip(sizes.iter())
            .map(|(by, size)| by.normal * *size);
        let turned = stacked(turned);
        let gained = thirds(&(delassus * self.impulses(met)));
        let more = thirds(&(delassus * &turned + &responses[0]));
        let (mut speeds, mut answers) = (Vector3::zeros(), Vector3::zeros());
        for (row, (of, by)) in met.iter().zip(by).enumerate() {
            speeds[row] = by.normal.dot(&of.velocity_m_s) + of.normal.dot(&by.velocity);
            answers[row] = by.normal.dot(&gained[row]) + of.normal.dot(&more[row]);
        }
        along(met, &of.change(&speeds, &answers)) + turned
    }

    pub(super) fn by_restitution(&self, met: &[Met]) -> DVector<f64> {
        match self {
            Self::Coulomb(of) => stacked([of.by_restitution()]),
            Self::Newton(of) => along(met, &of.by_restitution()),
        }
    }

    pub(super) fn by_tangential_restitution(&self, met: &[Met]) -> DVector<f64> {
        match self {
            Self::Coulomb(of) => stacked([of.by_tangential_restitution()]),
            Self::Newton(_) => DVector::zeros(3 * met.len()),
        }
    }

    pub(super) fn by_friction(&self, met: &[Met]) -> DVector<f64> {
        match self {
            Self::Coulomb(of) => stacked([of.by_friction()]),
            Self::Newton(_) => DVector::zeros(3 * met.len()),
        }
    }
}

/// Impulses of these sizes along the normals.
fn along(met: &[Met], sizes: &Vector3<f64>) -> DVector<f64> {
    stacked(
        met.iter()
            .zip(sizes.iter())
            .map(|(of, size)| of.normal * *size),
    )
}
