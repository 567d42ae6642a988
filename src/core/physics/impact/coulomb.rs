//! The impulse at one contact with friction, by the law of Chatterjee and Ruina (see
//! [`super::Law`]):
//!
//! ```text
//! P = (1 + e) P_I + κ D,   P_I = −u/(n·W n) n,   P_II = −W⁻¹ v,   D = P_II − P_I
//! κ = 1 + e_t                           sticking
//! κ = μ (1 + e) |P_I| / (|T| − μ n·D)   sliding, with T = D − (n·D) n
//! ```

use nalgebra::{Matrix3, Vector3};

use super::error::ImpactError;
use super::law::Law;
use super::rows::Change;

/// Share of the greatest eigenvalue of `W` below which an impulse along an eigenvector moves nothing.
const RIGID: f64 = 1e-12;

/// The impulse with the intermediate results that its derivatives need.
pub(crate) struct Coulomb {
    law: Law,
    normal: Vector3<f64>,
    velocity: Vector3<f64>,
    delassus: Matrix3<f64>,
    inverse_delassus: Matrix3<f64>,
    /// `I − W⁻¹ W`: on directions along which no impulse moves the contact.
    rigid: Matrix3<f64>,
    /// `n·W n`.
    normal_delassus: f64,
    /// `n·P_I` [N s].
    plastic: f64,
    /// `D = P_II − P_I`.
    to_stick: Vector3<f64>,
    /// `κ`.
    share: f64,
    slide: Slide,
}

/// The case that determines `κ`.
enum Slide {
    /// `κ = 1 + e_t`.
    Sticks,
    /// `κ` is limited by the friction cone: direction of `T`, and `|T| − μ n·D`.
    Slides(Vector3<f64>, f64),
    /// The contact recedes, or `T` is zero: `κ = 0`.
    Free,
}

/// Changes of the law's inputs.
pub(crate) struct CoulombChange<const C: usize> {
    pub(crate) normal: Change<C>,
    pub(crate) velocity: Change<C>,
    /// Change of `W`, times `n`.
    pub(crate) delassus_normal: Change<C>,
    /// Change of `W`, times `P_II`.
    pub(crate) delassus_stuck: Change<C>,
    /// Change of `W`, times `W⁻¹ P_II`; of bodies it does not count.
    pub(crate) delassus_rigid: Change<C>,
}

impl Coulomb {
    /// Of bodies by themselves, whose `W` is regular.
    pub(crate) fn new(
        law: &Law,
        normal: &Vector3<f64>,
        velocity: &Vector3<f64>,
        delassus: &Matrix3<f64>,
    ) -> Result<Self, ImpactError> {
        let factor = delassus.cholesky().ok_or(ImpactError::NoResponse)?;
        let inverses = [factor.inverse(), Matrix3::zeros()];
        Ok(Self::with_inverse(
            law, normal, velocity, delassus, inverses,
        ))
    }

    /// Of bodies that joints may hold along some directions: `W⁻¹` is the pseudo-inverse. A contact's velocity
    /// `v = J u` is in the range of `W = J M⁻¹ Jᵀ`, so that `W P_II = −v` and all that the law promises stays.
    ///
    /// Fails where the normal is a direction along which nothing moves, or poses are not finite.
    pub(crate) fn of_joined(
        law: &Law,
        normal: &Vector3<f64>,
        velocity: &Vector3<f64>,
        delassus: &Matrix3<f64>,
    ) -> Result<Self, ImpactError> {
        if !delassus.iter().chain(velocity).all(|x| x.is_finite()) {
            return Err(ImpactError::NoResponse);
        }
        let eigen = delassus.symmetric_eigen();
        let least = RIGID * eigen.eigenvalues.max();
        if !(normal.dot(&(delassus * normal)) > least) {
            return Err(ImpactError::NoResponse);
        }
        let (mut inverse, mut rigid) = (Matrix3::zeros(), Matrix3::identity());
        for (value, vector) in eigen
            .eigenvalues
            .iter()
            .zip(eigen.eigenvectors.column_iter())
        {
            if *value > least {
                let square = vector * vector.transpose();
                inverse += square / *value;
                rigid -= square;
            }
        }
        if eigen.eigenvalues.iter().all(|value| *value > least) {
            rigid = Matrix3::zeros();
        }
        let inverses = [inverse, rigid];
        Ok(Self::with_inverse(
            law, normal, velocity, delassus, inverses,
        ))
    }

