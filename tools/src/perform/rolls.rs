//! Rolls of dice and cubes that are asked to show a face at rest: after some bounces, with friction,
//! while they still fly.

use super::bounces::{self, Polyhedron, Throw, thrown};
use super::truth::{Truth, TruthError};
use enact::config::scene_from_toml;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Sides \[m\], and about how fast such a die turns at most [rad/s].
const DICE: [(f64, f64); 4] = [(0.016, 60.0), (0.05, 35.0), (0.1, 20.0), (0.3, 12.0)];
/// Axes that may be asked to be up.
const FACES: [&str; 6] = ["+x", "-x", "+y", "-y", "+z", "-z"];
/// Share of its last flight after which a performance ends.
const LAST_SHARE: f64 = 0.7;

/// A roll, and what it is asked to show.
#[derive(Clone, Copy, Debug)]
pub struct Roll {
    /// The throw, with friction.
    pub throw: Throw,
    /// Bounces before the performance ends.
    pub bounces: usize,
    /// The axis that is to be up.
    pub face: &'static str,
    /// Of the throw.
    pub seed: u64,
}

impl Roll {
    /// The roll of a seed: size, number of bounces, friction and face are all of it.
    pub fn of(seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let (side_m, fastest_rad_s) = DICE[rng.random_range(0..DICE.len())];
        Self {
            throw: Throw {
                friction: rng.random_range(0.1..0.5),
                last_share: LAST_SHARE,
                ..Throw::sized(side_m, fastest_rad_s)
            },
            bounces: rng.random_range(1..=4),
            face: FACES[rng.random_range(0..FACES.len())],
            seed,
        }
    }

    /// Its side \[m\].
    pub fn side_m(&self) -> f64 {
        2.0 * self.throw.half_m
    }

    /// The motion, in a scene that asks for its face, and the scene file; `goal` is added to the keys
    /// of that goal. Stamps are physical times where that is said.
    pub fn truth(&self, goal: &str, stamps: &str) -> Result<(Truth, String), TruthError> {
        let mut truth = thrown(Polyhedron::Cube, &self.throw, self.bounces, self.seed)?;
        let text = bounces::scene_toml(&truth.scene)
            .replace("stamps = \"tempo\"", &format!("stamps = {stamps:?}"))
            .replace("[timing]", "settle_s = 5\n[timing]");
        let face = self.face;
        let text = format!(
            "{text}[[goal]]\nevent = \"rest\"\nbody = \"cube\"\nface_up = {face:?}\n{goal}"
        );
        truth.scene = scene_from_toml(&text).expect("a scene");
        Ok((truth, text))
    }
}
