//! How far an estimate is from the truth, and whether it does what it says.

use enact::math::so3;
use enact::motion::{End, Estimate, EventEstimate, GoalTarget};
use enact::physics::State;
use enact::pipeline::Outcome;

use crate::case::{Case, Posed};
use crate::perform::{Truth, simulate};

/// Largest errors of each kind, relative to the largest value of that kind in the true motion;
/// of orientation in radians.
#[derive(Clone, Copy, Debug, serde::Serialize)]
pub struct Errors {
    /// Of positions.
    pub position: f64,
    /// Of orientations \[rad\].
    pub orientation: f64,
    /// Of velocities.
    pub velocity: f64,
    /// Of angular velocities.
    pub angular_velocity: f64,
    /// Of the times of events that are estimated, relative to the duration.
    pub event_time: f64,
    /// Of sample times, relative to the duration.
    pub sample_time: f64,
}

impl Errors {
    /// Of an outcome's estimate.
    pub fn of(case: &Case, outcome: &Outcome) -> Self {
        let posed = Posed::new(case.scene(), &outcome.sketch);
        let offset_s = case.offset_s(&posed, &outcome.sketch);
        let truth = &case.performance.truth;
        let estimate = &outcome.estimate;
        let mut errors = [0.0_f64; 4];
        let mut sizes = [0.0_f64; 4];
        sizes[1] = 1.0;
        for (index, arc) in estimate.arcs.iter().enumerate() {
            let state = case.true_state(index, arc.epoch_s, offset_s);
            let delta = arc.state.minus(&state);
            for (block, error) in errors.iter_mut().enumerate() {
                *error = error.max(delta.fixed_rows::<3>(3 * block).norm());
            }
            sizes[0] = sizes[0].max(state.position_m.norm());
            sizes[2] = sizes[2].max(state.velocity_m_s.norm());
            sizes[3] = sizes[3].max(state.angular_velocity_rad_s.norm());
        }
        let late = |estimated_s: f64, true_s: f64| {
            (estimated_s - offset_s - true_s).abs() / truth.duration_s
        };
        let events = events_off_s(case, outcome, &posed);
        let events = events.map(|(_, off_s)| off_s / truth.duration_s);
        let samples = estimate.sample_times.iter();
        let samples = samples.map(|s| late(s.time_s, case.hidden_s(s.track, s.stamp)));
        Self {
            position: errors[0] / sizes[0],
            orientation: errors[1] / sizes[1],
            velocity: errors[2] / sizes[2],
            angular_velocity: errors[3] / sizes[3],
            event_time: events.fold(0.0, f64::max),
            sample_time: samples.fold(0.0, f64::max),
        }
    }

    /// In the order of the fields.
    pub fn all(&self) -> [f64; 6] {
        [
            self.position,
            self.orientation,
            self.velocity,
            self.angular_velocity,
            self.event_time,
            self.sample_time,
        ]
    }

    /// The largest of states and event times.
    pub fn worst(&self) -> f64 {
        self.all()[..5].iter().copied().fold(0.0, f64::max)
    }
}

/// How far times of events that are estimated are off, at most.
#[derive(Clone, Copy, Debug)]
pub struct EventTimesOff {
    /// In milliseconds; infinite where one is no number.
    pub ms: f64,
    /// In their deviations, of those that have one.
    pub deviations: f64,
}

impl EventTimesOff {
    /// Of an outcome's estimate.
    pub fn of(case: &Case, outcome: &Outcome) -> Self {
        let posed = Posed::new(case.scene(), &outcome.sketch);
        let mut worst = Self {
            ms: 0.0,
            deviations: 0.0,
        };
        for (event, off_s) in events_off_s(case, outcome, &posed) {
            let off_s = if off_s.is_nan() { f64::INFINITY } else { off_s };
            worst.ms = worst.ms.max(1e3 * off_s);
            if let Some(sd_s) = event.sd_s {
                worst.deviations = worst.deviations.max(off_s / sd_s);
            }
        }
        worst
    }
}

