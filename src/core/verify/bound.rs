//! Upper bounds of how fast a body moves, in flight or on what carries it.

use nalgebra::Vector3;

use crate::motion::ArcEstimate;
use crate::physics::support::{Pivot, PivotAxes};
use crate::physics::{Body, PlaneSupport, State, Support, Sustained};

/// Moments closer than this, relative to the largest, are treated as equal in the bound.
const APART: f64 = 1e-6;

/// Greatest speed of the centre of mass [m/s], and greatest angular speed [rad/s].
#[derive(Clone, Copy, Debug)]
pub(super) struct SpeedBound {
    pub(super) speed_m_s: f64,
    pub(super) spin_rad_s: f64,
}

impl SpeedBound {
    /// Of a part of an arc from one state to another.
    pub(super) fn new(
        body: &Body,
        gravity_m_s2: &Vector3<f64>,
        arc: &ArcEstimate,
        ends: &[State; 2],
        duration_s: f64,
    ) -> Self {
        let pull_m_s2 = body.pull_m_s2(gravity_m_s2);
        match &arc.support {
            Some(Support::Plane(plane)) => {
                Self::on_plane(body, plane, &pull_m_s2, ends, duration_s)
            }
            Some(Support::Pivot(pivot)) => Self::at_pivot(body, pivot, &pull_m_s2, &ends[0]),
            // Lift turns the velocity: what gravity gains may be lost again before the end.
            None if body.lift() != 0.0 => Self {
                speed_m_s: ends[0].velocity_m_s.norm() + pull_m_s2.norm() * duration_s.abs(),
                spin_rad_s: arc.state.angular_velocity_rad_s.norm(),
            },
            Some(Support::Stuck(part)) => {
                let [first, last] = [0, 1].map(|end: usize| part.of_whole(&ends[end]));
                let speed_m_s = first.velocity_m_s.norm().max(last.velocity_m_s.norm());
                let spin_rad_s = spin_bound_rad_s(&part.whole(), &first.angular_velocity_rad_s);
                Self {
                    speed_m_s: speed_m_s + spin_rad_s * part.centre_m.norm(),
                    spin_rad_s,
                }
            }
            None => Self {
                // |v| is largest at an end: where it stands still its second derivative is positive, as
                // |p|² > (p·v)²/v² there, with drag as without.
                speed_m_s: ends[0].velocity_m_s.norm().max(ends[1].velocity_m_s.norm()),
                spin_rad_s: spin_bound_rad_s(body, &arc.state.angular_velocity_rad_s),
            },
        }
    }

    /// By the greatest accelerations: what changes by no more than `a` is at most `½ (s₀ + s₁ + a T)`.
    fn on_plane(
        body: &Body,
        plane: &PlaneSupport,
        pull_m_s2: &Vector3<f64>,
        ends: &[State; 2],
        duration_s: f64,
    ) -> Self {
        let n = plane.normal;
        let pressed = -pull_m_s2.dot(&n);
        let along = (pull_m_s2 + n * pressed).norm();
        let friction = plane.friction * pressed;
        let least = body.moments_kg_m2().min() / body.mass_kg();
        let [straight, turning] = match (plane.sustained, plane.touching.radius_m()) {
            (Sustained::Rest, _) => [0.0, 0.0],
            (Sustained::Slide, Some(radius_m)) => [along + friction, friction * radius_m / least],
            (Sustained::Slide, None) => [along + friction, friction / least.sqrt()],
            (Sustained::Roll, radius_m) => {
                let most = along + friction;
                [most, radius_m.map_or(0.0, |radius_m| most / radius_m)]
            }
        };
        let most = |of: fn(&State) -> f64, rate: f64| {
            0.5 * (of(&ends[0]) + of(&ends[1]) + rate * duration_s)
        };
        Self {
            speed_m_s: most(|state| state.velocity_m_s.norm(), straight),
            spin_rad_s: most(|state| state.angular_velocity_rad_s.norm(), turning),
        }
    }

    /// By the energy, which is at most that of the beginning: `½ ωᵀJω ≤ ½ ω₀ᵀJω₀ − p·R₀ r + |p||r|`.
    fn at_pivot(body: &Body, pivot: &Pivot, pull_m_s2: &Vector3<f64>, start: &State) -> Self {
        let r = -pivot.at_m;
        let inertia = pivot.inertia_m2(&body.gyration_m2());
        let least = match pivot.axes {
            PivotAxes::All => inertia.symmetric_eigenvalues().min(),
            PivotAxes::One(axis) => axis.dot(&(inertia * axis)),
            PivotAxes::None => {
                return Self {
                    speed_m_s: start.velocity_m_s.norm(),
                    spin_rad_s: start.angular_velocity_rad_s.norm(),
                };
            }
        };
        let omega = start.angular_velocity_rad_s;
        let turning = 0.5 * omega.dot(&(inertia * omega));
        let falling = pull_m_s2.norm() * r.norm() - pull_m_s2.dot(&(start.orientation * r));
        let spin_rad_s = (2.0 * (turning + falling) / least).sqrt();
        Self {
            speed_m_s: spin_rad_s * r.norm(),
            spin_rad_s,
        }
    }
}

/// Largest `|ω|` of the free rotation through a given `ω`.
///
/// Energy and angular momentum fix the two sums `Σ I_i ω_i²` and `Σ I_i² ω_i²`; on the rest,
/// `Σ ω_i²` is linear in one unknown and largest where one of the three is zero, or at the given
/// `ω`.
pub(super) fn spin_bound_rad_s(body: &Body, omega: &Vector3<f64>) -> f64 {
    let moments = body.moments_kg_m2();
    let squares = omega.component_mul(omega);
    let twice_energy = moments.dot(&squares);
    let momentum_squared = moments.component_mul(&moments).dot(&squares);
    let mut largest = squares.sum();
    for axis in 0..3 {
        let (a, b) = (moments[(axis + 1) % 3], moments[(axis + 2) % 3]);
        if (a - b).abs() <= APART * moments.max() {
            continue;
        }
        let of_a = (momentum_squared - b * twice_energy) / (a * (a - b));
        let of_b = (momentum_squared - a * twice_energy) / (b * (b - a));
        if of_a >= 0.0 && of_b >= 0.0 {
            largest = largest.max(of_a + of_b);
        }
    }
    largest.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::verify::series;

    #[test]
    fn no_free_turn_spins_faster_than_its_bound() {
        for moments in [[3.0, 2.0, 2.0], [1.0, 9.0, 9.0], [2.0, 2.0, 2.0]] {
            let body = Body::new(1.0, Vector3::from(moments)).unwrap();
            let state = State {
                position_m: Vector3::zeros(),
                orientation: nalgebra::UnitQuaternion::identity(),
                velocity_m_s: Vector3::zeros(),
                angular_velocity_rad_s: Vector3::new(0.3, 2.0, -1.0),
            };
            let bound = spin_bound_rad_s(&body, &state.angular_velocity_rad_s);
            let largest = (0..100)
                .map(|k| series::advance(&body, &Vector3::zeros(), &state, 0.05 * k as f64))
                .map(|state| state.angular_velocity_rad_s.norm())
                .fold(0.0, f64::max);
            assert!(largest <= bound * (1.0 + 1e-9), "{largest} {bound}");
            assert!(bound <= largest * (1.0 + 1e-6), "{largest} {bound}");
        }
    }
}
