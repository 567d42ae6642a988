//! How much the samples can be trusted, chosen on half of the tosses.

use nalgebra::Vector3;

use super::cut::{Cut, cut, steps};
use super::read::{ObjectToss, RATE_HZ};
use super::scene::{Trust, contact_height_m, rest_height_m};
use super::smoothing::fall;
use super::solid::Solid;
use crate::tosses::Pose;

/// A toss with where it is cut, and its shape.
pub type Known<'a> = (&'a ObjectToss, Cut, &'a Solid);

/// The tosses for choosing in which a flight is seen, with the first of their shapes.
pub fn known<'a>(tosses: &'a [ObjectToss], shapes: &'a [[Solid; 2]]) -> Vec<Known<'a>> {
    let chosen = tosses.iter().zip(shapes);
    let chosen = chosen.filter(|(toss, _)| toss.is_for_choosing);
    chosen
        .filter_map(|(toss, [solid, _])| Some((toss, cut(&toss.poses)?, solid)))
        .collect()
}

/// Standard deviations from some tosses: of positions about the free flight that is nearest to those
/// of each first flight, of orientations about constant spin, and of the table's height by the lowest point at
/// the first contact about that at rest, of shapes that are measured. `None` of too few.
pub fn trust(known: &[Known], gravity_m_s2: &Vector3<f64>) -> Option<Trust> {
    let (mut position, mut turn, mut table) =
        (Pooled::default(), Pooled::default(), Pooled::default());
    for (toss, cut, solid) in known {
        let flight = &toss.poses[cut.first[0]..=cut.first[1]];
        let centres_m: Vec<Vector3<f64>> = flight
            .iter()
            .map(|pose| solid.world_from_body(pose).translation.vector)
            .collect();
        let fall = fall(&centres_m, RATE_HZ, gravity_m_s2)?;
        position.add(fall.squares_m2, fall.freedom);
        turn.add(turn_squares(flight), 3 * (flight.len() - 2));
        if let Some(rest_m) = rest_height_m(solid, &toss.poses).filter(|_| solid.is_measured) {
            let contact_m = contact_height_m(solid, &toss.poses, cut.first[1]);
            table.add((contact_m - rest_m).powi(2), 1);
        }
    }
    Some(Trust {
        position_mm: 1e3 * position.sd()?,
        orientation_deg: turn.sd()?.to_degrees(),
        table_mm: 1e3 * table.sd()?,
    })
}

/// Squares of the steps about their mean; a step has the noise of two orientations.
fn turn_squares(flight: &[Pose]) -> f64 {
    let steps = steps(flight);
    let mean = steps.iter().sum::<Vector3<f64>>() / steps.len() as f64;
    let squares = steps.iter().map(|step| (step - mean).norm_squared());
    0.5 * squares.sum::<f64>()
}

#[derive(Default)]
struct Pooled {
    squares: f64,
    freedom: usize,
}

impl Pooled {
    fn add(&mut self, squares: f64, freedom: usize) {
        self.squares += squares;
        self.freedom += freedom;
    }

    fn sd(&self) -> Option<f64> {
        (self.freedom > 0).then(|| (self.squares / self.freedom as f64).sqrt())
    }
}