/// Events whose times are estimated, and how far each is off \[s\].
fn events_off_s<'a>(
    case: &'a Case,
    outcome: &'a Outcome,
    posed: &'a Posed,
) -> impl Iterator<Item = (&'a EventEstimate, f64)> {
    let offset_s = case.offset_s(posed, &outcome.sketch);
    let true_s = &case.performance.truth.event_times_s;
    let events = outcome.estimate.events.iter();
    let free = events.filter(|event| posed.problem.event_is_free[event.event]);
    free.map(move |event| {
        let off_s = (event.time_s - offset_s - true_s[event.event]).abs();
        (event, off_s)
    })
}

/// Whether the solver stopped because it was done, and not because it got no further: its verdict
/// is about the gaps alone.
pub fn has_converged(estimate: &Estimate) -> bool {
    matches!(estimate.reason.end, End::Converged(_))
}

/// Sample times against the hidden ones: rms as they are, and with the best constant taken
/// off \[s\].
pub fn sample_time_errors_s(case: &Case, outcome: &Outcome) -> (f64, f64) {
    let times = &outcome.estimate.sample_times;
    let errors = times
        .iter()
        .map(|s| s.time_s - case.hidden_s(s.track, s.stamp));
    let errors: Vec<f64> = errors.collect();
    let count = errors.len() as f64;
    let mean = errors.iter().sum::<f64>() / count;
    let rms = |zero: f64| (errors.iter().map(|e| (e - zero).powi(2)).sum::<f64>() / count).sqrt();
    (rms(0.0), rms(mean))
}

/// How far an estimate's last arcs miss the pose goals, by flying them there [m, rad].
pub fn goal_gap(case: &Case, estimate: &Estimate) -> (f64, f64) {
    misses(&flown(case, estimate))
}

/// The same by an independent simulation from the first states through all collisions; infinite
/// where a collision does not happen.
pub fn simulated_goal_gap(case: &Case, estimate: &Estimate) -> (f64, f64) {
    let none = (f64::INFINITY, f64::INFINITY);
    let scene = case.scene();
    let starts_s = estimate.arcs.iter().map(|arc| arc.start_s);
    let start_s = starts_s.fold(f64::INFINITY, f64::min);
    let initial: Option<Vec<State>> = scene
        .mechanisms
        .keys()
        .map(|mechanism| {
            let mut arcs = estimate.arcs.iter();
            let first = arcs.find(|arc| arc.mechanism == mechanism)?;
            Some(scene.flown(first, &estimate.gravity_m_s2, start_s))
        })
        .collect();
    let (Some(initial), Some(last)) = (initial, estimate.events.last()) else {
        return none;
    };
    let values = parameters(estimate);
    simulate(scene, &values, &initial, last.time_s - start_s).map_or(none, |t| misses(&t))
}

fn flown(case: &Case, estimate: &Estimate) -> Truth {
    Truth {
        scene: case.scene().clone(),
        is_physical: true,
        parameters: parameters(estimate),
        arcs: estimate.arcs.clone(),
        event_times_s: estimate.events.iter().map(|event| event.time_s).collect(),
        duration_s: 0.0,
    }
}

fn parameters(estimate: &Estimate) -> Vec<f64> {
    estimate.parameters.iter().map(|p| p.value).collect()
}

fn misses(truth: &Truth) -> (f64, f64) {
    let mut miss = (0.0_f64, 0.0_f64);
    for goal in &truth.scene.goals {
        let GoalTarget::Pose { world_from_body } = &goal.target else {
            continue;
        };
        let pose = truth.world_from_body(goal.link, truth.event_times_s[goal.event]);
        let turn = world_from_body.rotation.inverse() * pose.rotation;
        let shift = pose.translation.vector - world_from_body.translation.vector;
        miss = (miss.0.max(shift.norm()), miss.1.max(so3::log(&turn).norm()));
    }
    miss
}
