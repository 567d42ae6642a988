//! The estimated motion and the performance of one body as stamped poses.

use std::collections::BTreeMap;

use nalgebra::{Quaternion, UnitQuaternion};

use super::error::SamplingError;
use crate::math::Pose;
use crate::motion::held::{GripEstimate, HeldEstimate};
use crate::motion::{
    ArcEstimate, Estimate, EventEstimate, JointTree, LinkIndex, MechanismIndex, PoseSample, Scene,
    Seen, Settled, Sketch, Stamp,
};
use crate::physics::State;
use crate::physics::flow::{Fall, Spin, Supported};
use crate::physics::impact::{Pressed, Velocities};
use crate::physics::tree::{Snapshot, Tree, TreeState};

/// Most frames that are made, of all links: [`FRAME_LIMIT`] and so many per sample that was read. A
/// frame takes a kilobyte in memory, and two samples may be years apart. More is no motion but the
/// trace of an estimation that ran away.
const FRAME_LIMIT: f64 = 200_000.0;
const FRAMES_PER_SAMPLE: f64 = 20.0;

/// Farthest frame from time zero: a day at 240 Hz.
const FARTHEST_FRAME: f64 = 86_400.0 * 240.0;

/// Frame rates at which frames are made \[Hz\].
const FRAME_RATES_HZ: std::ops::RangeInclusive<f64> = 1e-3..=1e5;

/// Physical time zero: the stamp of the first sample used.
pub fn zero(estimate: &Estimate, sketch: &Sketch) -> Stamp {
    estimate
        .all_sample_times()
        .map(|sample| sample.stamp)
        .min()
        .unwrap_or(sketch.origin)
}

/// The stamp of a physical time \[s\].
pub fn stamp(zero: Stamp, time_s: f64) -> Stamp {
    // A float converts to the nearest integer in range.
    Stamp(zero.0.saturating_add((time_s * 1e9).round() as i64))
}

/// A link's estimated poses, those of the frame in which the scene gives it, at every frame of a grid that
/// holds time zero, at the beginning and end of its motion, and at every event in between. At a collision, whose sides may differ
/// by a gap, the pose is the one before it. Stamps increase strictly; what would be stamped
/// before 1970, which messages cannot say, is left out. Fails where the rate is not of 0.001 to 100 000 Hz, or
/// the motion of all links would have more frames than 200,000 and twenty per sample.
pub fn estimate_frames(
    scene: &Scene,
    estimate: &Estimate,
    link: LinkIndex,
    zero: Stamp,
    frame_rate_hz: f64,
) -> Result<Vec<PoseSample>, SamplingError> {
    if !FRAME_RATES_HZ.contains(&frame_rate_hz) {
        return Err(SamplingError::FrameRate { frame_rate_hz });
    }
    let mechanism = scene.mechanism_of(link);
    let mut samples = match (estimate.held_motion(link), scene.joint_tree(mechanism)) {
        (Some(held), _) => held_frames(scene, estimate, held, zero, frame_rate_hz)?,
        (None, Some(joined)) => tree_frames(scene, joined, estimate, link, zero, frame_rate_hz)?,
        (None, None) => free_frames(scene, estimate, link, zero, frame_rate_hz)?,
    };
    give(&mut samples, &scene.links[link].link_from_given);
    make_signs_continuous(&mut samples);
    Ok(samples)
}

/// Poses of a link become those of the frame in which the scene gives it.
fn give(samples: &mut [PoseSample], link_from_given: &Pose) {
    if *link_from_given == Pose::identity() {
        return;
    }
    for sample in samples {
        let [x, y, z, w] = sample.quaternion_xyzw;
        let turn = UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z));
        let world_from_link = Pose::from_parts(sample.position_m.into(), turn);
        let given = PoseSample::from_pose(sample.stamp, &(world_from_link * link_from_given));
        sample.position_m = given.position_m;
        sample.quaternion_xyzw = given.quaternion_xyzw;
    }
}

