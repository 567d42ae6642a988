//! The impact of a contact set, with and without derivatives.

use super::contact_set::ContactSet;
use super::derivative::ImpactDerivative;
use super::error::ImpactError;
use super::knock::Knock;
use super::law::{Impact, Law, Side};
use super::model::ImpactByModel;
use super::plane;
use super::solution::ImpactSolution;

impl ContactSet {
    /// The impact of A with B, or with the static world.
    ///
    /// Fails where a contact is degenerate or the contacts depend on each other. A contact that
    /// recedes is treated by the same formulas without friction, so that every iterate of a solver
    /// has a result. Panics where the law has friction, tangential restitution or tilt and the contact set admits
    /// none.
    pub fn impact(&self, a: &Side, b: Option<&Side>, law: &Law) -> Result<Impact, ImpactError> {
        self.check_law(law);
        Ok(ImpactSolution::new(self, a, b, law)?.impact())
    }

    /// What happens at each contact of [`ContactSet::impact`]; of a face that lands flat with friction, all of it as one.
    ///
    /// Fails and panics as that does.
    pub fn knocks(&self, a: &Side, b: Option<&Side>, law: &Law) -> Result<Vec<Knock>, ImpactError> {
        self.check_law(law);
        Ok(ImpactSolution::new(self, a, b, law)?.knocks())
    }

    /// [`ContactSet::impact`] with its derivatives, into `derivative`. Only entries for existing
    /// contacts and bodies are set; all others stay as they were.
    pub fn derivative(
        &self,
        a: &Side,
        b: Option<&Side>,
        law: &Law,
        derivative: &mut ImpactDerivative,
    ) -> Result<Impact, ImpactError> {
        self.check_law(law);
        if b.is_none()
            && !self.has_friction()
            && let [contact] = self.as_slice()
            && let Some(point) = plane::PointOnPlane::of(contact)
        {
            return Ok(point.derivative(a, law, derivative));
        }
        let solution = ImpactSolution::new(self, a, b, law)?;
        solution.derivative(derivative)?;
        Ok(solution.impact())
    }

    /// Derivatives of [`ContactSet::impact`] by the model: by inertia, by where features are on the
    /// bodies and in the world. A work of its own, beside [`ContactSet::derivative`].
    ///
    /// Fails and panics as that does.
    pub fn by_model(
        &self,
        a: &Side,
        b: Option<&Side>,
        law: &Law,
    ) -> Result<ImpactByModel, ImpactError> {
        self.check_law(law);
        ImpactSolution::new(self, a, b, law)?.by_model()
    }

    fn check_law(&self, law: &Law) {
        assert!(
            self.has_friction() || law.friction == 0.0,
            "friction in a meeting without"
        );
        assert!(
            law.tangential_restitution == 0.0 || self.has_friction() && self.as_slice().len() == 1,
            "tangential restitution without friction at one contact"
        );
        assert!(
            law.tilt_rad == [0.0; 2] || self.check_tilt().is_ok(),
            "a tilt where no face is touched"
        );
    }
}
