//! What every report says alike: of doubts, samples and what follows the performance.

use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};

use crate::motion::{Doubt, SampleCounts, Scene, Settled};

/// One thing that speaks against a motion.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DoubtLine {
    /// What was measured; see [`About`](crate::motion::About).
    pub quantity: &'static str,
    /// What it is; `null` where the performance does not determine it.
    pub value: f64,
    /// What it may be.
    pub bound: f64,
    /// Unit of both.
    pub unit: &'static str,
    /// The body, event or parameter where it is; none where it is of the whole motion.
    pub at: Option<String>,
    /// Physical time, where it is at one: the beginning of a flight.
    pub time_s: Option<f64>,
    /// The best verdict that it leaves: `physical` where it is only to be known.
    pub best: &'static str,
}

impl DoubtLine {
    /// With the scene's names.
    pub fn new(scene: &Scene, doubt: &Doubt) -> Self {
        Self {
            quantity: doubt.about.as_str(),
            value: doubt.value,
            bound: doubt.bound,
            unit: doubt.about.unit(),
            at: doubt.place.name(scene).map(str::to_owned),
            time_s: doubt.place.time_s(),
            best: doubt.about.best().as_str(),
        }
    }
}

/// What became of the samples.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SampleLine {
    /// Delivered.
    pub read: usize,
    /// In the objective.
    pub used: usize,
    /// Left out, by reason.
    pub dropped: Ordered<usize>,
    /// Sorted in.
    pub reordered: usize,
    /// Made unit.
    pub normalised: usize,
    /// Made continuous in sign.
    pub flipped: usize,
    /// Gaps in the streams.
    pub gaps: usize,
}

impl SampleLine {
    /// In words.
    pub fn new(counts: &SampleCounts) -> Self {
        let dropped = counts.dropped.iter();
        let dropped = dropped.map(|(reason, count)| (reason.as_str().to_owned(), *count));
        Self {
            read: counts.read,
            used: counts.used,
            dropped: Ordered(dropped.collect()),
            reordered: counts.reordered,
            normalised: counts.normalised,
            flipped: counts.flipped,
            gaps: counts.gaps,
        }
    }
}

/// How the motion goes on by simulation.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SettledLine {
    /// Physical time from which it is simulated.
    pub from_s: f64,
    /// Physical time at which it ends.
    pub end_s: f64,
    /// Whether everything rests there.
    pub at_rest: bool,
    /// Largest speed of a centre of mass on the way.
    pub largest_speed_m_s: f64,
}

impl SettledLine {
    /// Where it begins and how it ends.
    pub fn new(settled: &Settled) -> Self {
        Self {
            from_s: settled.from_s,
            end_s: settled.end_s(),
            at_rest: settled.at_rest,
            largest_speed_m_s: settled.largest_speed_m_s,
        }
    }
}

/// Named values in the order that means something; a map in JSON.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ordered<T>(pub Vec<(String, T)>);

impl<T: Serialize> Serialize for Ordered<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.0.len()))?;
        for (name, value) in &self.0 {
            map.serialize_entry(name, value)?;
        }
        map.end()
    }
}
