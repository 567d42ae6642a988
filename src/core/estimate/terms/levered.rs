//! The terms of points beside the centre of mass, of directions, and of samples with covariances, four
//! samples at a time, summed into one small block per view.
//!
//! All is in world axes: where a change of the state moves the centre of mass by `ξ` and turns the body
//! by `φ`, the cost of a sample changes by
//!
//! ```text
//! g_x·ξ + g_φ·φ + ½ (ξ, φ) M (ξ, φ),     ξ = δx + s δv + ṡ…,   φ = R₀ (δθ + s K δω)
//! ```
//!
//! so that `g` and `M` of a sample ([`Rows`]) are all that its kind has to tell ([`lever_rows`](super::lever_rows)).

use nalgebra::{Matrix3, Vector3};
use wide::f64x4;

use super::samples::TimeTerms;
use crate::estimate::problem::ArcSample;
use crate::math::lanes::{LANES, SYMMETRIC, Vectors, sum_of_columns, symmetric};
use crate::math::so3;
use crate::physics::flow::Fall;
use crate::physics::observe::lanes::{Turned, Turner};
use crate::physics::{Body, State};

/// Half the sum of squares with its derivatives by the arc's state: by position, orientation, velocity
/// and angular velocity.
#[derive(Clone, Debug, Default)]
pub(in crate::estimate) struct StateTerms {
    pub(in crate::estimate) cost: f64,
    pub(in crate::estimate) gradient: [Vector3<f64>; 4],
    /// By position twice, by it and velocity, by velocity twice.
    pub(in crate::estimate) places: [Matrix3<f64>; 3],
    /// By position (rows) and orientation, and by velocity and orientation.
    pub(in crate::estimate) by_turn: [Matrix3<f64>; 2],
    /// By position (rows) and angular velocity, and by velocity and angular velocity.
    pub(in crate::estimate) by_spin: [Matrix3<f64>; 2],
    /// By orientation twice, by it and angular velocity, by angular velocity twice.
    pub(in crate::estimate) turns: [Matrix3<f64>; 3],
}

/// Four samples beside the flight.
pub(in crate::estimate) struct Four<'a> {
    /// The samples; the last again where there are fewer.
    pub(in crate::estimate) indices: [usize; LANES],
    pub(in crate::estimate) samples: [&'a ArcSample; LANES],
    /// One, or zero where there are fewer, times what each stands for.
    pub(in crate::estimate) weight: f64x4,
    /// Centre of mass \[m\].
    pub(in crate::estimate) place_m: Vectors,
    pub(in crate::estimate) turned: Turned,
}

/// `g` and `M` of four samples.
pub(in crate::estimate) trait Rows {
    /// How many entries of `M` by two places may differ from zero or from another: of none, one or all
    /// six.
    const PLACES: usize;
    /// Whether places and turns are coupled.
    const IS_COUPLED: bool;

    /// Half the square.
    fn cost(&self) -> f64x4;
    /// `g_x` and `g_φ`.
    fn gradient(&self) -> [Vectors; 2];
    /// Of `M`, by places in the order of [`SYMMETRIC`].
    fn places(&self) -> [f64x4; 6];
    /// Of `M`, by places and turns: the columns of turns.
    fn mixed(&self) -> [Vectors; 3];
    /// Of `M`, by turns in the order of [`SYMMETRIC`].
    fn turns(&self) -> [f64x4; 6];
    /// `M (0, φ)`.
    fn pull_of_turn(&self, turn: &Vectors) -> [Vectors; 2];
    /// `M (ξ, φ)`.
    fn pull(&self, place: &Vectors, turn: &Vectors) -> [Vectors; 2];
}

/// The samples of a view, along the flight from a state at its epoch.
pub(in crate::estimate) struct Along<'a> {
    pub(in crate::estimate) samples: &'a [ArcSample],
    /// Every `stride`-th is used, with the weight of `stride`.
    pub(in crate::estimate) stride: usize,
    pub(in crate::estimate) body: &'a Body,
    pub(in crate::estimate) gravity_m_s2: &'a Vector3<f64>,
    pub(in crate::estimate) state: &'a State,
    pub(in crate::estimate) epoch_s: f64,
}

