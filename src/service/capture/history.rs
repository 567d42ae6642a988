//! The last takes, for the operator's page.

use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use serde::Serialize;
use tokio::sync::watch;

use super::event::CaptureEvent;
use super::label::TakeLabel;
use crate::motion::Verdict;
use crate::service::takes::{TakeEntry, entry, take_files};

/// Number of takes that are remembered.
const TAKES: usize = 20;

/// Longest picture, and longest motion, that is kept \[bytes\].
const PICTURE_BYTES: usize = 1 << 20;

/// What became of a take.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub(super) struct TakeLine {
    take: u64,
    /// `recording`, `estimating`, `discarded`, `broken`, `not estimated`, or the verdict.
    state: String,
    /// Whether the motion is good, once it is known.
    is_good: Option<bool>,
    /// What is to be said of it: an error, a doubt.
    text: String,
    /// The file.
    recording: String,
    /// Its estimate.
    output: Option<String>,
    label: TakeLabel,
    /// Whether there is a picture of its motion.
    has_picture: bool,
    #[serde(skip)]
    picture: Option<Arc<str>>,
    /// Whether there is its motion, beside what was acted, as glTF.
    has_motion: bool,
    /// How often the motion was made anew: first so far, at marks, then as it is in the file.
    motions: u32,
    /// Whether it is that of the file, which was checked.
    is_checked: bool,
    #[serde(skip)]
    motion: Option<Arc<[u8]>>,
    /// The verdict so far, before the take is estimated.
    so_far: Option<&'static str>,
}

/// The last takes.
#[derive(Debug, Default)]
pub(super) struct History {
    /// The latest first.
    lines: Mutex<VecDeque<TakeLine>>,
    changes: watch::Sender<()>,
}

impl History {
    /// Takes in the last takes that are in a folder already, as far as they can be read.
    pub(super) fn read(&self, folder: &Path) {
        let files = take_files(folder).unwrap_or_default();
        for file in files.iter().rev().take(TAKES) {
            self.earlier(entry(file));
        }
    }

    /// A take of before, earlier than all others.
    fn earlier(&self, of: TakeEntry) {
        let (Some(take), Ok(mut takes)) = (of.number, self.lines.lock()) else {
            return;
        };
        if takes.len() >= TAKES || takes.iter().any(|line| line.take <= take) {
            return;
        }
        let verdicts = [Verdict::Physical, Verdict::Plausible, Verdict::Failed];
        let mut words = verdicts.iter().map(|verdict| verdict.as_str());
        let state = words.find(|word| of.verdict.as_deref() == Some(*word));
        takes.push_back(TakeLine {
            take,
            state: state.unwrap_or("not estimated").to_owned(),
            is_good: of.is_good,
            text: of.error.or(of.why).unwrap_or_default(),
            recording: of.recording,
            output: of.estimate,
            label: TakeLabel {
                name: of.name,
                note: of.note,
                rating: of.rating,
            },
            ..TakeLine::default()
        });
        self.changes.send_replace(());
    }

    /// Keeps a picture of the motion of a take that it knows; of too large a one nothing.
    pub(super) fn draw(&self, take: u64, picture: String) {
        if picture.len() > PICTURE_BYTES {
            return;
        }
        self.change_known(take, |line| {
            line.has_picture = true;
            line.picture = Some(picture.into());
        });
    }

    /// Keeps the motion so far of a take that it knows, as glTF; of too large a one nothing.
    pub(super) fn keep_so_far(&self, take: u64, glb: Vec<u8>) {
        self.keep_motion(take, glb, false);
    }

    /// Keeps the motion that was checked.
    pub(super) fn keep_checked(&self, take: u64, glb: Vec<u8>) {
        self.keep_motion(take, glb, true);
    }

    fn keep_motion(&self, take: u64, glb: Vec<u8>, is_checked: bool) {
        if glb.len() > PICTURE_BYTES {
            return;
        }
        self.change_known(take, |line| {
            line.has_motion = true;
            line.motions += 1;
            line.is_checked = is_checked;
            line.motion = Some(glb.into());
        });
    }

    /// The recording of a take that is over.
    pub(super) fn recording(&self, take: u64) -> Option<PathBuf> {
        let takes = self.lines.lock().ok()?;
        let line = takes.iter().find(|line| line.take == take)?;
        let is_over = line.state != "recording" && !line.recording.is_empty();
        is_over.then(|| PathBuf::from(&line.recording))
    }

