//! Residuals of the samples of one arc with their derivatives by everything that they depend on:
//! state, time, and parameters that act on the flight or on what the tracker sees of it.
//!
//! This is the general form of the residuals, for arcs on which such parameters act and for bodies
//! with drag; [`samples`](super::samples) is the short one for all others. Positions are as there.
//! Orientations are seen from the frame of the arc's epoch: the residual `e = R₀ᵀ R_i Log(R_iᵀ R(s))`,
//! a change of `R(s)` by `δ` in that frame changes it by `δ`
//! (see [`TurnTerms`](crate::physics::observe::TurnTerms)).

use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use super::influence::{Acting, Influence, drag_is_free};
use super::modelled::Mount;
use super::problem::{Arc, ArcSample, Problem};
use crate::math::so3;
use crate::physics::flow::{Fall, Spin, SpinByMoments};
use crate::physics::state::{self, part};
use crate::physics::{Body, State};

/// A residual in units: position [world], orientation [frame of the epoch].
type Six = [f64; 6];

/// One residual with its derivatives.
pub(super) struct Observed {
    /// The residual.
    pub(super) residual: Six,
    /// Derivatives by the arc's state.
    pub(super) by_state: [Six; state::DIMENSION],
    /// Derivative by the sample's time [1/s].
    pub(super) by_time: Six,
    /// Derivatives by the acting parameters, in their order.
    pub(super) by_acting: Vec<Six>,
    /// `R₀ᵀ R(s)`, from the body's axes to the frame of the epoch.
    pub(super) turn: UnitQuaternion<f64>,
}

/// The flight of one arc as its tracker sees it.
pub(super) struct Observer<'a> {
    problem: &'a Problem,
    acting: &'a [Acting],
    parameters: &'a [f64],
    state: &'a State,
    epoch_s: f64,
    mount: Mount,
    fall: Fall,
    spin: Spin,
    /// Where a moment is free.
    moments: Option<SpinByMoments>,
    /// Derivatives of the mount's turn by the components of the tracker's rotation vector.
    by_turn: Matrix3<f64>,
}

impl<'a> Observer<'a> {
    /// The flight of an arc of `body` from a state at its epoch.
    pub(super) fn new(
        problem: &'a Problem,
        arc: usize,
        (body, gravity_m_s2): (&Body, &Vector3<f64>),
        (state, epoch_s): (&'a State, f64),
        parameters: &'a [f64],
    ) -> Self {
        let mount = problem.mount_at(arc, parameters);
        let of: &Arc = &problem.arcs[arc];
        let rotation = problem.mounts[of.track].rotation;
        Self {
            problem,
            acting: &of.acting,
            parameters,
            state,
            epoch_s,
            fall: Fall::new(body, gravity_m_s2, state).with_drag_free(drag_is_free(&of.acting)),
            spin: Spin::new(body, &state.angular_velocity_rad_s),
            moments: of
                .acting
                .iter()
                .any(|acting| matches!(acting.influence, Influence::Moment(_)))
                .then(|| SpinByMoments::new(body, &state.angular_velocity_rad_s)),
            by_turn: -(so3::right_jacobian(&mount.turn) * so3::matrix(&rotation)),
            mount,
        }
    }

    /// A sample's physical time \[s\].
    pub(super) fn time_s(&self, sample: &ArcSample, node_times_s: &[f64]) -> f64 {
        let zero_s = node_times_s.first().copied().unwrap_or(0.0);
        self.mount.time_s(sample.time_s(node_times_s), zero_s)
    }

    /// Centre of mass [m, world] and orientation of the flight at a sample's time, and those that
    /// the sample shows.
    pub(super) fn seen(
        &mut self,
        sample: &ArcSample,
        node_times_s: &[f64],
    ) -> [(Vector3<f64>, UnitQuaternion<f64>); 2] {
        let s = self.time_s(sample, node_times_s) - self.epoch_s;
        let flown = (
            self.fall.position(s),
            self.state.orientation * self.spin.turn(s),
        );
        [flown, self.mount.seen(sample)]
    }

    /// The residual of a sample with its derivatives.
    pub(super) fn observed(&mut self, sample: &ArcSample, node_times_s: &[f64]) -> Observed {
        let stamped_s = sample.time_s(node_times_s);
        let s = self.time_s(sample, node_times_s) - self.epoch_s;
        let (position_m, measured) = self.mount.seen(sample);
        let fallen = self.fall.fallen(s);
        let (turn, k) = self.spin.turn_and_derivative(s);
        let to_epoch = self.state.orientation.inverse() * measured;
        let error = so3::log(&(turn * (measured.inverse() * self.state.orientation)));
        let [per_m, per_rad] = [
            self.problem.position_unit_m.recip(),
            self.problem.orientation_unit_rad.recip(),
        ];
        let six = |shift: Vector3<f64>, turn: Vector3<f64>| -> Six {
            let (shift, turn) = (shift * per_m, turn * per_rad);
            [shift.x, shift.y, shift.z, turn.x, turn.y, turn.z]
        };
        let zero = Vector3::zeros();
        let mut by_state = [[0.0; 6]; state::DIMENSION];
        for axis in 0..3 {
            let unit = Vector3::ith(axis, 1.0);
            by_state[part::POSITION + axis] = six(unit, zero);
            by_state[part::ORIENTATION + axis] = six(zero, unit);
            let by_velocity = fallen.position_by_velocity.column(axis).into_owned();
            by_state[part::VELOCITY + axis] = six(by_velocity, zero);
            by_state[part::ANGULAR_VELOCITY + axis] = six(zero, k.column(axis) * s);
        }
        let by_time = six(fallen.velocity_m_s, k * self.state.angular_velocity_rad_s);
        let zero_s = node_times_s.first().copied().unwrap_or(0.0);
        let lever_m = self.mount.to_m;
        let by_acting = self.acting.iter().map(|acting| match acting.influence {
            Influence::Pull(axis) => six(fallen.position_by_pull.column(axis).into_owned(), zero),
            Influence::LinearDrag => six(fallen.position_by_drag.column(0).into_owned(), zero),
            Influence::QuadraticDrag => six(fallen.position_by_drag.column(1).into_owned(), zero),
            Influence::Moment(axes) => {
                let by_moments = self.moments.as_mut().expect("a free moment");
                let by_logarithms = by_moments.at(s).orientation;
                let change: Vector3<f64> = (0..3)
                    .filter(|axis| axes[*axis])
                    .map(|axis| by_logarithms.column(axis).into_owned())
                    .sum();
                six(zero, turn * change / self.parameters[acting.parameter])
            }
            Influence::Centre(axis) => six(-(measured * Vector3::ith(axis, 1.0)), zero),
            Influence::TrackerPosition(axis) => six(measured * Vector3::ith(axis, 1.0), zero),
            Influence::TrackerOrientation(axis) => {
                let change: Vector3<f64> = self.by_turn.column(axis).into();
                six(measured * change.cross(&lever_m), -(to_epoch * change))
            }
            Influence::ClockRate => by_time.map(|by| by * (stamped_s - zero_s)),
            Influence::ClockOffset => by_time,
            Influence::Mass | Influence::SurfaceHeight | Influence::SurfaceTilt(_) => [0.0; 6],
        });
        let by_acting = by_acting.collect();
        Observed {
            residual: six(fallen.position_m - position_m, error),
            by_state,
            by_time,
            by_acting,
            turn,
        }
    }
}
