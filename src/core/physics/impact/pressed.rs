//! A contact that lasts: how two bodies move while they press on each other, and where they come apart.
//!
//! The impulse of the impact acts over a time `T`, as that of a spring with a damper does along the normal: with the
//! restitution `e`, `ω = π/T` and `γ = −ln(e)/T`, a normal speed `u` becomes
//!
//! ```text
//! ż = u exp(−γ s) (cos ω s − γ/ω sin ω s),   z = u/ω exp(−γ s) sin ω s,   z(T) = 0,   ż(T) = −e u
//! ```
//!
//! A face of the world bears the body's weight, too, which presses by `g` and adds to friction: with `k = g/u` the impulse is
//! that of an impact with the restitution `e + k T`, of which the share `h` has acted after `s`, and `H = ∫h`:
//!
//! ```text
//! h = (1 − ż/u + k s)/(1 + e + k T),   H = (s − z/u + ½ k s²)/(1 + e + k T)
//! ```
//!
//! With the change `Δ` by that impact and the pull `a` on the body,
//!
//! ```text
//! x = x⁻ + s v⁻ + H Δv + ½ s² a,   v = v⁻ + h Δv + s a
//! R = R⁻ Exp(φ),   φ = s ω⁻ + H Δω,   ω = I⁻¹ Exp(−φ) I (ω⁻ + h Δω)
//! ```
//!
//! so that angular momentum is that of the impact in axes that have turned. At the end the point of contact is as high as it
//! was, and has gone on along the surface.

use std::f64::consts::PI;

use nalgebra::{SMatrix, SVector, UnitQuaternion, Vector3};

use super::contact_set::ContactSet;
use super::law::{Law, Velocities};
use crate::math::so3;
use crate::physics::body::Body;
use crate::physics::contact::Feature;
use crate::physics::state::{ByStates, State, StateTangent, part};

/// Restitution below which the damper is no stronger: the impulse is over at once.
const LEAST_RESTITUTION: f64 = 1e-6;

/// Least approach that is told from none [m/s].
const LEAST_M_S: f64 = 1e-3;

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
    /// Restitution: the speed along the normal with which it comes off over that with which it touches.
    pub restitution: f64,
    /// What else acts on the body, per mass [m/s²].
    pub pull_m_s2: Vector3<f64>,
    /// The body's moments of inertia [kg m²]; only their ratios matter.
    pub moments_kg_m2: Vector3<f64>,
    /// `k`, by which its weight presses [1/s],
    pub weight_per_s: f64,
    /// the derivative of that by the speed of the contact along its normal [1/m],
    pub weight_by_speed: f64,
    /// and by the pull [s/m].
    pub weight_by_pull: Vector3<f64>,
    /// Whether its pull acts meanwhile.
    pub is_pulled: bool,
}

impl Pressed {
    /// How a body is pressed at contacts with something, under its pull, with the first one's speed along its normal
    /// [m/s], negative approaching.
    pub fn new(
        contacts: &ContactSet,
        on: PressedOn,
        body: &Body,
        gravity_m_s2: &Vector3<f64>,
        speed_m_s: f64,
        restitution: f64,
        duration_s: f64,
    ) -> Self {
        let normal = match (on, contacts.as_slice()) {
            (PressedOn::World, [contact]) => match contact.b() {
                Feature::Face { normal, .. } => Some(*normal),
                _ => None,
            },
            _ => None,
        };
        let is_pulled = normal.is_some() || on == PressedOn::Flying;
        let pull_m_s2 = match is_pulled {
            true => body.pull_m_s2(gravity_m_s2),
            false => Vector3::zeros(),
        };
        let approach_m_s = (-speed_m_s).max(LEAST_M_S);
        let weight_by_pull = normal.map_or_else(Vector3::zeros, |normal| -normal / approach_m_s);
        let weight_per_s = weight_by_pull.dot(&pull_m_s2);
        let varies = -speed_m_s > LEAST_M_S;
        Self {
            duration_s,
            restitution,
            pull_m_s2,
            moments_kg_m2: body.moments_kg_m2(),
            weight_per_s,
            weight_by_speed: if varies {
                weight_per_s / approach_m_s
            } else {
                0.0
            },
            weight_by_pull,
            is_pulled,
        }
    }

