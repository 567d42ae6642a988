//! The tempo in which a motion of trees is acted, where stamps are no physical times (paper §4.3).
//!
//! Between knots `a_k` of acted time physical time `t` goes on at a steady *pace*, of which the logarithm `λ_k` is an
//! unknown, so that time never runs back:
//!
//! ```text
//! t(a) = t_0 + Σ_{i<k} e^{λ_i} (a_{i+1} − a_i) + e^{λ_k} (a − a_k)
//! ```
//!
//! The prior is that of bodies by themselves ([`crate::estimate::tempo`]), `λ` a Brownian motion of strength `σ`. In
//! these unknowns it is linear, and where nothing is seen yet, the pace goes on as it was:
//!
//! ```text
//! r = (λ_{k+1} − λ_k) / (σ √½(Δa_k + Δa_{k+1}))
//! ```

use super::point::TreePoint;
use super::problem::TreeProblem;
use super::sample::TreeSample;
use crate::motion::{Scene, Timing};

/// Distance of knots \[s, acted\]: within it a hand's tempo hardly changes.
const SPACING_S: f64 = 0.1;
/// Greatest number of pieces between them: in a longer take they are farther apart.
const PIECES_MOST: usize = 64;
/// Distance of samples for which the scene's strength of the prior is \[s, acted\]: of a faster stream it weighs as many
/// times as there are more of them, so that more samples do not make it say less.
const DENSE_S: f64 = 0.0045;

/// Where the pace of a motion may change, and how much it does.
#[derive(Clone, Debug)]
pub struct Tempo {
    /// Knots in order \[s, acted\]: the beginning and the end of the motion, and some between.
    pub knots_s: Vec<f64>,
    /// Standard deviation of the log-pace's change after one acted second.
    pub sd_per_sqrt_s: f64,
    /// First guess of the pace, physical time per acted time.
    pub guess: f64,
}

impl Tempo {
    /// That of a scene with a span \[s, acted\]; `None` where stamps are physical times.
    pub(super) fn of_scene(
        scene: &Scene,
        [from_s, to_s]: [f64; 2],
        samples: &[TreeSample],
    ) -> Option<Self> {
        let Timing::Unknown {
            tempo_sd_per_sqrt_s,
        } = scene.timing
        else {
            return None;
        };
        let lasts_s = to_s - from_s;
        let pieces = ((lasts_s / SPACING_S).ceil() as usize).clamp(1, PIECES_MOST);
        let knot_s = |knot: usize| from_s + lasts_s * knot as f64 / pieces as f64;
        let mut times_s: Vec<f64> = samples.iter().map(|sample| sample.acted_s).collect();
        times_s.dedup();
        let crowd = times_s.len() as f64 * DENSE_S / lasts_s;
        Some(Self {
            knots_s: (0..=pieces).map(knot_s).collect(),
            sd_per_sqrt_s: tempo_sd_per_sqrt_s / crowd.max(1.0).sqrt(),
            guess: 1.0,
        })
    }

    /// Number of its unknowns.
    pub fn pieces(&self) -> usize {
        self.knots_s.len() - 1
    }

    /// Deviation of the difference of the log-paces of a piece and the next.
    pub(super) fn change_sd(&self, piece: usize) -> f64 {
        let knots_s = &self.knots_s;
        self.sd_per_sqrt_s * (0.5 * (knots_s[piece + 2] - knots_s[piece])).sqrt()
    }
}

/// Acted to physical time at a point of a problem.
#[derive(Clone, Debug)]
pub(super) struct TimeLine<'p> {
    /// Beginning and end \[s, acted\].
    span_s: [f64; 2],
    /// Of an unknown tempo: knots \[s, acted\], their physical times \[s\], and the pace after each.
    knots_s: &'p [f64],
    times_s: Vec<f64>,
    paces: Vec<f64>,
}

