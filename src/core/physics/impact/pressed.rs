//! A contact that lasts: how two bodies move while they press on each other, and where they come apart.
//!
//! The impulse of the impact acts over a time `T`, as that of a spring with a damper does along the normal: with the
//! restitution `e`, `ω = π/T` and `γ = −ln(e)/T`, a normal speed `u` becomes
//!
//! ```text
//! ż = u exp(−γ s) (cos ω s − γ/ω sin ω s),   z = u/ω exp(−γ s) sin ω s,   z(T) = 0,   ż(T) = −e u
//! ```
//!
//! so that the share `h = (1 − ż/u)/(1 + e)` of the change of all velocities has happened after `s`. With
//! `H = ∫h = (s − z/u)/(1 + e)`, the change `Δ` by the impact and the pull `a` that the contact does not bear,
//!
//! ```text
//! x = x⁻ + s v⁻ + H Δv + ½ s² a,   R = R⁻ Exp(s ω⁻ + H Δω),   v = v⁻ + h Δv + s a,   ω = ω⁻ + h Δω
//! ```
//!
//! At the end `H = T/(1 + e)`: the point of contact is as high as it was, and has gone on along the surface.

use std::f64::consts::PI;

use nalgebra::{SMatrix, Vector3};

use super::law::Velocities;
use crate::math::so3;
use crate::physics::state::{ByStates, State, StateTangent, part};

/// Restitution below which the damper is no stronger: the impulse is over at once.
const LEAST_RESTITUTION: f64 = 1e-6;

/// Derivatives of a state by both velocities of an impact.
pub type ByVelocities = SMatrix<f64, 12, 6>;

/// On what a body presses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PressedOn {
    /// What does not move.
    World,
    /// What is in a hand.
    Held,
    /// What flies, too.
    Flying,
}

/// How a body is pressed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pressed {
    /// How long \[s\].
    pub duration_s: f64,
    /// Restitution of the impact.
    pub restitution: f64,
    /// What acts on the body beside the contact, per mass [m/s²].
    pub pull_m_s2: Vector3<f64>,
}

impl Pressed {
    /// The state some time after the touch, from that at the touch and the velocities after an impact that is one moment.
    pub fn state(&self, touching: &State, after: &Velocities, since_s: f64) -> State {
        let restitution = self.restitution.max(LEAST_RESTITUTION);
        let frequency_rad_s = PI / self.duration_s;
        let decay_per_s = -restitution.ln() / self.duration_s;
        let (sine, cosine) = (frequency_rad_s * since_s).sin_cos();
        let faded = (-decay_per_s * since_s).exp();
        let speed = faded * (cosine - decay_per_s / frequency_rad_s * sine);
        let depth_s = faded * sine / frequency_rad_s;
        let share = (1.0 - speed) / (1.0 + restitution);
        let share_s = (since_s - depth_s) / (1.0 + restitution);
        let (v, omega) = (touching.velocity_m_s, touching.angular_velocity_rad_s);
        let changed_m_s = after.velocity_m_s - v;
        let turned_rad_s = after.angular_velocity_rad_s - omega;
        let pull = self.pull_m_s2;
        State {
            position_m: touching.position_m
                + v * since_s
                + changed_m_s * share_s
                + pull * (0.5 * since_s * since_s),
            orientation: touching.orientation
                * so3::exp(&(omega * since_s + turned_rad_s * share_s)),
            velocity_m_s: v + changed_m_s * share + pull * since_s,
            angular_velocity_rad_s: omega + turned_rad_s * share,
        }
    }

    /// The state in which the body comes off, with its derivatives.
    pub fn left(&self, touching: &State, after: &Velocities) -> LeftState {
        let Self {
            duration_s,
            restitution,
            pull_m_s2,
        } = *self;
        let share = 1.0 / (1.0 + restitution);
        let (v, omega) = (touching.velocity_m_s, touching.angular_velocity_rad_s);
        let changed_m_s = after.velocity_m_s - v;
        let turned_rad_s = after.angular_velocity_rad_s - omega;
        let (mean_m_s, mean_rad_s) = (v + changed_m_s * share, omega + turned_rad_s * share);
        let (turn, right) = so3::exp_and_right_jacobian(&(mean_rad_s * duration_s));
        let state = State {
            position_m: touching.position_m
                + mean_m_s * duration_s
                + pull_m_s2 * (0.5 * duration_s * duration_s),
            orientation: touching.orientation * turn,
            velocity_m_s: after.velocity_m_s + pull_m_s2 * duration_s,
            angular_velocity_rad_s: after.angular_velocity_rad_s,
        };
        let moved = |velocity: Vector3<f64>, spin: Vector3<f64>| {
            let mut by = StateTangent::zeros();
            by.fixed_rows_mut::<3>(part::POSITION).copy_from(&velocity);
            by.fixed_rows_mut::<3>(part::ORIENTATION)
                .copy_from(&(right * spin));
            by
        };
        let mut by_after = ByVelocities::zeros();
        let mut by_touching = ByStates::zeros();
        by_touching
            .fixed_view_mut::<3, 3>(part::POSITION, part::POSITION)
            .fill_with_identity();
        by_touching
            .fixed_view_mut::<3, 3>(part::ORIENTATION, part::ORIENTATION)
            .copy_from(&so3::matrix(&turn.inverse()));
        for axis in 0..3 {
            let along = Vector3::ith(axis, duration_s);
            let (velocity, spin) = (
                moved(along, Vector3::zeros()),
                moved(Vector3::zeros(), along),
            );
            by_after.set_column(axis, &(velocity * share));
            by_after.set_column(3 + axis, &(spin * share));
            let (at, about) = (part::VELOCITY + axis, part::ANGULAR_VELOCITY + axis);
            by_touching.set_column(at, &(velocity * (1.0 - share)));
            by_touching.set_column(about, &(spin * (1.0 - share)));
        }
        by_after
            .fixed_view_mut::<6, 6>(part::VELOCITY, 0)
            .fill_with_identity();
        let mut by_duration = moved(mean_m_s + pull_m_s2 * duration_s, mean_rad_s);
        by_duration
            .fixed_rows_mut::<3>(part::VELOCITY)
            .copy_from(&pull_m_s2);
        let less = -share * share * duration_s;
        LeftState {
            state,
            by_touching,
            by_after,
            by_duration,
            by_restitution: moved(changed_m_s * less, turned_rad_s * less),
        }
    }

