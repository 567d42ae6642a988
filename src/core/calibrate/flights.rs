//! Where in a stream the object flies freely.

use std::ops::Range;

use nalgebra::{DMatrix, Vector3};

use super::stream::{Reading, Stream};

/// Fewest samples of a flight that is searched for.
pub const LEAST: usize = 8;

/// Standard deviation of a third difference of white noise: √(1 + 9 + 9 + 1).
const THIRD: f64 = 4.472_135_955;

/// The least of many noises is less than the noise.
const LUCK: f64 = 1.5;

/// Residuals of a flight are at most so many times the noise.
const NOISE: f64 = 4.0;

/// The fall during a flight is at least so many times the noise.
const FALL: f64 = 40.0;

/// Further flights fall by at least this share of what the longest does.
const SHARE: f64 = 0.3;

/// Windows of fewer samples are tried one by one.
const LONG: usize = 1024;

/// How much the acceleration of further flights may differ from the first's.
pub(super) const ALIKE: f64 = 0.2;

struct Window {
    range: Range<usize>,
    acceleration: Vector3<f64>,

    /// `|a| T²/8`: how far the path is from a straight line.
    fall: f64,
    /// `|a|² T`: what slides on a table is slowed for longer than something falls, but by less.
    pull: f64,
}

/// The ranges of readings in which a point of the tracker's axes moves on a parabola within the noise, and falls by
/// much more than that: first the one that is pulled most, and all others that fall alike, in order of time.
///
/// The noise is that of third differences, which a parabola does not have, where they are least.
pub fn flights(stream: &Stream, point_m: &Vector3<f64>) -> Vec<Range<usize>> {
    let places: Vec<Vector3<f64>> = stream
        .readings
        .iter()
        .map(|reading| place(reading, point_m))
        .collect();
    let noise = noise(&places);
    let times: Vec<f64> = stream.readings.iter().map(|of| of.time_s).collect();
    let mut windows: Vec<Window> = Vec::new();
    let count = places.len();
    let (mut start, mut end) = (0, LEAST);
    while start + LEAST <= count {
        end = end.max(start + LEAST);
        // The longest that begins here: once a window is no parabola, no longer one is.
        let mut longest = None;
        while end <= count {
            match parabola(&times[start..end], &places[start..end], noise) {
                Some(acceleration) => longest = Some((end, acceleration)),
                None => break,
            }
            end = match end == count {
                true => count + 1,
                false => (end + step(end - start)).min(count),
            };
        }
        let length = longest.map_or(0, |(end, _)| end - start);
        if let Some((end, acceleration)) = longest {
            let duration_s = times[end - 1] - times[start];
            let size = acceleration.norm();
            let fall = size * duration_s * duration_s / 8.0;
            if fall >= FALL * noise {
                windows.push(Window {
                    range: start..end,
                    acceleration,

                    fall,
                    pull: size * size * duration_s,
                });
            }
        }
        start += step(length);
    }
    chosen(windows)
}

/// From one window to the next: a sample, or of long windows a part of their length that does not count.
fn step(length: usize) -> usize {
    1 + length / LONG
}

/// The window that is pulled most, then others that do not overlap and fall alike.
fn chosen(mut windows: Vec<Window>) -> Vec<Range<usize>> {
    windows.sort_by(|a, b| b.pull.total_cmp(&a.pull));
    let mut found: Vec<Range<usize>> = Vec::new();
    let Some(first) = windows.first() else {
        return found;
    };
    let (acceleration, fall) = (first.acceleration, first.fall);
    for window in &windows {
        let is_apart = found
            .iter()
            .all(|of| window.range.end <= of.start || of.end <= window.range.start);
        let differs = (window.acceleration - acceleration).norm() > ALIKE * acceleration.norm();
        if is_apart && !differs && window.fall >= SHARE * fall {
            // The first and the last sample may be of the hand and of the impact, by a part of an interval.
            found.push(window.range.start + 1..window.range.end - 1);
        }
    }
    found.sort_by_key(|range| range.start);
    found
}

pub(super) fn place(reading: &Reading, point_m: &Vector3<f64>) -> Vector3<f64> {
    (reading.world_from_tracker * nalgebra::Point3::from(*point_m)).coords
}

/// Standard deviation per axis by third differences, where they are least for as long as the shortest flight: at rest
/// or in flight. At least that of rounding.
fn noise(places: &[Vector3<f64>]) -> f64 {
    let thirds = places.windows(4);
    let thirds = thirds.map(|of| of[3] - of[0] + (of[1] - of[2]) * 3.0);
    let squares: Vec<f64> = thirds.map(|of| of.norm_squared() / 3.0).collect();
    let windows = squares.windows(LEAST);
    let means = windows.map(|of| of.iter().sum::<f64>() / LEAST as f64);
    let least = means.fold(f64::INFINITY, f64::min);
    let size = places.iter().map(|place| place.amax()).fold(0.0, f64::max);
    if least.is_finite() {
        (LUCK * least.sqrt() / THIRD).max(1e-9 * size)
    } else {
        1e-9 * size
    }
}

/// The acceleration of the parabola, where every place is within the noise of it.
fn parabola(times: &[f64], places: &[Vector3<f64>], noise: f64) -> Option<Vector3<f64>> {
    let middle_s = 0.5 * (times.first()? + times.last()?);
    let length_s = times.last()? - times.first()?;
    let u = |t: f64| (t - middle_s) / length_s;
    let powers = DMatrix::from_fn(times.len(), 3, |row, power| {
        u(times[row]).powi(power as i32)
    });
    let observed = DMatrix::from_fn(times.len(), 3, |row, axis| places[row][axis]);
    let normal = powers.tr_mul(&powers).cholesky()?;
    let coefficients = normal.solve(&powers.tr_mul(&observed));
    let residual = &observed - &powers * &coefficients;
    let is_one = residual.amax() <= NOISE * noise;
    is_one
        .then(|| coefficients.row(2).transpose().fixed_rows::<3>(0) * (2.0 / (length_s * length_s)))
}
