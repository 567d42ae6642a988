//! A free rotation through the orientations of one segment (paper §6.2.1), by Levenberg–Marquardt:
//!
//! ```text
//! min over R, ω   Σ |Log(R_iᵀ R(s_i))|²,   R(s) the free rotation from R, ω
//! ```
//!
//! from several starts, since it has several minima where the performance rotates unevenly.

use nalgebra::{Matrix6, UnitQuaternion, Vector3, Vector6};

use crate::math::so3;
use crate::motion::Observer;
use crate::physics::Body;
use crate::physics::body::Symmetry;
use crate::physics::flow::{self, Spin};
use crate::physics::observe::TurnTerms;

/// Number of samples on which the starts are compared; the last fit uses all.
const SCOUTS: usize = 14;
/// Root mean square angle below which the fit from the mean rate is accepted: no other start found
/// another one in any performance.
const CLEAR_RMS_RAD: f64 = 0.2;
/// Greatest angle between neighbours from which a mean rate is computed.
const NEIGHBOURS_RAD: f64 = 2.0;
/// Least and greatest number of readings of the first window of [`grow`].
const FIRST_WINDOW: (usize, usize) = (4, 8);
/// The first window ends where the body has turned by this \[rad\], a third of a flip: eight
/// readings of eight flips in 0.7 s are most of a flip, from whose mean rate one fit in twelve went
/// wrong.
const FIRST_TURN_RAD: f64 = 3.0;
/// Of more than twice as many readings only so many are used: they suffice for a start.
pub(super) const READINGS_MAX: usize = 512;
/// Greatest number of iterations of one fit.
const ITERATIONS_MAX: usize = 25;

/// A measured orientation, `s` seconds from the epoch.
pub type OrientationReading = (f64, UnitQuaternion<f64>);

/// Orientation and angular velocity at the epoch, with the sum of squares of the fit.
#[derive(Clone, Copy, Debug)]
pub struct TurnFit {
    /// World from body.
    pub orientation: UnitQuaternion<f64>,
    /// Angular velocity [rad/s, body].
    pub angular_velocity_rad_s: Vector3<f64>,
    /// Sum of squared angles \[rad²\].
    pub square_rad2: f64,
    /// Iterations, of all starts together.
    pub iterations: usize,
}

/// Fits `readings`, in order of time: from the mean rate of all, and from fits to the first
/// half, the middle and the last half; a body with three different moments also from fits that
/// grow from its first readings.
pub fn fit(body: &Body, readings: &[OrientationReading]) -> TurnFit {
    let stride = readings.len() / READINGS_MAX;
    if stride > 1 {
        let some: Vec<OrientationReading> = readings.iter().copied().step_by(stride).collect();
        let of_some = fit(body, &some);
        let for_each = readings.len() as f64 / some.len() as f64;
        return TurnFit {
            square_rad2: for_each * of_some.square_rad2,
            ..of_some
        };
    }
    if body.symmetry() == Symmetry::Asymmetric {
        let grown = grow(body, readings);
        let clear = readings.len() as f64 * CLEAR_RMS_RAD * CLEAR_RMS_RAD;
        if grown.square_rad2 < clear {
            return grown;
        }
        let other = fit_from_means(body, readings);
        let iterations = grown.iterations + other.iterations;
        let best = if other.square_rad2 < grown.square_rad2 {
            other
        } else {
            grown
        };
        return TurnFit { iterations, ..best };
    }
    fit_from_means(body, readings)
}

/// Fit for bodies with three different moments, whose mean rate over a flip is meaningless: starts
/// from the mean rate of the first few readings and fits ever more of them, each time half as many
/// again, so that no fit has to find more than a part of a flip.
fn grow(body: &Body, readings: &[OrientationReading]) -> TurnFit {
    let count = readings.len();
    // The epoch is the first reading until all readings are used.
    let first_s = readings.first().map_or(0.0, |reading| reading.0);
    let from_first: Vec<OrientationReading> =
        readings.iter().map(|(s, r)| (s - first_s, *r)).collect();
    let mut window = first_window(readings);
    let mut best = start(body, &from_first[..window]);
    let mut iterations = 0;
    while window < count {
        best = descend(body, &from_first[..window], best);
        iterations += best.iterations;
        window += window / 2;
    }
    let turn = flow::turn(
        body,
        &best.orientation,
        &best.angular_velocity_rad_s,
        -first_s,
    );
    best.orientation = turn.orientation;
    best.angular_velocity_rad_s = turn.angular_velocity_rad_s;
    best = descend(body, readings, best);
    iterations += best.iterations;
    TurnFit { iterations, ..best }
}

