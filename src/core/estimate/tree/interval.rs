//! One interval of the motion, from a node to the next: residuals of its samples, rows of its goals and events, and
//! how it joins the next, with all derivatives by the interval's unknowns: the node's tangent, then times of its events, then
//! the log-paces of an unknown tempo and what of the laws of impacts is unknown.
//!
//! With `X = ∂x(t)/∂(x_k, T, λ, p)` of the [trajectory](super::trajectory) from a node, `L = ∂(link)/∂x` of a link's state and
//! `y` of a quantity, a row `y(link(x(t)))` has the derivative `y_link L X`. The flow to the next node must end
//! there: `x(t_{k+1}) ⊟ x_{k+1} = 0`.

use nalgebra::{DMatrix, DVector, Matrix3xX, Vector3};

use super::clearance::TreeClearance;
use super::evaluation::{Evaluation, Told};
use super::event::TreeEvent;
use super::goal::TreeGoal;
use super::nearness::StoppedMotion;
use super::problem::TreeProblem;
use super::program::TreeProgram;
use super::rows;
use super::sample::{Residual, TreeSample};
use super::trajectory::{Stop, Trajectory, With};
use crate::estimate::constraint::quantity::{self, Valued};
use crate::estimate::constraint::within::WithinRow;
use crate::motion::{GoalQuantity, Moment};
use crate::optimise::block::{Block, BlockPattern};
use crate::physics::State;
use crate::physics::tree::{ForestSnapshot, TreeState};

/// A link's state with its derivatives by that of all.
type LinkState = (State, DMatrix<f64>);

/// What one part of the motion, from a node to the next, adds up.
pub(super) struct Sums {
    pub(super) cost: f64,
    pub(super) gradient: DVector<f64>,
    pub(super) hessian: DMatrix<f64>,
}

impl TreeProgram<'_> {
    /// Evaluates the motion from a node to the next. Where an impact is undefined the cost is not finite, and rows
    /// after it are not told.
    pub(super) fn interval(
        &self,
        of: &Evaluation,
        node: usize,
        blocks: &mut [Block],
        told: &mut dyn Told,
    ) -> Sums {
        let Evaluation {
            problem,
            part,
            point,
            has_derivatives,
        } = *of;
        let first_event = problem.events_of(node).start;
        let (width, size) = (problem.width(), problem.interval_size(node));
        let line = &point.time_line(problem);
        let mut trajectory =
            Trajectory::new(problem, line, node, &point.nodes[node], has_derivatives);
        let mut snapshot = ForestSnapshot::new(&problem.forest, &problem.gravity_m_s2);
        let mut jacobian = DMatrix::zeros(width, size);
        let mut links: Vec<Option<LinkState>> = vec![None; problem.forest.link_count()];
        let mut sums = Sums {
            cost: 0.0,
            gradient: DVector::zeros(size),
            hessian: DMatrix::zeros(size, size),
        };
        let mut reached: Option<Stop> = None;
        for item in items(problem, node) {
            if item.about_s > part.until_s {
                if let Some(index) = item.kind.block(problem) {
                    rows::silence(&self.structure.blocks[index], &mut blocks[index]);
                }
                continue;
            }
            let mut least = None;
            if let ItemKind::Clearance(_, clearance) = item.kind {
                let ends = clearance.piece.ends(problem, line, point);
                least = clearance.least(problem, ends, &mut trajectory);
                reached = None;
            }
            let to = match (&least, item.event) {
                (Some(least), _) => least.stop,
                (None, Some(event)) => Stop {
                    time_s: point.event_times_s[first_event + event],
                    with: With::Event(event),
                },
                (None, None) => Stop::acted(line, item.about_s),
            };
            if reached != Some(to) {
                trajectory.advance(to);
                reached = Some(to);
                snapshot.set(&trajectory.state());
                if has_derivatives {
                    jacobian = trajectory.jacobian();
                }
                links.fill(None);
            }
            match item.kind {
                ItemKind::Sample(sample) => {
                    let valued = |state: &State| {
                        quantity::valued(&sample.quantity, state, None, &sample.point_m)
                    };
                    let mut residual = if has_derivatives {
                        let [link] = states([sample.place], &snapshot, &mut links, width);
                        let valued = valued(&link.0);
                        let by = chained(&valued, &[link], &jacobian);
                        Residual::new(sample, &valued, &by)
                    } else {
                        let valued = valued(&snapshot.link_state(sample.place));
                        Residual::new(sample, &valued, &Matrix3xX::zeros(0))
                    };
                    told.sample(node, &mut residual);
                    if problem.errors.is_none() {
                        sums.add(&residual);
                    }
                }
                ItemKind::Goal(index, goal) => {
                    let state = trajectory.state();
                    let (value, mut by) = asked(
                        problem, goal, item.event, &state, &snapshot, &mut links, &jacobian,
                    );
                    told.goal(index, &value, &mut by);
                    let (pattern, block) = self.room(index, blocks);
                    for (row, of) in goal.rows(&value).iter().enumerate() {
                        match goal.condition.sd {
                            Some(sd) => sums.soft_goal(of, &by, sd),
                            None => rows::put(goal, row, of, &by, pattern, &mut *block),
                        }
                    }
                }
                ItemKind::Event(index, event) => {
                    let (pattern, block) = self.room(problem.event_block(index), blocks);
                    rows::order(problem, index, line, &point.event_times_s, pattern, block);
                    let Some(touch) = event.touch_at(point) else {
                        continue;
                    };
                    let Ok((impact, derivative)) = trajectory.hit(&snapshot, &touch, &event.free)
                    else {
                        sums.cost = f64::NAN;
                        return sums;
                    };
                    let place = index - problem.events_of(node).start;
                    let count = event.touch_row_count();
                    rows::touch(
                        &impact,
                        &derivative,
                        count,
                        place,
                        &jacobian,
                        pattern,
                        block,
                    );
                    reached = None;
                }
                ItemKind::Clearance(index, clearance) => {
                    let (pattern, block) = self.room(problem.clearance_block(index), blocks);
                    let Some(least) = &least else {
                        block.spoil();
                        continue;
                    };
                    let both = states(clearance.places, &snapshot, &mut links, width);
                    let at = StoppedMotion {
                        snapshot: &snapshot,
                        links: both.map(|(_, by)| by),
                        jacobian: &jacobian,
                    };
                    clearance.fill(least, &at, pattern, block);
                }
                ItemKind::Next(node) => {
                    let (pattern, block) = self.room(problem.join_block(node), blocks);
                    rows::join(
                        problem,
                        &trajectory.state(),
                        &point.nodes[node + 1],
                        &jacobian,
                        pattern,
                        block,
                    );
                }
            }
        }
        sums
    }

    /// A block of rows with nothing in it.
    fn room<'b>(
        &'b self,
        index: usize,
        blocks: &'b mut [Block],
    ) -> (&'b BlockPattern, &'b mut Block) {
        let (pattern, block) = (&self.structure.blocks[index], &mut blocks[index]);
        block.reset(pattern);
        (pattern, block)
    }
}

