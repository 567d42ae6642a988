//! The payloads of the contract: layouts, type names, and the meaning of their fields.
//!
//! All words are little-endian and aligned to eight bytes, in the order of the fields; there is
//! no padding. Times are nanoseconds; [`NO_TIME`] where there is none.

use iceoryx2::prelude::ZeroCopySend;

use super::token::TOKEN_BYTES;
use crate::motion::{Mark, PoseSample, Stamp};

/// The value of a time that is not known.
pub const NO_TIME: i64 = i64::MIN;

/// Bit 0 of [`PoseRecord::flags`]: the tracker vouches for the pose.
pub const VALID: u32 = 1;

/// Bytes of a [`PoseRecord`].
pub const POSE_BYTES: usize = 96;

/// Bytes for a name: 64 characters of any script.
pub const NAME_BYTES: usize = 256;

/// Bytes for a note.
pub const NOTE_BYTES: usize = 1024;

/// Bytes of a part of an answer.
pub const PART_BYTES: usize = 4000;

/// One reading of one tracker: `enact.Pose.1`, 96 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, ZeroCopySend)]
#[type_name("enact.Pose.1")]
pub struct PoseRecord {
    /// Counts the readings of this publisher by one, from any beginning; missing numbers are lost
    /// readings.
    pub sequence: u64,
    /// When the driver had the reading \[ns since 1970, system clock\].
    pub available_ns: i64,
    /// When it was measured, on the system clock \[ns since 1970\]; [`NO_TIME`] if the driver
    /// does not know.
    pub sample_ns: i64,
    /// Time of the device's own clock, unchanged \[ns, any zero\]; [`NO_TIME`] if it has none.
    pub device_ns: i64,
    /// Position [m, world].
    pub position_m: [f64; 3],
    /// Orientation, world from tracker, as `[x, y, z, w]`.
    pub quaternion_xyzw: [f64; 4],
    /// [`VALID`] where the tracker vouches for the pose; the other bits are zero.
    pub flags: u32,
    /// A number that differs for every start of the publisher.
    pub session: u32,
}

/// An event happens now: `enact.Mark.1`, 296 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, ZeroCopySend)]
#[type_name("enact.Mark.1")]
pub struct MarkRecord {
    /// As [`PoseRecord::sequence`].
    pub sequence: u64,
    /// As [`PoseRecord::available_ns`].
    pub available_ns: i64,
    /// When it happened, on the clock of the poses' `sample_ns`; [`NO_TIME`]: on arrival.
    pub sample_ns: i64,
    /// As [`PoseRecord::device_ns`].
    pub device_ns: i64,
    /// Name of the scene's event in UTF-8, zeros after it; all zero: the next one in order.
    pub event: [u8; NAME_BYTES],
    /// No bits are defined; zero.
    pub flags: u32,
    /// As [`PoseRecord::session`].
    pub session: u32,
}

/// A command to the daemon: `enact.Control.2`, 40 bytes. The same bytes again are the same
/// command: it is answered as before and not executed twice.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, ZeroCopySend)]
#[type_name("enact.Control.2")]
pub struct ControlRecord {
    /// As [`PoseRecord::sequence`].
    pub sequence: u64,
    /// As [`PoseRecord::available_ns`].
    pub available_ns: i64,
    /// See [`Command`]; any other number is refused.
    pub command: u32,
    /// As [`PoseRecord::session`].
    pub session: u32,
    /// The daemon's [`Token`](super::token::Token); of [`Command::Ask`] it is not looked at.
    pub token: [u8; TOKEN_BYTES],
}

/// What a director says of the take that runs: `enact.Label.1`, 1304 bytes. Of several the later
/// one holds, but for what it leaves empty.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, ZeroCopySend)]
#[type_name("enact.Label.1")]
pub struct LabelRecord {
    /// As [`PoseRecord::sequence`].
    pub sequence: u64,
    /// As [`PoseRecord::available_ns`].
    pub available_ns: i64,
    /// A name in UTF-8, zeros after it; all zero: none.
    pub name: [u8; NAME_BYTES],
    /// A note in UTF-8, zeros after it; all zero: none.
    pub note: [u8; NOTE_BYTES],
    /// 1 (bad) to 5 (good); 0: none.
    pub rating: u32,
    /// As [`PoseRecord::session`].
    pub session: u32,
}

