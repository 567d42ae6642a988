//! What the samples of a segment show, as the fits of a flight take it: places of the centre of mass and
//! orientations, at acted times.

use nalgebra::{UnitQuaternion, Vector3};

use super::ballistic::Place;
use crate::math::so3;
use crate::motion::{Sample, Scene, Seen, Sees, Segment, Sketch};
use crate::physics::Body;
use crate::physics::body::Symmetry;
use crate::physics::support::StuckPart;

/// An orientation at an acted time \[s, world from body\].
pub type Turn = (f64, UnitQuaternion<f64>);

/// An axis in the body, and where it points at acted times.
type Axis = (Vector3<f64>, Vec<Place>);

/// The readings of one segment.
#[derive(Clone, Debug, Default)]
pub struct Readings {
    /// Places of the centre of mass; of a point that is seen alone, its own.
    pub places: Vec<Place>,
    /// Orientations. Those of a direction follow each other without rotation about it.
    pub turns: Vec<Turn>,
    /// Where only a point is seen, and no orientation: where it is in body axes \[m\].
    pub lever_m: Option<Vector3<f64>>,
    /// Where one axis alone is seen of how it is turned, about which the body is not symmetric: the axis in
    /// the body and where it points, unit vectors.
    pub pointed: Option<(Vector3<f64>, Vec<Place>)>,
}

impl Readings {
    /// The readings of a segment, of all its tracks, each in order of time.
    pub fn of(scene: &Scene, sketch: &Sketch, segment: &Segment) -> Self {
        let mut readings = Self::default();
        let mut points: Vec<(Vector3<f64>, Vec<Place>)> = Vec::new();
        let mut directions: Vec<Axis> = Vec::new();
        for view in &segment.views {
            let track = &scene.tracks[view.track];
            let (mut seen_at, mut pointed) = (Vec::new(), Vec::new());
            readings.places.reserve(view.samples.len());
            readings.turns.reserve(view.samples.len());
            for Sample { acted_s, seen, .. } in sketch.samples_of(view) {
                match seen {
                    Seen::Pose {
                        position_m,
                        orientation,
                    } => {
                        readings.places.push((*acted_s, *position_m));
                        readings.turns.push((*acted_s, *orientation));
                    }
                    Seen::Point(position_m) => seen_at.push((*acted_s, *position_m)),
                    Seen::Orientation(orientation) => readings.turns.push((*acted_s, *orientation)),
                    Seen::Direction(direction) => pointed.push((*acted_s, direction.into_inner())),
                }
            }
            points.extend((!seen_at.is_empty()).then(|| (track.point_m(), seen_at)));
            if let Sees::Direction(axis) = track.sees {
                directions.extend((!pointed.is_empty()).then(|| (axis.into_inner(), pointed)));
            }
        }
        if readings.turns.is_empty() {
            let axes = axes(&points, directions);
            readings.turns = turns(&axes);
            let body = scene.body_of(segment.mechanism);
            readings.pointed = alone(&axes).filter(|(axis, _)| !is_symmetry_axis(body, axis));
        }
        readings.add_points(&points);
        readings.places.sort_by(|a, b| a.0.total_cmp(&b.0));
        readings.turns.sort_by(|a, b| a.0.total_cmp(&b.0));
        readings
    }

    /// The readings of the whole of which the body is a part, as far as orientations are known: of its centre of mass and of its principal axes.
    pub(super) fn of_whole(&self, part: &StuckPart) -> Self {
        let places = self.places.iter().map(|(acted_s, place_m)| {
            let known = !self.turns.is_empty();
            let lever_m = known.then(|| nearest(&self.turns, *acted_s) * part.centre_m);
            (*acted_s, place_m + lever_m.unwrap_or_default())
        });
        let turns = self.turns.iter();
        let turns = turns.map(|(acted_s, turn)| (*acted_s, turn * part.axes));
        Self {
            places: places.collect(),
            turns: turns.collect(),
            ..self.clone()
        }
    }

    /// The axis that alone is seen, in the body.
    pub(super) fn axis(&self) -> Option<Vector3<f64>> {
        self.pointed.as_ref().map(|(axis, _)| *axis)
    }

