//! What the acting page says: texts in JSON, and readings in the layout that iceoryx2 carries.
//!
//! | message | is |
//! |---|---|
//! | text `{"say": "pair", "code": "042137"}` | the first one of a page that is new |
//! | text `{"say": "resume", "key": "…"}` | the first one of a page that was let in before |
//! | text `{"say": "act", "stream": 0}` | from now on this page is the tracker of that stream |
//! | text `{"say": "start"}`, `{"say": "stop", "name": "", "note": "", "rating": 0}`, `{"say": "discard"}` | as the operator's page orders |
//! | text `{"say": "mark", "event": "", "device_ns": 0}` | an event happened then, on the clock of the readings |
//! | text `{"say": "calibrate", "step": "plane", "stream": 0, "takes": [3], "feature": "tip", "surface": "table", "stands": []}` | a step of a calibration, of these takes |
//! | bytes: the stream as `u32`, zero as `u32`, then 1 to 64 readings as `enact.Pose.1` | readings of the stream |
//!
//! Of a reading `sequence`, `device_ns`, `position_m`, `quaternion_xyzw` and `flags` count. The daemon says itself when
//! it came, and who sent it.

use serde::Deserialize;
use thiserror::Error;

use super::super::director::{DirectorOrder, TakeRemarks};
use super::calibration::CalibrationWish;
use crate::ingest::live::{POSE_BYTES, PoseRecord};

/// Longest message of a page \[bytes\]: the most readings that come at once.
pub(super) const MESSAGE_BYTES: usize = HEAD_BYTES + READINGS * POSE_BYTES;

/// Most readings in a message.
const READINGS: usize = 64;

const HEAD_BYTES: usize = 8;

/// What a text says.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(tag = "say", rename_all = "snake_case", deny_unknown_fields)]
pub(super) enum PageText {
    /// It knows the code.
    Pair {
        /// The digits.
        code: String,
    },
    /// It was let in before.
    Resume {
        /// The key that it was given.
        key: String,
    },
    /// It is the tracker of a stream.
    Act {
        /// Index of the stream.
        stream: usize,
    },
    /// Begin a take.
    Start,
    /// End the take and estimate it.
    Stop(TakeRemarks),
    /// End the take and move it aside.
    Discard,
    /// An event happened.
    Mark {
        /// Its name; empty: the next one.
        #[serde(default)]
        event: String,
        /// When, on the clock of the readings \[ns\].
        device_ns: i64,
    },
    /// A step of a calibration.
    Calibrate(CalibrationWish),
}

/// PageReadings of a stream.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct PageReadings {
    /// Index of the stream.
    pub(super) stream: usize,
    /// At least one, as sent.
    pub(super) records: Vec<PoseRecord>,
}

/// Why a message is none of the page's.
#[derive(Debug, Error, PartialEq, Eq)]
pub(super) enum MessageError {
    /// A text that says nothing.
    #[error("no message of the acting page: {0}")]
    Text(String),
    /// Bytes that are no readings.
    #[error(
        "{0} bytes, expected 8 of the stream and then 1 to 64 readings of 96 each, as `enact.Pose.1`"
    )]
    Length(usize),
    /// The second word of the head, or a bit that means nothing.
    #[error("a bit is set that means nothing")]
    Bits,
}

impl PageText {
    /// What a text says.
    pub(super) fn read(text: &str) -> Result<Self, MessageError> {
        serde_json::from_str(text).map_err(|error| MessageError::Text(error.to_string()))
    }

    /// As an order to the recorder, if it is one.
    pub(super) fn order(self) -> Option<DirectorOrder> {
        match self {
            Self::Start => Some(DirectorOrder::Start),
            Self::Stop(remarks) => Some(DirectorOrder::Stop(remarks)),
            Self::Discard => Some(DirectorOrder::Discard),
            Self::Pair { .. }
            | Self::Resume { .. }
            | Self::Act { .. }
            | Self::Mark { .. }
            | Self::Calibrate(_) => None,
        }
    }
}

