//! Checks for samples outside the time of the flight that they are compared with.

use super::flights::CredibleFlight;
use crate::motion::{About, Doubt, Scene, Timing};

/// Greatest time of a sample beyond an end of its flight \[s\].
const BEYOND_S: f64 = 1e-3;

pub(super) fn doubts(scene: &Scene, flights: &[CredibleFlight]) -> Vec<Doubt> {
    // In an edited sketch the samples themselves define the flights.
    if scene.timing == Timing::Edited {
        return Vec::new();
    }
    let each = flights.iter().filter_map(|flight| {
        let beyond_s = beyond_s(flight);
        Doubt::beyond(About::Outside, flight.place(), beyond_s, BEYOND_S)
    });
    each.collect()
}

/// Greatest time of a sample beyond an end of the flight \[s\].
fn beyond_s(flight: &CredibleFlight) -> f64 {
    let beyond_s = flight.readings.iter().map(|reading| {
        let before_s = flight.arc.start_s - reading.time_s;
        before_s.max(reading.time_s - flight.arc.end_s)
    });
    beyond_s.fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use nalgebra::{UnitQuaternion, Vector3};

    use super::super::flights::FlightSample;
    use super::*;
    use crate::motion::{ArcEstimate, MechanismIndex, SegmentResidual, TrackIndex};
    use crate::physics::State;

    #[test]
    fn a_sample_on_either_side_of_its_flight_is_as_far_beyond_it() {
        let arc = ArcEstimate {
            mechanism: MechanismIndex(0),
            epoch_s: 0.5,
            state: State {
                position_m: Vector3::zeros(),
                velocity_m_s: Vector3::zeros(),
                orientation: UnitQuaternion::identity(),
                angular_velocity_rad_s: Vector3::zeros(),
            },
            start_s: 0.2,
            end_s: 0.8,
            support: None,
            certainty: None,
        };
        let residual = SegmentResidual {
            arc: 0,
            track: TrackIndex(0),
            samples: 2,
            position_rms_m: Some(0.0),
            orientation_rms_rad: Some(0.0),
        };
        let at = |times_s: [f64; 2]| {
            let readings = times_s.map(|time_s| FlightSample {
                acted_s: time_s,
                time_s,
                position_m: Vector3::zeros(),
                estimated_m: Vector3::zeros(),
            });
            beyond_s(&CredibleFlight {
                arc: &arc,
                residual: &residual,
                times: &[],
                readings: readings.to_vec(),
            })
        };
        assert_eq!(at([0.2, 0.8]), 0.0);
        assert!((at([0.15, 0.8]) - 0.05).abs() < 1e-12);
        assert!((at([0.3, 0.83]) - 0.03).abs() < 1e-12);
    }
}
