//! Where bodies stick together, as their trackers show it: the mean pose of one in the axes of the other.

use nalgebra::{UnitQuaternion, Vector3};

use super::error::SegmentError;
use crate::math::{Pose, so3};
use crate::motion::{LinkIndex, Sample, Scene, Segment, Sketch, StuckPair};

/// Sweeps of the mean of rotations.
const SWEEPS: usize = 20;

/// The scene in which bodies that stick together do so where samples show it, until an estimate tells it better.
///
/// Fails where both are not seen at one time after they began to.
pub fn stuck(scene: &Scene, sketch: &Sketch, segments: &[Segment]) -> Result<Scene, SegmentError> {
    let mut stuck = scene.clone();
    for pair in scene.stuck_pairs() {
        let [first, second] = pair
            .links
            .map(|link| seen(scene, sketch, segments, &pair, link));
        let between = second.iter().filter_map(|of| {
            let (at_s, pose) = (of.acted_s, pose(of)?);
            Some(interpolated(first, at_s)?.inverse() * pose)
        });
        let poses: Vec<Pose> = between.collect();
        let Some(pose) = mean(&poses) else {
            let name = |side: usize| scene.links[pair.links[side]].name.clone();
            return Err(SegmentError::NotSeenStuck {
                event: scene.events[pair.event].name.clone(),
                bodies: [name(0), name(1)],
            });
        };
        stuck.stick(&pair, &pose);
    }
    Ok(stuck)
}

/// The samples of a body after it began to stick to another, those beside that left out.
fn seen<'s>(
    scene: &Scene,
    sketch: &'s Sketch,
    segments: &[Segment],
    pair: &StuckPair,
    link: LinkIndex,
) -> &'s [Sample] {
    let mechanism = scene.mechanism_of(link);
    let mut after = segments.iter();
    let after = after.find(|of| (of.mechanism, of.start_event) == (mechanism, Some(pair.event)));
    let views = after.into_iter().flat_map(|of| &of.views);
    let views = views.map(|view| sketch.samples_of(view));
    let shown = |samples: &&[Sample]| samples.iter().filter_map(pose).count();
    views.max_by_key(shown).unwrap_or_default()
}

fn pose(sample: &Sample) -> Option<Pose> {
    let seen = sample.seen.position_m().zip(sample.seen.orientation());
    seen.map(|(place_m, turn)| Pose::from_parts(place_m.into(), turn))
}

/// The pose at a time between two samples.
fn interpolated(samples: &[Sample], acted_s: f64) -> Option<Pose> {
    let next = samples.partition_point(|of| of.acted_s < acted_s);
    let to = samples.get(next)?;
    let from = samples.get(next.saturating_sub(1))?;
    let after_s = acted_s - from.acted_s;
    if after_s < 0.0 {
        return None;
    }
    let share = match to.acted_s - from.acted_s {
        span_s if span_s > 0.0 => after_s / span_s,
        _ => 0.0,
    };
    let [from, to] = [pose(from)?, pose(to)?];
    let turn = so3::log(&(from.rotation.inverse() * to.rotation)) * share;
    let place_m = from.translation.vector.lerp(&to.translation.vector, share);
    Some(Pose::from_parts(
        place_m.into(),
        from.rotation * so3::exp(&turn),
    ))
}

/// The mean of all.
fn mean(poses: &[Pose]) -> Option<Pose> {
    let first = poses.first()?;
    let count = poses.len() as f64;
    let places = poses.iter().map(|of| of.translation.vector);
    let place_m = places.sum::<Vector3<f64>>() / count;
    let mut turn: UnitQuaternion<f64> = first.rotation;
    for _ in 0..SWEEPS {
        let off = poses
            .iter()
            .map(|of| so3::log(&(turn.inverse() * of.rotation)));
        turn *= so3::exp(&(off.sum::<Vector3<f64>>() / count));
    }
    Some(Pose::from_parts(place_m.into(), turn))
}
