//! Scenes in which several [groups](Scene::groups) move: each is estimated and checked by itself, as if the others were not
//! there; what comes out is put together, and whether one goes into another is checked then.

use super::outcome::{Outcome, PipelineError};
use super::perform::marks;
use super::search::SearchWork;
use crate::motion::{
    DurationEstimate, End, Estimate, Fit, FitUntold, Fits, Group, LinkIndex, Observer, Penetration,
    Place, SampleCounts, Scene, TakeEvent, Undetermined, Verdict,
};
use crate::segment;
use crate::verify::deepest_between;

/// The groups of a scene with joined bodies, where there are several.
pub(super) struct Groups {
    /// The scene, with as many collisions as there are marks.
    whole: Scene,
    all: Vec<Group>,
    /// Counts of the samples before flights and trees use some.
    cleaned: SampleCounts,
}

impl Groups {
    /// Those of a scene; `None` where all that moves is one, and where marks are missing: proposals are for all of them or none.
    pub(super) fn of(scene: &Scene, events: &[TakeEvent]) -> Result<Option<Self>, PipelineError> {
        if scene.joint_trees().next().is_none() {
            return Ok(None);
        }
        let whole = scene.with_marks(marks(events));
        let all = whole.groups();
        if all.len() < 2 {
            return Ok(None);
        }
        let (_, cleaned) = segment::clean::clean(&whole, events)?;
        let is_marked = cleaned.marks.proposed.is_empty() && cleaned.marks.ignored == 0;
        Ok(is_marked.then_some(Self {
            whole,
            all,
            cleaned,
        }))
    }

    /// The scene of each group.
    pub(super) fn scenes(&self) -> impl Iterator<Item = Scene> {
        self.all.iter().map(|group| self.whole.only(group))
    }

    /// The outcome of all, from those of the groups in their order.
    pub(super) fn together(&self, parts: Vec<Outcome>) -> Outcome {
        let mut given = self.whole.clone();
        (given.parameters, given.cones) = (Vec::new(), Vec::new());
        for (part, group) in parts.iter().zip(0..) {
            let first = given.parameters.len();
            given
                .parameters
                .extend(part.given.parameters.iter().cloned());
            given.cones.extend(part.given.cones.iter().map(|cone| {
                let mut cone = *cone;
                cone.parameters = cone.parameters.map(|parameter| first + parameter);
                cone
            }));
            for event in self.events_of(group) {
                given.events[event] = part.given.events[event].clone();
            }
        }
        let estimate = self.estimate(&parts);
        let mut parts = parts.into_iter();
        let mut whole = parts.next().expect("there are several groups");
        whole.estimate = estimate;
        for (part, group) in parts.zip(1..) {
            for (track, of) in self.whole.tracks.iter_enumerated() {
                if self.all[group].has(self.whole.mechanism_of(of.link)) {
                    whole.sketch.tracks[track] = part.sketch.tracks[track].clone();
                }
            }
            for event in self.events_of(group) {
                whole.sketch.marks_s[event] = part.sketch.marks_s[event];
                whole.sketch.marks[event] = part.sketch.marks[event];
                whole.marks_made_s[event] = part.marks_made_s[event];
            }
            whole.counts.add_beyond(&part.counts, &self.cleaned);
            whole.freed.extend(part.freed);
            whole.inferred.extend(part.inferred);
            whole.search = SearchWork::both(whole.search, part.search);
            whole.verification = whole
                .verification
                .zip(part.verification)
                .map(|(one, other)| one.with(other));
            whole.diagnoses.extend(part.diagnoses);
        }
        whole.inferred.sort_unstable();
        whole.scene = given.as_estimated(&whole.estimate);
        whole.given = given;
        whole
    }

    /// Doubts whether one group goes into another; there was no time to look where the observer ends it.
    pub(super) fn check(&self, outcome: &mut Outcome, observer: &mut dyn Observer) {
        if outcome.estimate.verdict == Verdict::Failed {
            return;
        }
        let group_of = |link: LinkIndex| {
            let mechanism = self.whole.mechanism_of(link);
            self.all.iter().position(|group| group.has(mechanism))
        };
        let are_apart = |one: LinkIndex, other: LinkIndex| {
            let both = group_of(one).zip(group_of(other));
            both.is_some_and(|(one, other)| one != other)
        };
        let deepest = deepest_between(&outcome.scene, &outcome.estimate, &are_apart, observer);
        if observer.should_stop() {
            outcome.verification = None;
            outcome.estimate.is_not_verified();
            return;
        }
        let Some(deepest) = deepest else { return };
        let doubt = deepest.doubt(outcome.scene.tolerance_m);
        let doubts = outcome.estimate.doubts.drain(..).chain([doubt]).collect();
        outcome.estimate.doubt(doubts);
        if let Some(checks) = &mut outcome.verification {
            checks.deepest = Penetration::deeper(checks.deepest, Some(deepest));
        }
    }

    /// The events that a group estimates.
    fn events_of(&self, group: usize) -> impl Iterator<Item = usize> {
        let events = 0..self.whole.events.len();
        events.filter(move |event| self.whole.group_of_event(&self.all, *event) == group)
    }

