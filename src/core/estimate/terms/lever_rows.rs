//! What four samples tell of a flight, by their kind ([`Rows`]).
//!
//! With `q = R p` of a point `p`, or `R a` of an axis, all in world axes:
//!
//! ```text
//! point        e = x + q − p_i,         changes by ξ + φ × q
//! direction    e = q − a_i, a chord,    changes by φ × q
//! covariance   e = (x + q − p_i, Log(R R_i⁻¹)),  by (ξ + φ × q, J_l⁻¹ φ), weighed by (L Lᵀ)⁻¹
//! ```

use nalgebra::{Matrix6, Vector3};
use wide::f64x4;

use super::levered::{Four, Rows};
use crate::math::lanes::{SYMMETRIC, Vectors};
use crate::physics::observe::lanes::turn_errors;

/// Points or directions, all with one weight.
pub(in crate::estimate) struct Lever<const IS_POINT: bool> {
    /// Of a residual's square.
    weight: f64x4,
    /// `q`
    lever: Vectors,
    /// `e`
    off: Vectors,
}

impl Lever<true> {
    /// Points `p` \[m\] on the body, with a weight per square metre.
    #[inline]
    pub(in crate::estimate) fn point(four: &Four, point_m: &Vector3<f64>, weight: f64) -> Self {
        let lever = Vectors::splat(point_m).rotated(four.turned.orientation);
        let seen = Vectors::of(four.samples.map(|sample| &sample.position_m));
        Self {
            weight: four.weight * weight,
            off: four.place_m.plus(&lever).minus(&seen),
            lever,
        }
    }
}

impl Lever<false> {
    /// Directions of an axis `a` of the body, with a weight per squared chord.
    #[inline]
    pub(in crate::estimate) fn direction(four: &Four, axis: &Vector3<f64>, weight: f64) -> Self {
        let axis = Vectors::splat(axis);
        let lever = axis.rotated(four.turned.orientation);
        Self {
            weight: four.weight * weight,
            off: lever.minus(&axis.rotated(measured(four))),
            lever,
        }
    }
}

impl<const IS_POINT: bool> Lever<IS_POINT> {
    /// What a pull at the lever's end is for the centre of mass, and as a torque.
    #[inline]
    fn pulls(&self, pull: Vectors) -> [Vectors; 2] {
        let on_place = if IS_POINT { pull } else { Vectors::default() };
        [on_place, self.lever.cross(&pull)]
    }
}

/// The samples' orientations as `(i, j, k, w)`.
#[inline]
fn measured(four: &Four) -> [f64x4; 4] {
    [0, 1, 2, 3].map(|part| f64x4::from(four.samples.map(|sample| sample.orientation[part])))
}

impl<const IS_POINT: bool> Rows for Lever<IS_POINT> {
    const PLACES: usize = IS_POINT as usize;
    const IS_COUPLED: bool = IS_POINT;

    #[inline]
    fn cost(&self) -> f64x4 {
        self.off.dot(&self.off) * self.weight * 0.5
    }

    #[inline]
    fn gradient(&self) -> [Vectors; 2] {
        self.pulls(self.off.times(self.weight))
    }

    #[inline]
    fn places(&self) -> [f64x4; 6] {
        let zero = f64x4::ZERO;
        [self.weight, zero, self.weight, zero, zero, self.weight]
    }

    /// `−[q]×`
    #[inline]
    fn mixed(&self) -> [Vectors; 3] {
        let [x, y, z] = self.lever.times(self.weight).0;
        let zero = f64x4::ZERO;
        [
            Vectors([zero, -z, y]),
            Vectors([z, zero, -x]),
            Vectors([-y, x, zero]),
        ]
    }

    /// `[q]×ᵀ[q]× = |q|² 1 − q qᵀ`
    #[inline]
    fn turns(&self) -> [f64x4; 6] {
        let weighed = self.lever.times(self.weight).0;
        let square = [0, 1, 2].map(|axis| weighed[axis] * self.lever.0[axis]);
        SYMMETRIC.map(|(row, column)| {
            if row == column {
                square[(row + 1) % 3] + square[(row + 2) % 3]
            } else {
                -(weighed[row] * self.lever.0[column])
            }
        })
    }

    #[inline]
    fn pull_of_turn(&self, turn: &Vectors) -> [Vectors; 2] {
        self.pulls(turn.cross(&self.lever).times(self.weight))
    }

    #[inline]
    fn pull(&self, place: &Vectors, turn: &Vectors) -> [Vectors; 2] {
        let swung = turn.cross(&self.lever);
        let moved = if IS_POINT { swung.plus(place) } else { swung };
        self.pulls(moved.times(self.weight))
    }
}

/// Samples with covariances, of places and turns together or apart.
pub(in crate::estimate) struct Weighed<const IS_COUPLED: bool> {
    cost: f64x4,
    gradient: [Vectors; 2],
    places: [f64x4; 6],
    mixed: [Vectors; 3],
    /// By turns, the columns.
    turns: [Vectors; 3],
}

