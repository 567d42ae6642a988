//! What a support does to the body that it carries.

use nalgebra::Vector3;

use super::estimate::ArcEstimate;
use super::scene::Scene;
use crate::physics::Support;
use crate::physics::flow::Supported;
use crate::physics::state::part;

/// The force of a support on a body at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BorneForce {
    /// [N, world].
    pub force_n: Vector3<f64>,
    /// The normal of the surface, away from it \[world\]; `None` at a pivot.
    pub normal: Option<Vector3<f64>>,
}

impl BorneForce {
    /// How hard a surface presses \[N\]; `None` at a pivot.
    pub fn pressing_n(&self) -> Option<f64> {
        Some(self.normal?.dot(&self.force_n))
    }

    /// Friction of a surface \[N\]; `None` at a pivot.
    pub fn friction_n(&self) -> Option<f64> {
        let normal = self.normal?;
        Some((self.force_n - normal * normal.dot(&self.force_n)).norm())
    }

    /// The whole at a pivot \[N\]; `None` on a surface.
    pub fn pivot_n(&self) -> Option<f64> {
        match self.normal {
            Some(_) => None,
            None => Some(self.force_n.norm()),
        }
    }
}

impl ArcEstimate {
    /// What its support does to the body at physical times \[s\], `m (v̇ − p)` of the pull `p`; `None` in flight, and of what
    /// is stuck to another body. The scene is as estimated.
    pub fn borne(
        &self,
        scene: &Scene,
        gravity_m_s2: &Vector3<f64>,
        times_s: impl Iterator<Item = f64>,
    ) -> Option<Vec<BorneForce>> {
        let body = scene.body_on(self);
        let normal = match self.support? {
            Support::Plane(plane) => Some(plane.normal),
            Support::Pivot(_) => None,
            // What two bodies do to each other is none of the world's.
            Support::Stuck(_) => return None,
        };
        let mut supported = Supported::new(&body, gravity_m_s2, &self.state)?;
        let pull = body.pull_m_s2(gravity_m_s2);
        let forces = times_s.map(|time_s| {
            let rate = supported.carried(time_s - self.epoch_s).rate;
            let acceleration: Vector3<f64> = rate.fixed_rows::<3>(part::VELOCITY).into();
            BorneForce {
                force_n: (acceleration - pull) * body.mass_kg(),
                normal,
            }
        });
        Some(forces.collect())
    }
}
