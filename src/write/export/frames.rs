//! The motion on a grid of frames, with keys of its own where it begins, ends and has kinks.

use std::collections::BTreeSet;

use nalgebra::{Quaternion, UnitQuaternion, Vector3, Vector4};

use super::motion::WrittenMotion;
use crate::motion::{LinkIndex, PoseSample, Scene, Stamp};
use crate::report::DeviationMessage;
use crate::sampling::{make_signs_continuous, stamp};

/// How far the stamp of a pose may be from that of a frame which it is \[ns\]: both are rounded.
const SAME_NS: i64 = 1;

/// A pose at a frame, or at an instant of its own.
#[derive(Clone, Debug, PartialEq)]
pub struct Key {
    /// When, and where the body is: world from body.
    pub sample: PoseSample,
    /// The name of the event that happens then.
    pub event: Option<String>,
    /// Whether it is there whatever the grid is: an event, a beginning or an end.
    pub is_exact: bool,
}

/// How deep a straight line from frame to frame may cut off a kink of what is simulated \[m\].
const CUT_M: f64 = 5e-4;

/// What is exported of a body.
#[derive(Clone, Debug, PartialEq)]
pub struct ExportedBody {
    /// The body.
    pub link: LinkIndex,
    /// The motion.
    pub keys: Vec<Key>,
    /// The performance as it was acted, at its samples; empty where it is not asked for or no tracker sees
    /// the body's pose.
    pub acted: Vec<Key>,
}

/// The bodies that have a motion, with keys at every frame of a grid that holds physical time zero, at the
/// motion's beginning and end, at every event between, and where what is simulated bounces.
///
/// A frame that the file has is as it is there. Others are read off the polynomials through the four nearest
/// poses of the same flight, and of what is simulated, which touches at times that are not known, through two.
pub fn exported_bodies(
    scene: &Scene,
    motion: &WrittenMotion,
    frame_rate_hz: f64,
    with_acted: bool,
) -> Vec<ExportedBody> {
    let bodies = scene.links.keys().filter_map(|link| {
        let samples = &motion.estimates[link];
        let acted = motion.sketches[link].iter().filter(|_| with_acted);
        let acted = acted.map(|sample| Key {
            sample: *sample,
            event: None,
            is_exact: true,
        });
        (!samples.is_empty()).then(|| ExportedBody {
            link,
            keys: keys(
                motion,
                samples,
                frame_rate_hz,
                bounces(scene, motion, link, frame_rate_hz),
            ),
            acted: acted.collect(),
        })
    });
    bodies.collect()
}

fn keys(
    motion: &WrittenMotion,
    samples: &[PoseSample],
    frame_rate_hz: f64,
    bounces: BTreeSet<Stamp>,
) -> Vec<Key> {
    let (Some(first), Some(last)) = (samples.first(), samples.last()) else {
        return Vec::new();
    };
    let mut keys: Vec<Key> = Vec::new();
    let ends = [first.stamp, last.stamp];
    for sample in samples {
        let events = motion.events.iter().filter(|(at, _)| *at == sample.stamp);
        let names: Vec<&str> = events.map(|(_, name)| name.as_str()).collect();
        let is_own = ends.contains(&sample.stamp) || bounces.contains(&sample.stamp);
        if !names.is_empty() || is_own {
            keys.push(Key {
                sample: *sample,
                event: (!names.is_empty()).then(|| names.join(" + ")),
                is_exact: true,
            });
        }
    }
    let exact: Vec<Stamp> = keys.iter().map(|key| key.sample.stamp).collect();
    let frame_of = |at: Stamp| at.seconds_since(motion.zero) * frame_rate_hz;
    let (from, to) = (
        frame_of(ends[0]).floor() as i64,
        frame_of(ends[1]).ceil() as i64,
    );
    for frame in from..=to {
        let at = stamp(motion.zero, frame as f64 / frame_rate_hz);
        let is_there = exact.iter().any(|of| (of.0 - at.0).abs() <= SAME_NS);
        if is_there || at < ends[0] || at > ends[1] {
            continue;
        }
        keys.push(Key {
            sample: pose_at(motion, samples, at),
            event: None,
            is_exact: false,
        });
    }
    keys.sort_by_key(|key| key.sample.stamp);
    let mut samples: Vec<PoseSample> = keys.iter().map(|key| key.sample).collect();
    make_signs_continuous(&mut samples);
    for (key, sample) in keys.iter_mut().zip(samples) {
        key.sample = sample;
    }
    keys
}

