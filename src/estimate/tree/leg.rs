//! One leg of the motion, from a node to the next: residuals of its samples, rows of its goals, and how it joins
//! the next, with all derivatives.
//!
//! With `Φ = ∂x(t)/∂x(t_k)` of the flow from a node, `L = ∂(link)/∂x` of a link's state and `y` of a quantity,
//! a row `y(link(x(t)))` has the derivative `y_link L Φ` by the node's unknowns. The flow to the next node must end
//! there: `x(t_{k+1}) ⊟ x_{k+1} = 0`.

use nalgebra::{DMatrix, DVector, Matrix3xX, Vector3};

use super::problem::{TreeGoal, TreeProblem, TreeSample};
use super::program::{Nodes, Part, TreeProgram};
use crate::estimate::constraint::quantity::{self, Valued};
use crate::estimate::constraint::within::{self, WithinRow};
use crate::motion::GoalQuantity;
use crate::optimise::block::{Block, BlockPattern};
use crate::physics::State;
use crate::physics::tree::{Flow, Snapshot, TreeState};

/// A link's state with its derivatives by the tree's.
type LinkState = (State, DMatrix<f64>);

/// What one part of the motion, from a node to the next, adds up.
pub(super) struct Sums {
    pub(super) cost: f64,
    pub(super) gradient: DVector<f64>,
    pub(super) hessian: DMatrix<f64>,
}

impl TreeProgram<'_> {
    /// Evaluates the motion from a node to the next.
    pub(super) fn leg(
        &self,
        node: usize,
        part: &Part,
        nodes: &Nodes,
        blocks: &mut [Block],
    ) -> Sums {
        let problem = self.problem;
        let tree = &problem.tree;
        let width = problem.width();
        let [from_s, to_s] = problem.leg_s(node);
        let is_last = node + 1 == nodes.len();
        let mut flow = Flow::new(tree, &problem.gravity_m_s2, problem.tableau);
        flow.begin(&nodes[node], true);
        let mut snapshot = Snapshot::new(tree, &problem.gravity_m_s2);
        let mut jacobian = DMatrix::zeros(width, width + 1);
        let mut links: Vec<Option<LinkState>> = vec![None; tree.link_count()];
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
                    match goal.condition.sd {
                        Some(sd) => rows.iter().for_each(|of| sums.wish(of, &by, sd)),
                        None => {
                            for (row, of) in rows.iter().enumerate() {
                                put(goal, row, of, &by, (pattern, &mut *block));
                            }
                        }
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
        (snapshot, links): (&Snapshot, &mut [Option<LinkState>]),
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
    (snapshot, links): (&Snapshot, &'l mut [Option<LinkState>]),
    width: usize,
) -> [&'l LinkState; N] {
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
fn chained(valued: &Valued, links: &[&LinkState], jacobian: &DMatrix<f64>) -> Matrix3xX<f64> {
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

    /// A row of a goal that weighs: half the square of how far it is from its bounds, in deviations.
    fn wish(&mut self, of: &WithinRow, by: &Matrix3xX<f64>, sd: f64) {
        let (lower, upper) = of.bounds;
        let off = (of.value - of.value.clamp(lower, upper)) / sd;
        if off == 0.0 && lower != upper {
            return;
        }
        let by = by.tr_mul(&of.by) / sd;
        self.cost += 0.5 * off * off;
        self.gradient.axpy(off, &by, 1.0);
        self.hessian.ger(1.0, &by, &by, 1.0);
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