impl Along<'_> {
    /// Their terms; `each` is called with every sample and its terms by its time, where one is given.
    pub(in crate::estimate) fn terms<R: Rows>(
        &self,
        time_s: impl Fn(&ArcSample) -> f64,
        mut rows: impl FnMut(&Four) -> R,
        mut each: Option<impl FnMut(&ArcSample, &TimeTerms)>,
    ) -> StateTerms {
        let omega = &self.state.angular_velocity_rad_s;
        let mut turner = Turner::new(self.body, &self.state.orientation, omega);
        let mut fall = Fall::new(self.body, self.gravity_m_s2, self.state).with_drag_free(false);
        let used = self
            .samples
            .len()
            .saturating_sub(self.stride / 2)
            .div_ceil(self.stride);
        let each_counts = self.samples.len() as f64 / used.max(1) as f64;
        let world_from_epoch = so3::matrix(&self.state.orientation);
        let axes = turner.axes;
        let spin = Vectors::splat(&axes.tr_mul(omega));
        let mut sums = LeverSums::default();
        for first in (0..used).step_by(LANES) {
            let indices: [usize; LANES] = std::array::from_fn(|lane| {
                self.stride / 2 + (first + lane).min(used - 1) * self.stride
            });
            let samples = indices.map(|index| &self.samples[index]);
            let s = samples.map(|sample| time_s(sample) - self.epoch_s);
            let fallen = s.map(|s| fall.position_and_velocity(s));
            let present = (used - first).min(LANES);
            let weight = std::array::from_fn(|lane| if lane < present { each_counts } else { 0.0 });
            let s = f64x4::from(s);
            let four = Four {
                indices,
                samples,
                weight: f64x4::from(weight),
                place_m: Vectors::of(fallen.each_ref().map(|of| &of.0)),
                turned: turner.at(s),
            };
            let rows = rows(&four);
            let by_spin = &four.turned.by_spin;
            sums.add(&rows, s, by_spin);
            if let Some(each) = &mut each {
                let velocity = Vectors::of(fallen.each_ref().map(|of| &of.1));
                let turning = Vectors::combined(by_spin, &spin);
                let [pull, twist] = rows.pull(&velocity, &turning);
                let [by_place, by_turn] = rows.gradient();
                let gradient = velocity.dot(&by_place) + turning.dot(&by_turn);
                let square = velocity.dot(&pull) + turning.dot(&twist);
                let (gradient, square) = (gradient.to_array(), square.to_array());
                let cross = [
                    pull,
                    twist.turned(&world_from_epoch.transpose()),
                    pull.times(s),
                    twist.along(by_spin).times(s).turned(&axes),
                ];
                let cross = cross.map(Vectors::to_arrays);
                for lane in 0..present {
                    let [x, r, v, w] = cross.each_ref().map(|of| Vectors::lane(of, lane));
                    let terms = TimeTerms {
                        gradient: gradient[lane],
                        square: square[lane],
                        with_next: 0.0,
                        cross: [x, r, v, w, Vector3::zeros()],
                    };
                    each(samples[lane], &terms);
                }
            }
        }
        sums.gathered::<R>(&world_from_epoch, &axes)
    }
}

/// Sums in world axes, by angular velocity in those of [`Turner::axes`].
#[derive(Default)]
struct LeverSums {
    cost: f64x4,
    /// `Σ g_x`, `Σ s g_x`, `Σ g_φ`, `Σ s Kᵀ g_φ`
    gradient: [Vectors; 4],
    /// `Σ s^k M`, k = 0…2
    places: [[f64x4; 6]; 3],
    /// `Σ s^k M`, k = 0, 1
    mixed: [[Vectors; 3]; 2],
    /// `Σ s^k M K`, k = 1, 2
    mixed_by_spin: [[Vectors; 3]; 2],
    /// `Σ M`, `Σ s M K`, `Σ s² Kᵀ M K`
    turn: [f64x4; 6],
    turn_by_spin: [Vectors; 3],
    spin: [f64x4; 6],
}

impl LeverSums {
    #[inline]
    fn add<R: Rows>(&mut self, rows: &R, s: f64x4, by_spin: &[Vectors; 3]) {
        let one = f64x4::ONE;
        let square = s * s;
        self.cost += rows.cost();
        let [by_place, by_turn] = rows.gradient();
        if R::PLACES > 0 {
            self.gradient[0].add(&by_place, one);
            self.gradient[1].add(&by_place, s);
            for (entry, place) in rows.places()[..R::PLACES].iter().enumerate() {
                self.places[0][entry] += *place;
                self.places[1][entry] += *place * s;
                self.places[2][entry] += *place * square;
            }
        }
        self.gradient[2].add(&by_turn, one);
        self.gradient[3].add(&by_turn.along(by_spin), s);
        let pulls = by_spin.each_ref().map(|column| rows.pull_of_turn(column));
        if R::IS_COUPLED {
            for (column, mixed) in rows.mixed().iter().enumerate() {
                self.mixed[0][column].add(mixed, one);
                self.mixed[1][column].add(mixed, s);
                self.mixed_by_spin[0][column].add(&pulls[column][0], s);
                self.mixed_by_spin[1][column].add(&pulls[column][0], square);
            }
        }
        for (sum, entry) in self.turn.iter_mut().zip(rows.turns()) {
            *sum += entry;
        }
        for (sum, [_, twist]) in self.turn_by_spin.iter_mut().zip(&pulls) {
            sum.add(twist, s);
        }
        for (sum, (row, column)) in self.spin.iter_mut().zip(SYMMETRIC) {
            *sum += by_spin[row].dot(&pulls[column][1]) * square;
        }
    }

    fn gathered<R: Rows>(self, world_from_epoch: &Matrix3<f64>, axes: &Matrix3<f64>) -> StateTerms {
        let [by_place, by_velocity, by_turn, by_spin] = self.gradient.map(Vectors::sum);
        let to_axes = axes.transpose();
        let to_epoch = world_from_epoch.transpose();
        let place = |entries: [f64x4; 6]| {
            let [first, rest @ ..] = entries.map(f64x4::reduce_add);
            let [a, b, c, d, e] = rest;
            match R::PLACES {
                6 => symmetric([first, a, b, c, d, e]),
                _ => Matrix3::from_diagonal_element(first),
            }
        };
        StateTerms {
            cost: self.cost.reduce_add(),
            gradient: [by_place, to_epoch * by_turn, by_velocity, axes * by_spin],
            places: self.places.map(place),
            by_turn: self.mixed.map(|of| sum_of_columns(of) * world_from_epoch),
            by_spin: self.mixed_by_spin.map(|of| sum_of_columns(of) * to_axes),
            turns: [
                to_epoch * symmetric(self.turn.map(f64x4::reduce_add)) * world_from_epoch,
                to_epoch * sum_of_columns(self.turn_by_spin) * to_axes,
                axes * symmetric(self.spin.map(f64x4::reduce_add)) * to_axes,
            ],
        }
    }
}
