//! Estimated flights with their samples.

use nalgebra::Vector3;

use crate::motion::{
    ArcEstimate, Estimate, Place, SampleTime, Scene, Seen, SegmentResidual, Sketch,
};
use crate::physics::flow::{Fall, Spin, Supported};

/// A sample of a flight.
#[derive(Clone, Copy, Debug)]
pub(super) struct FlightSample {
    /// Acted time [s since the sketch's origin].
    pub(super) acted_s: f64,
    /// Estimated physical time \[s\].
    pub(super) time_s: f64,
    /// Centre of mass as acted [m, world].
    pub(super) position_m: Vector3<f64>,
    /// Centre of mass as estimated [m, world].
    pub(super) estimated_m: Vector3<f64>,
}

/// What one track saw of an arc, in order of time; empty where it saw no positions.
pub(super) struct CredibleFlight<'a> {
    pub(super) arc: &'a ArcEstimate,
    pub(super) residual: &'a SegmentResidual,
    /// Times of all its samples.
    pub(super) times: &'a [SampleTime],
    pub(super) readings: Vec<FlightSample>,
}

impl CredibleFlight<'_> {
    /// The place that doubts about it name.
    pub(super) fn place(&self) -> Place {
        Place::Flight {
            mechanism: self.arc.mechanism,
            start_s: self.arc.start_s,
        }
    }
}

/// All flights of an estimate.
pub(super) fn flights<'a>(
    scene: &Scene,
    sketch: &Sketch,
    estimate: &'a Estimate,
) -> Vec<CredibleFlight<'a>> {
    let mut rest = estimate.sample_times.as_slice();
    let residuals = estimate.residuals.iter();
    residuals
        .map(|residual| {
            let arc = &estimate.arcs[residual.arc];
            let point_m = scene.tracks[residual.track].point_m();
            let body = &scene.body_on(arc);
            let mut supported = Supported::new(body, &estimate.gravity_m_s2, &arc.state);
            let mut fall = Fall::new(body, &estimate.gravity_m_s2, &arc.state);
            let mut spin = Spin::new(body, &arc.state.angular_velocity_rad_s);
            let (times, after) = rest.split_at(residual.samples.min(rest.len()));
            rest = after;
            let readings = times.iter().filter_map(|time| {
                let samples = &sketch.tracks[time.track].samples;
                let at = samples.binary_search_by_key(&time.stamp, |sample| sample.stamp);
                let sample = &samples[at.ok()?];
                let since_s = time.time_s - arc.epoch_s;
                // A point is seen where the centre of mass would be with the estimated turn.
                let lever_m = match sample.seen {
                    Seen::Point(_) => match &mut supported {
                        Some(supported) => supported.at(since_s).orientation * point_m,
                        None => arc.state.orientation * (spin.turn(since_s) * point_m),
                    },
                    _ => Vector3::zeros(),
                };
                Some(FlightSample {
                    acted_s: sample.acted_s,
                    time_s: time.time_s,
                    position_m: sample.seen.position_m()? - lever_m,
                    estimated_m: match &mut supported {
                        Some(supported) => supported.at(since_s).position_m,
                        None => fall.position(since_s),
                    },
                })
            });
            CredibleFlight {
                arc,
                residual,
                times,
                readings: readings.collect(),
            }
        })
        .collect()
}
