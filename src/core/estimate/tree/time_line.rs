//! Acted to physical time: in the paces of an unknown [tempo](super::tempo), or as it is.

use super::problem::TreeProblem;

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
