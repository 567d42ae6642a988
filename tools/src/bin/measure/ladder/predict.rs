//! What an estimated motion says of the tracker at the times of samples that it was not estimated
//! from, and how certain of that it is.
//!
//! The program reports deviations of parameters and times, not of poses. Its covariance has them all:
//! a pose at a time depends on the state of its flight and on the parameters, and to first order its
//! deviation is that of a linear combination of those. Derivatives are central differences.

use enact::estimate::adequacy;
use enact::estimate::covariance::{Covariance, Moment};
use enact::estimate::problem::Problem;
use enact::estimate::schedule::recipe::{self, Recipe};
use enact::estimate::terms::context::SolveContext;
use enact::estimate::unknowns::kept::KeptSteps;
use enact::estimate::unknowns::layout::Layout;
use enact::estimate::unknowns::point::Point;
use enact::math::{Pose, so3};
use enact::motion::{MechanismIndex, Quantity, Scene, Stamp, TrackIndex};
use enact::physics::state::StateTangent;
use enact::physics::{State, flow};
use enact::pipeline::Outcome;
use enact::segment;

/// Step of a difference in an unknown of a state [m, rad, m/s, rad/s], and in a parameter in typical
/// changes of it.
const STEP: f64 = 1e-5;

/// Position along world axes \[m\], then orientation along the tracker's \[rad\].
pub type Six = [f64; 6];

/// The only tracker and the only body.
const TRACK: TrackIndex = TrackIndex(0);
const BODY: MechanismIndex = MechanismIndex(0);

/// A motion, and how it is seen.
struct Seen {
    scene: Scene,
    states: Vec<State>,
    clock_rate: f64,
}

/// Where the motion of an outcome has the tracker at those stamps \[world\].
pub fn poses(outcome: &Outcome, stamps: &[Stamp]) -> Vec<Pose> {
    let seen = Seen::estimated(outcome);
    let pose = |stamp: &Stamp| seen.pose(outcome, arc_at(outcome, &seen, *stamp), *stamp);
    stamps.iter().map(pose).collect()
}

/// From one pose to another.
pub fn difference(from: &Pose, to: &Pose) -> Six {
    let shift_m = to.translation.vector - from.translation.vector;
    let turn = so3::log(&(from.rotation.inverse() * to.rotation));
    [shift_m.x, shift_m.y, shift_m.z, turn.x, turn.y, turn.z]
}

impl Seen {
    fn estimated(outcome: &Outcome) -> Self {
        let arcs = outcome.estimate.arcs.iter();
        Self {
            scene: outcome.scene.clone(),
            states: arcs.map(|arc| arc.state).collect(),
            clock_rate: clock_rate(outcome, &values(outcome)),
        }
    }

    /// Physical time of a stamp: an affine function, known at the first sample.
    fn time_s(&self, outcome: &Outcome, stamp: Stamp) -> f64 {
        let first = &outcome.estimate.sample_times[0];
        first.time_s + (1.0 + self.clock_rate) * stamp.seconds_since(first.stamp)
    }

    fn pose(&self, outcome: &Outcome, arc: usize, stamp: Stamp) -> Pose {
        let flown_s = self.time_s(outcome, stamp) - outcome.estimate.arcs[arc].epoch_s;
        let body = self.scene.body_of(BODY);
        let state = flow::advance(body, &self.scene.gravity_m_s2, &self.states[arc], flown_s);
        state.world_from_body() * self.scene.tracks[TRACK].link_from_tracker
    }
}

/// The flight at a stamp: the first that has not ended, or the last.
fn arc_at(outcome: &Outcome, seen: &Seen, stamp: Stamp) -> usize {
    let (arcs, time_s) = (&outcome.estimate.arcs, seen.time_s(outcome, stamp));
    let at = arcs.iter().position(|arc| time_s <= arc.end_s);
    at.unwrap_or(arcs.len() - 1)
}