/// A part of what the daemon says, in words: `enact.Answer.1`, 4048 bytes. The text of all parts is
/// one JSON object, a line of `enact capture --format ndjson`; of `estimated` it has the verdict and
/// the files.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, ZeroCopySend)]
#[type_name("enact.Answer.1")]
pub struct AnswerRecord {
    /// Counts the answers of this daemon; the same in all parts of one.
    pub sequence: u64,
    /// When it was published \[ns since 1970\].
    pub available_ns: i64,
    /// Sequence number of the control message that this answers.
    pub control_sequence: u64,
    /// Session of that message; 0: it answers none.
    pub control_session: u32,
    /// Number of the part, from 0.
    pub part: u32,
    /// Number of parts.
    pub parts: u32,
    /// Bytes of `text` that are used.
    pub length: u32,
    /// A part of the text in UTF-8; a character may go on in the next part.
    pub text: [u8; PART_BYTES],
    /// Zero.
    pub reserved: u64,
}

/// Commands to the daemon.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Command {
    /// 1: begin a take; a running one is stopped first.
    Start,
    /// 2: end the take and estimate it.
    Stop,
    /// 3: end the take and move it aside.
    Discard,
    /// 4: report the state; changes nothing.
    Ask,
}

/// The state of a take: `enact.Take.1`, 48 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, ZeroCopySend)]
#[type_name("enact.Take.1")]
pub struct TakeRecord {
    /// Counts the records of this daemon.
    pub sequence: u64,
    /// When it was published \[ns since 1970\].
    pub available_ns: i64,
    /// The take, counted from 1 since the daemon's start; 0: none yet.
    pub take: u64,
    /// Poses and marks journalled in it so far.
    pub messages: u64,
    /// See [`TakeState`].
    pub state: u32,
    /// Session of the control message that this answers; 0: it answers none.
    pub control_session: u32,
    /// Sequence number of that message.
    pub control_sequence: u64,
}

/// The state of a take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TakeState {
    /// 0: the daemon listens, no take runs.
    Ready,
    /// 1: samples are journalled.
    Recording,
    /// 2: the journal is complete and has its final name.
    Closed,
    /// 3: removed.
    Discarded,
    /// 4: recording stopped by an error; what was journalled so far is kept.
    Broken,
    /// 5: its estimate is written.
    Estimated,
    /// 6: it has no estimate; the daemon's log says why.
    NotEstimated,
    /// 7: a control message was refused: it is not possible in this state, or its command is
    /// unknown.
    Refused,
}

/// An estimate's numbers: `enact.Estimate.1`, 96 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, ZeroCopySend)]
#[type_name("enact.Estimate.1")]
pub struct EstimateRecord {
    /// Counts the estimates of this publisher.
    pub sequence: u64,
    /// When it was ready \[ns since 1970\].
    pub available_ns: i64,
    /// The take, as in [`TakeRecord::take`].
    pub take: u64,
    /// Number of marks that it uses.
    pub marks: u64,
    /// Physical time zero on the clock of the samples \[ns\].
    pub origin_ns: i64,
    /// Number of frames that follow on the services of all bodies together.
    pub frames: u64,
    /// Value of the objective (paper eq. 1, 6) at the estimate.
    pub objective: f64,
    /// Duration of the motion \[s\].
    pub physical_s: f64,
    /// Root mean square distance over all samples \[m\].
    pub residual_m: f64,
    /// Root mean square angle over all samples \[rad\].
    pub residual_rad: f64,
    /// Solver iterations.
    pub iterations: u64,
    /// 0 failed, 1 plausible, 2 physical.
    pub verdict: u32,
    /// 1 where the take is over and the estimate checked and written; 0 for a preview.
    pub is_final: u32,
}

