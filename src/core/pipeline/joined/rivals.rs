//! Motions of joined bodies with one choice of contacts or another, and which of them is kept.

use super::tried::{AttemptOutcome, Tried, TriedField};
use crate::motion::{ContactRival, Contacts, Counters, Observer, Standing};

/// What every open collision touches with.
pub(super) type Choice = Vec<(usize, Contacts)>;

/// Choices of contacts, each with what came of it.
#[derive(Default)]
pub(super) struct Standings {
    all: Vec<(Choice, AttemptOutcome)>,
    /// Work on all of them.
    counters: Counters,
}

impl Standings {
    /// Adds what came of a choice, in the place of what is known of it.
    pub(super) fn add(&mut self, choice: Choice, outcome: AttemptOutcome) {
        if let AttemptOutcome::Tried(tried) = &outcome {
            self.counters.add(&tried.estimate.counters);
        }
        self.all.retain(|(other, _)| *other != choice);
        self.all.push((choice, outcome));
    }

    /// How many were tried.
    pub(super) fn count(&self) -> usize {
        let all = self.all.iter();
        all.filter(|(_, outcome)| !matches!(outcome, AttemptOutcome::Left))
            .count()
    }

    /// The best of those that are an optimum.
    pub(super) fn motion(&self) -> Option<&Tried> {
        let (_, best) = self.best_at()?;
        best.has_ended().then_some(best)
    }

    fn best_at(&self) -> Option<(usize, &Tried)> {
        let all = self.all.iter().enumerate();
        let all = all.filter_map(|(at, (_, outcome))| match outcome {
            AttemptOutcome::Tried(tried) => Some((at, tried.as_ref())),
            _ => None,
        });
        all.reduce(|least, other| match other.1.is_better(least.1) {
            true => other,
            false => least,
        })
    }

    /// The best one, with what of the others is not ruled out by it: what is as likely, what led to no optimum, what was
    /// not tried.
    ///
    /// # Panics
    /// Where no choice led to a motion, be it none that has ended.
    pub(super) fn best(mut self, field: &TriedField, observer: &mut dyn Observer) -> Tried {
        let (at, _) = self.best_at().expect("one was tried as if it were named");
        let (choice, outcome) = self.all.swap_remove(at);
        let AttemptOutcome::Tried(best) = outcome else {
            unreachable!("it is the best of those that were tried");
        };
        let mut best = *best;
        let mut rivals: Vec<ContactRival> = Vec::new();
        let mut add = |others: &Choice, standing: Standing| {
            for ((event, own), (_, other)) in choice.iter().zip(others) {
                let rival = ContactRival {
                    event: *event,
                    contacts: other.clone(),
                    standing,
                };
                if own != other && !rivals.contains(&rival) {
                    rivals.push(rival);
                }
            }
        };
        for (others, outcome) in &self.all {
            match outcome {
                AttemptOutcome::Tried(tried) if tried.has_ended() => {
                    if tried.is_sound() && !best.beats(&tried.solved, || tried.evidence()) {
                        add(others, Standing::Alike);
                    }
                }
                AttemptOutcome::Tried(_) | AttemptOutcome::Lost => add(others, Standing::Lost),
                AttemptOutcome::Left => add(others, Standing::Untried),
                AttemptOutcome::Worse => {}
            }
        }
        best = field.told(best, observer);
        best.estimate.is_rivalled_by(rivals);
        best.estimate.counters = self.counters;
        best
    }
}
