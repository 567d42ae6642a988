//! Finds outliers: readings of a tracker that jumped away and came back.
//!
//! Three neighbouring readings on a smooth motion are nearly collinear: the middle one is off the
//! line by noise and by the curvature of the path. How much of each is usual is estimated from the
//! stream, by lower quartiles over near and farther neighbours, which are robust against many bad
//! readings. Where three neighbours are off by more, dynamic programming keeps the most readings
//! for which the path is piecewise smooth: leaving one out costs a little less than a break of the
//! path. A collision is such a break, of velocity and not of position; so a reading that was left
//! out is restored where it continues the path on one side of it.
//!
//! Physics, marks and scene are not used; the motion is taken in the time of the stamps.

use nalgebra::{Vector3, Vector4};

use super::reading::Reading;
use crate::motion::{DropReason, SampleCounts};

/// Distance from its neighbours' line below which a reading is never an outlier, in position \[m\],
const FLOOR_M: f64 = 0.01;
/// and in orientation \[rad\].
const FLOOR_RAD: f64 = 0.06;
/// The limit is this multiple of the lower quartile of that distance: with white noise, nearly
/// eight standard deviations of it.
const QUARTILES: f64 = 7.0;
/// Distance of the farther neighbours in intervals.
const FAR: usize = 3;
/// Least number of readings for the quartiles.
const READINGS_MIN: usize = 8;
/// The next reading kept is at most so many after the last: up to six in a row are left out.
const STRIDE_MAX: usize = 7;
/// Readings added on either side of one that continues neither side.
const MARGIN: usize = 4;
/// Cost of leaving out a reading.
const DROP_COST: u32 = 10;
/// Cost of a break of the path. A single outlier makes three breaks, two to four equal ones make
/// four; a collision makes two at most.
const BREAK_COST: u32 = 11;
/// Greatest share of a stream that may be left out. Beyond it the stream may not be smooth at all,
/// and all of it is kept.
const SHARE_MAX: f64 = 0.4;

/// Leaves out of a stream in order of time what [`outliers`] finds, and counts it.
pub(super) fn drop_outliers(stream: &mut Vec<Reading>, counts: &mut SampleCounts) {
    let is_outlier = outliers(stream);
    counts.drop(
        DropReason::Outlier,
        is_outlier.iter().filter(|is| **is).count(),
    );
    let mut verdicts = is_outlier.into_iter();
    stream.retain(|_| !verdicts.next().unwrap_or(false));
}

/// Which readings of a stream in order of time are outliers; empty if none is.
fn outliers(stream: &[Reading]) -> Vec<bool> {
    let Some(path) = OutlierPath::new(stream) else {
        return Vec::new();
    };
    let mut dropped = Vec::new();
    for zone in path.zones() {
        dropped.extend(path.left_out(&zone));
    }
    let mut is_outlier = vec![false; stream.len()];
    for index in &dropped {
        is_outlier[*index] = true;
    }
    let confirmed: Vec<usize> = dropped
        .into_iter()
        .filter(|index| !path.continues_a_side(&is_outlier, *index))
        .collect();
    if confirmed.is_empty() || confirmed.len() as f64 > SHARE_MAX * stream.len() as f64 {
        return Vec::new();
    }
    is_outlier.fill(false);
    for index in confirmed {
        is_outlier[index] = true;
    }
    is_outlier
}

/// A pose, and its time in median intervals.
struct PlacedPose {
    time: f64,
    position_m: Vector3<f64>,
    quaternion: Vector4<f64>,
}

/// Readings and the usual distances between them.
struct OutlierPath {
    readings: Vec<PlacedPose>,
    position: Usual,
    orientation: Usual,
}

/// Usual distance of a reading from the line through its neighbours, times [`QUARTILES`].
#[derive(Clone, Copy, Default)]
struct Usual {
    noise: f64,
    /// Part from curvature, where both neighbours are one interval away.
    curvature: f64,
}

impl Usual {
    /// From squared distances to the line through neighbours and through those at [`FAR`].
    fn new(near: &mut [f64], far: &mut [f64]) -> Self {
        let near = lower_quartile(near);
        let far = lower_quartile(far);
        // In squared distances, curvature grows with the fourth power of the interval, noise does
        // not.
        let curvature = ((far - near) / ((FAR as f64).powi(4) - 1.0)).max(0.0);
        Self {
            noise: QUARTILES * near.sqrt(),
            curvature: QUARTILES * curvature.sqrt(),
        }
    }

