//! How the residual of a sample follows a change of the flight: in all of its six numbers, or along a pull `u`, which is what
//! `Jᵀu` needs.

use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};

/// A residual in units: position [world], orientation [frame of the epoch].
pub(super) type Six = [f64; 6];

/// What is kept of a change: a column of the derivative.
pub(in crate::estimate) trait Follows {
    /// What it is.
    type Column: Copy;

    /// That of a change of the centre of mass, in the world, and of the rotation, in the frame of the epoch.
    fn flown(&self, shift_m: Vector3<f64>, turn_rad: Vector3<f64>) -> Self::Column;

    /// That of a change of the residual itself, before units.
    fn seen(&self, position_m: Vector3<f64>, turn_rad: Vector3<f64>) -> Self::Column;

    /// A column by a factor.
    fn times(column: Self::Column, by: f64) -> Self::Column;

    /// That of what does not change it.
    fn none(&self) -> Self::Column {
        self.seen(Vector3::zeros(), Vector3::zeros())
    }
}

/// How a residual follows a change of the flight: that of the centre of mass, in the world, and that of
/// the rotation, in the frame of the epoch.
pub(super) struct Following<'w> {
    /// `R₀`.
    pub(super) from_epoch: Matrix3<f64>,
    /// What is seen of a change of the centre of mass.
    pub(super) sees_place: bool,
    /// Of a change of the rotation `δ`, the change of the position, `R₀ (δ × T p)`.
    pub(super) lever_m: Vector3<f64>,
    /// Of a change of the rotation `δ`, the change of the turn: `δ`, `δ × T a` or nothing.
    pub(super) turn: Matrix3<f64>,
    /// From metres and radians to units.
    pub(super) to_units: ToUnits<'w>,
}

pub(super) enum ToUnits<'w> {
    /// Units of positions and of turns.
    Each([f64; 2]),
    /// `L⁻¹`.
    Whitened(&'w Matrix6<f64>),
}

impl Follows for Following<'_> {
    type Column = Six;

    fn flown(&self, shift_m: Vector3<f64>, turn_rad: Vector3<f64>) -> Six {
        let mut position_m = self.from_epoch * turn_rad.cross(&self.lever_m);
        if self.sees_place {
            position_m += shift_m;
        }
        self.seen(position_m, self.turn * turn_rad)
    }

    fn seen(&self, position_m: Vector3<f64>, turn_rad: Vector3<f64>) -> Six {
        match &self.to_units {
            ToUnits::Each([unit_m, unit_rad]) => {
                let (p, r) = (position_m / *unit_m, turn_rad / *unit_rad);
                [p.x, p.y, p.z, r.x, r.y, r.z]
            }
            ToUnits::Whitened(whitening) => {
                let turn = self.from_epoch * turn_rad;
                let both = Vector6::from_iterator(position_m.iter().chain(turn.iter()).copied());
                (*whitening * both).into()
            }
        }
    }

    fn times(column: Six, by: f64) -> Six {
        column.map(|of| of * by)
    }
}

/// How `u · r` follows, with `u` as it is.
pub(super) struct Pulled {
    /// `u · r` by the residual before units: position and turn.
    place_by_m: Vector3<f64>,
    turn_by_rad: Vector3<f64>,
    /// and by the flight: centre of mass and rotation.
    shift_by_m: Vector3<f64>,
    turned_by_rad: Vector3<f64>,
}

impl Pulled {
    pub(super) fn new(following: &Following, pull: &Six) -> Self {
        let from_epoch = &following.from_epoch;
        let [place, turn] = [0, 3].map(|at| Vector3::from_column_slice(&pull[at..at + 3]));
        let (place, turn) = match &following.to_units {
            ToUnits::Each([unit_m, unit_rad]) => (place / *unit_m, turn / *unit_rad),
            ToUnits::Whitened(whitening) => {
                let both = whitening.tr_mul(&Vector6::from_column_slice(pull));
                let turn: Vector3<f64> = both.fixed_rows::<3>(3).into();
                (both.fixed_rows::<3>(0).into(), from_epoch.tr_mul(&turn))
            }
        };
        let lever = following.lever_m.cross(&from_epoch.tr_mul(&place));
        Self {
            place_by_m: place,
            turn_by_rad: turn,
            shift_by_m: place * f64::from(u8::from(following.sees_place)),
            turned_by_rad: lever + following.turn.tr_mul(&turn),
        }
    }
}

impl Follows for Pulled {
    type Column = f64;

    fn flown(&self, shift_m: Vector3<f64>, turn_rad: Vector3<f64>) -> f64 {
        self.shift_by_m.dot(&shift_m) + self.turned_by_rad.dot(&turn_rad)
    }

    fn seen(&self, position_m: Vector3<f64>, turn_rad: Vector3<f64>) -> f64 {
        self.place_by_m.dot(&position_m) + self.turn_by_rad.dot(&turn_rad)
    }

    fn times(column: f64, by: f64) -> f64 {
        column * by
    }
}
