//! Bodies in the hand at their collisions.
//!
//! The state `q` of a held body at a collision is an unknown beside the event's time `τ`, with what its
//! tracker showed as a prior: the smoothed state `m` and its covariance `P`
//! ([`HeldMotion`]). The tracker's motion runs in acted time `a`, of which
//! `s = da/dτ` passes in a second, so that velocities of `q` are divided by `s` before they are
//! compared:
//!
//! ```text
//! r = c^½ L⁻¹ ((x, R, v/s, ω/s) ⊟ m(a(τ, u), u)),   P = L Lᵀ
//! ```
//!
//! `P` is that at the event's mark and stays; `m` follows the event and the parameters `u` of the
//! tracker, its mount and its clock. `c` is how often samples are counted, so that neither side pulls
//! more than it knows. Where a body's own tracker shows it in a hand and then flying, a hand that acts strays in both
//! (`hand`), and its variance is added to `P`. The impact deflects only what hits the body, and the state after it is `q` too.

mod hand;

use nalgebra::{Cholesky, DVector, SMatrix, Vector3};

use super::context::SolveContext;
use crate::estimate::problem::influence::{Acting, Influence};
use crate::estimate::problem::{HeldState, Problem};
use crate::estimate::unknowns::layout::Layout;
use crate::estimate::unknowns::point::Point;
use crate::math::{Pose, so3};
use crate::motion::held::{Meeting, Mounted};
use crate::motion::{HeldMotion, LinkIndex, TrackIndex};
use crate::physics::State;
use crate::physics::state::{self, StateTangent, part};

/// Derivatives of twelve residuals by a state.
type Twelve = SMatrix<f64, 12, 12>;

/// Residuals with their derivatives.
pub struct HeldTerm {
    /// The residuals.
    pub residual: StateTangent,
    /// Derivatives by the state.
    pub by_state: Twelve,
    /// Derivatives by the event's time, by the times of both nodes, and by the acting parameters.
    pub by_others: Vec<StateTangent>,
}

/// Acted time with its derivatives.
struct HeldClock {
    acted_s: f64,
    /// `da/dτ`.
    rate: f64,
    /// Derivatives of acted time and rate by each of the other unknowns.
    by_others: Vec<[f64; 2]>,
}

impl HeldState {
    /// A body whose tracker moves so, mounted so, at one of the motion's meetings.
    pub fn new(
        link: LinkIndex,
        track: TrackIndex,
        motion: &HeldMotion,
        mount: &Pose,
        meeting: &Meeting,
        acting: Vec<Acting>,
        nodes: Option<[usize; 2]>,
    ) -> Self {
        let mounted = Mounted::new(&motion.at(meeting.acted_s), mount);
        let covariance = mounted.covariance(&meeting.covariance);
        Self {
            event: meeting.event,
            link,
            track,
            motion: motion.clone(),
            mount: *mount,
            root: inverse_root(&covariance) * motion.counted.sqrt(),
            covariance,
            strays: false,
            acting,
            nodes,
        }
    }

    /// How often its residuals count: their variance.
    pub fn counted(&self) -> f64 {
        self.motion.counted
    }

    /// The smoothed state at the event's time.
    pub fn expected(&self, problem: &Problem, point: &Point) -> State {
        let clock = self.clock(problem, point);
        let state = self.mounted(clock.acted_s, &point.parameters).driven.state;
        State {
            velocity_m_s: state.velocity_m_s * clock.rate,
            angular_velocity_rad_s: state.angular_velocity_rad_s * clock.rate,
            ..state
        }
    }