impl PageReadings {
    /// The readings in bytes.
    pub(super) fn read(bytes: &[u8]) -> Result<Self, MessageError> {
        let length = || MessageError::Length(bytes.len());
        let (head, readings) = bytes.split_first_chunk::<HEAD_BYTES>().ok_or_else(length)?;
        let (readings, rest) = readings.as_chunks::<POSE_BYTES>();
        if !rest.is_empty() || !(1..=READINGS).contains(&readings.len()) {
            return Err(length());
        }
        let [a, b, c, d, zero @ ..] = *head;
        let records: Vec<PoseRecord> = readings.iter().map(PoseRecord::of_bytes).collect();
        if zero != [0; 4] || records.iter().any(|record| record.has_unknown_flags()) {
            return Err(MessageError::Bits);
        }
        Ok(Self {
            stream: u32::from_le_bytes([a, b, c, d]) as usize,
            records,
        })
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::calibration::CalibrationStep;
    use super::*;

    fn bytes(stream: u32, records: &[PoseRecord]) -> Vec<u8> {
        let mut bytes = stream.to_le_bytes().to_vec();
        bytes.extend([0; 4]);
        for record in records {
            bytes.extend(record.to_bytes());
        }
        bytes
    }

    #[test]
    fn readings_come_as_they_were_sent() {
        let records: Vec<PoseRecord> = (0..READINGS as u64).map(PoseRecord::numbered).collect();
        for count in [1, 2, READINGS] {
            let read = PageReadings::read(&bytes(3, &records[..count])).expect("readings");
            assert_eq!((read.stream, &read.records[..]), (3, &records[..count]));
        }
        let more = [&records[..], &records[..1]].concat();
        for wrong in [bytes(3, &[]), bytes(3, &more), vec![0; 7], Vec::new()] {
            let expected = Err(MessageError::Length(wrong.len()));
            assert_eq!(PageReadings::read(&wrong), expected);
        }
        let mut odd = records[0];
        odd.flags = 2;
        assert_eq!(
            PageReadings::read(&bytes(3, &[odd])),
            Err(MessageError::Bits)
        );
        let mut head = bytes(3, &records[..1]);
        head[5] = 1;
        assert_eq!(PageReadings::read(&head), Err(MessageError::Bits));
    }

    #[test]
    fn texts_say_one_thing_and_nothing_besides() {
        let mark = PageText::Mark {
            event: String::new(),
            device_ns: 12,
        };
        let stop = |name: &str| {
            PageText::Stop(TakeRemarks {
                name: name.to_owned(),
                note: String::new(),
                rating: 0,
            })
        };
        for (text, expected) in [
            (r#"{"say":"act","stream":1}"#, PageText::Act { stream: 1 }),
            (r#"{"say":"mark","device_ns":12}"#, mark),
            (r#"{"say":"start"}"#, PageText::Start),
            (r#"{"say":"stop"}"#, stop("")),
            (r#"{"say":"stop","name":"a throw"}"#, stop("a throw")),
            (
                r#"{"say":"calibrate","step":"rest","stream":0,"takes":[3,4],"stands":["+z","-x"]}"#,
                PageText::Calibrate(CalibrationWish {
                    step: CalibrationStep::Rest,
                    stream: 0,
                    takes: vec![3, 4],
                    feature: None,
                    surface: None,
                    stands: vec!["+z".to_owned(), "-x".to_owned()],
                }),
            ),
        ] {
            assert_eq!(PageText::read(text), Ok(expected));
        }
        for wrong in [
            "",
            "{}",
            r#"{"say":"quit"}"#,
            r#"{"say":"act"}"#,
            r#"{"say":"act","stream":-1}"#,
            r#"{"say":"act","stream":0,"more":1}"#,
            r#"{"say":"stop","more":1}"#,
            r#"{"say":"mark","device_ns":1e99}"#,
            r#"{"say":"calibrate","step":"clock","stream":0,"takes":[3]}"#,
            r#"{"say":"calibrate","step":"rest","stream":0,"takes":["/etc/passwd"]}"#,
            r#"{"say":"calibrate","step":"rest","stream":0}"#,
        ] {
            assert!(PageText::read(wrong).is_err(), "{wrong}");
        }
    }

    proptest! {
        /// Whatever bytes come: they are readings, all of which are theirs, or refused.
        #[test]
        fn any_bytes_are_readings_or_refused(
            given in prop_oneof![
                prop::collection::vec(any::<u8>(), 0..400),
                (any::<u32>(), 0..70_usize, any::<u8>()).prop_map(|(stream, count, fill)| {
                    let mut bytes = stream.to_le_bytes().to_vec();
                    bytes.extend([0; 4]);
                    bytes.extend(vec![fill & 1; count * POSE_BYTES]);
                    bytes
                }),
            ],
        ) {
            if let Ok(read) = PageReadings::read(&given) {
                let stream = u32::try_from(read.stream).expect("32 bits");
                // NaN is not equal to itself, its bits are.
                prop_assert_eq!(bytes(stream, &read.records), given);
            }
        }

        /// Whatever text comes: it is one of the page's messages, or refused.
        #[test]
        fn any_text_is_a_message_or_refused(text in "\\PC{0,80}|\\{\"say\":\"[a-z]{0,8}\"[ -~]{0,40}") {
            if let Ok(said) = PageText::read(&text) {
                prop_assert!(text.contains("say"), "{:?}", said);
            }
        }
    }
}
