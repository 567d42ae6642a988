//! Motions of joined bodies with one choice of contacts or another, and which of them is kept.

use super::tried::{Came, Tried, TriedField};
use crate::motion::{ContactRival, Contacts, Counters, Observer, Standing};

/// What every open collision touches with.
pub(super) type Choice = Vec<(usize, Contacts)>;

/// Choices of contacts, each with what came of it.
#[derive(Default)]
pub(super) struct Standings {
    all: Vec<(Choice, Came)>,
    /// Work on all of them.
    counters: Counters,
}

impl Standings {
    /// Adds what came of a choice, in the place of what is known of it.
    pub(super) fn add(&mut self, choice: Choice, came: Came) {
        if let Came::Tried(tried) = &came {
            self.counters.add(&tried.estimate.counters);
        }
        self.all.retain(|(other, _)| *other != choice);
        self.all.push((choice, came));
    }

    /// How many were tried.
    pub(super) fn count(&self) -> usize {
        let all = self.all.iter();
        all.filter(|(_, came)| !matches!(came, Came::Left)).count()
    }

    /// The best of those that are an optimum.
    pub(super) fn motion(&self) -> Option<&Tried> {
        let (_, best) = self.best_at()?;
        best.has_ended().then_some(best)
    }

    fn best_at(&self) -> Option<(usize, &Tried)> {
        let all = self.all.iter().enumerate();
        let all = all.filter_map(|(at, (_, came))| match came {
            Came::Tried(tried) => Some((at, tried.as_ref())),
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
        let (choice, came) = self.all.swap_remove(at);
        let Came::Tried(best) = came else {
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
        for (others, came) in &self.all {
            match came {
                Came::Tried(tried) if tried.has_ended() => {
                    if tried.is_sound() && !best.beats(&tried.solved, || tried.evidence()) {
                        add(others, Standing::Alike);
                    }
                }
                Came::Tried(_) | Came::Lost => add(others, Standing::Lost),
                Came::Left => add(others, Standing::Untried),
                Came::Worse => {}
            }
        }
        best = field.told(best, observer);
        best.estimate.is_rivalled_by(rivals);
        best.estimate.counters = self.counters;
        best
    }
}
