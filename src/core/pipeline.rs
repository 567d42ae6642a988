//! Stages 2 to 4c as one pure state machine: event in, checked estimate out.
//!
//! A driver pushes the events of its source, in any order, and calls [`Pipeline::finish`] when the
//! take is over, or [`Pipeline::estimate`] if it wants no checks. The result depends on the events
//! alone; clocks, files and threads belong to the driver. The same take gives the same [`Outcome`]
//! bit for bit. Where something speaks against the motion, likely mistakes in what is said of the
//! performance are tried as remedies (`diagnose`).

mod diagnose;
mod ended;
mod follow;
mod free;
mod groups;
mod infer;
mod joined;
mod keep_out;
mod kept;
mod kink;
mod led;
mod outcome;
mod perform;
mod preview;
mod rest;
mod search;
mod seen;
mod shared;
mod sound;
mod spread;
mod stages;
mod stick;
mod warm;

use self::diagnose::diagnose;
use self::ended::EarlyEnd;
use self::groups::Groups;
use self::keep_out::{goes_into_something, kept_out, only_overlaps};
pub use self::kept::KeptMotion;
use self::led::LedByGoals;
pub use self::outcome::{Outcome, PipelineError};
use self::perform::{Performed, Prepared};
pub use self::preview::{Preview, Previewed};
use self::rest::Sought;
pub use self::search::SearchWork;
pub use self::seen::{MarkProposal, SeenTake};
pub use self::shared::{NoShare, SharedTake};
use self::stages::doubts;
use crate::estimate::{LastState, Solved};
use crate::motion::{
    Counted, Diagnosis, Doubt, End, EventKind, Fits, Mark, Observer, Phase, Scene, SeenPhase,
    TakeEvent, Verdict, WorkLimited,
};
use crate::segment;
use crate::verify::verify_until;

/// Least number of looks at samples that may follow the estimation of a motion: all that is tried for a better one, and
/// again all diagnoses. It may be as much as the estimation took.
const LOOKS: usize = 1_000_000;

/// One take of one scene, to be estimated.
#[derive(Clone, Debug)]
pub struct Pipeline {
    scene: Scene,
    events: Vec<TakeEvent>,
    /// See [`Pipeline::with_free_auto`].
    is_free_auto: bool,
    /// See [`Pipeline::predicting`].
    is_predicting: bool,
    /// See [`Pipeline::with_diagnoses`].
    is_diagnosing: bool,
    /// Whether the motion may end before the mark of its end, where it touches something.
    may_end_early: bool,
}

/// A checked motion, before it goes on until it rests.
struct Finished {
    outcome: Outcome,
    /// The last states of what flies, with how certain they are; `None` where nothing is predicted or several groups move.
    known: Option<Vec<LastState>>,
    /// What was done for goals at rest.
    sought: Option<Sought>,
    /// The motion itself; `None` where several groups move, or joined bodies, and of a prediction.
    kept: Option<KeptMotion>,
}

impl Pipeline {
    /// An empty take of a scene.
    pub fn new(scene: Scene) -> Self {
        Self::of(scene, [])
    }

    /// A complete take of a scene.
    pub fn of(scene: Scene, events: impl IntoIterator<Item = TakeEvent>) -> Self {
        Self {
            scene,
            events: events.into_iter().collect(),
            is_free_auto: false,
            is_predicting: false,
            is_diagnosing: true,
            may_end_early: true,
        }
    }

    /// The same with what explains a misfit set free: the fewest of the quantities that the scene
    /// keeps fixed, for [`finish`](Self::finish).
    pub fn with_free_auto(self, is_free_auto: bool) -> Self {
        Self {
            is_free_auto,
            ..self
        }
    }

    /// The same with or without diagnoses: tries of remedies, which take up to ten times the work of the estimation.
    pub fn with_diagnoses(self, is_diagnosing: bool) -> Self {
        Self {
            is_diagnosing,
            ..self
        }
    }

    /// Whether likely mistakes are looked for.
    pub fn is_diagnosing(&self) -> bool {
        self.is_diagnosing
    }

    /// Whether what explains a misfit is set free.
    pub fn is_free_auto(&self) -> bool {
        self.is_free_auto
    }

    /// Whether what follows the last event is predicted ([`Pipeline::predicting`]).
    pub fn is_predicting(&self) -> bool {
        self.is_predicting
    }

    /// The same take of another scene, such as one with as many collisions as it has marks.
    pub fn in_scene(self, scene: Scene) -> Self {
        Self { scene, ..self }
    }