/// Number of readings of the first window.
fn first_window(readings: &[OrientationReading]) -> usize {
    let (least, most) = FIRST_WINDOW;
    let steps = readings.windows(2).take(most - 1);
    let turned = steps.scan(0.0, |turned_rad, pair| {
        *turned_rad += pair[0].1.angle_to(&pair[1].1);
        Some(*turned_rad)
    });
    let within = turned.take_while(|turned_rad| *turned_rad <= FIRST_TURN_RAD);
    (1 + within.count()).max(least).min(readings.len())
}

fn fit_from_means(body: &Body, readings: &[OrientationReading]) -> TurnFit {
    let stride = readings.len().div_ceil(SCOUTS).max(1);
    let scouts: Vec<OrientationReading> = readings.iter().copied().step_by(stride).collect();
    let mut best = descend(body, &scouts, start(body, readings));
    let mut iterations = best.iterations;
    let clear = scouts.len() as f64 * CLEAR_RMS_RAD * CLEAR_RMS_RAD;
    let others = if best.square_rad2 < clear {
        Vec::new()
    } else {
        windows(scouts.len())
    };
    for window in others {
        let window = &scouts[window];
        let local = descend(body, window, start(body, window));
        let whole = descend(body, &scouts, local);
        iterations += local.iterations + whole.iterations;
        if whole.square_rad2 < best.square_rad2 {
            best = whole;
        }
    }
    if stride > 1 {
        best = descend(body, readings, best);
        iterations += best.iterations;
    }
    TurnFit { iterations, ..best }
}

/// Distinct local minima, best first, and the number of iterations: `best`, those from the starts
/// of [`fit`], and those from starts with up to one turn more or less about each axis.
pub fn alternatives(
    body: &Body,
    readings: &[OrientationReading],
    best: TurnFit,
    observer: &mut dyn Observer,
) -> (Vec<TurnFit>, usize) {
    let stride = readings.len().div_ceil(SCOUTS).max(1);
    let scouts: Vec<OrientationReading> = readings.iter().copied().step_by(stride).collect();
    let span_s = readings[readings.len() - 1].0 - readings[0].0;
    let mut starts: Vec<TurnFit> = windows(scouts.len())
        .into_iter()
        .map(|window| descend(body, &scouts[window.clone()], start(body, &scouts[window])))
        .collect();
    for axis in 0..3 {
        for turns in [-1.0, -0.5, 0.5, 1.0] {
            let mut from = best;
            from.angular_velocity_rad_s[axis] += turns * std::f64::consts::TAU / span_s;
            starts.push(from);
        }
    }
    let mut found = vec![best];
    let mut iterations = 0;
    for from in starts {
        if observer.should_stop() {
            break;
        }
        let scouted = descend(body, &scouts, from);
        let end = descend(body, readings, scouted);
        iterations += scouted.iterations + end.iterations;
        let is_new = found.iter().all(|other| {
            (other.angular_velocity_rad_s - end.angular_velocity_rad_s).norm() * span_s > 0.3
                || other.orientation.angle_to(&end.orientation) > 0.2
        });
        if is_new {
            found.push(end);
        }
    }
    found.sort_by(|a, b| a.square_rad2.total_cmp(&b.square_rad2));
    (found, iterations)
}

/// First half, middle and last half of `count` readings; empty where there are too few.
fn windows(count: usize) -> Vec<std::ops::Range<usize>> {
    if count < 8 {
        return Vec::new();
    }
    vec![0..count / 2, count / 4..count - count / 4, count / 2..count]
}

/// The mean rate of `readings`, from the orientation nearest the epoch.
///
/// A symmetric top keeps the rate of its axis in the world and the rate about it in the body.
fn start(body: &Body, readings: &[OrientationReading]) -> TurnFit {
    let axis = match body.symmetry() {
        Symmetry::Spherical | Symmetry::Asymmetric => Vector3::zeros(),
        Symmetry::Axial { axis } => Vector3::ith(axis, 1.0),
    };
    // Neighbours far enough apart that noise is small relative to the angle between them, and near
    // enough that it is less than half a turn: more would look like less in the other direction.
    let steps = readings.windows(2);
    let turned_rad: f64 = steps.map(|pair| pair[0].1.angle_to(&pair[1].1)).sum();
    let per_step_rad = turned_rad / readings.len().saturating_sub(1).max(1) as f64;
    let stride = (readings.len() / 8)
        .min((NEIGHBOURS_RAD / per_step_rad) as usize)
        .max(1);
    let (mut about_axis, mut across, mut pairs) = (0.0, Vector3::zeros(), 0.0);
    for (from, to) in readings.iter().zip(readings.iter().skip(stride)) {
        let rate = so3::log(&(from.1.inverse() * to.1)) / (to.0 - from.0);
        let spin = rate.dot(&axis);
        about_axis += spin;
        across += from.1 * (rate - axis * spin);
        pairs += 1.0;
    }
    let orientation = readings
        .iter()
        .min_by(|a, b| a.0.abs().total_cmp(&b.0.abs()))
        .map_or_else(UnitQuaternion::identity, |reading| reading.1);
    let angular_velocity_rad_s = if pairs > 0.0 {
        (orientation.inverse() * across + axis * about_axis) / pairs
    } else {
        Vector3::zeros()
    };
    TurnFit {
        orientation,
        angular_velocity_rad_s,
        square_rad2: f64::INFINITY,
        iterations: 0,
    }
}

