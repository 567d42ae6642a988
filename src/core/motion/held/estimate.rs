//! The motion of a held body as estimated: its smoothed motion, led through its states at collisions.
//!
//! At a collision the estimate is off the smoothed state by `d` (position, turn) and `ḋ`. About it,
//! within as long as the smoother averages, the motion is shifted by the polynomial of fifth degree that
//! begins with nothing, has `d` and `ḋ` at the collision, and ends with nothing.

use nalgebra::Vector3;

use super::curve::Curve;
use super::knot::{Driven, Knot};
use crate::math::so3;
use crate::motion::index::LinkIndex;
use crate::motion::sample_time::SampleTime;
use crate::physics::State;

/// The estimated motion of a body in the hand.
#[derive(Clone, Debug, PartialEq)]
pub struct HeldEstimate {
    /// The body.
    pub link: LinkIndex,
    /// Its motion, in physical time.
    pub curve: Curve,
    /// Its collisions, in order of time.
    pub passed: Vec<Passed>,
    /// Physical times of its samples.
    pub sample_times: Vec<SampleTime>,
}

/// An estimated state of a held body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Passed {
    /// The collision (index into `Scene::events`).
    pub event: usize,
    /// Physical time \[s\].
    pub time_s: f64,
    /// The body's state.
    pub state: State,
    /// Time within which its correction fades \[s\].
    pub fading_s: f64,
    /// How far it is from the smoothed motion, in place \[m\] and angle \[rad\].
    pub off: [f64; 2],
}

impl HeldEstimate {
    /// The motion through smoothed states, in order of physical time, led through those at
    /// collisions.
    pub fn new(
        link: LinkIndex,
        smoothed: Vec<Knot>,
        mut passed: Vec<Passed>,
        sample_times: Vec<SampleTime>,
    ) -> Self {
        passed.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
        let plain = Curve::new(smoothed);
        for of in &mut passed {
            let smoothed = plain.at(of.time_s).state;
            of.off = [
                (of.state.position_m - smoothed.position_m).norm(),
                of.state.orientation.angle_to(&smoothed.orientation),
            ];
        }
        let neighbours_s = |index: usize| {
            let apart_s = |other: Option<&Passed>| {
                other.map_or(f64::INFINITY, |other| {
                    (other.time_s - passed[index].time_s).abs()
                })
            };
            let before = index.checked_sub(1).and_then(|before| passed.get(before));
            apart_s(before).min(apart_s(passed.get(index + 1)))
        };
        let mut times_s: Vec<f64> = plain.knots().iter().map(|knot| knot.time_s).collect();
        let mut bumps = Vec::new();
        for (index, of) in passed.iter().enumerate() {
            let reach_s = of.fading_s.min(neighbours_s(index));
            if reach_s > 0.0 {
                times_s.extend([of.time_s - reach_s, of.time_s, of.time_s + reach_s]);
                bumps.push(Bump::new(of, &plain.at(of.time_s).state, reach_s));
            }
        }
        times_s.sort_by(f64::total_cmp);
        times_s.dedup_by(|later, earlier| *later - *earlier < APART_S);
        let knots = times_s.into_iter().map(|time_s| Knot {
            time_s,
            driven: bumps.iter().fold(plain.at(time_s), |driven, bump| {
                bump.shifted(&driven, time_s)
            }),
        });
        let mut knots: Vec<Knot> = knots.collect();
        // At the collision itself exactly.
        for of in &passed {
            let near = knots
                .iter_mut()
                .find(|knot| (knot.time_s - of.time_s).abs() < APART_S);
            if let Some(knot) = near {
                knot.time_s = of.time_s;
                knot.driven.state = of.state;
            }
        }
        Self {
            link,
            curve: Curve::new(knots),
            passed,
            sample_times,
        }
    }

    /// The state at a physical time: before the first of its smoothed states and after the last it
    /// stands where it was then.
    pub fn state(&self, time_s: f64) -> State {
        let knots = self.curve.knots();
        let ends_s = [knots[0].time_s, knots[knots.len() - 1].time_s];
        let inside_s = time_s.clamp(ends_s[0], ends_s[1]);
        let state = self.curve.at(inside_s).state;
        if inside_s == time_s {
            return state;
        }
        State {
            velocity_m_s: Vector3::zeros(),
            angular_velocity_rad_s: Vector3::zeros(),
            ..state
        }
    }
}

/// Knots that are nearer than this are one \[s\].
const APART_S: f64 = 1e-9;

/// A correction that fades on both sides of a collision.
struct Bump {
    time_s: f64,
    reach_s: f64,
    /// Of the position, and its rate.
    shift: [Vector3<f64>; 2],
    /// Of the orientation, and its rate.
    turn: [Vector3<f64>; 2],
}

impl Bump {
    fn new(of: &Passed, plain: &State, reach_s: f64) -> Self {
        let turn = so3::log(&(plain.orientation.inverse() * of.state.orientation));
        // ω = Exp(−θ) ω₀ + J_r(θ) θ̇.
        let carried = so3::exp(&turn).inverse() * plain.angular_velocity_rad_s;
        let rate = of.state.angular_velocity_rad_s - carried;
        Self {
            time_s: of.time_s,
            reach_s,
            shift: [
                of.state.position_m - plain.position_m,
                of.state.velocity_m_s - plain.velocity_m_s,
            ],
            turn: [turn, so3::right_jacobian_inverse(&turn) * rate],
        }
    }

