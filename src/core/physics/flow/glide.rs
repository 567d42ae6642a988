//! The centre of mass of a body with drag and lift, step by step.
//!
//! ```text
//! x' = v,   v' = a(v) = p + Ω × v − k v − c|v| v,   p = g + f,   Ω = ℓ ω
//! ```
//!
//! with the angular velocity `ω` of a ball, which is constant in world axes, by the explicit Runge–Kutta method of
//! Cooper and Verner ("Some explicit Runge–Kutta methods of high order", SIAM Journal on Numerical Analysis 9, 1972): eleven stages, order eight. Steps are
//! of one fixed length, the last one shorter, so that the result is as smooth in all its inputs as
//! the method's formula, and derivatives are those of the formula itself, exact to rounding.

use nalgebra::{SMatrix, Vector3};

use crate::math::so3;
use crate::physics::drag::Drag;

/// Length of a step \[s\]. Over 1 s from 30 m/s a table-tennis ball with `c = 0.13/m` is 3e-13 m off
/// after it and a body with `k = 5/s` too. The error is largest where the speed passes through zero,
/// at which drag has no second derivative: 1e-9 m for that ball thrown straight up.
const STEP_S: f64 = 1.0 / 128.0;

/// Greatest `(k + c|v| + |Ω|)` times the length of a step. A balloon of `c = 3/m`, hit at 10 m/s, begins at
/// 0.23 and is 5e-11 m off after 1 s; one of 10/m begins at 0.78 and is 1e-5 m off.
const MOST_RATE: f64 = 1.0;

/// Longest duration \[s\]; longer ones would take too many steps to store.
const DURATION_MAX_S: f64 = 1e3;

const STAGES: usize = 11;

/// `√21`.
const S: f64 = 4.582_575_694_955_84;

/// Weights of the earlier stages in each stage.
const A: [&[f64]; STAGES] = [
    &[],
    &[0.5],
    &[0.25, 0.25],
    &[1.0 / 7.0, (-7.0 - 3.0 * S) / 98.0, (21.0 + 5.0 * S) / 49.0],
    &[
        (11.0 + S) / 84.0,
        0.0,
        (18.0 + 4.0 * S) / 63.0,
        (21.0 - S) / 252.0,
    ],
    &[
        (5.0 + S) / 48.0,
        0.0,
        (9.0 + S) / 36.0,
        (-231.0 + 14.0 * S) / 360.0,
        (63.0 - 7.0 * S) / 80.0,
    ],
    &[
        (10.0 - S) / 42.0,
        0.0,
        (-432.0 + 92.0 * S) / 315.0,
        (633.0 - 145.0 * S) / 90.0,
        (-504.0 + 115.0 * S) / 70.0,
        (63.0 - 13.0 * S) / 35.0,
    ],
    &[
        1.0 / 14.0,
        0.0,
        0.0,
        0.0,
        (14.0 - 3.0 * S) / 126.0,
        (13.0 - 3.0 * S) / 63.0,
        1.0 / 9.0,
    ],
    &[
        1.0 / 32.0,
        0.0,
        0.0,
        0.0,
        (91.0 - 21.0 * S) / 576.0,
        11.0 / 72.0,
        (-385.0 - 75.0 * S) / 1152.0,
        (63.0 + 13.0 * S) / 128.0,
    ],
    &[
        1.0 / 14.0,
        0.0,
        0.0,
        0.0,
        1.0 / 9.0,
        (-733.0 - 147.0 * S) / 2205.0,
        (515.0 + 111.0 * S) / 504.0,
        (-51.0 - 11.0 * S) / 56.0,
        (132.0 + 28.0 * S) / 245.0,
    ],
    &[
        0.0,
        0.0,
        0.0,
        0.0,
        (-42.0 + 7.0 * S) / 18.0,
        (-18.0 + 28.0 * S) / 45.0,
        (-273.0 - 53.0 * S) / 72.0,
        (301.0 + 53.0 * S) / 72.0,
        (28.0 - 28.0 * S) / 45.0,
        (49.0 - 7.0 * S) / 18.0,
    ],
];

/// Weights of the stages in a step.
const B: [f64; STAGES] = [
    1.0 / 20.0,
    0.0,
    0.0,
    0.0,
    0.0,
    0.0,
    0.0,
    49.0 / 180.0,
    16.0 / 45.0,
    49.0 / 180.0,
    1.0 / 20.0,
];