    /// The same up to an event of the scene, by its index: nothing after its mark counts, and from there the motion is
    /// predicted until it rests, for `limit_s` at most. `None` where there is no such event, or its mark is not there.
    pub fn predicting(self, event: usize, limit_s: f64) -> Option<Self> {
        let name = &self.scene.events.get(event)?.name;
        let mut marks: Vec<&Mark> = self.events.iter().filter_map(TakeEvent::mark).collect();
        marks.sort_by_key(|mark| mark.stamp);
        let named = marks.iter().find(|mark| mark.event.as_ref() == Some(name));
        // Marks without names stand for the events in order.
        let in_order = || marks.get(event).filter(|mark| mark.event.is_none());
        let last = named.or_else(in_order)?.stamp;
        let mut scene = self.scene.until(event);
        scene.settle_s = Some(limit_s);
        let is_before = |of: &TakeEvent| of.stamp() <= last;
        Some(Self {
            scene,
            events: self
                .events
                .iter()
                .filter(|of| is_before(of))
                .cloned()
                .collect(),
            is_predicting: true,
            ..self
        })
    }

    /// The scene as given.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Adds an event, in any order.
    pub fn push(&mut self, event: TakeEvent) {
        self.events.push(event);
    }

    /// Proposes marks for the take, in order of time and without use of its own marks: for every
    /// collision of the scene, or `count` on each track, its start and end, at the first and the
    /// last sample or where a whole toss flies, and where its phases are seen to begin and end. Fails where there are too few samples or no clear proposals.
    pub fn propose(&self, count: Option<usize>) -> Result<Vec<MarkProposal>, PipelineError> {
        let marks = count.map_or(self.marks(), |count| {
            count + self.scene.events.len().max(1) - 1
        });
        let scene = &self.scene.with_marks(marks);
        let sketch = segment::clean::unmarked(scene, &self.events)?;
        let name = |event: usize| scene.events[event].name.clone();
        let collisions = segment::propose(scene, &sketch, count).into_iter();
        let mut marks: Vec<MarkProposal> = collisions
            .map(|proposal| MarkProposal {
                track: Some(proposal.track),
                event: proposal.event.map(name),
                stamp: proposal.stamp(&sketch),
                time_s: proposal.acted_s,
                score: Some(proposal.score),
            })
            .collect();
        let ends_s = segment::ends_of_motion_s(scene, &sketch);
        let at = |acted_s: f64| sketch.origin.after(acted_s);
        for (index, event) in scene.events.iter().enumerate() {
            let stamp = match event.kind {
                EventKind::Start => ends_s.map(|[start_s, _]| at(start_s)),
                EventKind::End => ends_s.map(|[_, end_s]| at(end_s)),
                EventKind::Collision(_)
                | EventKind::Collisions { .. }
                | EventKind::Change(_)
                | EventKind::Waypoint(_) => None,
            };
            marks.extend(stamp.map(|stamp| MarkProposal {
                track: None,
                event: Some(name(index)),
                stamp,
                time_s: stamp.seconds_since(sketch.origin),
                score: None,
            }));
        }
        seen::at_phases(scene, &self.events, &mut marks);
        marks.sort_by_key(|mark| mark.stamp);
        Ok(marks)
    }

    /// What the streams show besides flights, between the marks of start and end where the take has them. Of edited stamps
    /// nothing is told.
    pub fn seen(&self) -> Result<SeenTake, PipelineError> {
        seen::seen(&self.scene.with_marks(self.marks()), &self.events)
    }

    /// What the scene does not say of a motion against which something speaks.
    fn unsaid(&self, outcome: &Outcome) -> Vec<SeenPhase> {
        let seen = (!seen::is_clean(outcome))
            .then(|| self.seen().ok())
            .flatten();
        seen.map_or_else(Vec::new, |seen| seen.unsaid().copied().collect())
    }

    /// The estimate from all events, checked, and continued until it rests if the scene
    /// asks for that. A motion that is not physical is an outcome with that verdict; an error
    /// means that no estimate is possible.
    pub fn finish(&self, observer: &mut dyn Observer) -> Result<Outcome, PipelineError> {
        Ok(self.finish_kept(observer)?.0)
    }

