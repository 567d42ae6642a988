//! One toss: what it shows, and what the program makes of it.

use anyhow::Result;
use enact::motion::{Scene, Stamp, TakeEvent};
use enact::pipeline::Pipeline;
use enact_tools::case::estimated;
use enact_tools::objects::read::{ObjectToss, RATE_HZ};
use enact_tools::objects::scene::{END, IMPACT, Trust, flight, impact};
use enact_tools::objects::solid::Solid;
use enact_tools::tosses::Toss;
use nalgebra::Vector3;
use serde::Serialize;

use super::answer::{Answer, Question};
use super::facts::Facts;

/// One toss.
#[derive(Serialize)]
pub struct Told {
    pub name: String,
    pub is_for_choosing: bool,
    pub shape: String,
    pub is_measured: bool,
    /// Of the last sample.
    pub last_height_m: f64,
    /// None: no flight is seen, and nothing is asked.
    pub seen: Option<Asked>,
}

/// A mark as the program proposes it.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Proposed {
    /// In samples of the toss.
    pub place: f64,
    /// See `MarkProposal::score`.
    pub score: f64,
}

/// What was asked about a toss.
#[derive(Serialize)]
pub struct Asked {
    pub facts: Facts,
    /// The mark of the first impact as the program proposes it: in the samples that are asked about,
    /// and in all of the toss; or why not.
    pub proposed: Result<Proposed, String>,
    pub proposed_in_all: Result<Proposed, String>,
    /// The first flight.
    pub flight: Answer,
    /// Gravity where it is free, off the scene's [m/s²].
    pub gravity_off_m_s2: Option<f64>,
    /// Through the first impact.
    pub impact: Answer,
    /// The same with the object's other shape.
    pub other_shape: String,
    pub other: Answer,
}

impl Told {
    /// Asks about a toss.
    pub fn new(
        toss: &ObjectToss,
        shapes: &[Solid; 2],
        (trust, gravity_m_s2): (&Trust, &Vector3<f64>),
    ) -> Result<Self> {
        let [solid, other] = shapes;
        let facts = Facts::new(toss, solid, gravity_m_s2);
        let seen = facts.map(|facts| asked(toss, (solid, other), (trust, gravity_m_s2), facts));
        Ok(Self {
            name: toss.name.clone(),
            is_for_choosing: toss.is_for_choosing,
            shape: solid.source.clone(),
            is_measured: solid.is_measured,
            last_height_m: toss.poses.last().map_or(f64::NAN, |pose| pose.0.z),
            seen: seen.transpose()?,
        })
    }
}

fn asked(
    toss: &ObjectToss,
    (solid, other): (&Solid, &Solid),
    (trust, gravity_m_s2): (&Trust, &Vector3<f64>),
    facts: Facts,
) -> Result<Asked> {
    let [first, last] = facts.first;
    let part = toss.part(first, toss.poses.len() - 1);
    let count = last + 1 - first;
    let fixed = flight(solid, trust, false)?;
    let take = |samples: usize| part.take(RATE_HZ, samples, &[(samples as f64 - 1.0, IMPACT)]);
    let alone = Question {
        scene: &fixed,
        solid,
        samples: &part.poses,
        count,
        take: &take,
        filter: facts.filter,
    };
    let free = estimated(&flight(solid, trust, true)?, &take(count), &mut ());
    let off = |gravity: Vector3<f64>| (gravity - gravity_m_s2).norm();
    let scene = impact(solid, trust, facts.table_m)?;
    let through = facts.second[1] + 1 - first;
    let other_table_m = Facts::new(toss, other, gravity_m_s2).map_or(0.0, |facts| facts.table_m);
    let other_scene = impact(other, trust, other_table_m)?;
    Ok(Asked {
        proposed: proposed(&scene, &part, (first, through)),
        proposed_in_all: proposed(&scene, &part, (first, part.poses.len())),
        flight: alone.answered(),
        gravity_off_m_s2: free.ok().map(|outcome| off(outcome.estimate.gravity_m_s2)),
        impact: through_impact(&part, &facts, (solid, &scene)),
        other_shape: other.source.clone(),
        other: through_impact(&part, &facts, (other, &other_scene)),
        facts,
    })
}

fn through_impact(part: &Toss, facts: &Facts, (solid, scene): (&Solid, &Scene)) -> Answer {
    let first = facts.first[0];
    let impact = facts.impact() - first as f64;
    let take = |samples: usize| {
        let marks = [(impact, IMPACT), (samples as f64 - 1.0, END)];
        part.take(RATE_HZ, samples, &marks)
    };
    let question = Question {
        scene,
        solid,
        samples: &part.poses,
        count: facts.second[1] + 1 - first,
        take: &take,
        filter: facts.filter,
    };
    question.answered()
}

/// The mark of the impact as proposed in so many samples from the first on.
fn proposed(
    scene: &Scene,
    part: &Toss,
    (first, samples): (usize, usize),
) -> Result<Proposed, String> {
    let events: Vec<TakeEvent> = part.take(RATE_HZ, samples, &[]);
    let proposals = Pipeline::of(scene.clone(), events).propose(None);
    let proposals = proposals.map_err(|error| error.to_string())?;
    let mark = proposals.iter().find(|mark| mark.track.is_some());
    let mark = mark.ok_or("nothing is proposed")?;
    Ok(Proposed {
        place: first as f64 + mark.stamp.seconds_since(Stamp(0)) * RATE_HZ,
        score: mark.score.unwrap_or(f64::NAN),
    })
}