/// Where columns of derivatives begin: by the velocity at the start, by `p`, by `k`, by `c`.
pub(super) mod column {
    pub const VELOCITY: usize = 0;
    pub const PULL: usize = 3;
    pub const LINEAR_DRAG: usize = 6;
    pub const QUADRATIC_DRAG: usize = 7;
}

/// Derivatives of a vector by [`column`].
pub(super) type Change = SMatrix<f64, 3, 8>;

/// Derivatives of a vector by `Ω`.
type ByLifting = SMatrix<f64, 3, 3>;

/// The motion between two steps.
#[derive(Clone, Copy, Debug)]
pub(super) struct GlideNode {
    /// Way from the start [m, world].
    pub way_m: Vector3<f64>,
    /// Velocity [m/s, world].
    pub velocity_m_s: Vector3<f64>,
}

/// Derivatives of a node.
#[derive(Clone, Copy, Debug)]
pub(super) struct NodeChange<const C: usize> {
    pub way: SMatrix<f64, 3, C>,
    pub velocity: SMatrix<f64, 3, C>,
}

/// The motion of a centre of mass from one start: its steps, computed when first needed.
#[derive(Clone, Debug)]
pub(super) struct Glide {
    pull_m_s2: Vector3<f64>,
    drag: Drag,
    /// `Ω` [1/s, world], if there is lift.
    lifting_per_s: Option<Vector3<f64>>,
    start: GlideNode,
    /// Nodes after the start, and before it.
    sides: [GlideSide; 2],
}

/// Nodes in one direction of time, the first of which is the start.
#[derive(Clone, Debug, Default)]
struct GlideSide {
    nodes: Vec<GlideNode>,
    /// Of as many of the nodes as were asked for.
    changes: Vec<NodeChange<8>>,
    /// The same by `Ω`.
    by_lifting: Vec<NodeChange<3>>,
}

impl Glide {
    pub(super) fn new(pull_m_s2: Vector3<f64>, drag: Drag, velocity_m_s: &Vector3<f64>) -> Self {
        Self {
            pull_m_s2,
            drag,
            lifting_per_s: None,
            start: GlideNode {
                way_m: Vector3::zeros(),
                velocity_m_s: *velocity_m_s,
            },
            sides: [GlideSide::default(), GlideSide::default()],
        }
    }

    /// The same with lift, of a given `Ω` [1/s, world].
    pub(super) fn lifted(self, lifting_per_s: Vector3<f64>) -> Self {
        Self {
            lifting_per_s: Some(lifting_per_s),
            ..self
        }
    }

    /// Way and velocity after `duration_s` (negative: before).
    pub(super) fn at(&mut self, duration_s: f64) -> GlideNode {
        let (side, whole, rest_s) = self.reach(duration_s);
        let node = &self.sides[side].nodes[whole];
        node.after(&self.stages(node, rest_s), rest_s)
    }

    /// The same with derivatives.
    pub(super) fn at_with_change(&mut self, duration_s: f64) -> (GlideNode, NodeChange<8>) {
        let mut start = Change::zeros();
        start
            .fixed_columns_mut::<3>(column::VELOCITY)
            .fill_diagonal(1.0);
        let direct = |velocity: &Vector3<f64>, acceleration: &mut Change| {
            for axis in 0..3 {
                acceleration[(axis, column::PULL + axis)] += 1.0;
                acceleration[(axis, column::LINEAR_DRAG)] -= velocity[axis];
                acceleration[(axis, column::QUADRATIC_DRAG)] -= velocity.norm() * velocity[axis];
            }
        };
        self.followed(duration_s, |side| &mut side.changes, start, direct)
    }

    /// Derivatives after `duration_s` by `Ω`: `δa = δΩ × v`.
    pub(super) fn by_lifting(&mut self, duration_s: f64) -> NodeChange<3> {
        let direct = |velocity: &Vector3<f64>, acceleration: &mut ByLifting| {
            *acceleration -= so3::hat(velocity);
        };
        self.followed(
            duration_s,
            |side| &mut side.by_lifting,
            ByLifting::zeros(),
            direct,
        )
        .1
    }

