//! The stages of one step of a tree's flow, its end, and the states within it.

use super::flow::Flow;
use super::kinematics::Root;
use super::tangent::coordinates_by_time;

impl Flow<'_> {
    /// Goes to the end of the step.
    pub(super) fn end_step(&mut self) {
        self.compute(self.tableau.b.len());
        self.put(self.tableau.b);
        self.share = 1.0;
    }

    /// The slope at the end of the last step is that at the beginning of this one.
    pub(super) fn keep_end(&mut self) {
        let (size, wide, end) = (self.from.len(), self.changes.len(), self.tableau.b.len());
        self.slopes.copy_within(end * size..(end + 1) * size, 0);
        if self.has_derivatives {
            self.change_slopes
                .copy_within(end * wide..(end + 1) * wide, 0);
        }
        self.stages = 1;
    }

    /// Goes to a share of the step.
    pub(super) fn tell(&mut self, share: f64) {
        self.share = share;
        if share == 0.0 {
            self.state.copy_from_slice(&self.from);
            if self.has_derivatives {
                self.changes.copy_from_slice(&self.from_changes);
            }
            return;
        }
        self.compute(self.tableau.stages());
        let [weights, _] = self.tableau.weights(share);
        self.put(&weights);
    }

    /// How the angular state changes with time now, coordinates before rates: the derivative of what tells it.
    pub(super) fn by_time(&mut self) -> Vec<f64> {
        let size = self.from.len();
        let mut slope = vec![0.0; size];
        if self.share == 0.0 {
            self.compute(1);
            slope.copy_from_slice(&self.slopes[..size]);
        } else {
            let [_, weights] = self.tableau.weights(self.share);
            add(&mut slope, 1.0, &weights, &self.slopes);
        }
        slope
    }

    /// State and changes by weights of the stages.
    fn put(&mut self, weights: &[f64]) {
        combine(
            &self.from,
            self.step_s,
            weights,
            &self.slopes,
            &mut self.state,
        );
        if self.has_derivatives {
            let (from, to) = (&self.from_changes, &mut self.changes);
            combine(from, 1.0, weights, &self.change_slopes, to);
        }
    }

    /// Computes the step's first stages, so many, where they are not.
    fn compute(&mut self, count: usize) {
        let tableau = self.tableau;
        let further = tableau.dense.map_or(&[][..], |dense| dense.a);
        let rows = tableau.a.iter().chain([&tableau.b]).chain(further);
        for (stage, weights) in rows.enumerate().take(count).skip(self.stages) {
            combine(
                &self.from,
                self.step_s,
                weights,
                &self.slopes,
                &mut self.stage,
            );
            if let Some(hand) = &self.tree.hand {
                let share: f64 = weights.iter().sum();
                let since_s = self.begun_s + share * self.step_s;
                let held = hand.anchor(&self.tree.anchor_m, self.start.time_s + since_s);
                self.root = Root::in_hand(&held, &self.gravity_m_s2);
            }
            self.slope(stage);
            if self.has_derivatives {
                let (from, to) = (&self.from_changes, &mut self.stage_changes);
                combine(from, 1.0, weights, &self.change_slopes, to);
                self.change_slope(stage);
            }
        }
        self.stages = self.stages.max(count);
    }

    /// `f(Y)`.
    fn slope(&mut self, stage: usize) {
        let tree = self.tree;
        let (coordinates, rates) = self.stage.split_at(tree.coordinates);
        self.field.evaluate(tree, coordinates, rates, &self.root);
        let size = self.stage.len();
        let slope = &mut self.slopes[stage * size..(stage + 1) * size];
        coordinates_by_time(tree, &self.stage, slope);
        slope[tree.coordinates..].copy_from_slice(&self.field.rates_by_time);
    }

    /// `h f'(Y) δY`.
    fn change_slope(&mut self, stage: usize) {
        let (tree, wide) = (self.tree, self.changes.len());
        let coordinates = &self.stage[..tree.coordinates];
        self.change
            .evaluate(tree, &mut self.field, coordinates, &self.root);
        let slope = &mut self.change_slopes[stage * wide..(stage + 1) * wide];
        self.tangent
            .slope(tree, &self.stage, &self.change, &self.stage_changes, slope);
        for number in slope.iter_mut() {
            *number *= self.step_s;
        }
    }
}

/// `y + h Σ a_j k_j`.
fn combine(from: &[f64], step: f64, weights: &[f64], slopes: &[f64], to: &mut [f64]) {
    to.copy_from_slice(from);
    add(to, step, weights, slopes);
}

fn add(to: &mut [f64], step: f64, weights: &[f64], slopes: &[f64]) {
    for (weight, slope) in weights.iter().zip(slopes.chunks_exact(to.len())) {
        if *weight != 0.0 {
            let weight = step * weight;
            for (sum, number) in to.iter_mut().zip(slope) {
                *sum += weight * number;
            }
        }
    }
}
