//! Checks speeds, distances and tempo.

use super::flights::{CredibleFlight, FlightSample};
use crate::motion::{About, Doubt, Estimate, Place, Scene, Timing};
use crate::verify::bound::spin_bound_rad_s;

/// Greatest speed of a point of a body [m/s].
pub(in crate::verify) const SPEED_M_S: f64 = 80.0;
/// Greatest angular speed [rad/s].
pub(in crate::verify) const SPIN_RAD_S: f64 = 1000.0;
/// Greatest ratio of the estimated to the acted way of a flight.
const WAY: f64 = 5.0;
/// Greatest ratio of acted to physical duration of the motion,
const SLOWNESS: f64 = 12.0;
/// and greatest inverse of it.
const HASTE: f64 = 2.5;
/// The same bounds for one flight.
const FLIGHT_SLOWNESS: f64 = 16.0;
const FLIGHT_HASTE: f64 = 3.0;
/// Number of intervals of what a support carries or the air lifts.
const MOMENTS: usize = 64;
/// Least number of samples of a flight to check its tempo.
const LEAST: usize = 4;

pub(super) fn doubts(scene: &Scene, estimate: &Estimate, flights: &[CredibleFlight]) -> Vec<Doubt> {
    let mut doubts = Vec::new();
    for flight in flights {
        let arc = flight.arc;
        let link = scene.free_link(arc.mechanism);
        let link = &scene.links[link];
        // Of what is carried or lifted bounds are wide: it is looked at, moment by moment.
        let is_bent = arc.support.is_some() || link.body.lift() != 0.0;
        let moments = if is_bent { MOMENTS } else { 1 };
        let step_s = (arc.end_s - arc.start_s) / moments as f64;
        let states = (0..=moments).map(|at| {
            let time_s = arc.start_s + at as f64 * step_s;
            scene.flown(arc, &estimate.gravity_m_s2, time_s)
        });
        let [mut speed_m_s, mut spin_rad_s] = [0.0_f64; 2];
        for state in states {
            speed_m_s = speed_m_s.max(state.velocity_m_s.norm());
            spin_rad_s = spin_rad_s.max(state.angular_velocity_rad_s.norm());
        }
        if arc.support.is_none() {
            // |v| is largest at an end, with drag as without.
            spin_rad_s = spin_bound_rad_s(&link.body, &arc.state.angular_velocity_rad_s);
        }
        let radius_m = link.radius_m();
        let speed_m_s = speed_m_s + spin_rad_s * radius_m;
        let way = way(flight, radius_m);
        doubts.extend(Doubt::beyond(
            About::Speed,
            flight.place(),
            speed_m_s,
            SPEED_M_S,
        ));
        doubts.extend(Doubt::beyond(
            About::Spin,
            flight.place(),
            spin_rad_s,
            SPIN_RAD_S,
        ));
        doubts.extend(Doubt::beyond(About::Way, flight.place(), way, WAY));
    }
    if matches!(scene.timing, Timing::Unknown { .. }) {
        let all: Vec<FlightSample> = flights.iter().flat_map(|f| f.readings.clone()).collect();
        tempo(&all, Place::Motion, [SLOWNESS, HASTE], &mut doubts);
        for flight in flights {
            let limits = [FLIGHT_SLOWNESS, FLIGHT_HASTE];
            tempo(&flight.readings, flight.place(), limits, &mut doubts);
        }
    }
    doubts
}

/// Ratio of estimated to acted way, for a body of the given radius.
fn way(flight: &CredibleFlight, radius_m: f64) -> f64 {
    let length = |of: fn(&FlightSample) -> nalgebra::Vector3<f64>| -> f64 {
        let pairs = flight.readings.windows(2);
        pairs.map(|pair| (of(&pair[1]) - of(&pair[0])).norm()).sum()
    };
    length(|r| r.estimated_m) / (length(|r| r.position_m) + radius_m)
}

fn tempo(readings: &[FlightSample], place: Place, limits: [f64; 2], doubts: &mut Vec<Doubt>) {
    if readings.len() < LEAST {
        return;
    }
    let extent_s = |of: fn(&FlightSample) -> f64| {
        let most = readings.iter().map(of).fold(f64::NEG_INFINITY, f64::max);
        most - readings.iter().map(of).fold(f64::INFINITY, f64::min)
    };
    let slowness = extent_s(|r| r.acted_s) / extent_s(|r| r.time_s);
    let [slow, hasty] = limits;
    doubts.extend(Doubt::beyond(
        About::Slowness,
        place.clone(),
        slowness,
        slow,
    ));
    doubts.extend(Doubt::beyond(About::Haste, place, 1.0 / slowness, hasty));
}
