//! What the report of an estimate's file says, as far as a page shows it.
//!
//! It is read leniently: an estimate of another version may lack some of it, and what lacks is not shown.

use serde::Deserialize;
use serde::de::{Deserializer, MapAccess, Visitor};

use super::markup::shown_in;
use super::svg::escaped;

/// What an estimate says of itself; see [`EstimateMessage`](crate::report::EstimateMessage) for what is what.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Said {
    pub verdict: String,
    pub fits: String,
    pub fit_tested: Option<bool>,
    pub fit_note: Option<String>,
    pub not_told: Vec<String>,
    pub determined: bool,
    pub suspects: Vec<Suspect>,
    pub freed: Vec<Suspect>,
    pub reason: String,
    pub termination: Termination,
    pub doubts: Vec<Doubt>,
    pub diagnoses: Vec<Diagnosis>,
    pub objective: Option<f64>,
    pub iterations: u64,
    pub assignment_rounds: u64,
    pub starts: u64,
    pub acted_s: f64,
    pub physical_s: f64,
    pub physical_sd_s: Option<f64>,
    pub physical_is_determined: bool,
    pub events: Vec<Event>,
    pub goals: Vec<Goal>,
    #[serde(deserialize_with = "in_order")]
    pub parameters: Vec<(String, Parameter)>,
    pub residual_mm: Option<f64>,
    pub residual_deg: Option<f64>,
    pub segments: Vec<Segment>,
    pub held: Vec<Held>,
    pub undetermined: Vec<String>,
    pub verification: Option<Checked>,
    pub settled: Option<Settled>,
    pub rest: Option<Rest>,
    pub samples: Samples,
    pub time_map: TimeMap,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Suspect {
    pub quantity: String,
    pub unit: String,
    pub quantities: Vec<(String, Option<f64>)>,
    pub explains: Option<f64>,
    pub rivals_first: bool,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Termination {
    pub kind: String,
    pub at: Vec<String>,
    pub unproven_after_bounds: Option<u64>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Doubt {
    pub quantity: String,
    pub at: Option<String>,
    pub best: String,
    pub text: String,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Diagnosis {
    pub key: String,
    pub value: String,
    pub sentence: String,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct ContactRival {
    pub contact: String,
    pub standing: String,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Event {
    pub name: String,
    pub kind: String,
    pub time_s: f64,
    pub time_sd_s: Option<f64>,
    pub time_is: String,
    pub time_at_bound: Option<String>,
    pub acted_s: f64,
    pub bodies: Vec<String>,
    pub contact: Option<String>,
    pub contact_inferred: bool,
    pub contact_rivals: Vec<ContactRival>,
    pub gap_m: Option<f64>,
    pub gap_rad: Option<f64>,
    pub gap_m_s: Option<f64>,
    pub gap_rad_s: Option<f64>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Goal {
    pub event: String,
    pub body: Option<String>,
    pub what: String,
    pub is_met: bool,
    pub binds: bool,
    pub distance: Option<f64>,
    pub sd: Option<f64>,
    pub unit: String,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Parameter {
    pub value: Option<f64>,
    pub sd: Option<f64>,
    pub at_bound: Option<String>,
    pub bounds: [Option<f64>; 2],
    pub unit: String,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Segment {
    pub body: String,
    pub start_s: f64,
    pub end_s: f64,
    pub samples: u64,
    pub residual_mm: Option<f64>,
    pub residual_deg: Option<f64>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Held {
    pub body: String,
    pub samples: u64,
    pub noise_mm: Option<f64>,
    pub noise_deg: Option<f64>,
    pub collisions: u64,
    pub moved_mm: Option<f64>,
    pub moved_deg: Option<f64>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Checked {
    pub tolerance_m: f64,
    pub deepest: Option<Overlap>,
    pub wrong_features: Vec<Touch>,
    pub single_shot: Option<Shot>,
    pub restarts: Vec<String>,
    pub missed: Vec<String>,
    pub imbalance: Option<f64>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Overlap {
    pub body: String,
    pub against: String,
    pub time_s: f64,
    pub depth_m: f64,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Touch {
    pub event: String,
    pub expected: Vec<String>,
    pub found: Option<String>,
    pub lead_m: f64,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Shot {
    pub position_m: Option<f64>,
    pub orientation_rad: Option<f64>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Settled {
    pub from_s: f64,
    pub end_s: f64,
    pub at_rest: bool,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Rest {
    pub goals: Vec<Lie>,
    pub tried: u64,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Lie {
    pub body: String,
    pub asked: String,
    pub face_up: String,
    pub is_still: bool,
    pub is_met: bool,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Samples {
    pub read: u64,
    pub used: u64,
    #[serde(deserialize_with = "in_order")]
    pub dropped: Vec<(String, u64)>,
    pub reordered: u64,
    pub normalised: u64,
    pub flipped: u64,
    pub gaps: u64,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct TimeMap {
    pub origin: Time,
    pub bodies: Vec<BodyTimes>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Time {
    pub sec: i64,
    pub nsec: i64,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct BodyTimes {
    pub body: String,
    pub acted_s: Vec<f64>,
    pub physical_s: Vec<f64>,
}

impl Suspect {
    /// Names and likely values, as HTML.
    pub(super) fn words(&self) -> String {
        let (factor, unit) = shown_in(&self.unit);
        let values = self.quantities.iter().map(|(name, value)| {
            let value = value.map_or("?".to_owned(), |value| format!("{:.3}", value * factor));
            let words = format!("{} {value} {unit}", escaped(name));
            words.trim_end().to_owned()
        });
        values.collect::<Vec<_>>().join(", ")
    }
}

impl Said {
    /// Reads the message of `/estimate/report`.
    pub(super) fn read(json: &[u8]) -> Result<Self, serde_json::Error> {
        serde_json::from_slice(json)
    }
}

/// A map as pairs in its order, which means something.
fn in_order<'de, D, T>(deserializer: D) -> Result<Vec<(String, T)>, D::Error>
where
    D: Deserializer<'de>,
    T: Deserialize<'de>,
{
    struct Pairs<T>(std::marker::PhantomData<T>);

    impl<'de, T: Deserialize<'de>> Visitor<'de> for Pairs<T> {
        type Value = Vec<(String, T)>;

        fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
            f.write_str("a map")
        }

        fn visit_map<M: MapAccess<'de>>(self, mut map: M) -> Result<Self::Value, M::Error> {
            let mut pairs = Vec::new();
            while let Some(pair) = map.next_entry()? {
                pairs.push(pair);
            }
            Ok(pairs)
        }
    }

    deserializer.deserialize_map(Pairs(std::marker::PhantomData))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::{FIRST_NS, counts, estimate, scene, sketch};
    use crate::motion::Stamp;
    use crate::report::{EstimateMessage, Reported, json};

    #[test]
    fn what_is_written_is_read() {
        let (scene, sketch, counts, estimate) = (scene(), sketch(), counts(), estimate());
        let of = Reported {
            scene: &scene,
            inferred: &[0],
            sketch: &sketch,
            counts: &counts,
            estimate: &estimate,
            verification: None,
            settled: None,
            diagnoses: &[],
            freed: &[],
            rest: None,
        };
        let written = EstimateMessage::new(&of, Stamp(FIRST_NS), None);
        let said = Said::read(&json(&written)).expect("JSON");
        let report = &written.report;
        assert_eq!(
            (said.verdict.as_str(), said.fits.as_str()),
            (report.verdict, report.fits)
        );
        assert_eq!(said.fit_tested, Some(report.is_fit_tested));
        assert_eq!(said.events.len(), report.events.len());
        assert_eq!(said.events[0].contact, report.events[0].contact);
        let names: Vec<&str> = said
            .parameters
            .iter()
            .map(|(name, _)| name.as_str())
            .collect();
        let written: Vec<&str> = report
            .parameters
            .0
            .iter()
            .map(|(name, _)| name.as_str())
            .collect();
        assert!(!names.is_empty() && names == written);
        // A bound that does not bind is null.
        assert_eq!(said.parameters[0].1.bounds, [Some(0.0), None]);
        assert_eq!(said.samples.used as usize, report.samples.used);
        assert!(!said.time_map.bodies[0].physical_s.is_empty());
        // Nothing is there of a file that says nothing, and nothing fails.
        let silent = Said::read(b"{}").expect("an object");
        assert!(silent.verdict.is_empty() && silent.events.is_empty());
        assert!(Said::read(b"7").is_err());
    }
}
