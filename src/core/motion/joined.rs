//! The motion of bodies joined in a tree.

use nalgebra::Vector3;

use super::index::{MechanismIndex, TrackIndex};
use crate::physics::tree::{Flow, Tree, TreeState, tableau};

/// The estimated motion of bodies joined in a tree.
#[derive(Clone, Debug, PartialEq)]
pub struct TreeEstimate {
    /// What moves.
    pub mechanism: MechanismIndex,
    /// States in order of time, the first at the beginning and the last at the end.
    pub knots: Vec<TreeKnot>,
    /// Longest step of the integrator between them \[s\].
    pub step_s: f64,
    /// How far the motion is from what each track saw.
    pub residuals: Vec<TrackResidual>,
    /// Standard deviation of the prior that holds rates at the beginning [rad/s].
    pub rate_sd_rad_s: f64,
}

/// A state of a tree.
#[derive(Clone, Debug, PartialEq)]
pub struct TreeKnot {
    /// Physical time \[s\].
    pub time_s: f64,
    /// State at that time.
    pub state: TreeState,
}

/// Residuals of what one track saw.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrackResidual {
    /// The track.
    pub track: TrackIndex,
    /// Number of samples.
    pub samples: usize,
    /// Root mean square distance \[m\]; `None` where no place is seen.
    pub position_rms_m: Option<f64>,
    /// Root mean square angle \[rad\]; `None` where neither orientation nor direction is seen.
    pub orientation_rms_rad: Option<f64>,
}

impl TreeEstimate {
    /// Beginning and end of the motion \[s\].
    pub fn span_s(&self) -> [f64; 2] {
        [
            self.knots[0].time_s,
            self.knots[self.knots.len() - 1].time_s,
        ]
    }

    /// Whether all states are finite.
    pub fn is_finite(&self) -> bool {
        self.knots.iter().all(|knot| {
            let mut numbers = knot.state.coordinates.iter().chain(&knot.state.rates);
            numbers.all(|number| number.is_finite())
        })
    }

    /// The state at a time within the motion before what happens then: the first of two states at that time.
    pub fn state_before(&self, tree: &Tree, gravity_m_s2: &Vector3<f64>, time_s: f64) -> TreeState {
        let mut there = self.knots.iter();
        let there = there.find(|knot| knot.time_s == time_s);
        there.map_or_else(
            || self.state(tree, gravity_m_s2, time_s),
            |knot| knot.state.clone(),
        )
    }

    /// The state at a time within the motion: what the flow leads to from the last knot before it.
    pub fn state(&self, tree: &Tree, gravity_m_s2: &Vector3<f64>, time_s: f64) -> TreeState {
        let after = self.knots.partition_point(|knot| knot.time_s <= time_s);
        let from = &self.knots[after.max(1) - 1];
        let since_s = time_s - from.time_s;
        if since_s <= 0.0 {
            return from.state.clone();
        }
        let mut flow = Flow::new(tree, gravity_m_s2, tableau::DORMAND_PRINCE);
        flow.begin(&from.state, false);
        let steps = (since_s / self.step_s).ceil() as usize;
        flow.advance(since_s, steps.max(1));
        flow.state()
    }
}