    /// [`finish`](Self::finish), which keeps the motion for further questions; joined bodies, and several groups, have none.
    pub fn finish_kept(
        &self,
        observer: &mut dyn Observer,
    ) -> Result<(Outcome, Option<KeptMotion>), PipelineError> {
        let Finished {
            mut outcome,
            known,
            sought,
            kept,
        } = match Groups::of(&self.scene, &self.events)? {
            None => self.finished(&self.scene, observer)?,
            Some(groups) => self.together(&groups, observer)?,
        };
        outcome.settle(self.is_predicting, observer);
        outcome.spread(known.as_deref(), observer);
        if let Some(sought) = sought {
            outcome.lie(sought.work, sought.labels);
            if self.is_diagnosing {
                outcome.diagnoses.extend(sought.offered);
            }
        }
        outcome.seen = self.unsaid(&outcome);
        observer.phase(Phase::Done);
        Ok((outcome, kept))
    }

    /// The motion of several groups, each by itself.
    fn together(
        &self,
        groups: &Groups,
        observer: &mut dyn Observer,
    ) -> Result<Finished, PipelineError> {
        let (mut outcomes, mut sought) = (Vec::new(), None);
        for scene in groups.scenes() {
            let part = self.finished(&scene, observer)?;
            outcomes.push(part.outcome);
            sought = sought.or(part.sought);
        }
        let mut outcome = groups.together(outcomes);
        observer.phase(Phase::Verify);
        groups.check(&mut outcome, observer);
        Ok(Finished {
            outcome,
            known: None,
            sought,
            kept: None,
        })
    }

    /// The motion of a scene that is one group, checked.
    fn finished(
        &self,
        scene: &Scene,
        observer: &mut dyn Observer,
    ) -> Result<Finished, PipelineError> {
        let may_keep_out = !self.is_predicting;
        if let Some(outcome) = joined::outcome(scene, &self.events, may_keep_out, observer)? {
            return Ok(Finished {
                outcome,
                known: None,
                sought: None,
                kept: None,
            });
        }
        let mut counted = Counted {
            observer,
            steps: 0,
            looks: 0,
        };
        let mut solved = self.solved(scene, &mut counted)?;
        let Counted {
            observer,
            steps,
            looks,
        } = counted;
        let following = LOOKS.max(looks);
        let after = &mut WorkLimited {
            observer,
            looks: following,
            steps: 0,
        };
        let sought = rest::seek(&mut solved, &self.events, after);
        let mut led = self.judged(&mut solved, after)?;
        let mut freed = Vec::new();
        if self.is_free_auto && sought.is_none() {
            (solved, freed) = free::free(solved, &self.events, after)?;
        }
        let predicting = self.is_predicting.then_some(&solved.inferred.solved);
        let known = predicting.and_then(Solved::last_states);
        let may_keep_out = may_keep_out && sought.is_none();
        let mut kept = (!self.is_predicting).then(|| KeptMotion(solved.clone()));
        let mut outcome = solved.outcome(after.observer);
        if self.is_predicting {
            outcome.end_where_it_touches();
        }
        checked(&mut outcome, led, Vec::new(), after.observer);
        if may_keep_out && let Some(ended) = self.ended_early(scene, &outcome, after) {
            return Ok(ended);
        }
        let overlapping = kept.as_ref().filter(|_| may_keep_out);
        let overlapping = overlapping.filter(|_| only_overlaps(&outcome.estimate));
        if let Some(mut out) = overlapping.and_then(|of| kept_out(of.0.clone(), after)) {
            out.refine_again(after);
            led = self.judged(&mut out, after)?;
            let passed = out.inferred.solved.just_passed(scene.tolerance_m);
            let mut other = out.clone().outcome(after.observer);
            checked(&mut other, led, passed, after.observer);
            let still_fits = other.estimate.fits() != Fits::No;
            if still_fits && !goes_into_something(other.verification.as_ref()) {
                (outcome, kept) = (other, Some(KeptMotion(out)));
            }
        }
        outcome.freed = freed;
        if after.is_used_up() {
            let steps = outcome.estimate.counters.iterations;
            outcome
                .estimate
                .reason
                .unfinished_after_steps
                .get_or_insert(steps);
        }
        // What was led to its rest is as far from the performance as that takes.
        let is_led = matches!(outcome.estimate.reason.end, End::Simulated(_));
        if self.is_diagnosing && !is_led {
            after.looks = following;
            outcome.diagnoses = diagnose(scene, &self.events, Some(&outcome), steps, after);
        }
        Ok(Finished {
            outcome,
            known,
            sought,
            kept,
        })
    }

