//! Two clocks, by the turning that both trackers see.

use nalgebra::{Matrix3, Matrix3xX, Rotation3, UnitQuaternion, Vector3};

use super::error::CalibrateError;
use super::regression::{Equation, Regression, regress};
use super::rest::mean_turn;
use super::spread::{Measured, Spread};
use super::stream::{Reading, Stream};
use super::turn_rate::turn_rate;
use crate::math::so3::{exp, log, matrix};

/// Least time in common \[s\].
const OVERLAP_S: f64 = 2.0;

/// Steps in which offsets are searched, at most.
const STEPS: f64 = 4000.0;

/// Least half of the window of an angular velocity \[s\], and in sampling intervals.
const HALF_S: f64 = 0.03;
const HALF_INTERVALS: f64 = 3.0;

/// Least correlation of two turnings that are the same.
const AGREES: f64 = 0.6;

/// Offset, drift, and the two rotations.
const UNKNOWNS: usize = 8;

/// Weight of rotations that do not change, beside that of a reading.
const RIDGE: f64 = 1e-4;

/// Rounds of linearisation at most; it ends when the offset changes by less than this share of its standard deviation.
const ROUNDS: usize = 12;
const CONVERGED: f64 = 1e-3;

/// Offset and drift between two clocks.
#[derive(Clone, Debug, PartialEq)]
pub struct ClockFit {
    /// What to add to stamps of the second stream at its first sample \[s\].
    pub offset_s: Measured,
    /// What to add at the middle of the time in common \[s\]: the best known.
    pub middle_offset_s: Measured,
    /// That middle \[s, second stream\].
    pub middle_s: f64,
    /// By how much the second clock is slow [s/s]: time is `1 + rate` times what its stamps say.
    pub rate: Measured,
    /// Rotation between the trackers: first from second.
    pub first_from_second: UnitQuaternion<f64>,

    /// Root mean square difference of the orientations \[rad\].
    pub residual_rad: f64,
    /// Root mean square turn from the mean orientation \[rad\].
    pub turn_rad: f64,
    /// Root mean square angular velocity \[rad/s\].
    pub turning_rad_s: f64,
    /// Time in common \[s\].
    pub overlap_s: f64,
    /// How the residuals are correlated.
    pub spread: Spread,
}

/// Finds offset and drift by orientations, which two trackers on one object see alike but for constant rotations between the
/// trackers, `Q`, and between their worlds, `W`: `R₁(s + o + d (s − s̄)) = W R₂(s) Qᵀ`. Where each is mounted does not
/// matter. Both streams' times count from one origin. The search begins where the speeds of turning are most alike.
///
/// Fails where they have less than 2 s in common or do not turn alike at any offset.
pub fn clock(first: &Stream, second: &Stream) -> Result<ClockFit, CalibrateError> {
    let interval_s = first
        .interval_s()
        .unwrap_or(0.0)
        .max(second.interval_s().unwrap_or(0.0));
    let half_s = HALF_S.max(HALF_INTERVALS * interval_s);
    let coarse_s = coarse(first, second, half_s, interval_s)?;
    let mut at = Alignment {
        offset_s: coarse_s,
        rate: 0.0,
        middle_s: 0.0,
        turn: UnitQuaternion::identity(),
        worlds: UnitQuaternion::identity(),
    };
    let overlap = common(first, second, coarse_s);
    let overlap_s = overlap[1] - overlap[0];
    at.middle_s = 0.5 * (overlap[0] + overlap[1]) - coarse_s;
    let rates: Vec<(f64, Vector3<f64>)> = second
        .readings
        .iter()
        .filter_map(|of| Some((of.time_s, turn_rate(&second.readings, of.time_s, half_s)?)))
        .collect();

    at.turn = at.turn_between(&first.readings, &rates, half_s);
    let worlds: Vec<UnitQuaternion<f64>> = second
        .readings
        .iter()
        .filter_map(|of| {
            let here = turn_at(&first.readings, at.time_s(of.time_s), half_s)?;
            Some(here * at.turn * of.world_from_tracker.rotation.inverse())
        })
        .collect();
    at.worlds = mean_turn(&worlds);

    let too_little = CalibrateError::NoOverlap {
        overlap_s,
        least_s: OVERLAP_S,
    };
    let mut fit = at
        .step(&first.readings, &second.readings, half_s)
        .ok_or(too_little.clone())?;
    for _ in 0..ROUNDS {
        at.apply(&fit);
        if fit.unknowns[0].abs() < CONVERGED * fit.covariance[(0, 0)].max(0.0).sqrt() {
            break;
        }
        fit = at
            .step(&first.readings, &second.readings, half_s)
            .ok_or(too_little.clone())?;
    }
    let freedom = (fit.spread.blocks - 1) as f64;
    let covariance = &fit.covariance;
    let since_s = second.extent_s()[0] - at.middle_s;
    let variance = covariance[(0, 0)]
        + 2.0 * since_s * covariance[(0, 1)]
        + since_s * since_s * covariance[(1, 1)];
    let measured = |value: f64, variance: f64| {
        Measured::new(vec![value], vec![variance.max(0.0).sqrt()], freedom)
    };

    let oriented: Vec<_> = second
        .readings
        .iter()
        .map(|of| of.world_from_tracker.rotation)
        .collect();
    let mean = mean_turn(&oriented);
    let turns: f64 = oriented
        .iter()
        .map(|turn| mean.angle_to(turn).powi(2))
        .sum();
    let squares: f64 = rates.iter().map(|(_, rate)| rate.norm_squared()).sum();
    Ok(ClockFit {
        offset_s: measured(at.offset_s + at.rate * since_s, variance),
        middle_offset_s: measured(at.offset_s, covariance[(0, 0)]),
        middle_s: at.middle_s,
        rate: measured(at.rate, covariance[(1, 1)]),
        first_from_second: at.turn,

        residual_rad: fit.rms(),
        turn_rad: (turns / second.readings.len() as f64).sqrt(),
        turning_rad_s: (squares / rates.len().max(1) as f64).sqrt(),
        overlap_s,
        spread: fit.spread,
    })
}

