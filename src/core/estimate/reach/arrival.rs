//! An arc's state at an event with all derivatives, for arcs on which parameters act and for bodies
//! with drag or lift: the general form of [`ArcEnd`](super::arc_end).

use nalgebra::{Matrix3, Matrix3x2};

use super::arc_end::ArcEnd;
use crate::estimate::problem::Problem;
use crate::estimate::problem::influence::{Acting, Influence, drag_is_free, lift_is_free};
use crate::estimate::unknowns::point::Point;
use crate::physics::State;
use crate::physics::flow::{
    self, Carried, Fall, Fallen, Flown, FreeFlown, Supported, Turn, TurnByMoments,
};
pub(in crate::estimate) use crate::physics::state::ByStates;
use crate::physics::state::{StateTangent, part};

/// An arc's state at an event.
pub(in crate::estimate) struct GeneralArrival {
    /// The state, and its derivatives by time and by rotations.
    pub(in crate::estimate) end: ArcEnd,
    flown: Flown,
    /// The parameter that holds the friction of what supports the body.
    friction_parameter: Option<usize>,
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
        let body = &problem.body_at(arc, &point.parameters)?;
        let gravity_m_s2 = problem.gravity(&point.parameters);
        let state: &State = &point.arcs[arc];
        if let Some(mut supported) = Supported::new(body, &gravity_m_s2, state) {
            let duration_s = time_s - epoch_s;
            let carried = supported.carried(duration_s);
            return Some(Self {
                end: ArcEnd::carried(&carried, duration_s),
                flown: Flown::Carried(carried),
                friction_parameter: problem.arcs[arc].friction_parameter,
            });
        }
        let end = ArcEnd::new(body, &gravity_m_s2, point, arc, [epoch_s, time_s]);
        let s = end.duration_s;
        let is_moment = |acting: &Acting| matches!(acting.influence, Influence::Moment(_));
        let has_moments = problem.arcs[arc].acting.iter().any(is_moment);
        let fallen = Fall::new(body, &gravity_m_s2, state)
            .with_drag_free(drag_is_free(&problem.arcs[arc].acting))
            .with_lift_free(lift_is_free(&problem.arcs[arc].acting))
            .fallen(s);
        let omega = &state.angular_velocity_rad_s;
        let by_moments = has_moments.then(|| flow::turn_by_moments(body, omega, s));
        Some(Self::of(end, fallen, by_moments))
    }

    /// A state that is itself the unknown, whatever the time: of a held body.
    pub(in crate::estimate) fn given(state: &State) -> Self {
        let fallen = Fallen {
            position_m: state.position_m,
            velocity_m_s: state.velocity_m_s,
            position_by_velocity: Matrix3::zeros(),
            position_by_pull: Matrix3::zeros(),
            position_by_drag: Matrix3x2::zeros(),
            velocity_by_velocity: Matrix3::identity(),
            velocity_by_pull: Matrix3::zeros(),
            velocity_by_drag: Matrix3x2::zeros(),
            by_spinning: None,
        };
        Self::of(ArcEnd::given(state), fallen, None)
    }

    fn of(end: ArcEnd, fallen: Fallen, by_moments: Option<TurnByMoments>) -> Self {
        let turn = Turn {
            orientation: end.state.orientation,
            angular_velocity_rad_s: end.state.angular_velocity_rad_s,
            orientation_by_orientation: end.by_orientation,
            orientation_by_angular_velocity: end.turn_by_spin,
            angular_velocity_by_angular_velocity: end.spin_by_spin,
        };
        Self {
            end,
            flown: Flown::Free(FreeFlown {
                fallen,
                turn,
                by_moments,
            }),
            friction_parameter: None,
        }
    }

    /// The slip with its derivatives, of an arc on a support.
    pub(in crate::estimate) fn carried(&self) -> Option<&Carried> {
        match &self.flown {
            Flown::Free(_) => None,
            Flown::Carried(carried) => Some(carried),
        }
    }

    /// Derivative of a component of the velocity by itself at the epoch.
    pub(in crate::estimate) fn velocity_by_velocity(&self, axis: usize) -> f64 {
        let at = part::VELOCITY + axis;
        self.flown.by_state()[(at, at)]
    }

    /// Whether a parameter is the friction of what supports it: another arc at the same event may have another.
    pub(in crate::estimate) fn is_slowed_by(&self, acting: &Acting) -> bool {
        self.friction_parameter == Some(acting.parameter)
    }

    /// Derivatives by the state at the epoch.
    pub(in crate::estimate) fn by_state(&self) -> ByStates {
        self.flown.by_state()
    }

    /// Derivative by a parameter of the given value that acts on the flight; zero for one that does not.
    pub(in crate::estimate) fn by(&self, influence: Influence, value: f64) -> StateTangent {
        let flown = &self.flown;
        match influence {
            Influence::Pull(axis) => flown.by_pull(axis),
            Influence::SupportFriction => flown.by_friction(),
            Influence::LinearDrag => flown.by_drag(0),
            Influence::QuadraticDrag => flown.by_drag(1),
            Influence::Lift => flown.by_lift(),
            Influence::Moment(axes) => (0..3)
                .filter(|axis| axes[*axis])
                .map(|axis| flown.by_log_moment(axis) / value)
                .sum(),
            _ => StateTangent::zeros(),
        }
    }

    /// The same by one that acts at an event, maybe on another arc.
    pub(in crate::estimate) fn by_acting(&self, acting: &Acting, value: f64) -> StateTangent {
        match acting.influence {
            Influence::SupportFriction if !self.is_slowed_by(acting) => StateTangent::zeros(),
            influence => self.by(influence, value),
        }
    }
}
