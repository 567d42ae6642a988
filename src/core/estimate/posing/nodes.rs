//! Nodes of the time map: the acted times whose physical times are unknowns (timing unknown, paper
//! §4.3).
//!
//! In a slow stream every sample is a node. In a faster one, times of samples between two nodes are
//! interpolated linearly: a performer's tempo does not change within milliseconds, so the number of
//! unknowns follows the motion and not the sampling rate. The weight of the tempo prior is
//! multiplied by the number of samples per node, so that the optimum does not depend on the
//! sampling rate either.

use crate::motion::{Segment, Sketch};

/// Least distance of nodes except at the ends of flights \[s\]: streams of up to 200 samples a
/// second have a node at every sample.
pub(in crate::estimate) const SPACING_S: f64 = 0.0045;

/// Distance of nodes within which a hand's tempo hardly changes \[s, acted\].
const PACE_S: f64 = 0.05;

/// Greatest number of nodes in a flight: what is acted for so long is none.
const PACES_MOST: f64 = 80.0;

/// The nodes, and the number of samples per node.
pub(in crate::estimate) struct Nodes {
    /// Acted times, distinct and increasing \[s\].
    pub(in crate::estimate) acted_s: Vec<f64>,
    /// Number of distinct sample times per node; one where every sample is a node.
    pub(in crate::estimate) samples_each: f64,
}

impl Nodes {
    /// Nodes at all samples of all segments.
    pub(in crate::estimate) fn everywhere(sketch: &Sketch, segments: &[Segment]) -> Self {
        let of_all = segments
            .iter()
            .flat_map(|segment| sketch.samples_in(segment));
        Self {
            acted_s: distinct(of_all.map(|sample| sample.acted_s).collect()),
            samples_each: 1.0,
        }
    }

    /// Nodes at least [`SPACING_S`] apart. The first and the last sample of every segment are
    /// nodes, so that no interpolated sample lies between two flights.
    pub(in crate::estimate) fn spaced(sketch: &Sketch, segments: &[Segment]) -> Self {
        let all = Self::everywhere(sketch, segments);
        let kept = spread(&all.acted_s, sketch, segments, SPACING_S);
        let intervals = |times: usize| times.saturating_sub(1).max(1) as f64;
        Self {
            samples_each: intervals(all.acted_s.len()) / intervals(kept.len()),
            acted_s: kept,
        }
    }

    /// Nodes between which the pace of a hand is steady: at least [`PACE_S`] apart except at the ends of flights, and not many in any
    /// of them.
    pub(in crate::estimate) fn of_paces(sketch: &Sketch, segments: &[Segment]) -> Self {
        let all = Self::spaced(sketch, segments);
        let spans = segments.iter().filter_map(|of| sketch.span_s(of));
        let longest_s = spans.fold(0.0, |longest: f64, [from_s, to_s]| {
            longest.max(to_s - from_s)
        });
        let apart_s = PACE_S.max(longest_s / PACES_MOST);
        Self {
            acted_s: spread(&all.acted_s, sketch, segments, apart_s),
            samples_each: all.samples_each,
        }
    }

    /// The node at or before a time, and the share of the interval to the next: zero at a node.
    pub(in crate::estimate) fn place(&self, acted_s: f64) -> (usize, f64) {
        let nodes = &self.acted_s;
        let node = nodes.partition_point(|node| *node <= acted_s) - 1;
        let after_s = acted_s - nodes[node];
        let share = if after_s > 0.0 {
            after_s / (nodes[node + 1] - nodes[node])
        } else {
            0.0
        };
        (node, share)
    }
}

/// Those of some times that are at least so far apart, and those at which a segment begins or ends \[s\].
fn spread(times_s: &[f64], sketch: &Sketch, segments: &[Segment], apart_s: f64) -> Vec<f64> {
    let ends = segments
        .iter()
        .filter_map(|segment| sketch.span_s(segment))
        .flatten();
    let mut ends = distinct(ends.collect()).into_iter().peekable();
    // With whether they are ends.
    let mut kept: Vec<(f64, bool)> = Vec::new();
    for acted_s in times_s {
        let is_end = ends.next_if_eq(acted_s).is_some();
        let since_s = kept.last().map_or(f64::INFINITY, |last| acted_s - last.0);
        if is_end {
            // One that would crowd an end gives way.
            let crowds = since_s < 0.5 * apart_s && kept.last().is_some_and(|last| !last.1);
            kept.truncate(kept.len() - usize::from(crowds));
        }
        if is_end || since_s >= apart_s {
            kept.push((*acted_s, is_end));
        }
    }
    kept.into_iter().map(|(acted_s, _)| acted_s).collect()
}

