//! Where an object flies and where it is touched, by its spin alone: between contacts the angular
//! velocity changes slowly, and a contact changes it at once. The positions do not tell: they are
//! smoothed over half a second.

use nalgebra::Vector3;

use crate::tosses::Pose;
use enact::math::so3;

/// Greatest change of the rotation from one step to the next in flight; chosen on the tosses for
/// choosing \[rad\].
const CHANGE_RAD: f64 = 4.0 / 180.0 * std::f64::consts::PI;
/// Least number of steps of a flight: fewer show no spin that stays.
const LEAST_STEPS: usize = 3;
/// The spin before a step is the mean of so many.
const RECENT: usize = 3;
/// Steps of a contact: the one in which it happens, and one that it may share with a second.
const CONTACT_STEPS: usize = 2;

/// Rotations from sample to sample, in world axes \[rad\].
pub fn steps(poses: &[Pose]) -> Vec<Vector3<f64>> {
    let step = |pair: &[Pose]| so3::log(&(pair[1].1 * pair[0].1.inverse()));
    poses.windows(2).map(step).collect()
}

/// First and last samples of the stretches in which the spin changes slowly.
pub fn flights(poses: &[Pose]) -> Vec<[usize; 2]> {
    let steps = steps(poses);
    let mut flights = Vec::new();
    let mut first = 0;
    while first < steps.len() {
        let mut end = first + 1;
        while end < steps.len() {
            let recent = &steps[first.max(end.saturating_sub(RECENT))..end];
            let mean = recent.iter().sum::<Vector3<f64>>() / recent.len() as f64;
            if (steps[end] - mean).norm() > CHANGE_RAD {
                break;
            }
            end += 1;
        }
        if end - first >= LEAST_STEPS {
            flights.push([first, end]);
            first = end;
        } else {
            first += 1;
        }
    }
    flights
}

/// The first flight of a toss, the first contact, and the flight after it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cut {
    /// First and last sample of the first flight.
    pub first: [usize; 2],
    /// The same of the second; `None` where the next contact comes too soon to show one.
    pub second: Option<[usize; 2]>,
}

impl Cut {
    /// The place of the first contact, in samples: between the last sample with the old spin and the next.
    pub fn impact(&self) -> f64 {
        self.first[1] as f64 + 0.5
    }
}

/// Cuts a toss; `None` where its spin never stays.
pub fn cut(poses: &[Pose]) -> Option<Cut> {
    let flights = flights(poses);
    let first = *flights.first()?;
    let follows = |flight: &&[usize; 2]| flight[0] <= first[1] + CONTACT_STEPS;
    let second = flights.get(1).filter(follows);
    // The step of the contact belongs to neither.
    let second = second.map(|flight| [flight[0].max(first[1] + 1), flight[1]]);
    Some(Cut { first, second })
}
