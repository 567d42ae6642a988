//! What was seen of trees: quantities of its links at times.

use std::borrow::Cow;

use nalgebra::{Matrix3, Matrix3xX, Matrix6, UnitQuaternion, Vector3};

use crate::estimate::constraint::quantity::Valued;
use crate::estimate::wander::SampleInstant;
use crate::motion::{
    BodyPoint, GoalQuantity, GoalUnit, Sample, Scene, Seen, Sees, Sketch, Stamp, Track, TrackIndex,
    Weights,
};
use crate::physics::contact::Feature;

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
    /// What makes its residual one of unit variance, where each sample errs by itself and its message says by how much.
    pub whitening: Option<Matrix3<f64>>,
    /// Variance along an axis that its message says, in units.
    pub noise_variance: f64,
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
            noise_variance: self.noise_variance,
        }
    }

    /// Standard deviation of errors with which it weighs as it does, in the quantity's own unit.
    pub(super) fn sd(&self) -> f64 {
        match self.whitening {
            Some(_) => self.unit * self.noise_variance.sqrt(),
            None => self.unit,
        }
    }

    /// Makes its errors so many times as great.
    pub(super) fn widened(&mut self, times: f64) {
        match &mut self.whitening {
            Some(whitening) => *whitening /= times,
            None => self.unit *= times,
        }
    }

    /// The same with the errors of its message, which has this covariance of it in the quantity's own unit.
    fn with_errors(self, covariance: &Matrix3<f64>) -> Self {
        let factor = covariance
            .cholesky()
            .expect("cleaning keeps sound covariances");
        Self {
            whitening: Some(factor.l().try_inverse().expect("its diagonal is positive")),
            noise_variance: covariance.trace() / 3.0 / self.unit.powi(2),
            ..self
        }
    }
}

/// A sample with its residual, in units, and the derivative by the unknowns of its interval.
#[derive(Clone)]
pub(super) struct Residual<'s> {
    pub(super) sample: &'s TreeSample,
    pub(super) value: Vector3<f64>,
    pub(super) by: Matrix3xX<f64>,
}

impl<'s> Residual<'s> {
    pub(super) fn new(sample: &'s TreeSample, valued: &Valued, by: &Matrix3xX<f64>) -> Self {
        let off = valued.value - sample.seen;
        let (value, by) = match &sample.whitening {
            Some(whitening) => (whitening * off, whitening * by),
            None => {
                let per_unit = 1.0 / sample.unit;
                (off * per_unit, by * per_unit)
            }
        };
        Self { sample, value, by }
    }

    /// The same in units, whatever its message says of its errors.
    pub(super) fn in_units(&self) -> Cow<'_, Self> {
        let Some(whitening) = &self.sample.whitening else {
            return Cow::Borrowed(self);
        };
        let inverse = whitening.try_inverse().expect("it is that of a covariance");
        let scale = inverse / self.sample.unit;
        Cow::Owned(Self {
            sample: self.sample,
            value: scale * self.value,
            by: scale * &self.by,
        })
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
        let within = |sample: &Sample| (span_s[0]..=span_s[1]).contains(&sample.acted_s);
        let shown = &sketch.tracks[index];
        for (at, sample) in shown.samples.iter().enumerate() {
            if !within(sample) {
                continue;
            }
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
                whitening: None,
                noise_variance: 0.0,
                is_counted: true,
            };
            let covariance = shown.covariances.get(at);
            samples.extend(parts(&begun, &sample.seen, track, weights, covariance));
        }
    }
    samples.sort_by(|a, b| a.acted_s.total_cmp(&b.acted_s));
    samples
}

/// A sample's parts: its place and how it is turned. A message's covariance is of the tracker's place, and of a rotation in
/// world axes; what it says of both together is left out.
fn parts(
    begun: &TreeSample,
    seen: &Seen,
    track: &Track,
    weights: &Weights,
    covariance: Option<&Matrix6<f64>>,
) -> Vec<TreeSample> {
    let placed = |at_m: Vector3<f64>, point_m: Vector3<f64>| {
        let placed = TreeSample {
            point_m,
            seen: at_m,
            ..begun.clone()
        };
        match covariance {
            Some(of) => placed.with_errors(&of.fixed_view::<3, 3>(0, 0).into_owned()),
            None => placed,
        }
    };
    let turned = |quantity: GoalQuantity, by_rotation: Matrix3<f64>| {
        let turned = TreeSample {
            quantity,
            unit: weights.orientation_rad,
            ..begun.clone()
        };
        match covariance {
            Some(of) => {
                let of = of.fixed_view::<3, 3>(3, 3);
                turned.with_errors(&(by_rotation * of * by_rotation.transpose()))
            }
            None => turned,
        }
    };
    let turn = |from: UnitQuaternion<f64>| {
        let quantity = GoalQuantity::Turn {
            from,
            seen_from: None,
        };
        turned(quantity, from.inverse().to_rotation_matrix().into_inner())
    };
    match (*seen, track.sees) {
        (
            Seen::Pose {
                position_m,
                orientation,
            },
            _,
        ) => {
            let point_m = match covariance {
                Some(_) => track.point_m(),
                None => Vector3::zeros(),
            };
            let at_m = position_m + orientation * point_m;
            vec![placed(at_m, point_m), turn(orientation)]
        }
        (Seen::Point(at_m), _) => vec![placed(at_m, track.point_m())],
        (Seen::Orientation(orientation), _) => vec![turn(orientation)],
        (Seen::Direction(towards), Sees::Direction(axis)) => {
            let quantity = GoalQuantity::Direction {
                axis: axis.into_inner(),
                towards: towards.into_inner(),
                seen_from: None,
            };
            // By a rotation `ω` a direction moves along a tangent `t` by `ω·(d × t)`.
            let [first, second] = Feature::tangents(&towards);
            let axes = [second, -first, towards.into_inner()].map(|axis| axis.transpose());
            vec![turned(quantity, Matrix3::from_rows(&axes))]
        }
        (Seen::Direction(_), _) => unreachable!("directions are of tracks that see one"),
    }
}
