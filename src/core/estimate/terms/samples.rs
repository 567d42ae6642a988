//! The sample terms of the objective (paper eq. 1), summed into one small block per arc.
//!
//! The cost of one sample, `s` seconds from the arc's epoch, is
//!
//! ```text
//! ½|x(s) − x_i|²/u_x² + ½|Log(R_iᵀ R(s))|²/u_R²,   x(s) = x + v s + ½ g s²
//! ```
//!
//! with the units `u` of residuals; the second term is in [`TurnTerms`]. With known times the
//! position terms are an exact quadratic in `x`, `v` and `g`, whatever the number of samples:
//! [`ArcSums`] keeps its coefficients, relative to a reference near the optimum so that no digits
//! cancel.

use nalgebra::{Matrix3, Vector3};

use crate::estimate::problem::{ArcSample, View};
use crate::physics::flow::{self, Spin};
use crate::physics::observe::TurnTerms;
use crate::physics::{Body, State};

/// Sums over the samples of an arc for the position terms when times are known.
#[derive(Clone, Debug)]
pub struct ArcSums {
    reference_position_m: Vector3<f64>,
    reference_velocity_m_s: Vector3<f64>,
    reference_gravity_m_s2: Vector3<f64>,
    /// `Σ s^k`, k = 0…4.
    powers: [f64; 5],
    /// `Σ r`, `Σ s r`, `Σ ½s² r` of the reference's residuals.
    moments: [Vector3<f64>; 3],
    /// `Σ |r|²`.
    square: f64,
}

/// Half the sum of squared residuals of an arc and its derivatives by the state, in the
/// order position, orientation, velocity, angular velocity; and by gravity.
#[derive(Clone, Debug, Default)]
pub struct ArcTerms {
    /// Value of the position terms.
    pub cost: f64,
    /// `Σ r`, `Σ s r`, `Σ ½s² r` per squared unit: gradients by position, velocity, gravity.
    pub position_gradient: [Vector3<f64>; 3],
    /// `Σ s^k` per squared unit, k = 0…4: the Hessian between position, velocity, gravity is
    /// `[p0, p1, p2/2; ·, p2, p3/2; ·, ·, p4/4]`, the same on every axis.
    pub powers: [f64; 5],
    /// Terms of the rotation, its cost included.
    pub turn: TurnTerms,
}

/// Derivatives of the cost by the time of a node.
#[derive(Clone, Copy, Debug, Default)]
pub struct TimeTerms {
    /// First derivative by the time.
    pub gradient: f64,
    /// Second derivative by the time (Gauss–Newton).
    pub square: f64,
    /// Mixed derivative by the time and that of the next node.
    pub with_next: f64,
    /// Mixed derivatives by the time and position, orientation, velocity, angular velocity,
    /// gravity.
    pub cross: [Vector3<f64>; 5],
}

impl TimeTerms {
    /// Adds terms of a sample time that moves by `share` of the node's time.
    #[inline]
    pub(in crate::estimate) fn add(&mut self, terms: &Self, share: f64) {
        self.gradient += share * terms.gradient;
        self.square += share * share * terms.square;
        for (entry, cross) in self.cross.iter_mut().zip(&terms.cross) {
            *entry += cross * share;
        }
    }
}

/// Collects the terms of the samples between two nodes and hands them over node by node.
pub(in crate::estimate) struct Between {
    /// The current node; `terms` are its terms and those of the next node.
    node: usize,
    terms: [TimeTerms; 2],
    /// Whether a sample lies after the node, so that the next node has terms.
    reaches: bool,
}

impl Between {
    pub(in crate::estimate) fn new(node: usize) -> Self {
        Self {
            node,
            terms: [TimeTerms::default(); 2],
            reaches: false,
        }
    }

    /// Adds a sample's terms by its time; `each` is called with nodes whose terms are complete.
    #[inline]
    pub(in crate::estimate) fn add(
        &mut self,
        sample: &ArcSample,
        terms: &TimeTerms,
        mut each: impl FnMut(usize, &TimeTerms),
    ) {
        if sample.node != self.node {
            let [here, next] = self.terms;
            each(self.node, &here);
            self.terms = [next, TimeTerms::default()];
            if self.reaches && sample.node != self.node + 1 {
                each(self.node + 1, &next);
                self.terms[0] = TimeTerms::default();
            }
            (self.node, self.reaches) = (sample.node, false);
        }
        let [here, next] = &mut self.terms;
        let share = sample.share;
        here.add(terms, 1.0 - share);
        if share > 0.0 {
            self.reaches = true;
            next.add(terms, share);
            here.with_next += share * (1.0 - share) * terms.square;
        }
    }

    pub(in crate::estimate) fn end(&self, mut each: impl FnMut(usize, &TimeTerms)) {
        let [here, next] = &self.terms;
        each(self.node, here);
        if self.reaches {
            each(self.node + 1, next);
        }
    }
}

