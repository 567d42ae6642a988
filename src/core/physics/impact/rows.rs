//! The contact Jacobian `J`: three rows that map the bodies' velocities to speeds at the contacts,
//! and changes of `J V` and `M⁻¹ Jᵀ p` with the poses.
//!
//! A row of a body is a direction `d` [world] and its lever `l = p × Rᵀd` [m, body] about the
//! centre of mass: the speed of the contact point `p` along `d` is `d·v + l·ω`. Rows of B are
//! negated, so that `J V` are speeds of A's points relative to B's.

use nalgebra::{Matrix3, RowSVector, SMatrix, Vector3};

use super::inertia::InverseInertia;
use super::law::{Side, Velocities};

/// Changes of a vector, one column for each variable.
pub(crate) type Change<const C: usize> = SMatrix<f64, 3, C>;

/// Number of rows; rows of absent contacts are zero.
pub(super) const ROWS: usize = 3;

/// Speeds are those of A relative to B.
const SIGNS: [f64; 2] = [1.0, -1.0];

/// `J` and `M⁻¹`. The static world is a body of infinite mass at rest.
pub(super) struct ImpactRows {
    /// Number of bodies that move: one or two.
    pub(super) bodies: usize,
    directions: [Vector3<f64>; ROWS],
    /// Levers `[body][row]`, those of B negated.
    levers: [[Vector3<f64>; ROWS]; 2],
    /// By body.
    inertia: [InverseInertia; 2],
}

/// Changes `δJ` of the rows.
pub(super) struct RowsChange<const C: usize> {
    /// Changes of the directions; `None` where they are fixed.
    pub(super) directions: Option<[Change<C>; ROWS]>,
    /// Changes of the levers `[body][row]`, those of B negated.
    pub(super) levers: [[Change<C>; ROWS]; 2],
}

impl ImpactRows {
    /// The bodies, with all rows zero.
    pub(super) fn new(a: &Side, b: Option<&Side>) -> Self {
        Self {
            bodies: 1 + usize::from(b.is_some()),
            directions: [Vector3::zeros(); ROWS],
            levers: [[Vector3::zeros(); ROWS]; 2],
            inertia: [
                InverseInertia::of(a),
                b.map_or_else(InverseInertia::default, InverseInertia::of),
            ],
        }
    }

    /// The inertia of A.
    pub(super) fn of_a(&self) -> &InverseInertia {
        &self.inertia[0]
    }

    /// Sets a row; `levers` are those of both bodies, B's not negated.
    pub(super) fn set(&mut self, row: usize, direction: Vector3<f64>, levers: [Vector3<f64>; 2]) {
        self.directions[row] = direction;
        self.levers[0][row] = levers[0];
        self.levers[1][row] = -levers[1];
    }

    /// `J V` [m/s].
    pub(super) fn speeds(&self, motion: &[Velocities; 2]) -> Vector3<f64> {
        let relative = motion[0].velocity_m_s - motion[1].velocity_m_s;
        Vector3::from_fn(|row, _| {
            self.directions[row].dot(&relative)
                + self.levers[0][row].dot(&motion[0].angular_velocity_rad_s)
                + self.levers[1][row].dot(&motion[1].angular_velocity_rad_s)
        })
    }

    /// The columns of `J` for `v` and `ω` of one body.
    pub(super) fn of_body(&self, body: usize) -> SMatrix<f64, ROWS, 6> {
        let mut result = SMatrix::<f64, ROWS, 6>::zeros();
        for row in 0..ROWS {
            result
                .fixed_view_mut::<1, 3>(row, 0)
                .tr_copy_from(&(self.directions[row] * SIGNS[body]));
            result
                .fixed_view_mut::<1, 3>(row, 3)
                .tr_copy_from(&self.levers[body][row]);
        }
        result
    }

    /// Delassus' operator `W = J M⁻¹ Jᵀ` [1/kg].
    pub(super) fn delassus(&self) -> Matrix3<f64> {
        let mut result = Matrix3::zeros();
        for row in 0..ROWS {
            let impulse = Vector3::ith(row, 1.0);
            result.set_column(row, &self.speeds(&self.velocity_changes(&impulse)));
        }
        result
    }