/// One frame of an estimated motion: `enact.EstimatedPose.1`, 96 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, ZeroCopySend)]
#[type_name("enact.EstimatedPose.1")]
pub struct EstimatedPoseRecord {
    /// [`EstimateRecord::sequence`] of the estimate that it belongs to.
    pub estimate: u64,
    /// The take.
    pub take: u64,
    /// Number of the frame, from 0.
    pub index: u64,
    /// Number of frames of this body.
    pub count: u64,
    /// Physical time, on the clock of the samples \[ns\].
    pub sample_ns: i64,
    /// Centre of mass [m, world].
    pub position_m: [f64; 3],
    /// Orientation, world from body, as `[x, y, z, w]`.
    pub quaternion_xyzw: [f64; 4],
}

impl PoseRecord {
    /// Whether the tracker vouches for the pose.
    pub fn is_valid(&self) -> bool {
        self.flags & VALID != 0
    }

    /// The pose as sent, with the given stamp; its numbers may not be finite.
    pub fn pose(&self, stamp: Stamp) -> PoseSample {
        PoseSample::new(stamp, self.position_m.into(), self.quaternion_xyzw)
    }

    /// Whether a bit is set that means nothing.
    pub fn has_unknown_flags(&self) -> bool {
        self.flags & !VALID != 0
    }

    /// The record of its words in their order, little-endian; every bit pattern is one.
    pub fn of_bytes(bytes: &[u8; POSE_BYTES]) -> Self {
        let word = |number: usize| {
            let mut word = [0; 8];
            word.copy_from_slice(&bytes[8 * number..8 * (number + 1)]);
            u64::from_le_bytes(word)
        };
        let time_ns = |number| word(number).cast_signed();
        let number = |at| f64::from_bits(word(at));
        let [flags, session] = [word(11) as u32, (word(11) >> 32) as u32];
        Self {
            sequence: word(0),
            available_ns: time_ns(1),
            sample_ns: time_ns(2),
            device_ns: time_ns(3),
            position_m: [number(4), number(5), number(6)],
            quaternion_xyzw: [number(7), number(8), number(9), number(10)],
            flags,
            session,
        }
    }

    /// The words in their order, little-endian: what a journal keeps.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = head(
            self.sequence,
            self.available_ns,
            self.sample_ns,
            self.device_ns,
        );
        for number in self.position_m.iter().chain(&self.quaternion_xyzw) {
            bytes.extend(number.to_le_bytes());
        }
        tail(bytes, self.flags, self.session)
    }
}

impl MarkRecord {
    /// The mark with the given stamp; `None` where the name is not UTF-8 or contains a zero.
    pub fn mark(&self, stamp: Stamp) -> Option<Mark> {
        let name = unpadded(&self.event)?;
        Some(Mark {
            stamp,
            event: (!name.is_empty()).then(|| name.to_owned()),
        })
    }

    /// A name as zero-padded bytes; a longer one is cut after a whole character.
    pub fn event_bytes(name: &str) -> [u8; NAME_BYTES] {
        padded(name)
    }

    /// The words in their order, little-endian: what a journal keeps.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = head(
            self.sequence,
            self.available_ns,
            self.sample_ns,
            self.device_ns,
        );
        bytes.extend(self.event);
        tail(bytes, self.flags, self.session)
    }
}

impl LabelRecord {
    /// A label; texts that are too long are cut after a whole character.
    pub fn new(session: u32, now_ns: i64, name: &str, note: &str, rating: u32) -> Self {
        Self {
            sequence: 0,
            available_ns: now_ns,
            name: padded(name),
            note: padded(note),
            rating,
            session,
        }
    }

    /// Name and note; `None` where they are not UTF-8 or contain a zero.
    pub fn texts(&self) -> Option<(&str, &str)> {
        Some((unpadded(&self.name)?, unpadded(&self.note)?))
    }
}

