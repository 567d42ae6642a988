//! The motion of a body on a plane that supports it: it slides, rolls or lies still.
//!
//! What friction acts against is the slip `u = ρ d`, a speed `ρ` in a direction `d` along the plane, of which
//!
//! ```text
//! u̇ = G − k d        so that   ρ̇ = G·d − k,   ḋ = (G − (G·d) d)/ρ
//!
//! ball that slides   u = v_t − r ω × n        G = g_t              k = μ g_n (1 + 1/c),   c = I/(m r²)
//! flat, slides       u = v_t + a ω_n n        G = g_t              k = μ g_n,             a² = I_n/m
//! ball that rolls    u = v_t                  G = g_t/(1 + c)      k = μ g_n
//! cylinder, rolls    u = w (w·v)              G = w (w·g_t)/(1 + c)  k = μ g_n,           w = n × axis
//! ```
//!
//! with the pull's part along the plane, `g_t`, and against it, `g_n`, and the gyration radius `a` about the
//! normal. Friction of a flat body so acts against its slip and its yaw as against one velocity: both end at
//! once, as those of a disc do, whose limit surface is within a tenth of this one (Goyal, Ruina and
//! Papadopoulos, "Planar sliding with dry friction", Wear 143, 1991). On a level plane `d` stays and all is in
//! closed form. After `ρ` has passed zero the motion goes on in reverse, smoothly: where it ends is a
//! condition of the estimation. Slower than [`LEAST_TURNING_M_S`] the direction no longer turns.
//!
//! Velocity along the normal and what else of the angular velocity friction does not change is carried along. In a step
//! the slip is integrated by the classic Runge–Kutta method, exactly on a level plane; the rotation by the sixth-order
//! expansion of Magnus for an angular velocity that is linear in time (Blanes, Casas, Oteo and Ros, "The Magnus
//! expansion and some of its applications", Physics Reports 470, 2009), exactly about an axis that stays.

use nalgebra::{SMatrix, UnitQuaternion, Vector3};

use super::seen::{FRICTION, PULL, Seen};
use crate::math::jet::{Jet, Jet3};
use crate::math::so3;
use crate::physics::body::Body;
use crate::physics::state::{State, part};
use crate::physics::support::{OnPlane, PlaneSupport, Sustained};

/// Length of a step \[s\]: at 50 rad/s about an axis that turns, the rotation is 1e-8 rad off after a second.
pub(super) const STEP_S: f64 = 1.0 / 64.0;

/// Slip below which its direction no longer turns on a slope [m/s].
pub const LEAST_TURNING_M_S: f64 = 0.02;

/// Sine of the angle between axis and normal below which a cylinder has no way to roll.
const LEAST_WAY: f64 = 1e-9;

/// Least slip of which a direction is told [m/s].
const LEAST_M_S: f64 = 1e-9;

/// What is constant on the way.
#[derive(Clone, Debug)]
pub(super) struct Slipping<const N: usize> {
    support: PlaneSupport,
    /// `1 + c` of what rolls, with its radius.
    round: Option<[f64; 2]>,
    normal: Jet3<N>,
    position_m: Jet3<N>,
    velocity_m_s: Jet3<N>,
    /// In world axes.
    spin_rad_s: Jet3<N>,
    /// `g_t`.
    along_m_s2: Jet3<N>,
    /// `G`.
    drive_m_s2: Jet3<N>,
    /// `k`.
    friction_m_s2: Jet<N>,
    /// `1/a` of what lies flat.
    per_gyration_m: Jet<N>,
    /// Where it begins.
    pub(super) start: SlipNode<N>,
}

/// The motion between two steps.
#[derive(Clone, Copy, Debug)]
pub(super) struct SlipNode<const N: usize> {
    since_s: f64,
    slip_m_s: Jet<N>,
    direction: Jet3<N>,
    /// `∫u`.
    way_m: Jet3<N>,
    orientation: UnitQuaternion<f64>,
    /// Its changes as left perturbations.
    turned: SMatrix<f64, 3, N>,
}