    /// `M⁻¹ Jᵀ p`: changes of the velocities by impulses `p` along the rows [N s].
    pub(super) fn velocity_changes(&self, impulses: &Vector3<f64>) -> [Velocities; 2] {
        let sum = |rows: &[Vector3<f64>; ROWS]| {
            rows[0] * impulses[0] + rows[1] * impulses[1] + rows[2] * impulses[2]
        };
        let push = sum(&self.directions);
        [0, 1].map(|body| Velocities {
            velocity_m_s: self.inertia[body].velocity_changes(&(push * SIGNS[body])),
            angular_velocity_rad_s: self.inertia[body].spin_change(&sum(&self.levers[body])),
        })
    }

    /// `δJ V`.
    pub(super) fn speeds_change<const C: usize>(
        &self,
        motion: &[Velocities; 2],
        by: &RowsChange<C>,
    ) -> Change<C> {
        let relative = motion[0].velocity_m_s - motion[1].velocity_m_s;
        let mut result = Change::<C>::zeros();
        for row in 0..ROWS {
            let mut speeds = RowSVector::<f64, C>::zeros();
            for body in 0..self.bodies {
                speeds += motion[body]
                    .angular_velocity_rad_s
                    .tr_mul(&by.levers[body][row]);
            }
            if let Some(directions) = &by.directions {
                speeds += relative.tr_mul(&directions[row]);
            }
            result.set_row(row, &speeds);
        }
        result
    }

    /// `δ(J M⁻¹ Jᵀ) p = δJ (M⁻¹ Jᵀ p) + J M⁻¹ (δJᵀ p)`.
    pub(super) fn delassus_change<const C: usize>(
        &self,
        impulses: &Vector3<f64>,
        by: &RowsChange<C>,
    ) -> Change<C> {
        let mut result = self.speeds_change(&self.velocity_changes(impulses), by);
        let velocity_changes = self.velocity_changes_by(impulses, None, by);
        for body in 0..self.bodies {
            result += self.of_body(body) * velocity_changes[body];
        }
        result
    }

    /// `M⁻¹ (δJᵀ p + Jᵀ δp)`, the second term where the impulses change too: rows `v`, `ω` of each
    /// body, zero for the world.
    pub(super) fn velocity_changes_by<const C: usize>(
        &self,
        impulses: &Vector3<f64>,
        change: Option<&Change<C>>,
        by: &RowsChange<C>,
    ) -> [SMatrix<f64, 6, C>; 2] {
        let turned = |rows: &[Change<C>; ROWS]| {
            rows[0] * impulses[0] + rows[1] * impulses[1] + rows[2] * impulses[2]
        };
        let mut result = change.map_or_else(
            || [SMatrix::zeros(); 2],
            |c| self.velocity_changes_by_impulses(c),
        );
        let push = by.directions.as_ref().map(turned);
        for body in 0..self.bodies {
            if let Some(push) = &push {
                let mut velocity = result[body].fixed_rows_mut::<3>(0);
                velocity += self.inertia[body].velocity_changes(&(push * SIGNS[body]));
            }
            let mut spin = result[body].fixed_rows_mut::<3>(3);
            spin += self.inertia[body].spin_changes(turned(&by.levers[body]));
        }
        result
    }

    /// `δ(M⁻¹) Jᵀ p` of one body by `ln` of its mass and of its three moments: rows `v`, `ω`.
    pub(super) fn velocity_changes_by_inertia(
        &self,
        body: usize,
        impulses: &Vector3<f64>,
    ) -> SMatrix<f64, 6, 4> {
        let changes = &self.velocity_changes(impulses)[body];
        let mut result = SMatrix::<f64, 6, 4>::zeros();
        result
            .fixed_view_mut::<3, 1>(0, 0)
            .copy_from(&-changes.velocity_m_s);
        for axis in 0..3 {
            result[(3 + axis, 1 + axis)] = -changes.angular_velocity_rad_s[axis];
        }
        result
    }

    /// `M⁻¹ Jᵀ δp`.
    pub(super) fn velocity_changes_by_impulses<const C: usize>(
        &self,
        change: &SMatrix<f64, ROWS, C>,
    ) -> [SMatrix<f64, 6, C>; 2] {
        let mut result = [SMatrix::<f64, 6, C>::zeros(); 2];
        let push = Matrix3::from_columns(&self.directions) * change;
        for body in 0..self.bodies {
            let inertia = &self.inertia[body];
            let velocities = inertia.velocity_changes(&(push * SIGNS[body]));
            let spins = self.levers[body].map(|lever| inertia.spin_change(&lever));
            let spins = Matrix3::from_columns(&spins) * change;
            result[body].fixed_rows_mut::<3>(0).copy_from(&velocities);
            result[body].fixed_rows_mut::<3>(3).copy_from(&spins);
        }
        result
    }
}