/// A guess of what is sought.
struct Alignment {
    offset_s: f64,
    rate: f64,
    middle_s: f64,
    /// First tracker from second.
    turn: UnitQuaternion<f64>,
    /// The first's world from the second's.
    worlds: UnitQuaternion<f64>,
}

impl Alignment {
    fn time_s(&self, stamp_s: f64) -> f64 {
        stamp_s + self.offset_s + self.rate * (stamp_s - self.middle_s)
    }

    /// The rotation that fits best with these clocks.
    fn turn_between(
        &self,
        first: &[Reading],
        second: &[(f64, Vector3<f64>)],
        half_s: f64,
    ) -> UnitQuaternion<f64> {
        let pairs = second
            .iter()
            .filter_map(|(at_s, rate)| Some((turn_rate(first, self.time_s(*at_s), half_s)?, rate)));
        let scatter: Matrix3<f64> = pairs.map(|(one, other)| one * other.transpose()).sum();
        let svd = scatter.svd(true, true);
        let (Some(u), Some(v_t)) = (svd.u, svd.v_t) else {
            return UnitQuaternion::identity();
        };
        let handed = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, (u * v_t).determinant()));
        let turn = Rotation3::from_matrix_unchecked(u * handed * v_t);
        UnitQuaternion::from_rotation_matrix(&turn)
    }

    /// The equations linearised here, solved for changes of offset, drift and both rotations: with
    /// `e = Log(Q R₂(s)ᵀ Wᵀ R₁(t))`, `ω₁ (δo + (s − s̄) δd) + θ_Q − R₁ᵀ θ_W = −e`.
    fn step(&self, first: &[Reading], second: &[Reading], half_s: f64) -> Option<Regression> {
        let mut equations = Vec::new();
        for reading in second {
            let time_s = self.time_s(reading.time_s);
            let (Some(here), Some(rate)) = (
                turn_at(first, time_s, half_s),
                turn_rate(first, time_s, half_s),
            ) else {
                continue;
            };
            let model = self.worlds * reading.world_from_tracker.rotation * self.turn.inverse();
            let mut coefficients = Matrix3xX::zeros(UNKNOWNS);
            coefficients.set_column(0, &rate);
            coefficients.set_column(1, &(rate * (reading.time_s - self.middle_s)));
            coefficients
                .fixed_columns_mut::<3>(2)
                .copy_from(&Matrix3::identity());
            coefficients
                .fixed_columns_mut::<3>(5)
                .copy_from(&-matrix(&here.inverse()));
            equations.push(Equation {
                coefficients,
                observed: -log(&(model.inverse() * here)),
            });
        }
        if equations.is_empty() {
            return None;
        }
        // About one axis alone the two rotations are not told apart, and need not be.
        for column in [2, 5] {
            let mut coefficients = Matrix3xX::zeros(UNKNOWNS);
            coefficients
                .fixed_columns_mut::<3>(column)
                .copy_from(&(Matrix3::identity() * RIDGE));
            equations.push(Equation {
                coefficients,
                observed: Vector3::zeros(),
            });
        }
        regress(&equations)
    }

    fn apply(&mut self, fit: &Regression) {
        let x = &fit.unknowns;
        self.offset_s += x[0];
        self.rate += x[1];
        self.turn = exp(&Vector3::new(x[2], x[3], x[4])) * self.turn;
        self.worlds = exp(&Vector3::new(x[5], x[6], x[7])) * self.worlds;
    }
}

