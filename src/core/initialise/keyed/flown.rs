//! Keyframes of a flight, and the flight on its own clock.

use nalgebra::{UnitQuaternion, Vector3};

use crate::initialise::ballistic::Place;
use crate::initialise::turn::OrientationReading;
use crate::motion::{MechanismIndex, Scene, Seen, Segment, Sketch};
use crate::physics::{State, flow};

/// A flight on its own clock: state at an epoch.
#[derive(Clone, Copy, Debug)]
pub(super) struct KeyedFlight {
    pub(super) state: State,
    pub(super) epoch_s: f64,
}

impl KeyedFlight {
    /// The state at a time on its clock.
    pub(super) fn at(&self, scene: &Scene, mechanism: MechanismIndex, time_s: f64) -> State {
        let body = scene.body_of(mechanism);
        flow::advance(
            body,
            &scene.gravity_m_s2,
            &self.state,
            time_s - self.epoch_s,
        )
    }
}

/// A keyframe.
#[derive(Clone, Copy, Debug)]
pub(super) struct KeyPose {
    pub(super) acted_s: f64,
    /// Centre of mass [m, world].
    pub(super) position_m: Vector3<f64>,
    pub(super) orientation: UnitQuaternion<f64>,
}

/// The keyframes of a flight that are whole poses at known times, where there are two; otherwise all
/// whole poses, at the times that their places among others suggest. `None` where several tracks see
/// the flight.
pub(super) fn keys(sketch: &Sketch, segment: &Segment) -> Option<Vec<KeyPose>> {
    let [view] = segment.views.as_slice() else {
        return None;
    };
    let samples = sketch.samples_of(view).iter().zip(view.samples.clone());
    let whole = samples.filter_map(|(sample, index)| match sample.seen {
        Seen::Pose {
            position_m,
            orientation,
        } => Some((
            KeyPose {
                acted_s: sample.acted_s,
                position_m,
                orientation,
            },
            sketch.tracks[view.track].open_times_s.contains_key(&index),
        )),
        _ => None,
    });
    let whole: Vec<(KeyPose, bool)> = whole.collect();
    let is_told = whole.iter().filter(|(_, is_open)| !is_open).count() > 1;
    let keys = whole
        .into_iter()
        .filter(|(_, is_open)| !(is_told && *is_open));
    Some(keys.map(|(key, _)| key).collect())
}

/// Places and orientations at known times that a flight's other samples show alone.
#[derive(Clone, Debug, Default)]
pub(super) struct Parts {
    /// Centres of mass.
    pub(super) places: Vec<Place>,
    /// Orientations.
    pub(super) turns: Vec<OrientationReading>,
}

/// What is seen of a flight in parts. A point off the centre of mass is left to the estimation.
pub(super) fn parts(scene: &Scene, sketch: &Sketch, segment: &Segment) -> Parts {
    let mut parts = Parts::default();
    for view in &segment.views {
        let is_centre = scene.tracks[view.track].point_m() == Vector3::zeros();
        let open = &sketch.tracks[view.track].open_times_s;
        let samples = sketch.samples_of(view).iter().zip(view.samples.clone());
        for (sample, _) in samples.filter(|(_, index)| !open.contains_key(index)) {
            match sample.seen {
                Seen::Point(place_m) if is_centre => parts.places.push((sample.acted_s, place_m)),
                Seen::Orientation(turn) => parts.turns.push((sample.acted_s, turn)),
                _ => {}
            }
        }
    }
    parts
}
