//! The motion of a body that is stuck to another one: the whole of both flies freely, and the body with it,
//!
//! ```text
//! q(s) = B(Φ_whole(W(q), s)),   ∂q(s)/∂q = B′ Φ′ W′
//! ```
//!
//! with the states `W` of the whole and `B` of the body ([`StuckPart`]).

use nalgebra::{RowSVector, Vector3};

use super::seen::Carried;
use crate::physics::body::Body;
use crate::physics::flow::asymmetric::{self, Steps};
use crate::physics::flow::fall::Fall;
use crate::physics::flow::free::FreeFlown;
use crate::physics::flow::turn::Turns;
use crate::physics::state::{ByStates, State, StateTangent, part};
use crate::physics::support::StuckPart;

/// The motion from one state.
#[derive(Clone, Debug)]
pub(super) struct Sticking {
    part: StuckPart,
    whole: Body,
    gravity_m_s2: Vector3<f64>,
    /// Of the whole at the start, with its derivatives by that of the body.
    start: State,
    start_by_state: ByStates,
    /// Those of the rotation, where three moments differ: those of one duration serve the next.
    steps: Option<Steps>,
}

impl Sticking {
    pub(super) fn new(part: &StuckPart, gravity_m_s2: &Vector3<f64>, state: &State) -> Self {
        let (whole, start) = (part.whole(), part.of_whole(state));
        Self {
            part: *part,
            steps: Steps::needed(&whole, &start.angular_velocity_rad_s),
            whole,
            gravity_m_s2: *gravity_m_s2,
            start,
            start_by_state: part.whole_by_body(state),
        }
    }

    pub(super) fn at(&mut self, duration_s: f64) -> State {
        let whole = self.flown(duration_s).state();
        self.part.of_body(&whole)
    }

    pub(super) fn carried(&mut self, duration_s: f64) -> Carried {
        let flown = self.flown(duration_s);
        let end = flown.state();
        let back = self.part.body_by_whole(&end);
        Carried {
            state: self.part.of_body(&end),
            rate: back * self.rate(&end),
            by_state: back * flown.by_state() * self.start_by_state,
            by_pull: [0, 1, 2].map(|axis| back * flown.by_pull(axis)),
            by_friction: StateTangent::zeros(),
            slip_m_s: 0.0,
            slip_rate_m_s2: 0.0,
            slip_by_state: RowSVector::zeros(),
            slip_by_pull: [0.0; 3],
            slip_by_friction: 0.0,
        }
    }

    /// The flight of the whole.
    fn flown(&mut self, duration_s: f64) -> FreeFlown {
        let State {
            orientation,
            angular_velocity_rad_s,
            ..
        } = &self.start;
        let steps = self.steps.take();
        let mut turns = Turns::with_steps(&self.whole, orientation, angular_velocity_rad_s, steps);
        let turn = turns.after(duration_s);
        self.steps = turns.into_steps();
        FreeFlown {
            fallen: Fall::new(&self.whole, &self.gravity_m_s2, &self.start).fallen(duration_s),
            turn,
            by_moments: None,
        }
    }

    /// Derivative of a state of the whole by time.
    fn rate(&self, whole: &State) -> StateTangent {
        let omega = &whole.angular_velocity_rad_s;
        let [a, b, c] = asymmetric::couplings(&self.whole);
        let euler = Vector3::new(
            a * omega.y * omega.z,
            b * omega.z * omega.x,
            c * omega.x * omega.y,
        );
        let mut rate = StateTangent::zeros();
        let mut put = |row: usize, of: &Vector3<f64>| rate.fixed_rows_mut::<3>(row).copy_from(of);
        put(part::POSITION, &whole.velocity_m_s);
        put(part::ORIENTATION, omega);
        put(part::VELOCITY, &self.whole.pull_m_s2(&self.gravity_m_s2));
        put(part::ANGULAR_VELOCITY, &euler);
        rate
    }
}