/// The poses of a body by itself.
fn free_frames(
    scene: &Scene,
    estimate: &Estimate,
    link: LinkIndex,
    zero: Stamp,
    frame_rate_hz: f64,
) -> Result<Vec<PoseSample>, SamplingError> {
    let mut pieces = pieces(scene, estimate, link);
    let (Some(first), Some(last)) = (pieces.first(), pieces.last()) else {
        return Ok(Vec::new());
    };
    let times_s = times_s(
        scene,
        link,
        estimate,
        [first.span_s()[0], last.span_s()[1]],
        pieces.iter().flat_map(FramedPiece::span_s),
        zero,
        frame_rate_hz,
    )?;
    let poses = times_s.into_iter().filter(|(stamp, _)| stamp.0 >= 0);
    let samples = poses.map(|(stamp, time_s)| {
        let pose = pose_at(&mut pieces, time_s);
        PoseSample::from_pose(stamp, &pose)
    });
    Ok(samples.collect())
}

/// The parts of the motion of a body by itself, in order of time.
pub(super) fn pieces<'a>(
    scene: &'a Scene,
    estimate: &'a Estimate,
    link: LinkIndex,
) -> Vec<FramedPiece<'a>> {
    let mechanism = scene.mechanism_of(link);
    let arcs: Vec<&ArcEstimate> = estimate
        .arcs
        .iter()
        .filter(|arc| arc.mechanism == mechanism && arc.end_s >= arc.start_s)
        .collect();
    let flights = arcs.into_iter().map(|arc| {
        let body = &scene.body_on(arc);
        FramedPiece::Arc(Box::new(FramedArc {
            arc,
            fall: Fall::new(body, &estimate.gravity_m_s2, &arc.state),
            spin: Spin::new(body, &arc.state.angular_velocity_rad_s),
            supported: Supported::new(body, &estimate.gravity_m_s2, &arc.state),
        }))
    });
    let grips = estimate.grips_of(link).map(FramedPiece::Grip);
    let events = estimate.events.iter();
    let pressed = events.filter_map(|event| pressed(scene, estimate, link, event));
    let mut pieces: Vec<FramedPiece> = grips.chain(flights).chain(pressed).collect();
    pieces.sort_by(|a, b| a.span_s()[0].total_cmp(&b.span_s()[0]));
    pieces
}

/// Times of frames and events within a motion, and of its ends, by their stamps.
fn times_s(
    scene: &Scene,
    link: LinkIndex,
    estimate: &Estimate,
    [start_s, end_s]: [f64; 2],
    ends: impl Iterator<Item = f64>,
    zero: Stamp,
    frame_rate_hz: f64,
) -> Result<BTreeMap<Stamp, f64>, SamplingError> {
    let frames = (end_s - start_s) * frame_rate_hz;
    let farthest = start_s.abs().max(end_s.abs()) * frame_rate_hz;
    // Not so of numbers that are not finite either.
    let samples = estimate.all_sample_times().count() as f64;
    let most = (FRAME_LIMIT + FRAMES_PER_SAMPLE * samples) / scene.links.len().max(1) as f64;
    let is_sane = frames <= most && farthest <= FARTHEST_FRAME;
    if !is_sane {
        return Err(SamplingError::Span {
            body: scene.links[link].name.clone(),
            start_s,
            end_s,
        });
    }
    let mut times_s = BTreeMap::new();
    let (from, to) = (
        (start_s * frame_rate_hz).ceil() as i64,
        (end_s * frame_rate_hz).floor() as i64,
    );
    for frame in from..=to {
        let time_s = frame as f64 / frame_rate_hz;
        times_s.insert(stamp(zero, time_s), time_s);
    }
    // After the frames, so that where both fall on one nanosecond the exact time stays.
    let events = estimate.events.iter().map(|event| event.time_s);
    for time_s in events.chain(ends) {
        if (start_s..=end_s).contains(&time_s) {
            times_s.insert(stamp(zero, time_s), time_s);
        }
    }
    Ok(times_s)
}

