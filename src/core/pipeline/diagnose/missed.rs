//! Collisions that were acted though the scene knows none: samples show one kink more than there are marks.

use super::facts::Facts;
use super::world::over_planes;
use crate::math::Pose;
use crate::motion::{
    Collision, ContactLawIndex, EventKind, LinkIndex, Mark, Partner, Remedy, Sample, Scene, Sketch,
    Stamp, TakeEvent, Touching, TrackIndex,
};
use crate::segment;
use crate::segment::propose::CLEAR_SCORE;

/// Farthest that a body is from the surface that it seems to hit, in the scene's weights: a hand strays by two.
const NEAR: f64 = 4.0;

/// One more collision of what a track sees with a surface, where its samples show a kink that is none of the marks'.
pub(super) fn remedies(facts: &Facts) -> Vec<Remedy> {
    let marks = facts.events.iter().filter_map(TakeEvent::mark);
    let mut marks: Vec<&Mark> = marks.collect();
    marks.sort_by_key(|mark| mark.stamp);
    let scene = facts.scene.with_marks(marks.len());
    let Ok(sketch) = segment::clean::unmarked(&scene, facts.events) else {
        return Vec::new();
    };
    if marks.len() != scene.events.len() {
        return Vec::new();
    }
    let tracks = scene.tracks.keys();
    let tracks = tracks.filter(|track| scene.sees_moving(*track) && facts.is_tracked(*track));
    let missed = tracks.filter_map(|track| {
        let stamp = kink(&scene, &sketch, &marks, track)?;
        hit(&scene, &sketch, &marks, track, stamp)
    });
    missed.collect()
}

/// The clearest kink of a track that is none of the marks', if its samples show one more than there are.
fn kink(scene: &Scene, sketch: &Sketch, marks: &[&Mark], track: TrackIndex) -> Option<Stamp> {
    let mechanism = scene.mechanism_seen_by(track);
    let events = scene.events.iter().zip(marks);
    let own = events.filter_map(|(event, mark)| {
        let collision = event.kind.collision()?;
        (scene.takes_part(mechanism, collision)).then_some(mark.stamp)
    });
    let mut own: Vec<Stamp> = own.collect();
    let proposals = segment::propose(scene, sketch, Some(own.len() + 1)).into_iter();
    let mut proposals: Vec<_> = proposals.filter(|of| of.track == track).collect();
    // Each mark takes the kink that is nearest to it, the nearest pair first.
    while !own.is_empty() {
        let pairs = own.iter().enumerate().flat_map(|(mark, stamp)| {
            let apart_ns = |at: Stamp| at.0.abs_diff(stamp.0);
            let kinks = proposals.iter().enumerate();
            kinks.map(move |(kink, of)| (apart_ns(of.stamp(sketch)), mark, kink))
        });
        let (_, mark, kink) = pairs.min()?;
        own.remove(mark);
        proposals.remove(kink);
    }
    let clear = proposals.into_iter().filter(|of| of.score >= CLEAR_SCORE);
    clear.map(|of| of.stamp(sketch)).next()
}

/// What a body hits there: the surface that is nearest to it.
fn hit(
    scene: &Scene,
    sketch: &Sketch,
    marks: &[&Mark],
    track: TrackIndex,
    stamp: Stamp,
) -> Option<Remedy> {
    let link = scene.tracks[track].link;
    let samples = sketch.tracks[track].samples.iter();
    let nearest = samples.min_by_key(|sample| sample.stamp.0.abs_diff(stamp.0))?;
    let any = collision(scene, link, None)?;
    let (surface, height_m) = over_planes(scene, &any, &seen(nearest)?)?;
    let index = marks.iter().filter(|mark| mark.stamp <= stamp).count();
    // Before a start and after an end nothing is estimated.
    let is_of = |at: usize, kind: EventKind| scene.events.get(at).is_some_and(|of| of.kind == kind);
    let is_beyond = is_of(index, EventKind::Start)
        || index
            .checked_sub(1)
            .is_some_and(|before| is_of(before, EventKind::End));
    let is_near = height_m.abs() <= NEAR * scene.weights.position_m;
    (is_near && !is_beyond).then_some(Remedy::MissedCollision {
        index,
        link,
        surface,
        stamp,
        acted_s: stamp.seconds_since(sketch.origin),
    })
}

/// The pose of what is seen, if its pose is.
fn seen(sample: &Sample) -> Option<Pose> {
    Some(Pose::from_parts(
        sample.seen.position_m()?.into(),
        sample.seen.orientation()?,
    ))
}

/// A collision of a body with a surface, or any, whose contact is open. Its law is that of the same body with the same
/// surface, or of the same body, or any.
pub(super) fn collision(
    scene: &Scene,
    link: LinkIndex,
    surface: Option<usize>,
) -> Option<Collision> {
    let known = || {
        let events = scene.events.iter();
        events.filter_map(|event| event.kind.collision())
    };
    let is_alike = |of: &&Collision| {
        of.link == link && of.contacts.iter().any(|touching| touching.other == surface)
    };
    let law: ContactLawIndex = (known().find(is_alike))
        .or_else(|| known().find(|of| of.link == link))
        .or_else(|| known().next())?
        .law;
    Some(Collision {
        link,
        partner: Partner::World,
        contacts: vec![Touching {
            feature: None,
            other: surface,
        }],
        law,
        tilt_rad: [0.0; 2],
    })
}