/// Poses of what is simulated that frames would cut off: those about a kink, where the velocity jumps from one step to
/// the next by more than gravity does.
fn bounces(
    scene: &Scene,
    motion: &WrittenMotion,
    link: LinkIndex,
    frame_rate_hz: f64,
) -> BTreeSet<Stamp> {
    let samples = &motion.estimates[link];
    let Some(from) = motion.simulated_from else {
        return BTreeSet::new();
    };
    let begin = samples.partition_point(|sample| sample.stamp < from);
    // Gravity alone pulls at the centre of mass; the frame in which the body is given goes round it.
    let centre_m = scene.links[link]
        .link_from_given
        .inverse()
        .translation
        .vector;
    let place_m = |sample: &PoseSample| {
        let [x, y, z, w] = sample.quaternion_xyzw;
        let turn = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z));
        sample.position_m + turn * centre_m
    };
    let mut kept = BTreeSet::new();
    for three in samples[begin..].windows(3) {
        let [before_s, after_s] =
            [0, 1].map(|at| three[at + 1].stamp.seconds_since(three[at].stamp));
        let [first, middle, last] = [0, 1, 2].map(|at| place_m(&three[at]));
        let fallen_m_s = scene.gravity_m_s2 * (0.5 * (before_s + after_s));
        let jump_m_s = (last - middle) / after_s - (middle - first) / before_s - fallen_m_s;
        // A line over a kink is off by a quarter of a frame's way at most.
        if 0.25 * jump_m_s.norm() / frame_rate_hz > CUT_M {
            kept.extend(three.iter().map(|sample| sample.stamp));
        }
    }
    kept
}

/// Where the motion has a body at a time; `None` before it begins and after it ends.
pub fn motion_at(motion: &WrittenMotion, link: LinkIndex, at: Stamp) -> Option<PoseSample> {
    let samples = &motion.estimates[link];
    let is_within = samples.first()?.stamp <= at && at <= samples.last()?.stamp;
    is_within.then(|| pose_at(motion, samples, at))
}

/// How certain a body is at a time: between the two poses of one flight next to it, in proportion; `None` where the file
/// does not say it.
pub fn deviation_at(
    motion: &WrittenMotion,
    link: LinkIndex,
    at: Stamp,
) -> Option<DeviationMessage> {
    let told = motion.deviations.get(link)?;
    let after = told.partition_point(|of| of.stamp().0 < at.0 - SAME_NS);
    let near = told.get(after)?;
    if (near.stamp().0 - at.0).abs() <= SAME_NS {
        return Some(*near);
    }
    let before = &told[after.checked_sub(1)?];
    // At an event it is that of the flight before.
    if motion
        .events
        .iter()
        .any(|(event, _)| *event == before.stamp())
    {
        return Some(*near);
    }
    let share = at.seconds_since(before.stamp()) / near.stamp().seconds_since(before.stamp());
    Some(before.towards(near, share, at))
}

/// Where a body was acted at a physical time, between the two samples next to it; `None` where they are farther
/// apart than that.
pub fn acted_at(
    motion: &WrittenMotion,
    link: LinkIndex,
    at: Stamp,
    farthest_s: f64,
) -> Option<PoseSample> {
    let samples = &motion.sketches[link];
    let after = samples.partition_point(|sample| sample.stamp < at);
    let near = samples.get(after)?;
    if near.stamp == at {
        return Some(*near);
    }
    let before = &samples[after.checked_sub(1)?];
    let is_near = near.stamp.seconds_since(before.stamp) <= farthest_s;
    is_near.then(|| interpolated(&[*before, *near], at))
}