/// The orientation at a time, between the two readings about it; `None` in a gap and beyond the ends.
fn turn_at(readings: &[Reading], time_s: f64, gap_s: f64) -> Option<UnitQuaternion<f64>> {
    let after = readings.partition_point(|of| of.time_s <= time_s);
    let (before, after) = (readings.get(after.checked_sub(1)?)?, readings.get(after)?);
    let interval_s = after.time_s - before.time_s;
    let turn = before.world_from_tracker.rotation;
    let change = log(&(turn.inverse() * after.world_from_tracker.rotation));
    (interval_s <= gap_s).then(|| turn * exp(&(change * ((time_s - before.time_s) / interval_s))))
}

/// From when to when both are there, on the first clock, if so much is added to the second.
fn common(first: &Stream, second: &Stream, offset_s: f64) -> [f64; 2] {
    let ([a, b], [c, d]) = (first.extent_s(), second.extent_s());
    [a.max(c + offset_s), b.min(d + offset_s)]
}

/// The offset at which the speeds of turning are most alike, by normalised cross-correlation in steps.
fn coarse(
    first: &Stream,
    second: &Stream,
    half_s: f64,
    interval_s: f64,
) -> Result<f64, CalibrateError> {
    let extent = |of: &Stream| of.extent_s()[1] - of.extent_s()[0];
    let (one_s, other_s) = (extent(first), extent(second));
    let shortest_s = one_s.min(other_s);
    let no_overlap = |overlap_s: f64| CalibrateError::NoOverlap {
        overlap_s,
        least_s: OVERLAP_S,
    };
    if shortest_s < OVERLAP_S {
        return Err(no_overlap(shortest_s));
    }
    let step_s = interval_s.max(one_s.max(other_s) / STEPS);
    let speeds = |of: &Stream| -> Vec<Option<f64>> {
        let [from_s, to_s] = of.extent_s();
        let count = ((to_s - from_s) / step_s) as usize + 1;
        let at = |step: usize| turn_rate(&of.readings, from_s + step as f64 * step_s, half_s);
        (0..count)
            .map(|step| at(step).map(|rate| rate.norm()))
            .collect()
    };
    let (a, b) = (speeds(first), speeds(second));
    // At least half of the shorter one, and two seconds.
    let least = ((0.5 * shortest_s).max(OVERLAP_S) / step_s) as usize;
    let (from, to) = (
        least as isize - b.len() as isize,
        a.len() as isize - least as isize,
    );
    let best = (from..=to)
        .filter_map(|lag| Some((correlation(&a, &b, lag, least)?, lag)))
        .max_by(|x, y| x.0.total_cmp(&y.0));
    match best {
        Some((correlation, lag)) if correlation >= AGREES => {
            Ok(first.extent_s()[0] + lag as f64 * step_s - second.extent_s()[0])
        }
        best => Err(CalibrateError::NoAgreement(best.map_or(0.0, |of| of.0))),
    }
}

/// Pearson's correlation of `a` with `b` shifted by `lag`; `None` of fewer than half of `least` pairs.
fn correlation(a: &[Option<f64>], b: &[Option<f64>], lag: isize, least: usize) -> Option<f64> {
    let start = lag.max(0) as usize;
    let end = a.len().min((b.len() as isize + lag).max(0) as usize);
    let pairs = (start..end).filter_map(|at| Some((a[at]?, b[(at as isize - lag) as usize]?)));
    let mut sums = [0.0; 6];
    for (x, y) in pairs {
        let terms = [1.0, x, y, x * x, y * y, x * y];
        (0..6).for_each(|of| sums[of] += terms[of]);
    }
    let [n, x, y, xx, yy, xy] = sums;
    if n < 0.5 * least as f64 {
        return None;
    }
    let covariance = xy - x * y / n;
    let variances = (xx - x * x / n) * (yy - y * y / n);
    (variances > 0.0).then(|| covariance / variances.sqrt())
}