/// The poses of a held link, over the time of all flights.
fn held_frames(
    scene: &Scene,
    estimate: &Estimate,
    held: &HeldEstimate,
    zero: Stamp,
    frame_rate_hz: f64,
) -> Result<Vec<PoseSample>, SamplingError> {
    let Some(extent_s) = estimate.extent_s() else {
        return Ok(Vec::new());
    };
    let times_s = times_s(
        scene,
        held.link,
        estimate,
        extent_s,
        extent_s.into_iter(),
        zero,
        frame_rate_hz,
    )?;
    let poses = times_s.into_iter().filter(|(stamp, _)| stamp.0 >= 0);
    let poses = poses
        .map(|(stamp, time_s)| PoseSample::from_pose(stamp, &held.state(time_s).world_from_body()));
    Ok(poses.collect())
}

/// The poses of a link of a tree.
fn tree_frames(
    scene: &Scene,
    joined: &JointTree,
    estimate: &Estimate,
    link: LinkIndex,
    zero: Stamp,
    frame_rate_hz: f64,
) -> Result<Vec<PoseSample>, SamplingError> {
    let tree = scene.tree_model_with(joined, &estimate.held);
    let place = joined.place_of(link).expect("a link of the tree");
    let mut snapshot = Snapshot::new(&tree, &estimate.gravity_m_s2);
    let states = tree_states(
        scene,
        &tree,
        estimate,
        scene.mechanism_of(link),
        zero,
        frame_rate_hz,
    )?;
    let poses = states.into_iter().map(|(stamp, state)| {
        snapshot.set(&state);
        PoseSample::from_pose(stamp, &snapshot.world_from_link(place))
    });
    Ok(poses.collect())
}

/// The states of a tree at its frames and events; none where it has no motion.
pub(super) fn tree_states(
    scene: &Scene,
    tree: &Tree,
    estimate: &Estimate,
    mechanism: MechanismIndex,
    zero: Stamp,
    frame_rate_hz: f64,
) -> Result<Vec<(Stamp, TreeState)>, SamplingError> {
    let Some(motion) = estimate.tree_motion(mechanism) else {
        return Ok(Vec::new());
    };
    let span_s = motion.span_s();
    let first = scene.mechanisms[mechanism].links().next();
    let times_s = times_s(
        scene,
        first.expect("a mechanism has links"),
        estimate,
        span_s,
        span_s.into_iter(),
        zero,
        frame_rate_hz,
    )?;
    let times_s = times_s.into_iter().filter(|(stamp, _)| stamp.0 >= 0);
    let gravity_m_s2 = &estimate.gravity_m_s2;
    let states = times_s.map(|(stamp, time_s)| (stamp, motion.state(tree, gravity_m_s2, time_s)));
    Ok(states.collect())
}

/// Appends a link's simulated poses: those stamped after its estimated ones.
pub(super) fn append_settled(
    samples: &mut Vec<PoseSample>,
    settled: &Settled,
    scene: &Scene,
    link: LinkIndex,
    zero: Stamp,
) {
    let Some(last) = samples.last().map(|sample| sample.stamp) else {
        return;
    };
    let poses = settled.links.get(link).map_or(&[][..], |link| &link.poses);
    for (step, pose) in poses.iter().enumerate() {
        let time_s = settled.from_s + step as f64 * settled.interval_s;
        let stamp = stamp(zero, time_s);
        if stamp > last {
            let world_from_given = pose * scene.links[link].link_from_given;
            samples.push(PoseSample::from_pose(stamp, &world_from_given));
        }
    }
    make_signs_continuous(samples);
}

/// The used samples of what sees a link's pose, at their physical times, as poses of the frame in which the
/// scene gives the link.
pub fn sketch_frames(
    scene: &Scene,
    estimate: &Estimate,
    sketch: &Sketch,
    link: LinkIndex,
    zero: Stamp,
) -> Vec<PoseSample> {
    let mut samples: Vec<PoseSample> = estimate
        .all_sample_times()
        .filter(|time| scene.tracks[time.track].link == link)
        .filter_map(|time| {
            let samples = &sketch.tracks.get(time.track)?.samples;
            let at = samples
                .binary_search_by_key(&time.stamp, |sample| sample.stamp)
                .ok()?;
            let Seen::Pose {
                position_m,
                orientation,
            } = samples[at].seen
            else {
                return None;
            };
            let pose = Pose::from_parts(position_m.into(), orientation);
            Some(PoseSample::from_pose(stamp(zero, time.time_s), &pose))
        })
        .filter(|sample| sample.stamp.0 >= 0)
        .collect();
    samples.sort_by_key(|sample| sample.stamp);
    give(&mut samples, &scene.links[link].link_from_given);
    make_signs_continuous(&mut samples);
    samples
}