impl AnswerRecord {
    /// A text in as many parts as it needs.
    pub fn parts(
        sequence: u64,
        now_ns: i64,
        asked: Option<(u32, u64)>,
        text: &str,
    ) -> impl Iterator<Item = Self> {
        let (control_session, control_sequence) = asked.unwrap_or((0, 0));
        let parts = text.len().div_ceil(PART_BYTES) as u32;
        let pieces = text.as_bytes().chunks(PART_BYTES);
        pieces.zip(0..).map(move |(piece, part)| {
            let mut text = [0; PART_BYTES];
            text[..piece.len()].copy_from_slice(piece);
            Self {
                sequence,
                available_ns: now_ns,
                control_sequence,
                control_session,
                part,
                parts,
                length: piece.len() as u32,
                text,
                reserved: 0,
            }
        })
    }

    /// The bytes of the part.
    pub fn bytes(&self) -> &[u8] {
        &self.text[..(self.length as usize).min(PART_BYTES)]
    }
}

/// A text as zero-padded bytes; a longer one is cut after a whole character.
fn padded<const N: usize>(text: &str) -> [u8; N] {
    let mut end = text.len().min(N);
    while !text.is_char_boundary(end) {
        end -= 1;
    }
    let mut bytes = [0; N];
    bytes[..end].copy_from_slice(&text.as_bytes()[..end]);
    bytes
}

/// The text of zero-padded bytes; `None` where it is not UTF-8 or contains a zero, which no message
/// can hold inside a text.
fn unpadded(bytes: &[u8]) -> Option<&str> {
    let length = bytes.iter().rposition(|byte| *byte != 0);
    let text = std::str::from_utf8(&bytes[..length.map_or(0, |last| last + 1)]).ok()?;
    (!text.contains('\0')).then_some(text)
}

fn head(sequence: u64, available_ns: i64, sample_ns: i64, device_ns: i64) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(96);
    bytes.extend(sequence.to_le_bytes());
    for time_ns in [available_ns, sample_ns, device_ns] {
        bytes.extend(time_ns.to_le_bytes());
    }
    bytes
}

fn tail(mut bytes: Vec<u8>, flags: u32, session: u32) -> Vec<u8> {
    bytes.extend(flags.to_le_bytes());
    bytes.extend(session.to_le_bytes());
    bytes
}

impl Command {
    /// The command with a number; `None` for an unknown number.
    pub fn of(number: u32) -> Option<Self> {
        [
            Command::Start,
            Command::Stop,
            Command::Discard,
            Command::Ask,
        ]
        .into_iter()
        .find(|command| command.number() == number)
    }

    /// Its number in a payload.
    pub fn number(self) -> u32 {
        match self {
            Command::Start => 1,
            Command::Stop => 2,
            Command::Discard => 3,
            Command::Ask => 4,
        }
    }
}

impl TakeState {
    /// The state with a number; `None` for an unknown number.
    pub fn of(number: u32) -> Option<Self> {
        [
            TakeState::Ready,
            TakeState::Recording,
            TakeState::Closed,
            TakeState::Discarded,
            TakeState::Broken,
            TakeState::Estimated,
            TakeState::NotEstimated,
            TakeState::Refused,
        ]
        .into_iter()
        .find(|state| state.number() == number)
    }

    /// Its number in a payload.
    pub fn number(self) -> u32 {
        match self {
            TakeState::Ready => 0,
            TakeState::Recording => 1,
            TakeState::Closed => 2,
            TakeState::Discarded => 3,
            TakeState::Broken => 4,
            TakeState::Estimated => 5,
            TakeState::NotEstimated => 6,
            TakeState::Refused => 7,
        }
    }
}

/// A time of a payload; `None` where it is [`NO_TIME`].
pub fn time(time_ns: i64) -> Option<i64> {
    (time_ns != NO_TIME).then_some(time_ns)
}

