//! What the reading of a file may cost, whatever is in it.
//!
//! A file of 50 kB can unpack to gigabytes, and can hold the beginning of a record that must be
//! hashed to its end at every fiftieth byte. Work is therefore counted, in bytes, against limits
//! that are proportional to the size of the file: the same file is read alike on every machine.
//! The clock matters only where somebody asks for a deadline.

use std::time::Instant;

/// How a file is read.
#[derive(Clone, Copy, Debug, Default)]
pub struct Reading {
    /// As a journal of a live take, all of whose data are in records with checksums: no other record
    /// is believed, and its bytes are said not to have been read.
    pub is_journal: bool,
    /// When reading ends, wherever it is; what was not read is then a damage ([`Damage::Late`](super::Damage::Late)).
    pub deadline: Option<Instant>,
}

/// Limit of what all chunks unpack to: this multiple of the file's size plus [`UNPACKED_BYTES`].
/// Poses compress three to ten times, what stands still fifty times.
const UNPACKED_SHARE: usize = 64;
const UNPACKED_BYTES: usize = 64 << 20;

/// Limit of the bytes that are hashed or unpacked without success: this multiple of the file's size
/// plus [`VAIN_BYTES`].
const VAIN_SHARE: usize = 8;
const VAIN_BYTES: usize = 64 << 20;

/// What it costs to begin to unpack, in bytes.
pub(super) const ATTEMPT_BYTES: usize = 4096;

/// The clock is asked once in so many steps.
const STEPS: u32 = 1024;

/// What is left of the work that one walk over a file may do.
pub(super) struct Budget {
    unpacked_left: usize,
    vain_left: Option<usize>,
    deadline: Option<Instant>,
    steps: u32,
    is_late: bool,
}

impl Budget {
    /// That of a file of the given size.
    pub(super) fn new(bytes: usize, deadline: Option<Instant>) -> Self {
        let limit = |share, least| bytes.saturating_mul(share).saturating_add(least);
        Self {
            unpacked_left: limit(UNPACKED_SHARE, UNPACKED_BYTES),
            vain_left: Some(limit(VAIN_SHARE, VAIN_BYTES)),
            deadline,
            steps: 0,
            is_late: false,
        }
    }

    /// How many bytes chunks may still unpack to.
    pub(super) fn unpacked_left(&self) -> usize {
        self.unpacked_left
    }

    /// Takes the bytes of an unpacked chunk from it.
    pub(super) fn take_unpacked(&mut self, bytes: usize) {
        self.unpacked_left = self.unpacked_left.saturating_sub(bytes);
    }

    /// Whether so many bytes may be hashed, perhaps without success.
    pub(super) fn may_hash(&mut self, bytes: usize) -> bool {
        self.vain_left = self.vain_left.and_then(|left| left.checked_sub(bytes));
        self.vain_left.is_some()
    }

    /// The bytes were not hashed in vain.
    pub(super) fn was_worth(&mut self, bytes: usize) {
        self.vain_left = self.vain_left.map(|left| left.saturating_add(bytes));
    }

    /// Whether too much work was done without success.
    pub(super) fn is_spent(&self) -> bool {
        self.vain_left.is_none()
    }

    /// Counts a step; whether the deadline is over.
    pub(super) fn step(&mut self) -> bool {
        let is_due = self.steps == 0;
        self.steps = (self.steps + 1) % STEPS;
        if is_due {
            self.look();
        }
        self.is_late
    }

    /// Asks the clock whether the deadline is over.
    pub(super) fn look(&mut self) -> bool {
        self.is_late |= self.deadline.is_some_and(|at| Instant::now() >= at);
        self.is_late
    }

    /// Whether the deadline was found to be over.
    pub(super) fn is_late(&self) -> bool {
        self.is_late
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vain_work_ends_for_good_and_work_that_succeeds_costs_nothing() {
        let mut budget = Budget::new(0, None);
        for _ in 0..10 {
            assert!(budget.may_hash(VAIN_BYTES));
            budget.was_worth(VAIN_BYTES);
        }
        assert!(budget.may_hash(VAIN_BYTES) && !budget.may_hash(1) && budget.is_spent());
        budget.was_worth(1 << 30);
        assert!(!budget.may_hash(1));
    }

    #[test]
    fn a_deadline_that_is_over_is_noticed_within_so_many_steps() {
        let mut budget = Budget::new(0, Some(Instant::now()));
        assert!(budget.step());
        let mut none = Budget::new(0, None);
        assert!((0..3 * STEPS).all(|_| !none.step()));
    }
}
