//! Cubes that are really thrown, with one thing wrong in the scene: what the program should blame.

use enact::motion::{ContactLaw, ContactLawIndex, LinkIndex, Quantity, Scene, TrackIndex};
use enact::physics::{Body, contact};
use nalgebra::{UnitQuaternion, Vector3};

use super::Asked;
use super::faults::{asked, each_face, lift_tables, stretch};
use crate::perform::{Acting, Polyhedron, Throw, Truth, bounces};

/// What is wrong, and by how much.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wrong {
    /// Nothing.
    Nothing,
    /// Restitution of the first bounce is 0.25 too low.
    Restitution,
    /// Friction of the first bounce is 0.2, where there is none.
    Friction,
    /// Moments of inertia are half as large.
    Inertia,
    /// Gravity is 5 % too weak.
    Gravity,
    /// Gravity has 0.5 m/s² across.
    GravityDirection,
    /// The table is 8 mm too high.
    TableHeight,
    /// The table is tilted by 0.05 rad.
    TableTilt,
    /// The tracker is 10 mm off.
    Tracker,
    /// The tracker is turned by 0.05 rad.
    TrackerTurn,
    /// The centre of mass is 6 mm off.
    Centre,
    /// The clock is 3 % slow.
    Clock,
    /// The air is left out: a quadratic drag of 0.13/m, a table-tennis ball's.
    Drag,
}

/// Quadratic drag of a table-tennis ball \[1/m\]: half the air's density, 1.2 kg/m³, times a drag
/// coefficient of 0.47 and the cross-section of 40 mm, over 2.7 g.
const BALL_PER_M: f64 = 0.13;

impl Wrong {
    /// All that is wrong.
    pub const ALL: [Self; 12] = [
        Self::Restitution,
        Self::Friction,
        Self::Inertia,
        Self::Gravity,
        Self::GravityDirection,
        Self::TableHeight,
        Self::TableTilt,
        Self::Tracker,
        Self::TrackerTurn,
        Self::Centre,
        Self::Clock,
        Self::Drag,
    ];

    /// In words.
    pub fn name(self) -> &'static str {
        match self {
            Self::Nothing => "nothing",
            Self::Restitution => "restitution 0.25 too low",
            Self::Friction => "friction 0.2 for none",
            Self::Inertia => "inertia × 0.5",
            Self::Gravity => "gravity 5 % too weak",
            Self::GravityDirection => "gravity 0.5 m/s² across",
            Self::TableHeight => "table 8 mm too high",
            Self::TableTilt => "table tilted by 0.05 rad",
            Self::Tracker => "tracker 10 mm off",
            Self::TrackerTurn => "tracker turned by 0.05 rad",
            Self::Centre => "centre of mass 6 mm off",
            Self::Clock => "clock 3 % slow",
            Self::Drag => "air left out",
        }
    }

    /// Whether that quantity, freed, is the culprit.
    pub fn is_of(self, quantity: Quantity) -> bool {
        match quantity {
            Quantity::Restitution { law } => self == Self::Restitution && law == ContactLawIndex(0),
            Quantity::Friction { law } => self == Self::Friction && law == ContactLawIndex(0),
            Quantity::Moment { .. } => self == Self::Inertia,
            Quantity::Gravity { .. } => {
                matches!(self, Self::Gravity | Self::GravityDirection)
            }
            Quantity::SurfaceHeight { .. } => self == Self::TableHeight,
            Quantity::SurfaceTilt { .. } => self == Self::TableTilt,
            Quantity::TrackerPosition { .. } => self == Self::Tracker,
            Quantity::TrackerOrientation { .. } => self == Self::TrackerTurn,
            Quantity::Centre { .. } => self == Self::Centre,
            Quantity::ClockRate { .. } => self == Self::Clock,
            Quantity::LinearDrag { .. } | Quantity::QuadraticDrag { .. } => self == Self::Drag,
            _ => false,
        }
    }

    /// The true throw of a seed, with one or two bounces. Fails where none is found.
    pub fn truth(self, seed: u64) -> Result<Truth, String> {
        let count = 1 + (seed / 2 % 2) as usize;
        let throw = Throw {
            quadratic_drag_per_m: if self == Self::Drag { BALL_PER_M } else { 0.0 },
            ..Throw::BOX
        };
        let truth = bounces::thrown(Polyhedron::Cube, &throw, count, seed);
        truth.map_err(|error| error.to_string())
    }

    /// That throw acted so, with this wrong in its scene. Weights are those of the noise, or where a hand strays, as they are.
    pub fn asked(self, acting: &Acting, seed: u64) -> Result<Asked, String> {
        let mut asked = asked(&self.truth(seed)?, acting, seed);
        if acting.distortion == 0.0 {
            asked.scene.weights.position_m = acting.noise_position_m;
            asked.scene.weights.orientation_rad = acting.noise_orientation_rad;
        }
        self.put_into(&mut asked);
        Ok(asked)
    }

    fn put_into(self, asked: &mut Asked) {
        let scene = &mut asked.scene;
        let tracker = &mut scene.tracks[TrackIndex(0)].link_from_tracker;
        match self {
            Self::Nothing => {}
            Self::Restitution => first_law(scene).restitution -= 0.25,
            Self::Friction => first_law(scene).friction += 0.2,
            Self::Inertia => {
                let link = &mut scene.links[LinkIndex(0)];
                let half = link.body.with_factors(1.0, &Vector3::repeat(0.5));
                link.body = half.expect("a body");
            }
            Self::Gravity => scene.gravity_m_s2 *= 0.95,
            Self::GravityDirection => scene.gravity_m_s2.x += 0.5,
            Self::TableHeight => lift_tables(scene, 0.008),
            Self::TableTilt => each_face(scene, |point_m, normal| {
                let turn = UnitQuaternion::from_scaled_axis(Vector3::new(0.05, 0.0, 0.0));
                contact::Feature::face(point_m, turn * normal)
            }),
            Self::Tracker => tracker.translation.vector.x += 0.01,
            Self::TrackerTurn => {
                tracker.rotation *= UnitQuaternion::from_scaled_axis(Vector3::new(0.0, 0.05, 0.0));
            }
            Self::Centre => {
                tracker.translation.vector.x += 0.006;
                for feature in &mut scene.links[LinkIndex(0)].features {
                    if let contact::Feature::Point { point_m, .. } = &mut feature.geometry {
                        point_m.x += 0.006;
                    }
                }
            }
            Self::Clock => stretch(&mut asked.events, 1.03),
            Self::Drag => {
                let link = &mut scene.links[LinkIndex(0)];
                let (mass_kg, moments_kg_m2) = (link.body.mass_kg(), link.body.moments_kg_m2());
                link.body = Body::new(mass_kg, moments_kg_m2).expect("a body");
            }
        }
    }
}

fn first_law(scene: &mut Scene) -> &mut ContactLaw {
    scene.contact_laws.first_mut().expect("a bounce has a law")
}