/// What happens on an interval, in its order: an event parts what is before it from what is after it, wherever its
/// estimated time is.
fn items(problem: &TreeProblem, node: usize) -> Vec<TimedItem<'_>> {
    let events = problem.events_of(node);
    let before = |about_s: f64| {
        let of_interval = problem.events[events.clone()].iter();
        of_interval.filter(|event| event.about_s <= about_s).count()
    };
    let at_stamp = |acted_s: f64, kind| TimedItem {
        phase: (before(acted_s), 0),
        about_s: acted_s,
        event: None,
        kind,
    };
    let is_here = |acted_s: f64| problem.node_of(acted_s) == node;
    let samples = problem.samples.iter().filter(|of| is_here(of.acted_s));
    let mut items: Vec<TimedItem> = samples
        .map(|sample| at_stamp(sample.acted_s, ItemKind::Sample(sample)))
        .collect();
    let at_event = |event: usize, kind, rank| TimedItem {
        phase: (event - events.start, rank),
        about_s: problem.events[event].about_s,
        event: Some(event - events.start),
        kind,
    };
    let goals = problem.goals.iter().enumerate();
    for (index, goal) in goals.filter(|(_, goal)| !goal.is_timed()) {
        let kind = ItemKind::Goal(index, goal);
        match problem.event_within(goal) {
            Some(event) if events.contains(&event) => {
                let rank = match goal.condition.moment {
                    Moment::Before => 1,
                    Moment::After => 3,
                };
                items.push(at_event(event, kind, rank));
            }
            Some(_) => {}
            None if is_here(goal.acted_s) => items.push(at_stamp(goal.acted_s, kind)),
            None => {}
        }
    }
    for event in events.clone() {
        let kind = ItemKind::Event(event, &problem.events[event]);
        items.push(at_event(event, kind, 2));
    }
    for (index, clearance) in problem.clearances.iter().enumerate() {
        if clearance.piece.node == node {
            items.push(TimedItem {
                phase: (clearance.piece.phase(problem), 0),
                about_s: clearance.about_s,
                event: None,
                kind: ItemKind::Clearance(index, clearance),
            });
        }
    }
    if node + 1 < problem.nodes_s.len() {
        let mut next = at_stamp(problem.interval_s(node)[1], ItemKind::Next(node));
        next.phase = (events.len(), 1);
        items.push(next);
    }
    items.sort_by(|a, b| {
        let in_phase = a.about_s.total_cmp(&b.about_s);
        a.phase.cmp(&b.phase).then(in_phase)
    });
    items
}