impl<const N: usize> Slipping<N> {
    pub(super) fn new(
        body: &Body,
        support: &PlaneSupport,
        gravity_m_s2: &Vector3<f64>,
        state: &State,
    ) -> Self {
        let position_m = Jet3::variable(state.position_m, part::POSITION);
        let velocity_m_s = Jet3::variable(state.velocity_m_s, part::VELOCITY);
        let turn = Jet3::variable(Vector3::zeros(), part::ORIENTATION);
        let spin = Jet3::variable(state.angular_velocity_rad_s, part::ANGULAR_VELOCITY);
        let pull = Jet3::variable(body.pull_m_s2(gravity_m_s2), PULL);
        let friction = Jet::variable(support.friction, FRICTION);
        let to_world = so3::matrix(&state.orientation);
        // R Exp(δ) ω = R (ω + δ × ω), and R Exp(δ) = Exp(R δ) R.
        let spin_rad_s = (spin + turn.cross(spin)).through(&to_world);
        let turned = turn.through(&to_world).by;
        let normal = Jet3::constant(support.normal);
        let against_m_s2 = -pull.dot(normal);
        let along_m_s2 = pull + normal * against_m_s2;
        let across = |of: Jet3<N>| of - normal * of.dot(normal);
        let moments = body.gyration_m2();
        let round =
            |about_m2: f64, radius_m: f64| [1.0 + about_m2 / (radius_m * radius_m), radius_m];
        let (round, way) = match support.touching {
            OnPlane::Ball { radius_m } => (Some(round(moments.mean(), radius_m)), None),
            OnPlane::Side { radius_m, axis } => {
                let about_m2 = axis.dot(&moments.component_mul(&axis));
                let along = Jet3::constant(axis);
                let across = normal.cross((along + turn.cross(along)).through(&to_world));
                let way = across * across.norm(LEAST_WAY).recip();
                (Some(round(about_m2, radius_m)), Some(way))
            }
            OnPlane::Face { .. } => (None, None),
        };
        // The normal in body axes, Exp(−δ) Rᵀ n, and the gyration radius about it.
        let below = Jet3::constant(to_world.tr_mul(&support.normal));
        let below = below - turn.cross(below);
        let gyration_m = below
            .dot(below.through(&nalgebra::Matrix3::from_diagonal(&moments)))
            .sqrt();
        let (slip, drive_m_s2, factor) = match (support.sustained, round) {
            (Sustained::Slide, Some([one_and_c, radius_m])) => (
                across(velocity_m_s) - spin_rad_s.cross(normal) * radius_m,
                along_m_s2,
                one_and_c / (one_and_c - 1.0),
            ),
            (Sustained::Slide, None) => (
                across(velocity_m_s) + normal * (spin_rad_s.dot(normal) * gyration_m),
                along_m_s2,
                1.0,
            ),
            (_, round) => {
                let share = round.map_or(1.0, |[one_and_c, _]| one_and_c.recip());
                // A cylinder rolls across its axis alone.
                let taken = |of: Jet3<N>| way.map_or(of, |way| way * of.dot(way));
                (taken(across(velocity_m_s)), taken(along_m_s2 * share), 1.0)
            }
        };
        let slip_m_s = slip.norm(LEAST_M_S);
        let start = SlipNode {
            since_s: 0.0,
            slip_m_s,
            direction: slip * slip_m_s.recip(),
            way_m: Jet3::constant(Vector3::zeros()),
            orientation: state.orientation,
            turned,
        };
        Self {
            support: *support,
            round,
            normal,
            position_m,
            velocity_m_s,
            spin_rad_s,
            along_m_s2,
            drive_m_s2,
            friction_m_s2: friction * against_m_s2 * factor,
            per_gyration_m: gyration_m.recip(),
            start,
        }
    }

    /// `ρ̇` and `ḋ`.
    fn rates(&self, slip_m_s: Jet<N>, direction: Jet3<N>) -> (Jet<N>, Jet3<N>) {
        let along = self.drive_m_s2.dot(direction);
        let least = LEAST_TURNING_M_S * LEAST_TURNING_M_S;
        let per_slip = slip_m_s * (slip_m_s * slip_m_s + Jet::constant(least)).recip();
        let turning = (self.drive_m_s2 - direction * along) * per_slip;
        (along - self.friction_m_s2, turning)
    }

    /// The angular velocity where the slip is `u` \[world\].
    fn spin_rad_s(&self, since_s: f64, u: Jet3<N>) -> Jet3<N> {
        let normal = self.normal;
        match (self.support.sustained, self.round) {
            (Sustained::Slide, Some([one_and_c, radius_m])) => {
                let lost = self.start.u() + self.along_m_s2 * since_s - u;
                self.spin_rad_s + normal.cross(lost) * (one_and_c * radius_m).recip()
            }
            (Sustained::Slide, None) => {
                let yaw = u.dot(normal) * self.per_gyration_m - self.spin_rad_s.dot(normal);
                self.spin_rad_s + normal * yaw
            }
            (Sustained::Roll, Some([_, radius_m])) => {
                self.spin_rad_s + normal.cross(u - self.start.u()) * radius_m.recip()
            }
            _ => self.spin_rad_s,
        }
    }

