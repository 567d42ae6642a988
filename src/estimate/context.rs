//! Fixed data of a solve, and the guidance of its stages.

use super::layout::Layout;
use super::point::Point;
use super::problem::{Arc, Problem};
use super::samples::ArcSums;
use crate::physics::Dynamics;

/// The data that stay fixed while one problem is solved.
#[derive(Clone, Debug)]
pub struct SolveContext<'a> {
    /// The problem.
    pub problem: &'a Problem,
    /// Indices of its unknowns.
    pub layout: &'a Layout,
    /// Epochs: physical times at which the arcs' states hold \[s\].
    pub epochs_s: Vec<f64>,
    /// Sums of each plain arc's samples; empty where times are unknown.
    pub sums: Vec<Option<ArcSums>>,
}

impl<'a> SolveContext<'a> {
    /// A context about `point`.
    pub fn new(
        problem: &'a Problem,
        layout: &'a Layout,
        epochs_s: Vec<f64>,
        point: &Point,
    ) -> Self {
        let gravity = problem.gravity(&point.parameters);
        let sums = if problem.times_are_unknown() {
            Vec::new()
        } else {
            let arcs = problem.arcs.iter().zip(&point.arcs).zip(&epochs_s);
            arcs.map(|((arc, state), epoch_s)| {
                let Dynamics::Free(body) = &problem.dynamics[arc.mechanism];
                arc.is_plain.then(|| {
                    ArcSums::new(body, arc, &point.node_times_s, *epoch_s, state, &gravity)
                })
            })
            .collect()
        };
        Self {
            problem,
            layout,
            epochs_s,
            sums,
        }
    }
}

/// Temporary terms and bounds that lead a stage towards the optimum; none in the finish.
#[derive(Clone, Debug)]
pub struct Guidance {
    /// Upper bound of the normal speed before each of the scene's events [m/s]; empty: zero,
    /// contacts do not recede.
    pub approach_limits_m_s: Vec<f64>,
    /// Mean of the prior of event times \[s\].
    pub event_times_s: Vec<f64>,
    /// Standard deviation of that prior \[s\]; `None`: no prior.
    pub event_sd_s: Option<f64>,
    /// About so many orientations of an arc are used, evenly spread and weighted for all of them.
    pub orientations_per_arc: usize,
}

impl Guidance {
    /// No guidance; contacts do not recede.
    pub fn none() -> Self {
        Self {
            approach_limits_m_s: Vec::new(),
            event_times_s: Vec::new(),
            event_sd_s: None,
            orientations_per_arc: usize::MAX,
        }
    }

    /// Stride of the samples used of an arc whose times are unknown, so that at least the wanted
    /// number of orientations and as many samples as nodes are used.
    pub(super) fn stride(&self, arc: &Arc) -> usize {
        let samples = &arc.samples;
        let nodes = match (samples.first(), samples.last()) {
            (Some(first), Some(last)) => last.node - first.node + 1,
            _ => 1,
        };
        (samples.len() / self.orientations_per_arc.max(nodes)).max(1)
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{UnitQuaternion, Vector3};

    use super::*;
    use crate::estimate::problem::ArcSample;
    use crate::motion::{MechanismIndex, TrackIndex};

    fn arc(samples: usize, per_node: usize) -> Arc {
        let sample = |index: usize| ArcSample {
            position_m: Vector3::zeros(),
            orientation: UnitQuaternion::identity(),
            node: 3 + index / per_node,
            share: (index % per_node) as f64 / per_node as f64,
        };
        Arc {
            mechanism: MechanismIndex(0),
            track: TrackIndex(0),
            start: None,
            end: None,
            clock: None,
            acting: Vec::new(),
            is_plain: true,
            samples: (0..samples).map(sample).collect(),
        }
    }

    #[test]
    fn one_in_so_many_samples_is_read_and_no_fewer_than_there_are_nodes() {
        let coarse = Guidance {
            orientations_per_arc: 16,
            ..Guidance::none()
        };
        assert_eq!(coarse.stride(&arc(160, 160)), 10);
        assert_eq!(coarse.stride(&arc(160, 4)), 4);
        assert_eq!(coarse.stride(&arc(306, 17)), 17);
        assert_eq!(coarse.stride(&arc(160, 1)), 1);
        assert_eq!(coarse.stride(&arc(5, 1)), 1);
        assert_eq!(coarse.stride(&arc(0, 1)), 1);
        assert_eq!(Guidance::none().stride(&arc(160, 160)), 1);
    }
}
