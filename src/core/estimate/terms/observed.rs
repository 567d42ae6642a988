//! Residuals of the samples of one view with their derivatives by everything that they depend on:
//! state, time, and parameters that act on the flight or on what the tracker sees of it.
//!
//! This is the general form of the residuals, for arcs on which such parameters act and for bodies with
//! drag or lift; [`samples`](super::samples) and [`levered`](super::levered) are the short ones for all others. In the frame of the arc's epoch, in which `T(s) = R₀ᵀ R(s)`,
//!
//! ```text
//! position      x(s) − x_i                       [world]     changed by δx
//! point         x(s) + R(s) p − p_i              [world]     R₀ (δ × T p)
//! orientation   R₀ᵀ R_i Log(R_iᵀ R(s))           [epoch]     δ
//! direction     T(s) a − R₀ᵀ a_i, a chord        [epoch]     δ × T a
//! ```
//!
//! where a change of `R(s)` by `δ` in that frame changes them by the last column
//! (see [`TurnTerms`](crate::physics::observe::TurnTerms)).
//!
//! A sample with the covariance `L Lᵀ` of the tracker's place and rotation vector in world axes has the
//! residual `L⁻¹ (p, R₀ e)`, the position being that of the tracker; the logarithm `e` then changes by
//! `J_l⁻¹(e) δ`.

use nalgebra::{Matrix3, Vector3};

use super::following::{Following, Follows, Pulled, Six, ToUnits};
use super::modelled::Mount;
use crate::estimate::problem::influence::{Acting, Influence, drag_is_free, lift_is_free};
use crate::estimate::problem::{Problem, Shows, View};
use crate::estimate::unknowns::kept::KeptSpin;
use crate::estimate::unknowns::point::Point;
use crate::math::so3;
use crate::physics::flow::{Carried, Fall, FallenBySpinning, SpinByMoments, Supported};
use crate::physics::state::{self, StateTangent, part};
use crate::physics::{Body, State};

/// One residual with its derivatives, or with those of its product with a pull.
pub(in crate::estimate) struct Observed<C = Six> {
    /// The residual.
    pub(in crate::estimate) residual: Six,
    /// Derivatives by the arc's state.
    pub(in crate::estimate) by_state: [C; state::DIMENSION],
    /// Derivative by the sample's time [1/s].
    pub(in crate::estimate) by_time: C,
    /// Derivatives by the acting parameters, in their order.
    pub(in crate::estimate) by_acting: Vec<C>,
}

/// The flight of one arc as its tracker sees it.
pub(in crate::estimate) struct SampleObserver<'a> {
    view: &'a View,
    acting: &'a [Acting],
    parameters: &'a [f64],
    state: &'a State,
    epoch_s: f64,
    mount: Mount,
    fall: Fall,
    turning: KeptSpin<'a>,
    /// On a support, in place of fall and turning.
    supported: Option<Supported>,
    /// Where a moment is free.
    moments: Option<SpinByMoments>,
    /// Derivatives of the mount's turn by the components of the tracker's rotation vector.
    by_turn: Matrix3<f64>,
    /// Whether turns are in the body's axes, with all of their derivative, and not in the frame of the epoch.
    is_in_body: bool,
}

