//! Fixed data of a solve, and the guidance of its stages.

use super::samples::ArcSums;
use crate::estimate::problem::{Problem, View};
use crate::estimate::unknowns::layout::Layout;
use crate::estimate::unknowns::point::Point;

/// The data that stay fixed while one problem is solved.
#[derive(Clone, Debug)]
pub struct SolveContext<'a> {
    /// The problem.
    pub problem: &'a Problem,
    /// Indices of its unknowns.
    pub layout: &'a Layout,
    /// Epochs: physical times at which the arcs' states hold \[s\].
    pub epochs_s: Vec<f64>,
    /// Sums of each plain view's samples ([`Problem::views`]); empty where times are unknown.
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
        let sums = if problem.times_are_unknown() || problem.weave.is_some() {
            Vec::new()
        } else {
            let views = problem.views().map(|(arc, view)| {
                let body = problem.body_of(arc);
                let (state, epoch_s) = (&point.arcs[arc], epochs_s[arc]);
                view.is_plain.then(|| {
                    ArcSums::new(body, view, &point.node_times_s, epoch_s, state, &gravity)
                })
            });
            views.collect()
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
    /// Greatest weight of a goal that has a weight, per squared unit.
    pub goal_weight_max: f64,
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
            goal_weight_max: f64::INFINITY,
            orientations_per_arc: usize::MAX,
        }
    }

    /// No guidance, and none of the goals that have a weight.
    pub(in crate::estimate) fn without_wishes() -> Self {
        Self {
            goal_weight_max: 0.0,
            ..Self::none()
        }
    }

    /// Stride of the samples used of a view whose times are unknown, so that at least the wanted
    /// number of orientations and as many samples as nodes are used.
    pub(in crate::estimate) fn stride(&self, view: &View) -> usize {
        let samples = &view.samples;
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
    use crate::estimate::problem::{ArcSample, Shows};
    use crate::motion::TrackIndex;

    fn view(samples: usize, per_node: usize) -> View {
        let sample = |index: usize| ArcSample {
            stamp: crate::motion::Stamp(0),
            position_m: Vector3::zeros(),
            orientation: UnitQuaternion::identity(),
            node: 3 + index / per_node,
            share: (index % per_node) as f64 / per_node as f64,
            open: None,
        };
        View {
            track: TrackIndex(0),
            shows: Shows::Pose,
            units: [1.0; 2],
            whitenings: Vec::new(),
            informations: Vec::new(),
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
        assert_eq!(coarse.stride(&view(160, 160)), 10);
        assert_eq!(coarse.stride(&view(160, 4)), 4);
        assert_eq!(coarse.stride(&view(306, 17)), 17);
        assert_eq!(coarse.stride(&view(160, 1)), 1);
        assert_eq!(coarse.stride(&view(5, 1)), 1);
        assert_eq!(coarse.stride(&view(0, 1)), 1);
        assert_eq!(Guidance::none().stride(&view(160, 160)), 1);
    }
}