/// How fast a motion turns at most \[rad/s\].
pub fn fastest_turn_rad_s(samples: &[PoseSample]) -> f64 {
    // An event may be so near to a frame that rounding would count.
    const SHORTEST_S: f64 = 1e-5;
    let rates = samples.windows(2).map(|pair| {
        let [a, b] = [&pair[0], &pair[1]].map(|of| Vector4::from(of.quaternion_xyzw));
        let quarter_rad = (b - a).norm().atan2((b + a).norm());
        let duration_s = pair[1].stamp.seconds_since(pair[0].stamp);
        4.0 * quarter_rad / duration_s.max(SHORTEST_S)
    });
    rates.fold(0.0, f64::max)
}

/// The pose at a time within the samples.
fn pose_at(motion: &WrittenMotion, samples: &[PoseSample], at: Stamp) -> PoseSample {
    let after = samples.partition_point(|sample| sample.stamp.0 < at.0 - SAME_NS);
    let near = &samples[after];
    if (near.stamp.0 - at.0).abs() <= SAME_NS || after == 0 {
        return *near;
    }
    let is_kink = |index: usize| {
        let stamp = samples[index].stamp;
        motion.simulated_from.is_some_and(|from| stamp >= from)
            || motion.events.iter().any(|(event, _)| *event == stamp)
    };
    let (mut from, mut to) = (after - 1, after);
    while to - from < 3 {
        let (may_before, may_after) = (
            from > 0 && !is_kink(from),
            to + 1 < samples.len() && !is_kink(to),
        );
        if may_before && (!may_after || after - from <= to + 1 - after) {
            from -= 1;
        } else if may_after {
            to += 1;
        } else {
            break;
        }
    }
    interpolated(&samples[from..=to], at)
}

