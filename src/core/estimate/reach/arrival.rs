//! An arc's state at an event with all derivatives, for arcs on which parameters act and for bodies
//! with drag: the general form of [`ArcEnd`](super::arc_end).

use nalgebra::{Matrix3, Matrix3x2, SMatrix};

use super::arc_end::ArcEnd;
use crate::estimate::problem::Problem;
use crate::estimate::problem::influence::{Acting, Influence, drag_is_free};
use crate::estimate::unknowns::point::Point;
use crate::physics::State;
use crate::physics::flow::{self, Fall, Fallen};
use crate::physics::state::{StateTangent, part};

/// Derivatives of a state by a state.
pub(in crate::estimate) type ByStates = SMatrix<f64, 12, 12>;

/// An arc's state at an event.
pub(in crate::estimate) struct GeneralArrival {
    /// The state, and its derivatives by time and by rotations.
    pub(in crate::estimate) end: ArcEnd,
    fallen: Fallen,
    /// Derivatives of orientation and angular velocity by the logarithms of the moments.
    by_moments: [Matrix3<f64>; 2],
}

impl GeneralArrival {
    /// The state of an arc at a time; `None` where no body has such moments.
    pub(in crate::estimate) fn new(
        problem: &Problem,
        point: &Point,
        arc: usize,
        epoch_s: f64,
        time_s: f64,
    ) -> Option<Self> {
        let bodies = problem.bodies_at(&point.parameters)?;
        let body = &bodies[problem.arcs[arc].mechanism];
        let gravity_m_s2 = problem.gravity(&point.parameters);
        let state: &State = &point.arcs[arc];
        let end = ArcEnd::new(body, &gravity_m_s2, state, epoch_s, time_s);
        let s = end.duration_s;
        let is_moment = |acting: &&Acting| matches!(acting.influence, Influence::Moment(_));
        let by_moments = match problem.arcs[arc].acting.iter().find(is_moment) {
            Some(_) => {
                let by = flow::turn_by_moments(body, &state.angular_velocity_rad_s, s);
                [by.orientation, by.angular_velocity]
            }
            None => [Matrix3::zeros(); 2],
        };
        Some(Self {
            fallen: Fall::new(body, &gravity_m_s2, state)
                .with_drag_free(drag_is_free(&problem.arcs[arc].acting))
                .fallen(s),
            by_moments,
            end,
        })
    }

    /// A state that is itself the unknown, whatever the time: of a held body.
    pub(in crate::estimate) fn given(state: &State) -> Self {
        Self {
            end: ArcEnd::given(state),
            fallen: Fallen {
                position_m: state.position_m,
                velocity_m_s: state.velocity_m_s,
                position_by_velocity: Matrix3::zeros(),
                position_by_pull: Matrix3::zeros(),
                position_by_drag: Matrix3x2::zeros(),
                velocity_by_velocity: Matrix3::identity(),
                velocity_by_pull: Matrix3::zeros(),
                velocity_by_drag: Matrix3x2::zeros(),
            },
            by_moments: [Matrix3::zeros(); 2],
        }
    }

    /// Derivative of a component of the velocity by itself at the epoch.
    pub(in crate::estimate) fn velocity_by_velocity(&self, axis: usize) -> f64 {
        self.fallen.velocity_by_velocity[(axis, axis)]
    }

    /// Derivatives by the state at the epoch.
    pub(in crate::estimate) fn by_state(&self) -> ByStates {
        let mut by = ByStates::identity();
        let mut set = |row: usize, column: usize, block: &Matrix3<f64>| {
            by.fixed_view_mut::<3, 3>(row, column).copy_from(block);
        };
        set(
            part::POSITION,
            part::VELOCITY,
            &self.fallen.position_by_velocity,
        );
        set(
            part::VELOCITY,
            part::VELOCITY,
            &self.fallen.velocity_by_velocity,
        );
        set(
            part::ORIENTATION,
            part::ORIENTATION,
            &self.end.by_orientation,
        );
        set(
            part::ORIENTATION,
            part::ANGULAR_VELOCITY,
            &self.end.turn_by_spin,
        );
        set(
            part::ANGULAR_VELOCITY,
            part::ANGULAR_VELOCITY,
            &self.end.spin_by_spin,
        );
        by
    }

    /// Derivative by a parameter of the given value that acts on the flight; zero for one that does not.
    pub(in crate::estimate) fn by(&self, influence: Influence, value: f64) -> StateTangent {
        let mut by = StateTangent::zeros();
        let mut set = |at: usize, column: nalgebra::Vector3<f64>| {
            by.fixed_rows_mut::<3>(at).copy_from(&column);
        };
        let fallen = &self.fallen;
        match influence {
            Influence::Pull(axis) => {
                set(part::POSITION, fallen.position_by_pull.column(axis).into());
                set(part::VELOCITY, fallen.velocity_by_pull.column(axis).into());
            }
            Influence::LinearDrag | Influence::QuadraticDrag => {
                let column = usize::from(influence == Influence::QuadraticDrag);
                set(
                    part::POSITION,
                    fallen.position_by_drag.column(column).into(),
                );
                set(
                    part::VELOCITY,
                    fallen.velocity_by_drag.column(column).into(),
                );
            }
            Influence::Moment(axes) => {
                for axis in (0..3).filter(|axis| axes[*axis]) {
                    let [turn, spin] = self.by_moments.map(|by| by.column(axis) / value);
                    let mut part = by.fixed_rows_mut::<3>(part::ORIENTATION);
                    part += turn;
                    let mut part = by.fixed_rows_mut::<3>(part::ANGULAR_VELOCITY);
                    part += spin;
                }
            }
            _ => {}
        }
        by
    }
}
