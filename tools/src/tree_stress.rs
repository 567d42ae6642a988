//! Performances of joined bodies that are hard or impossible, and what an independent look finds of the answers.
//!
//! A [`Hard`] draws a true motion from a seed, and a hand acts it as in [`tree_impacts`](crate::tree_impacts); [`cases`]
//! lists what is measured, [`mod@check`] holds a motion that is called physical against the laws by other steps.

pub mod cases;
pub mod check;
mod motion;
mod scene;

use enact::config::scene_from_toml;
use enact::motion::{GoalSet, GoalTarget, Scene};
use enact::physics::tree::{Snapshot, Tree, TreeState};
use nalgebra::Vector3;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::joint_wrongs::Wrong;
use crate::tree_impacts::{Acted, Strike, acted_out};
use crate::trees::{Asked, Jointed, goals};

/// A rod along its own z axis; it hangs from its upper end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rod {
    /// Length \[m\].
    pub length_m: f64,
    /// Radius \[m\].
    pub radius_m: f64,
    /// Mass \[kg\].
    pub mass_kg: f64,
}

/// What trackers see.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Seen {
    /// The lower end of a rod.
    End(usize),
    /// The centre of a rod.
    Centre(usize),
    /// Place and orientation of a rod.
    Whole(usize),
    /// Those of every rod.
    All,
}

/// How the state at the beginning is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Draw {
    /// Angles and rates up to these [rad, rad/s], each by itself.
    Within([f64; 2]),
    /// The same, where the last rod's universal joint passes 90° on the way: its first axis is then along the rod.
    Through([f64; 2]),
    /// The first rod swings at so many rad/s, either way; the others as [`Draw::Within`].
    Swung(f64, [f64; 2]),
    /// The first rod is about upside down.
    FromAbove([f64; 2]),
}

/// Where the last rod's end is asked to be at the end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Wish {
    /// Where it truly is.
    Reached,
    /// That way, but so much farther from where the first rod hangs than all rods in a line reach \[m\].
    Beyond(f64),
}

/// A kind of hard performances.
#[derive(Clone, Debug, PartialEq)]
pub struct Hard {
    /// In words.
    pub name: String,
    /// From the first, which hangs from the world or flies, to the last.
    pub rods: Vec<Rod>,
    /// How they are joined.
    pub joints: Jointed,
    /// Whether the first hangs from the world.
    pub is_clamped: bool,
    /// Duration \[s\].
    pub duration_s: f64,
    /// What is seen.
    pub seen: Seen,
    /// How the motion begins.
    pub draw: Draw,
    /// Whether the true motion is told to rounding: where errors grow without bound, none is.
    pub is_exact: bool,
    /// Whether the whole configuration at the start is a goal.
    pub asks_start: bool,
    /// Where the end should be.
    pub wish: Wish,
    /// What the scene says wrongly.
    pub wrong: Wrong,
    /// Wander of a usual hand, times this.
    pub distortion: f64,
}

/// What is to be estimated.
pub struct Performance {
    /// What was recorded, with the true scene and motion.
    pub strike: Strike,
    /// The scene that is said: the true one but for what is wrong.
    pub said: Scene,
    /// Its file.
    pub said_toml: String,
}

/// Draws of a seed before there is no motion of a kind.
const DRAWS: usize = 4000;

impl Hard {
    /// Acts a motion of a seed.
    ///
    /// # Panics
    /// Where no draw of the seed is of the kind.
    pub fn perform(&self, seed: u64) -> Performance {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let bare = scene_from_toml(&scene::toml(self, "")).expect("a valid scene");
        let (_, joined) = bare.joint_trees().next().expect("a tree");
        let tree = bare.tree_model(joined);
        let states = (0..DRAWS).find_map(|_| self.motion(&bare, &tree, &mut random));
        let states = states.expect("a motion of the kind");
        let asked = Asked {
            links: self.rods.len(),
            last_m: self.rods[self.rods.len() - 1].length_m,
            asks_start: self.asks_start,
        };
        let end_m = self.end_m(&bare, &tree, &states[states.len() - 1]);
        let goals = goals(&asked, (&bare, joined, &tree), &states[0], &end_m);
        let toml = scene::toml(self, &goals);
        let acted = Acted::of(self.distortion);
        let mut strike = acted_out(toml.clone(), (Vec::new(), states), &acted, &mut random);
        let said_toml = self.wrong.said(&toml, self.rods.len());
        let mut said = scene_from_toml(&said_toml).expect("a valid scene");
        if let Wish::Beyond(by_m) = self.wish {
            let hangs_m = Vector3::new(0.0, 0.0, scene::HANGS_M);
            let reach_m: f64 = self.rods.iter().map(|rod| rod.length_m).sum();
            let beyond_m = hangs_m + (end_m - hangs_m).normalize() * (reach_m + by_m);
            ask_elsewhere(&mut strike.scene, beyond_m);
            ask_elsewhere(&mut said, beyond_m);
        }
        Performance {
            strike,
            said,
            said_toml,
        }
    }

    /// Where the lower end of the last rod is \[m\].
    fn end_m(&self, scene: &Scene, tree: &Tree, last: &TreeState) -> Vector3<f64> {
        let mut snapshot = Snapshot::new(tree, &scene.gravity_m_s2);
        snapshot.set(last);
        let rod = self.rods.len() - 1;
        snapshot.point(rod, &self.rods[rod].end_m())
    }
}

/// Asks the last rod's end to be elsewhere in the end: a file that asks for what is out of reach is refused.
fn ask_elsewhere(scene: &mut Scene, end_m: Vector3<f64>) {
    if let Some(goal) = scene.goals.last_mut()
        && let GoalTarget::Condition(condition) = &mut goal.target
    {
        condition.set = GoalSet::point(end_m);
    }
}

impl Rod {
    /// Its lower end \[m, in its axes\].
    pub fn end_m(&self) -> Vector3<f64> {
        Vector3::new(0.0, 0.0, -0.5 * self.length_m)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every kind has motions, of which the true one is a motion of its scene; what is out of reach is.
    #[test]
    fn every_kind_is_what_it_says() {
        for hard in cases::all().iter().filter(|hard| hard.duration_s < 5.0) {
            let performance = hard.perform(7005);
            let strike = &performance.strike;
            let samples = strike.scene.tracks.len() * strike.states.len();
            assert_eq!(strike.events.len(), samples + 2, "{}", hard.name);
            let is_right = hard.wrong == Wrong::Nothing;
            assert_eq!(
                performance.said_toml == strike.scene_toml,
                is_right,
                "{}",
                hard.name
            );
            let forest = strike.scene.forest();
            let last = &strike.states[strike.states.len() - 1];
            let asked = check::asked_end_m(&strike.scene).expect("a goal at the end");
            let off_m = (check::end_m(&strike.scene, &forest.trees()[0], last) - asked).norm();
            assert_eq!(off_m < 1e-9, hard.wish == Wish::Reached, "{}", hard.name);
        }
    }

    /// A joint that passes 90° does so, and one that does not is no such motion.
    #[test]
    fn a_joint_passes_its_quarter_turn() {
        let all = cases::all();
        let through = all
            .iter()
            .find(|hard| matches!(hard.draw, Draw::Through(_)));
        let hard = through.expect("a case");
        let states = hard.perform(7006).strike.states;
        let (least, most) = states
            .iter()
            .fold((f64::MAX, f64::MIN), |(least, most), state| {
                let along = state.coordinates[3].cos();
                (least.min(along), most.max(along))
            });
        assert!(least < 0.0 && most > 0.0, "{least} {most}");
    }
}
