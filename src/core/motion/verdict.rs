//! The verdict about an estimated motion.

/// How physical a motion is, in order from best to worst.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Verdict {
    /// Every gap is within tolerance, and checks, if made, raised no doubt.
    Physical,
    /// The goals are met; some velocity gaps or doubts remain, and are listed.
    Plausible,
    /// Goals or contacts are not met, or no hand moves so; the reason or the doubt is given with
    /// it.
    Failed,
}

impl Verdict {
    /// Its name in files and reports.
    pub fn as_str(self) -> &'static str {
        match self {
            Verdict::Physical => "physical",
            Verdict::Plausible => "plausible",
            Verdict::Failed => "failed",
        }
    }
}
