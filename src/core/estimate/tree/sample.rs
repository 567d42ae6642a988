//! What was seen of trees: quantities of its links at times.

use nalgebra::{Matrix3xX, Vector3};

use crate::estimate::constraint::quantity::Valued;
use crate::estimate::wander::SampleInstant;
use crate::motion::{
    BodyPoint, GoalQuantity, GoalUnit, Sample, Scene, Seen, Sees, Sketch, Stamp, TrackIndex,
};

/// A part of a sample: a quantity of one link at a time, and where it was seen.
#[derive(Clone, Debug)]
pub struct TreeSample {
    /// Of which track.
    pub track: TrackIndex,
    /// When it was measured.
    pub stamp: Stamp,
    /// The same \[s\].
    pub acted_s: f64,
    /// The link's place in the forest.
    pub place: usize,
    /// What was seen.
    pub quantity: GoalQuantity,
    /// Point of the link that it is about [m, link axes].
    pub point_m: Vector3<f64>,
    /// Its value.
    pub seen: Vector3<f64>,
    /// One unit of its residual, in the quantity's own.
    pub unit: f64,
    /// Whether it weighs: of samples that err in time some do not.
    pub is_counted: bool,
}

impl TreeSample {
    /// 0 where a place was seen, 1 where it is how the link is turned.
    pub(super) fn kind(&self) -> usize {
        usize::from(self.quantity.unit() != GoalUnit::Metre)
    }

    /// When it was taken.
    pub(super) fn instant(&self) -> SampleInstant {
        SampleInstant {
            time_s: self.acted_s,
            noise_variance: 0.0,
        }
    }
}

/// A sample with its residual, in units, and the derivative by the unknowns of its interval.
pub(super) struct Residual<'s> {
    pub(super) sample: &'s TreeSample,
    pub(super) value: Vector3<f64>,
    pub(super) by: Matrix3xX<f64>,
}

impl<'s> Residual<'s> {
    pub(super) fn new(sample: &'s TreeSample, valued: &Valued, by: &Matrix3xX<f64>) -> Self {
        let per_unit = 1.0 / sample.unit;
        Self {
            sample,
            value: (valued.value - sample.seen) * per_unit,
            by: by * per_unit,
        }
    }
}

/// The samples of all links that move here within a span \[s\], in order of time.
pub(super) fn samples(scene: &Scene, sketch: &Sketch, span_s: [f64; 2]) -> Vec<TreeSample> {
    let mut samples = Vec::new();
    for (index, track) in scene.tracks.iter_enumerated() {
        if !scene.sees_moving(index) {
            continue;
        }
        let place = scene.place_of(track.link);
        let weights = track.weights(&scene.weights);
        let within = |sample: &&Sample| (span_s[0]..=span_s[1]).contains(&sample.acted_s);
        for sample in sketch.tracks[index].samples.iter().filter(within) {
            let begun = TreeSample {
                track: index,
                stamp: sample.stamp,
                acted_s: sample.acted_s,
                place,
                quantity: GoalQuantity::Position {
                    point: BodyPoint::Centre,
                    seen_from: None,
                },
                point_m: Vector3::zeros(),
                seen: Vector3::zeros(),
                unit: weights.position_m,
                is_counted: true,
            };
            samples.extend(parts(
                &begun,
                &sample.seen,
                track.sees,
                track.point_m(),
                weights.orientation_rad,
            ));
        }
    }
    samples.sort_by(|a, b| a.acted_s.total_cmp(&b.acted_s));
    samples
}

/// A sample's parts: its place and how it is turned.
fn parts(
    begun: &TreeSample,
    seen: &Seen,
    sees: Sees,
    point_m: Vector3<f64>,
    orientation_rad: f64,
) -> Vec<TreeSample> {
    let placed = |at_m: Vector3<f64>, point_m: Vector3<f64>| TreeSample {
        point_m,
        seen: at_m,
        ..begun.clone()
    };
    let turned = |quantity: GoalQuantity| TreeSample {
        quantity,
        unit: orientation_rad,
        ..begun.clone()
    };
    let turn = |from| {
        turned(GoalQuantity::Turn {
            from,
            seen_from: None,
        })
    };
    match (*seen, sees) {
        (
            Seen::Pose {
                position_m,
                orientation,
            },
            _,
        ) => vec![placed(position_m, Vector3::zeros()), turn(orientation)],
        (Seen::Point(at_m), _) => vec![placed(at_m, point_m)],
        (Seen::Orientation(orientation), _) => vec![turn(orientation)],
        (Seen::Direction(towards), Sees::Direction(axis)) => {
            vec![turned(GoalQuantity::Direction {
                axis: axis.into_inner(),
                towards: towards.into_inner(),
                seen_from: None,
            })]
        }
        (Seen::Direction(_), _) => unreachable!("directions are of tracks that see one"),
    }
}
