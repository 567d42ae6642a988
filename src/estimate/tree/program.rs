//! Residuals of samples, rows of goals and of continuity, with all derivatives, as a program for the
//! [optimiser](crate::optimise).
//!
//! With `Φ = ∂x(t)/∂x(t_k)` of the flow from a node, `L = ∂(link)/∂x` of a link's state and `y` of a quantity,
//! a row `y(link(x(t)))` has the derivative `y_link L Φ` by the node's unknowns. The flow to the next node must end
//! there: `x(t_{k+1}) ⊟ x_{k+1} = 0`.

use nalgebra::{DMatrix, DVector, Matrix3xX, Vector3};

use super::problem::{RATE_SD_RAD_S, TreeGoal, TreeProblem, TreeSample};
use crate::estimate::constraint::quantity::{self, Valued};
use crate::estimate::constraint::within::{self, WithinRow};
use crate::estimate::problem::unit;
use crate::motion::GoalQuantity;
use crate::optimise::block::{Block, BlockPattern};
use crate::optimise::envelope::{Envelope, Pattern};
use crate::optimise::{Program, Structure, System};
use crate::physics::State;
use crate::physics::tree::{Flow, Snapshot, TreeState, tableau};

/// Weight of a squared radian, metre or their rates that holds what nothing else does where it began, per
/// information: next to nothing.
const CALM: f64 = 1e-8;
/// Typical changes of coordinates and of rates, in radians, metres and seconds.
const LENGTHS: [f64; 2] = [0.3, 3.0];
/// Step of the differences that give second derivatives.
const STEP: f64 = 1e-6;

/// What of a problem counts.
#[derive(Clone, Debug)]
pub struct Part {
    /// Samples and goals later than this do not \[s\].
    pub until_s: f64,
    /// Standard deviation of the rates at the start [rad/s].
    pub rate_sd_rad_s: f64,
}

impl Part {
    /// All.
    pub fn whole() -> Self {
        Self {
            until_s: f64::INFINITY,
            rate_sd_rad_s: RATE_SD_RAD_S,
        }
    }
}

/// States at the nodes.
pub type Nodes = Vec<TreeState>;

/// A problem for the optimiser.
pub struct TreeProgram<'a> {
    problem: &'a TreeProblem,
    structure: Structure,
    /// Where what nothing determines stays.
    calm: Nodes,
}

/// What one part of the motion, from a node to the next, adds up.
struct Sums {
    cost: f64,
    gradient: DVector<f64>,
    hessian: DMatrix<f64>,
}

impl<'a> TreeProgram<'a> {
    /// The program of a problem; what nothing determines stays where it is in `calm`.
    pub fn new(problem: &'a TreeProblem, calm: Nodes) -> Self {
        let (width, nodes) = (problem.width(), problem.nodes_s.len());
        let of = |node: usize| node * width..(node + 1) * width;
        let mut blocks: Vec<BlockPattern> = Vec::new();
        for goal in &problem.goals {
            let node = problem.node_of(goal.time_s);
            blocks.push(BlockPattern::dense(goal.row_count(), of(node).collect()));
        }
        for node in 1..nodes {
            let columns = of(node - 1).chain(of(node)).collect();
            blocks.push(BlockPattern::dense(width, columns));
        }
        let couplings = (0..nodes * width).flat_map(|row| {
            let first = (row / width).saturating_sub(1) * width;
            (first..=row).map(move |column| (row, column))
        });
        let pattern = Pattern::new(nodes * width, couplings);
        Self {
            structure: Structure {
                pattern,
                priced: blocks.iter().map(|_| BlockPattern::default()).collect(),
                blocks,
            },
            problem,
            calm,
        }
    }

    /// Hessian of a part's cost.
    pub(super) fn information_at(&self, part: &Part, nodes: &Nodes) -> DMatrix<f64> {
        let system = self.evaluated(part, nodes);
        let pattern = &self.structure.pattern;
        DMatrix::from_fn(pattern.size(), pattern.size(), |row, column| {
            system
                .hessian
                .get(pattern, row.max(column), row.min(column))
        })
    }

    /// Directions that rows leave free which act: a column each, orthonormal.
    pub(super) fn free_directions(&self, system: &System) -> DMatrix<f64> {
        /// Share of the largest eigenvalue of `JᵀJ` below which nothing holds a direction.
        const FREE: f64 = 1e-14;
        let size = self.structure.size();
        let mut square = DMatrix::zeros(size, size);
        for (pattern, block) in self.structure.blocks.iter().zip(&system.blocks) {
            for row in (0..block.values.len()).filter(|row| block.acts(*row)) {
                let entries = block.derivatives(pattern, row);
                let mut whole = DVector::zeros(size);
                for (at, entry) in pattern.unknowns(row).iter().zip(entries) {
                    whole[*at] = *entry;
                }
                square.ger(1.0, &whole, &whole, 1.0);
            }
        }
        let eigen = square.symmetric_eigen();
        let largest = eigen.eigenvalues.max();
        let is_free = |at: &usize| eigen.eigenvalues[*at] <= FREE * largest;
        let free = (0..size)
            .filter(is_free)
            .map(|at| eigen.eigenvectors.column(at));
        let free: Vec<_> = free.collect();
        if free.is_empty() {
            return DMatrix::zeros(size, 0);
        }
        DMatrix::from_columns(&free)
    }

