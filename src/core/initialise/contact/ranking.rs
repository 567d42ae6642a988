//! Candidates of a collision, ranked.

use crate::motion::Contacts;

/// Greatest distance of a likely candidate beyond the first, in spreads.
const SPREADS_MAX: f64 = 4.0;

/// A candidate, and its distance from the performance.
#[derive(Clone, Debug, PartialEq)]
pub struct Reach {
    /// The contacts.
    pub contacts: Contacts,
    /// Change of the pose for which these contacts would touch first \[m\].
    pub reach_m: f64,
}

/// The candidates of one collision.
#[derive(Clone, Debug, PartialEq)]
pub struct Ranking {
    /// The collision (index into `Scene::events`).
    pub event: usize,
    /// Candidates; the one that touches first comes first.
    pub candidates: Vec<Reach>,
    /// Uncertainty of the bodies' surfaces at the event \[m\].
    pub spread_m: f64,
}

impl Ranking {
    /// Whether the second is as good as the first within the uncertainty.
    pub fn is_ambiguous(&self) -> bool {
        const SPREADS: f64 = 2.0;
        let reach_m = |index: usize| self.candidates.get(index).map(|c| c.reach_m);
        match (reach_m(0), reach_m(1)) {
            (Some(first_m), Some(second_m)) => second_m - first_m < SPREADS * self.spread_m,
            _ => false,
        }
    }

    /// Candidates that are not much farther from touching than the first.
    pub fn likely(&self) -> &[Reach] {
        let first_m = self.candidates.first().map_or(0.0, |first| first.reach_m);
        let most_m = first_m + SPREADS_MAX * self.spread_m;
        let count = self.candidates.partition_point(|c| c.reach_m <= most_m);
        &self.candidates[..count]
    }
}