    /// The law of the impact whose impulse acts meanwhile.
    pub fn law(&self, law: &Law) -> Law {
        Law {
            restitution: law.restitution + self.weight_per_s * self.duration_s,
            ..*law
        }
    }

    /// `1 + e + k T`.
    fn whole(&self) -> f64 {
        1.0 + self.restitution + self.weight_per_s * self.duration_s
    }

    /// The state some time after the touch, from that at the touch and the velocities after an impact that is one moment.
    pub fn state(&self, touching: &State, after: &Velocities, since_s: f64) -> State {
        let restitution = self.restitution.max(LEAST_RESTITUTION);
        let frequency_rad_s = PI / self.duration_s;
        let decay_per_s = -restitution.ln() / self.duration_s;
        let (sine, cosine) = (frequency_rad_s * since_s).sin_cos();
        let faded = (-decay_per_s * since_s).exp();
        let speed = faded * (cosine - decay_per_s / frequency_rad_s * sine);
        let depth_s = faded * sine / frequency_rad_s;
        let whole = 1.0 + restitution + self.weight_per_s * self.duration_s;
        let borne = self.weight_per_s * since_s;
        let share = (1.0 - speed + borne) / whole;
        let share_s = (since_s - depth_s + 0.5 * borne * since_s) / whole;
        let (v, omega) = (touching.velocity_m_s, touching.angular_velocity_rad_s);
        let changed_m_s = after.velocity_m_s - v;
        let turned_rad_s = after.angular_velocity_rad_s - omega;
        let turn = so3::exp(&(omega * since_s + turned_rad_s * share_s));
        State {
            position_m: touching.position_m
                + v * since_s
                + changed_m_s * share_s
                + self.pull_m_s2 * (0.5 * since_s * since_s),
            orientation: touching.orientation * turn,
            velocity_m_s: v + changed_m_s * share + self.pull_m_s2 * since_s,
            angular_velocity_rad_s: self.spun(&turn.inverse(), &(omega + turned_rad_s * share)),
        }
    }

    /// A spin in axes that have turned meanwhile: angular momentum stays.
    fn spun(&self, turned: &UnitQuaternion<f64>, spin_rad_s: &Vector3<f64>) -> Vector3<f64> {
        let momentum = turned * self.moments_kg_m2.component_mul(spin_rad_s);
        momentum.component_div(&self.moments_kg_m2)
    }

    /// The velocities after an impact that is one moment, from the states at the touch and where the body comes off.
    pub fn after(&self, touching: &State, left: &State) -> Velocities {
        let turn = touching.orientation.inverse() * left.orientation;
        Velocities {
            velocity_m_s: left.velocity_m_s - self.pull_m_s2 * self.duration_s,
            angular_velocity_rad_s: self.spun(&turn, &left.angular_velocity_rad_s),
        }
    }