    /// The motion that ends where it touches something, if the mark of its end is later and that leads it into nothing.
    fn ended_early(
        &self,
        scene: &Scene,
        outcome: &Outcome,
        after: &mut WorkLimited,
    ) -> Option<Finished> {
        let overlaps = outcome.verification.as_ref()?.deepest.is_some();
        let early = (self.may_end_early && overlaps).then(|| EarlyEnd::of(outcome))??;
        let take = Self {
            scene: self.scene.clone(),
            events: early.marked(outcome, &self.events)?,
            may_end_early: false,
            ..*self
        };
        let mut ended = take.finished(scene, after).ok()?;
        if after.is_used_up() || goes_into_something(ended.outcome.verification.as_ref()) {
            return None;
        }
        early.tell(&mut ended.outcome);
        let counters = &mut ended.outcome.estimate.counters;
        counters.add(&outcome.estimate.counters);
        Some(ended)
    }

    /// Looks whether a motion explains the performance, and whether it is its goals that lead it away.
    fn judged(
        &self,
        take: &mut Performed,
        after: &mut WorkLimited,
    ) -> Result<Option<LedByGoals>, PipelineError> {
        take.judge(after.observer);
        let led = LedByGoals::of(take, &self.events, after)?;
        if let Some(led) = &led {
            led.clear(take);
        }
        Ok(led)
    }

    /// Likely mistakes in what is said of a take for which [`finish`](Self::finish) gives an error.
    pub fn diagnose(&self, observer: &mut dyn Observer) -> Vec<Diagnosis> {
        if !self.is_diagnosing || self.scene.joint_trees().next().is_some() {
            return Vec::new();
        }
        diagnose(&self.scene, &self.events, None, 0, observer)
    }

    /// The estimate from all events, unchecked: its verdict is that of its gaps alone.
    pub fn estimate(&self, observer: &mut dyn Observer) -> Result<Outcome, PipelineError> {
        let mut of = |scene: &Scene| -> Result<Outcome, PipelineError> {
            Ok(
                match joined::outcome(scene, &self.events, false, observer)? {
                    Some(joined) => joined,
                    None => self.solved(scene, observer)?.outcome(observer),
                },
            )
        };
        let outcome = match Groups::of(&self.scene, &self.events)? {
            None => of(&self.scene)?,
            Some(groups) => {
                let parts = groups.scenes().map(|scene| of(&scene));
                groups.together(parts.collect::<Result<_, _>>()?)
            }
        };
        observer.phase(Phase::Done);
        Ok(outcome)
    }

    fn solved(
        &self,
        scene: &Scene,
        observer: &mut dyn Observer,
    ) -> Result<Performed, PipelineError> {
        Prepared::new(scene, &self.events, observer)?.performed(observer)
    }

    /// The take's motion, to be asked what it says of `parameters` of the scene (indices into its list), which are free in it.
    /// Where none is found so, they are held at their initial values.
    pub fn shared(
        &self,
        parameters: &[usize],
        observer: &mut dyn Observer,
    ) -> Result<SharedTake, NoShare> {
        let free = self.shared_held(parameters, &[], observer);
        match free {
            Err(NoShare::NotPhysical(_) | NoShare::NoMotion(_)) => {
                let held = self.shared_held(parameters, parameters, observer);
                // What is said of the take is what was found with them free.
                held.or(free)
            }
            free => free,
        }
    }

    /// The same with some of these parameters held at their initial values while the motion is found.
    pub fn shared_held(
        &self,
        parameters: &[usize],
        held: &[usize],
        observer: &mut dyn Observer,
    ) -> Result<SharedTake, NoShare> {
        let scene = shared::held(&self.scene, held);
        SharedTake::new(&scene, &self.events, parameters, observer)
    }

    /// Number of marks: it determines how often a repeated collision happens.
    pub fn marks(&self) -> usize {
        perform::marks(&self.events)
    }
}

/// Checks a motion, with what its goals cost and what it only just passes.
fn checked(
    outcome: &mut Outcome,
    led: Option<LedByGoals>,
    passed: Vec<Doubt>,
    observer: &mut dyn Observer,
) {
    if outcome.estimate.verdict == Verdict::Failed {
        return;
    }
    observer.phase(Phase::Verify);
    outcome.verification = verify_until(&outcome.scene, &outcome.estimate, observer);
    let mut doubts = doubts(outcome);
    doubts.extend(passed);
    outcome.estimate.doubt(match led {
        Some(led) => led.instead_of(doubts),
        None => doubts,
    });
    if outcome.verification.is_none() {
        outcome.estimate.is_not_verified();
    }
}
