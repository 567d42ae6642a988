//! Where the motion is cut into intervals, and how far it is followed at a time: by how errors grow along it.
//!
//! With `Φ` the flow's derivative and `S` typical changes of coordinates and rates, an error has grown by
//!
//! ```text
//! γ = ‖S⁻¹ Φ S‖ / ‖1‖      (Frobenius)
//! ```
//!
//! Unknown states at nodes keep it small on each interval (multiple shooting: Bock and Plitt, IFAC World Congress, 1984). A
//! motion of which errors grow less needs the one at its beginning alone.

use nalgebra::DMatrix;

use super::point::TreePoint;
use super::problem::TreeProblem;
use super::program::LENGTHS;
use super::time_line::TimeLine;
use super::trajectory::Trajectory;
use crate::physics::tree::TreeState;

/// Errors may grow by so much on an interval,
const ON_AN_INTERVAL: f64 = 300.0;
/// and by so much on what is added to the part of the sketch that counts.
const FURTHER: f64 = 30.0;
/// Samples that are added at least,
const LEAST_FURTHER: usize = 4;
/// and that an interval has: where errors grow faster a joint whirls, which no node mends.
const LEAST_ON_AN_INTERVAL: usize = 12;

impl TreeProblem {
    /// The last sample's stamp, not after `to_s`, to which the motion is followed from `from_s` before errors grow too
    /// much \[s\]; a share of the samples on that way.
    pub(super) fn followed_s(&self, point: &TreePoint, from_s: f64, to_s: f64, share: f64) -> f64 {
        let between = |time_s: &f64| (from_s..to_s).contains(time_s);
        let times_s: Vec<f64> = self.sample_stamps_s().into_iter().filter(between).collect();
        if times_s.len() <= LEAST_FURTHER {
            return to_s;
        }
        let state = self.state_at(point, from_s);
        let this = &*self.as_told(point);
        let line = &point.time_line(this);
        let mut errors = GrowingErrors::new(this, line, point, &state, line.time_s(from_s));
        let too_far = times_s
            .iter()
            .position(|time_s| errors.continued(line.time_s(*time_s)) > FURTHER);
        let count = too_far.unwrap_or(times_s.len()) as f64 * share;
        match times_s.get((count as usize).max(LEAST_FURTHER)) {
            Some(until_s) => *until_s,
            None => to_s,
        }
    }

    /// The problem and its point with further nodes, so that errors do not grow too much on any interval until a time \[s\].
    pub(super) fn cut(mut self, mut point: TreePoint, until_s: f64) -> (Self, TreePoint) {
        while let Some((node_s, state)) = self.next_node(&point, until_s) {
            self.nodes_s.push(node_s);
            point.nodes.push(state);
        }
        (self, point)
    }

    /// The problem and its point with those of some further nodes that are not after a time \[s\].
    pub(super) fn cut_at(
        mut self,
        nodes_s: &[f64],
        mut point: TreePoint,
        until_s: f64,
    ) -> (Self, TreePoint) {
        let last_s = self.nodes_s[self.nodes_s.len() - 1];
        let is_next = |node_s: &&f64| **node_s > last_s && **node_s <= until_s;
        for node_s in nodes_s.iter().filter(is_next) {
            let state = self.state_at(&point, *node_s);
            self.nodes_s.push(*node_s);
            point.nodes.push(state);
        }
        (self, point)
    }

    /// Where the last interval has to end, and the state there.
    fn next_node(&self, point: &TreePoint, until_s: f64) -> Option<(f64, TreeState)> {
        let (from_s, from) = (*self.nodes_s.last()?, point.nodes.last()?);
        let after = |time_s: &f64| *time_s > from_s && *time_s <= until_s;
        let times_s: Vec<f64> = self.sample_stamps_s().into_iter().filter(after).collect();
        let this = &*self.as_told(point);
        let line = &point.time_line(this);
        let mut errors = GrowingErrors::new(this, line, point, from, line.time_s(from_s));
        let at = times_s
            .iter()
            .position(|time_s| errors.continued(line.time_s(*time_s)) > ON_AN_INTERVAL)?;
        (at >= LEAST_ON_AN_INTERVAL)
            .then(|| (times_s[at - 1], self.state_at(point, times_s[at - 1])))
    }

    /// By how much errors grow from the first node to the end.
    pub(super) fn errors_grown(&self, point: &TreePoint) -> f64 {
        let this = &*self.as_told(point);
        let line = &point.time_line(this);
        let [from_s, to_s] = line.physical_span_s();
        let mut errors = GrowingErrors::new(this, line, point, &point.nodes[0], from_s);
        errors.continued(to_s)
    }

    /// Stamps of samples \[s\], each once.
    pub(super) fn sample_stamps_s(&self) -> Vec<f64> {
        let mut times_s: Vec<f64> = self.samples.iter().map(|sample| sample.acted_s).collect();
        times_s.dedup();
        times_s
    }

    /// The state at a stamp \[s\], from the node before it.
    pub(super) fn state_at(&self, point: &TreePoint, time_s: f64) -> TreeState {
        let node = self.node_of(time_s);
        let this = &*self.as_told(point);
        let line = &point.time_line(this);
        let [from_s, to_s] = [self.nodes_s[node], time_s].map(|of| line.time_s(of));
        let mut trajectory = Trajectory::plain(this, line, &point.nodes[node], from_s);
        this.follow(point, from_s, to_s, &mut trajectory);
        trajectory.state()
    }
}

/// Errors on the way from a state.
struct GrowingErrors<'p> {
    problem: &'p TreeProblem,
    point: &'p TreePoint,
    trajectory: Trajectory<'p>,
    now_s: f64,
}

impl<'p> GrowingErrors<'p> {
    fn new(
        problem: &'p TreeProblem,
        line: &'p TimeLine<'p>,
        point: &'p TreePoint,
        state: &TreeState,
        from_s: f64,
    ) -> Self {
        Self {
            problem,
            point,
            trajectory: Trajectory::of_state(problem, line, state, from_s),
            now_s: from_s,
        }
    }

    /// By how much they have grown at a later physical time \[s\]; no number where the motion is none.
    fn continued(&mut self, time_s: f64) -> f64 {
        self.problem
            .follow(self.point, self.now_s, time_s, &mut self.trajectory);
        self.now_s = time_s;
        let jacobian = self.trajectory.jacobian();
        let freedoms = self.problem.forest.freedoms();
        let length = |at: usize| LENGTHS[usize::from(at >= freedoms)];
        let scaled = DMatrix::from_fn(jacobian.nrows(), jacobian.ncols(), |row, column| {
            jacobian[(row, column)] * length(column) / length(row)
        });
        scaled.norm() / (scaled.ncols() as f64).sqrt()
    }
}
