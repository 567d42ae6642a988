//! The continuation of a motion past the sketch until it rests (paper §6.2.3).

use typed_index_collections::TiVec;

use super::index::LinkIndex;
use super::spread::Spread;
use crate::math::Pose;

/// The motion after the estimate's end, by forward simulation.
#[derive(Clone, Debug, PartialEq)]
pub struct Settled {
    /// Physical time from which every link is simulated \[s\]: the end of the last arc.
    pub from_s: f64,
    /// Time between two poses \[s\].
    pub interval_s: f64,
    /// One per link of the scene.
    pub links: TiVec<LinkIndex, SettledLink>,
    /// Whether all links came to rest; otherwise some still move at the limit.
    pub at_rest: bool,
    /// Whether it is to say where the bodies come to rest, and what was seen of that was not used; otherwise it shows a
    /// way to rest after the end of what was performed.
    pub is_predicted: bool,
    /// How far the prediction may be off, where that is known.
    pub spread: Option<Spread>,
    /// Largest speed of a centre of mass [m/s] among the states at multiples of the interval.
    pub largest_speed_m_s: f64,
}

/// The simulated motion of one link.
#[derive(Clone, Debug, PartialEq)]
pub struct SettledLink {
    /// World from link at `from_s` and every interval after it; empty for a link without arcs.
    pub poses: Vec<Pose>,
}

impl Settled {
    /// Physical time of the last pose \[s\].
    pub fn end_s(&self) -> f64 {
        let poses = self.links.iter().map(|link| link.poses.len()).max();
        let steps = poses.unwrap_or(0).saturating_sub(1);
        self.from_s + steps as f64 * self.interval_s
    }
}