/// An arc, flight or on a support, from which many poses are asked for.
pub(super) struct FramedArc<'a> {
    pub(super) arc: &'a ArcEstimate,
    fall: Fall,
    spin: Spin,
    supported: Option<Supported>,
}

/// A part of a motion.
pub(super) enum FramedPiece<'a> {
    /// By itself.
    Arc(Box<FramedArc<'a>>),
    /// In a hand.
    Grip(&'a GripEstimate),
    /// In a contact that lasts.
    Pressed(Box<PressedPiece>),
}

/// A body in a contact that lasts.
pub(super) struct PressedPiece {
    touch_s: f64,
    touching: State,
    /// The velocities after an impact of one moment.
    after: Velocities,
    pressed: Pressed,
}

/// What a link does while it presses on something at an event, if it does.
fn pressed<'a>(
    scene: &Scene,
    estimate: &Estimate,
    link: LinkIndex,
    event: &EventEstimate,
) -> Option<FramedPiece<'a>> {
    let collision = scene.events[event.event].kind.collision()?;
    collision.links().find(|other| *other == link)?;
    let pressed = scene.pressed(estimate, event, link)?;
    let mechanism = scene.mechanism_of(link);
    let mut arcs = estimate.arcs.iter();
    let after = arcs.find(|of| of.mechanism == mechanism && of.start_s == event.left_s())?;
    let touching = estimate.arriving(scene, link, event.time_s)?;
    let left = scene.flown(after, &estimate.gravity_m_s2, event.left_s());
    Some(FramedPiece::Pressed(Box::new(PressedPiece {
        touch_s: event.time_s,
        touching,
        after: pressed.after(&touching, &left),
        pressed,
    })))
}

impl FramedPiece<'_> {
    pub(super) fn span_s(&self) -> [f64; 2] {
        match self {
            FramedPiece::Arc(of) => [of.arc.start_s, of.arc.end_s],
            FramedPiece::Grip(of) => of.span_s,
            FramedPiece::Pressed(of) => [of.touch_s, of.touch_s + of.pressed.duration_s],
        }
    }
}

impl PressedPiece {
    pub(super) fn state(&self, time_s: f64) -> State {
        let since_s = time_s - self.touch_s;
        self.pressed.state(&self.touching, &self.after, since_s)
    }
}

/// The pose at a physical time within the motion: on the first piece that has not ended.
fn pose_at(pieces: &mut [FramedPiece], time_s: f64) -> Pose {
    let at = pieces.iter().position(|of| time_s <= of.span_s()[1]);
    let at = at.unwrap_or(pieces.len() - 1);
    let of = match &mut pieces[at] {
        FramedPiece::Arc(of) => of,
        FramedPiece::Grip(of) => return of.state(time_s).world_from_body(),
        FramedPiece::Pressed(of) => {
            return of.state(time_s).world_from_body();
        }
    };
    let FramedArc {
        arc,
        fall,
        spin,
        supported,
    } = &mut **of;
    let duration_s = time_s - arc.epoch_s;
    if let Some(supported) = supported {
        return supported.at(duration_s).world_from_body();
    }
    Pose::from_parts(
        fall.position(duration_s).into(),
        arc.state.orientation * spin.turn(duration_s),
    )
}

/// Quaternions q and −q are one rotation, but not to a viewer that interpolates them.
pub fn make_signs_continuous(samples: &mut Vec<PoseSample>) {
    let mut last = UnitQuaternion::identity().coords;
    for sample in samples {
        let [x, y, z, w] = sample.quaternion_xyzw;
        let mut coords = nalgebra::Vector4::new(x, y, z, w);
        if coords.dot(&last) < 0.0 {
            coords = -coords;
            sample.quaternion_xyzw = coords.into();
        }
        last = coords;
    }
}

#[cfg(test)]
mod tests;
