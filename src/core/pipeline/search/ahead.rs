//! Lower bounds of a search: of single arcs and pairs for the rest of a sequence, and of partial
//! sequences.

use super::lower_bound::{LowerBound, lowest};
use super::{Search, places};
use crate::estimate::{Bound, Part};

impl Search<'_> {
    /// Arcs that begin after `from` open collisions and before the next.
    fn group(&self, from: usize) -> Vec<usize> {
        let open = |index: usize| self.field.open.get(index).map(|(event, _)| *event);
        let least = from.checked_sub(1).and_then(open);
        let most = open(from).unwrap_or(usize::MAX);
        let is_in = |index: &usize| match self.field.segments[*index].start_event {
            Some(start) => least.is_none_or(|least| start >= least) && start < most,
            None => least.is_none(),
        };
        (0..self.field.segments.len()).filter(is_in).collect()
    }

    /// Computes bounds of single arcs and of pairs, and from these the bounds of all arcs after a
    /// node.
    pub(super) fn look_ahead(&mut self) {
        let depth = self.field.open.len();
        let groups: Vec<Vec<usize>> = (0..=depth).map(|from| self.group(from)).collect();
        let singles: Vec<f64> = (0..self.field.segments.len())
            .map(|arc| self.bound(&[], &[arc], false))
            .collect();
        let sum = |arcs: &[usize]| arcs.iter().map(|arc| singles[*arc]).sum::<f64>();
        for index in 0..depth {
            let event = self.field.open[index].0;
            let is_beside = |arc: &usize| {
                let segment = &self.field.segments[*arc];
                segment.end_event == Some(event) || segment.start_event == Some(event)
            };
            let near: Vec<usize> = [&groups[index][..], &groups[index + 1]].concat();
            let arcs: Vec<usize> = (0..self.field.segments.len()).filter(is_beside).collect();
            let others: Vec<usize> = near.iter().copied().filter(|arc| !is_beside(arc)).collect();
            let is_near = arcs.iter().all(|arc| near.contains(arc));
            let candidates = self.field.open[index].1.len();
            let pair = is_near.then(|| {
                let of = |candidate| self.least(&[(index, candidate)], &arcs, false);
                let mut bounds: Vec<LowerBound> = (0..candidates).map(of).collect();
                self.race(&mut bounds);
                let whole = |bound: &LowerBound| bound.cost().max(sum(&arcs)) + sum(&others);
                bounds.iter().map(whole).collect()
            });
            self.pairs.push(pair);
        }
        self.tails = vec![0.0; depth + 2];
        for from in (0..=depth).rev() {
            let alone = sum(&groups[from]) + self.tails[from + 1];
            let pair = self.pairs.get(from).and_then(|pair| pair.as_ref());
            let paired = pair.map_or(0.0, |costs| {
                costs.iter().copied().fold(f64::INFINITY, f64::min) + self.tails[from + 2]
            });
            self.tails[from] = alone.max(paired);
        }
    }

    /// A bound of some arcs with some open collisions known, as places in the list and candidates.
    pub(super) fn least(
        &self,
        known: &[(usize, usize)],
        arcs: &[usize],
        own_priors: bool,
    ) -> LowerBound {
        let guesses = self.field.guesses;
        let mut starts: Vec<(usize, Bound)> = Vec::new();
        for (index, guess) in guesses.iter().enumerate() {
            // Guesses that differ in other arcs only give the same bound.
            let is_same = |(other, _): &(usize, Bound)| {
                let other = &guesses[*other];
                arcs.iter().all(|arc| other.arcs[*arc] == guess.arcs[*arc])
            };
            if !starts.iter().any(is_same) {
                starts.push((index, Bound::default()));
            }
        }
        LowerBound {
            is_begun: false,
            known: known.to_vec(),
            arcs: arcs.to_vec(),
            own_priors,
            starts,
        }
    }

    /// Raises a bound until it is above `ceiling` or cannot be raised.
    pub(super) fn tighten(&mut self, least: &mut LowerBound, ceiling: f64) {
        let scene = self.with(&least.known);
        self.work.bounds += usize::from(!least.is_begun);
        least.is_begun = true;
        loop {
            let (lowest, next) = lowest(&least.starts, |(_, bound)| bound.cost);
            let (guess, bound) = &mut least.starts[lowest];
            if bound.is_done() || bound.cost > ceiling {
                return;
            }
            let part = Part {
                scene: &scene,
                sketch: self.field.sketch,
                segments: self.field.segments,
                arcs: &least.arcs,
                guess: &self.field.guesses[*guess],
                own_priors: least.own_priors,
            };
            let work = bound.tighten(&part, ceiling.min(next), self.recipe);
            self.counters.add(&work);
            let share = least.arcs.len() as f64 / self.field.segments.len() as f64;
            self.iterations += share * work.iterations as f64;
        }
    }

    /// Raises several bounds until the least of them is final and the others are above it; returns
    /// its index.
    pub(super) fn race(&mut self, bounds: &mut [LowerBound]) -> usize {
        loop {
            let (first, next) = lowest(bounds, LowerBound::cost);
            if bounds[first].is_done() {
                return first;
            }
            self.tighten(&mut bounds[first], next);
        }
    }

    /// Bound of the arcs up to the first collision that is still open.
    pub(super) fn prefix(&self, choice: &[usize]) -> LowerBound {
        let arcs: Vec<usize> = (0..=choice.len())
            .flat_map(|from| self.group(from))
            .collect();
        self.least(&places(choice), &arcs, true)
    }

    /// Bound of arcs that no collision ties.
    fn bound(&mut self, known: &[(usize, usize)], arcs: &[usize], own_priors: bool) -> f64 {
        let mut least = self.least(known, arcs, own_priors);
        self.tighten(&mut least, f64::INFINITY);
        least.cost()
    }
}
