//! What the tosses were measured with, and which there are.

use enact_tools::objects::scene::Trust;
use nalgebra::Vector3;

use super::answer::Answer;
use super::facts::Facts;
use super::judge::said;
use super::told::{Asked, Told};

/// What all of it was measured with.
pub struct With<'a> {
    pub trust: &'a Trust,
    pub gravity_m_s2: &'a Vector3<f64>,
}

impl With<'_> {
    pub fn off_m_s2(&self, facts: &Facts) -> f64 {
        let acceleration = facts.acceleration_m_s2;
        acceleration.map_or(f64::NAN, |a| (a - self.gravity_m_s2).norm())
    }

    pub fn said(&self, answer: &Answer, facts: &Facts) -> String {
        said(answer, facts, self.trust, self.off_m_s2(facts))
    }
}

pub fn half(told: &Told) -> &'static str {
    if told.is_for_choosing {
        "choosing"
    } else {
        "reported"
    }
}

pub fn seen(told: &[Told]) -> impl Iterator<Item = (&Told, &Asked)> {
    told.iter()
        .filter_map(|told| Some((told, told.seen.as_ref()?)))
}
