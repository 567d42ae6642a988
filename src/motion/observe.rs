//! How the pipeline is watched and stopped from outside: it reads no clock and prints nothing.

/// What the pipeline is about to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Phase {
    /// Sort, check and mount the samples; match the marks.
    Clean,
    /// Refine the marks.
    Marks,
    /// Fit each arc by itself.
    ArcFits,
    /// Search for what touches at each collision.
    Sequence,
    /// Bring the constraints in as a growing penalty.
    Sweep,
    /// Tighten them by multipliers.
    Multipliers,
    /// Newton steps on the optimality conditions.
    Finish,
    /// What the performance determines, and how well.
    Covariance,
    /// Check the motion independently.
    Verify,
    /// Simulate on until it rests.
    Settle,
    /// Nothing more.
    Done,
}

impl Phase {
    /// The word for it in files and reports.
    pub fn as_str(self) -> &'static str {
        match self {
            Phase::Clean => "clean",
            Phase::Marks => "marks",
            Phase::ArcFits => "arc_fits",
            Phase::Sequence => "sequence",
            Phase::Sweep => "sweep",
            Phase::Multipliers => "multipliers",
            Phase::Finish => "finish",
            Phase::Covariance => "covariance",
            Phase::Verify => "verify",
            Phase::Settle => "settle",
            Phase::Done => "done",
        }
    }
}

/// Somebody outside the core: measures phases, ends a run that takes too long.
pub trait Observer {
    /// A phase begins; the one before it, if any, has ended. Phases may come again.
    fn phase(&mut self, phase: Phase) {
        let _ = phase;
    }

    /// Asked between iterations; `true` ends the run with what it has.
    fn should_stop(&mut self) -> bool {
        false
    }
}

/// Watches nothing, stops nothing.
impl Observer for () {}
