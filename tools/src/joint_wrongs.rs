//! Scenes of joined bodies with one thing wrong.

use enact::config::scene_from_toml;
use enact::motion::{Quantity, Scene};

use crate::trees::ROD_M;

/// What a scene of rods says wrongly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Wrong {
    /// Nothing.
    Nothing,
    /// The last rod but one is longer by this share beyond its middle: the last joint is so much further along it.
    Long(f64),
    /// The last joint is beside the middle of the rod before it \[m\].
    Beside(f64),
    /// The last rod weighs so many times as much.
    Heavy(f64),
    /// Gravity is so many times as great.
    Gravity(f64),
}

impl Wrong {
    /// Those that are measured.
    pub const ALL: [Wrong; 9] = [
        Wrong::Nothing,
        Wrong::Long(0.05),
        Wrong::Long(0.1),
        Wrong::Long(0.2),
        Wrong::Beside(0.005),
        Wrong::Beside(0.01),
        Wrong::Beside(0.02),
        Wrong::Heavy(2.0),
        Wrong::Gravity(0.9),
    ];

    /// In words.
    pub fn words(self) -> String {
        match self {
            Wrong::Nothing => "nothing".to_owned(),
            Wrong::Long(share) => format!("a rod {:.0} % too long", 100.0 * share),
            Wrong::Beside(off_m) => format!("a joint {:.0} mm off", 1e3 * off_m),
            Wrong::Heavy(times) => format!("a rod {times} times as heavy"),
            Wrong::Gravity(times) => format!("{times} of gravity"),
        }
    }

    /// The scene file of some rods that says it.
    ///
    /// # Panics
    /// Where the file is none of [`trees`](crate::trees) or [`tree_impacts`](crate::tree_impacts).
    pub fn said(self, scene_toml: &str, rods: usize) -> String {
        let half_mm = 500.0 * ROD_M;
        let within = |table: String, from: String, to: String| {
            let begin = scene_toml.find(&table).expect("the table");
            let (before, after) = scene_toml.split_at(begin);
            assert!(after.contains(&from), "{from}");
            format!("{before}{}", after.replacen(&from, &to, 1))
        };
        let place = |beside_mm: f64, along_mm: f64| {
            within(
                format!("name = \"joint {rods}\""),
                format!("parent_at_mm = [0, 0, {:?}]", -half_mm),
                format!("parent_at_mm = [0, {beside_mm:?}, {:?}]", -along_mm),
            )
        };
        match self {
            Wrong::Nothing => scene_toml.to_owned(),
            Wrong::Long(share) => place(0.0, half_mm + 1e3 * ROD_M * share),
            Wrong::Beside(off_m) => place(1e3 * off_m, half_mm),
            Wrong::Heavy(times) => within(
                format!("name = \"rod {rods}\""),
                "mass_g = 100".to_owned(),
                format!("mass_g = {:?}", 100.0 * times),
            ),
            Wrong::Gravity(times) => {
                let gravity = format!("gravity_m_s2 = [0, 0, {:?}]", -9.80665 * times);
                format!("{gravity}\n{scene_toml}")
            }
        }
    }

    /// The scene that says it.
    ///
    /// # Panics
    /// As [`Wrong::said`] does.
    pub fn scene(self, scene_toml: &str, rods: usize) -> Scene {
        scene_from_toml(&self.said(scene_toml, rods)).expect("a valid scene")
    }

    /// Whether a quantity is what is wrong.
    pub fn is_of(self, scene: &Scene, quantity: Quantity) -> bool {
        let link = |quantity: Quantity| match quantity {
            Quantity::JointPlace { child, .. } | Quantity::Mass { link: child } => {
                Some(scene.links[child].name.as_str())
            }
            _ => None,
        };
        let last = scene.links.last().map(|link| link.name.as_str());
        match self {
            Wrong::Nothing => false,
            Wrong::Long(_) | Wrong::Beside(_) => {
                matches!(quantity, Quantity::JointPlace { .. }) && link(quantity) == last
            }
            Wrong::Heavy(_) => matches!(quantity, Quantity::Mass { .. }),
            Wrong::Gravity(_) => matches!(quantity, Quantity::Gravity { .. }),
        }
    }
}