/// Values of the parameters.
fn values(outcome: &Outcome) -> Vec<f64> {
    let parameters = outcome.estimate.parameters.iter();
    parameters.map(|parameter| parameter.value).collect()
}

fn clock_rate(outcome: &Outcome, values: &[f64]) -> f64 {
    let mut free = outcome.given.parameters.iter().zip(values);
    let rate = free.find(|(free, _)| matches!(free.quantity, Quantity::ClockRate { .. }));
    rate.map_or(0.0, |(_, value)| *value)
}

/// Standard deviations of predictions.
pub struct Deviations {
    /// Of every component at every stamp, as the program has it; `None` where the performance does not
    /// determine it.
    pub sds: Vec<[Option<f64>; 6]>,
    /// The same under white noise alone, of the size that the scene's weights say.
    pub stated: Vec<[Option<f64>; 6]>,
    /// Of a sample about the motion: the white noise that the estimation saw [m, rad].
    pub noise: [f64; 2],
}

/// Standard deviations of [`poses`]; `None` where there is no covariance.
pub fn deviations(outcome: &Outcome, stamps: &[Stamp]) -> Option<Deviations> {
    let given = &outcome.given;
    let sketch = outcome.sketch.clone().seen_in(&outcome.scene, given);
    let segments = segment::cut(given, &sketch).ok()?;
    let problem = Problem::new(given, &sketch, &segments);
    let layout = Layout::new(&problem);
    let estimate = &outcome.estimate;
    // Throws of the ladder have nothing in the hand.
    let point = Point {
        arcs: estimate.arcs.iter().map(|arc| arc.state).collect(),
        held: Vec::new(),
        event_times_s: estimate.events.iter().map(|event| event.time_s).collect(),
        node_times_s: problem.nodes_acted_s.clone(),
        parameters: values(outcome),
        kept: KeptSteps::default(),
    };
    let epochs_s: Vec<f64> = estimate.arcs.iter().map(|arc| arc.epoch_s).collect();
    let recipe = Recipe::default().from_the_last();
    let solution = recipe::solve_from(&problem, &layout, point, epochs_s.clone(), &recipe, &mut ());
    let (point, system) = (&solution.point, &solution.system);
    let context = SolveContext::new(&problem, &layout, epochs_s, point);
    let in_time = adequacy::in_time(&context, &solution)?;
    let covariance =
        |in_time| Covariance::new(&context, point, system, &solution.multipliers, in_time);
    let (told, stated) = (covariance(Some(&in_time))?, covariance(None)?);
    let is_bounded = estimate.parameters.iter().any(|p| p.at_bound.is_some());
    let moments = moments(outcome, (&problem, &layout), stamps)?;
    let sds = |covariance: &Covariance| -> Vec<[Option<f64>; 6]> {
        let sd = |moment: &Moment| {
            let own = covariance.sds(std::slice::from_ref(moment))[0]?;
            let beyond = is_bounded.then(|| covariance.beyond_bounds(moment));
            Some(own.hypot(beyond.unwrap_or(0.0)))
        };
        moments.iter().map(|six| six.each_ref().map(sd)).collect()
    };
    let [position, orientation] = in_time.noise_sds();
    Some(Deviations {
        sds: sds(&told),
        stated: sds(&stated),
        noise: [
            position * problem.position_unit_m,
            orientation * problem.orientation_unit_rad,
        ],
    })
}

