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
//! ```
//!
//! with the pull's part along the plane, `g_t`, and against it, `g_n`, and the gyration radius `a` about the
//! normal. Friction of a flat body so acts against its slip and its yaw as against one velocity: both end at
//! once, as those of a disc do, whose limit surface is within a tenth of this one (Goyal, Ruina and
//! Papadopoulos, "Planar sliding with dry friction", Wear 143, 1991). On a level plane `d` stays and all is in
//! closed form. After `ρ` has passed zero the motion goes on in reverse, smoothly: where it ends is a
//! condition of the estimation. Slower than [`LEAST_TURNING_M_S`] the direction no longer turns.
//!
//! Velocity along the normal and what else of the angular velocity friction does not change is carried along:
//! constraints keep it at zero.
//!
//! Steps are of one fixed length, so that the result is as smooth as its formulas. In a step the slip is
//! integrated by the classic Runge–Kutta method, exactly on a level plane; the rotation by the sixth-order
//! expansion of Magnus for an angular velocity that is linear in time (Blanes, Casas, Oteo and Ros, "The Magnus
//! expansion and some of its applications", Physics Reports 470, 2009), exactly about an axis that stays.
//! Derivatives are those of the formulas.

use nalgebra::{RowSVector, SMatrix, UnitQuaternion, Vector3};

use crate::math::jet::{Jet, Jet3};
use crate::math::so3;
use crate::physics::body::Body;
use crate::physics::state::{ByStates, State, StateTangent, part};
use crate::physics::support::{Support, Sustained};

/// Length of a step \[s\]: at 50 rad/s about an axis that turns, the rotation is 1e-8 rad off after a second.
const STEP_S: f64 = 1.0 / 64.0;

/// Slip below which its direction no longer turns on a slope [m/s].
pub const LEAST_TURNING_M_S: f64 = 0.02;

/// Least slip of which a direction is told [m/s].
const LEAST_M_S: f64 = 1e-9;

/// Longest duration \[s\]; longer ones would take too many steps to store.
const DURATION_MAX_S: f64 = 1e3;

/// Variables of the derivatives: the state at the epoch, the pull, the coefficient of friction.
const VARIABLES: usize = 16;
const PULL: usize = 12;
const FRICTION: usize = 15;

/// A state on a support with its derivatives from the start.
#[derive(Clone, Copy, Debug)]
pub struct Carried {
    /// The state.
    pub state: State,
    /// Its derivative by time.
    pub rate: StateTangent,
    /// Its derivatives by the state at the start.
    pub by_state: ByStates,
    /// By the pull, an axis each.
    pub by_pull: [StateTangent; 3],
    /// By the coefficient of friction.
    pub by_friction: StateTangent,
    /// The slip, negative after it has passed zero [m/s].
    pub slip_m_s: f64,
    /// Its derivative by time [m/s²].
    pub slip_rate_m_s2: f64,
    /// By the state at the start.
    pub slip_by_state: RowSVector<f64, PULL>,
    /// By the pull \[s\].
    pub slip_by_pull: [f64; 3],
    /// By the coefficient of friction.
    pub slip_by_friction: f64,
}

/// The motion on a support from one state, for many durations of either sign.
#[derive(Clone, Debug)]
pub struct Supported {
    values: Slipping<0>,
    changes: Slipping<VARIABLES>,
}

impl Supported {
    /// From a state; `None` of a body in flight.
    pub fn new(body: &Body, gravity_m_s2: &Vector3<f64>, state: &State) -> Option<Self> {
        let support = body.support()?;
        Some(Self {
            values: Slipping::new(body, &support, gravity_m_s2, state),
            changes: Slipping::new(body, &support, gravity_m_s2, state),
        })
    }

    /// The state after a duration \[s\]; not a number beyond 1000 s.
    pub fn at(&mut self, duration_s: f64) -> State {
        self.values.seen(duration_s).state()
    }

    /// The same with its derivatives.
    pub fn carried(&mut self, duration_s: f64) -> Carried {
        self.changes.seen(duration_s).carried()
    }
}

