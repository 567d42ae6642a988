//! Smooths the streams of bodies in the hand into the motions by which they are driven.
//!
//! A hand's jerk is taken as white noise, and so is the error of a tracker: the smoother (`filter`)
//! then gives the most likely motion at every sample, and at collisions its covariance. Both
//! strengths are found by likelihood (`likelihood`) from the samples near the body's collisions,
//! since a hand that strikes moves otherwise than one that rests; the tracker's may be given by the
//! scene.

mod chain;
mod filter;
mod likelihood;
#[cfg(test)]
mod tests;

use std::ops::Range;

use nalgebra::Vector3;

use self::chain::{Chain, Nines, PlaceChain, TurnChain};
use self::filter::{Believed, Noises, Timed};
use crate::math::Pose;
use crate::motion::held::{Curve, Driven, HeldMotion, Knot, Meeting, StateCovariance};
use crate::motion::{Held, Sample};
use crate::physics::State;
use crate::physics::state::part;

/// Least number of samples of a held body: with fewer, nothing is left to tell noise from motion.
pub const SAMPLES_MIN: usize = 6;
/// Samples so near to a collision tell the noises there \[s\], at least so many on either side, and
/// at most.
const NEAR_S: f64 = 0.5;
const NEAR_MIN: usize = 24;
const NEAR_MAX: usize = 240;
/// Least standard deviation of a tracker's position \[m\] and orientation \[rad\]: that of the best
/// there are.
const LEAST_SD: [f64; 2] = [1e-5, 5e-5];

/// The smoothed motion of the tracker that shows these poses of its link, every so often \[s\], which hits something, is let
/// go or caught at some events, with their acted times.
///
/// # Panics
/// With fewer than [`SAMPLES_MIN`] samples.
pub fn smoothed(
    samples: &[Sample],
    interval_s: f64,
    link_from_tracker: &Pose,
    held: &Held,
    hits: &[(usize, f64)],
) -> HeldMotion {
    let poses = samples.iter().filter_map(|sample| {
        let place = sample.seen.position_m()?;
        let world_from_link = Pose::from_parts(place.into(), sample.seen.orientation()?);
        Some((sample.acted_s, world_from_link * link_from_tracker))
    });
    let poses: Vec<(f64, Pose)> = poses.collect();
    let marks_s: Vec<f64> = hits.iter().map(|(_, time_s)| *time_s).collect();
    let tracked = Tracked {
        near: near(&poses, &marks_s),
        interval_s,
        poses,
        marks_s,
    };
    let of_place = |pose: &Pose| pose.translation.vector;
    let of_turn = |pose: &Pose| pose.rotation;
    let places = tracked.believed::<PlaceChain>(of_place, held.position_sd_m, LEAST_SD[0]);
    let turns = tracked.believed::<TurnChain>(of_turn, held.orientation_sd_rad, LEAST_SD[1]);
    let times_s = timed(&tracked.poses, &tracked.marks_s, |_| ())
        .into_iter()
        .map(|one| one.time_s);
    let times_s: Vec<f64> = times_s.collect();
    let each = places.states.iter().zip(&turns.states);
    let knots = times_s
        .iter()
        .zip(each)
        .map(|(time_s, (place, turn))| Knot {
            time_s: *time_s,
            driven: driven(&place.chain, &turn.chain),
        });
    let meetings = hits.iter().map(|(event, acted_s)| {
        let at = times_s.partition_point(|time_s| time_s < acted_s);
        let at = at.min(times_s.len() - 1);
        // What is taken or hit before it was seen is a little less certain there.
        let by_s = (acted_s - times_s[at]).min(0.0);
        let place = filter::beyond(&places.states[at], by_s, &places.noises).covariance;
        let turn = filter::beyond(&turns.states[at], by_s, &turns.noises).covariance;
        Meeting {
            event: *event,
            acted_s: *acted_s,
            covariance: covariance(&place, &turn),
            acceleration_sds: [&place, &turn].map(|of| {
                let variances = of.diagonal();
                (variances.rows(6, 3).sum() / 3.0).sqrt()
            }),
        }
    });
    let sd = [places.noises, turns.noises].map(|noises| noises.reading.sqrt());
    HeldMotion {
        curve: Curve::new(knots.collect()),
        meetings: meetings.collect(),
        noise_sd: sd,
        counted: 1.0,
    }
}

