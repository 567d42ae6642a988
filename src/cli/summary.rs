//! What became of many recordings: a line each, and how many of each kind.

use super::table::table;
use crate::report::{EstimateReport, RecordingReport, plain};

/// Lines in the order of the recordings.
#[derive(Default)]
pub(super) struct Summary {
    rows: Vec<Vec<String>>,
    physical: usize,
    other: usize,
    failed: usize,
    left_alone: usize,
}

impl Summary {
    pub(super) fn estimated(&mut self, report: &RecordingReport) {
        let estimate = &report.estimate;
        if estimate.is_physical() {
            self.physical += 1;
        } else {
            self.other += 1;
        }
        let what = match (report.ended_early, report.is_whole()) {
            (true, _) => "ended at its deadline",
            (false, true) => "",
            (false, false) if estimate.is_physical() => "look at its account",
            (false, false) => "not physical",
        };
        self.rows.push(vec![
            plain(&report.recording).into_owned(),
            estimate.verdict.clone(),
            format!("{:.2} mm", estimate.residual_mm),
            format!("{:.2}°", estimate.residual_deg),
            what.to_owned(),
        ]);
    }

    /// An estimate that was there.
    pub(super) fn present(&mut self, recording: &str, report: &EstimateReport, ended_early: bool) {
        match report.is_physical() {
            true => self.physical += 1,
            false => self.other += 1,
        }
        let what = match (ended_early, report.is_undoubted()) {
            (true, _) => "was there, ended at its deadline",
            (false, true) => "was there",
            (false, false) => "was there, look at its report",
        };
        self.without_motion(recording, &report.verdict, what);
    }

    pub(super) fn left_alone(&mut self, recording: &str) {
        self.left_alone += 1;
        self.without_motion(recording, "left alone", "has an estimate already");
    }

    pub(super) fn failed(&mut self, recording: &str) {
        self.failed += 1;
        self.without_motion(recording, "no estimate", "see the error");
    }

    fn without_motion(&mut self, recording: &str, what: &str, why: &str) {
        let [none, neither] = [String::new(), String::new()];
        self.rows.push(vec![
            plain(recording).into_owned(),
            what.to_owned(),
            none,
            neither,
            why.to_owned(),
        ]);
    }

    /// A table, and the counts.
    pub(super) fn text(&self) -> String {
        let counts = [
            (self.physical, "physical"),
            (self.other, "not physical"),
            (self.failed, "without an estimate"),
            (self.left_alone, "left alone"),
        ];
        let counts = counts.iter().filter(|(count, _)| *count > 0);
        let counts: Vec<String> = counts
            .map(|(count, what)| format!("{count} {what}"))
            .collect();
        let head = ["recording", "verdict", "residual", "", ""];
        format!(
            "{}{} recordings: {}\n",
            table("", &head, &self.rows),
            self.rows.len(),
            counts.join(", ")
        )
    }
}