    /// Adds the centres of mass below points that are seen, where orientations are known; of points
    /// alone, those of the point nearest to the centre.
    fn add_points(&mut self, points: &[(Vector3<f64>, Vec<Place>)]) {
        if !self.turns.is_empty() {
            for (point_m, places) in points {
                let centres = places.iter().map(|(acted_s, position_m)| {
                    (
                        *acted_s,
                        position_m - nearest(&self.turns, *acted_s) * point_m,
                    )
                });
                self.places.extend(centres);
            }
            return;
        }
        let nearest = points
            .iter()
            .min_by(|a, b| a.0.norm().total_cmp(&b.0.norm()));
        if let Some((point_m, places)) = nearest.filter(|_| self.places.is_empty()) {
            self.places.extend(places);
            self.lever_m = (point_m.norm() > 0.0).then_some(*point_m);
        }
    }
}

/// Axes in the body, each with where it points at acted times: given directions, and lines from one point
/// to the others.
fn axes(points: &[(Vector3<f64>, Vec<Place>)], directions: Vec<Axis>) -> Vec<Axis> {
    let mut axes = directions;
    if let Some(((first_m, from), others)) = points.split_first() {
        for (other_m, to) in others {
            let lines = from
                .iter()
                .filter_map(|(acted_s, from_m)| Some((*acted_s, between(to, *acted_s)? - from_m)));
            let lines: Vec<Place> = lines.collect();
            if (other_m - first_m).norm() > 0.0 && !lines.is_empty() {
                axes.push((other_m - first_m, lines));
            }
        }
    }
    axes
}

/// The first axis, if no other tells how the body is turned about it.
fn alone(axes: &[Axis]) -> Option<Axis> {
    let ((axis, shown), others) = axes.split_first()?;
    let units = shown
        .iter()
        .filter_map(|(acted_s, way)| Some((*acted_s, way.try_normalize(0.0)?)));
    others
        .iter()
        .all(|(other, _)| !is_across(other, axis))
        .then(|| (axis.normalize(), units.collect()))
}

/// Whether a body is the same however it is turned about an axis: the least rotation about it is as good as
/// any.
fn is_symmetry_axis(body: &Body, axis: &Vector3<f64>) -> bool {
    match body.symmetry() {
        Symmetry::Axial { axis: own } => !is_across(&Vector3::ith(own, 1.0), axis),
        _ => false,
    }
}

fn is_across(other: &Vector3<f64>, axis: &Vector3<f64>) -> bool {
    other.cross(axis).norm() > 1e-6 * other.norm() * axis.norm()
}

/// Orientations that turn axes of the body to where they are seen. One axis alone is followed without
/// rotation about it.
fn turns(axes: &[Axis]) -> Vec<Turn> {
    let Some(((axis, shown), others)) = axes.split_first() else {
        return Vec::new();
    };
    let mut last: Option<UnitQuaternion<f64>> = None;
    let turned = shown.iter().map(|(acted_s, direction)| {
        let before = last.unwrap_or_default();
        let mut turn = so3::between(&(before * axis), direction) * before;
        // The second axis says how the body is turned about the first.
        let second = others.iter().find(|(other, _)| is_across(other, axis));
        if let Some((other, shown)) = second
            && let Some(there) = between(shown, *acted_s)
        {
            let about = direction.normalize();
            let across = |v: Vector3<f64>| v - about * about.dot(&v);
            let (from, to) = (across(turn * other), across(there));
            let angle = about.dot(&from.cross(&to)).atan2(from.dot(&to));
            turn = UnitQuaternion::from_scaled_axis(about * angle) * turn;
        }
        last = Some(turn);
        (*acted_s, turn)
    });
    turned.collect()
}

/// A place at an acted time, linear between neighbours; `None` outside of all.
fn between(places: &[Place], acted_s: f64) -> Option<Vector3<f64>> {
    let after = places.partition_point(|place| place.0 < acted_s);
    let to = places.get(after)?;
    let from = places.get(after.checked_sub(1).unwrap_or(after))?;
    if to.0 <= from.0 {
        return (to.0 == acted_s).then_some(to.1);
    }
    let share = (acted_s - from.0) / (to.0 - from.0);
    Some(from.1 + (to.1 - from.1) * share)
}

/// The orientation nearest in time, or between the two about it.
fn nearest(turns: &[Turn], acted_s: f64) -> UnitQuaternion<f64> {
    let after = turns.partition_point(|turn| turn.0 < acted_s);
    match (
        after.checked_sub(1).and_then(|before| turns.get(before)),
        turns.get(after),
    ) {
        (Some(from), Some(to)) if to.0 > from.0 => {
            let share = (acted_s - from.0) / (to.0 - from.0);
            from.1.try_slerp(&to.1, share, 1e-9).unwrap_or(to.1)
        }
        (_, Some(only)) | (Some(only), None) => only.1,
        (None, None) => UnitQuaternion::identity(),
    }
}
