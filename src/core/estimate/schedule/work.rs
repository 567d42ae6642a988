//! The work of an iteration, in looks at a sample: about a microsecond each. It is counted and not timed, so that limits end a
//! solve at the same place on every machine.

use crate::estimate::terms::context::SolveContext;
use crate::estimate::unknowns::point::Point;
use crate::motion::{Observer, Phase};
use crate::optimise::{IterationWork, Stage, Watch};
use crate::physics::body::Symmetry;

/// How many looks at each sample an iteration with second derivatives is worth,
const CURVED_SAMPLE: usize = 5;
/// and how many looks a radian of a flight is worth of which three moments differ, whose rotation has no closed form: without
/// second derivatives, and with those, which are differences, of each distance that is kept as of all else.
const TURN: f64 = 20.0;
const CURVED_TURN: f64 = 500.0;
/// How many looks a second is worth of what the air slows down or lifts or something supports: it is followed in steps.
const STEPPED_PER_S: f64 = 300.0;

impl SolveContext<'_> {
    /// Looks of an iteration at a point. With second derivatives a quadratic programme is solved, whose work is told by how
    /// many entries its matrix has: about a microsecond each.
    pub(super) fn looks(&self, point: &Point) -> IterationWork {
        let problem = self.problem;
        let time_s = |event: Option<usize>| Some(point.event_times_s[event?]);
        let flights = problem.arcs.iter().zip(&point.arcs).enumerate();
        let (mut turns_rad, mut stepped_s) = (0.0, 0.0);
        for (index, (arc, state)) in flights {
            let ends_s = time_s(arc.end).zip(time_s(arc.start));
            let lasts_s = ends_s.map_or(0.0, |(end_s, start_s)| end_s - start_s);
            let body = problem.body_of(index);
            if body.symmetry() == Symmetry::Asymmetric {
                turns_rad += state.angular_velocity_rad_s.norm() * lasts_s;
            }
            if !body.is_ballistic() {
                stepped_s += lasts_s.max(0.0);
            }
        }
        let samples = problem.sample_count() + (STEPPED_PER_S * stepped_s) as usize;
        let distances = 1 + problem.clearances.len();
        IterationWork {
            plain: samples + (TURN * turns_rad) as usize,
            curved: CURVED_SAMPLE * samples
                + distances * (CURVED_TURN * turns_rad) as usize
                + self.layout.structure.pattern.stored(),
        }
    }
}

/// The observer as the optimiser's [`Watch`].
pub(in crate::estimate) struct Watched<'o>(pub(in crate::estimate) &'o mut dyn Observer);

impl Watch for Watched<'_> {
    fn begins(&mut self, stage: Stage) {
        self.0.phase(match stage {
            Stage::Sweep { .. } => Phase::Sweep,
            Stage::Multipliers => Phase::Multipliers,
            Stage::Finish => Phase::Finish,
        });
    }

    fn should_stop(&mut self) -> bool {
        self.0.should_stop()
    }

    fn worked(&mut self, looks: usize) -> bool {
        self.0.worked(looks)
    }
}
