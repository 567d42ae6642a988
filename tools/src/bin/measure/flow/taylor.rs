//! Taylor series of the free turn to any order, in numbers of any length: Euler's equations in
//! the components of `ω`, the quaternion, and the derivatives `W`, `η` of both by `ω(0)`,
//!
//! ```text
//! ω̇_i = c_i ω_j ω_k,              q̇ = ½ q ω,
//! Ẇ_i = c_i (ω_j W_k + ω_k W_j),   η̇_i = W_i + ω_k η_j − ω_j η_k
//! ```
//!
//! each step as long as its last terms allow. Unlike the program's it has no factors near the
//! separatrix, no invariant that is kept and no direction that is spared.

use std::ops::{Add, Mul, Neg, Sub};

use nalgebra::{Matrix3, Quaternion};

use super::method::Turned;
use enact_tools::reference::Pair;

/// What it computes with.
pub trait Scalar:
    Copy + From<f64> + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Neg<Output = Self>
{
    /// The quotient, rounded to this length.
    fn over(self, other: Self) -> Self;
    /// To a plain number.
    fn plain(self) -> f64;
}

impl Scalar for f64 {
    fn over(self, other: Self) -> Self {
        self / other
    }
    fn plain(self) -> f64 {
        self
    }
}

impl Scalar for Pair {
    fn over(self, other: Self) -> Self {
        self / other
    }
    fn plain(self) -> f64 {
        self.0
    }
}

/// `w, x, y, z` of the turn; `ω`; columns of `W`; columns of `η`.
#[derive(Clone, Copy)]
pub struct Node<N> {
    pub turn: [N; 4],
    pub omega: [N; 3],
    pub w: [[N; 3]; 3],
    pub eta: [[N; 3]; 3],
}

/// Steps longer than any turn needs are a failure.
const STEPS_MAX: usize = 2_000_000;

/// A turn, step by step; `TERMS` is the order and one.
pub struct Taylor<N, const TERMS: usize> {
    couplings: [N; 3],
    speed: f64,
    tolerance: f64,
    start_s: N,
    reach_s: f64,
    steps: usize,
    series: [Node<N>; TERMS],
}

impl<N: Scalar, const TERMS: usize> Taylor<N, TERMS> {
    /// The turn that begins with `omega`; `tolerance` is what the last terms may add, relative.
    pub fn new(moments: [f64; 3], omega: [f64; 3], tolerance: f64) -> Self {
        let moment = moments.map(N::from);
        let [zero, one] = [0.0, 1.0].map(N::from);
        let couplings =
            [0, 1, 2].map(|i| (moment[(i + 1) % 3] - moment[(i + 2) % 3]).over(moment[i]));
        let node = Node {
            turn: [one, zero, zero, zero],
            omega: omega.map(N::from),
            w: [[one, zero, zero], [zero, one, zero], [zero, zero, one]],
            eta: [[zero; 3]; 3],
        };
        let mut taylor = Self {
            couplings,
            speed: omega.iter().map(|w| w * w).sum::<f64>().sqrt(),
            tolerance,
            start_s: zero,
            reach_s: 0.0,
            steps: 0,
            series: [node; TERMS],
        };
        taylor.expand(node);
        taylor
    }

    fn expand(&mut self, node: Node<N>) {
        let half = N::from(0.5);
        self.series[0] = node;
        for n in 0..TERMS - 1 {
            let zero = N::from(0.0);
            let mut turn = [zero; 4];
            let mut omega = [zero; 3];
            let (mut w, mut eta) = ([[zero; 3]; 3], [[zero; 3]; 3]);
            for l in 0..=n {
                let (a, b) = (&self.series[l].omega, &self.series[n - l]);
                let q = &b.turn;
                turn[0] = turn[0] - (q[1] * a[0] + q[2] * a[1] + q[3] * a[2]);
                turn[1] = turn[1] + q[0] * a[0] + q[2] * a[2] - q[3] * a[1];
                turn[2] = turn[2] + q[0] * a[1] + q[3] * a[0] - q[1] * a[2];
                turn[3] = turn[3] + q[0] * a[2] + q[1] * a[1] - q[2] * a[0];
                for i in 0..3 {
                    let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                    omega[i] = omega[i] + a[j] * b.omega[k];
                    for column in 0..3 {
                        let (z, e) = (&b.w[column], &b.eta[column]);
                        w[column][i] = w[column][i] + a[j] * z[k] + a[k] * z[j];
                        eta[column][i] = eta[column][i] + a[k] * e[j] - a[j] * e[k];
                    }
                }
            }
            let share = N::from(1.0).over(N::from((n + 1) as f64));
            for i in 0..3 {
                let scale = self.couplings[i] * share;
                omega[i] = omega[i] * scale;
                for column in 0..3 {
                    w[column][i] = w[column][i] * scale;
                    eta[column][i] = (eta[column][i] + self.series[n].w[column][i]) * share;
                }
            }
            self.series[n + 1] = Node {
                turn: turn.map(|entry| entry * half * share),
                omega,
                w,
                eta,
            };
        }
        self.reach_s = [TERMS - 2, TERMS - 1]
            .map(|n| self.reach_of(n))
            .into_iter()
            .fold(f64::INFINITY, f64::min);
    }

    /// How far the terms of an order stay below the tolerance \[s\].
    fn reach_of(&self, n: usize) -> f64 {
        let term = &self.series[n];
        let size = |entries: &[N]| {
            let sizes = entries.iter().map(|entry| entry.plain().abs());
            sizes.fold(0.0_f64, f64::max)
        };
        let of_eta = term.eta.iter().map(|column| self.speed * size(column));
        let of_omega = size(&term.omega) / self.speed;
        let largest = of_eta.fold(size(&term.turn).max(of_omega), f64::max);
        if largest == 0.0 {
            return f64::INFINITY;
        }
        (self.tolerance / largest).powf(1.0 / n as f64)
    }

    fn value(&self, time: N) -> Node<N> {
        let mut sum = self.series[TERMS - 1];
        for term in self.series[..TERMS - 1].iter().rev() {
            for i in 0..4 {
                sum.turn[i] = sum.turn[i] * time + term.turn[i];
            }
            for i in 0..3 {
                sum.omega[i] = sum.omega[i] * time + term.omega[i];
                for j in 0..3 {
                    sum.w[i][j] = sum.w[i][j] * time + term.w[i][j];
                    sum.eta[i][j] = sum.eta[i][j] * time + term.eta[i][j];
                }
            }
        }
        sum
    }

    /// The state at a time that is not before the last one asked for.
    pub fn node(&mut self, time_s: f64) -> Option<Node<N>> {
        loop {
            let left = N::from(time_s) - self.start_s;
            if left.plain() <= self.reach_s {
                return Some(self.value(left));
            }
            self.steps += 1;
            if self.steps > STEPS_MAX || !(self.reach_s > 0.0) {
                return None;
            }
            let node = self.value(N::from(self.reach_s));
            self.start_s = self.start_s + N::from(self.reach_s);
            self.expand(node);
        }
    }
}

impl<const TERMS: usize> Taylor<f64, TERMS> {
    /// The turn at a time that is not before the last one asked for.
    pub fn at(&mut self, time_s: f64) -> Option<Turned> {
        let node = self.node(time_s)?;
        let [w, x, y, z] = node.turn;
        let by_spin = Matrix3::from_fn(|row, column| node.eta[column][row]);
        Some(Turned::of(Quaternion::new(w, x, y, z), by_spin))
    }
}
