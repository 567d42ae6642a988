//! The interface by which a run is observed and stopped from outside; the core itself reads no
//! clock and prints nothing.

/// A phase of the pipeline.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Phase {
    /// Sort and check the samples, transform them to the body; match the marks.
    Clean,
    /// Refine the marks.
    Marks,
    /// Fit each arc by itself.
    ArcFits,
    /// Search for the features that touch at each collision.
    Sequence,
    /// Constraints as a quadratic penalty.
    Sweep,
    /// Multiplier rounds on the augmented Lagrangian.
    Multipliers,
    /// Newton steps on the KKT conditions.
    Finish,
    /// Whether the motion explains the performance, and what may be wrong where it does not.
    Adequacy,
    /// Standard deviations, and what is undetermined.
    Covariance,
    /// Check the motion independently.
    Verify,
    /// Try remedies for likely mistakes in what is said of the performance.
    Diagnose,
    /// Continue the motion by simulation until it rests.
    Settle,
    /// Search for a motion near the performance that rests as the scene asks.
    Rest,
    /// The run has ended.
    Done,
}

impl Phase {
    /// Its name in files and reports.
    pub fn as_str(self) -> &'static str {
        match self {
            Phase::Clean => "clean",
            Phase::Marks => "marks",
            Phase::ArcFits => "arc_fits",
            Phase::Sequence => "sequence",
            Phase::Sweep => "sweep",
            Phase::Multipliers => "multipliers",
            Phase::Finish => "finish",
            Phase::Adequacy => "adequacy",
            Phase::Covariance => "covariance",
            Phase::Verify => "verify",
            Phase::Diagnose => "diagnose",
            Phase::Settle => "settle",
            Phase::Rest => "rest",
            Phase::Done => "done",
        }
    }
}

/// An observer of a run: it may measure phases, and end a run that takes too long.
pub trait Observer {
    /// A phase begins; the previous one, if any, has ended. Phases may repeat.
    fn phase(&mut self, phase: Phase) {
        let _ = phase;
    }

    /// Called between iterations; `true` ends the run with the result so far.
    fn should_stop(&mut self) -> bool {
        false
    }
}

/// No observer.
impl Observer for () {}

/// An observer that counts the looks whether a run should stop: its work in iterations, by which costs are limited
/// where no clock may count.
pub struct Counted<'a> {
    /// What is told and asked.
    pub observer: &'a mut dyn Observer,
    /// How often it was asked.
    pub work: usize,
}

impl Observer for Counted<'_> {
    fn phase(&mut self, phase: Phase) {
        self.observer.phase(phase);
    }

    fn should_stop(&mut self) -> bool {
        self.work += 1;
        self.observer.should_stop()
    }
}

/// An observer that ends a stage after so many looks whether it should stop, a limit of work where no clock may count.
pub struct StepLimited<'a> {
    /// What is told and asked.
    pub observer: &'a mut dyn Observer,
    /// How often it may still be asked.
    pub left: usize,
}

impl StepLimited<'_> {
    /// Whether it ended the stage, and not what it asks.
    pub fn is_used_up(&mut self) -> bool {
        self.left == 0 && !self.observer.should_stop()
    }
}

impl Observer for StepLimited<'_> {
    fn phase(&mut self, phase: Phase) {
        self.observer.phase(phase);
    }

    fn should_stop(&mut self) -> bool {
        let Some(left) = self.left.checked_sub(1) else {
            return true;
        };
        self.left = left;
        self.observer.should_stop()
    }
}

/// An observer of trials within a phase: their own phases are none of the run's.
pub struct Quiet<'a>(pub &'a mut dyn Observer);

impl Observer for Quiet<'_> {
    fn should_stop(&mut self) -> bool {
        self.0.should_stop()
    }
}
