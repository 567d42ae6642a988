//! What a motion may be called.

/// How far the motion may be called physical; the worse, the greater.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Verdict {
    /// Every gap is within tolerance, and where the motion was checked nothing speaks against it.
    Physical,
    /// The goals are met; some velocity gaps are left, and listed, or doubts.
    Plausible,
    /// Neither, or no hand moves so; the reason or the doubt is given beside it.
    Failed,
}

impl Verdict {
    /// The word for it in files and reports.
    pub fn as_str(self) -> &'static str {
        match self {
            Verdict::Physical => "physical",
            Verdict::Plausible => "plausible",
            Verdict::Failed => "failed",
        }
    }
}
