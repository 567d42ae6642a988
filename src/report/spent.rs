//! Where the time of a recording went.

use crate::motion::Phase;

/// Names of what time is spent on, in order: the solve's is the second.
const PARTS: [&str; 8] = [
    "reading",
    "solving",
    "adequacy",
    "checking",
    "diagnosing",
    "settling",
    "leading",
    "writing",
];
const READING: usize = 0;
const SOLVING: usize = 1;
const WRITING: usize = PARTS.len() - 1;

/// Wall time of all that was done of a recording, by what was done \[s\].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spent([f64; PARTS.len()]);

impl Spent {
    /// Of a pipeline that took so long in all, and by phase. Phases that are none of the others' are the solve's.
    pub fn of(whole_seconds: f64, phases: &[(Phase, f64)]) -> Self {
        let mut spent = Self::default();
        for (phase, seconds) in phases {
            let part = match phase {
                Phase::Adequacy => 2,
                Phase::Verify => 3,
                Phase::Diagnose => 4,
                Phase::Settle => 5,
                Phase::Rest => 6,
                _ => continue,
            };
            spent.0[part] += seconds;
        }
        spent.0[SOLVING] = (whole_seconds - spent.0.iter().sum::<f64>()).max(0.0);
        spent
    }

    /// The same with what reading the recording and writing the estimate took.
    pub fn with_files(mut self, reading_seconds: f64, writing_seconds: f64) -> Self {
        self.0[READING] = reading_seconds;
        self.0[WRITING] = writing_seconds;
        self
    }

    /// Of the estimation alone.
    pub fn solving(&self) -> f64 {
        self.0[SOLVING]
    }

    /// By name, what took no time left out.
    pub(super) fn parts(&self) -> Vec<(String, f64)> {
        let parts = PARTS.iter().zip(self.0);
        let parts = parts.filter(|(_, seconds)| *seconds > 0.0);
        parts
            .map(|(part, seconds)| ((*part).to_owned(), seconds))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_of_no_other_part_is_the_solves() {
        let phases = [
            (Phase::Clean, 0.1),
            (Phase::Sweep, 0.4),
            (Phase::Diagnose, 3.0),
            (Phase::Adequacy, 1.0),
        ];
        let spent = Spent::of(5.0, &phases).with_files(0.2, 0.3);
        assert_eq!(spent.solving(), 1.0);
        let names: Vec<String> = spent.parts().into_iter().map(|(name, _)| name).collect();
        assert_eq!(
            names,
            ["reading", "solving", "adequacy", "diagnosing", "writing"]
        );
        assert!((spent.parts().iter().map(|(_, s)| s).sum::<f64>() - 5.5).abs() < 1e-12);
    }
}
