//! The samples, the work done, and what follows the performance.

use std::fmt;
use std::marker::PhantomData;

use serde::de::{MapAccess, Visitor};
use serde::ser::SerializeMap;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::read::unknown;
use super::spread::SpreadLine;
use crate::motion::{Counters, SampleCounts, Scene, Settled};

/// What became of the samples.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
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
    /// With words for the reasons.
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
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct SettledLine {
    /// Physical time from which it is simulated.
    #[serde(default = "unknown")]
    pub from_s: f64,
    /// Physical time at which it ends.
    pub end_s: f64,
    /// Whether everything rests there.
    pub at_rest: bool,
    /// Whether it is a prediction, or only a way to rest.
    pub is_predicted: bool,
    /// How far the prediction may be off, where that is known.
    pub spread: Option<SpreadLine>,
    /// Largest speed of a centre of mass on the way.
    pub largest_speed_m_s: f64,
}

impl SettledLine {
    /// Where it begins and how it ends.
    pub fn new(scene: &Scene, settled: &Settled) -> Self {
        let spread = settled.spread.as_ref();
        Self {
            spread: spread.map(|spread| SpreadLine::new(scene, spread)),
            from_s: settled.from_s,
            end_s: settled.end_s(),
            at_rest: settled.at_rest,
            is_predicted: settled.is_predicted,
            largest_speed_m_s: settled.largest_speed_m_s,
        }
    }
}

/// Work done, by kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct CounterLine {
    /// Evaluations with a factorisation.
    pub iterations: usize,
    /// Evaluations of all sample residuals.
    pub evaluations: usize,
    /// Matrix factorisations.
    pub factorisations: usize,
    /// Iterations of the arc fits.
    pub fit_iterations: usize,
    /// Rounds of mark refinement and of time assignment.
    pub assignment_rounds: usize,
    /// Starts tried.
    pub starts: usize,
}

impl CounterLine {
    /// Of an estimate's counters.
    pub fn new(counters: &Counters) -> Self {
        Self {
            iterations: counters.iterations,
            evaluations: counters.evaluations,
            factorisations: counters.factorisations,
            fit_iterations: counters.fit_iterations,
            assignment_rounds: counters.assignment_rounds,
            starts: counters.starts,
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

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Ordered<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(InOrder(PhantomData))
    }
}

/// Reads a map in its order.
struct InOrder<T>(PhantomData<T>);

impl<'de, T: Deserialize<'de>> Visitor<'de> for InOrder<T> {
    type Value = Ordered<T>;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a map")
    }

    fn visit_map<M: MapAccess<'de>>(self, mut map: M) -> Result<Self::Value, M::Error> {
        let mut pairs = Vec::new();
        while let Some(pair) = map.next_entry()? {
            pairs.push(pair);
        }
        Ok(Ordered(pairs))
    }
}
