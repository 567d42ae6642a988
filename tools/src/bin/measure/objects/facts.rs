//! What a toss shows by itself, without the program.

use enact_tools::objects::cut::{Cut, cut};
use enact_tools::objects::read::{ObjectToss, RATE_HZ};
use enact_tools::objects::scene::{contact_height_m, rest_height_m};
use enact_tools::objects::smoothing::{Filter, fall, filter};
use enact_tools::objects::solid::Solid;
use nalgebra::Vector3;
use serde::Serialize;

/// Samples after a contact that are asked about where no second flight is seen.
const AFTER: usize = 4;
/// An object whose lowest point is less above the table than this is not in the air \[m\].
const LOW_M: f64 = 0.02;

/// What is seen of a toss.
#[derive(Clone, Debug, Serialize)]
pub struct Facts {
    /// All samples.
    pub samples: usize,
    /// The filter that its positions show.
    pub filter: Option<Filter>,
    /// First and last sample of the first flight.
    pub first: [usize; 2],
    /// The same after the first contact.
    pub second: [usize; 2],
    /// Whether a flight is seen there.
    pub second_is_seen: bool,
    /// Acceleration of the best parabola through the first flight [m/s²].
    pub acceleration_m_s2: Option<Vector3<f64>>,
    /// Whether it rests at its end.
    pub rests: bool,
    /// Height of the table: of the lowest point at rest, or at the first contact \[m\].
    pub table_m: f64,
    /// Height of the lowest point above it at the first contact, and at the first sample \[m\].
    pub contact_m: f64,
    pub start_m: f64,
}

impl Facts {
    /// `None` where no flight is seen.
    pub fn new(toss: &ObjectToss, solid: &Solid, gravity_m_s2: &Vector3<f64>) -> Option<Self> {
        let poses = &toss.poses;
        let found: Cut = cut(poses)?;
        let last = found.first[1];
        if last + 1 >= poses.len() {
            return None;
        }
        let lowest_m = |place: usize| solid.lowest_m(&solid.world_from_body(&poses[place]));
        let contact_m = contact_height_m(solid, poses, last);
        let rest_m = rest_height_m(solid, poses);
        let table_m = rest_m.unwrap_or(contact_m);
        let centres_m: Vec<Vector3<f64>> = poses[found.first[0]..=last]
            .iter()
            .map(|pose| solid.world_from_body(pose).translation.vector)
            .collect();
        Some(Self {
            samples: poses.len(),
            filter: filter(poses),
            first: found.first,
            second: found
                .second
                .unwrap_or([last + 1, (last + AFTER).min(poses.len() - 1)]),
            second_is_seen: found.second.is_some(),
            acceleration_m_s2: fall(&centres_m, RATE_HZ, gravity_m_s2)?.acceleration_m_s2,
            rests: rest_m.is_some(),
            table_m,
            contact_m: contact_m - table_m,
            start_m: lowest_m(found.first[0]) - table_m,
        })
    }

    /// The place of the first contact, in samples of the toss.
    pub fn impact(&self) -> f64 {
        self.first[1] as f64 + 0.5
    }

    /// What the toss shows that a first flight and a single impact of a tracked body would not.
    pub fn is_not(&self) -> Vec<String> {
        let mut said = Vec::new();
        let flight = self.first[1] + 1 - self.first[0];
        if let Some(filter) = self.filter.filter(|filter| filter.window > flight) {
            said.push(format!("smoothed over {} samples", filter.window));
        }
        if self.first[0] > 0 {
            said.push(format!("spin changes up to sample {}", self.first[0]));
        }
        if self.start_m < LOW_M {
            said.push("begins at the table".to_owned());
        }
        if !self.second_is_seen {
            said.push("next contact within four samples".to_owned());
        }
        if !self.rests {
            said.push("does not rest at its end".to_owned());
        }
        said
    }
}