fn evaluate(body: &Body, readings: &[OrientationReading], fit: &TurnFit) -> Quadratic {
    let readings = readings.iter().map(|(s, measured)| (*s, measured));
    let mut spin = Spin::new(body, &fit.angular_velocity_rad_s);
    Quadratic::of(&TurnTerms::of(&mut spin, &fit.orientation, readings))
}

pub(super) fn descend(body: &Body, readings: &[OrientationReading], from: TurnFit) -> TurnFit {
    descend_on(|fit| evaluate(body, readings, fit), from)
}

/// Half a sum of squares about a rotation, by orientation and angular velocity at the epoch.
pub(super) struct Quadratic {
    pub(super) cost: f64,
    pub(super) gradient: Vector6<f64>,
    pub(super) matrix: Matrix6<f64>,
}

impl Quadratic {
    fn of(terms: &TurnTerms) -> Self {
        let mut matrix = Matrix6::zeros();
        matrix
            .fixed_view_mut::<3, 3>(0, 0)
            .fill_diagonal(terms.count);
        matrix.fixed_view_mut::<3, 3>(0, 3).copy_from(&terms.cross);
        matrix
            .fixed_view_mut::<3, 3>(3, 0)
            .copy_from(&terms.cross.transpose());
        matrix.fixed_view_mut::<3, 3>(3, 3).copy_from(&terms.square);
        let mut gradient = Vector6::zeros();
        gradient
            .fixed_rows_mut::<3>(0)
            .copy_from(&terms.gradient_orientation);
        gradient
            .fixed_rows_mut::<3>(3)
            .copy_from(&terms.gradient_spin);
        Self {
            cost: terms.cost,
            gradient,
            matrix,
        }
    }
}

/// The least sum of squares near a start.
pub(super) fn descend_on(evaluate: impl Fn(&TurnFit) -> Quadratic, from: TurnFit) -> TurnFit {
    let mut fit = from;
    let mut terms = evaluate(&fit);
    let (mut damping, mut growth) = (1e-4, 2.0);
    for iteration in 1..=ITERATIONS_MAX {
        let (delta, predicted) = match step(&terms, damping) {
            Some(step) => step,
            None => {
                return TurnFit {
                    square_rad2: 2.0 * terms.cost,
                    iterations: iteration,
                    ..fit
                };
            }
        };
        let trial = TurnFit {
            orientation: UnitQuaternion::new_normalize(
                (fit.orientation * so3::exp(&delta.fixed_rows::<3>(0).into())).into_inner(),
            ),
            angular_velocity_rad_s: fit.angular_velocity_rad_s + delta.fixed_rows::<3>(3),
            ..fit
        };
        let trial_terms = evaluate(&trial);
        let ratio = (terms.cost - trial_terms.cost) / predicted.max(f64::MIN_POSITIVE);
        let small = predicted < 1e-5 * terms.cost.max(1e-12);
        if ratio > 1e-4 {
            damping *= (1.0 - (2.0 * ratio - 1.0).powi(3)).max(1.0 / 3.0);
            growth = 2.0;
            (fit, terms) = (trial, trial_terms);
        } else {
            damping *= growth;
            growth *= 2.0;
        }
        fit.iterations = iteration;
        if small {
            break;
        }
    }
    TurnFit {
        square_rad2: 2.0 * terms.cost,
        ..fit
    }
}

