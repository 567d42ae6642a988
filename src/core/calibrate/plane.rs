//! The plane that is touched.

use nalgebra::{Matrix3, Vector3};
use statrs::distribution::{ContinuousCDF, StudentsT};

use super::error::CalibrateError;
use super::spread::{Measured, quantile};
use super::stream::{Reading, Stream};

/// Least width of the touches beside their length.
const LEAST_WIDTH: f64 = 0.05;

/// Least width of the touches \[m\]: nearer ones are one touch.
const LEAST_WIDTH_M: f64 = 5e-3;

/// Greatest uncertainty of the normal's direction \[rad\]: beyond that, the touches are a line.
const GREATEST_TILT_RAD: f64 = 0.17;

/// With fewer touches none is called an outlier.
const LEAST_FOR_OUTLIERS: usize = 6;

/// How often one of touches that are all right is called an outlier at most.
const BY_CHANCE: f64 = 1e-3;

/// A moment at which the body touched.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Touch {
    /// When \[s\].
    pub time_s: f64,
    /// Where the point of the body was that touched \[m, world\].
    pub point_m: Vector3<f64>,
    /// Where the tracker was \[m, world\].
    pub tracker_m: Vector3<f64>,
    /// The same point from the tracker, per unit of the point's coordinates in the tracker's axes.
    pub turn: Matrix3<f64>,
}

/// The plane.
#[derive(Clone, Debug, PartialEq)]
pub struct PlaneFit {
    /// Unit normal, towards the side on which the tracker was.
    pub normal: Vector3<f64>,
    /// Two unit axes in the plane, along which the touches extend most and least.
    pub axes: [Vector3<f64>; 2],
    /// By how much the normal may lean along these axes \[rad\].
    pub tilt_rad: Measured,
    /// The middle of the touches, projected to the plane \[m, world\].
    pub point_m: Vector3<f64>,
    /// Distance of the plane from the world's origin at that point, along the normal \[m\].
    pub height_m: Measured,
    /// Root mean square distance of touches from the plane, each degree of freedom counted once \[m\];
    /// `None` of three, which always lie in one.
    pub residual_m: Option<f64>,
    /// Distance of each touch \[m\], positive along the normal.
    pub distances_m: Vec<f64>,
    /// Indices of touches that are too far off to count.
    pub outliers: Vec<usize>,
}

/// The median pose within `window_s` of a time, and with it where a point of the tracker's axes
/// was.
pub fn touch(
    stream: &Stream,
    time_s: f64,
    point_m: &Vector3<f64>,
    window_s: f64,
) -> Result<Touch, CalibrateError> {
    let is_near = |of: &&Reading| (of.time_s - time_s).abs() <= window_s;
    let near: Vec<&Reading> = stream.readings.iter().filter(is_near).collect();
    let Some(middle) = near.get(near.len() / 2) else {
        return Err(CalibrateError::TouchOutside {
            time_s,
            window_ms: window_s * 1e3,
        });
    };
    let median = |of: &dyn Fn(&Reading) -> Vector3<f64>| {
        Vector3::from_fn(|axis, _| {
            let mut numbers: Vec<f64> = near.iter().map(|reading| of(reading)[axis]).collect();
            numbers.sort_by(f64::total_cmp);
            let half = numbers.len() / 2;
            if numbers.len() % 2 == 1 {
                numbers[half]
            } else {
                0.5 * (numbers[half - 1] + numbers[half])
            }
        })
    };
    Ok(Touch {
        time_s,
        point_m: median(&|reading| {
            (reading.world_from_tracker * nalgebra::Point3::from(*point_m)).coords
        }),
        tracker_m: median(&|reading| reading.world_from_tracker.translation.vector),
        turn: crate::math::so3::matrix(&middle.world_from_tracker.rotation),
    })
}

/// The plane nearest to the touches by orthogonal distances. `point_sd_m` is how well the point that
/// touches is known in the tracker's axes; it is common to all touches. `up` decides the side of the normal where
/// the tracker's place does not.
///
/// Each touch counts once, whatever noise is within it, and the interval is that of their distances from the plane: three touches
/// have none. Of six and more, one that is far off the plane of the others is left out.
///
/// Fails where there are fewer than three or they lie in a line.
pub fn plane(
    touches: &[Touch],
    point_sd_m: &Vector3<f64>,
    up: &Vector3<f64>,
) -> Result<PlaneFit, CalibrateError> {
    let mut used: Vec<usize> = (0..touches.len()).collect();
    let mut outliers = Vec::new();
    while used.len() >= LEAST_FOR_OUTLIERS {
        let Some(at) = outlier(touches, &used) else {
            break;
        };
        outliers.push(used.remove(at));
    }
    outliers.sort_unstable();
    let counted: Vec<Touch> = used.iter().map(|at| touches[*at]).collect();
    let fitted = FittedPlane::of(&counted)?;
    let count = counted.len() as f64;
    let side_m: f64 = counted
        .iter()
        .map(|touch| (touch.tracker_m - touch.point_m).dot(&fitted.normal) / count)
        .sum();
    let side = if side_m.abs() > 1e-3 {
        side_m
    } else {
        fitted.normal.dot(up)
    };
    let normal = fitted.normal * if side < 0.0 { -1.0 } else { 1.0 };
    let freedom = count - 3.0;
    let sd_m = fitted.sd_m();
    // The plane in its own axes is d = a + b u + c v, with u and v from the middle along the principal axes.
    let tilt_sd = fitted
        .extents_m
        .map(|extent| sd_m.unwrap_or(f64::INFINITY) / extent);
    let mean_turn = counted.iter().map(|touch| touch.turn).sum::<Matrix3<f64>>() / count;
    let lever = mean_turn.tr_mul(&normal);
    let common_m = lever.component_mul(point_sd_m).norm();
    let own_m = sd_m.unwrap_or(f64::INFINITY) / count.sqrt();
    let mut height_m = Measured::new(vec![fitted.middle_m.dot(&normal)], vec![own_m], freedom);
    // The two are independent, with degrees of freedom of their own.
    let half_m = height_m.half[0].hypot(quantile(1e6) * common_m);
    (height_m.sd[0], height_m.half[0]) = (own_m.hypot(common_m), half_m);
    Ok(PlaneFit {
        normal,
        axes: fitted.axes,
        tilt_rad: Measured::new(vec![0.0; 2], tilt_sd.to_vec(), freedom),
        point_m: fitted.middle_m,
        height_m,
        residual_m: sd_m,
        distances_m: touches
            .iter()
            .map(|touch| (touch.point_m - fitted.middle_m).dot(&normal))
            .collect(),
        outliers,
    })
}