/// The polynomial through all of some samples, of which neighbouring quaternions have one sign.
fn interpolated(samples: &[PoseSample], at: Stamp) -> PoseSample {
    let mut position_m = Vector3::zeros();
    let mut turn = Vector4::zeros();
    for (index, sample) in samples.iter().enumerate() {
        let others = samples
            .iter()
            .enumerate()
            .filter(|(other, _)| *other != index);
        let weights = others.map(|(_, other)| {
            at.seconds_since(other.stamp) / sample.stamp.seconds_since(other.stamp)
        });
        let weight: f64 = weights.product();
        position_m += weight * sample.position_m;
        turn += weight * Vector4::from(sample.quaternion_xyzw);
    }
    PoseSample::new(at, position_m, turn.normalize().into())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A fall with a bounce at 0.2 s whose poses are at 240 Hz.
    fn bounced(at_s: f64) -> (Vector3<f64>, UnitQuaternion<f64>) {
        let since_s = at_s - 0.2;
        let (rate_m_s, turn_rad) = match since_s < 0.0 {
            true => (-1.5, 30.0 * since_s),
            false => (1.2, -12.0 * since_s),
        };
        let height_m = rate_m_s * since_s - 4.903 * since_s * since_s;
        let axis = Vector3::new(0.6, 0.0, 0.8);
        (
            Vector3::new(0.3 * since_s, 0.0, height_m),
            UnitQuaternion::from_scaled_axis(axis * turn_rad),
        )
    }

    fn motion() -> (WrittenMotion, Vec<PoseSample>) {
        let zero = Stamp(5_000_000_007);
        let times_s = (0..=96).map(|frame| f64::from(frame) / 240.0);
        let samples = times_s.map(|at_s| {
            let (position_m, turn) = bounced(at_s);
            PoseSample::new(stamp(zero, at_s), position_m, turn.coords.into())
        });
        let mut samples: Vec<PoseSample> = samples.collect();
        make_signs_continuous(&mut samples);
        let motion = WrittenMotion {
            verdict: "physical".to_owned(),
            provenance: None,
            report: Vec::new(),
            zero,
            events: vec![(stamp(zero, 0.2), "bounce".to_owned())],
            simulated_from: None,
            parameters: Vec::new(),
            estimates: Default::default(),
            deviations: Default::default(),
            sketches: Default::default(),
        };
        (motion, samples)
    }

    #[test]
    fn frames_between_those_of_the_file_are_of_the_flight_that_they_are_in() {
        let (motion, samples) = motion();
        for rate_hz in [25.0, 30.0, 1000.0, 59.94] {
            let keys = keys(&motion, &samples, rate_hz, BTreeSet::new());
            assert!(keys.len() as f64 > 0.4 * rate_hz);
            for key in &keys {
                let at_s = key.sample.stamp.seconds_since(motion.zero);
                let (position_m, turn) = bounced(at_s);
                let off_m = (key.sample.position_m - position_m).norm();
                let [x, y, z, w] = key.sample.quaternion_xyzw;
                let read = UnitQuaternion::new_unchecked(nalgebra::Quaternion::new(w, x, y, z));
                // Stamps are rounded to nanoseconds; a quaternion's fourth derivative is (30/2)⁴.
                assert!(off_m < 1e-8, "{rate_hz} Hz at {at_s} s: {off_m} m");
                assert!(read.angle_to(&turn) < 3e-6, "{rate_hz} Hz at {at_s} s");
            }
        }
    }

    #[test]
    fn what_is_simulated_has_keys_where_it_bounces() {
        let (mut motion, samples) = motion();
        motion.events.clear();
        motion.simulated_from = Some(samples[0].stamp);
        let scene = crate::fixture::scene();
        motion.estimates = vec![samples.clone(); scene.links.len()].into();
        let link = LinkIndex(0);
        let floor_m = |at_s: f64| (at_s - 0.2).abs() < 1.0 / 60.0;
        let bounced_at = bounces(&scene, &motion, link, 24.0);
        let times_s = bounced_at.iter().map(|at| at.seconds_since(motion.zero));
        let times_s: Vec<f64> = times_s.collect();
        assert!(
            !times_s.is_empty() && times_s.iter().all(|at_s| floor_m(*at_s)),
            "{times_s:?}"
        );
        let keyed = keys(&motion, &samples, 24.0, bounced_at);
        let lowest_m = keyed.iter().map(|key| key.sample.position_m.z);
        let lowest_m = lowest_m.fold(f64::INFINITY, f64::min);
        assert!(lowest_m.abs() < 1e-6, "{lowest_m}");
        // At the rate of the simulation nothing is cut off.
        let fine = bounces(&scene, &motion, link, 2400.0);
        assert!(fine.is_empty(), "{fine:?}");
    }

    #[test]
    fn frames_of_the_file_are_as_they_are_and_kinks_have_keys() {
        let (motion, samples) = motion();
        let keys = keys(&motion, &samples, 24.0, BTreeSet::new());
        // 0.4 s are 9.6 frames: ten of them, the bounce, and the end.
        assert_eq!(keys.len(), 12);
        for key in &keys {
            let mut same = samples.iter().filter(|of| of.stamp == key.sample.stamp);
            assert_eq!(same.next(), Some(&key.sample));
        }
        let events: Vec<_> = keys.iter().filter_map(|key| key.event.as_deref()).collect();
        assert_eq!(events, ["bounce"]);
        assert_eq!(keys[11].sample, samples[96]);
    }

    #[test]
    fn the_fastest_turn_is_that_of_the_faster_flight() {
        let (_, samples) = motion();
        let fastest_rad_s = fastest_turn_rad_s(&samples);
        assert!((fastest_rad_s - 30.0).abs() < 1e-4, "{fastest_rad_s}");
    }

    #[test]
    fn what_is_simulated_is_between_its_neighbours() {
        let (mut motion, samples) = motion();
        motion.simulated_from = Some(motion.zero);
        let at = stamp(motion.zero, 0.19 + 0.5 / 240.0);
        let read = pose_at(&motion, &samples, at);
        let after = samples.partition_point(|of| of.stamp < at);
        assert_eq!(read, interpolated(&samples[after - 1..=after], at));
    }
}
