//! Dice of any size, thrown fast: what a hand really does and no bound may call absurd.

use enact::math::so3;
use enact::physics::contact;
use enact::physics::{Body, Shape, State};
use nalgebra::{UnitQuaternion, Vector3};

use super::Asked;
use crate::case::Case;
use crate::perform::{Acting, bounces};
use crate::stress::hit::{direction, hit, rng};

/// Half the side of the cube of [`bounces`] \[m\].
const HALF_M: f64 = 0.15;
/// A corner moves no faster about the middle than this [m/s].
const RIM_M_S: f64 = 10.0;

/// A die, its spin and its speed.
#[derive(Clone, Copy, Debug)]
pub struct Thrown {
    side_m: f64,
    spin_rad_s: f64,
    speed_m_s: f64,
}

/// 5 mm to 1 m, 5 to 200 rad/s, 2 to 20 m/s, as far as a hand could.
pub fn all() -> Vec<Thrown> {
    let mut all = Vec::new();
    for side_m in [0.005, 0.02, 0.1, 1.0] {
        for spin_rad_s in [5.0, 50.0, 200.0] {
            for speed_m_s in [2.0, 20.0] {
                let thrown = Thrown {
                    side_m,
                    spin_rad_s,
                    speed_m_s,
                };
                let is_possible = side_m * spin_rad_s < RIM_M_S && speed_m_s * side_m < 10.0;
                all.extend(is_possible.then_some(thrown));
            }
        }
    }
    all
}

impl Thrown {
    /// For the table.
    pub fn name(&self) -> String {
        let Self {
            side_m,
            spin_rad_s,
            speed_m_s,
        } = self;
        format!(
            "die of {} mm, {spin_rad_s} rad/s, {speed_m_s} m/s",
            side_m * 1e3
        )
    }

    /// One bounce, physical times, tracked at 500 Hz.
    pub fn asked(&self, seed: u64) -> Result<Asked, String> {
        let mut scene = bounces(1, 0).map_err(|error| error.to_string())?.scene;
        let scale = 0.5 * self.side_m / HALF_M;
        let cube = &mut scene.bodies[0];
        let moments_kg_m2 = cube.body.moments_kg_m2() * scale.powi(5);
        cube.body = Body::new(cube.body.mass_kg() * scale.powi(3), moments_kg_m2)
            .map_err(|error| error.to_string())?;
        cube.body_from_tracker.translation.vector *= scale;
        let sides_m = Vector3::repeat(self.side_m);
        cube.shape = Shape::Cuboid {
            half_extents_m: 0.5 * sides_m,
        };
        for feature in &mut cube.features {
            if let contact::Feature::Point { point_m, .. } = &mut feature.geometry {
                *point_m *= scale;
            }
        }
        let touching = scene.events[0]
            .kind
            .collision()
            .ok_or("no bounce")?
            .contacts[0];
        let corner = scene.bodies[0].features[touching.feature.ok_or("no feature")?].geometry;
        let contact::Feature::Point {
            point_m: corner_m, ..
        } = corner
        else {
            return Err("no corner".into());
        };
        let mut rng = rng(seed);
        let down = UnitQuaternion::rotation_between(&corner_m, &-Vector3::z());
        let orientation = so3::exp(&(direction(&mut rng) * 0.2)) * down.ok_or("opposite")?;
        let along_m_s = (self.speed_m_s * self.speed_m_s - 2.0).max(0.0).sqrt();
        let state = State {
            position_m: Vector3::new(0.3, 0.2, 0.0) - {
                let arm_m = orientation * corner_m;
                Vector3::new(0.0, 0.0, arm_m.z)
            },
            orientation,
            velocity_m_s: Vector3::new(
                along_m_s,
                0.2,
                -2.0_f64.max(0.8 * self.side_m * self.spin_rad_s),
            ),
            angular_velocity_rad_s: direction(&mut rng) * self.spin_rad_s,
        };
        let truth = hit(&scene, &state, 0.12, 0.12)?;
        let mut truth = truth;
        truth.scene.goals.clear();
        let acting = Acting {
            rate_hz: 500.0,
            distortion: (10.0 * self.side_m).min(1.0) * 0.25,
            mark_error_s: 0.01,
            ..Acting::timing_known()
        };
        let case = Case::new(&truth, &acting, seed);
        Ok(Asked {
            scene: case.scene().clone(),
            events: case.performance.events.clone(),
        })
    }
}