    /// The node after `duration_s` with derivatives by something: those that are kept, those of the velocity at the start,
    /// and what is added to those of the acceleration at a velocity.
    fn followed<const C: usize>(
        &mut self,
        duration_s: f64,
        kept: impl Fn(&mut GlideSide) -> &mut Vec<NodeChange<C>>,
        velocity: SMatrix<f64, 3, C>,
        direct: impl Fn(&Vector3<f64>, &mut SMatrix<f64, 3, C>),
    ) -> (GlideNode, NodeChange<C>) {
        let (side, whole, rest_s) = self.reach(duration_s);
        let step_s = STEP_S.copysign(duration_s);
        let mut changes = std::mem::take(kept(&mut self.sides[side]));
        let nodes = &self.sides[side].nodes;
        while changes.len() <= whole {
            let next = match changes.last() {
                None => NodeChange {
                    way: SMatrix::zeros(),
                    velocity,
                },
                Some(last) => {
                    let stages = self.stages(&nodes[changes.len() - 1], step_s);
                    self.change_after(last, &stages, step_s, &direct)
                }
            };
            changes.push(next);
        }
        let stages = self.stages(&nodes[whole], rest_s);
        let node = nodes[whole].after(&stages, rest_s);
        let change = self.change_after(&changes[whole], &stages, rest_s, &direct);
        *kept(&mut self.sides[side]) = changes;
        (node, change)
    }

    /// Computes the nodes up to a time: their side, the last node, and the time left from it.
    fn reach(&mut self, duration_s: f64) -> (usize, usize, f64) {
        let side = usize::from(duration_s < 0.0);
        let step_s = STEP_S.copysign(duration_s);
        let is_short = duration_s.abs() <= DURATION_MAX_S;
        let duration_s = if is_short { duration_s } else { f64::NAN };
        let whole = (duration_s / step_s) as usize;
        while self.sides[side].nodes.len() <= whole {
            let next = match self.sides[side].nodes.last() {
                None => self.start,
                Some(last) => last.after(&self.stages(last, step_s), step_s),
            };
            self.sides[side].nodes.push(next);
        }
        (side, whole, duration_s - whole as f64 * step_s)
    }

    /// Velocities and accelerations at the stages of a step; not numbers beyond [`MOST_RATE`].
    fn stages(&self, from: &GlideNode, step_s: f64) -> [[Vector3<f64>; 2]; STAGES] {
        let mut rate = self.drag.rate_per_s(&from.velocity_m_s) * STEP_S;
        if let Some(lifting_per_s) = &self.lifting_per_s {
            rate += lifting_per_s.norm() * STEP_S;
        }
        if !(rate <= MOST_RATE) {
            return [[Vector3::repeat(f64::NAN); 2]; STAGES];
        }
        let mut stages = [[Vector3::zeros(); 2]; STAGES];
        for (stage, weights) in A.iter().enumerate() {
            let mut velocity = from.velocity_m_s;
            for (weight, [_, earlier]) in weights.iter().zip(&stages) {
                velocity += earlier * (weight * step_s);
            }
            let mut acceleration = self.pull_m_s2 + self.drag.acceleration_m_s2(&velocity);
            if let Some(lifting_per_s) = &self.lifting_per_s {
                acceleration += lifting_per_s.cross(&velocity);
            }
            stages[stage] = [velocity, acceleration];
        }
        stages
    }

    /// Derivatives after a step, from its stages and the derivatives before it; `direct` adds to those of the
    /// acceleration what is not by the velocity.
    fn change_after<const C: usize>(
        &self,
        from: &NodeChange<C>,
        stages: &[[Vector3<f64>; 2]; STAGES],
        step_s: f64,
        direct: &impl Fn(&Vector3<f64>, &mut SMatrix<f64, 3, C>),
    ) -> NodeChange<C> {
        let mut accelerations = [SMatrix::<f64, 3, C>::zeros(); STAGES];
        let mut after = *from;
        for (stage, [velocity, _]) in stages.iter().enumerate() {
            let mut change = from.velocity;
            for (weight, earlier) in A[stage].iter().zip(&accelerations) {
                if *weight != 0.0 {
                    change += earlier * (weight * step_s);
                }
            }
            let mut by_velocity = self.drag.acceleration_by_velocity_per_s(velocity);
            if let Some(lifting_per_s) = &self.lifting_per_s {
                by_velocity += so3::hat(lifting_per_s);
            }
            let mut acceleration = by_velocity * change;
            direct(velocity, &mut acceleration);
            if B[stage] != 0.0 {
                after.way += change * (B[stage] * step_s);
                after.velocity += acceleration * (B[stage] * step_s);
            }
            accelerations[stage] = acceleration;
        }
        after
    }
}

impl GlideNode {
    /// The node after a step with these stages.
    fn after(&self, stages: &[[Vector3<f64>; 2]; STAGES], step_s: f64) -> Self {
        let mut after = *self;
        for (weight, [velocity, acceleration]) in B.iter().zip(stages) {
            after.way_m += velocity * (weight * step_s);
            after.velocity_m_s += acceleration * (weight * step_s);
        }
        after
    }
}