/// What is constant on the way.
#[derive(Clone, Debug)]
struct Slipping<const N: usize> {
    support: Support,
    /// `1 + c` of a ball, with its radius.
    ball: Option<[f64; 2]>,
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
    start: SlipNode<N>,
    /// Nodes after the start, and before it.
    sides: [Vec<SlipNode<N>>; 2],
}

/// The motion between two steps.
#[derive(Clone, Copy, Debug)]
struct SlipNode<const N: usize> {
    since_s: f64,
    slip_m_s: Jet<N>,
    direction: Jet3<N>,
    /// `∫u`.
    way_m: Jet3<N>,
    orientation: UnitQuaternion<f64>,
    /// Its changes as left perturbations.
    turned: SMatrix<f64, 3, N>,
}

/// A node with what follows from it.
struct Seen<const N: usize> {
    node: SlipNode<N>,
    position_m: Jet3<N>,
    velocity_m_s: Jet3<N>,
    spin_rad_s: Jet3<N>,
    /// Rates of position and orientation \[world\]: what is carried along moves nothing that lies.
    moving_m_s: Vector3<f64>,
    turning_rad_s: Vector3<f64>,
    acceleration_m_s2: Vector3<f64>,
    angular_acceleration_rad_s2: Vector3<f64>,
    slip_rate_m_s2: f64,
}

