//! Changes of marks.

use std::collections::BTreeSet;
use std::path::PathBuf;

use anyhow::{Context, bail, ensure};

use crate::ingest::{ListedMark, MarkTime, marks_of_file, read_text};
use crate::motion::{Mark, Scene, Stamp};
use crate::service::finish::Opened;

/// What is changed, in this order: other marks in place of all, then some left out, moved, added.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MarkEdits {
    /// A list of marks, JSON or CSV, that takes the place of the recording's.
    pub from_file: Option<PathBuf>,
    /// A topic of the recording whose messages do.
    pub from_topic: Option<String>,
    /// Marks to leave out: a number as listed, the name of an event, or `all`.
    pub remove: Vec<String>,
    /// Marks to move, and where to.
    pub moves: Vec<(String, MarkTime)>,
    /// Marks to add.
    pub add: Vec<ListedMark>,
}

impl MarkEdits {
    /// Whether nothing is changed.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

/// A mark, and the message that it is in the recording.
#[derive(Clone, Debug)]
pub(super) struct PlacedMark {
    pub(super) mark: Mark,
    /// Place of its message among all, from 0; `None` for one that is added.
    place: Option<u64>,
    log_time: Stamp,
}

/// The marks after the changes.
pub(super) struct Edited {
    /// In order of time.
    pub(super) marks: Vec<PlacedMark>,
    /// Places of the messages that are no longer among them.
    pub(super) without: BTreeSet<u64>,
}

impl Edited {
    /// The marks that have no message yet, with when they are logged.
    pub(super) fn added(&self) -> impl Iterator<Item = (Stamp, Mark)> + '_ {
        let added = self.marks.iter().filter(|of| of.place.is_none());
        added.map(|of| (of.log_time, of.mark.clone()))
    }
}

/// The recording's own marks, in order of time.
pub(super) fn present(opened: &Opened) -> anyhow::Result<Vec<PlacedMark>> {
    let topic = &opened.scene.for_reading().marks_topic;
    if !opened
        .recording
        .container()
        .topics()
        .contains(topic.as_str())
    {
        return Ok(Vec::new());
    }
    let messages = opened.recording.marks_on(topic)?;
    let mut marks: Vec<PlacedMark> = messages
        .into_iter()
        .map(|message| PlacedMark {
            mark: message.mark,
            place: Some(message.place),
            log_time: message.log_time,
        })
        .collect();
    marks.sort_by_key(|of| of.mark.stamp);
    Ok(marks)
}

/// The marks with the changes. Times count from the first pose, and messages are logged so much later than
/// they are stamped.
pub(super) fn edited(
    mut marks: Vec<PlacedMark>,
    edits: &MarkEdits,
    opened: &Opened,
    first: Stamp,
    offset_ns: i64,
) -> anyhow::Result<Edited> {
    let scene = opened.scene.for_reading();
    let mut without = BTreeSet::new();
    let placed = |stamp: Stamp, event: Option<String>| PlacedMark {
        mark: Mark { stamp, event },
        place: None,
        log_time: Stamp(stamp.0.saturating_add(offset_ns).max(0)),
    };
    let new = |(time, event): &ListedMark| -> anyhow::Result<PlacedMark> {
        if let Some(event) = event {
            check_event(event, scene)?;
        }
        Ok(placed(stamp_of(*time, first)?, event.clone()))
    };
    let replaced: Option<Vec<PlacedMark>> = match (&edits.from_file, &edits.from_topic) {
        (Some(file), _) => {
            let text = read_text(file)
                .with_context(|| format!("{}: cannot read the marks", file.display()))?;
            let listed = marks_of_file(file, &text)?;
            Some(listed.iter().map(new).collect::<Result<_, _>>()?)
        }
        (None, Some(topic)) => Some(of_topic(opened, topic, &placed, offset_ns)?),
        (None, None) => None,
    };
    if let Some(replaced) = replaced {
        without.extend(marks.iter().filter_map(|of| of.place));
        marks = replaced;
        marks.sort_by_key(|of| of.mark.stamp);
    }
    // Numbers are those of the list before anything is left out or moved.
    let mut listed: Vec<Option<PlacedMark>> = marks.into_iter().map(Some).collect();
    for which in &edits.remove {
        let found = if which == "all" {
            (0..listed.len()).collect()
        } else {
            vec![find(which, &listed)?]
        };
        for index in found {
            without.extend(listed[index].take().and_then(|of| of.place));
        }
    }
    for (which, time) in &edits.moves {
        let index = find(which, &listed)?;
        if let Some(of) = listed[index].take() {
            without.extend(of.place);
            listed[index] = Some(placed(stamp_of(*time, first)?, of.mark.event));
        }
    }
    let mut marks: Vec<PlacedMark> = listed.into_iter().flatten().collect();
    for of in &edits.add {
        marks.push(new(of)?);
    }
    marks.sort_by_key(|of| of.mark.stamp);
    for (index, of) in marks.iter().enumerate() {
        let same =
            |other: &&PlacedMark| of.mark.event.is_some() && other.mark.event == of.mark.event;
        ensure!(
            edits.is_empty() || !marks[..index].iter().any(|other| same(&other)),
            "a second mark of {:?}, expected one: --move moves the one that is there",
            of.mark.event.as_deref().unwrap_or_default()
        );
    }
    Ok(Edited { marks, without })
}

