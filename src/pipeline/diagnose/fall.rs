//! How the flights fall by the streams alone, whatever the scene says of gravity and units.
//!
//! ```text
//! min over x, v of each flight and one a   Σ |p_i − x − v s_i − ½ a s_i²|²
//! ```

use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use crate::motion::{PoseSample, Scene, Stamp, TakeEvent, TrackIndex};

/// Share of a flight left out at either end: marks are off by a reaction time.
const MARGIN: f64 = 0.1;
/// Least number of samples of a flight.
const LEAST: usize = 5;

/// What the streams show, in their own axes and units.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fall {
    /// Acceleration of the flights.
    pub(super) acceleration_m_s2: Vector3<f64>,
    /// Whether every stamp is a whole number of seconds after the first.
    pub(super) is_whole_seconds: bool,
}

/// The fall of the flights between the marks; `None` where no flight has enough samples.
pub(super) fn fall(scene: &Scene, events: &[TakeEvent]) -> Option<Fall> {
    let mut cuts: Vec<Stamp> = events
        .iter()
        .filter_map(|event| match event {
            TakeEvent::Mark(mark) => Some(mark.stamp),
            TakeEvent::Pose { .. } => None,
        })
        .collect();
    cuts.sort_unstable();
    let mut streams: Vec<((TrackIndex, usize), Vec<PoseSample>)> = Vec::new();
    for event in events {
        let TakeEvent::Pose {
            track,
            stream,
            sample,
        } = event
        else {
            continue;
        };
        let of = (*track, *stream);
        match streams.iter_mut().find(|(other, _)| *other == of) {
            Some((_, samples)) => samples.push(*sample),
            None => streams.push((of, vec![*sample])),
        }
    }
    let mut sums = Sums::default();
    let mut is_whole_seconds = true;
    for ((track, _), samples) in &mut streams {
        samples.sort_by_key(|sample| sample.stamp);
        let tracker_from_link = scene.tracks.get(*track)?.link_from_tracker.inverse();
        let first = samples.first()?.stamp;
        let is_whole = |sample: &PoseSample| {
            let since_ns = i128::from(sample.stamp.0) - i128::from(first.0);
            since_ns % 1_000_000_000 == 0
        };
        is_whole_seconds &= samples.iter().all(is_whole);
        let points: Vec<(f64, Vector3<f64>)> = samples
            .iter()
            .filter_map(|sample| {
                let since_ns = i128::from(sample.stamp.0) - i128::from(first.0);
                let [x, y, z, w] = sample.quaternion_xyzw;
                let turn = UnitQuaternion::try_new(Quaternion::new(w, x, y, z), 0.5)?;
                let centre_m = sample.position_m + turn * tracker_from_link.translation.vector;
                let is_finite = centre_m.iter().all(|x| x.is_finite());
                is_finite.then_some((since_ns as f64 * 1e-9, centre_m))
            })
            .collect();
        let cuts_s = cuts
            .iter()
            .map(|cut| (i128::from(cut.0) - i128::from(first.0)) as f64 * 1e-9);
        let ends_s: Vec<f64> = [f64::NEG_INFINITY]
            .into_iter()
            .chain(cuts_s)
            .chain([f64::INFINITY])
            .collect();
        for pair in ends_s.windows(2) {
            let from = points.partition_point(|(time_s, _)| *time_s < pair[0]);
            let to = points.partition_point(|(time_s, _)| *time_s < pair[1]);
            sums.add(&points[from..to.max(from)]);
        }
    }
    (sums.weight > 0.0).then(|| Fall {
        acceleration_m_s2: sums.pull / sums.weight,
        is_whole_seconds,
    })
}

#[derive(Default)]
struct Sums {
    pull: Vector3<f64>,
    weight: f64,
}

impl Sums {
    /// Adds a flight: what of it is orthogonal to a straight line.
    fn add(&mut self, points: &[(f64, Vector3<f64>)]) {
        let margin = (MARGIN * points.len() as f64).ceil() as usize;
        let Some(points) = points.get(margin..points.len().saturating_sub(margin)) else {
            return;
        };
        if points.len() < LEAST {
            return;
        }
        let count = points.len() as f64;
        let mean_s = points.iter().map(|(s, _)| s).sum::<f64>() / count;
        let square_s2: f64 = points.iter().map(|(s, _)| (s - mean_s).powi(2)).sum();
        if square_s2 <= 0.0 {
            return;
        }
        let mean = points
            .iter()
            .map(|(s, _)| (s - mean_s).powi(2))
            .sum::<f64>()
            / count;
        let slope = points
            .iter()
            .map(|(s, _)| (s - mean_s).powi(3))
            .sum::<f64>()
            / square_s2;
        for (s, position_m) in points {
            let since_s = s - mean_s;
            let bow = 0.5 * (since_s * since_s - mean - slope * since_s);
            self.pull += position_m * bow;
            self.weight += bow * bow;
        }
    }
}
