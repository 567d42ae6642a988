//! The two ways of throwing a pencil into a mug (paper, figure 1).
//!
//! Each is built backward from its goal: from the goal's pose and a chosen landing velocity back
//! to the bounce, through the inverted impact, back to the start. Then it is simulated forward.

use enact::motion::{GoalTarget, LinkIndex, Scene};
use enact::physics::State;
use nalgebra::Vector3;

use super::encounter::{Encounter, still};
use super::truth::{Flight, SCAN_S, Truth, TruthError, crossing_s, simulate};

/// How far back a bounce is looked for \[s\].
const LONGEST_ARC_S: f64 = 2.0;

/// How the pencil is thrown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Style {
    /// Tip first, then a full tumble.
    Tip,
    /// Eraser first, then half a tumble.
    Eraser,
}

/// What is chosen besides the goal.
struct Landing {
    velocity_m_s: Vector3<f64>,
    /// Without the part along the pencil [rad/s, world].
    tumble_rad_s: Vector3<f64>,
    /// About the pencil's own axis [rad/s].
    twirl_rad_s: f64,
    before_bounce_s: f64,
}

impl Style {
    /// Both.
    pub const ALL: [Style; 2] = [Style::Tip, Style::Eraser];

    /// Its word in file names and flags.
    pub fn as_str(self) -> &'static str {
        match self {
            Style::Tip => "tip",
            Style::Eraser => "eraser",
        }
    }

    /// Its scene file.
    pub fn scene_toml(self) -> &'static str {
        match self {
            Style::Tip => include_str!("../../../config/pencil_tip.toml"),
            Style::Eraser => include_str!("../../../config/pencil_eraser.toml"),
        }
    }

    /// Found by scanning for a landing that passes the mug's rim in the middle and comes from a
    /// pencil let go about 0.57 m above the table, slowly turning.
    fn landing(self) -> Landing {
        match self {
            Style::Tip => Landing {
                velocity_m_s: Vector3::new(0.6, 0.1, -2.2),
                tumble_rad_s: Vector3::new(-0.3, 13.84, 0.0),
                twirl_rad_s: 20.0,
                before_bounce_s: 0.35,
            },
            Style::Eraser => Landing {
                velocity_m_s: Vector3::new(0.45, -0.12, -2.1),
                tumble_rad_s: Vector3::new(0.25, 7.4, 0.0),
                twirl_rad_s: -16.0,
                before_bounce_s: 0.35,
            },
        }
    }

    /// The true motion in the style's own scene.
    ///
    /// # Panics
    /// If the scene file in this repository is broken.
    pub fn truth(self) -> Truth {
        let scene = enact::config::scene_from_toml(self.scene_toml()).expect("a valid scene file");
        self.truth_in(&scene)
            .expect("a scene with a bounce and a pose goal")
    }

    /// The true motion in a scene of one body, one bounce and a pose goal at the end.
    pub fn truth_in(self, scene: &Scene) -> Result<Truth, TruthError> {
        if scene.links.len() != 1 {
            return Err(TruthError::Bodies {
                count: scene.links.len(),
                expected: 1,
            });
        }
        let lacks = |what| TruthError::Lacks { what };
        let goal = scene.goals.iter().find_map(|goal| match &goal.target {
            GoalTarget::Pose { world_from_body } => Some(*world_from_body),
            GoalTarget::PositionWithin { .. } | GoalTarget::Condition(_) => None,
        });
        let goal = goal.ok_or(lacks("a pose goal"))?;
        let parameters: Vec<f64> = scene.parameters.iter().map(|p| p.initial).collect();
        let bounce = (0..scene.events.len())
            .find_map(|event| Encounter::of(scene, &parameters, event))
            .ok_or(lacks("a collision"))?;

        let chosen = self.landing();
        let mut angular_velocity_rad_s =
            goal.rotation.inverse_transform_vector(&chosen.tumble_rad_s);
        angular_velocity_rad_s.z = chosen.twirl_rad_s;
        let landing = State {
            position_m: goal.translation.vector,
            orientation: goal.rotation,
            velocity_m_s: chosen.velocity_m_s,
            angular_velocity_rad_s,
        };
        let flight = Flight::of(scene, LinkIndex(0));
        let after_bounce_s = crossing_s(SCAN_S, LONGEST_ARC_S, |time_s| {
            bounce.gap_m(&flight.advance(&landing, -time_s), &still())
        })
        .ok_or(lacks("a bounce before the landing"))?;
        let after = flight.advance(&landing, -after_bounce_s);
        let (before, _) = bounce.before(&after, &still());
        let initial = flight.advance(&before, -chosen.before_bounce_s);
        let duration_s = chosen.before_bounce_s + after_bounce_s;
        simulate(scene, &parameters, &[initial], duration_s)
    }
}
