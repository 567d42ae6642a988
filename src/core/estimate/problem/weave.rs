//! Which samples err together: those of one hand, from flight to flight, where their errors are a process in time. Trackers on
//! one body are in one hand.

use std::ops::Range;

use nalgebra::Vector3;

use super::influence::Acting;
use crate::estimate::wander::likelihood::LikelyErrors;
use crate::estimate::wander::{Gain, SampleInstant};
use crate::motion::{MechanismIndex, TrackIndex};

/// How impacts are seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kinks {
    /// As a hand acts them, which makes no sharp kink: samples near them are left out, and so are those that follow one another
    /// faster than a hand moves.
    Rounded,
    /// As they are: every sample counts.
    Sharp,
}

/// An impact, at which a path has a kink.
#[derive(Clone, Copy, Debug)]
pub struct Kink {
    /// \[s\].
    pub time_s: f64,
    /// By how much velocity [m/s, world] and spin [rad/s, body] jump.
    pub jumps: [Vector3<f64>; 2],
}

/// The samples of all hands, whose errors are a process.
#[derive(Clone, Debug)]
pub struct Weave {
    /// Errors of positions, and of orientations and directions, in units of residuals.
    pub errors: LikelyErrors,
    /// Hand by hand.
    pub hands: Vec<WovenHand>,
}

/// The samples of a hand.
#[derive(Clone, Debug)]
pub struct WovenHand {
    /// What it moves.
    pub mechanism: MechanismIndex,
    /// The first of its trackers.
    pub track: TrackIndex,
    /// One unit of residuals \[m, rad\], infinite where none are seen: trackers that weigh otherwise are by themselves.
    pub units: [f64; 2],
    /// Its flights, in order of time.
    pub arcs: Vec<WovenArc>,
    /// Parameters that act on any of them.
    pub parameters: Vec<usize>,
}

/// The samples of a flight.
#[derive(Clone, Debug)]
pub struct WovenArc {
    /// Index into [`Problem::arcs`](super::Problem::arcs).
    pub arc: usize,
    /// Parameters that act on it or on what is seen of it, gravity among them.
    pub acting: Vec<Acting>,
    /// Its samples, in order of time.
    pub samples: Vec<WovenSample>,
    /// Nodes of the time map whose unknown times move its samples; none where times are known.
    pub moved: Range<usize>,
    /// Of how many flights before it errors still tell of its own.
    pub remembered: usize,
    /// Whether positions that are seen depend on how the body is turned and turns: by a lever, or by lift.
    pub is_levered: bool,
    /// Whether a surface carries the body, so that places and turns depend on each other.
    pub is_carried: bool,
}

/// A sample.
#[derive(Clone, Copy, Debug)]
pub struct WovenSample {
    /// Index into [`Arc::views`](super::Arc::views).
    pub view: usize,
    /// Index into [`View::samples`](super::View::samples).
    pub sample: usize,
    /// When it was taken \[s, acted\].
    pub acted_s: f64,
    /// Variance of its noise as its message says, and as a hand rounds a kink that is near, of positions and of orientations, in units of residuals.
    pub noise_variances: [f64; 2],
    /// How it becomes independent of those before it, of positions and of orientations where it shows them.
    pub gains: [Option<Gain>; 2],
}

impl Weave {
    /// Parameters that act on a flight, and on what is seen of it.
    pub fn acting_on(&self, arc: usize) -> &[Acting] {
        let mut arcs = self.hands.iter().flat_map(|of| &of.arcs);
        let of = arcs.find(|of| of.arc == arc);
        of.map_or(&[], |of| &of.acting)
    }
}

impl WovenSample {
    /// When it was taken, as the errors of a kind see it.
    pub fn instant(&self, kind: usize) -> SampleInstant {
        SampleInstant {
            time_s: self.acted_s,
            noise_variance: self.noise_variances[kind],
        }
    }
}
