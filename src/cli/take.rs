//! `take`: sends one command to a running daemon and prints its answer.

use std::time::Duration;

use super::arguments::{TakeArguments, Wanted};
use super::exit::Exit;
use super::output;
use crate::service::{DirectJob, Direction, TakeState, direct};

/// A daemon answers within milliseconds; a busy machine is given time.
const PATIENCE: Duration = Duration::from_secs(5);

pub(super) fn run(arguments: TakeArguments) -> anyhow::Result<Exit> {
    let answer = direct(&DirectJob {
        direction: match arguments.wanted {
            Wanted::Start => Direction::Start,
            Wanted::Stop => Direction::Stop,
            Wanted::Discard => Direction::Discard,
            Wanted::Status => Direction::Ask,
            Wanted::Mark => Direction::Mark(arguments.event),
        },
        marks_topic: arguments.topic,
        iceoryx2: arguments.iceoryx2,
        patience: PATIENCE,
    })?;
    let (take, messages) = (answer.take, answer.messages);
    let (text, exit) = match answer.state {
        Some(TakeState::Ready) => ("no take runs".to_owned(), Exit::Done),
        Some(TakeState::Recording) if arguments.wanted == Wanted::Start => {
            (format!("take {take} begins"), Exit::Done)
        }
        Some(TakeState::Recording) => (
            format!("take {take}: {messages} samples and marks"),
            Exit::Done,
        ),
        Some(TakeState::Closed) => (
            format!("take {take} is over: {messages} samples and marks"),
            Exit::Done,
        ),
        Some(TakeState::Discarded) => (format!("take {take} is discarded"), Exit::Done),
        Some(TakeState::Refused) => ("refused: no take runs".to_owned(), Exit::Error),
        Some(TakeState::Broken) => (format!("take {take} could not be recorded"), Exit::Error),
        Some(TakeState::Estimated | TakeState::NotEstimated) | None => (
            format!("take {take}: an answer that is not understood"),
            Exit::Error,
        ),
    };
    output::print(&format!("{text}\n"))?;
    Ok(exit)
}