    fn limit(&self, floor: f64, offset: &Offset) -> f64 {
        floor + self.noise * offset.noise + self.curvature * offset.curvature
    }
}

/// Distance of a reading from the line through two others, and factors of its expected size.
struct Offset {
    square_m2: f64,
    square_rad2: f64,
    /// Factor of noise, 1 for a reading in the middle of two.
    noise: f64,
    /// Factor of curvature, 1 for direct neighbours.
    curvature: f64,
}

/// Readings from `begin` to before `end` among which some may be left out.
struct Zone {
    begin: usize,
    end: usize,
}

impl OutlierPath {
    fn new(stream: &[Reading]) -> Option<Self> {
        if stream.len() < READINGS_MIN {
            return None;
        }
        let origin = stream[0].stamp;
        let mut intervals_ns: Vec<i64> = stream
            .windows(2)
            .map(|pair| pair[1].stamp.0 - pair[0].stamp.0)
            .collect();
        let middle = intervals_ns.len() / 2;
        let interval_ns = (*intervals_ns.select_nth_unstable(middle).1).max(1);
        let readings: Vec<PlacedPose> = stream
            .iter()
            .map(|sample| PlacedPose {
                time: (sample.stamp.0 - origin.0) as f64 / interval_ns as f64,
                position_m: sample.position_m,
                quaternion: Vector4::from(sample.quaternion_xyzw).normalize(),
            })
            .collect();
        let mut path = Self {
            readings,
            position: Usual::default(),
            orientation: Usual::default(),
        };
        let squares = |distance: usize| -> (Vec<f64>, Vec<f64>) {
            (distance..stream.len() - distance)
                .map(|i| path.offset(i - distance, i, i + distance))
                .map(|offset| (offset.square_m2, offset.square_rad2))
                .unzip()
        };
        let (mut near_m2, mut near_rad2) = squares(1);
        let (mut far_m2, mut far_rad2) = squares(FAR);
        path.position = Usual::new(&mut near_m2, &mut far_m2);
        path.orientation = Usual::new(&mut near_rad2, &mut far_rad2);
        Some(path)
    }

    /// Offset of reading `i` from the line through `j` and `k`; `i` may lie outside of them.
    fn offset(&self, j: usize, i: usize, k: usize) -> Offset {
        let (a, b, c) = (&self.readings[j], &self.readings[i], &self.readings[k]);
        let share = (b.time - a.time) / (c.time - a.time);
        let off_m = b.position_m - a.position_m - (c.position_m - a.position_m) * share;
        // Of the two quaternions of a rotation, take the one on the side of `b`.
        let from = a.quaternion * a.quaternion.dot(&b.quaternion).signum();
        let to = c.quaternion * c.quaternion.dot(&b.quaternion).signum();
        let off = b.quaternion - from - (to - from) * share;
        // The radial part is that of a chord inside the sphere and no rotation; quaternions see
        // half angles.
        let across = off - b.quaternion * b.quaternion.dot(&off);
        Offset {
            square_m2: off_m.norm_squared(),
            square_rad2: 4.0 * across.norm_squared(),
            noise: ((1.0 + share * share + (1.0 - share) * (1.0 - share)) / 1.5).sqrt(),
            curvature: ((b.time - a.time) * (c.time - b.time)).abs(),
        }
    }

    /// Whether reading `i` is within the limit of the line through `j` and `k`.
    fn is_smooth(&self, j: usize, i: usize, k: usize) -> bool {
        let offset = self.offset(j, i, k);
        let limit_m = self.position.limit(FLOOR_M, &offset);
        let limit_rad = self.orientation.limit(FLOOR_RAD, &offset);
        offset.square_m2 <= limit_m * limit_m && offset.square_rad2 <= limit_rad * limit_rad
    }