impl<'p> TimeLine<'p> {
    pub(super) fn new(problem: &'p TreeProblem, log_paces: &[f64]) -> Self {
        let knots_s = problem.tempo.as_ref().map_or(&[][..], |of| &of.knots_s);
        let paces: Vec<f64> = log_paces.iter().map(|log| log.exp()).collect();
        let mut times_s = vec![problem.span_s[0]];
        for (pair, pace) in knots_s.windows(2).zip(&paces) {
            times_s.push(times_s[times_s.len() - 1] + pace * (pair[1] - pair[0]));
        }
        Self {
            span_s: problem.span_s,
            knots_s,
            times_s,
            paces,
        }
    }

    /// Whether paces are unknown.
    pub(super) fn is_unknown(&self) -> bool {
        !self.paces.is_empty()
    }

    /// The piece of an acted time: that before a knot is its, beyond an end the nearest.
    fn piece(&self, acted_s: f64) -> usize {
        let before = self.knots_s.partition_point(|knot_s| *knot_s < acted_s);
        before.clamp(1, self.paces.len()) - 1
    }

    /// Physical time \[s\] of an acted one \[s\].
    pub(super) fn time_s(&self, acted_s: f64) -> f64 {
        if self.paces.is_empty() {
            return acted_s;
        }
        let piece = self.piece(acted_s);
        self.times_s[piece] + self.paces[piece] * (acted_s - self.knots_s[piece])
    }

    /// Acted time \[s\] of a physical one \[s\], with the pace there.
    pub(super) fn acted_s(&self, time_s: f64) -> (f64, f64) {
        if self.paces.is_empty() {
            return (time_s, 1.0);
        }
        let before = self.times_s.partition_point(|knot_s| *knot_s < time_s);
        let piece = before.clamp(1, self.paces.len()) - 1;
        let since_s = (time_s - self.times_s[piece]) / self.paces[piece];
        (self.knots_s[piece] + since_s, self.paces[piece])
    }

    /// Derivatives of the physical time of an acted one \[s\] by the log-paces, of those that move it.
    pub(super) fn by_log_paces(&self, acted_s: f64) -> impl Iterator<Item = f64> + '_ {
        let last = match self.paces.is_empty() {
            true => None,
            false => Some(self.piece(acted_s)),
        };
        let passed =
            (0..last.unwrap_or(0)).map(|piece| self.times_s[piece + 1] - self.times_s[piece]);
        let begun = last.map(|last| self.paces[last] * (acted_s - self.knots_s[last]));
        passed.chain(begun)
    }

    /// Acted time \[s\] of an event within the motion that is at a physical time \[s\], with its derivatives by unknowns.
    pub(super) fn acted_by(
        &self,
        problem: &TreeProblem,
        event: usize,
        time_s: f64,
    ) -> (f64, Vec<(usize, f64)>) {
        let (acted_s, pace) = self.acted_s(time_s);
        let by_paces = self.by_log_paces(acted_s).enumerate();
        let by_paces = by_paces.map(|(piece, by)| (problem.unknown_of_pace(piece), -by / pace));
        let by_time = (problem.unknown_of_event(event), 1.0 / pace);
        (acted_s, [by_time].into_iter().chain(by_paces).collect())
    }

    /// The physical time of an acted one \[s\] as a sum of unknowns with factors, to first order.
    pub(super) fn moment(&self, problem: &TreeProblem, acted_s: f64) -> Vec<(usize, f64)> {
        let by = self.by_log_paces(acted_s).enumerate();
        by.map(|(piece, by)| (problem.unknown_of_pace(piece), by))
            .collect()
    }

    /// Beginning and end of the motion \[s\].
    pub(super) fn physical_span_s(&self) -> [f64; 2] {
        self.span_s.map(|end_s| self.time_s(end_s))
    }
}

impl TreePoint {
    /// Acted to physical time.
    pub(super) fn time_line<'p>(&self, problem: &'p TreeProblem) -> TimeLine<'p> {
        TimeLine::new(problem, &self.log_paces)
    }
}
