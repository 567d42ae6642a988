//! The hidden tempo: which physical time is acted at which acted time.

use rand::Rng;

use super::wander::{TEMPO, Wander};

/// Spacing of the knots in acted time \[s\]; between them the tempo is a cubic.
const STEP_S: f64 = 1e-3;

/// A smooth, strictly increasing map between acted and physical time, 0 to 0.
#[derive(Clone, Debug)]
pub struct Tempo {
    /// Physical time and its rate by acted time at each knot.
    knots: Vec<[f64; 2]>,
    duration_s: f64,
    acted_duration_s: f64,
}

impl Tempo {
    /// A tempo that acts `duration_s` about `slowdown` times slower; the logarithm of its rate
    /// varies smoothly by `variation` (standard deviation).
    pub fn draw(duration_s: f64, slowdown: f64, variation: f64, rng: &mut impl Rng) -> Self {
        let wander = Wander::draw(&TEMPO, rng);
        let rate = |acted_s: f64| (variation * wander.at(acted_s)).exp() / slowdown;
        let mut knots = vec![[0.0, rate(0.0)]];
        let (mut physical_s, mut last) = (0.0, rate(0.0));
        while physical_s < duration_s {
            let acted_s = (knots.len() - 1) as f64 * STEP_S;
            let (middle, next) = (rate(acted_s + 0.5 * STEP_S), rate(acted_s + STEP_S));
            physical_s += (last + 4.0 * middle + next) * (STEP_S / 6.0);
            knots.push([physical_s, next]);
            last = next;
        }
        let mut tempo = Self {
            knots,
            duration_s,
            acted_duration_s: 0.0,
        };
        tempo.acted_duration_s = tempo.acted_s(duration_s);
        tempo
    }

    /// Acted time at the end \[s\].
    pub fn acted_duration_s(&self) -> f64 {
        self.acted_duration_s
    }

    /// Physical time acted at `acted_s`; the performer holds still before the start and after
    /// the end.
    pub fn physical_s(&self, acted_s: f64) -> f64 {
        if acted_s <= 0.0 {
            return 0.0;
        }
        if acted_s >= self.acted_duration_s && self.acted_duration_s > 0.0 {
            return self.duration_s;
        }
        let knot = self.knot_before(acted_s);
        self.within(knot, acted_s / STEP_S - knot as f64)
    }

    /// Physical seconds per acted second, at an acted time within the motion.
    pub fn rate(&self, acted_s: f64) -> f64 {
        let knot = self.knot_before(acted_s);
        let x = acted_s / STEP_S - knot as f64;
        let (rise, [a, b]) = self.cubic(knot);
        (rise + (1.0 - 2.0 * x) * (a * (1.0 - x) - b * x) - x * (1.0 - x) * (a + b)) / STEP_S
    }

    fn knot_before(&self, acted_s: f64) -> usize {
        ((acted_s / STEP_S) as usize).min(self.knots.len() - 2)
    }

    /// Acted time at which the motion's `physical_s` is acted, within the motion: bisection, to
    /// rounding.
    pub fn acted_s(&self, physical_s: f64) -> f64 {
        let physical_s = physical_s.clamp(0.0, self.duration_s);
        let after = self.knots.partition_point(|knot| knot[0] < physical_s);
        let Some(knot) = after.checked_sub(1) else {
            return 0.0;
        };
        let (mut low, mut high) = (0.0_f64, 1.0_f64);
        loop {
            let middle = 0.5 * (low + high);
            if middle <= low || middle >= high {
                return (knot as f64 + high) * STEP_S;
            }
            if self.within(knot, middle) < physical_s {
                low = middle;
            } else {
                high = middle;
            }
        }
    }

    /// Hermite's cubic after a knot, at a fraction of the step.
    fn within(&self, knot: usize, x: f64) -> f64 {
        let (rise, [a, b]) = self.cubic(knot);
        self.knots[knot][0] + x * rise + x * (1.0 - x) * (a * (1.0 - x) - b * x)
    }

    /// How far it rises in the step, and how much more it would at the slopes of its ends.
    fn cubic(&self, knot: usize) -> (f64, [f64; 2]) {
        let ([from, slope_from], [to, slope_to]) = (self.knots[knot], self.knots[knot + 1]);
        let rise = to - from;
        (rise, [slope_from * STEP_S - rise, slope_to * STEP_S - rise])
    }
}
