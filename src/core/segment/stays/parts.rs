//! What a body does while it stays on a surface: it rests, slides or rolls.
//!
//! It rests where neither velocity nor spin are more than noise. A ball, or the side of a cylinder, rolls where its lowest point
//! does not move, `v + ω × a = 0` with the arm `a` to it, and slides otherwise, as a face does. What friction slows down is slower
//! by the same in the same time: where it has ended is where the line through the speeds before is zero.

use std::ops::Range;

use nalgebra::Vector3;

use super::local::{LocalMotion, LocalMotions, median};
use super::surface::{Footing, NOISE, STILL, Stay};
use crate::motion::{Link, Scene, SeenOnSurface, Timing};
use crate::physics::{OnPlane, Sustained};

/// What rolls has no more slip than this [m/s], or than this share of its speed.
const GRIP_M_S: f64 = 0.02;
const GRIP_SHARE: f64 = 0.06;
/// A part is as long as this \[s\], and of so many moments; what is shorter belongs to the longer of those beside it.
const PART_S: f64 = 0.06;
const PART_MOMENTS: usize = 4;
/// Speeds so long before an end tell when friction ended them \[s\], which is at most so long after the last of them.
const SLOWING_S: f64 = 0.15;
const BEYOND_S: f64 = 0.12;
/// Least share of a speed that is lost in that time, where that tells when it ends.
const LOST: f64 = 0.3;
/// What rests strays by no more than this \[m\], and what is higher than it by more than the other, and this share of its way, is lifted.
const STRAY_M: f64 = 0.003;
const LIFTED_M: f64 = 5e-4;
const LIFTED_SHARE: f64 = 0.1;
/// It begins to move where it is so far from where it rests, and noise \[m\].
const STIRRED_M: f64 = 2e-4;
/// Frictions are within this.
const FRICTION: [f64; 2] = [0.001, 1.5];

/// A part of a stay in which a body moves in one way.
#[derive(Clone, Copy, Debug)]
pub(super) struct StayPart {
    pub(super) on: SeenOnSurface,
    /// When it begins and ends \[s\].
    pub(super) span_s: [f64; 2],
}

struct Slowed<'a> {
    scene: &'a Scene,
    link: &'a Link,
    footing: &'a Footing,
    motions: &'a LocalMotions,
}

/// The parts of a stay, in order.
pub(super) fn parts(
    scene: &Scene,
    link: &Link,
    footing: &Footing,
    motions: &LocalMotions,
    stay: &Stay,
) -> Vec<StayPart> {
    let of = Slowed {
        scene,
        link,
        footing,
        motions,
    };
    let found = of.lying(of.merged(stay.moments.clone()));
    let span_s = of.span_s(&found, stay);
    let mut begin_s = span_s[0];
    let mut parts = Vec::new();
    for (at, (sustained, moments)) in found.iter().enumerate() {
        let end_s = match found.get(at + 1) {
            Some((next, after)) => of.ends_s(*sustained, *next, moments, after),
            None => span_s[1],
        };
        let end_s = end_s.clamp(begin_s, span_s[1].max(begin_s));
        let friction = of.friction(*sustained, moments.clone());
        parts.push(StayPart {
            on: SeenOnSurface {
                sustained: *sustained,
                surface: footing.surface,
                feature: footing.feature,
                friction,
            },
            span_s: [begin_s, end_s],
        });
        begin_s = end_s;
    }
    parts
}

