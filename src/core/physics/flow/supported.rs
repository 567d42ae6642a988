//! The motion of a body that something carries: a plane on which it slides, rolls or lies still (`slipping`), a
//! pivot about which it turns (`pivoting`), or another body with which it flies as one (`sticking`).
//!
//! What the support takes from the state is carried along: constraints keep it at zero. Steps of a motion are of one length,
//! so that the result is as smooth as its formulas. Derivatives are those of the formulas.

mod pivoting;
mod seen;
mod slipping;
mod sticking;
#[cfg(test)]
mod tests;

use nalgebra::Vector3;

use self::pivoting::{Pivoting, TurnSeries};
pub use self::seen::Carried;
use self::seen::{Seen, VARIABLES};
pub use self::slipping::LEAST_TURNING_M_S;
use self::slipping::{SlipNode, Slipping};
use self::sticking::Sticking;
use crate::physics::body::Body;
use crate::physics::state::State;
use crate::physics::support::{Pivot, PlaneSupport, Support};

/// Greatest number of steps that are stored: of slow motions some 500 to 1000 s.
const STEPS_MOST: f64 = 32e3;

/// The motion on a support from one state, for many durations of either sign.
#[derive(Clone, Debug)]
pub struct Supported(SupportedBody);

#[derive(Clone, Debug)]
enum SupportedBody {
    Carried {
        values: CarriedFlow<0>,
        changes: CarriedFlow<VARIABLES>,
    },
    Stuck(Box<Sticking>),
}

impl Supported {
    /// From a state; `None` of a body in flight.
    pub fn new(body: &Body, gravity_m_s2: &Vector3<f64>, state: &State) -> Option<Self> {
        let support = body.support()?;
        Some(Self(match &support {
            Support::Plane(plane) => SupportedBody::Carried {
                values: CarriedFlow::slipping(body, plane, gravity_m_s2, state),
                changes: CarriedFlow::slipping(body, plane, gravity_m_s2, state),
            },
            Support::Pivot(pivot) => SupportedBody::Carried {
                values: CarriedFlow::pivoting(body, pivot, gravity_m_s2, state),
                changes: CarriedFlow::pivoting(body, pivot, gravity_m_s2, state),
            },
            Support::Stuck(part) => {
                SupportedBody::Stuck(Box::new(Sticking::new(part, gravity_m_s2, state)))
            }
        }))
    }

    /// The state after a duration \[s\]; not a number beyond 32,000 steps.
    pub fn at(&mut self, duration_s: f64) -> State {
        match &mut self.0 {
            SupportedBody::Carried { values, .. } => values.seen(duration_s).state(),
            SupportedBody::Stuck(of) => of.at(duration_s),
        }
    }

    /// The same with its derivatives.
    pub fn carried(&mut self, duration_s: f64) -> Carried {
        match &mut self.0 {
            SupportedBody::Carried { changes, .. } => changes.seen(duration_s).carried(),
            SupportedBody::Stuck(of) => of.carried(duration_s),
        }
    }
}

/// The motion, with derivatives by so many variables.
#[derive(Clone, Debug)]
enum CarriedFlow<const N: usize> {
    Slipping(Box<Slipping<N>>, Stepped<SlipNode<N>>),
    Pivoting(Box<Pivoting<N>>, Stepped<TurnSeries<N>>),
}

impl<const N: usize> CarriedFlow<N> {
    fn slipping(
        body: &Body,
        plane: &PlaneSupport,
        gravity_m_s2: &Vector3<f64>,
        state: &State,
    ) -> Self {
        let of = Slipping::new(body, plane, gravity_m_s2, state);
        Self::Slipping(Box::new(of), Stepped::default())
    }

    fn pivoting(body: &Body, pivot: &Pivot, gravity_m_s2: &Vector3<f64>, state: &State) -> Self {
        let of = Pivoting::new(body, pivot, gravity_m_s2, state);
        Self::Pivoting(Box::new(of), Stepped::default())
    }

    fn seen(&mut self, duration_s: f64) -> Seen<N> {
        let step_s = match self {
            Self::Slipping(..) => slipping::STEP_S,
            Self::Pivoting(of, _) => of.step_s,
        };
        let is_short = duration_s.abs() <= STEPS_MOST * step_s;
        let duration_s = if is_short { duration_s } else { f64::NAN };
        match self {
            Self::Slipping(of, nodes) => {
                let after = |node: &SlipNode<N>, step_s: f64| of.after(node, step_s);
                let (node, left_s) = nodes.on_the_way(duration_s, step_s, || of.start, after);
                of.told(of.after(node, left_s), duration_s)
            }
            Self::Pivoting(of, nodes) => {
                let after = |node: &TurnSeries<N>, step_s: f64| of.after(node, step_s);
                let (node, left_s) = nodes.on_the_way(duration_s, step_s, || of.start(), after);
                of.told(node, left_s)
            }
        }
    }
}

/// What is known at times a step apart, after the start and before it; nothing until it is asked for.
#[derive(Clone, Debug)]
struct Stepped<T>([Vec<T>; 2]);

impl<T> Default for Stepped<T> {
    fn default() -> Self {
        Self([Vec::new(), Vec::new()])
    }
}

impl<T> Stepped<T> {
    /// The last node on the way to a duration \[s\], and what is left from there \[s\]; `start` makes the first node,
    /// `after` one of the one before it and the step.
    fn on_the_way(
        &mut self,
        duration_s: f64,
        step_s: f64,
        start: impl Fn() -> T,
        after: impl Fn(&T, f64) -> T,
    ) -> (&T, f64) {
        let step_s = step_s.copysign(duration_s);
        let side = &mut self.0[usize::from(duration_s < 0.0)];
        let whole = (duration_s / step_s) as usize;
        while side.len() <= whole {
            let next = side.last().map_or_else(&start, |last| after(last, step_s));
            side.push(next);
        }
        (&side[whole], duration_s - whole as f64 * step_s)
    }
}