    fn estimate(&self, parts: &[Outcome]) -> Estimate {
        let worst = parts.iter().map(|part| &part.estimate);
        let is_other = |of: &Estimate| !matches!(of.reason.end, End::Converged(_));
        let rank = |of: &&Estimate| (of.verdict, is_other(of));
        // Of several that are as bad, the first one's reason.
        let worst = worst.rev().max_by_key(rank).expect("there are groups");
        let mut whole = parts[0].estimate.clone();
        whole.reason.end = worst.reason.end.clone();
        let mut count = seen(&whole);
        for (part, group) in parts.iter().zip(0..).skip(1) {
            let estimate = &part.estimate;
            let (first_arc, first_parameter) = (whole.arcs.len(), whole.parameters.len());
            whole.verdict = whole.verdict.max(estimate.verdict);
            let unproven = estimate.reason.unproven_after_bounds;
            whole.reason.unproven_after_bounds = whole.reason.unproven_after_bounds.or(unproven);
            let unfinished = estimate.reason.unfinished_after_steps;
            whole.reason.unfinished_after_steps =
                whole.reason.unfinished_after_steps.or(unfinished);
            whole.objective += estimate.objective;
            whole.arcs.extend(estimate.arcs.iter().cloned());
            whole.grips.extend(estimate.grips.iter().cloned());
            whole.trees.extend(estimate.trees.iter().cloned());
            whole.parameters.extend(estimate.parameters.iter().cloned());
            whole
                .sample_times
                .extend(estimate.sample_times.iter().copied());
            whole.suspects.extend(estimate.suspects.iter().cloned());
            whole
                .contact_rivals
                .extend(estimate.contact_rivals.iter().cloned());
            whole.rivals = whole.rivals.max(estimate.rivals);
            whole.counters.add(&estimate.counters);
            whole.duration = longer(&whole.duration, &estimate.duration);
            let samples = [count, seen(estimate)];
            whole.fit = both_fit(&whole.fit, &estimate.fit, samples);
            count += samples[1];
            whole.residuals.extend(estimate.residuals.iter().map(|of| {
                let mut of = *of;
                of.arc += first_arc;
                of
            }));
            whole.doubts.extend(estimate.doubts.iter().map(|doubt| {
                let mut doubt = doubt.clone();
                if let Place::Parameter(parameter) = &mut doubt.place {
                    *parameter += first_parameter;
                }
                doubt
            }));
            for open in &estimate.undetermined {
                let open = match *open {
                    Undetermined::Parameter(parameter) => {
                        Undetermined::Parameter(first_parameter + parameter)
                    }
                    open => open,
                };
                if !whole.undetermined.contains(&open) {
                    whole.undetermined.push(open);
                }
            }
            for event in self.events_of(group) {
                whole.events[event] = estimate.events[event].clone();
            }
            // Joined bodies follow their hand as their own group has it.
            for held in &estimate.held {
                let hangs = self
                    .whole
                    .joint_trees()
                    .filter(|(of, _)| self.all[group].has(*of));
                let mut hands = hangs.filter_map(|(_, tree)| self.whole.hand_of(tree));
                let known = whole.held.iter().position(|of| of.link == held.link);
                match known {
                    Some(known) if hands.any(|hand| hand == held.link) => {
                        whole.held[known] = held.clone();
                    }
                    Some(_) => {}
                    None => whole.held.push(held.clone()),
                }
            }
        }
        whole.sample_times.sort_by_key(|of| of.track);
        whole.suspects.sort_by(|a, b| b.gain.total_cmp(&a.gain));
        let doubts = std::mem::take(&mut whole.doubts);
        whole.doubt(doubts);
        whole
    }
}

/// Number of samples of a motion.
fn seen(estimate: &Estimate) -> usize {
    let trees = estimate.trees.iter().flat_map(|tree| &tree.residuals);
    let flights = estimate.residuals.iter().map(|of| of.samples);
    flights.chain(trees.map(|of| of.samples)).sum()
}

/// The duration of two motions that begin together.
fn longer(one: &DurationEstimate, other: &DurationEstimate) -> DurationEstimate {
    let sds_s = one.sd_s.zip(other.sd_s);
    DurationEstimate {
        duration_s: one.duration_s.max(other.duration_s),
        sd_s: sds_s.map(|(one_s, other_s)| one_s.max(other_s)),
    }
}

/// Whether two motions explain the performance: both must. What is not told of one is not told of both, unless the other
/// does not.
fn both_fit(
    one: &Result<Fit, FitUntold>,
    other: &Result<Fit, FitUntold>,
    samples: [usize; 2],
) -> Result<Fit, FitUntold> {
    match (one, other) {
        (Ok(one), Ok(other)) => Ok(one.with(other, samples)),
        (Ok(fit), Err(_)) | (Err(_), Ok(fit)) if fit.fits == Fits::No => Ok(fit.clone()),
        (Err(untold), _) | (_, Err(untold)) => Err(*untold),
    }
}