/// A goal's quantity with its derivative by the interval's unknowns, at a state, at the time of an event of the interval if that
/// is unknown.
fn asked(
    problem: &TreeProblem,
    goal: &TreeGoal,
    event: Option<usize>,
    state: &TreeState,
    snapshot: &ForestSnapshot,
    links: &mut [Option<LinkState>],
    jacobian: &DMatrix<f64>,
) -> (Vector3<f64>, Matrix3xX<f64>) {
    let width = problem.width();
    let quantity = &goal.condition.quantity;
    if let GoalQuantity::Angles { count } = quantity {
        let angles = problem.forest.angles_of(goal.places[0]);
        let [columns, coordinates] = angles.expect("asked of a pin or a universal joint");
        let mut value = Vector3::zeros();
        let mut by = Matrix3xX::zeros(jacobian.ncols());
        for axis in 0..*count {
            value[axis] = state.coordinates[coordinates.start + axis];
            by.row_mut(axis)
                .copy_from(&jacobian.row(columns.start + axis));
        }
        return (value, by);
    }
    let [own, other] = states(goal.places, snapshot, links, width);
    let other_state = quantity.seen_from().map(|_| &other.0);
    let valued = match &goal.touched {
        None => quantity::valued(quantity, &own.0, other_state, &goal.point_m),
        Some(touched) => {
            let both = [own.0, other.0];
            let Some(point) = problem.touched_point(goal, touched, &both) else {
                // The impact there is undefined, too.
                let unknown = Vector3::repeat(f64::NAN);
                return (unknown, Matrix3xX::zeros(jacobian.ncols()));
            };
            let mut valued = quantity::valued(quantity, &own.0, other_state, &point.point_m);
            valued.follow(&point.by[..1 + usize::from(touched.other.is_some())]);
            valued
        }
    };
    let mut by = chained(&valued, &[own, other], jacobian);
    if let Some(event) = event {
        let mut by_time = by.column_mut(width + event);
        for (by_link, place) in valued.by.iter().zip(goal.places) {
            by_time += by_link * snapshot.link_carried(place);
        }
    }
    (valued.value, by)
}

/// What happens at a stop.
struct TimedItem<'a> {
    /// Number of the interval's events before it; at an event, its goals come before it or after it.
    phase: (usize, usize),
    /// About when it is \[s, acted\].
    about_s: f64,
    /// Place among the interval's events of the one whose time is its time.
    event: Option<usize>,
    kind: ItemKind<'a>,
}

enum ItemKind<'a> {
    Sample(&'a TreeSample),
    Goal(usize, &'a TreeGoal),
    Event(usize, &'a TreeEvent),
    /// At the moment of its least distance, which is found there.
    Clearance(usize, &'a TreeClearance),
    /// The end of the interval of this node.
    Next(usize),
}

impl ItemKind<'_> {
    /// Its block of rows.
    fn block(&self, problem: &TreeProblem) -> Option<usize> {
        match self {
            ItemKind::Sample(_) => None,
            ItemKind::Goal(index, _) => Some(*index),
            ItemKind::Next(node) => Some(problem.join_block(*node)),
            ItemKind::Event(index, _) => Some(problem.event_block(*index)),
            ItemKind::Clearance(index, _) => Some(problem.clearance_block(*index)),
        }
    }
}

/// States of links with their derivatives by the state of all, each computed once per time.
fn states<'l, const N: usize>(
    places: [usize; N],
    snapshot: &ForestSnapshot,
    links: &'l mut [Option<LinkState>],
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
    let mut by = Matrix3xX::zeros(jacobian.nrows());
    for (by_link, (_, link)) in valued.by.iter().zip(links) {
        by += by_link * link;
    }
    by * jacobian
}

impl Sums {
    fn add(&mut self, residual: &Residual) {
        self.cost += 0.5 * residual.value.norm_squared();
        if residual.by.is_empty() {
            return;
        }
        self.gradient
            .gemv_tr(1.0, &residual.by, &residual.value, 1.0);
        self.hessian.gemm_tr(1.0, &residual.by, &residual.by, 1.0);
    }

    /// A row of a goal that weighs: half the square of how far it is from its bounds, in deviations.
    fn soft_goal(&mut self, of: &WithinRow, by: &Matrix3xX<f64>, sd: f64) {
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