    /// Evaluates the motion from a node to the next.
    fn leg(&self, node: usize, part: &Part, nodes: &Nodes, blocks: &mut [Block]) -> Sums {
        let problem = self.problem;
        let tree = &problem.tree;
        let width = problem.width();
        let [from_s, to_s] = problem.leg_s(node);
        let is_last = node + 1 == nodes.len();
        let mut flow = Flow::new(tree, &problem.gravity_m_s2, tableau::DORMAND_PRINCE);
        flow.begin(&nodes[node], true);
        let mut snapshot = Snapshot::new(tree, &problem.gravity_m_s2);
        let mut jacobian = DMatrix::zeros(width, width + 1);
        let mut links: Vec<Option<(State, DMatrix<f64>)>> = vec![None; tree.link_count()];
        let mut sums = Sums {
            cost: 0.0,
            gradient: DVector::zeros(width),
            hessian: DMatrix::zeros(width, width),
        };
        let is_here = |time_s: f64| problem.node_of(time_s) == node;
        let samples = problem.samples.iter().filter(|of| is_here(of.time_s));
        let goals = problem
            .goals
            .iter()
            .enumerate()
            .filter(|(_, of)| is_here(of.time_s));
        let mut items: Vec<(f64, Item)> = samples.map(|of| (of.time_s, Item::Sample(of))).collect();
        items.extend(goals.map(|(index, of)| (of.time_s, Item::Goal(index, of))));
        if !is_last {
            items.push((to_s, Item::Next));
        }
        items.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut now_s = from_s;
        let mut is_placed = false;
        for (time_s, item) in items {
            if time_s > part.until_s {
                if let Item::Goal(index, _) = item {
                    silence(&self.structure.blocks[index], &mut blocks[index]);
                }
                continue;
            }
            if time_s > now_s || !is_placed {
                if time_s > now_s {
                    flow.advance(time_s - now_s, problem.steps(time_s - now_s), 0.0);
                }
                (now_s, is_placed) = (time_s, true);
                snapshot.set(&flow.state());
                flow.jacobian(&mut jacobian);
                links.fill(None);
            }
            match item {
                Item::Sample(sample) => {
                    let [link] = states([sample.place], (&snapshot, &mut links), width);
                    let valued = quantity::valued(&sample.quantity, &link.0, None, &sample.point_m);
                    let by = chained(&valued, &[link], &jacobian);
                    sums.add(sample, &valued, &by);
                }
                Item::Goal(index, goal) => {
                    let state = flow.state();
                    let (value, by) = self.asked(goal, &state, (&snapshot, &mut links), &jacobian);
                    let rows = goal.rows(&value);
                    let (pattern, block) = (&self.structure.blocks[index], &mut blocks[index]);
                    block.reset(pattern);
                    for (row, of) in rows.iter().enumerate() {
                        put(goal, row, of, &by, (pattern, &mut *block));
                    }
                }
                Item::Next => {
                    let at = problem.goals.len() + node;
                    let (pattern, block) = (&self.structure.blocks[at], &mut blocks[at]);
                    join(
                        problem,
                        (&flow.state(), &nodes[node + 1]),
                        &jacobian,
                        (pattern, block),
                    );
                }
            }
        }
        sums
    }

    /// A goal's quantity with its derivative by the node.
    fn asked(
        &self,
        goal: &TreeGoal,
        state: &TreeState,
        (snapshot, links): (&Snapshot, &mut [Option<(State, DMatrix<f64>)>]),
        jacobian: &DMatrix<f64>,
    ) -> (Vector3<f64>, Matrix3xX<f64>) {
        let width = self.problem.width();
        let quantity = &goal.condition.quantity;
        if let GoalQuantity::Angles { count } = quantity {
            let angles = self.problem.tree.angles_of(goal.places[0]);
            let [columns, coordinates] = angles.expect("asked of a pin or a universal joint");
            let mut value = Vector3::zeros();
            let mut by = Matrix3xX::zeros(width);
            for axis in 0..*count {
                value[axis] = state.coordinates[coordinates.start + axis];
                let row = jacobian.row(columns.start + axis);
                by.row_mut(axis).copy_from(&row.columns(0, width));
            }
            return (value, by);
        }
        let [own, other] = states(goal.places, (snapshot, links), width);
        let other_state = quantity.seen_from().map(|_| &other.0);
        let valued = quantity::valued(quantity, &own.0, other_state, &goal.point_m);
        let by = chained(&valued, &[own, other], jacobian);
        (valued.value, by)
    }