    /// The residuals of a state at a point.
    pub fn term(&self, problem: &Problem, point: &Point, state: &State) -> HeldTerm {
        let clock = self.clock(problem, point);
        let mounted = self.mounted(clock.acted_s, &point.parameters);
        let slow = 1.0 / clock.rate;
        let acted = State {
            velocity_m_s: state.velocity_m_s * slow,
            angular_velocity_rad_s: state.angular_velocity_rad_s * slow,
            ..*state
        };
        let miss = acted.minus(&mounted.driven.state);
        let turn: Vector3<f64> = miss.fixed_rows::<3>(part::ORIENTATION).into();
        let right = so3::right_jacobian_inverse(&turn);
        let mut by_state = Twelve::identity();
        by_state
            .fixed_view_mut::<3, 3>(part::ORIENTATION, part::ORIENTATION)
            .copy_from(&right);
        let mut by_mean = -Twelve::identity();
        by_mean
            .fixed_view_mut::<3, 3>(part::ORIENTATION, part::ORIENTATION)
            .copy_from(&-right.transpose());
        let mut by_rate = StateTangent::zeros();
        for (at, velocity) in [
            (part::VELOCITY, &state.velocity_m_s),
            (part::ANGULAR_VELOCITY, &state.angular_velocity_rad_s),
        ] {
            by_state.fixed_view_mut::<3, 3>(at, at).fill_diagonal(slow);
            by_rate
                .fixed_rows_mut::<3>(at)
                .copy_from(&(velocity * (-slow * slow)));
        }
        let by_acted = by_mean * mounted.rate();
        let timely = clock.by_others.iter();
        let mut by_others: Vec<StateTangent> = timely
            .map(|[acted, rate]| by_acted * *acted + by_rate * *rate)
            .collect();
        let first = by_others.len() - self.acting.len();
        for (acting, by) in self.acting.iter().zip(&mut by_others[first..]) {
            if let Some(mean) = self.by_mount(acting, &mounted, &point.parameters) {
                *by += by_mean * mean;
            }
        }
        for by in &mut by_others {
            *by = self.root * *by;
        }
        HeldTerm {
            residual: self.root * miss,
            by_state: self.root * by_state,
            by_others,
        }
    }

    /// Unknowns of the residuals after those of the state: the event's time, the times of both nodes,
    /// the acting parameters.
    pub fn others(&self, layout: &Layout) -> Vec<Option<usize>> {
        let nodes = self.nodes.into_iter().flatten();
        let acting = self.acting.iter();
        std::iter::once(layout.events[self.event])
            .chain(nodes.map(|node| layout.nodes[node]))
            .chain(acting.map(|acting| Some(layout.parameters[acting.parameter])))
            .collect()
    }

    /// How the tracker is mounted: link from tracker.
    pub fn mount_at(&self, parameters: &[f64]) -> Pose {
        let mut mount = self.mount;
        let mut turn = Vector3::zeros();
        for acting in &self.acting {
            let value = parameters[acting.parameter];
            match acting.influence {
                Influence::TrackerPosition(axis) => mount.translation.vector[axis] += value,
                Influence::TrackerOrientation(axis) => turn[axis] += value,
                _ => {}
            }
        }
        mount.rotation *= so3::exp(&turn);
        mount
    }

    /// By how much the tracker's clock is slow, and what is added to its stamps \[s\].
    pub fn clock_at(&self, parameters: &[f64]) -> [f64; 2] {
        let (mut slow, mut offset_s) = (0.0, 0.0);
        for acting in &self.acting {
            let value = parameters[acting.parameter];
            match acting.influence {
                Influence::ClockRate => slow = value,
                Influence::ClockOffset => offset_s = value,
                _ => {}
            }
        }
        [slow, offset_s]
    }

    /// The body's state at an acted time, per second of acted time.
    fn mounted(&self, acted_s: f64, parameters: &[f64]) -> Mounted {
        Mounted::new(&self.motion.at(acted_s), &self.mount_at(parameters))
    }

    /// Derivative of the smoothed state by a parameter of the mount.
    fn by_mount(
        &self,
        acting: &Acting,
        mounted: &Mounted,
        parameters: &[f64],
    ) -> Option<StateTangent> {
        match acting.influence {
            Influence::TrackerPosition(axis) => {
                Some(mounted.by_tracker_position().column(axis).into())
            }
            Influence::TrackerOrientation(axis) => {
                let mut turn = Vector3::zeros();
                for other in &self.acting {
                    if let Influence::TrackerOrientation(axis) = other.influence {
                        turn[axis] += parameters[other.parameter];
                    }
                }
                let by = mounted.by_tracker_turn() * so3::right_jacobian(&turn);
                Some(by.column(axis).into())
            }
            _ => None,
        }
    }

