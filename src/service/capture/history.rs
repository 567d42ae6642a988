//! The last takes, for the operator's page.

use std::collections::VecDeque;
use std::sync::Mutex;

use serde::Serialize;

use super::event::CaptureEvent;
use super::label::TakeLabel;

/// Number of takes that are remembered.
const TAKES: usize = 20;

/// What became of a take.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub(super) struct TakeLine {
    take: u64,
    /// `recording`, `estimating`, `discarded`, `broken`, `not estimated`, or the verdict.
    state: &'static str,
    /// Whether the motion is good, once it is known.
    is_good: Option<bool>,
    /// What is to be said of it: an error, a doubt.
    text: String,
    /// The file.
    recording: String,
    /// Its estimate.
    output: Option<String>,
    label: TakeLabel,
}

/// The last takes, the latest first.
#[derive(Debug, Default)]
pub(super) struct History(Mutex<VecDeque<TakeLine>>);

impl History {
    /// Takes an event in.
    pub(super) fn said(&self, said: &CaptureEvent) {
        match said {
            CaptureEvent::Started {
                take, recording, ..
            } => self.change(*take, |line| {
                line.state = "recording";
                line.recording.clone_from(recording);
            }),
            CaptureEvent::Closed { take, label, .. } => self.change(*take, |line| {
                line.state = "estimating";
                line.label.clone_from(label);
            }),
            CaptureEvent::Discarded { take } => self.change(*take, |line| {
                line.state = "discarded";
                line.recording.clear();
            }),
            CaptureEvent::Broken {
                take,
                recording,
                error,
                ..
            } => self.change(*take, |line| {
                line.state = "broken";
                line.is_good = Some(false);
                line.recording.clone_from(recording);
                line.text.clone_from(error);
            }),
            CaptureEvent::Estimated { take, report } => self.change(*take, |line| {
                let estimate = &report.estimate;
                line.state = estimate.verdict;
                line.is_good = Some(estimate.is_good());
                line.output = Some(report.output.clone());
                let doubt = estimate.doubts.first().map(|doubt| &doubt.text);
                line.text.clone_from(doubt.unwrap_or(&estimate.reason));
            }),
            CaptureEvent::NotEstimated { take, error, .. } => self.change(*take, |line| {
                line.state = "not estimated";
                line.is_good = Some(false);
                line.text.clone_from(error);
            }),
            _ => {}
        }
    }

    /// The takes, the latest first.
    pub(super) fn takes(&self) -> Vec<TakeLine> {
        self.0
            .lock()
            .map_or(Vec::new(), |takes| takes.iter().cloned().collect())
    }

    fn change(&self, take: u64, change: impl FnOnce(&mut TakeLine)) {
        let Ok(mut takes) = self.0.lock() else {
            return;
        };
        if let Some(line) = takes.iter_mut().find(|line| line.take == take) {
            return change(line);
        }
        let mut line = TakeLine {
            take,
            ..TakeLine::default()
        };
        change(&mut line);
        takes.push_front(line);
        takes.truncate(TAKES);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_take_has_one_line_and_the_last_ones_are_kept() {
        let history = History::default();
        for take in 1..=30 {
            history.said(&CaptureEvent::Started {
                take,
                recording: format!("take-{take}"),
                unheard: Vec::new(),
                before: 0,
            });
        }
        history.said(&CaptureEvent::Discarded { take: 30 });
        history.said(&CaptureEvent::NotEstimated {
            take: 29,
            recording: String::new(),
            error: "no marks".to_owned(),
        });
        let takes = history.takes();
        assert_eq!(
            (takes.len(), takes[0].take, takes[19].take),
            (TAKES, 30, 11)
        );
        assert_eq!((takes[0].state, takes[2].state), ("discarded", "recording"));
        assert_eq!(
            (takes[1].text.as_str(), takes[1].is_good),
            ("no marks", Some(false))
        );
    }
}
