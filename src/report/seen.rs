//! What is seen besides flights.

use serde::{Deserialize, Serialize};

use super::units::seconds;
use crate::motion::{Scene, SeenMotion, SeenPhase, Stamp};

/// So many stretches a sentence lists.
const LISTED: usize = 4;

/// A stretch in which a body does not fly, as its samples show it. Times are acted.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct SeenPhaseLine {
    /// The body.
    pub body: String,
    /// `rest`, `slide`, `roll`, `still`: held where it is, `with`: it goes with another body, `held`: in a hand, `tumble`: it
    /// touches things now and then.
    pub motion: String,
    /// The surface that carries it.
    pub surface: Option<String>,
    /// By what of it.
    pub feature: Option<String>,
    /// The body with which it goes.
    pub with: Option<String>,
    /// Its friction as it is slowed down, where the tempo is known.
    pub friction: Option<f64>,
    /// When it begins [s since the first sample].
    pub from_s: f64,
    /// When it ends [s since the first sample].
    pub until_s: f64,
    /// The same in words.
    pub text: String,
}

impl SeenPhaseLine {
    /// What is seen, with times since a stamp.
    pub fn new(scene: &Scene, of: &SeenPhase, zero: Stamp) -> Self {
        let link = &scene.links[of.link];
        let times_s = [of.from, of.until].map(|stamp| stamp.seconds_since(zero));
        let mut line = Self {
            body: link.name.clone(),
            from_s: times_s[0],
            until_s: times_s[1],
            text: format!("{} {}", of.words(scene), when(times_s, of.is_at_end)),
            ..Self::default()
        };
        match of.motion {
            SeenMotion::On(on) => {
                line.motion = on.sustained.as_str().to_owned();
                line.surface = Some(scene.surfaces[on.surface].name.clone());
                line.feature = Some(link.features[on.feature].name.clone());
                line.friction = on.friction;
            }
            SeenMotion::Still => line.motion = "still".to_owned(),
            SeenMotion::With(other) => {
                line.motion = "with".to_owned();
                line.with = Some(scene.links[other].name.clone());
            }
            SeenMotion::InHand => line.motion = "held".to_owned(),
            SeenMotion::Tumble => line.motion = "tumble".to_owned(),
        }
        line
    }
}

/// From when to when, without ends that are those of the motion.
fn when([from_s, until_s]: [f64; 2], is_at_end: [bool; 2]) -> String {
    let (from, until) = (seconds(from_s), seconds(until_s));
    match is_at_end {
        [false, false] => format!("from {from} to {until}"),
        [true, false] => format!("until {until}"),
        [false, true] => format!("from {from}"),
        [true, true] => "throughout".into(),
    }
}

/// The sentence of what is seen and not said; none where that is nothing.
pub fn hint(seen: &[SeenPhaseLine]) -> Option<String> {
    let mut said: Vec<String> = Vec::new();
    for (at, line) in seen.iter().take(LISTED).enumerate() {
        let is_same = at > 0 && seen[at - 1].body == line.body;
        said.push(match is_same {
            true => line.text.clone(),
            false => format!("`{}` {}", line.body, line.text),
        });
    }
    if seen.len() > LISTED {
        said.push(format!("and {} more", seen.len() - LISTED));
    }
    let one = if seen.len() == 1 { "a phase" } else { "phases" };
    (!said.is_empty()).then(|| {
        format!(
            "{}: {one} would say so (`enact mark --propose`)",
            said.join(", ")
        )
    })
}
