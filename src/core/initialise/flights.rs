//! The fitted flights of one mechanism in a guess, and what is known at the events between them.

use std::collections::BTreeMap;

use crate::motion::{ArcGuess, GoalTarget, Guess, MechanismIndex, Scene, Segment};
use crate::physics::{State, flow};

/// What is known at events.
pub(super) type Known<T> = BTreeMap<usize, T>;

/// The fitted flights of one mechanism, in order of time.
pub(super) struct Flights<'a> {
    pub(super) scene: &'a Scene,
    pub(super) segments: &'a [Segment],
    pub(super) own: Vec<usize>,
}

impl Flights<'_> {
    pub(super) fn at_goals<T>(
        &self,
        mechanism: MechanismIndex,
        of: impl Fn(&GoalTarget) -> Option<T>,
    ) -> Known<T> {
        let goals = self.scene.goals.iter();
        let own = goals.filter(|goal| self.scene.mechanism_of(goal.link) == mechanism);
        own.filter_map(|goal| Some((goal.event, of(&goal.target)?)))
            .collect()
    }

    /// Adds what flights that are seen have at their ends.
    pub(super) fn at_ends<T>(
        &self,
        known: &mut Known<T>,
        is_seen: impl Fn(&usize) -> bool,
        guess: &Guess,
        of: impl Fn(State) -> T,
    ) {
        for at in self.own.iter().filter(|at| is_seen(at)) {
            for event in self.ends_of(*at).into_iter().flatten() {
                let state = self.advanced(&guess.arcs[*at], *at, guess.event_times_s[event]);
                known.entry(event).or_insert_with(|| of(state));
            }
        }
    }

    pub(super) fn ends_of(&self, at: usize) -> [Option<usize>; 2] {
        [self.segments[at].start_event, self.segments[at].end_event]
    }

    /// Times of the beginning and the end of a flight, of its first and last sample where no event
    /// is \[s\].
    pub(super) fn ends_s(&self, at: usize, guess: &Guess) -> [f64; 2] {
        let times_s = &guess.arcs[at].sample_times_s;
        let first_s = times_s.iter().copied().fold(f64::INFINITY, f64::min);
        let last_s = times_s.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let [start, end] = self.ends_of(at);
        let of = |event: Option<usize>, otherwise_s| {
            event.map_or(otherwise_s, |event| guess.event_times_s[event])
        };
        [of(start, first_s), of(end, last_s)]
    }

    /// States at an event of the flights before it and after it.
    pub(super) fn beside(&self, event: usize, guess: &Guess) -> [Option<State>; 2] {
        [1, 0].map(|side| {
            let has = |at: &&usize| self.ends_of(**at)[side] == Some(event);
            let at = self.own.iter().find(has)?;
            Some(self.advanced(&guess.arcs[*at], *at, guess.event_times_s[event]))
        })
    }

    pub(super) fn advanced(&self, arc: &ArcGuess, at: usize, time_s: f64) -> State {
        let segment = &self.segments[at];
        let body = self.scene.body_between(segment.mechanism, segment.ends());
        flow::advance(
            &body,
            &self.scene.gravity_m_s2,
            &arc.state,
            time_s - arc.epoch_s,
        )
    }
}

/// What is known at an event, or at the nearest one.
pub(super) fn nearest<T: Copy>(known: &Known<T>, event: Option<usize>) -> Option<T> {
    let event = event?;
    let nearest = known.iter().min_by_key(|(other, _)| other.abs_diff(event));
    nearest.map(|(_, of)| *of)
}
