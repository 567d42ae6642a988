//! First times of samples whose times are not known: where the guessed flight is nearest to them.
//!
//! Samples of a flight come one after the other. Of all times in their order those are taken at which
//! the sum of squared distances is least: exactly, on a grid, by dynamic programming.

use nalgebra::Vector3;

use crate::math::so3;
use crate::motion::{
    ArcGuess, Guess, MechanismIndex, Quantity, Sample, Scene, Seen, Segment, Sketch, View,
};
use crate::physics::{State, flow};

/// Number of intervals between the earliest and the latest time of a flight.
const STEPS: usize = 200;
/// Longest time before the first and after the last of a flight's ends and known samples \[s\].
const REACH_S: f64 = 0.5;

/// Sets the parameters that hold such times.
pub(super) fn place(scene: &Scene, sketch: &Sketch, segments: &[Segment], guess: &mut Guess) {
    for (index, segment) in segments.iter().enumerate() {
        let flight = segments[..index].iter();
        let flight = flight.filter(|other| other.mechanism == segment.mechanism);
        let flight = flight.count();
        for view in &segment.views {
            let track = view.track;
            let free = view.samples.clone().map(|sample| {
                let time = scene.parameter_of(Quantity::SampleTime { track, sample });
                (sample, time)
            });
            let free: Vec<(usize, Option<usize>)> = free.collect();
            if free.iter().all(|(_, parameter)| parameter.is_none()) {
                continue;
            }
            let clock = scene.parameter_of(Quantity::FlightClock { track, flight });
            let clock_s = clock.map_or(0.0, |clock| guess.parameters[clock]);
            let flown = FlownTimes {
                scene,
                mechanism: segment.mechanism,
                lever_m: scene.tracks[track].point_m(),
                arc: &guess.arcs[index],
                clock_s,
            };
            let ends = [segment.start_event, segment.end_event];
            let ends_s = ends.map(|event| event.map(|e| guess.event_times_s[e] - clock_s));
            let times_s = flown.nearest_s(sketch, view, &free, ends_s);
            for ((sample, parameter), time_s) in free.into_iter().zip(times_s) {
                if let Some(parameter) = parameter {
                    let of = &scene.parameters[parameter];
                    let added_s = time_s - sketch.tracks[track].samples[sample].acted_s;
                    guess.parameters[parameter] = added_s.clamp(of.lower, of.upper);
                }
            }
        }
    }
}

/// A guessed flight, on the clock of a track.
struct FlownTimes<'a> {
    scene: &'a Scene,
    mechanism: MechanismIndex,
    /// Where the tracker is in body axes \[m\].
    lever_m: Vector3<f64>,
    arc: &'a ArcGuess,
    clock_s: f64,
}

impl FlownTimes<'_> {
    fn at(&self, time_s: f64) -> State {
        let body = self.scene.body_of(self.mechanism);
        let since_s = time_s + self.clock_s - self.arc.epoch_s;
        flow::advance(body, &self.scene.gravity_m_s2, &self.arc.state, since_s)
    }

    /// Squared distance of a sample from the flight, in the scene's weights.
    fn square(&self, sample: &Sample, state: &State) -> f64 {
        let weights = &self.scene.weights;
        let place = sample.seen.position_m().map(|seen_m| {
            let lever_m = match sample.seen {
                Seen::Point(_) => self.lever_m,
                _ => Vector3::zeros(),
            };
            let there_m = state.position_m + state.orientation * lever_m;
            (there_m - seen_m).norm_squared() / weights.position_m.powi(2)
        });
        let turn = sample.seen.orientation().map(|seen| {
            let off = so3::log(&(seen.inverse() * state.orientation));
            off.norm_squared() / weights.orientation_rad.powi(2)
        });
        place.unwrap_or(0.0) + turn.unwrap_or(0.0)
    }

    /// The times of a view's samples: those that are known, and for the others the nearest.
    fn nearest_s(
        &self,
        sketch: &Sketch,
        view: &View,
        free: &[(usize, Option<usize>)],
        ends_s: [Option<f64>; 2],
    ) -> Vec<f64> {
        let samples = sketch.samples_of(view);
        let ranges_s: Vec<[f64; 2]> = samples
            .iter()
            .zip(free)
            .map(|(sample, (_, parameter))| match parameter {
                Some(parameter) => {
                    let of = &self.scene.parameters[*parameter];
                    [sample.acted_s + of.lower, sample.acted_s + of.upper]
                }
                None => [sample.acted_s; 2],
            })
            .collect();
        let all_s = samples.iter().map(|sample| sample.acted_s);
        let first_s = all_s.clone().fold(f64::INFINITY, f64::min);
        let last_s = all_s.fold(f64::NEG_INFINITY, f64::max);
        let from_s = ends_s[0].unwrap_or(first_s - REACH_S).min(first_s);
        let to_s = ends_s[1].unwrap_or(last_s + REACH_S).max(last_s);
        let step_s = (to_s - from_s) / STEPS as f64;
        let grid = (0..=STEPS).map(|step| from_s + step as f64 * step_s);
        let grid: Vec<(f64, State)> = grid.map(|time_s| (time_s, self.at(time_s))).collect();
        // Least sum over the samples so far, the last no later than each time; and where it is.
        let mut least = vec![0.0; grid.len()];
        let mut places: Vec<Vec<usize>> = Vec::new();
        for (sample, range_s) in samples.iter().zip(&ranges_s) {
            let mut best = (f64::INFINITY, 0);
            let mut place = vec![0; grid.len()];
            for (at, (time_s, state)) in grid.iter().enumerate() {
                // Half a step: every interval holds a time of the grid, or nearly.
                let is_within =
                    (range_s[0] - 0.5 * step_s..=range_s[1] + 0.5 * step_s).contains(time_s);
                let is_known = range_s[0] == range_s[1];
                let own = if !is_within {
                    f64::INFINITY
                } else if is_known {
                    0.0
                } else {
                    self.square(sample, state)
                };
                let sum = least[at] + own;
                if sum < best.0 {
                    best = (sum, at);
                }
                least[at] = best.0;
                place[at] = best.1;
            }
            places.push(place);
        }
        let mut at = grid.len() - 1;
        let mut times_s = vec![0.0; samples.len()];
        for (index, place) in places.iter().enumerate().rev() {
            at = place[at];
            times_s[index] = grid[at].0;
        }
        times_s
    }
}