    /// The state in which the body comes off, with its derivatives.
    pub fn left(&self, touching: &State, after: &Velocities) -> LeftState {
        let (duration_s, pull_m_s2) = (self.duration_s, self.pull_m_s2);
        let (weight_per_s, whole) = (self.weight_per_s, self.whole());
        let share_s = duration_s * (1.0 + 0.5 * weight_per_s * duration_s) / whole;
        let (v, omega) = (touching.velocity_m_s, touching.angular_velocity_rad_s);
        let changed_m_s = after.velocity_m_s - v;
        let turned_rad_s = after.angular_velocity_rad_s - omega;
        let angle_rad = omega * duration_s + turned_rad_s * share_s;
        let (turn, right) = so3::exp_and_right_jacobian(&angle_rad);
        let back = turn.inverse();
        let spin_rad_s = self.spun(&back, &after.angular_velocity_rad_s);
        let state = State {
            position_m: touching.position_m
                + v * duration_s
                + changed_m_s * share_s
                + pull_m_s2 * (0.5 * duration_s * duration_s),
            orientation: touching.orientation * turn,
            velocity_m_s: after.velocity_m_s + pull_m_s2 * duration_s,
            angular_velocity_rad_s: spin_rad_s,
        };
        // What the way and the turn change: with the turn δ the momentum z = Exp(−φ) I ω⁺ becomes z + z × δ in these axes.
        let momentum = self.moments_kg_m2.component_mul(&spin_rad_s);
        let moved = |way: Vector3<f64>, turned: Vector3<f64>| {
            let turn = right * turned;
            let spun = momentum.cross(&turn).component_div(&self.moments_kg_m2);
            tangent([way, turn, Vector3::zeros(), spun])
        };
        let mut by_touching = ByStates::zeros();
        let mut by_after = ByVelocities::zeros();
        let zero = Vector3::zeros();
        for axis in 0..3 {
            let one = Vector3::ith(axis, 1.0);
            by_touching.set_column(part::POSITION + axis, &tangent([one, zero, zero, zero]));
            let turned = tangent([zero, back * one, zero, zero]);
            by_touching.set_column(part::ORIENTATION + axis, &turned);
            let (velocity, spin) = (moved(one, zero), moved(zero, one));
            let left_s = duration_s - share_s;
            by_touching.set_column(part::VELOCITY + axis, &(velocity * left_s));
            by_touching.set_column(part::ANGULAR_VELOCITY + axis, &(spin * left_s));
            let jumped = tangent([zero, zero, one, zero]);
            by_after.set_column(axis, &(velocity * share_s + jumped));
            let spun = tangent([zero, zero, zero, self.spun(&back, &one)]);
            by_after.set_column(3 + axis, &(spin * share_s + spun));
        }
        let pulled = tangent([pull_m_s2 * duration_s, zero, pull_m_s2, zero]);
        // Derivatives of H(T) by T, e and k.
        let by_duration = (1.0 + weight_per_s * (duration_s - share_s)) / whole;
        let by_restitution_s = -share_s / whole;
        let by_weight_s2 = duration_s * (0.5 * duration_s - share_s) / whole;
        let shared = |by: f64| moved(changed_m_s * by, turned_rad_s * by);
        LeftState {
            state,
            by_touching,
            by_after,
            by_duration: moved(v, omega) + shared(by_duration) + pulled,
            by_restitution: shared(by_restitution_s),
            by_weight: shared(by_weight_s2),
        }
    }

    /// Derivative of the state in which the body comes off by the logarithm of the moment about an axis, the velocities after the impact apart.
    pub fn left_by_log_moment(
        &self,
        touching: &State,
        after: &Velocities,
        left: &State,
        axis: usize,
    ) -> StateTangent {
        let back = left.orientation.inverse() * touching.orientation;
        let spin = after.angular_velocity_rad_s[axis] * self.moments_kg_m2[axis];
        let mut spun = (back * Vector3::ith(axis, spin)).component_div(&self.moments_kg_m2);
        spun[axis] -= left.angular_velocity_rad_s[axis];
        let zero = Vector3::zeros();
        tangent([zero, zero, zero, spun])
    }
}

/// A tangent of its parts: position, orientation, velocity, angular velocity.
fn tangent(parts: [Vector3<f64>; 4]) -> StateTangent {
    StateTangent::from_fn(|at, _| parts[at / 3][at % 3])
}

/// The state in which a pressed body comes off.
#[derive(Clone, Debug)]
pub struct LeftState {
    /// The state.
    pub state: State,
    /// Its derivatives by the state at the touch, where the velocities after the impact stay,
    pub by_touching: ByStates,
    /// by these,
    pub by_after: ByVelocities,
    /// by how long the contact lasts,
    pub by_duration: StateTangent,
    /// by the restitution,
    pub by_restitution: StateTangent,
    /// and by how its weight presses.
    pub by_weight: StateTangent,
}