impl<const N: usize> Slipping<N> {
    fn new(body: &Body, support: &Support, gravity_m_s2: &Vector3<f64>, state: &State) -> Self {
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
        let moments = body.moments_kg_m2() / body.mass_kg();
        let ball = support
            .radius_m
            .map(|radius_m| [1.0 + moments.mean() / (radius_m * radius_m), radius_m]);
        // The normal in body axes, Exp(−δ) Rᵀ n, and the gyration radius about it.
        let below = Jet3::constant(to_world.tr_mul(&support.normal));
        let below = below - turn.cross(below);
        let gyration_m = below
            .dot(below.through(&nalgebra::Matrix3::from_diagonal(&moments)))
            .sqrt();
        let (slip, drive_m_s2, factor) = match (support.sustained, ball) {
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
            (_, ball) => (
                across(velocity_m_s),
                along_m_s2 * ball.map_or(1.0, |[one_and_c, _]| one_and_c.recip()),
                1.0,
            ),
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
            ball,
            normal,
            position_m,
            velocity_m_s,
            spin_rad_s,
            along_m_s2,
            drive_m_s2,
            friction_m_s2: friction * against_m_s2 * factor,
            per_gyration_m: gyration_m.recip(),
            start,
            sides: [vec![start], vec![start]],
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
        match (self.support.sustained, self.ball) {
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
    fn after(&self, node: &SlipNode<N>, h: f64) -> SlipNode<N> {
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
        let angle = match (self.support.sustained, self.ball) {
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

    /// After a duration.
    fn seen(&mut self, duration_s: f64) -> Seen<N> {
        let is_short = duration_s.abs() <= DURATION_MAX_S;
        let duration_s = if is_short { duration_s } else { f64::NAN };
        let side = usize::from(duration_s < 0.0);
        let step_s = STEP_S.copysign(duration_s);
        let whole = (duration_s / step_s) as usize;
        while self.sides[side].len() <= whole {
            let last = self.sides[side].last().expect("the start");
            let next = self.after(last, step_s);
            self.sides[side].push(next);
        }
        let last = &self.sides[side][whole];
        let node = self.after(last, duration_s - whole as f64 * step_s);
        self.told(node, duration_s)
    }

    /// What follows from a node.
    fn told(&self, node: SlipNode<N>, s: f64) -> Seen<N> {
        let normal = self.normal;
        let (slip_rate, turning) = self.rates(node.slip_m_s, node.direction);
        let rate = (node.direction * slip_rate + turning * node.slip_m_s).value;
        let u = node.u();
        let off = self.velocity_m_s.dot(normal);
        let spin_rad_s = self.spin_rad_s(s, u);
        let zero = Vector3::zeros();
        let n = normal.value;
        let g = self.along_m_s2.value;
        let (position_m, velocity_m_s, acceleration_m_s2, angular_acceleration_rad_s2) =
            match (self.support.sustained, self.ball) {
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
                (sustained, ball) => {
                    let across = |of: Jet3<N>| of - normal * of.dot(normal);
                    let straight = rate - n * n.dot(&rate);
                    let spun = match (sustained, ball) {
                        (Sustained::Slide, _) => n * (n.dot(&rate) * self.per_gyration_m.value),
                        (_, Some([_, radius_m])) => n.cross(&rate) / radius_m,
                        (_, None) => zero,
                    };
                    (
                        self.position_m + across(node.way_m) + normal * off * s,
                        across(u) + normal * off,
                        straight,
                        spun,
                    )
                }
            };
        let spin = spin_rad_s.value;
        let (moving_m_s, turning_rad_s) = match (self.support.sustained, self.ball) {
            (Sustained::Rest, _) => (zero, zero),
            (Sustained::Slide, None) => (velocity_m_s.value, n * n.dot(&spin)),
            _ => (velocity_m_s.value, spin),
        };
        Seen {
            node,
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

impl<const N: usize> Seen<N> {
    fn state(&self) -> State {
        State {
            position_m: self.position_m.value,
            orientation: self.node.orientation,
            velocity_m_s: self.velocity_m_s.value,
            angular_velocity_rad_s: self.node.orientation.inverse() * self.spin_rad_s.value,
        }
    }
}

impl Seen<VARIABLES> {
    fn carried(&self) -> Carried {
        let state = self.state();
        let to_body = so3::matrix(&state.orientation).transpose();
        let mut by = SMatrix::<f64, 12, VARIABLES>::zeros();
        let mut set = |row: usize, block: SMatrix<f64, 3, VARIABLES>| {
            by.fixed_view_mut::<3, VARIABLES>(row, 0).copy_from(&block);
        };
        set(part::POSITION, self.position_m.by);
        set(part::ORIENTATION, to_body * self.node.turned);
        set(part::VELOCITY, self.velocity_m_s.by);
        // (Exp(δ) R)ᵀ ω = Rᵀ (ω − δ × ω).
        let spun = self.spin_rad_s.by + so3::hat(&self.spin_rad_s.value) * self.node.turned;
        set(part::ANGULAR_VELOCITY, to_body * spun);
        let mut rate = StateTangent::zeros();
        let mut put = |row: usize, of: Vector3<f64>| rate.fixed_rows_mut::<3>(row).copy_from(&of);
        put(part::VELOCITY, self.acceleration_m_s2);
        // What turns by less than its angular velocity sees that of the world turn: (Rᵀ ω)˙ = Rᵀ (ω̇ − Ω × ω).
        let apparent = self.turning_rad_s.cross(&self.spin_rad_s.value);
        put(
            part::ANGULAR_VELOCITY,
            to_body * (self.angular_acceleration_rad_s2 - apparent),
        );
        put(part::POSITION, self.moving_m_s);
        put(part::ORIENTATION, to_body * self.turning_rad_s);
        let column = |at: usize| by.column(at).into_owned();
        Carried {
            state,
            rate,
            by_state: by.fixed_columns::<12>(0).into_owned(),
            by_pull: [0, 1, 2].map(|axis| column(PULL + axis)),
            by_friction: column(FRICTION),
            slip_m_s: self.node.slip_m_s.value,
            slip_rate_m_s2: self.slip_rate_m_s2,
            slip_by_state: self.node.slip_m_s.by.fixed_columns::<12>(0).into_owned(),
            slip_by_pull: [0, 1, 2].map(|axis| self.node.slip_m_s.by[PULL + axis]),
            slip_by_friction: self.node.slip_m_s.by[FRICTION],
        }
    }
}

#[cfg(test)]
mod tests;