/// A damped step and its predicted decrease; `None` where the matrix is not positive definite.
fn step(terms: &Quadratic, damping: f64) -> Option<(Vector6<f64>, f64)> {
    let scale = terms.matrix.diagonal().map(|d| damping * d + 1e-12);
    let damped = terms.matrix + Matrix6::from_diagonal(&scale);
    let delta = -damped.cholesky()?.solve(&terms.gradient);
    let predicted = 0.5 * (delta.component_mul(&scale).dot(&delta) - terms.gradient.dot(&delta));
    Some((delta, predicted))
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_distr::Distribution;

    use super::*;
    use crate::physics::flow::Spin;

    #[test]
    fn finds_a_fast_turn_from_clean_data_to_rounding() {
        for moments in [
            Vector3::new(2.0, 2.0, 2.0),
            Vector3::new(2.0, 2.0, 0.02),
            Vector3::new(2.0, 1.0, 1.5),
        ] {
            let body = Body::new(1.0, moments).unwrap();
            let orientation = UnitQuaternion::from_euler_angles(0.3, 1.0, -2.0);
            let omega = Vector3::new(9.0, -6.0, 14.0);
            let mut spin = Spin::new(&body, &omega);
            let readings: Vec<OrientationReading> = (0..60)
                .map(|i| f64::from(i) / 120.0 - 0.25)
                .map(|s| (s, orientation * spin.turn_and_derivative(s).0))
                .collect();
            let fit = fit(&body, &readings);
            assert!(fit.square_rad2 < 1e-9, "{fit:?}");
            assert!((fit.angular_velocity_rad_s - omega).norm() < 1e-3);
        }
    }

    /// Readings of a tumbling brick at 120 Hz, with a smooth wander of 8° rms and noise of 0.3°.
    fn tumble(
        body: &Body,
        omega: &Vector3<f64>,
        count: usize,
        seed: u64,
    ) -> Vec<OrientationReading> {
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
        let normal = rand_distr::StandardNormal;
        let mut draw = || -> f64 { normal.sample(&mut random) };
        let waves: Vec<(f64, Vector3<f64>)> = [0.3, 0.6, 1.0, 1.6]
            .into_iter()
            .flat_map(|hertz| [hertz, -hertz])
            .map(|hertz| (hertz, Vector3::new(draw(), draw(), draw())))
            .collect();
        // Eight waves of mean square one half each, on three axes.
        let wander_rad = 8.0_f64.to_radians() / 12.0_f64.sqrt();
        let noise_rad = 0.3_f64.to_radians() / 3.0_f64.sqrt();
        let mut spin = Spin::new(body, omega);
        (0..count)
            .map(|i| (i as f64 - 0.5 * count as f64) / 120.0)
            .map(|s| {
                let wave = |(hertz, size): &(f64, Vector3<f64>)| {
                    let phase = std::f64::consts::TAU * hertz.abs() * s;
                    size * if *hertz > 0.0 {
                        phase.sin()
                    } else {
                        phase.cos()
                    }
                };
                let wander: Vector3<f64> = waves.iter().map(wave).sum();
                let noise = Vector3::new(draw(), draw(), draw());
                let off = so3::exp(&(wander * wander_rad + noise * noise_rad));
                (s, spin.turn_and_derivative(s).0 * off)
            })
            .collect()
    }

    /// The fit that the true motion leads to.
    fn from_the_truth(
        body: &Body,
        readings: &[OrientationReading],
        omega: Vector3<f64>,
    ) -> TurnFit {
        let truth = TurnFit {
            orientation: UnitQuaternion::identity(),
            angular_velocity_rad_s: omega,
            square_rad2: f64::INFINITY,
            iterations: 0,
        };
        descend(body, readings, truth)
    }

    #[test]
    fn finds_every_flip_of_a_tumbling_brick_in_a_distorted_sketch() {
        let body = Body::new(1.0, Vector3::new(1.0, 2.0, 2.5)).unwrap();
        let omega = Vector3::new(0.5, 14.0, -0.3);
        for (seed, count) in [70, 150, 280, 420, 560, 700, 900].into_iter().enumerate() {
            let readings = tumble(&body, &omega, count, seed as u64);
            let found = fit(&body, &readings);
            let best = from_the_truth(&body, &readings, omega);
            assert!(
                found.square_rad2 < best.square_rad2 * (1.0 + 1e-3),
                "{count}: {found:?} {best:?}"
            );
            assert!((found.angular_velocity_rad_s - omega).norm() < 2.0);
        }
    }

    #[test]
    fn finds_a_tumble_of_two_radians_a_reading() {
        // A brick of 20 × 12 × 6 cm, eight flips and more in 0.7 s.
        let body = Body::new(1.0, Vector3::new(0.0045, 0.0109, 0.0136)).unwrap();
        for seed in 0..40_u64 {
            let (sin, cos) = (0.4 * seed as f64).sin_cos();
            let omega = Vector3::new(0.2 * sin, 1.0, 0.2 * cos) * (100.0 + 3.0 * seed as f64);
            let readings = tumble(&body, &omega, 84, seed);
            let found = fit(&body, &readings);
            let best = from_the_truth(&body, &readings, omega);
            assert!(
                found.square_rad2 < best.square_rad2 * (1.0 + 1e-3),
                "{seed}: {found:?} {best:?}"
            );
        }
    }

    #[test]
    fn three_readings_without_motion_stand_still() {
        for moments in [Vector3::new(2.0, 2.0, 0.02), Vector3::new(2.0, 1.0, 1.5)] {
            let body = Body::new(1.0, moments).unwrap();
            let readings = [-0.1, 0.0, 0.1].map(|s| (s, UnitQuaternion::identity()));
            let fit = fit(&body, &readings);
            assert!(fit.angular_velocity_rad_s.norm() < 1e-12 && fit.square_rad2 < 1e-20);
        }
    }
}