impl LeftState {
    /// The same with how the velocities after the impact follow from its law, given their derivative by the restitution.
    pub fn with_law(mut self, pressed: &Pressed, after_by_restitution: &SVector<f64, 6>) -> Self {
        let by_law = self.by_after * after_by_restitution;
        self.by_duration += by_law * pressed.weight_per_s;
        self.by_restitution += by_law;
        self.by_weight += by_law * pressed.duration_s;
        self
    }

    /// Its derivative by the pull along an axis of the world.
    pub fn by_pull(&self, pressed: &Pressed, axis: usize) -> StateTangent {
        let by_weight = self.by_weight * pressed.weight_by_pull[axis];
        if !pressed.is_pulled {
            return by_weight;
        }
        let (zero, one) = (Vector3::zeros(), Vector3::ith(axis, pressed.duration_s));
        by_weight + tangent([one * (0.5 * pressed.duration_s), zero, one, zero])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pressed() -> Pressed {
        Pressed {
            duration_s: 0.04,
            restitution: 0.7,
            pull_m_s2: Vector3::new(0.6, -0.2, -9.0),
            moments_kg_m2: Vector3::new(1.0, 1.7, 2.2),
            weight_per_s: 3.0,
            weight_by_speed: 1.0,
            weight_by_pull: Vector3::new(0.0, 0.0, -1.0 / 3.0),
            is_pulled: true,
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
            // The restitution with the weight of 40 ms.
            velocity_m_s: Vector3::new(0.9, 0.5, 3.0 * (0.7 + 3.0 * 0.04)),
            angular_velocity_rad_s: Vector3::new(-3.0, 5.0, 2.5),
        }
    }

    #[test]
    fn it_comes_off_as_high_as_it_touched_with_the_speed_of_its_restitution() {
        let (pressed, touching, after) = (pressed(), touching(), after());
        let left = pressed.left(&touching, &after).state;
        assert!((left.position_m.z - touching.position_m.z).abs() < 1e-15);
        assert!((left.velocity_m_s.z - 2.1).abs() < 1e-12);
        let on_the_way = pressed.state(&touching, &after, pressed.duration_s);
        assert!(on_the_way.minus(&left).norm() < 1e-12);
        let back = pressed.after(&touching, &left);
        assert!((back.velocity_m_s - after.velocity_m_s).norm() < 1e-12);
        assert!((back.angular_velocity_rad_s - after.angular_velocity_rad_s).norm() < 1e-12);
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
            // Angular momentum changes along that of the impact alone.
            let momentum = |state: &State| {
                let own = pressed
                    .moments_kg_m2
                    .component_mul(&state.angular_velocity_rad_s);
                touching.orientation.inverse() * (state.orientation * own)
            };
            let changed = after.angular_velocity_rad_s - touching.angular_velocity_rad_s;
            let along = pressed.moments_kg_m2.component_mul(&changed);
            let off = momentum(&now) - momentum(&touching);
            assert!(
                off.cross(&along).norm() < 1e-12 * along.norm_squared(),
                "{since_s}"
            );
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
        let by = slope(&|step| with(&|of| of.weight_per_s += step));
        assert!((by - left.by_weight).norm() < 1e-8);
        for axis in 0..3 {
            let by = slope(&|step| with(&|of| of.moments_kg_m2[axis] *= step.exp()));
            let told = pressed.left_by_log_moment(&touching, &after, &left.state, axis);
            assert!((by - told).norm() < 1e-8, "{axis}");
        }
        for axis in 0..3 {
            let by = slope(&|step| {
                with(&|of| {
                    of.pull_m_s2[axis] += step;
                    of.weight_per_s = of.weight_by_pull.dot(&of.pull_m_s2);
                })
            });
            assert!((by - left.by_pull(&pressed, axis)).norm() < 1e-8, "{axis}");
        }
    }
}