    /// What holds rates of the start, and what nothing else does.
    fn calm(&self, part: &Part, nodes: &Nodes, system: &mut System) {
        let problem = self.problem;
        let (width, freedoms) = (problem.width(), problem.tree.freedoms());
        let flight = width / 2 - problem.tree.angular_freedoms();
        for (node, (state, calm)) in nodes.iter().zip(&self.calm).enumerate() {
            let off = problem.tree.minus(state, calm);
            for (at, off) in off.into_iter().enumerate() {
                let is_rate = node == 0 && at >= freedoms + flight;
                let (off, weight) = if is_rate {
                    (state.rates[at - freedoms], part.rate_sd_rad_s.powi(-2))
                } else {
                    (off, CALM * problem.information.0)
                };
                let row = node * width + at;
                system.cost += 0.5 * weight * off * off;
                system.gradient[row] += weight * off;
                system
                    .hessian
                    .add(&self.structure.pattern, row, row, weight);
            }
        }
    }
}

/// What happens at a time.
enum Item<'a> {
    Sample(&'a TreeSample),
    Goal(usize, &'a TreeGoal),
    /// The next node.
    Next,
}

/// States of links with their derivatives by the tree's state, each computed once per time.
fn states<'l, const N: usize>(
    places: [usize; N],
    (snapshot, links): (&Snapshot, &'l mut [Option<(State, DMatrix<f64>)>]),
    width: usize,
) -> [&'l (State, DMatrix<f64>); N] {
    for place in places {
        links[place].get_or_insert_with(|| {
            let mut by = DMatrix::zeros(crate::physics::state::DIMENSION, width);
            snapshot.link_jacobian(place, &mut by);
            (snapshot.link_state(place), by)
        });
    }
    places.map(|place| links[place].as_ref().expect("just computed"))
}

/// `y_link L Φ`.
fn chained(
    valued: &Valued,
    links: &[&(State, DMatrix<f64>)],
    jacobian: &DMatrix<f64>,
) -> Matrix3xX<f64> {
    let width = jacobian.nrows();
    let mut by = Matrix3xX::zeros(width);
    for (by_link, (_, link)) in valued.by.iter().zip(links) {
        by += by_link * link;
    }
    by * jacobian.columns(0, width)
}

impl Sums {
    fn add(&mut self, sample: &TreeSample, valued: &Valued, by: &Matrix3xX<f64>) {
        let per_unit = 1.0 / sample.unit;
        let residual = (valued.value - sample.seen) * per_unit;
        let by = by * per_unit;
        self.cost += 0.5 * residual.norm_squared();
        self.gradient.gemv_tr(1.0, &by, &residual, 1.0);
        self.hessian.gemm_tr(1.0, &by, &by, 1.0);
    }
}

impl TreeGoal {
    fn rows(&self, value: &Vector3<f64>) -> Vec<WithinRow> {
        let set = &self.condition.set;
        if self.axes.is_empty() {
            return vec![within::single(set, value)];
        }
        let axes = self.axes.iter();
        axes.map(|axis| within::along(set, value, *axis)).collect()
    }
}

fn put(
    goal: &TreeGoal,
    row: usize,
    of: &WithinRow,
    by: &Matrix3xX<f64>,
    (pattern, block): (&BlockPattern, &mut Block),
) {
    let unit = goal.unit();
    block.values[row] = of.value / unit;
    block.bounds[row] = (of.bounds.0 / unit, of.bounds.1 / unit);
    let chained = by.tr_mul(&of.by) / unit;
    let entries = block.derivatives_mut(pattern, row);
    entries.copy_from_slice(chained.as_slice());
}

/// A goal that does not count yet: it holds, whatever moves.
fn silence(pattern: &BlockPattern, block: &mut Block) {
    block.reset(pattern);
    block.values.fill(0.0);
    for row in 0..block.values.len() {
        block.derivatives_mut(pattern, row).fill(0.0);
    }
}

/// `x(t) ⊟ x_next`, with its derivatives by both nodes.
fn join(
    problem: &TreeProblem,
    (reached, next): (&TreeState, &TreeState),
    jacobian: &DMatrix<f64>,
    (pattern, block): (&BlockPattern, &mut Block),
) {
    let (tree, width) = (&problem.tree, problem.width());
    let off = tree.minus(reached, next);
    let turned = tree.minus_jacobians(reached, next);
    block.reset(pattern);
    for row in 0..width {
        let unit = problem.unit_of(row);
        block.values[row] = off[row] / unit;
        let entries = block.derivatives_mut(pattern, row);
        let (before, after) = entries.split_at_mut(width);
        for column in 0..width {
            let along = turned[0].row(row).transpose();
            before[column] = along.dot(&jacobian.column(column)) / unit;
            after[column] = turned[1][(row, column)] / unit;
        }
    }
}

impl Program for TreeProgram<'_> {
    type Point = Nodes;
    type Guidance = Part;

    fn structure(&self) -> &Structure {
        &self.structure
    }

    fn evaluate(&self, part: &Part, nodes: &Nodes, system: &mut System) {
        let width = self.problem.width();
        system.cost = 0.0;
        system.gradient.fill(0.0);
        system.hessian.clear();
        for node in 0..nodes.len() {
            let sums = self.leg(node, part, nodes, &mut system.blocks);
            system.cost += sums.cost;
            let first = node * width;
            for row in 0..width {
                system.gradient[first + row] += sums.gradient[row];
                for column in 0..=row {
                    let entry = sums.hessian[(row, column)];
                    let pattern = &self.structure.pattern;
                    system
                        .hessian
                        .add(pattern, first + row, first + column, entry);
                }
            }
        }
        self.calm(part, nodes, system);
    }

    fn retract(&self, from: &Nodes, step: &DVector<f64>, to: &mut Nodes) {
        let tree = &self.problem.tree;
        let steps = step.as_slice().chunks_exact(self.problem.width());
        for ((from, step), to) in from.iter().zip(steps).zip(to) {
            *to = tree.retract(from, step);
        }
    }

    fn damping(&self) -> DVector<f64> {
        let (width, freedoms) = (self.problem.width(), self.problem.tree.freedoms());
        let weight = |length: f64| 10.0 * self.problem.information.0 / (length * length);
        DVector::from_fn(width * self.problem.nodes_s.len(), |at, _| {
            weight(LENGTHS[usize::from(at % width >= freedoms)])
        })
    }

    fn is_curved(&self) -> bool {
        true
    }

    fn information(&self) -> (f64, f64) {
        self.problem.information
    }

    /// By differences of the Lagrangian's gradient: the flow's second derivatives are nowhere else.
    fn add_curvature(
        &self,
        (nodes, system): (&Nodes, &System),
        multipliers: &[f64],
        hessian: &mut Envelope,
    ) {
        let size = self.structure.size();
        let part = Part::whole();
        let slope = |system: &System| {
            let mut gradient = system.gradient.clone();
            system.add_pull(&self.structure, |row| multipliers[row], &mut gradient);
            gradient
        };
        let mut curved = DMatrix::zeros(size, size);
        let mut moved = nodes.clone();
        let mut there = System::new(&self.structure);
        for column in 0..size {
            let mut step = DVector::zeros(size);
            let mut of_side = |by: f64| {
                step[column] = by;
                self.retract(nodes, &step, &mut moved);
                self.evaluate(&part, &moved, &mut there);
                slope(&there)
            };
            let difference = (of_side(STEP) - of_side(-STEP)) / (2.0 * STEP);
            curved.set_column(column, &difference);
        }
        let pattern = &self.structure.pattern;
        let width = self.problem.width();
        for row in 0..size {
            let first = (row / width).saturating_sub(1) * width;
            for column in first..=row {
                let exact = 0.5 * (curved[(row, column)] + curved[(column, row)]);
                let given = system.hessian.get(pattern, row, column);
                hessian.add(pattern, row, column, exact - given);
            }
        }
    }
}

impl TreeProblem {
    /// The node from which the motion reaches a time.
    pub fn node_of(&self, time_s: f64) -> usize {
        let after = self.nodes_s.partition_point(|node_s| *node_s <= time_s);
        after.max(1) - 1
    }

    /// Beginning and end of the motion from a node to the next \[s\].
    pub fn leg_s(&self, node: usize) -> [f64; 2] {
        let to_s = self.nodes_s.get(node + 1).copied();
        [self.nodes_s[node], to_s.unwrap_or(self.span_s[1])]
    }

    /// Number of steps of the integrator for an interval.
    pub fn steps(&self, interval_s: f64) -> usize {
        ((interval_s / self.step_s).ceil() as usize).max(1)
    }

    /// One unit of a number of a tangent.
    pub fn unit_of(&self, at: usize) -> f64 {
        let freedoms = self.tree.freedoms();
        let flight = freedoms - self.tree.angular_freedoms();
        match (at / freedoms, at % freedoms < flight) {
            (0, true) => unit::POSITION_M,
            (0, false) => unit::ORIENTATION_RAD,
            (_, true) => unit::VELOCITY_M_S,
            (_, false) => unit::ANGULAR_VELOCITY_RAD_S,
        }
    }
}
