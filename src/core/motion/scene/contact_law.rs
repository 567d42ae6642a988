//! How things that touch part again.

/// Greatest restitution of a bumper; a larger one is a mistake.
const BUMPER_MAX: f64 = 10.0;

/// Restitution and friction of what touches: of an object, shared by all its impacts, or of one
/// event.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactLaw {
    /// Unique name: of the body or of the event to which it belongs.
    pub name: String,
    /// Coefficient of restitution, 0 to [`ContactLaw::most_restitution`].
    pub restitution: f64,
    /// Whether it is of a bumper, which gives energy where it is hit.
    pub is_bumper: bool,
    /// Coefficient of Coulomb friction, 0 or more.
    pub friction: f64,
    /// Tangential restitution, 0 to 1: with how much of its tangential velocity what sticks springs back.
    pub tangential_restitution: f64,
    /// Standard deviation of the restitution between occasions, as far as it is stated; zero where it is not.
    pub restitution_sd: f64,
    /// That of the friction.
    pub friction_sd: f64,
}

impl ContactLaw {
    /// Whether no deviation is stated: it is the same on all occasions.
    pub fn is_exact(&self) -> bool {
        self.restitution_sd == 0.0 && self.friction_sd == 0.0
    }

    /// The greatest restitution that it may have: 1, for no impact gains energy, unless a bumper gives it.
    pub fn most_restitution(&self) -> f64 {
        if self.is_bumper { BUMPER_MAX } else { 1.0 }
    }

    /// A law with restitution only.
    pub fn frictionless(name: impl Into<String>, restitution: f64) -> Self {
        Self {
            name: name.into(),
            restitution,
            is_bumper: false,
            friction: 0.0,
            tangential_restitution: 0.0,
            restitution_sd: 0.0,
            friction_sd: 0.0,
        }
    }
}
