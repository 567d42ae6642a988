//! Order of samples whose times `t` are not known, among themselves and within their flight (paper
//! eq. 7):
//!
//! ```text
//! t_{i+1} − t_i ≥ 0,   t_first − τ_begin ≥ 0,   τ_end − t_last ≥ 0
//! ```
//!
//! With `t = (1 + r)(s + u − s_0) + s_0 + o` of the stamp `s`, what is added to it `u`, and the clock's
//! rate `r` and offset `o`, of which several may be free. Between samples of one track the clock does
//! not matter: the first row is that of `s + u`.

use super::kind::{At, Constraint, Filled};
use crate::estimate::problem::influence::Influence;
use crate::estimate::problem::{ArcSample, Beside, Problem, SampleOrder, unit};
use crate::estimate::unknowns::layout::Layout;
use crate::optimise::block::{Block, BlockPattern};

impl Constraint for SampleOrder {
    fn patterns(&self, problem: &Problem, layout: &Layout) -> [BlockPattern; 2] {
        let columns = self.columns(problem, layout);
        [BlockPattern::dense(1, columns), BlockPattern::default()]
    }

    fn fill(&self, at: &mut At, [(pattern, block), _]: [Filled; 2]) {
        let (problem, point) = (at.problem, at.point);
        let stamped_s = |of: &ArcSample| of.stamped_s(&point.node_times_s, &point.parameters);
        let time_s = || problem.sample_time_s(self.arc, self.track, &self.sample, point);
        let value_s = match &self.beside {
            Beside::Next(next) => stamped_s(next) - stamped_s(&self.sample),
            Beside::Begin(event) => time_s() - point.event_times_s[*event],
            Beside::End(event) => point.event_times_s[*event] - time_s(),
        };
        block.reset(pattern);
        block.values[0] = value_s / unit::TIME_S;
        block.bounds[0] = (0.0, f64::INFINITY);
        let zero_s = point.node_times_s.first().copied().unwrap_or(0.0);
        let since_s = stamped_s(&self.sample) - zero_s;
        let by = self.derivatives(problem, &point.parameters, since_s);
        for (entry, by) in block.derivatives_mut(pattern, 0).iter_mut().zip(by) {
            *entry = by / unit::TIME_S;
        }
    }

    fn places(&self, _: &Block) -> Vec<std::ops::Range<usize>> {
        Vec::new()
    }

    fn is_curved(&self) -> bool {
        false
    }

    fn time_gap_s(&self, rows: &Block) -> f64 {
        rows.violation(0).abs() * unit::TIME_S
    }
}

impl SampleOrder {
    /// Parameters of the clock on which the sample is, and how they act.
    fn clock<'p>(&self, problem: &'p Problem) -> impl Iterator<Item = (usize, Influence)> + 'p {
        let track = self.track;
        let acting = problem.arcs[self.arc].acting.iter();
        let own = acting.filter(move |acting| acting.track == Some(track));
        own.filter_map(|acting| {
            let is_of_clock = matches!(
                acting.influence,
                Influence::ClockRate | Influence::ClockOffset
            );
            is_of_clock.then_some((acting.parameter, acting.influence))
        })
    }

    /// The unknowns, in the order of [`SampleOrder::derivatives`].
    fn columns(&self, problem: &Problem, layout: &Layout) -> Vec<usize> {
        let parameter = |index: usize| layout.parameters[index];
        let own = self.sample.open.map(parameter);
        match &self.beside {
            Beside::Next(next) => [own, next.open.map(parameter)]
                .into_iter()
                .flatten()
                .collect(),
            Beside::Begin(event) | Beside::End(event) => {
                let clock = self.clock(problem).map(|(index, _)| parameter(index));
                let both = [own, layout.events[*event]].into_iter().flatten();
                both.chain(clock).collect()
            }
        }
    }

    /// Derivatives of the row in seconds; `since_s` is the stamped time since the zero of the clock.
    fn derivatives(&self, problem: &Problem, parameters: &[f64], since_s: f64) -> Vec<f64> {
        let (sign, event) = match &self.beside {
            Beside::Next(next) => {
                let both = [self.sample.open.map(|_| -1.0), next.open.map(|_| 1.0)];
                return both.into_iter().flatten().collect();
            }
            Beside::Begin(event) => (1.0, *event),
            Beside::End(event) => (-1.0, *event),
        };
        let clock = || self.clock(problem);
        let rate = clock().find(|(_, how)| *how == Influence::ClockRate);
        let rate = rate.map_or(0.0, |(index, _)| parameters[index]);
        let own = self.sample.open.map(|_| sign * (1.0 + rate));
        let event = problem.event_is_free[event].then_some(-sign);
        let by_clock = clock().map(|(_, how)| match how {
            Influence::ClockRate => sign * since_s,
            _ => sign,
        });
        [own, event].into_iter().flatten().chain(by_clock).collect()
    }
}