impl ArcSums {
    /// Sums over the samples of `view` at `times_s`, of residuals of the reference flight through
    /// `state`, of a body without drag.
    pub fn new(
        body: &Body,
        view: &View,
        times_s: &[f64],
        epoch_s: f64,
        state: &State,
        gravity_m_s2: &Vector3<f64>,
    ) -> Self {
        assert!(body.is_ballistic(), "sums over a parabola");
        let mut sums = Self {
            reference_position_m: state.position_m,
            reference_velocity_m_s: state.velocity_m_s,
            reference_gravity_m_s2: *gravity_m_s2,
            powers: [0.0; 5],
            moments: [Vector3::zeros(); 3],
            square: 0.0,
        };
        for sample in &view.samples {
            let s = sample.time_s(times_s) - epoch_s;
            let residual = flow::position(body, gravity_m_s2, state, s) - sample.position_m;
            sums.moments[0] += residual;
            sums.moments[1] += residual * s;
            sums.moments[2] += residual * (0.5 * s * s);
            sums.square += residual.norm_squared();
            let mut power = 1.0;
            for entry in &mut sums.powers {
                *entry += power;
                power *= s;
            }
        }
        sums
    }

    /// Adds the position terms of a state.
    fn add_to(
        &self,
        terms: &mut ArcTerms,
        state: &State,
        gravity_m_s2: &Vector3<f64>,
        unit_m: f64,
    ) {
        let weight = 1.0 / (unit_m * unit_m);
        let [p0, p1, p2, p3, p4] = self.powers;
        let x = state.position_m - self.reference_position_m;
        let v = state.velocity_m_s - self.reference_velocity_m_s;
        let g = gravity_m_s2 - self.reference_gravity_m_s2;
        let change = [
            x * p0 + v * p1 + g * (0.5 * p2),
            x * p1 + v * p2 + g * (0.5 * p3),
            x * (0.5 * p2) + v * (0.5 * p3) + g * (0.25 * p4),
        ];
        let step = [x, v, g];
        let mut cost = 0.5 * self.square;
        for k in 0..3 {
            cost += step[k].dot(&(self.moments[k] + change[k] * 0.5));
            terms.position_gradient[k] += (self.moments[k] + change[k]) * weight;
        }
        // A sum of squares; rounding may make that of a perfect fit slightly negative.
        terms.cost += cost.max(0.0) * weight;
        for (entry, power) in terms.powers.iter_mut().zip(&self.powers) {
            *entry += power * weight;
        }
    }
}

/// Terms of a plain view whose sample times are known. Every `stride`-th orientation is used, with the
/// weight of `stride`.
pub fn known_times(
    view: &View,
    (sums, stride): (&ArcSums, usize),
    (state, epoch_s): (&State, f64),
    spin: &mut Spin,
    gravity_m_s2: &Vector3<f64>,
    times_s: &[f64],
) -> ArcTerms {
    let [unit_m, unit_rad] = view.units;
    let mut terms = ArcTerms::default();
    if unit_rad.is_finite() {
        let readings = view.samples.iter().skip(stride / 2).step_by(stride);
        let weight =
            view.samples.len() as f64 / (readings.len().max(1) as f64 * unit_rad * unit_rad);
        let readings =
            readings.map(|sample| (sample.time_s(times_s) - epoch_s, &sample.orientation));
        terms.turn = TurnTerms::of(spin, &state.orientation, readings).weighed(weight);
    }
    if unit_m.is_finite() {
        sums.add_to(&mut terms, state, gravity_m_s2, unit_m);
    }
    terms
}

/// Terms of a view in the short form whose sample times are unknowns or depend on some. Every
/// `stride`-th sample is used, with the weight of `stride`. `each` is called with every sample and its
/// terms by its time.
pub fn unknown_times(
    body: &Body,
    (view, stride): (&View, usize),
    (state, epoch_s): (&State, f64),
    spin: &mut Spin,
    gravity_m_s2: &Vector3<f64>,
    time_s: impl Fn(&ArcSample) -> f64,
    mut each: impl FnMut(&ArcSample, &TimeTerms),
) -> ArcTerms {
    let mut terms = ArcTerms::default();
    assert!(body.is_ballistic(), "derivatives of a parabola");
    let samples = view.samples.iter().skip(stride / 2).step_by(stride);
    let for_each = view.samples.len() as f64 / samples.len().max(1) as f64;
    let [weight, turn_weight] = view.units.map(|unit| for_each / (unit * unit));
    for sample in samples {
        let s = time_s(sample) - epoch_s;
        let (k, error) = if turn_weight > 0.0 {
            terms.turn.add(
                spin,
                &state.orientation,
                &sample.orientation,
                s,
                turn_weight,
            )
        } else {
            (Matrix3::zeros(), Vector3::zeros())
        };
        let velocity = flow::velocity(body, gravity_m_s2, state, s);
        let residual = flow::position(body, gravity_m_s2, state, s) - sample.position_m;
        let half_square = 0.5 * s * s;
        terms.cost += 0.5 * weight * residual.norm_squared();
        terms.position_gradient[0] += residual * weight;
        terms.position_gradient[1] += residual * (weight * s);
        terms.position_gradient[2] += residual * (weight * half_square);
        let mut power = weight;
        for entry in &mut terms.powers {
            *entry += power;
            power *= s;
        }
        // The body's angular velocity at s, in the epoch's frame, is K ω.
        let omega = k * state.angular_velocity_rad_s;
        let (pull, turn) = (velocity * weight, omega * turn_weight);
        let by_time = TimeTerms {
            gradient: pull.dot(&residual) + turn.dot(&error),
            square: pull.dot(&velocity) + turn.dot(&omega),
            with_next: 0.0,
            cross: [
                pull,
                turn,
                pull * s,
                k.tr_mul(&turn) * s,
                pull * half_square,
            ],
        };
        each(sample, &by_time);
    }
    terms
}