/// The components of every pose as linear combinations of unknowns.
fn moments(
    outcome: &Outcome,
    (_problem, layout): (&Problem, &Layout),
    stamps: &[Stamp],
) -> Option<Vec<[Moment; 6]>> {
    let seen = Seen::estimated(outcome);
    let at = |stamp: &Stamp| (arc_at(outcome, &seen, *stamp), *stamp);
    let places: Vec<(usize, Stamp)> = stamps.iter().map(at).collect();
    let mut moments: Vec<[Moment; 6]> = places.iter().map(|_| Default::default()).collect();
    // Adds the derivative by one unknown, from the poses after a step back and one ahead.
    let mut add = |unknown: usize, [back, ahead]: [&Seen; 2], step: f64, of: Option<usize>| {
        for ((arc, stamp), six) in places.iter().zip(&mut moments) {
            if of.is_some_and(|of| of != *arc) {
                continue;
            }
            let [from, to] = [back, ahead].map(|seen| seen.pose(outcome, *arc, *stamp));
            for (moment, change) in six.iter_mut().zip(difference(&from, &to)) {
                moment.push((unknown, change / step));
            }
        }
    };
    for arc in 0..seen.states.len() {
        for (index, unknown) in layout.state(arc).enumerate() {
            let moved = |by: f64| {
                let mut delta = StateTangent::zeros();
                delta[index] = by;
                let mut states = seen.states.clone();
                states[arc] = states[arc].retract(&delta);
                Seen {
                    scene: seen.scene.clone(),
                    states,
                    clock_rate: seen.clock_rate,
                }
            };
            add(
                unknown,
                [&moved(-STEP), &moved(STEP)],
                2.0 * STEP,
                Some(arc),
            );
        }
    }
    let given = &outcome.given;
    for (index, free) in given.parameters.iter().enumerate() {
        let step = STEP * free.quantity.typical();
        let [lower, upper] = free.quantity.limits();
        let stepped = [-step, step].map(|by| {
            let mut all = values(outcome);
            all[index] = (all[index] + by).clamp(lower, upper);
            all
        });
        let moved = |all: &Vec<f64>| {
            let free = given.parameters.iter().map(|free| free.quantity);
            let all_named: Vec<(Quantity, f64)> = free.zip(all.iter().copied()).collect();
            Some(Seen {
                scene: given.with_values(&all_named).ok()?,
                states: seen.states.clone(),
                clock_rate: clock_rate(outcome, all),
            })
        };
        let [back, ahead] = [moved(&stepped[0])?, moved(&stepped[1])?];
        let step = stepped[1][index] - stepped[0][index];
        add(layout.parameters[index], [&back, &ahead], step, None);
    }
    Some(moments)
}

#[cfg(test)]
mod tests {
    use enact::motion::TakeEvent;
    use enact_tools::case::estimated;
    use enact_tools::nonsense::wrong::Wrong;

    use super::super::rungs::{Rung, freed};
    use super::super::step::pose_of;
    use super::super::throws::with_noise;
    use super::*;
    use crate::statistics::rms;

    #[test]
    fn predictions_at_used_samples_leave_the_residuals_of_the_estimate() {
        let asked = Wrong::Inertia.asked(&with_noise(), 2).expect("a throw");
        let rungs = [Rung::Moments, Rung::Centre, Rung::TrackerOrientation];
        let scene = freed(&asked.scene, &rungs);
        let outcome = estimated(&scene, &asked.events, &mut ()).expect("an estimate");
        let mut used = outcome.estimate.sample_times.iter();
        for flight in &outcome.estimate.residuals {
            let angles = used.by_ref().take(flight.samples).map(|time| {
                let mut events = asked.events.iter();
                let sample = events.find_map(|event| match event {
                    TakeEvent::Pose { sample, .. } if sample.stamp == time.stamp => Some(sample),
                    _ => None,
                });
                let seen = pose_of(sample.expect("it was used"));
                let [.., x, y, z] = difference(&poses(&outcome, &[time.stamp])[0], &seen);
                (x * x + y * y + z * z).sqrt()
            });
            let left_rad = rms(&angles.collect::<Vec<f64>>());
            // Quaternions are rounded in the take.
            let off_rad = left_rad - flight.orientation_rms_rad.expect("poses");
            assert!(off_rad.abs() < 1e-8, "{left_rad} and {flight:?}");
        }
    }
}