/// How surprising places are as those of a hand's motion, up to each of them (minus twice the logarithm of the likelihood of
/// all before), with the variance of a reading \[m²\]: the noises are told by the first `told` places, every so often.
pub fn surprises(places: &[(f64, Vector3<f64>)], told: usize, interval_s: f64) -> (f64, Vec<f64>) {
    let timed: Vec<Timed<Vector3<f64>>> = places
        .iter()
        .map(|(time_s, place_m)| Timed {
            time_s: *time_s,
            reading: Some(*place_m),
        })
        .collect();
    let told = timed[..told.min(timed.len())].to_vec();
    let noises = likelihood::credible::<PlaceChain>(&[told], interval_s, None, LEAST_SD[0]);
    let sums = filter::surprises::<PlaceChain>(&timed, &noises).into_iter();
    let costs = sums.map(|sum| sum.log_determinant + sum.square);
    (noises.reading, std::iter::once(0.0).chain(costs).collect())
}

/// What is believed of a chain at all times, with the noises that explain its readings.
struct Smoothed<C> {
    states: Vec<Believed<C>>,
    noises: Noises,
}

/// What a tracker delivered, and when something hit what it is on.
struct Tracked {
    /// Acted times \[s\] and poses.
    poses: Vec<(f64, Pose)>,
    marks_s: Vec<f64>,
    /// The poses near marks.
    near: Vec<Range<usize>>,
    /// Median interval between poses \[s\].
    interval_s: f64,
}

impl Tracked {
    /// What the poses say of one chain; the standard deviation of its readings is given, or at least
    /// so much.
    fn believed<C: Chain>(
        &self,
        of: impl Fn(&Pose) -> C::Reading + Copy,
        given: Option<f64>,
        least: f64,
    ) -> Smoothed<C> {
        let near = self.near.iter();
        let stretches = near.map(|range| timed(&self.poses[range.clone()], &[], of));
        let stretches: Vec<_> = stretches.collect();
        let noises = likelihood::credible::<C>(&stretches, self.interval_s, given, least);
        let states = filter::smooth::<C>(&timed(&self.poses, &self.marks_s, of), &noises);
        Smoothed { states, noises }
    }
}

/// Times of poses and marks, in order, with what the poses show.
fn timed<R>(poses: &[(f64, Pose)], marks_s: &[f64], of: impl Fn(&Pose) -> R) -> Vec<Timed<R>> {
    let read = poses.iter().map(|(time_s, pose)| Timed {
        time_s: *time_s,
        reading: Some(of(pose)),
    });
    let mut all: Vec<Timed<R>> = read.collect();
    for time_s in marks_s {
        let at = all.partition_point(|one| one.time_s < *time_s);
        // The filter begins with a reading.
        let is_new = all.get(at).is_none_or(|one| one.time_s != *time_s);
        if at > 0 && is_new {
            all.insert(
                at,
                Timed {
                    time_s: *time_s,
                    reading: None,
                },
            );
        }
    }
    all
}

/// The samples near marks, without gaps between overlapping stretches; all, where there are no
/// marks.
fn near(poses: &[(f64, Pose)], marks_s: &[f64]) -> Vec<Range<usize>> {
    let mut stretches: Vec<Range<usize>> = Vec::new();
    for mark_s in marks_s {
        let index = |time_s: f64| poses.partition_point(|(at_s, _)| *at_s < time_s);
        let middle = index(*mark_s);
        let reach = |reached: usize| reached.clamp(NEAR_MIN, NEAR_MAX);
        let before = reach(middle - index(mark_s - NEAR_S));
        let after = reach(index(mark_s + NEAR_S) - middle);
        let from = middle.saturating_sub(before);
        let to = (middle + after).min(poses.len());
        match stretches.last_mut() {
            Some(last) if from <= last.end => last.end = last.end.max(to),
            _ => stretches.push(from..to),
        }
    }
    let is_long = |range: &Range<usize>| range.len() >= SAMPLES_MIN;
    if stretches.is_empty() || !stretches.iter().all(is_long) {
        return std::iter::once(0..poses.len()).collect();
    }
    stretches
}

fn driven(place: &PlaceChain, turn: &TurnChain) -> Driven {
    Driven {
        state: State {
            position_m: place.position_m,
            orientation: turn.orientation,
            velocity_m_s: place.velocity_m_s,
            angular_velocity_rad_s: turn.spin_rad_s,
        },
        acceleration_m_s2: place.acceleration_m_s2,
        angular_acceleration_rad_s2: turn.spin_rate_rad_s2,
    }
}

/// Of position, orientation, velocity and angular velocity. Errors of places and of turns are
/// independent.
fn covariance(place: &Nines, turn: &Nines) -> StateCovariance {
    let mut covariance = StateCovariance::zeros();
    for (of, value, rate) in [
        (place, part::POSITION, part::VELOCITY),
        (turn, part::ORIENTATION, part::ANGULAR_VELOCITY),
    ] {
        for (row, from_row) in [(value, 0), (rate, 3)] {
            for (column, from_column) in [(value, 0), (rate, 3)] {
                covariance
                    .fixed_view_mut::<3, 3>(row, column)
                    .copy_from(&of.fixed_view::<3, 3>(from_row, from_column));
            }
        }
    }
    covariance
}
