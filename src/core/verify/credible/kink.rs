//! Kinks of the residuals at collisions.
//!
//! A hand wanders through a bounce as anywhere else: the slope of the residuals changes there no
//! more than in flight. A wrong law of impact changes it just there. For short flights, residuals
//! of flights alone do not distinguish the two, since a line follows any wander over a few samples;
//! kinks do.

use nalgebra::Vector3;

use super::flights::{CredibleFlight, FlightSample};

/// Longest stretch over which a slope is fitted \[s\].
const WINDOW_S: f64 = 0.06;
/// Least number of samples for a slope.
const LEAST: usize = 2;

/// Ratio of the root mean square changes of the residuals' slope: over collisions to within
/// flights. `None` where flights are too short.
pub(super) fn kinks(flights: &[CredibleFlight]) -> Option<f64> {
    let flies = |flight: &&CredibleFlight| flight.readings.len() >= LEAST;
    let all: Vec<&CredibleFlight> = flights.iter().filter(flies).collect();
    let pairs: Vec<[&[FlightSample]; 2]> = all
        .windows(2)
        .filter(|pair| pair[0].arc.mechanism == pair[1].arc.mechanism)
        .map(|pair| [pair[0].readings.as_slice(), pair[1].readings.as_slice()])
        .collect();
    let shortest = pairs.iter().flatten().map(|r| r.len()).min()?;
    let interval_s = mean_interval_s(&all)?;
    // In flight the two windows are as far apart as those on both sides of a collision.
    let apart = pairs.iter().map(|[before, after]| {
        let gap_s = after[0].time_s - before[before.len() - 1].time_s;
        (gap_s / interval_s).round().max(1.0) as usize - 1
    });
    let apart = apart.max()?;
    let most = (WINDOW_S / interval_s) as usize;
    let window = most.min(shortest.saturating_sub(apart) / 2).max(LEAST);
    let at_collisions = pairs.iter().filter_map(|[before, after]| {
        let from = before.len().checked_sub(window)?;
        Some(slope(after.get(..window)?)? - slope(&before[from..])?)
    });
    let in_flight = all.iter().flat_map(|flight| {
        let stretches = flight.readings.windows(2 * window + apart);
        stretches.filter_map(|s| Some(slope(&s[window + apart..])? - slope(&s[..window])?))
    });
    let ratio = mean_square(at_collisions)? / mean_square(in_flight)?;
    Some(ratio.sqrt())
}

fn mean_interval_s(flights: &[&CredibleFlight]) -> Option<f64> {
    let spans_s = flights.iter().map(|flight| {
        let readings = &flight.readings;
        readings[readings.len() - 1].time_s - readings[0].time_s
    });
    let intervals: usize = flights.iter().map(|flight| flight.readings.len() - 1).sum();
    let mean_s = spans_s.sum::<f64>() / intervals as f64;
    (mean_s > 0.0).then_some(mean_s)
}

/// Slope of the residuals by least squares [m/s].
fn slope(readings: &[FlightSample]) -> Option<Vector3<f64>> {
    let count = readings.len() as f64;
    let mean_s = readings.iter().map(|r| r.time_s).sum::<f64>() / count;
    let (mut square_s2, mut moment) = (0.0, Vector3::zeros());
    for reading in readings {
        let since_s = reading.time_s - mean_s;
        square_s2 += since_s * since_s;
        moment += (reading.position_m - reading.estimated_m) * since_s;
    }
    (square_s2 > 0.0).then(|| moment / square_s2)
}

fn mean_square(values: impl Iterator<Item = Vector3<f64>>) -> Option<f64> {
    let (mut sum, mut count) = (0.0, 0);
    for value in values {
        sum += value.norm_squared();
        count += 1;
    }
    (count > 0 && sum > 0.0).then(|| sum / f64::from(count))
}

#[cfg(test)]
mod tests {
    use nalgebra::UnitQuaternion;

    use super::*;
    use crate::motion::{ArcEstimate, MechanismIndex, SegmentResidual, TrackIndex};
    use crate::physics::State;

    /// Two flights of 45 ms at 120 Hz, from which a hand is off by `off_m`.
    fn kinks_of(off_m: impl Fn(f64) -> f64) -> Option<f64> {
        let arc = |start_s: f64| ArcEstimate {
            mechanism: MechanismIndex(0),
            epoch_s: start_s,
            state: State {
                position_m: Vector3::zeros(),
                velocity_m_s: Vector3::zeros(),
                orientation: UnitQuaternion::identity(),
                angular_velocity_rad_s: Vector3::zeros(),
            },
            start_s,
            end_s: start_s + 0.045,
            support: None,
            certainty: None,
        };
        let residual = SegmentResidual {
            arc: 0,
            track: TrackIndex(0),
            samples: 5,
            position_rms_m: Some(0.0),
            orientation_rms_rad: Some(0.0),
        };
        let arcs = [arc(0.0), arc(0.05)];
        let flights = [0, 6].map(|first: usize| {
            let readings = (first..first + 5).map(|index| {
                let time_s = index as f64 / 120.0;
                FlightSample {
                    acted_s: time_s,
                    time_s,
                    position_m: Vector3::new(off_m(time_s), 0.0, 0.0),
                    estimated_m: Vector3::zeros(),
                }
            });
            CredibleFlight {
                arc: &arcs[first / 6],
                residual: &residual,
                times: &[],
                readings: readings.collect(),
            }
        });
        kinks(&flights)
    }

    #[test]
    fn a_hand_bends_at_a_bounce_as_in_flight() {
        let hand = kinks_of(|s| 0.02 * (12.0 * s).sin()).expect("enough samples");
        assert!(hand < 2.0, "{hand}");
        // A bounce that is slower by half a metre a second than the law's.
        let wrong = kinks_of(|s| 0.02 * (12.0 * s).sin() + 0.5 * (s - 0.0458).max(0.0));
        assert!(wrong.expect("enough samples") > 10.0, "{wrong:?}");
    }

    #[test]
    fn no_kinks_without_samples_or_collisions() {
        assert_eq!(kinks(&[]), None);
        assert_eq!(kinks_of(|_| 0.0), None);
    }
}