    fn clock(&self, problem: &Problem, point: &Point) -> HeldClock {
        let time_s = point.event_times_s[self.event];
        if let Some(nodes) = self.nodes {
            return self.between(problem, point, nodes);
        }
        let [slow, offset_s] = self.clock_at(&point.parameters);
        let zero_s = point.node_times_s.first().copied().unwrap_or(0.0);
        let rate = 1.0 / (1.0 + slow);
        let since_s = (time_s - offset_s - zero_s) * rate;
        let of_parameters = self.acting.iter().map(|acting| match acting.influence {
            Influence::ClockRate => [-since_s * rate, -rate * rate],
            Influence::ClockOffset => [-rate, 0.0],
            _ => [0.0, 0.0],
        });
        HeldClock {
            acted_s: zero_s + since_s,
            rate,
            by_others: std::iter::once([rate, 0.0]).chain(of_parameters).collect(),
        }
    }

    /// In an unknown tempo: the time map is linear between two nodes.
    fn between(&self, problem: &Problem, point: &Point, nodes: [usize; 2]) -> HeldClock {
        let [from_s, to_s] = nodes.map(|node| point.node_times_s[node]);
        let [acted_from_s, acted_to_s] = nodes.map(|node| problem.nodes_acted_s[node]);
        let lasting_s = to_s - from_s;
        let rate = (acted_to_s - acted_from_s) / lasting_s;
        let since_s = point.event_times_s[self.event] - from_s;
        let by_node = rate / lasting_s;
        let of_parameters = self.acting.iter().map(|_| [0.0, 0.0]);
        let timely = [
            [rate, 0.0],
            [since_s * by_node - rate, by_node],
            [-since_s * by_node, -by_node],
        ];
        HeldClock {
            acted_s: acted_from_s + since_s * rate,
            rate,
            by_others: timely.into_iter().chain(of_parameters).collect(),
        }
    }
}

impl Problem {
    /// Sets the states of held bodies at an event, or at all, to the smoothed ones.
    pub fn hold(&self, point: &mut Point, event: Option<usize>) {
        for (index, of) in self.held.iter().enumerate() {
            if event.is_none_or(|event| event == of.event) {
                point.held[index] = of.expected(self, point);
            }
        }
    }
}

/// Changes of the residuals of all held bodies by a step of the unknowns.
pub fn changes<'a>(
    context: &'a SolveContext,
    point: &'a Point,
    step: &'a DVector<f64>,
) -> impl Iterator<Item = (&'a HeldState, StateTangent)> {
    let (problem, layout) = (context.problem, context.layout);
    let each = problem.held.iter().zip(&point.held).zip(&layout.held);
    each.map(move |((of, state), at)| {
        let term = of.term(problem, point, state);
        let own: StateTangent = step.fixed_rows::<{ state::DIMENSION }>(*at).into();
        let others = of.others(layout).into_iter().zip(&term.by_others);
        let others = others.filter_map(|(unknown, by)| Some(by * step[unknown?]));
        (of, others.fold(term.by_state * own, |sum, by| sum + by))
    })
}

/// Shares of its variances that are added to a covariance, the first that makes it positive.
const ROUNDING: [f64; 4] = [0.0, 1e-12, 1e-9, 1e-6];

/// `L⁻¹` of a covariance `L Lᵀ`.
///
/// # Panics
/// Where variances are not above zero: those of a held motion are.
fn inverse_root(covariance: &Twelve) -> Twelve {
    let scale = covariance
        .diagonal()
        .map(|variance| variance.sqrt().recip());
    let scaled = Twelve::from_fn(|i, j| covariance[(i, j)] * scale[i] * scale[j]);
    // Rounding may leave a direction of nearly no variance with less than none.
    let mut rounded = ROUNDING.into_iter();
    let factor = rounded.find_map(|more| Cholesky::new(scaled + Twelve::identity() * more));
    let factor = factor.expect("a covariance with variances above zero");
    let inverse = factor
        .l()
        .solve_lower_triangular(&Twelve::identity())
        .expect("a factor with a positive diagonal");
    Twelve::from_fn(|i, j| inverse[(i, j)] * scale[j])
}
