//! The motion of trees as a program for the [optimiser](crate::optimise): its intervals (`interval`) summed, what holds rates
//! at the start and what nothing else does, and the curvature of all of it.

use std::cell::RefCell;

use nalgebra::{DMatrix, DVector, Matrix3xX, Vector3};

use super::curvature::{HessianRemainder, dense};
use super::evaluation::{Evaluation, Slope, Told};
use super::part::Part;
use super::point::TreePoint;
use super::problem::TreeProblem;
use super::rows;
use super::sample::Residual;
use super::whitened::WhitenedSums;
use crate::optimise::block::BlockPattern;
use crate::optimise::envelope::{Envelope, Pattern};
use crate::optimise::{Program, Structure, System};

/// Weight of a squared radian, metre or their rates, or step, that holds what nothing else does, per information: next
/// to nothing.
pub(super) const REGULARISER: f64 = 1e-8;
/// Typical changes of coordinates and of rates, in radians, metres and seconds,
pub(super) const LENGTHS: [f64; 2] = [0.3, 3.0];
/// of times \[s\],
const TIME_LENGTH_S: f64 = 0.03;
/// and of log-paces.
const LOG_PACE_LENGTH: f64 = 0.3;
/// How far samples are apart of which second derivatives are told \[s\].
const CURVATURE_S: f64 = 1.0 / 60.0;

/// A problem for the optimiser.
pub struct TreeProgram<'a> {
    pub(super) problem: &'a TreeProblem,
    pub(super) structure: Structure,
    /// Where what nothing determines stays.
    anchor: TreePoint,
    /// What was told last of the curvature.
    told: RefCell<Option<HessianRemainder>>,
}

impl<'a> TreeProgram<'a> {
    /// The program of a problem; what nothing determines stays where it is in `anchor`.
    pub fn new(problem: &'a TreeProblem, anchor: TreePoint) -> Self {
        let (width, nodes) = (problem.width(), problem.nodes_s.len());
        let of = |node: usize| node * width..(node + 1) * width;
        let of_interval = |node: usize| {
            let own = 0..problem.interval_size(node);
            own.map(move |at| problem.unknown_of(node, at))
        };
        let mut blocks: Vec<BlockPattern> = Vec::new();
        for goal in &problem.goals {
            if goal.is_timed() {
                blocks.push(problem.timed_pattern(goal));
                continue;
            }
            let node = problem.node_of(problem.about_s(goal));
            blocks.push(BlockPattern::dense(
                goal.row_count(),
                of_interval(node).collect(),
            ));
        }
        for node in 1..nodes {
            let columns = of_interval(node - 1).chain(of(node)).collect();
            blocks.push(BlockPattern::dense(width, columns));
        }
        for (index, event) in problem.events.iter().enumerate() {
            let node = problem.node_of(event.about_s);
            let mut pattern =
                BlockPattern::dense(event.touch_row_count(), of_interval(node).collect());
            for times in rows::order_unknowns(problem, index) {
                pattern.push(1, times);
            }
            blocks.push(pattern);
        }
        let clearances = problem.clearances.iter();
        blocks.extend(
            clearances.map(|of| BlockPattern::dense(1, of_interval(of.piece.node).collect())),
        );
        blocks.extend(problem.bound_patterns());
        let size = problem.unknown_count();
        let couplings =
            (0..size).flat_map(|row| (problem.first_coupled(row)..=row).map(move |at| (row, at)));
        let pattern = Pattern::new(size, couplings);
        Self {
            structure: Structure {
                pattern,
                priced: blocks.iter().map(|_| BlockPattern::default()).collect(),
                blocks,
            },
            problem,
            anchor,
            told: RefCell::new(None),
        }
    }

    /// [`Program::evaluate`], and every sample of which `each` is told with the node of its interval. Where derivatives are
    /// not asked for, those of samples have no columns, and those of rows are zero.
    pub(super) fn evaluate_each(
        &self,
        part: &Part,
        point: &TreePoint,
        has_derivatives: bool,
        system: &mut System,
        each: &mut dyn FnMut(usize, &Residual),
    ) {
        system.cost = 0.0;
        system.gradient.fill(0.0);
        system.hessian.clear();
        let slopes = match has_derivatives {
            true => self.slopes(part, point),
            false => Some(Vec::new()),
        };
        let (Some(there), Some(slopes)) = (self.problem.at(point), slopes) else {
            system.cost = f64::NAN;
            return;
        };
        let problem = &*there;
        let whitened = problem.errors.as_ref();
        let mut summed = SummedSamples {
            slopes: &slopes,
            parameters: problem.parameters.len(),
            seen: 0,
            each,
            whitened: whitened
                .map(|errors| WhitenedSums::new(problem, errors.processes, has_derivatives)),
        };
        let of = Evaluation {
            problem,
            part,
            point,
            has_derivatives,
        };
        for node in 0..problem.nodes_s.len() {
            let sums = self.interval(&of, node, &mut system.blocks, &mut summed);
            system.cost += sums.cost;
            let place = |at: usize| problem.unknown_of(node, at);
            for row in (0..sums.gradient.len()).take_while(|_| has_derivatives) {
                system.gradient[place(row)] += sums.gradient[row];
                for column in 0..=row {
                    let entry = sums.hessian[(row, column)];
                    let pattern = &self.structure.pattern;
                    system
                        .hessian
                        .add(pattern, place(row), place(column), entry);
                }
            }
        }
        if let Some(whitened) = summed.whitened {
            whitened.add_to(&self.structure.pattern, system);
        }
        for slope in &slopes {
            self.fill_slope(slope, system);
        }
        problem.fill_bounds(point, &self.structure.blocks, &mut system.blocks);
        let patterns = &self.structure.blocks;
        for row in problem.fill_timed(point, patterns, &mut system.blocks) {
            self.pull(row.off, &row.by, 1.0, system);
        }
        self.regularise(part, point, system);
    }

