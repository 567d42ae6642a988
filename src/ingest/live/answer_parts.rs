//! What a daemon says, from its parts.

use crate::wire::live::AnswerRecord;

/// What a daemon said: the command it answers, as session and sequence number, and the JSON.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Answered {
    /// Session of the command, 0 where it answers none.
    pub session: u32,
    /// Its sequence number.
    pub sequence: u64,
    /// One JSON object.
    pub json: String,
}

/// The parts so far of the answer that is being received.
#[derive(Debug, Default)]
pub(super) struct AnswerParts {
    /// The answer's number and the number of the next part.
    next: Option<(u64, u32)>,
    text: Vec<u8>,
}

/// Longest answer \[bytes\]: a report has some ten thousand.
const LONGEST_BYTES: usize = 4 << 20;

impl AnswerParts {
    /// Takes a part in; the answer, if it is the last. An answer with a part missing, one that is too
    /// long and one that is not UTF-8 are left out.
    pub(super) fn take(&mut self, record: &AnswerRecord) -> Option<Answered> {
        if self.next != Some((record.sequence, record.part)) {
            self.forget();
            if record.part != 0 {
                return None;
            }
        }
        self.text.extend_from_slice(record.bytes());
        let following = record
            .part
            .checked_add(1)
            .filter(|part| *part < record.parts);
        if let Some(part) = following {
            self.next = Some((record.sequence, part));
            if self.text.len() > LONGEST_BYTES {
                self.forget();
            }
            return None;
        }
        self.next = None;
        let json = String::from_utf8(std::mem::take(&mut self.text)).ok()?;
        Some(Answered {
            session: record.control_session,
            sequence: record.control_sequence,
            json,
        })
    }

    fn forget(&mut self) {
        self.next = None;
        self.text.clear();
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        /// A lost part costs its own answer and no other; garbage in between costs nothing but what
        /// it interrupts.
        #[test]
        fn answers_are_whole_or_left_out(
            texts in prop::collection::vec(".{1,3000}", 1..6),
            lost in 0..8_usize,
            garbage in any::<(u64, u32, u32, u32, u8)>(),
        ) {
            let records: Vec<(usize, AnswerRecord)> = texts
                .iter()
                .enumerate()
                .flat_map(|(k, text)| {
                    let parts = AnswerRecord::parts(k as u64, 0, Some((1, k as u64)), text);
                    parts.map(move |part| (k, part))
                })
                .collect();
            let of_lost = records.get(lost).map(|(k, _)| *k);
            let mut parts = AnswerParts::default();
            let mut heard = Vec::new();
            for (index, (_, record)) in records.iter().enumerate() {
                if index != lost {
                    heard.extend(parts.take(record));
                }
            }
            let expected: Vec<(u64, &String)> = texts
                .iter()
                .enumerate()
                .filter(|(k, _)| Some(*k) != of_lost)
                .map(|(k, text)| (k as u64, text))
                .collect();
            let found: Vec<(u64, &String)> = heard.iter().map(|of| (of.sequence, &of.json)).collect();
            prop_assert_eq!(found, expected);
            // Whatever else comes is survived.
            let (sequence, part, many, length, byte) = garbage;
            let bad = AnswerRecord {
                sequence,
                part,
                parts: many,
                length,
                text: [byte; 4000],
                ..records[0].1
            };
            for _ in 0..3 {
                parts.take(&bad);
            }
            let again = parts.take(&AnswerRecord { parts: 1, part: 0, ..records[0].1 });
            prop_assert!(again.is_none_or(|of| texts[0].starts_with(&of.json)));
        }
    }
}
