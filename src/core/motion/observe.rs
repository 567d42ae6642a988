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

    /// Called now and then; `true` ends the run with the result so far.
    fn should_stop(&mut self) -> bool {
        false
    }

    /// Called between iterations of a solve with the work of one, in looks at a sample; `true` ends the solve as
    /// [`should_stop`](Self::should_stop) does.
    fn worked(&mut self, looks: usize) -> bool {
        let _ = looks;
        self.should_stop()
    }
}

/// No observer.
impl Observer for () {}

/// An observer that counts work, by which costs are limited where no clock may count.
pub struct Counted<'a> {
    /// What is told and asked.
    pub observer: &'a mut dyn Observer,
    /// How often it was asked: about once an iteration.
    pub steps: usize,
    /// Looks at samples.
    pub looks: usize,
}

impl Observer for Counted<'_> {
    fn phase(&mut self, phase: Phase) {
        self.observer.phase(phase);
    }

    fn should_stop(&mut self) -> bool {
        self.steps += 1;
        self.observer.should_stop()
    }

    fn worked(&mut self, looks: usize) -> bool {
        self.steps += 1;
        self.looks += looks;
        self.observer.worked(looks)
    }
}

/// An observer that ends a stage when its work is done, a limit where no clock may count.
pub struct WorkLimited<'a> {
    /// What is told and asked.
    pub observer: &'a mut dyn Observer,
    /// Looks at samples that are left,
    pub looks: usize,
    /// and iterations that may be made even so.
    pub steps: usize,
}

impl WorkLimited<'_> {
    /// Whether it ended the stage, and not what it asks.
    pub fn is_used_up(&mut self) -> bool {
        self.is_over() && !self.observer.should_stop()
    }

    fn is_over(&self) -> bool {
        self.looks == 0 && self.steps == 0
    }
}

impl Observer for WorkLimited<'_> {
    fn phase(&mut self, phase: Phase) {
        self.observer.phase(phase);
    }

    fn should_stop(&mut self) -> bool {
        self.is_over() || self.observer.should_stop()
    }

    fn worked(&mut self, looks: usize) -> bool {
        self.looks = self.looks.saturating_sub(looks);
        self.steps = self.steps.saturating_sub(1);
        self.observer.worked(looks) || self.is_over()
    }
}

/// An observer of trials within a phase: their own phases are none of the run's.
pub struct Quiet<'a>(pub &'a mut dyn Observer);

impl Observer for Quiet<'_> {
    fn should_stop(&mut self) -> bool {
        self.0.should_stop()
    }

    fn worked(&mut self, looks: usize) -> bool {
        self.0.worked(looks)
    }
}