impl<const IS_COUPLED: bool> Weighed<IS_COUPLED> {
    /// With `(L Lᵀ)⁻¹` of every sample; of a tracker mounted at a place on the body, seen from the centre
    /// of mass \[m\], `seen_m` from where the samples say the centre of mass is.
    #[inline]
    pub(in crate::estimate) fn new(
        four: &Four,
        informations: &[Matrix6<f64>],
        mount_m: &Vector3<f64>,
        seen_m: &Vector3<f64>,
    ) -> Self {
        let weights = four.indices.map(|index| &informations[index]);
        let entry = |row: usize, column: usize| {
            f64x4::from(weights.map(|of| of[(row, column)])) * four.weight
        };
        let places = SYMMETRIC.map(|(row, column)| entry(row, column));
        let turns = SYMMETRIC.map(|(row, column)| entry(3 + row, 3 + column));
        let measured = measured(four);
        let (error, by_turn) = turn_errors(four.turned.orientation, measured);
        let seen = Vectors::of(four.samples.map(|sample| &sample.position_m));
        let mut off = four.place_m.minus(&seen);
        if !IS_COUPLED {
            let pull = through(&places, &off);
            let twist = through(&turns, &error);
            return Self {
                cost: (off.dot(&pull) + error.dot(&twist)) * 0.5,
                gradient: [pull, twist.along(&by_turn)],
                places,
                mixed: Default::default(),
                turns: by_turn
                    .each_ref()
                    .map(|of| through(&turns, of).along(&by_turn)),
            };
        }
        let lever = Vectors::splat(mount_m).rotated(four.turned.orientation);
        off = off
            .plus(&lever)
            .minus(&Vectors::splat(seen_m).rotated(measured));
        // The columns by turns and rows by places.
        let between = [0, 1, 2].map(|turn| Vectors([0, 1, 2].map(|row| entry(row, 3 + turn))));
        let weigh = |place: &Vectors, turn: &Vectors| {
            let pull = through(&places, place).plus(&Vectors::combined(&between, turn));
            let twist = through(&turns, turn).plus(&place.along(&between));
            [pull, lever.cross(&pull).plus(&twist.along(&by_turn)), twist]
        };
        let [pull, torque, twist] = weigh(&off, &error);
        let [x, y, z] = lever.0;
        let zero = f64x4::ZERO;
        let swung = [
            Vectors([zero, -z, y]),
            Vectors([z, zero, -x]),
            Vectors([-y, x, zero]),
        ];
        let columns = [0, 1, 2].map(|axis| weigh(&swung[axis], &by_turn[axis]));
        Self {
            cost: (off.dot(&pull) + error.dot(&twist)) * 0.5,
            gradient: [pull, torque],
            places,
            mixed: columns.map(|[pull, ..]| pull),
            turns: columns.map(|[_, torque, _]| torque),
        }
    }
}

/// A symmetric matrix times a vector.
#[inline]
fn through(entries: &[f64x4; 6], vector: &Vectors) -> Vectors {
    let [a, b, c, d, e, f] = *entries;
    let [x, y, z] = vector.0;
    Vectors([
        a * x + b * y + d * z,
        b * x + c * y + e * z,
        d * x + e * y + f * z,
    ])
}

impl<const IS_COUPLED: bool> Rows for Weighed<IS_COUPLED> {
    const PLACES: usize = 6;
    const IS_COUPLED: bool = IS_COUPLED;

    #[inline]
    fn cost(&self) -> f64x4 {
        self.cost
    }

    #[inline]
    fn gradient(&self) -> [Vectors; 2] {
        self.gradient
    }

    #[inline]
    fn places(&self) -> [f64x4; 6] {
        self.places
    }

    #[inline]
    fn mixed(&self) -> [Vectors; 3] {
        self.mixed
    }

    #[inline]
    fn turns(&self) -> [f64x4; 6] {
        SYMMETRIC.map(|(row, column)| self.turns[column].0[row])
    }

    #[inline]
    fn pull_of_turn(&self, turn: &Vectors) -> [Vectors; 2] {
        let on_place = if IS_COUPLED {
            Vectors::combined(&self.mixed, turn)
        } else {
            Vectors::default()
        };
        [on_place, Vectors::combined(&self.turns, turn)]
    }

    #[inline]
    fn pull(&self, place: &Vectors, turn: &Vectors) -> [Vectors; 2] {
        let [mut pull, mut twist] = self.pull_of_turn(turn);
        pull = pull.plus(&through(&self.places, place));
        if IS_COUPLED {
            twist = twist.plus(&place.along(&self.mixed));
        }
        [pull, twist]
    }
}

/// Whether places and turns are apart in all of them.
pub(in crate::estimate) fn are_apart(informations: &[Matrix6<f64>]) -> bool {
    let mut all = informations.iter();
    all.all(|of| {
        of.fixed_view::<3, 3>(0, 3)
            .iter()
            .all(|entry| *entry == 0.0)
    })
}