    /// Adds how the rows of joins, events and clearances change with a parameter: those of goals know it.
    fn fill_slope(&self, slope: &Slope, system: &mut System) {
        let unknown = self.problem.unknown_of_parameter(slope.parameter);
        let blocks = self.structure.blocks.iter().zip(&mut system.blocks);
        let all = blocks.zip(&slope.of.blocks);
        for ((pattern, block), rows) in all.skip(self.problem.goals.len()) {
            for (row, change) in rows.iter().enumerate() {
                let place = pattern.unknowns(row).iter().position(|of| *of == unknown);
                if let Some(place) = place {
                    block.derivatives_mut(pattern, row)[place] += change;
                }
            }
        }
    }

    /// Hessian of a part's cost.
    pub(super) fn information_at(&self, part: &Part, point: &TreePoint) -> DMatrix<f64> {
        let system = self.evaluated(part, point);
        dense(&self.structure.pattern, &system.hessian)
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

    /// What holds rates of the start, times at their marks, the tempo, parameters, and what nothing else does.
    fn regularise(&self, part: &Part, point: &TreePoint, system: &mut System) {
        let problem = self.problem;
        let (width, freedoms) = (problem.width(), problem.forest.freedoms());
        for (node, (state, anchor)) in point.nodes.iter().zip(&self.anchor.nodes).enumerate() {
            let off = problem.forest.minus(state, anchor);
            for (at, off) in off.into_iter().enumerate() {
                let is_rate = at >= freedoms && !problem.forest.is_translation(at - freedoms);
                let (off, weight) = if node == 0 && is_rate {
                    (state.rates[at - freedoms], part.rate_sd_rad_s.powi(-2))
                } else {
                    (off, REGULARISER * problem.information.0)
                };
                let row = node * width + at;
                system.cost += 0.5 * weight * off * off;
                system.gradient[row] += weight * off;
                system
                    .hessian
                    .add(&self.structure.pattern, row, row, weight);
            }
        }
        let line = point.time_line(problem);
        let times = point.event_times_s.iter().zip(&problem.events);
        for (index, (time_s, event)) in times.enumerate() {
            let row = problem.unknown_of_event(index);
            match event.mark {
                Some(mark) => {
                    let (acted_s, by) = line.acted_by(problem, index, *time_s);
                    let weight = mark.counted_sd_s().powi(-2);
                    self.pull(acted_s - mark.acted_s, &by, weight, system);
                }
                None => {
                    let off_s = time_s - self.anchor.event_times_s[index];
                    self.pull(
                        off_s,
                        &[(row, 1.0)],
                        REGULARISER * problem.information.0,
                        system,
                    );
                }
            }
        }
        self.hold_tempo(part, point, system);
        let values = point.parameters.iter().zip(&problem.parameters);
        for (index, (value, free)) in values.enumerate() {
            let by = [(problem.unknown_of_parameter(index), 1.0)];
            let (off, weight) = match free.prior_sd {
                Some(sd) => (value - free.initial, sd.powi(-2)),
                None => {
                    let weight = REGULARISER * problem.information.0 * free.length().powi(-2);
                    (value - self.anchor.parameters[index], weight)
                }
            };
            self.pull(off, &by, weight, system);
        }
    }

    /// What holds an unknown tempo: it changes little from piece to piece.
    fn hold_tempo(&self, part: &Part, point: &TreePoint, system: &mut System) {
        let problem = self.problem;
        let Some(tempo) = &problem.tempo else {
            return;
        };
        let unknown = |piece: usize| problem.unknown_of_pace(piece);
        let paces = &point.log_paces;
        for (piece, pair) in paces.windows(2).enumerate() {
            let by = [(unknown(piece), -1.0), (unknown(piece + 1), 1.0)];
            let weight = tempo.change_sd(piece).powi(-2);
            self.pull(pair[1] - pair[0], &by, weight, system);
        }
        let first = [(unknown(0), 1.0)];
        let (off, weight) = match part.log_pace_sd {
            Some(sd) => (paces[0] - tempo.guess.ln(), sd.powi(-2)),
            None => (
                paces[0] - self.anchor.log_paces[0],
                REGULARISER * problem.information.0,
            ),
        };
        self.pull(off, &first, weight, system);
    }

    /// Half the square of what is so far off, with its derivatives by unknowns, times a weight.
    fn pull(&self, off: f64, by: &[(usize, f64)], weight: f64, system: &mut System) {
        system.cost += 0.5 * weight * off * off;
        for (row, by_row) in by {
            system.gradient[*row] += weight * off * by_row;
            for (column, by_column) in by.iter().filter(|(column, _)| column <= row) {
                let entry = weight * by_row * by_column;
                system
                    .hessian
                    .add(&self.structure.pattern, *row, *column, entry);
            }
        }
    }
}

/// Samples on their way into sums, with how they change with what is freed.
struct SummedSamples<'s, 'p> {
    slopes: &'s [Slope],
    /// Number of parameters: the last unknowns of an interval.
    parameters: usize,
    /// How many samples there were.
    seen: usize,
    each: &'s mut dyn FnMut(usize, &Residual),
    whitened: Option<WhitenedSums<'p>>,
}

impl Told for SummedSamples<'_, '_> {
    fn sample(&mut self, node: usize, residual: &mut Residual) {
        for slope in self.slopes {
            let column = residual.by.ncols() - self.parameters + slope.parameter;
            let mut by = residual.by.column_mut(column);
            by += slope.of.residuals[self.seen];
        }
        self.seen += 1;
        if !residual.sample.is_counted {
            return;
        }
        (self.each)(node, residual);
        if let Some(whitened) = &mut self.whitened {
            whitened.add(node, residual);
        }
    }

