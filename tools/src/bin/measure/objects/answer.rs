//! What the program answers, and what is found of the answer without it.

use enact::motion::{AtBound, End, LinkIndex, Scene, TakeEvent, Verdict};
use enact::pipeline::{Outcome, Pipeline};
use enact::report::{EstimateReport, Reported};
use enact_tools::case::estimated;
use enact_tools::objects::check::{Checked, checked, miss};
use enact_tools::objects::scene::IMPACT;
use enact_tools::objects::smoothing::Filter;
use enact_tools::objects::solid::Solid;
use enact_tools::tosses::Pose;
use serde::Serialize;

use crate::table::number;

/// A free parameter as answered.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Value {
    pub value: f64,
    /// None: not determined.
    pub sd: Option<f64>,
    /// At which end of its range.
    pub at_bound: Option<&'static str>,
}

/// An answer.
#[derive(Clone, Debug, Serialize)]
pub struct Answer {
    /// `refused` where there is none.
    pub verdict: &'static str,
    pub is_physical: bool,
    /// Whether it fits, in the program's words.
    pub fits: &'static str,
    /// Doubts, suspects, mistakes and what is not determined, by name; why it is refused.
    pub said: Vec<String>,
    /// None where it is refused, or the motion is not finite.
    pub checked: Option<Checked>,
    /// What touches.
    pub feature: Option<String>,
    pub restitution: Option<Value>,
    pub friction: Option<Value>,
    /// By how much the table is higher than it was taken to be \[m\].
    pub table_m: Option<Value>,
    /// Largest gap in position \[m\] and velocity [m/s] at the impact.
    pub gap: Option<(f64, f64)>,
    /// Distance of a sample that was left out from where it is predicted \[mm\], and angle \[°\].
    pub left_out: Option<(f64, f64)>,
}

/// A question: samples from the first on, of which `count` are asked about, and the events' places.
pub struct Question<'a> {
    pub scene: &'a Scene,
    pub solid: &'a Solid,
    pub samples: &'a [Pose],
    pub count: usize,
    /// Makes the take of so many samples.
    pub take: &'a dyn Fn(usize) -> Vec<TakeEvent>,
    /// Of the filter that the samples show.
    pub filter: Option<Filter>,
}

impl Question<'_> {
    /// The program's answer, with all its checks.
    pub fn answered(&self) -> Answer {
        let take = (self.take)(self.count);
        let outcome = match Pipeline::of(self.scene.clone(), take).finish(&mut ()) {
            Ok(outcome) => outcome,
            Err(why) => return Answer::refused(why.to_string()),
        };
        let estimate = &outcome.estimate;
        let is_there = estimate.arcs.iter().all(|arc| arc.state.is_finite());
        let named = |name: &str| {
            let mut free = estimate.parameters.iter();
            let found = free.find(|parameter| parameter.name.ends_with(name))?;
            Some(Value {
                value: found.value,
                sd: found.sd,
                at_bound: found.at_bound.map(AtBound::as_str),
            })
        };
        let impact = outcome
            .scene
            .events
            .iter()
            .position(|event| event.name == IMPACT && event.kind.collision().is_some());
        Answer {
            verdict: estimate.verdict.as_str(),
            is_physical: estimate.verdict == Verdict::Physical,
            fits: estimate.fits().as_str(),
            said: said(&outcome),
            checked: is_there.then(|| {
                let samples = (self.samples, self.count);
                checked(&outcome, self.solid, samples, self.filter)
            }),
            feature: impact.and_then(|event| feature(&outcome.scene, event)),
            restitution: named("restitution"),
            friction: named("friction"),
            table_m: named("height"),
            gap: impact.map(|event| {
                let gap = &estimate.events[event].gap;
                (gap.position_m, gap.velocity_m_s)
            }),
            left_out: is_there.then(|| self.left_out(&outcome.given)).flatten(),
        }
    }

    /// The last sample, predicted from the others; what touches is taken from the answer to all.
    fn left_out(&self, given: &Scene) -> Option<(f64, f64)> {
        let last = self.count - 1;
        let outcome = estimated(given, &(self.take)(last), &mut ()).ok()?;
        let is_there = outcome.estimate.verdict != Verdict::Failed;
        is_there.then(|| miss(&outcome, self.solid, (last, &self.samples[last])))
    }
}

impl Answer {
    fn refused(why: String) -> Self {
        Self {
            verdict: "refused",
            is_physical: false,
            fits: "–",
            said: vec![why],
            checked: None,
            feature: None,
            restitution: None,
            friction: None,
            table_m: None,
            gap: None,
            left_out: None,
        }
    }
}

fn feature(scene: &Scene, event: usize) -> Option<String> {
    let collision = scene.events[event].kind.collision()?;
    let feature = collision.contacts.first()?.feature?;
    Some(scene.links[LinkIndex(0)].features[feature].name.clone())
}

/// What speaks against an answer, what is suspected and what is open, by name.
fn said(outcome: &Outcome) -> Vec<String> {
    let report = EstimateReport::new(&Reported {
        scene: &outcome.scene,
        inferred: &outcome.inferred,
        sketch: &outcome.sketch,
        counts: &outcome.counts,
        estimate: &outcome.estimate,
        verification: outcome.verification.as_ref(),
        settled: None,
        diagnoses: &outcome.diagnoses,
        seen: &outcome.seen,
        freed: &outcome.freed,
        rest: None,
    });
    let mut said: Vec<String> = Vec::new();
    if let End::VelocityJumps { .. } = outcome.estimate.reason.end {
        said.push("velocities jump".to_owned());
    } else if report.verdict == Verdict::Failed.as_str() && report.doubts.is_empty() {
        said.push(report.reason.clone());
    }
    said.extend(report.doubts.iter().map(|doubt| {
        let at = doubt.at.as_deref().filter(|_| doubt.quantity == "at_bound");
        let word = doubt.quantity.replace('_', " ");
        at.map_or(word.clone(), |at| format!("{word}: {at}"))
    }));
    let suspects = report.suspects.iter().filter(|of| of.rivals_first);
    let suspects = report.suspects.iter().take(1).chain(suspects);
    said.extend(suspects.map(|of| format!("suspect {} {}", of.quantity, number(of.value))));
    let mistakes = report.diagnoses.iter();
    said.extend(mistakes.map(|of| format!("mistake {}", of.cause)));
    let open = report.undetermined.iter();
    said.extend(open.map(|of| format!("not determined: {of}")));
    said.dedup();
    said
}