    /// Zones around readings that continue neither side, with a margin. Most readings are collinear
    /// with their neighbours, and those at a collision continue one side.
    fn zones(&self) -> Vec<Zone> {
        let count = self.readings.len();
        let is_between = |i: usize| i > 0 && i + 1 < count && self.is_smooth(i - 1, i, i + 1);
        let follows = |i: usize| i > 1 && self.is_smooth(i - 1, i, i - 2);
        let leads = |i: usize| i + 2 < count && self.is_smooth(i + 1, i, i + 2);
        // The middle of three equal outliers is collinear with them, but its neighbours are not.
        let between: Vec<bool> = (0..count).map(is_between).collect();
        let is_clear = |i: usize| {
            between[i.saturating_sub(1)..(i + 2).min(count)]
                .iter()
                .all(|is| *is)
        };
        let mut zones: Vec<Zone> = Vec::new();
        for i in (0..count).filter(|i| !(is_clear(*i) || follows(*i) || leads(*i))) {
            let (begin, end) = (i.saturating_sub(MARGIN), (i + MARGIN + 1).min(count));
            match zones.last_mut() {
                Some(last) if last.end >= begin => last.end = end,
                _ => zones.push(Zone { begin, end }),
            }
        }
        zones
    }

    /// Readings to leave out of a zone at the least cost, last first. Where the zone does not
    /// begin or end with the stream, its first or last two are kept.
    fn left_out(&self, zone: &Zone) -> Vec<usize> {
        let count = zone.end - zone.begin;
        let opens = zone.begin == 0;
        let closes = zone.end == self.readings.len();
        // Least cost up to reading `i` if the one kept before it is `stride` back; and the
        // stride before that one, 0 at the beginning.
        let mut costs = vec![[(u32::MAX, 0_usize); STRIDE_MAX + 1]; count];
        for i in 1..count {
            for stride in 1..=STRIDE_MAX.min(i) {
                let j = i - stride;
                let skipped = DROP_COST * (stride as u32 - 1);
                let is_begin = if opens { j < STRIDE_MAX } else { i == 1 };
                let mut best = if is_begin {
                    (DROP_COST * j as u32 + skipped, 0)
                } else {
                    (u32::MAX, 0)
                };
                for before in 1..=STRIDE_MAX.min(j) {
                    let so_far = costs[j][before].0;
                    if so_far == u32::MAX || so_far + skipped >= best.0 {
                        continue;
                    }
                    let [a, b, c] = [j - before, j, i].map(|index| zone.begin + index);
                    let broken = if self.is_smooth(a, b, c) {
                        0
                    } else {
                        BREAK_COST
                    };
                    if so_far + skipped + broken < best.0 {
                        best = (so_far + skipped + broken, before);
                    }
                }
                costs[i][stride] = best;
            }
        }
        let last = count - 1;
        let ends = (0..count)
            .flat_map(|i| (1..=STRIDE_MAX).map(move |stride| (i, stride)))
            .filter(|(i, stride)| {
                costs[*i][*stride].0 < u32::MAX
                    && if closes {
                        last - i < STRIDE_MAX
                    } else {
                        *i == last && *stride == 1
                    }
            });
        let end =
            ends.min_by_key(|(i, stride)| costs[*i][*stride].0 + DROP_COST * (last - i) as u32);
        let Some((mut i, mut stride)) = end else {
            return Vec::new();
        };
        let mut left_out: Vec<usize> = (i + 1..count).rev().collect();
        while stride > 0 {
            let j = i - stride;
            left_out.extend((j + 1..i).rev());
            stride = costs[i][stride].1;
            i = j;
        }
        left_out.extend((0..i).rev());
        left_out.iter().map(|index| zone.begin + index).collect()
    }

    /// Whether a reading left out continues the two kept before it or the two after it.
    fn continues_a_side(&self, is_left_out: &[bool], index: usize) -> bool {
        let kept = |i: &usize| !is_left_out[*i];
        let mut before = (0..index).rev().filter(kept);
        let mut after = (index + 1..is_left_out.len()).filter(kept);
        let fits = |near: Option<usize>, far: Option<usize>| match (near, far) {
            (Some(near), Some(far)) => self.is_smooth(near, index, far),
            _ => false,
        };
        fits(before.next(), before.next()) || fits(after.next(), after.next())
    }
}

fn lower_quartile(values: &mut [f64]) -> f64 {
    let quarter = values.len() / 4;
    *values.select_nth_unstable_by(quarter, f64::total_cmp).1
}

#[cfg(test)]
mod tests;
