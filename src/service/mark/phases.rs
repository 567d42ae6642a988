//! What the streams show besides flights, as text for the scene: events and phases that say it.
//!
//! Phases are added one after another in order of time, and each is read back with the scene: what no scene may say is listed with
//! the reason, and not in the text.

use serde::Serialize;

use super::draft::SceneDraft;
use crate::motion::{Mark, Scene, SeenPhase};
use crate::pipeline::SeenTake;
use crate::report::SeenPhaseLine;

/// What follows something begins so long after its end at most \[ns\].
const FOLLOWS_NS: u64 = 150_000_000;

/// Something that is seen besides flights.
#[derive(Clone, Debug, Serialize)]
pub struct ProposedPhase {
    /// What is seen.
    #[serde(flatten)]
    pub seen: SeenPhaseLine,
    /// The phase that says it: of the scene, or of the text.
    pub phase: Option<String>,
    /// Whether the scene has that.
    pub is_said: bool,
    /// Why no scene says it.
    pub reason: Option<String>,
}

/// What is seen, and what would say it.
#[derive(Clone, Debug, Default)]
pub struct PhaseProposals {
    /// Body by body in order of time.
    pub phases: Vec<ProposedPhase>,
    /// Marks of the events at which what is not said yet begins and ends, in order of time.
    pub phase_marks: Vec<Mark>,
    /// Text for the scene; none where nothing is to be said.
    pub toml: Option<String>,
    /// The scene with it.
    pub scene_toml: Option<String>,
}

/// What is seen of a take, and the text that would say in the scene what that does not say. `marks` are proposals for its events.
pub fn proposed_phases(
    scene: &Scene,
    text: &str,
    seen: &SeenTake,
    marks: &[Mark],
) -> PhaseProposals {
    let mut draft = SceneDraft::new(scene, text, seen, marks);
    let before = draft.clone();
    let mut phases = Vec::new();
    for (at, (of, said)) in seen.phases.iter().zip(&seen.said).enumerate() {
        let mut line = ProposedPhase {
            seen: SeenPhaseLine::new(scene, of, seen.first),
            phase: said.map(|phase| scene.phases[phase].name.clone()),
            is_said: said.is_some(),
            reason: None,
        };
        if said.is_none() {
            let is_next = |next: &&SeenPhase| {
                next.link == of.link && next.from.0.abs_diff(of.until.0) <= FOLLOWS_NS
            };
            let follows = |before: &&SeenPhase| {
                before.link == of.link && before.until.0.abs_diff(of.from.0) <= FOLLOWS_NS
            };
            let next = seen.phases.get(at + 1).filter(is_next);
            let follows = seen.phases[..at].last().filter(follows).is_some();
            match draft.with(scene, of, follows, next) {
                Ok((more, name)) => {
                    draft = more;
                    line.phase = Some(name);
                }
                Err(reason) => line.reason = Some(reason),
            }
        }
        phases.push(line);
    }
    let is_new = draft.text != before.text;
    draft.marks.sort_by_key(|mark| mark.stamp);
    PhaseProposals {
        phases,
        toml: is_new.then(|| draft.fragment()),
        scene_toml: is_new.then(|| draft.text.clone()),
        phase_marks: if is_new { draft.marks } else { Vec::new() },
    }
}