    fn shifted(&self, driven: &Driven, time_s: f64) -> Driven {
        let since = (time_s - self.time_s) / self.reach_s;
        if since.abs() >= 1.0 {
            return *driven;
        }
        let jet = |[value, rate]: &[Vector3<f64>; 2]| {
            let [v, r] = fading(since, self.reach_s);
            [0, 1, 2].map(|order| value * v[order] + rate * r[order])
        };
        let [shift, velocity, acceleration] = jet(&self.shift);
        let [turn, rate, bend] = jet(&self.turn);
        let Driven {
            state,
            acceleration_m_s2,
            angular_acceleration_rad_s2,
        } = *driven;
        let (by, right) = so3::exp_and_right_jacobian(&turn);
        Driven {
            state: State {
                position_m: state.position_m + shift,
                orientation: state.orientation * by,
                velocity_m_s: state.velocity_m_s + velocity,
                angular_velocity_rad_s: by.inverse() * state.angular_velocity_rad_s + right * rate,
            },
            acceleration_m_s2: acceleration_m_s2 + acceleration,
            // To first order in the correction.
            angular_acceleration_rad_s2: by.inverse() * angular_acceleration_rad_s2 + right * bend,
        }
    }
}

/// Value, first and second derivative by time of the polynomials that carry a value of one and a rate
/// of one at `s = 0`, and fade to nothing at `|s| = 1`.
fn fading(s: f64, reach_s: f64) -> [[f64; 3]; 2] {
    let (x, sign) = (s.abs(), s.signum());
    let [x2, x3] = [x * x, x * x * x];
    let (x4, x5) = (x2 * x2, x2 * x3);
    let h = reach_s;
    [
        [
            1.0 - 10.0 * x3 + 15.0 * x4 - 6.0 * x5,
            sign * (-30.0 * x2 + 60.0 * x3 - 30.0 * x4) / h,
            (-60.0 * x + 180.0 * x2 - 120.0 * x3) / (h * h),
        ],
        [
            sign * (x - 6.0 * x3 + 8.0 * x4 - 3.0 * x5) * h,
            1.0 - 18.0 * x2 + 32.0 * x3 - 15.0 * x4,
            sign * (-36.0 * x + 96.0 * x2 - 60.0 * x3) / h,
        ],
    ]
}

#[cfg(test)]
mod tests {
    use nalgebra::UnitQuaternion;

    use super::*;

    #[test]
    fn it_passes_through_what_was_estimated_and_is_plain_elsewhere() {
        let knots: Vec<Knot> = (0..60)
            .map(|k| {
                let time_s = f64::from(k) * 0.02;
                Knot {
                    time_s,
                    driven: Driven {
                        state: State {
                            position_m: Vector3::new(time_s, time_s * time_s, 0.0),
                            orientation: UnitQuaternion::from_scaled_axis(
                                Vector3::z() * (2.0 * time_s),
                            ),
                            velocity_m_s: Vector3::new(1.0, 2.0 * time_s, 0.0),
                            angular_velocity_rad_s: Vector3::z() * 2.0,
                        },
                        acceleration_m_s2: Vector3::y() * 2.0,
                        angular_acceleration_rad_s2: Vector3::zeros(),
                    },
                }
            })
            .collect();
        let plain = Curve::new(knots.clone());
        let passed = [0.411, 0.52].map(|time_s| {
            let mut state = plain.at(time_s).state;
            state.position_m += Vector3::new(1e-3, -2e-3, 0.5e-3);
            state.velocity_m_s += Vector3::new(0.05, 0.0, -0.02);
            state.orientation *= so3::exp(&Vector3::new(1e-3, 2e-3, -1e-3));
            state.angular_velocity_rad_s += Vector3::new(0.1, -0.1, 0.2);
            Passed {
                event: 0,
                time_s,
                state,
                fading_s: 0.15,
                off: [0.0; 2],
            }
        });
        let held = HeldEstimate::new(LinkIndex(0), knots, passed.to_vec(), Vec::new());
        for of in &passed {
            assert_eq!(held.state(of.time_s), of.state);
        }
        for time_s in [0.1, 0.25, 0.7, 1.17] {
            let off = held.state(time_s).minus(&plain.at(time_s).state).amax();
            assert!(off < 1e-9, "{time_s}: {off}");
        }
        assert_eq!(held.state(2.0).velocity_m_s, Vector3::zeros());
        // Velocities are the derivatives of poses.
        for time_s in [0.37, 0.45, 0.55] {
            let h = 1e-6;
            let [before, here, after] = [-h, 0.0, h].map(|by| held.state(time_s + by));
            let velocity = (after.position_m - before.position_m) / (2.0 * h);
            assert!((velocity - here.velocity_m_s).norm() < 1e-6, "{time_s}");
            let turn = so3::log(&(before.orientation.inverse() * after.orientation));
            let off = turn / (2.0 * h) - here.angular_velocity_rad_s;
            assert!(off.norm() < 1e-4, "{time_s}: {off}");
        }
    }
}