#[cfg(test)]
impl PoseRecord {
    /// A valid reading at the origin with that number, of publisher 1, whose times nobody says: for tests.
    pub(crate) fn numbered(sequence: u64) -> Self {
        Self {
            sequence,
            available_ns: 0,
            sample_ns: NO_TIME,
            device_ns: NO_TIME,
            position_m: [0.0; 3],
            quaternion_xyzw: [0.0, 0.0, 0.0, 1.0],
            flags: VALID,
            session: 1,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pose() -> PoseRecord {
        PoseRecord {
            sequence: 1,
            available_ns: -2,
            sample_ns: 3,
            device_ns: NO_TIME,
            position_m: [0.5, f64::NAN, -1.0],
            quaternion_xyzw: [0.0, 0.0, 0.0, 1.0],
            flags: VALID,
            session: 9,
        }
    }

    #[test]
    fn layouts_have_the_sizes_that_are_documented_and_no_padding() {
        assert_eq!(size_of::<PoseRecord>(), 96);
        assert_eq!(pose().to_bytes().len(), 96);
        assert_eq!(size_of::<MarkRecord>(), 296);
        assert_eq!(size_of::<ControlRecord>(), 40);
        assert_eq!(size_of::<TakeRecord>(), 48);
        assert_eq!(size_of::<EstimateRecord>(), 96);
        assert_eq!(size_of::<EstimatedPoseRecord>(), 96);
        assert_eq!(size_of::<LabelRecord>(), 8 + 8 + 256 + 1024 + 8);
        assert_eq!(size_of::<AnswerRecord>(), 3 * 8 + 4 * 4 + 4000 + 8);
    }

    #[test]
    fn a_pose_is_kept_word_by_word() {
        let bytes = pose().to_bytes();
        assert_eq!(bytes[0..8], 1_u64.to_le_bytes());
        assert_eq!(bytes[8..16], (-2_i64).to_le_bytes());
        assert_eq!(bytes[24..32], i64::MIN.to_le_bytes());
        assert_eq!(bytes[32..40], 0.5_f64.to_le_bytes());
        assert_eq!(bytes[80..88], 1_f64.to_le_bytes());
        assert_eq!(bytes[88..], [1, 0, 0, 0, 9, 0, 0, 0]);
    }

    #[test]
    fn a_long_answer_goes_there_and_back_in_parts() {
        for length in [0, 1, PART_BYTES, PART_BYTES + 1, 3 * PART_BYTES] {
            let text: String = "aü€".chars().cycle().take(length).collect();
            let parts: Vec<AnswerRecord> = AnswerRecord::parts(7, 0, Some((3, 4)), &text).collect();
            let bytes: Vec<u8> = parts
                .iter()
                .flat_map(|part| part.bytes().to_vec())
                .collect();
            assert_eq!(String::from_utf8(bytes).as_ref(), Ok(&text));
            assert!(parts.iter().zip(0..).all(|(part, k)| part.part == k));
            assert!(parts.iter().all(|part| part.parts as usize == parts.len()));
        }
    }

    #[test]
    fn numbers_stand_for_what_is_documented() {
        let states = (0..10).map_while(TakeState::of).map(TakeState::number);
        assert!(states.eq(0..8));
        let commands = (1..10).map_while(Command::of).map(Command::number);
        assert!(commands.eq(1..5));
        assert_eq!((Command::of(0), TakeState::of(8)), (None, None));
    }

    #[test]
    fn names_of_events_go_there_and_back_and_garbage_is_refused() {
        let long = "ü".repeat(200);
        for (name, expected) in [
            ("", None),
            ("bounce", Some("bounce")),
            (long.as_str(), Some(&long[..NAME_BYTES])),
        ] {
            let record = MarkRecord {
                sequence: 0,
                available_ns: 0,
                sample_ns: 0,
                device_ns: 0,
                event: MarkRecord::event_bytes(name),
                flags: 0,
                session: 0,
            };
            let mark = record.mark(Stamp(5)).expect("UTF-8");
            assert_eq!(mark.event.as_deref(), expected);
            for garbage in [0xff, 0x80] {
                let record = MarkRecord {
                    event: [garbage; NAME_BYTES],
                    ..record
                };
                assert_eq!(record.mark(Stamp(5)), None);
            }
        }
    }
}
