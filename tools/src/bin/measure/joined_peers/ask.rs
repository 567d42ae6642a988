//! Peers asked about one problem: `tools/peers/joined.py`.

use std::collections::BTreeMap;
use std::fs;
use std::process::Command;

use anyhow::{Context, Result, bail};
use enact::physics::tree::TreeState;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::figure::or_nan;
use crate::peers::tools;

/// Formulas that differ by more, relative, are of another problem: accelerations; objectives and rows, which the
/// integrators' errors are in; derivatives, which difference quotients are good for.
const AGREES: [f64; 3] = [1e-9, 1e-6, 1e-5];

/// The status of what the limit of time stopped.
const OVER: &str = "over the limit";

/// What came back.
#[derive(Deserialize)]
pub struct Report {
    /// Versions of everything.
    pub versions: Value,
    pub agreement: Agreement,
    pub answers: Vec<Answer>,
}

/// How well the peers' formulas agree with ours, the worst of all points of the problem.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
pub struct Agreement {
    /// Of the accelerations, relative to the greatest.
    #[serde(deserialize_with = "or_nan")]
    pub accelerations: f64,
    /// Of the objective, relative.
    #[serde(deserialize_with = "or_nan")]
    pub objective: f64,
    /// Of a row \[units\].
    #[serde(deserialize_with = "or_nan")]
    pub rows: f64,
    /// First and second derivatives against difference quotients, relative.
    #[serde(deserialize_with = "or_nan")]
    pub derivative: f64,
    /// What twice the steps change of the objective, relative.
    #[serde(deserialize_with = "or_nan")]
    pub integration: f64,
    /// Steps between samples.
    pub substeps: usize,
}

impl Agreement {
    fn check(&self) -> Result<()> {
        let of = [
            ("accelerations", self.accelerations, AGREES[0]),
            ("objectives", self.objective, AGREES[1]),
            ("rows", self.rows, AGREES[1]),
            ("derivatives", self.derivative, AGREES[2]),
        ];
        for (what, off, most) in of {
            // What is no number does not agree.
            if !(off <= most) {
                bail!("the peers' {what} differ by {off:.1e}, more than {most:.0e}");
            }
        }
        Ok(())
    }
}

/// Where a peer ended.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Answer {
    /// Who.
    pub peer: String,
    /// From which start.
    pub from: String,
    /// In its own words.
    pub status: String,
    /// Whether these mean that it has converged.
    pub succeeded: bool,
    /// Least and greatest of the repeats \[s\].
    pub seconds: [f64; 2],
    /// Inside the compiled formulas, of that \[s\].
    pub formula_seconds: f64,
    /// In Python between solver and formulas, the latter included \[s\].
    pub callback_seconds: Option<f64>,
    /// By the peers' formulas, over all segments.
    pub objective: Option<f64>,
    /// Largest gap or violation there, by them \[units\].
    pub violation: Option<f64>,
    pub evaluations: usize,
    pub iterations: Option<usize>,
    /// At the start.
    pub state: Option<State>,
}

impl Answer {
    /// Whether the limit of time stopped it.
    pub fn is_late(&self) -> bool {
        self.status == OVER
    }
}

/// A state of the file.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct State {
    coordinates: Vec<f64>,
    rates: Vec<f64>,
}

impl From<State> for TreeState {
    fn from(state: State) -> Self {
        Self {
            coordinates: state.coordinates,
            rates: state.rates,
            time_s: 0.0,
        }
    }
}

/// Gives a problem to all peers, from all starts; formulas that do not agree are an error.
pub fn ask(problem: &Value, starts: &[&str], limit_s: f64) -> Result<Report> {
    let folder = tempfile::tempdir()?;
    let (given, answers) = (folder.path().join("given"), folder.path().join("answers"));
    fs::write(&given, problem.to_string())?;
    let status = Command::new(tools().join(".venv/bin/python"))
        .arg(tools().join("joined.py"))
        .args([&given, &answers])
        .args(["--limit", &limit_s.to_string()])
        .args(["--from", &starts.join("|")])
        .status()
        .context("cannot run the peers")?;
    if !status.success() {
        bail!("the peers ended with {status}");
    }
    let report: Report = serde_json::from_str(&fs::read_to_string(&answers)?)?;
    report.agreement.check()?;
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for answer in &report.answers {
        *counts.entry(&answer.peer).or_default() += 1;
    }
    if let Some((peer, count)) = counts.iter().find(|(_, count)| **count != starts.len()) {
        bail!("{count} answers of {peer} from {} starts", starts.len());
    }
    Ok(report)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Formulas of another problem are refused, and so is what is no number.
    #[test]
    fn what_does_not_agree_is_refused() {
        let agreement = Agreement {
            accelerations: 1e-12,
            objective: 1e-9,
            rows: 1e-9,
            derivative: 1e-8,
            integration: 1e-10,
            substeps: 1,
        };
        agreement.check().expect("all agree");
        for off in [2e-5, f64::NAN] {
            let mut others = [agreement; 4];
            others[0].accelerations = off;
            others[1].objective = off;
            others[2].rows = off;
            others[3].derivative = off;
            for (other, what) in
                others
                    .iter()
                    .zip(["accelerations", "objectives", "rows", "derivatives"])
            {
                let refused = other.check().expect_err("one does not agree").to_string();
                assert!(refused.contains(what), "{refused}");
            }
        }
    }
}
