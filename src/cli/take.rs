//! `take`: directs a running daemon and prints its answer.

use std::path::Path;
use std::time::Duration;

use super::arguments::{Format, TakeArguments, Wanted};
use super::exit::Exit;
use super::output;
use super::table::table;
use crate::service::capture::{Presence, TrackerState};
use crate::service::{DaemonAnswer, DirectJob, Direction, Label, TakeEntry, direct, takes};

/// A daemon answers within milliseconds; a busy machine is given time.
const PATIENCE: Duration = Duration::from_secs(5);

pub(super) fn run(arguments: TakeArguments) -> anyhow::Result<Exit> {
    let is_status = matches!(arguments.wanted, Wanted::Status);
    let mut marks_topic = "/marks".to_owned();
    let direction = match arguments.wanted {
        Wanted::Start => Direction::Start,
        Wanted::Stop(stop) => Direction::Stop {
            label: Label {
                name: stop.name,
                note: stop.note,
                rating: stop.rating,
            },
            waits: stop.wait,
        },
        Wanted::List { folder, format } => return list(&folder, format),
        Wanted::Discard => Direction::Discard,
        Wanted::Status => Direction::Ask,
        Wanted::Mark { event, topic } => {
            marks_topic = topic;
            Direction::Mark(event)
        }
    };
    let answers = direct(&DirectJob {
        direction,
        marks_topic,
        iceoryx2: arguments.iceoryx2,
        token: arguments.token,
        patience: PATIENCE,
    })?;
    let mut exit = Exit::Done;
    for answer in &answers {
        let (text, of_it) = account(answer, is_status);
        output::print(&text)?;
        exit = exit.max(of_it);
    }
    Ok(exit)
}

/// What is said of an answer.
fn account(answer: &DaemonAnswer, is_status: bool) -> (String, Exit) {
    match answer {
        DaemonAnswer::Asked {
            take,
            messages,
            scene: _,
            events: _,
            trackers,
            troubles,
            page,
        } => {
            let mut text = take.map_or("no take runs\n".to_owned(), |take| {
                format!("take {take}: {messages} samples and marks\n")
            });
            if !is_status {
                return (text, Exit::Done);
            }
            text.push_str(&of_trackers(trackers));
            for trouble in troubles {
                text.push_str(&format!("  trouble: {}\n", crate::report::plain(trouble)));
            }
            if let Some(page) = page {
                text.push_str(&format!("  operator's page: {page}\n"));
            }
            let is_silent = |tracker: &TrackerState| tracker.state == Presence::Silent;
            let is_well = troubles.is_empty() && !trackers.iter().any(is_silent);
            (text, if is_well { Exit::Done } else { Exit::NotWhole })
        }
        DaemonAnswer::Started {
            take,
            unheard,
            troubles,
        } => {
            for trouble in troubles {
                output::print_warning(&crate::report::plain(trouble));
            }
            for topic in unheard {
                output::print_warning(&format!("nothing comes on {topic}: does its tracker send?"));
            }
            let exit = match troubles.is_empty() {
                true => Exit::Done,
                false => Exit::NotWhole,
            };
            (format!("take {take} begins\n"), exit)
        }
        DaemonAnswer::Closed {
            take,
            messages,
            recording,
        } => {
            let recording = crate::report::plain(recording);
            let text = format!(
                "take {take} is over: {messages} samples and marks\n  written {recording}\n"
            );
            (text, Exit::Done)
        }
        DaemonAnswer::Discarded { take, recording } => match recording {
            Some(recording) => {
                let recording = crate::report::plain(recording);
                let text = format!("take {take} is discarded\n  moved to {recording}\n");
                (text, Exit::Done)
            }
            None => {
                let text = format!("take {take} is discarded, but could not be moved aside\n");
                (text, Exit::NotWhole)
            }
        },
        DaemonAnswer::Broken { take, error } => {
            let error = crate::report::plain(error);
            (
                format!("take {take} could not be recorded: {error}\n"),
                Exit::Error,
            )
        }
        DaemonAnswer::Estimated {
            take,
            output,
            verdict,
            is_good,
            reason,
            doubts,
        } => {
            let why = doubts.first().unwrap_or(reason);
            let text = format!(
                "take {take}: {verdict}: {}\n  written {}\n",
                crate::report::plain(why),
                crate::report::plain(output)
            );
            (text, if *is_good { Exit::Done } else { Exit::NotWhole })
        }
        DaemonAnswer::NotEstimated { take, error, .. } => {
            let error = crate::report::plain(error);
            (
                format!("take {take}: not estimated: {error}\n"),
                Exit::Error,
            )
        }
        DaemonAnswer::Refused { reason } => {
            let reason = crate::report::plain(reason);
            (format!("refused: {reason}\n"), Exit::Error)
        }
        DaemonAnswer::Other => ("an answer that is not understood\n".to_owned(), Exit::Error),
    }
}

/// Prints the takes in a folder; done but not whole where one cannot be read.
fn list(folder: &Path, format: Format) -> anyhow::Result<Exit> {
    let takes = takes(folder)?;
    match format {
        Format::Text => output::print(&of_takes(&takes))?,
        Format::Ndjson => takes
            .iter()
            .try_for_each(|take| output::print_json("enact.take/1", take))?,
    }
    let is_whole = takes.iter().all(|take| take.error.is_none());
    Ok(if is_whole { Exit::Done } else { Exit::NotWhole })
}

fn of_takes(takes: &[TakeEntry]) -> String {
    let dash = || "-".to_owned();
    let rows: Vec<Vec<String>> = takes
        .iter()
        .map(|take| {
            vec![
                take.number.map_or_else(dash, |number| number.to_string()),
                take.name.clone().unwrap_or_else(dash),
                take.rating
                    .map_or_else(dash, |rating| format!("{rating} of 5")),
                take.messages.to_string(),
                take.verdict.clone().unwrap_or_else(dash),
                take.recording.clone(),
                take.error.clone().unwrap_or_else(|| said(take)),
            ]
        })
        .collect();
    let head = [
        "take", "name", "rating", "messages", "verdict", "file", "note",
    ];
    table("", &head, &rows)
}

/// The note on a take, and what speaks against its motion.
fn said(take: &TakeEntry) -> String {
    let against = take.why.clone().filter(|_| take.is_good == Some(false));
    let said = take.note.iter().cloned().chain(against);
    said.collect::<Vec<_>>().join("; ")
}

fn of_trackers(trackers: &[TrackerState]) -> String {
    let rows: Vec<Vec<String>> = trackers
        .iter()
        .map(|of| {
            let valid = of
                .valid_share
                .map(|share| format!("{:.0} %", 100.0 * share));
            let seen = of.seen_s.map(|seen_s| format!("{seen_s:.1} s ago"));
            vec![
                of.topic.clone(),
                of.state.as_str().to_owned(),
                format!("{:.1} Hz", of.rate_hz),
                valid.unwrap_or_else(|| "-".into()),
                seen.unwrap_or_else(|| "never".into()),
            ]
        })
        .collect();
    table(
        "  ",
        &["tracker", "state", "rate", "valid", "last sample"],
        &rows,
    )
}