struct FittedPlane {
    middle_m: Vector3<f64>,
    normal: Vector3<f64>,
    axes: [Vector3<f64>; 2],
    /// Root sums of squares along these axes, the longer first \[m\].
    extents_m: [f64; 2],
    square_m2: f64,
    count: usize,
}

impl FittedPlane {
    fn of(touches: &[Touch]) -> Result<Self, CalibrateError> {
        if touches.len() < 3 {
            return Err(CalibrateError::FewTouches(touches.len()));
        }
        let points = touches.iter().map(|touch| touch.point_m);
        let middle_m = points.clone().sum::<Vector3<f64>>() / touches.len() as f64;
        let scatter: Matrix3<f64> = points
            .map(|point| (point - middle_m) * (point - middle_m).transpose())
            .sum();
        let eigen = scatter.symmetric_eigen();
        let mut order = [0, 1, 2];
        order.sort_by(|a, b| eigen.eigenvalues[*b].total_cmp(&eigen.eigenvalues[*a]));
        let value = |at: usize| eigen.eigenvalues[order[at]].max(0.0);
        let fitted = Self {
            middle_m,
            normal: eigen.eigenvectors.column(order[2]).into_owned(),
            axes: [0, 1].map(|at| eigen.eigenvectors.column(order[at]).into_owned()),
            extents_m: [value(0).sqrt(), value(1).sqrt()],
            square_m2: value(2),
            count: touches.len(),
        };
        let [long_m, wide_m] = fitted.extents_m;
        let tilt_rad = fitted.sd_m().unwrap_or(0.0) / wide_m;
        if !(wide_m > LEAST_WIDTH * long_m
            && wide_m > LEAST_WIDTH_M
            && tilt_rad < GREATEST_TILT_RAD)
        {
            let extent_mm = |axis: usize| {
                let along = touches
                    .iter()
                    .map(|touch| (touch.point_m - middle_m).dot(&fitted.axes[axis]) * 1e3);
                let (least, most) = along.fold((0.0_f64, 0.0_f64), |(least, most), x| {
                    (least.min(x), most.max(x))
                });
                most - least
            };
            return Err(CalibrateError::Collinear {
                long_mm: extent_mm(0),
                wide_mm: extent_mm(1),
            });
        }
        Ok(fitted)
    }

    fn sd_m(&self) -> Option<f64> {
        let freedom = self.count.checked_sub(3).filter(|freedom| *freedom > 0)?;
        Some((self.square_m2 / freedom as f64).sqrt())
    }

    /// How likely another touch is as far off the plane by chance: its distance in deviations of such a distance, which the
    /// plane's own errors make greater, is Student's. `None` where nothing is known of them.
    fn chance(&self, touch: &Touch) -> Option<f64> {
        let sd_m = self.sd_m().filter(|sd_m| *sd_m > 0.0)?;
        let off_m = touch.point_m - self.middle_m;
        let along = self.axes.iter().zip(&self.extents_m);
        let along = along.map(|(axis, extent_m)| (off_m.dot(axis) / extent_m).powi(2));
        let leverage = 1.0 + (self.count as f64).recip() + along.sum::<f64>();
        let law = StudentsT::new(0.0, 1.0, self.count as f64 - 3.0).ok()?;
        Some(2.0 * law.sf(off_m.dot(&self.normal).abs() / (sd_m * leverage.sqrt())))
    }
}

/// The touch that is least likely to be off the plane of the others by chance, if that is too unlikely for one of so many.
fn outlier(touches: &[Touch], used: &[usize]) -> Option<usize> {
    let chance = |at: usize| {
        let others = used.iter().enumerate().filter(|(other, _)| *other != at);
        let others: Vec<Touch> = others.map(|(_, index)| touches[*index]).collect();
        // Without it the others may lie in a line: then it is needed.
        FittedPlane::of(&others).ok()?.chance(&touches[used[at]])
    };
    let each = (0..used.len()).filter_map(|at| Some((at, chance(at)?)));
    let least = each.min_by(|a, b| a.1.total_cmp(&b.1));
    let is_unlikely = |(_, chance): &(usize, f64)| chance * (used.len() as f64) < BY_CHANCE;
    least.filter(is_unlikely).map(|(at, _)| at)
}