fn distinct(mut times_s: Vec<f64>) -> Vec<f64> {
    times_s.sort_by(f64::total_cmp);
    times_s.dedup();
    times_s
}

#[cfg(test)]
mod tests {
    use nalgebra::{UnitQuaternion, Vector3};

    use super::*;
    use crate::motion::{MechanismIndex, Sample, Stamp, TrackIndex, TrackSketch, View};

    /// Two flights at `rate_hz`, of 0.4 s each, parted by 20 ms.
    fn two_flights(rate_hz: f64) -> (Sketch, Vec<Segment>) {
        let count = (0.4 * rate_hz) as usize;
        let sample = |acted_s: f64| {
            Sample::of_pose(
                Stamp((acted_s * 1e9) as i64),
                acted_s,
                Vector3::zeros(),
                UnitQuaternion::identity(),
            )
        };
        let flight = |from_s: f64| (0..count).map(move |i| sample(from_s + i as f64 / rate_hz));
        let sketch = Sketch {
            origin: Stamp(0),
            tracks: [TrackSketch::new(flight(0.0).chain(flight(0.42)).collect())]
                .into_iter()
                .collect(),
            marks_s: vec![0.41],
            contacts_s: Default::default(),
            cuts_sd_s: Default::default(),
            marks: vec![None],
        };
        let segment = |samples| Segment {
            mechanism: MechanismIndex(0),
            start_event: None,
            end_event: None,
            views: vec![View {
                track: TrackIndex(0),
                samples,
            }],
        };
        (sketch, vec![segment(0..count), segment(count..2 * count)])
    }

    #[test]
    fn a_slow_stream_has_a_node_per_sample() {
        for rate_hz in [30.0, 120.0, 200.0] {
            let (sketch, segments) = two_flights(rate_hz);
            let (all, spaced) = (
                Nodes::everywhere(&sketch, &segments),
                Nodes::spaced(&sketch, &segments),
            );
            assert_eq!(all.acted_s, spaced.acted_s, "{rate_hz}");
            assert_eq!(spaced.samples_each, 1.0);
        }
    }

    #[test]
    fn a_fast_stream_has_as_many_nodes_however_fast_and_they_bound_its_flights() {
        for rate_hz in [1e3, 1e4, 1e5] {
            let (sketch, segments) = two_flights(rate_hz);
            let nodes = Nodes::spaced(&sketch, &segments);
            let count = nodes.acted_s.len() as f64;
            assert!((120.0..=182.0).contains(&count), "{rate_hz}: {count}");
            let each = 2.0 * 0.4 * rate_hz / count;
            assert!((nodes.samples_each / each - 1.0).abs() < 0.02);
            for segment in &segments {
                let samples = sketch.samples_of(&segment.views[0]);
                let places: Vec<(usize, f64)> =
                    samples.iter().map(|s| nodes.place(s.acted_s)).collect();
                let (first, last) = (places[0], places[places.len() - 1]);
                assert!(first.1 == 0.0 && last.1 == 0.0);
                for ((node, share), sample) in places.iter().zip(samples) {
                    assert!((first.0..=last.0).contains(node) && (0.0..1.0).contains(share));
                    let from_s = nodes.acted_s[*node];
                    let to_s = *nodes.acted_s.get(node + 1).unwrap_or(&from_s);
                    let there_s = from_s + share * (to_s - from_s);
                    assert!((there_s - sample.acted_s).abs() < 1e-12);
                }
            }
            let crowded = nodes.acted_s.windows(2).map(|pair| pair[1] - pair[0]);
            assert!(crowded.fold(f64::INFINITY, f64::min) > 0.4 * SPACING_S);
        }
    }
}