impl Slowed<'_> {
    /// How it moves at a moment.
    fn sustained(&self, of: &LocalMotion) -> Sustained {
        let velocity_m_s = self.footing.along(of.velocity_m_s);
        let (slow_m_s, slow_rad_s) = (
            STILL[0].max(NOISE * self.motions.velocity_sd_m_s),
            STILL[1].max(NOISE * self.motions.spin_sd_rad_s),
        );
        let spin_rad_s = match self.footing.touching {
            OnPlane::Face { .. } => of.spin_rad_s.dot(&self.footing.normal).abs(),
            OnPlane::Ball { .. } | OnPlane::Side { .. } => of.spin_rad_s.norm(),
        };
        if velocity_m_s.norm() <= slow_m_s && spin_rad_s <= slow_rad_s {
            return Sustained::Rest;
        }
        let Some(radius_m) = self.footing.touching.radius_m() else {
            return Sustained::Slide;
        };
        let about = self.footing.along(of.spin_rad_s).norm();
        let fastest_m_s = velocity_m_s.norm().max(radius_m * about);
        let sd_m_s = self
            .motions
            .velocity_sd_m_s
            .hypot(radius_m * self.motions.spin_sd_rad_s);
        let grip_m_s = GRIP_M_S.max(GRIP_SHARE * fastest_m_s).max(NOISE * sd_m_s);
        match self.footing.slip_m_s(of).norm() <= grip_m_s {
            true => Sustained::Roll,
            false => Sustained::Slide,
        }
    }

    /// Stretches of moments in which it moves in one way, without those that are too short.
    fn merged(&self, moments: Range<usize>) -> Vec<(Sustained, Range<usize>)> {
        let each = &self.motions.each;
        let mut runs: Vec<(Sustained, Range<usize>)> = Vec::new();
        for at in moments {
            let of = self.sustained(&each[at]);
            match runs.last_mut() {
                Some((last, run)) if *last == of => run.end = at + 1,
                _ => runs.push((of, at..at + 1)),
            }
        }
        let long_s = |run: &Range<usize>| each[run.end - 1].time_s - each[run.start].time_s;
        loop {
            let is_short = |run: &Range<usize>| long_s(run) < PART_S || run.len() < PART_MOMENTS;
            // Half a window more of a rest with which the samples end is seen.
            let ends_at_rest = |(of, run): &(Sustained, Range<usize>)| {
                *of == Sustained::Rest && run.end == each.len()
            };
            let short = runs
                .iter()
                .enumerate()
                .filter(|(_, of)| is_short(&of.1) && !ends_at_rest(of));
            let shortest = short.min_by(|a, b| long_s(&a.1.1).total_cmp(&long_s(&b.1.1)));
            let Some((at, _)) = shortest.filter(|_| runs.len() > 1) else {
                return runs;
            };
            let beside = [at.checked_sub(1), (at + 1 < runs.len()).then_some(at + 1)];
            let longer = beside.into_iter().flatten();
            let Some(into) =
                longer.max_by(|a, b| long_s(&runs[*a].1).total_cmp(&long_s(&runs[*b].1)))
            else {
                return runs;
            };
            runs[at].0 = runs[into].0;
            let mut joined: Vec<(Sustained, Range<usize>)> = Vec::new();
            for (of, run) in runs {
                match joined.last_mut() {
                    Some((last, whole)) if *last == of => whole.end = run.end,
                    _ => joined.push((of, run)),
                }
            }
            runs = joined;
        }
    }

    /// The parts without those at an end in which it is lifted from where it rests, or put down there: for a moment both are as low
    /// as what slides. What is slow and yet goes far does not rest.
    fn lying(&self, mut runs: Vec<(Sustained, Range<usize>)>) -> Vec<(Sustained, Range<usize>)> {
        let each = &self.motions.each;
        for (of, run) in &mut runs {
            // By its middle half: it may be lifted, or be put down, slowly.
            let quarter = run.len() / 4;
            let [early_m, late_m] = [run.start + quarter, run.end - 1 - quarter]
                .map(|at| each[at].pose.translation.vector);
            let way_m = 2.0 * (late_m - early_m).norm();
            if *of == Sustained::Rest && way_m > STRAY_M + NOISE * self.motions.noise_m {
                *of = match self.footing.touching.radius_m() {
                    Some(_) => Sustained::Roll,
                    None => Sustained::Slide,
                };
            }
        }
        let height_m = |at: usize| {
            let place_m = each[at].pose.translation.vector;
            place_m.dot(&self.footing.normal)
        };
        let rests = runs.iter().filter(|(of, _)| *of == Sustained::Rest);
        let Some((_, rest)) = rests.max_by_key(|(_, run)| run.len()) else {
            return runs;
        };
        let Some(usual_m) = median(rest.clone().map(height_m)) else {
            return runs;
        };
        let reach_m = LIFTED_M.max(NOISE * self.motions.noise_m);
        let is_lifted = |(of, run): &(Sustained, Range<usize>)| {
            let first_m = each[run.start].pose.translation.vector;
            let way_m = (each[run.end - 1].pose.translation.vector - first_m).norm();
            let offs_m = run.clone().map(|at| (height_m(at) - usual_m).abs());
            let most_m = offs_m.fold(0.0, f64::max);
            *of != Sustained::Rest && most_m > reach_m.max(LIFTED_SHARE * way_m)
        };
        if runs.last().is_some_and(is_lifted) {
            runs.pop();
        }
        if runs.first().is_some_and(is_lifted) {
            runs.remove(0);
        }
        runs
    }

    /// When the parts begin and end \[s\]: with the stay, but a rest only where the body is where it rests.
    fn span_s(&self, runs: &[(Sustained, Range<usize>)], stay: &Stay) -> [f64; 2] {
        let motions = self.motions;
        let mut span_s = stay.span_s;
        let (Some(first), Some(last)) = (runs.first(), runs.last()) else {
            return span_s;
        };
        if first.1.start > stay.moments.start {
            span_s[0] = motions.each[first.1.start].time_s;
        }
        if last.1.end < stay.moments.end {
            span_s[1] = motions.each[last.1.end - 1].time_s;
        }
        for (end, (of, run)) in [first, last].into_iter().enumerate() {
            let places = run
                .clone()
                .map(|at| motions.each[at].pose.translation.vector);
            let usual = [0, 1, 2].map(|axis| median(places.clone().map(|of| of[axis])));
            let [Some(x), Some(y), Some(z)] = usual else {
                continue;
            };
            let reach_m = STIRRED_M + NOISE * motions.noise_m;
            let is_there = |at: &usize| {
                let place_m = motions.poses[*at].1.translation.vector;
                (place_m - Vector3::new(x, y, z)).norm() <= reach_m
            };
            let middle_s = motions.each[(run.start + run.end - 1) / 2].time_s;
            let own = motions.within(span_s);
            let middle = motions.within([middle_s, span_s[1]]).start;
            if *of != Sustained::Rest || !own.contains(&middle) {
                continue;
            }
            let outward: Vec<usize> = match end {
                0 => (own.start..middle).rev().collect(),
                _ => (middle..own.end).collect(),
            };
            // One by itself is noise.
            let mut pairs = outward.windows(2);
            if let Some(gone) = pairs.find(|pair| !pair.iter().any(is_there)) {
                span_s[end] = motions.poses[gone[0]].0;
            }
        }
        span_s
    }

    /// What ends where one way to move turns into another [m/s].
    fn ending_m_s(&self, from: Sustained, into: Sustained, of: &LocalMotion) -> Vector3<f64> {
        match (from, into) {
            (Sustained::Slide, Sustained::Roll) => self.footing.slip_m_s(of),
            _ => self.footing.along(of.velocity_m_s),
        }
    }

    /// When one way to move turns into the next \[s\].
    fn ends_s(
        &self,
        from: Sustained,
        into: Sustained,
        before: &Range<usize>,
        after: &Range<usize>,
    ) -> f64 {
        let each = &self.motions.each;
        let last_s = each[before.end - 1].time_s;
        let next_s = each[after.start].time_s;
        let between_s = 0.5 * (last_s + next_s);
        if from >= into {
            return between_s;
        }
        let slowing = before
            .clone()
            .filter(|at| last_s - each[*at].time_s <= SLOWING_S);
        let slowing: Vec<(f64, Vector3<f64>)> = slowing
            .map(|at| {
                (
                    each[at].time_s - last_s,
                    self.ending_m_s(from, into, &each[at]),
                )
            })
            .collect();
        let mean: Vector3<f64> = slowing.iter().map(|(_, of)| of).sum();
        let Some(way) = mean
            .try_normalize(1e-9)
            .filter(|_| slowing.len() >= PART_MOMENTS)
        else {
            return between_s;
        };
        let count = slowing.len() as f64;
        let middle_s = slowing.iter().map(|(at_s, _)| at_s).sum::<f64>() / count;
        let speed_m_s = mean.dot(&way) / count;
        let (mut squares, mut products) = (0.0, 0.0);
        for (at_s, of) in &slowing {
            squares += (at_s - middle_s).powi(2);
            products += (at_s - middle_s) * (of.dot(&way) - speed_m_s);
        }
        let slope_m_s2 = products / squares;
        let lost_m_s = -slope_m_s2 * (last_s - each[before.start].time_s).min(SLOWING_S);
        if !(lost_m_s > LOST * speed_m_s) {
            return between_s;
        }
        let zero_s = last_s + middle_s - speed_m_s / slope_m_s2;
        zero_s.clamp(last_s - BEYOND_S, last_s + BEYOND_S)
    }

    /// Friction of what slides or rolls, by how its velocity changes, where the tempo is known.
    fn friction(&self, sustained: Sustained, moments: Range<usize>) -> Option<f64> {
        if sustained == Sustained::Rest || self.scene.timing != Timing::Known {
            return None;
        }
        let each = &self.motions.each[moments];
        let count = each.len() as f64;
        if each.len() < PART_MOMENTS {
            return None;
        }
        let middle_s = each.iter().map(|of| of.time_s).sum::<f64>() / count;
        let (mut squares, mut products, mut against) = (0.0, Vector3::zeros(), Vector3::zeros());
        for of in each {
            squares += (of.time_s - middle_s).powi(2);
            products += self.footing.along(of.velocity_m_s) * (of.time_s - middle_s);
            let moved = match sustained {
                Sustained::Slide => self.footing.slip_m_s(of),
                Sustained::Roll | Sustained::Rest => self.footing.along(of.velocity_m_s),
            };
            against += moved.try_normalize(1e-9).unwrap_or_default();
        }
        let slowed_m_s2 = products / squares;
        let pull_m_s2 = self.link.body.pull_m_s2(&self.scene.gravity_m_s2);
        let pressed_m_s2 = -pull_m_s2.dot(&self.footing.normal);
        // Of what rolls, its turning takes a share of what gravity gives.
        let share = match (sustained, self.footing.touching) {
            (Sustained::Roll, OnPlane::Ball { radius_m }) => self.share(radius_m, Vector3::x()),
            (Sustained::Roll, OnPlane::Side { radius_m, axis }) => self.share(radius_m, axis),
            _ => 1.0,
        };
        let by_friction = slowed_m_s2 - self.footing.along(pull_m_s2) * share;
        let way = against.try_normalize(1e-9)?;
        let friction = -by_friction.dot(&way) / pressed_m_s2;
        let [least, most] = FRICTION;
        friction.is_finite().then(|| friction.clamp(least, most))
    }

    /// `1 / (1 + I / (m r²))` of what rolls about an axis of the body.
    fn share(&self, radius_m: f64, axis: Vector3<f64>) -> f64 {
        let about_m2 = self.link.body.gyration_m2().component_mul(&axis).dot(&axis);
        1.0 / (1.0 + about_m2 / (radius_m * radius_m))
    }
}