    fn goal(&mut self, goal: usize, _value: &Vector3<f64>, by: &mut Matrix3xX<f64>) {
        for slope in self.slopes {
            if let Some(change) = slope.of.goals[goal] {
                let column = by.ncols() - self.parameters + slope.parameter;
                let mut by = by.column_mut(column);
                by += change;
            }
        }
    }
}

impl Program for TreeProgram<'_> {
    type Point = TreePoint;
    type Guidance = Part;

    fn structure(&self) -> &Structure {
        &self.structure
    }

    fn evaluate(&self, part: &Part, point: &TreePoint, system: &mut System) {
        self.evaluate_each(part, point, true, system, &mut |_, _| {});
    }

    fn try_out(&self, part: &Part, point: &TreePoint, system: &mut System) {
        self.evaluate_each(part, point, false, system, &mut |_, _| {});
    }

    fn differentiate(&self, part: &Part, point: &TreePoint, system: &mut System) {
        self.evaluate(part, point, system);
    }

    fn retract(&self, from: &TreePoint, step: &DVector<f64>, to: &mut TreePoint) {
        from.retract(self.problem, step, to);
    }

    fn damping(&self) -> DVector<f64> {
        let (width, freedoms) = (self.problem.width(), self.problem.forest.freedoms());
        let states = width * self.problem.nodes_s.len();
        let times = states + self.problem.events.len();
        let paces = times + self.problem.pace_count();
        let weight = |length: f64| 10.0 * self.problem.information.0 / (length * length);
        DVector::from_fn(self.problem.unknown_count(), |at, _| {
            weight(match at < states {
                true => LENGTHS[usize::from(at % width >= freedoms)],
                false if at < times => TIME_LENGTH_S,
                false if at < paces => LOG_PACE_LENGTH,
                false => self.problem.parameters[at - paces].length(),
            })
        })
    }

    fn is_curved(&self) -> bool {
        true
    }

    fn information(&self) -> (f64, f64) {
        self.problem.information
    }

    /// What `curvature` tells of a coarse reading of the problem.
    fn add_curvature(
        &self,
        (point, system): (&TreePoint, &System),
        multipliers: &[f64],
        hessian: &mut Envelope,
    ) {
        let problem = self.problem;
        let mut told = self.told.borrow_mut();
        let kept = told.take();
        let kept = kept.filter(|kept| kept.serves(self, problem, point, multipliers));
        let kept = kept.unwrap_or_else(|| {
            let pace = problem.tempo.as_ref().map_or(1.0, |of| of.guess);
            let coarse = problem.coarse(CURVATURE_S / pace);
            let coarse = TreeProgram::new(&coarse, self.anchor.clone());
            let whole = Part::whole();
            match problem.nodes_s.len() {
                1 => {
                    let free = self.free_directions(system);
                    HessianRemainder::along(&coarse, &whole, &free, point, multipliers)
                }
                _ => HessianRemainder::on_intervals(&coarse, &whole, problem, point, multipliers),
            }
        });
        told.insert(kept)
            .add(problem, &self.structure.pattern, hessian);
    }
}
