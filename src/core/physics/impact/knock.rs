//! What happens at each contact of an impact: where, how fast, with which impulse.

use nalgebra::Vector3;

use super::law::Velocities;
use super::solution::ImpactSolution;

/// What happens at one contact of an impact, or at the middle of several.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Knock {
    /// Where A is touched [m, world].
    pub point_m: Vector3<f64>,
    /// The tilted unit normal, towards A \[world\].
    pub normal: Vector3<f64>,
    /// Velocity of A there against B's, before and after [m/s, world].
    pub velocities_m_s: [Vector3<f64>; 2],
    /// Impulse on A; that on B is the opposite [N s, world].
    pub impulse_n_s: Vector3<f64>,
    /// Moment on A beside that impulse [N m s, world]: of the friction of a face that lands flat about the normal, of a pin
    /// that catches across its axis. Zero of all else.
    pub moment_n_m_s: Vector3<f64>,
}

impl Knock {
    /// Speed along the normal before, positive approaching [m/s].
    pub fn approach_m_s(&self) -> f64 {
        -self.normal.dot(&self.velocities_m_s[0])
    }

    /// Speed along the normal after, positive parting [m/s].
    pub fn parting_m_s(&self) -> f64 {
        self.normal.dot(&self.velocities_m_s[1])
    }

    /// Speed across the normal, before and after [m/s].
    pub fn slips_m_s(&self) -> [f64; 2] {
        self.velocities_m_s
            .map(|of| (of - self.normal * self.normal.dot(&of)).norm())
    }

    /// Several contacts of one normal as one, where they press in the mean; in their middle where they do not press. `None` of
    /// none.
    pub fn whole(knocks: &[Self]) -> Option<Self> {
        let first = knocks.first()?;
        let pressing_n_s = |of: &Self| of.normal.dot(&of.impulse_n_s);
        let pressed_n_s: f64 = knocks.iter().map(pressing_n_s).sum();
        let share = |of: &Self| match pressed_n_s > 0.0 {
            true => pressing_n_s(of) / pressed_n_s,
            false => 1.0 / knocks.len() as f64,
        };
        // Velocities of a rigid body are linear in the place.
        let mean = |of: &dyn Fn(&Self) -> Vector3<f64>| -> Vector3<f64> {
            knocks.iter().map(|knock| of(knock) * share(knock)).sum()
        };
        Some(Self {
            point_m: mean(&|of| of.point_m),
            normal: first.normal,
            velocities_m_s: [0, 1].map(|at| mean(&|of| of.velocities_m_s[at])),
            impulse_n_s: knocks.iter().map(|of| of.impulse_n_s).sum(),
            moment_n_m_s: knocks.iter().map(|of| of.moment_n_m_s).sum(),
        })
    }
}

impl ImpactSolution<'_> {
    /// Contact by contact; of a flat landing with friction, which tells none of them by itself, the whole.
    pub(super) fn knocks(&self) -> Vec<Knock> {
        let impact = self.impact();
        let knocks = self.states().enumerate().map(|(contact, state)| {
            let points_m = [state.touch.on_a_m, state.touch.on_b_m];
            let arms_m = [0, 1].map(|side| self.frames[side].orientation * points_m[side]);
            let velocity = |of: &[Velocities; 2]| {
                let [a, b] = [0, 1].map(|side| {
                    let spin = self.frames[side].orientation * of[side].angular_velocity_rad_s;
                    of[side].velocity_m_s + spin.cross(&arms_m[side])
                });
                a - b
            };
            Knock {
                point_m: self.frames[0].position_m + arms_m[0],
                normal: state.normal,
                velocities_m_s: [velocity(&self.before), velocity(&impact.after)],
                impulse_n_s: self.impulse_at(contact, state, &impact),
                moment_n_m_s: Vector3::zeros(),
            }
        });
        let knocks: Vec<Knock> = knocks.collect();
        let Some(landed) = self.landing().and_then(|_| Knock::whole(&knocks)) else {
            return knocks;
        };
        let [impulse_n_s, turned_n_m_s] = self.gained(&impact.after[0]);
        let arm_m = landed.point_m - self.frames[0].position_m;
        vec![Knock {
            impulse_n_s,
            moment_n_m_s: turned_n_m_s - arm_m.cross(&impulse_n_s),
            ..landed
        }]
    }
}