impl<'a> SampleObserver<'a> {
    /// The flight of an arc of `body`, as a view sees it, where unknowns have the values of a point.
    pub(in crate::estimate) fn new(
        problem: &'a Problem,
        (arc, view): (usize, &'a View),
        (body, gravity_m_s2): (&Body, &Vector3<f64>),
        epoch_s: f64,
        point: &'a Point,
    ) -> Self {
        let (state, parameters) = (&point.arcs[arc], point.parameters.as_slice());
        let mount = problem.mount_at(arc, view.track, parameters);
        let acting = &problem.arcs[arc].acting;
        let rotation = problem.mounts[view.track].rotation;
        Self {
            view,
            acting,
            parameters,
            state,
            epoch_s,
            fall: Fall::new(body, gravity_m_s2, state)
                .with_drag_free(drag_is_free(acting))
                .with_lift_free(lift_is_free(acting)),
            turning: point.kept.spin(body, &state.angular_velocity_rad_s),
            supported: Supported::new(body, gravity_m_s2, state),
            moments: acting
                .iter()
                .any(|acting| matches!(acting.influence, Influence::Moment(_)))
                .then(|| SpinByMoments::new(body, &state.angular_velocity_rad_s)),
            by_turn: -(so3::right_jacobian(&mount.turn) * so3::matrix(&rotation)),
            mount,
            is_in_body: false,
        }
    }

    /// The same with turns in the body's axes, which go on from flight to flight, and other acting parameters. Samples have
    /// no covariances of their own.
    pub(in crate::estimate) fn in_body_axes(mut self, acting: &'a [Acting]) -> Self {
        debug_assert!(self.view.whitenings.is_empty());
        self.acting = acting;
        self.is_in_body = true;
        self
    }

    /// A sample's physical time \[s\].
    pub(in crate::estimate) fn time_s(&self, sample: usize, node_times_s: &[f64]) -> f64 {
        let zero_s = node_times_s.first().copied().unwrap_or(0.0);
        self.mount
            .time_s(self.stamped_s(sample, node_times_s), zero_s)
    }

    /// A sample's time before the clock's correction \[s\].
    fn stamped_s(&self, sample: usize, node_times_s: &[f64]) -> f64 {
        let of = &self.view.samples[sample];
        of.stamped_s(node_times_s, self.parameters)
    }

    /// By how much the flight is off what a sample shows: of positions \[m, world\], and of
    /// orientations as a rotation vector or of directions as a chord \[rad, body\].
    pub(in crate::estimate) fn off(
        &mut self,
        sample: usize,
        node_times_s: &[f64],
    ) -> [Vector3<f64>; 2] {
        let s = self.time_s(sample, node_times_s) - self.epoch_s;
        let (place_m, orientation) = match &mut self.supported {
            Some(supported) => {
                let state = supported.at(s);
                (state.position_m, state.orientation)
            }
            None => {
                let turn = self.turning.spin.turn(s);
                (self.fall.position(s), self.state.orientation * turn)
            }
        };
        let of = &self.view.samples[sample];
        let (centre_m, measured) = self.mount.seen(of);
        let mut off = [Vector3::zeros(); 2];
        match self.view.shows {
            Shows::Pose => {
                off[0] = place_m - centre_m;
                off[1] = so3::log(&(measured.inverse() * orientation));
            }
            Shows::Point => off[0] = place_m + orientation * self.mount.to_m - of.position_m,
            Shows::Orientation => off[1] = so3::log(&(measured.inverse() * orientation)),
            Shows::Direction(axis) => {
                off[1] = axis - orientation.inverse() * (of.orientation * axis);
            }
        }
        off
    }

    /// [`SampleObserver::off`] in units, with whitening where samples have covariances.
    pub(in crate::estimate) fn residual(&mut self, sample: usize, node_times_s: &[f64]) -> Six {
        if !self.view.whitenings.is_empty() {
            return self.observed(sample, node_times_s).residual;
        }
        let [unit_m, unit_rad] = self.view.units;
        let [shift, turn] = self.off(sample, node_times_s);
        let (shift, turn) = (shift / unit_m, turn / unit_rad);
        [shift.x, shift.y, shift.z, turn.x, turn.y, turn.z]
    }

    /// The residual of a sample with its derivatives.
    pub(in crate::estimate) fn observed(
        &mut self,
        sample: usize,
        node_times_s: &[f64],
    ) -> Observed {
        self.observed_in(sample, node_times_s, Vec::new())
    }

    /// [`SampleObserver::observed`] with memory for the derivatives by acting parameters.
    pub(in crate::estimate) fn observed_in(
        &mut self,
        sample: usize,
        node_times_s: &[f64],
        memory: Vec<Six>,
    ) -> Observed {
        self.followed(sample, node_times_s, memory, |following, _| following)
    }

    /// The residual of a sample with the derivatives of its product with a pull, by default with itself, which stays as it is.
    pub(in crate::estimate) fn pulled_in(
        &mut self,
        sample: usize,
        node_times_s: &[f64],
        memory: Vec<f64>,
        pull: Option<&Six>,
    ) -> Observed<f64> {
        self.followed(sample, node_times_s, memory, |following, residual| {
            Pulled::new(&following, pull.unwrap_or(residual))
        })
    }

    fn followed<F: Follows>(
        &mut self,
        sample: usize,
        node_times_s: &[f64],
        mut memory: Vec<F::Column>,
        how: impl FnOnce(Following<'a>, &Six) -> F,
    ) -> Observed<F::Column> {
        let of = &self.view.samples[sample];
        let stamped_s = self.stamped_s(sample, node_times_s);
        let s = self.time_s(sample, node_times_s) - self.epoch_s;
        let (centre_m, measured) = self.mount.seen(of);
        let carried = self.supported.as_mut().map(|of| of.carried(s));
        let fallen = self.fall.fallen(s);
        let (turn, k) = match &carried {
            Some(carried) => (
                self.state.orientation.inverse() * carried.state.orientation,
                Matrix3::zeros(),
            ),
            None => self.turning.spin.turn_and_derivative(s),
        };
        let position_m = carried.map_or(fallen.position_m, |of| of.state.position_m);
        let to_epoch = self.state.orientation.inverse() * measured;
        let whitening = self.view.whitenings.get(sample);
        let [sees_place, sees_turn] = self.view.kinds();
        // Where a covariance is that of the tracker's place, so is the residual.
        let is_of_tracker = self.view.shows == Shows::Point || sees_place && whitening.is_some();
        // The axis whose direction is seen, flown and shown.
        let axis = match self.view.shows {
            Shows::Direction(axis) => Some([
                turn * axis,
                self.state.orientation.inverse() * (of.orientation * axis),
            ]),
            _ => None,
        };
        let lever_m = if is_of_tracker {
            turn * self.mount.to_m
        } else {
            Vector3::zeros()
        };
        let error = match axis {
            Some([flown, shown]) if self.is_in_body => turn.inverse() * (flown - shown),
            Some([flown, shown]) => flown - shown,
            None if sees_turn && self.is_in_body => {
                so3::log(&(measured.inverse() * self.state.orientation * turn))
            }
            None if sees_turn => so3::log(&(turn * (measured.inverse() * self.state.orientation))),
            None => Vector3::zeros(),
        };
        let following = Following {
            from_epoch: so3::matrix(&self.state.orientation),
            sees_place,
            lever_m,
            turn: match axis {
                Some([_, shown]) if self.is_in_body => {
                    let to_body = turn.inverse();
                    -so3::hat(&(to_body * shown)) * so3::matrix(&to_body)
                }
                None if sees_turn && self.is_in_body => {
                    so3::right_jacobian_inverse(&error) * so3::matrix(&turn.inverse())
                }
                Some([flown, _]) => -so3::hat(&flown),
                // Equal weights in all directions see no difference, `J_l⁻¹(e)ᵀ e = e`.
                None if sees_turn && whitening.is_some() => {
                    so3::right_jacobian_inverse(&error).transpose()
                }
                None if sees_turn => Matrix3::identity(),
                None => Matrix3::zeros(),
            },
            to_units: match whitening {
                Some(whitening) => ToUnits::Whitened(whitening),
                None => ToUnits::Each(self.view.units),
            },
        };
        let zero = Vector3::zeros();
        let shift_m = match () {
            () if is_of_tracker => {
                let seen_m = match self.view.shows {
                    Shows::Point => of.position_m,
                    _ => of.position_m + of.orientation * self.mount.from_m,
                };
                position_m + following.from_epoch * lever_m - seen_m
            }
            () if sees_place => position_m - centre_m,
            () => zero,
        };
        let residual = following.seen(shift_m, error);
        let turned_by = following.turn;
        let following = how(following, &residual);
        let mut by_state = [following.none(); state::DIMENSION];
        for axis in 0..3 {
            let unit = Vector3::ith(axis, 1.0);
            by_state[part::POSITION + axis] = following.flown(unit, zero);
            let spinning = fallen.by_spinning.as_ref();
            let lifted = |of: &dyn Fn(&FallenBySpinning) -> Matrix3<f64>| {
                spinning.map_or(zero, |spinning| of(spinning).column(axis).into_owned())
            };
            let by_turn = lifted(&|of| of.by_orientation[0]);
            by_state[part::ORIENTATION + axis] = following.flown(by_turn, unit);
            let by_velocity = fallen.position_by_velocity.column(axis).into_owned();
            by_state[part::VELOCITY + axis] = following.flown(by_velocity, zero);
            let by_spin = lifted(&|of| of.by_angular_velocity[0]);
            by_state[part::ANGULAR_VELOCITY + axis] = following.flown(by_spin, k.column(axis) * s);
        }
        // Changes on a support as those of place and turn.
        let seen = |by: &StateTangent| {
            let shift_m = by.fixed_rows::<3>(part::POSITION).into_owned();
            let turned: Vector3<f64> = by.fixed_rows::<3>(part::ORIENTATION).into();
            following.flown(shift_m, turn * turned)
        };
        if let Some(carried) = &carried {
            for (at, by) in by_state.iter_mut().enumerate() {
                *by = seen(&carried.by_state.column(at).into_owned());
            }
        }
        let on_support =
            |of: &dyn Fn(&Carried) -> StateTangent| carried.as_ref().map(|c| seen(&of(c)));
        let by_time = following.flown(fallen.velocity_m_s, k * self.state.angular_velocity_rad_s);
        let by_time = on_support(&|of| of.rate).unwrap_or(by_time);
        let zero_s = node_times_s.first().copied().unwrap_or(0.0);
        let mount_m = self.mount.to_m;
        let flown = self.state.orientation * turn;
        let track = self.view.track;
        let by_acting = self.acting.iter().map(|acting| {
            if !acting.is_on(track) {
                return following.none();
            }
            // The place on the body that is seen, moved by a unit along an axis of the link.
            let moved = |axis: usize, by: f64| {
                let unit = Vector3::ith(axis, by);
                let shift = if is_of_tracker {
                    flown * unit
                } else {
                    measured * unit
                };
                following.seen(if sees_place { shift } else { zero }, zero)
            };
            match acting.influence {
                Influence::Pull(axis) => on_support(&|of| of.by_pull[axis]).unwrap_or_else(|| {
                    following.flown(fallen.position_by_pull.column(axis).into_owned(), zero)
                }),
                Influence::SupportFriction => {
                    on_support(&|of| of.by_friction).unwrap_or(following.none())
                }
                Influence::LinearDrag => {
                    following.flown(fallen.position_by_drag.column(0).into_owned(), zero)
                }
                Influence::QuadraticDrag => {
                    following.flown(fallen.position_by_drag.column(1).into_owned(), zero)
                }
                Influence::Lift => {
                    let by_lift = fallen.by_spinning.map_or(zero, |of| of.by_lift[0]);
                    following.flown(by_lift, zero)
                }
                Influence::Moment(axes) => {
                    let by_moments = self.moments.as_mut().expect("a free moment");
                    let by_logarithms = by_moments.at(s).orientation;
                    let change: Vector3<f64> = (0..3)
                        .filter(|axis| axes[*axis])
                        .map(|axis| by_logarithms.column(axis).into_owned())
                        .sum();
                    following.flown(zero, turn * change / self.parameters[acting.parameter])
                }
                Influence::Centre(axis) => moved(axis, -1.0),
                Influence::TrackerPosition(axis) => moved(axis, 1.0),
                // A direction is no reading of the tracker's frame.
                Influence::TrackerOrientation(_) if axis.is_some() => following.none(),
                Influence::TrackerOrientation(about) => {
                    let change: Vector3<f64> = self.by_turn.column(about).into();
                    let shift = if sees_place && !is_of_tracker {
                        measured * change.cross(&mount_m)
                    } else {
                        zero
                    };
                    let turned = match self.is_in_body {
                        true if sees_turn => so3::right_jacobian_inverse(&error).tr_mul(&change),
                        true => zero,
                        false => turned_by.tr_mul(&(to_epoch * change)),
                    };
                    following.seen(shift, -turned)
                }
                Influence::ClockRate => F::times(by_time, stamped_s - zero_s),
                Influence::ClockOffset => by_time,
                Influence::SampleTime if of.open == Some(acting.parameter) => {
                    F::times(by_time, 1.0 + self.mount.rate)
                }
                Influence::SampleTime => following.none(),
                Influence::Mass
                | Influence::SurfaceHeight
                | Influence::SurfaceTilt(_)
                | Influence::ContactDuration => following.none(),
            }
        });
        memory.clear();
        memory.extend(by_acting);
        Observed {
            residual,
            by_state,
            by_time,
            by_acting: memory,
        }
    }
}