    /// The picture of a take.
    pub(super) fn picture(&self, take: u64) -> Option<Arc<str>> {
        let takes = self.lines.lock().ok()?;
        takes.iter().find(|line| line.take == take)?.picture.clone()
    }

    /// The motion of a take as glTF.
    pub(super) fn motion(&self, take: u64) -> Option<Arc<[u8]>> {
        let takes = self.lines.lock().ok()?;
        takes.iter().find(|line| line.take == take)?.motion.clone()
    }

    /// Tells of every change from now on.
    pub(super) fn changes(&self) -> watch::Receiver<()> {
        self.changes.subscribe()
    }

    /// Takes an event in.
    pub(super) fn said(&self, said: &CaptureEvent) {
        match said {
            CaptureEvent::Started {
                take, recording, ..
            } => self.change(*take, |line| {
                line.state = "recording".to_owned();
                line.recording.clone_from(recording);
            }),
            CaptureEvent::Closed { take, label, .. } => self.change(*take, |line| {
                line.state = "estimating".to_owned();
                line.label.clone_from(label);
            }),
            CaptureEvent::Discarded { take, recording } => self.change(*take, |line| {
                line.state = "discarded".to_owned();
                line.recording = recording.clone().unwrap_or_default();
            }),
            CaptureEvent::Broken {
                take,
                recording,
                error,
                ..
            } => self.change(*take, |line| {
                line.state = "broken".to_owned();
                line.is_good = Some(false);
                line.recording.clone_from(recording);
                line.text.clone_from(error);
            }),
            CaptureEvent::Estimated { take, report } => self.change(*take, |line| {
                let estimate = &report.estimate;
                line.state.clone_from(&estimate.verdict);
                line.is_good = Some(estimate.is_good());
                line.output = Some(report.output.clone());
                let doubt = estimate.doubts.first().map(|doubt| &doubt.text);
                line.text.clone_from(doubt.unwrap_or(&estimate.reason));
            }),
            CaptureEvent::SoFar { take, verdict, .. } => self.change_known(*take, |line| {
                line.so_far = Some(*verdict);
            }),
            CaptureEvent::NotEstimated { take, error, .. } => self.change(*take, |line| {
                line.state = "not estimated".to_owned();
                line.is_good = Some(false);
                line.text.clone_from(error);
            }),
            _ => {}
        }
    }

    /// The takes, the latest first.
    pub(super) fn takes(&self) -> Vec<TakeLine> {
        self.lines
            .lock()
            .map_or(Vec::new(), |takes| takes.iter().cloned().collect())
    }

    fn change(&self, take: u64, change: impl FnOnce(&mut TakeLine)) {
        let Ok(mut takes) = self.lines.lock() else {
            return;
        };
        match takes.iter_mut().find(|line| line.take == take) {
            Some(line) => change(line),
            None => {
                let mut line = TakeLine {
                    take,
                    ..TakeLine::default()
                };
                change(&mut line);
                takes.push_front(line);
                takes.truncate(TAKES);
            }
        }
        drop(takes);
        self.changes.send_replace(());
    }

    /// Changes the line of a take that has one.
    fn change_known(&self, take: u64, change: impl FnOnce(&mut TakeLine)) {
        let Ok(mut takes) = self.lines.lock() else {
            return;
        };
        if let Some(line) = takes.iter_mut().find(|line| line.take == take) {
            change(line);
        }
        drop(takes);
        self.changes.send_replace(());
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
                troubles: Vec::new(),
            });
        }
        history.said(&CaptureEvent::Discarded {
            take: 30,
            recording: None,
        });
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
        let states = [&takes[0].state, &takes[2].state];
        assert_eq!(states, ["discarded", "recording"]);
        assert_eq!(
            (takes[1].text.as_str(), takes[1].is_good),
            ("no marks", Some(false))
        );
        // Pictures go with their lines, and none is too large.
        history.draw(28, "<svg/>".to_owned());
        history.draw(27, "x".repeat(PICTURE_BYTES + 1));
        history.draw(3, "<svg/>".to_owned());
        let pictures = [28, 27, 3].map(|take| history.picture(take).is_some());
        assert_eq!(pictures, [true, false, false]);
        assert!(history.takes()[2].has_picture);
        // So do motions, and who looks is told.
        let changes = history.changes();
        history.keep_so_far(28, vec![7; 3]);
        history.keep_checked(27, vec![7; PICTURE_BYTES + 1]);
        assert!(changes.has_changed().expect("there"));
        let motions = [28, 27].map(|take| history.motion(take).map(|glb| glb.len()));
        assert_eq!(motions, [Some(3), None]);
    }
}
