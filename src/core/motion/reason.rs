//! Why an estimation ended as it did: what was measured, and what was allowed.

use super::index::MechanismIndex;

/// Why an estimation ended, and whether the search that it rests on was complete.
#[derive(Clone, Debug, PartialEq)]
pub struct Reason {
    /// How it ended.
    pub end: End,
    /// Number of bounds after which the search over contacts ended without a proof that no other
    /// contacts fit better; `None` where the search was complete, or where there was none.
    pub unproven_after_bounds: Option<usize>,
    /// Number of the solver's steps after which it ended, the most for so many samples, before all starts were tried to their
    /// ends; `None` where they were.
    pub unfinished_after_steps: Option<usize>,
}

/// How an estimation ended.
#[derive(Clone, Debug, PartialEq)]
pub enum End {
    /// The solver is within its tolerances.
    Converged(Progress),
    /// Simulated from a first state near that of the best motion, so that it comes to rest as the
    /// scene asks: no optimum, and no decrease is known.
    Simulated(Progress),
    /// The caller ended it.
    Stopped(Progress),
    /// The solver is within its tolerances, but the caller ended it before the motion was verified.
    Unverified(Progress),
    /// No further step of the solver helps.
    NoProgress(Progress),
    /// The solver is within its tolerances, but velocity gaps are left, as the scene allows.
    VelocityJumps {
        /// Events with a gap (indices into `Scene::events`).
        events: Vec<usize>,
        /// Where the solver ended.
        progress: Progress,
    },
    /// A state or the objective is not finite.
    NotFinite,
    /// A flight's last event would be earlier than its first.
    EventsReversed {
        /// The event that begins the flight (index into `Scene::events`).
        first: usize,
        /// The event that ends it (index into `Scene::events`).
        last: usize,
        /// Physical time of `last` less that of `first` \[s\]: negative.
        interval_s: f64,
    },
    /// A flight that no event begins, or none ends, would end before it begins.
    FlightReversed {
        /// What flies.
        mechanism: MechanismIndex,
        /// Physical time at which the flight begins \[s\].
        start_s: f64,
        /// Physical time at which it ends \[s\].
        end_s: f64,
    },
}

/// Where the solver ended, against its tolerances.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Progress {
    /// Largest violation of a constraint, in the constraints' units.
    pub violation: Measured,
    /// Decrease that a further step would promise, relative to the objective; infinite where no step
    /// was tried.
    pub decrease: Measured,
}

/// A value and the bound that it is compared with.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Measured {
    /// The measured value.
    pub value: f64,
    /// The bound: at most this much.
    pub bound: f64,
}

impl From<End> for Reason {
    fn from(end: End) -> Self {
        Self {
            end,
            unproven_after_bounds: None,
            unfinished_after_steps: None,
        }
    }
}

impl End {
    /// The word for it in files and reports.
    pub fn as_str(&self) -> &'static str {
        match self {
            End::Converged(_) => "converged",
            End::Simulated(_) => "simulated",
            End::Stopped(_) => "stopped",
            End::Unverified(_) => "unverified",
            End::NoProgress(_) => "no_progress",
            End::VelocityJumps { .. } => "velocity_jumps",
            End::NotFinite => "not_finite",
            End::EventsReversed { .. } => "events_reversed",
            End::FlightReversed { .. } => "flight_reversed",
        }
    }

    /// Where the solver ended; `None` where its numbers were not looked at.
    pub fn progress(&self) -> Option<&Progress> {
        match self {
            End::Converged(progress)
            | End::Simulated(progress)
            | End::Stopped(progress)
            | End::Unverified(progress)
            | End::NoProgress(progress)
            | End::VelocityJumps { progress, .. } => Some(progress),
            End::NotFinite | End::EventsReversed { .. } | End::FlightReversed { .. } => None,
        }
    }
}
