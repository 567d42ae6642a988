//! How the flights fall by the streams alone, whatever the scene says of gravity and units.
//!
//! ```text
//! min over x, v of each flight, δ of each track and one a   Σ |p_i − x − v s_i − ½ a s_i² − R_i δ|²
//! ```
//!
//! with the mount as it is given (`δ = 0`), and with any other offset of the tracker: a wrong one, or one in
//! another unit than the stream, adds what the turning body does to the fall. The first is the more
//! certain where the mount is right and the body hardly turns.

use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};

use crate::motion::{PoseSample, Scene, Stamp, TakeEvent, TrackIndex};

/// Share of a flight left out at either end: marks are off by a reaction time.
const MARGIN: f64 = 0.1;
/// Least number of samples of a flight.
const LEAST: usize = 5;

/// What the streams show, in their own axes and units.
#[derive(Clone, Copy, Debug)]
pub(super) struct SeenFall {
    /// Acceleration of the flights.
    pub(super) acceleration_m_s2: Vector3<f64>,
    /// Whether every stamp is a whole number of seconds after the first.
    pub(super) is_whole_seconds: bool,
}

/// The fall of the flights between the marks, with the mounts as given and with any others; none where no
/// flight has enough samples.
pub(super) fn falls(scene: &Scene, events: &[TakeEvent]) -> Vec<SeenFall> {
    fallen(scene, events).unwrap_or_default()
}

fn fallen(scene: &Scene, events: &[TakeEvent]) -> Option<Vec<SeenFall>> {
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
        // What is held or apart does not fall here.
        if scene.tracks.get(*track).is_some() && !scene.sees_moving(*track) {
            continue;
        }
        let of = (*track, *stream);
        match streams.iter_mut().find(|(other, _)| *other == of) {
            Some((_, samples)) => samples.push(*sample),
            None => streams.push((of, vec![*sample])),
        }
    }
    let (mut given, mut freed) = (FallSums::default(), FallSums::default());
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
        let points: Vec<FallPoint> = samples
            .iter()
            .filter_map(|sample| {
                let since_ns = i128::from(sample.stamp.0) - i128::from(first.0);
                let [x, y, z, w] = sample.quaternion_xyzw;
                let turn = UnitQuaternion::try_new(Quaternion::new(w, x, y, z), 0.5)?;
                let centre_m = sample.position_m + turn * tracker_from_link.translation.vector;
                let is_finite = centre_m.iter().all(|x| x.is_finite());
                is_finite.then(|| FallPoint {
                    time_s: since_ns as f64 * 1e-9,
                    centre_m,
                    turn: turn.to_rotation_matrix().into_inner(),
                })
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
        let mut sums = TrackSums::default();
        for pair in ends_s.windows(2) {
            let from = points.partition_point(|point| point.time_s < pair[0]);
            let to = points.partition_point(|point| point.time_s < pair[1]);
            sums.add(&points[from..to.max(from)]);
        }
        given.add(Matrix3::identity() * sums.bow, sums.pull);
        // The offset eliminated, where the body turns.
        if let Some(inverse) = sums.turn.try_inverse() {
            let bend = sums.bend * inverse;
            let information = Matrix3::identity() * sums.bow - bend * sums.bend.transpose();
            freed.add(information, sums.pull - bend * sums.right);
        }
    }
    let falls = [given, freed].into_iter().filter_map(|sums| {
        let acceleration_m_s2 = sums.information.try_inverse()? * sums.pull;
        let is_finite = acceleration_m_s2.iter().all(|x| x.is_finite());
        is_finite.then_some(SeenFall {
            acceleration_m_s2,
            is_whole_seconds,
        })
    });
    Some(falls.collect())
}

/// A reading as the body's pose.
struct FallPoint {
    time_s: f64,
    centre_m: Vector3<f64>,
    turn: Matrix3<f64>,
}

/// Normal equations for the acceleration.
#[derive(Default)]
struct FallSums {
    information: Matrix3<f64>,
    pull: Vector3<f64>,
}

impl FallSums {
    fn add(&mut self, information: Matrix3<f64>, pull: Vector3<f64>) {
        self.information += information;
        self.pull += pull;
    }
}

/// Normal equations of one track for the acceleration and the offset.
#[derive(Default)]
struct TrackSums {
    bow: f64,
    pull: Vector3<f64>,
    bend: Matrix3<f64>,
    turn: Matrix3<f64>,
    right: Vector3<f64>,
}

impl TrackSums {
    /// Adds a flight: what of it is orthogonal to a straight line.
    fn add(&mut self, points: &[FallPoint]) {
        let margin = (MARGIN * points.len() as f64).ceil() as usize;
        let Some(points) = points.get(margin..points.len().saturating_sub(margin)) else {
            return;
        };
        if points.len() < LEAST {
            return;
        }
        let count = points.len() as f64;
        let mean_s = points.iter().map(|point| point.time_s).sum::<f64>() / count;
        let moment = |power: i32| -> f64 {
            points
                .iter()
                .map(|point| (point.time_s - mean_s).powi(power))
                .sum()
        };
        let square_s2 = moment(2);
        if square_s2 <= 0.0 {
            return;
        }
        let slope_s = moment(3) / square_s2;
        let (mut mean, mut slope) = (Matrix3::zeros(), Matrix3::zeros());
        for point in points {
            mean += point.turn / count;
            slope += point.turn * ((point.time_s - mean_s) / square_s2);
        }
        for point in points {
            let since_s = point.time_s - mean_s;
            let bow = 0.5 * (since_s * since_s - square_s2 / count - slope_s * since_s);
            let turned = point.turn - mean - slope * since_s;
            self.bow += bow * bow;
            self.pull += point.centre_m * bow;
            self.bend += turned * bow;
            self.turn += turned.tr_mul(&turned);
            self.right += turned.tr_mul(&point.centre_m);
        }
    }
}