/// The messages of a topic as marks. Those with no stamp of their own are stamped by when they were logged,
/// on the clock of the samples.
fn of_topic(
    opened: &Opened,
    topic: &str,
    placed: &dyn Fn(Stamp, Option<String>) -> PlacedMark,
    offset_ns: i64,
) -> anyhow::Result<Vec<PlacedMark>> {
    let messages = opened.recording.marks_on(topic)?;
    let marks = messages.into_iter().map(|message| {
        let stamp = if message.is_stamped {
            message.mark.stamp
        } else {
            Stamp(message.log_time.0.saturating_sub(offset_ns))
        };
        if let Some(event) = &message.mark.event {
            check_event(event, opened.scene.for_reading())?;
        }
        Ok(placed(stamp, message.mark.event))
    });
    marks.collect()
}

/// The index of a mark that is meant by its number, from 1, or by the name of its event.
fn find(which: &str, marks: &[Option<PlacedMark>]) -> anyhow::Result<usize> {
    let named: Vec<usize> = (0..marks.len())
        .filter(|index| {
            let mark = marks[*index].as_ref();
            mark.is_some_and(|of| of.mark.event.as_deref() == Some(which))
        })
        .collect();
    let number = which.parse::<usize>().ok();
    let number = number.and_then(|number| number.checked_sub(1));
    match (named.as_slice(), number) {
        ([index], _) => return Ok(*index),
        ([], Some(index)) if marks.get(index).is_some_and(Option::is_some) => return Ok(index),
        _ => {}
    }
    let present = marks.iter().enumerate().filter_map(|(index, of)| {
        let event = of.as_ref()?.mark.event.as_deref().unwrap_or("(next)");
        Some(format!("{} {event}", index + 1))
    });
    let present: Vec<String> = present.collect();
    if named.len() > 1 {
        bail!(
            "{which:?} is {} marks, expected the number of one; there are {}",
            named.len(),
            present.join(", ")
        );
    }
    if present.is_empty() {
        bail!("no mark {which:?}: there are none");
    }
    bail!("no mark {which:?}; there are {}", present.join(", "))
}

/// A time as a stamp.
pub(in crate::service) fn stamp_of(time: MarkTime, first: Stamp) -> anyhow::Result<Stamp> {
    let ns = match time {
        MarkTime::Stamp(ns) => Some(ns),
        MarkTime::SinceFirst(ns) => first.0.checked_add(ns),
    };
    match ns {
        Some(ns) if ns >= 0 => Ok(Stamp(ns)),
        _ => bail!("a mark before time 0 of the recording's clock, expected one at its motion"),
    }
}

/// Fails for the name of an event that the scene does not have.
pub(in crate::service) fn check_event(event: &str, scene: &Scene) -> anyhow::Result<()> {
    let names: Vec<&str> = scene.events.iter().map(|of| of.name.as_str()).collect();
    ensure!(
        scene.has_event_named(event),
        "no event {event:?} in the scene, which has {}",
        names.join(", ")
    );
    Ok(())
}