    fn with_inverse(
        law: &Law,
        normal: &Vector3<f64>,
        velocity: &Vector3<f64>,
        delassus: &Matrix3<f64>,
        [inverse_delassus, rigid]: [Matrix3<f64>; 2],
    ) -> Self {
        let normal_delassus = normal.dot(&(delassus * normal));
        let plastic = -normal.dot(velocity) / normal_delassus;
        let to_stick = -(inverse_delassus * velocity) - normal * plastic;
        let pressed = normal.dot(&to_stick);
        let tangential = to_stick - normal * pressed;
        let size = tangential.norm();
        let rebound = (1.0 + law.restitution) * plastic;
        let whole = 1.0 + law.tangential_restitution;
        let sticks = || whole * size <= law.friction * (rebound + whole * pressed);
        let (share, slide) = if !(plastic > 0.0) {
            (0.0, Slide::Free)
        } else if law.friction > 0.0 && sticks() {
            (whole, Slide::Sticks)
        } else if size > 0.0 {
            let margin = size - law.friction * pressed;
            let share = law.friction * rebound / margin;
            (share, Slide::Slides(tangential / size, margin))
        } else {
            (0.0, Slide::Free)
        };
        Self {
            law: *law,
            normal: *normal,
            velocity: *velocity,
            delassus: *delassus,
            inverse_delassus,
            rigid,
            normal_delassus,
            plastic,
            to_stick,
            share,
            slide,
        }
    }

    pub(crate) fn impulse(&self) -> Vector3<f64> {
        self.normal * ((1.0 + self.law.restitution) * self.plastic) + self.to_stick * self.share
    }

    pub(crate) fn sticks(&self) -> bool {
        matches!(self.slide, Slide::Sticks)
    }

    /// The tilted normal `n` of the law.
    pub(crate) fn normal(&self) -> &Vector3<f64> {
        &self.normal
    }

    /// `P_II`.
    pub(crate) fn stuck(&self) -> Vector3<f64> {
        self.to_stick + self.normal * self.plastic
    }

    /// Changes of the impulse under changes of the relative velocity only.
    pub(crate) fn by_velocity<const C: usize>(&self, velocity: Change<C>) -> Change<C> {
        self.change(&CoulombChange {
            normal: Change::zeros(),
            velocity,
            delassus_normal: Change::zeros(),
            delassus_stuck: Change::zeros(),
            delassus_rigid: Change::zeros(),
        })
    }

    /// `W⁻¹ P_II`.
    pub(crate) fn stuck_twice(&self) -> Vector3<f64> {
        self.inverse_delassus * self.stuck()
    }

    /// Changes of the impulse under changes of all inputs.
    pub(crate) fn change<const C: usize>(&self, by: &CoulombChange<C>) -> Change<C> {
        let (n, e) = (&self.normal, self.law.restitution);
        let speed = self.velocity.tr_mul(&by.normal) + n.tr_mul(&by.velocity);
        let delassus = (self.delassus * n).tr_mul(&by.normal) * 2.0 + n.tr_mul(&by.delassus_normal);
        let plastic = -(speed + delassus * self.plastic) / self.normal_delassus;
        let plastic_vector = n * plastic + by.normal * self.plastic;
        // With `δ(W⁻¹) = −W⁻¹ δW W⁻¹ + (I − W⁻¹ W) δW W⁻²` on the range of `W`.
        let stuck = self.rigid * by.delassus_rigid
            - self.inverse_delassus * (by.velocity + by.delassus_stuck);
        let to_stick = stuck - plastic_vector;
        let change = plastic_vector * (1.0 + e) + to_stick * self.share;
        let Slide::Slides(direction, margin) = &self.slide else {
            return change;
        };
        let mu = self.law.friction;
        let pressed = self.to_stick.tr_mul(&by.normal) + n.tr_mul(&to_stick);
        let size = direction.tr_mul(&(to_stick - by.normal * n.dot(&self.to_stick)));
        let share = (plastic * (mu * (1.0 + e)) - (size - pressed * mu) * self.share) / *margin;
        change + self.to_stick * share
    }

    /// Derivative of the impulse by the restitution.
    pub(crate) fn by_restitution(&self) -> Vector3<f64> {
        let share = match self.slide {
            Slide::Slides(_, margin) => self.law.friction * self.plastic / margin,
            Slide::Sticks | Slide::Free => 0.0,
        };
        self.normal * self.plastic + self.to_stick * share
    }

    /// Derivative of the impulse by the tangential restitution.
    pub(crate) fn by_tangential_restitution(&self) -> Vector3<f64> {
        match self.slide {
            Slide::Sticks => self.to_stick,
            Slide::Slides(..) | Slide::Free => Vector3::zeros(),
        }
    }

    /// Derivative of the impulse by the coefficient of friction.
    pub(crate) fn by_friction(&self) -> Vector3<f64> {
        match self.slide {
            Slide::Slides(_, margin) => {
                let rebound = (1.0 + self.law.restitution) * self.plastic;
                let pressed = self.normal.dot(&self.to_stick);
                self.to_stick * ((rebound + self.share * pressed) / margin)
            }
            Slide::Sticks | Slide::Free => Vector3::zeros(),
        }
    }
}