    /// Derivative of the state in which the body comes off by a part of the pull, along `along`.
    pub fn left_by_pull(&self, along: &Vector3<f64>) -> StateTangent {
        let mut by = StateTangent::zeros();
        let duration_s = self.duration_s;
        by.fixed_rows_mut::<3>(part::POSITION)
            .copy_from(&(along * (0.5 * duration_s * duration_s)));
        by.fixed_rows_mut::<3>(part::VELOCITY)
            .copy_from(&(along * duration_s));
        by
    }
}

/// The state in which a pressed body comes off.
#[derive(Clone, Debug)]
pub struct LeftState {
    /// The state.
    pub state: State,
    /// Its derivatives by the state at the touch, the velocities after the impact apart,
    pub by_touching: ByStates,
    /// by these,
    pub by_after: ByVelocities,
    /// by how long the contact lasts,
    pub by_duration: StateTangent,
    /// and by the restitution, these velocities apart.
    pub by_restitution: StateTangent,
}

#[cfg(test)]
mod tests {
    use nalgebra::UnitQuaternion;

    use super::*;

    fn pressed() -> Pressed {
        Pressed {
            duration_s: 0.04,
            restitution: 0.7,
            pull_m_s2: Vector3::new(0.6, -0.2, 0.0),
        }
    }

    fn touching() -> State {
        State {
            position_m: Vector3::new(0.1, -0.2, 0.3),
            orientation: UnitQuaternion::from_euler_angles(0.3, -0.4, 0.5),
            velocity_m_s: Vector3::new(1.2, 0.4, -3.0),
            angular_velocity_rad_s: Vector3::new(4.0, -7.0, 2.0),
        }
    }

    fn after() -> Velocities {
        Velocities {
            velocity_m_s: Vector3::new(0.9, 0.5, 2.1),
            angular_velocity_rad_s: Vector3::new(-3.0, 5.0, 2.5),
        }
    }

    #[test]
    fn it_comes_off_as_high_as_it_touched_with_the_speed_of_its_restitution() {
        let (pressed, touching, after) = (pressed(), touching(), after());
        let left = pressed.left(&touching, &after).state;
        assert!((left.position_m.z - touching.position_m.z).abs() < 1e-15);
        let on_the_way = pressed.state(&touching, &after, pressed.duration_s);
        assert!(on_the_way.minus(&left).norm() < 1e-12);
        let at_first = pressed.state(&touching, &after, 0.0);
        assert!(at_first.minus(&touching).norm() < 1e-15);
    }

    #[test]
    fn it_moves_as_its_velocities_say() {
        let (pressed, touching, after) = (pressed(), touching(), after());
        for since_s in [0.003, 0.02, 0.037] {
            let [before, now, later] =
                [-1e-6, 0.0, 1e-6].map(|off_s| pressed.state(&touching, &after, since_s + off_s));
            let slope = (later.position_m - before.position_m) / 2e-6;
            assert!((slope - now.velocity_m_s).norm() < 1e-6, "{since_s}");
        }
    }

    #[test]
    fn derivatives_are_those_of_differences() {
        let (pressed, touching, after) = (pressed(), touching(), after());
        let left = pressed.left(&touching, &after);
        const STEP: f64 = 1e-6;
        let slope = |state: &dyn Fn(f64) -> State| state(STEP).minus(&state(-STEP)) / (2.0 * STEP);
        for entry in 0..12 {
            let by = slope(&|step| {
                let moved = touching.retract(&StateTangent::ith(entry, step));
                pressed.left(&moved, &after).state
            });
            assert!(
                (by - left.by_touching.column(entry)).norm() < 1e-8,
                "{entry}"
            );
        }
        for entry in 0..6 {
            let by = slope(&|step| {
                let mut moved = after;
                let half = match entry < 3 {
                    true => &mut moved.velocity_m_s,
                    false => &mut moved.angular_velocity_rad_s,
                };
                half[entry % 3] += step;
                pressed.left(&touching, &moved).state
            });
            assert!((by - left.by_after.column(entry)).norm() < 1e-8, "{entry}");
        }
        let with = |change: &dyn Fn(&mut Pressed)| {
            let mut other = pressed;
            change(&mut other);
            other.left(&touching, &after).state
        };
        let by = slope(&|step| with(&|of| of.duration_s += step));
        assert!((by - left.by_duration).norm() < 1e-7);
        let by = slope(&|step| with(&|of| of.restitution += step));
        assert!((by - left.by_restitution).norm() < 1e-8);
        let along = Vector3::new(0.3, 0.5, -0.2);
        let by = slope(&|step| with(&|of| of.pull_m_s2 += along * step));
        assert!((by - pressed.left_by_pull(&along)).norm() < 1e-8);
    }
}