    /// The node after a step.
    pub(super) fn after(&self, node: &SlipNode<N>, h: f64) -> SlipNode<N> {
        if self.support.sustained == Sustained::Rest {
            return SlipNode {
                since_s: node.since_s + h,
                ..*node
            };
        }
        let (slip, direction) = (node.slip_m_s, node.direction);
        let moved = |by: (Jet<N>, Jet3<N>), h: f64| (slip + by.0 * h, direction + by.1 * h);
        let first = self.rates(slip, direction);
        let (s2, d2) = moved(first, 0.5 * h);
        let second = self.rates(s2, d2);
        let (s3, d3) = moved(second, 0.5 * h);
        let third = self.rates(s3, d3);
        let (s4, d4) = moved(third, h);
        let fourth = self.rates(s4, d4);
        let mean = (
            (first.0 + (second.0 + third.0) * 2.0 + fourth.0) * (1.0 / 6.0),
            (first.1 + (second.1 + third.1) * 2.0 + fourth.1) * (1.0 / 6.0),
        );
        let (slip_m_s, turned) = moved(mean, h);
        let u = direction * slip + (d2 * s2 + d3 * s3) * 2.0 + d4 * s4;
        let mut after = SlipNode {
            since_s: node.since_s + h,
            slip_m_s,
            direction: turned,
            way_m: node.way_m + u * (h / 6.0),
            ..*node
        };
        let angle = match (self.support.sustained, self.round) {
            (Sustained::Slide, None) => {
                let yaw = (after.way_m - node.way_m).dot(self.normal) * self.per_gyration_m;
                self.normal * yaw
            }
            _ => self.magnus(node, &after, h),
        };
        let (rotation, jacobian) = so3::exp_and_left_jacobian(&angle.value);
        after.orientation = rotation * node.orientation;
        after.turned = jacobian * angle.by + so3::matrix(&rotation) * node.turned;
        after
    }

    /// The rotation vector of a step.
    fn magnus(&self, node: &SlipNode<N>, after: &SlipNode<N>, h: f64) -> Jet3<N> {
        let ends = [node, after].map(|at| self.spin_rad_s(at.since_s, at.u()));
        let first = (ends[0] + ends[1]) * (0.5 * h);
        let second = (ends[1] - ends[0]) * h;
        let c1 = first.cross(second);
        let c2 = first.cross(c1) * (-1.0 / 60.0);
        first + (c1 - first * 20.0).cross(second + c2) * (1.0 / 240.0)
    }

    /// What of the velocity a cylinder carries along its axis; nothing of anything else.
    fn sideways(&self) -> Jet3<N> {
        match self.support.touching {
            OnPlane::Side { .. } => {
                let left = self.velocity_m_s - self.start.u();
                left - self.normal * left.dot(self.normal)
            }
            _ => Jet3::constant(Vector3::zeros()),
        }
    }

    /// What follows from a node.
    pub(super) fn told(&self, node: SlipNode<N>, s: f64) -> Seen<N> {
        let normal = self.normal;
        let (slip_rate, turning) = self.rates(node.slip_m_s, node.direction);
        let rate = (node.direction * slip_rate + turning * node.slip_m_s).value;
        let u = node.u();
        let off = self.velocity_m_s.dot(normal);
        let sideways = self.sideways();
        let spin_rad_s = self.spin_rad_s(s, u);
        let zero = Vector3::zeros();
        let n = normal.value;
        let g = self.along_m_s2.value;
        let (position_m, velocity_m_s, acceleration_m_s2, angular_acceleration_rad_s2) =
            match (self.support.sustained, self.round) {
                (Sustained::Slide, Some([one_and_c, radius_m])) => {
                    let share = (one_and_c - 1.0) / one_and_c;
                    let start = self.start.u();
                    let lost = start + self.along_m_s2 * s - u;
                    let lost_way = start * s + self.along_m_s2 * (0.5 * s * s) - node.way_m;
                    (
                        self.position_m + self.velocity_m_s * s + self.along_m_s2 * (0.5 * s * s)
                            - lost_way * share,
                        self.velocity_m_s + self.along_m_s2 * s - lost * share,
                        g - (g - rate) * share,
                        n.cross(&(g - rate)) / (one_and_c * radius_m),
                    )
                }
                (Sustained::Rest, _) => (self.position_m, self.velocity_m_s, zero, zero),
                (sustained, round) => {
                    let across = |of: Jet3<N>| of - normal * of.dot(normal);
                    let straight = rate - n * n.dot(&rate);
                    let spun = match (sustained, round) {
                        (Sustained::Slide, _) => n * (n.dot(&rate) * self.per_gyration_m.value),
                        (_, Some([_, radius_m])) => n.cross(&rate) / radius_m,
                        (_, None) => zero,
                    };
                    (
                        self.position_m + across(node.way_m) + normal * off * s,
                        across(u) + normal * off + sideways,
                        straight,
                        spun,
                    )
                }
            };
        let spin = spin_rad_s.value;
        let (moving_m_s, turning_rad_s) = match (self.support.sustained, self.round) {
            (Sustained::Rest, _) => (zero, zero),
            (Sustained::Slide, None) => (velocity_m_s.value, n * n.dot(&spin)),
            _ => (velocity_m_s.value - sideways.value, spin),
        };
        Seen {
            orientation: node.orientation,
            turned: node.turned,
            slip_m_s: node.slip_m_s,
            position_m,
            velocity_m_s,
            spin_rad_s,
            moving_m_s,
            turning_rad_s,
            acceleration_m_s2,
            angular_acceleration_rad_s2,
            slip_rate_m_s2: slip_rate.value,
        }
    }
}

impl<const N: usize> SlipNode<N> {
    /// `u`.
    fn u(&self) -> Jet3<N> {
        self.direction * self.slip_m_s
    }
}
