//! A grid's unknowns with objective and constraints, derived from the program's own lifted system.
//!
//! What follows is first simulated, so that the lifted unknowns are consistent; the program's system
//! is evaluated there; and its derivatives are chained to the grid's unknowns. The chain comes from
//! the lifted rows themselves: of a contact `φ(x, τ) = 0` that
//! `dτ = −(∂φ/∂x dx)/φ̇`, division by the approach speed (paper §5.2), and of the continuity through
//! the impact the change of the state after it, saltation included. So samples, impacts and goals are
//! the same code for every method, and exact wherever the program's derivatives are.

use std::cell::RefCell;

use enact::estimate::problem::Problem;
use enact::estimate::terms::context::{Guidance, SolveContext};
use enact::estimate::unknowns::point::Point;
use enact::optimise::block::Block;
use enact::optimise::envelope::Envelope;
use enact::optimise::{Program, Structure, System};
use enact::physics::state::DIMENSION as STATE;
use enact::physics::state::StateTangent;
use nalgebra::DVector;

use super::chain::Chains;
use super::columns::GAP;
use super::join;
use super::parts::{Part, of_collision, of_goal};
use super::rows::{fill_block, rows_of, unknowns};
use super::setting::{Place, Setting};
use super::simulate::{gaps, simulate};

/// What is evaluated again and again.
pub struct Model<'a> {
    setting: &'a Setting,
    /// Of the lifted problem.
    inner: SolveContext<'a>,
    /// Lifted system at the last place.
    system: RefCell<System>,
}

impl<'a> Model<'a> {
    /// Of a setting.
    pub fn new(setting: &'a Setting) -> Self {
        let split = &setting.split;
        let epochs_s = split.epochs_s.clone();
        let inner = SolveContext::new(&split.problem, &setting.lifted, epochs_s, &split.start);
        Self {
            system: RefCell::new(System::new(inner.structure())),
            inner,
            setting,
        }
    }

    /// Where the arcs' own fits put it.
    pub fn start(&self) -> Place {
        let Setting { split, grid, .. } = self.setting;
        let gaps = if grid.shoots() && self.gap_weight().is_some() {
            gaps(&split.problem, split, &split.start)
        } else {
            vec![[StateTangent::zeros(); 2]; split.problem.collisions.len()]
        };
        self.followed(split.start.clone(), gaps)
    }

    /// Context and point of the fits themselves, for what leads the way.
    pub fn fits(&self) -> (&SolveContext<'a>, &Point) {
        (&self.inner, &self.setting.split.start)
    }

    /// What is estimated.
    pub fn problem(&self) -> &'a Problem {
        &self.setting.problem
    }

    fn gap_weight(&self) -> Option<f64> {
        self.setting.problem.velocity_gap_weight
    }

    fn followed(&self, mut lifted: Point, gaps: Vec<[StateTangent; 2]>) -> Place {
        let Setting {
            split,
            grid,
            columns,
            ..
        } = self.setting;
        let exists = simulate(split, columns, *grid, &mut lifted, &gaps).is_some();
        Place {
            lifted,
            gaps,
            exists,
        }
    }

    /// Moves a place by `delta`.
    pub fn moved(&self, from: &Place, delta: &DVector<f64>) -> Place {
        let Setting {
            split,
            columns,
            lifted: layout,
            ..
        } = self.setting;
        let mut all = DVector::zeros(layout.size());
        let mut free = |at: usize, of: &[usize]| {
            for (index, column) in of.iter().enumerate() {
                all[at + index] = delta[*column];
            }
        };
        for (piece, at) in layout.arcs.iter().enumerate() {
            if !split.follows[piece] {
                free(*at, &columns.pieces[piece]);
            }
        }
        let follows = |event: usize| {
            let collisions = split.problem.collisions.iter().zip(&columns.times_follow);
            collisions
                .into_iter()
                .any(|(c, follows)| c.event == event && *follows)
        };
        for (event, at) in layout.events.iter().enumerate() {
            if let Some(at) = at
                && !follows(event)
            {
                free(*at, &columns.events[event]);
            }
        }
        for (at, column) in layout.nodes.iter().zip(&columns.nodes) {
            if let (Some(at), Some(column)) = (at, column) {
                free(*at, &[*column]);
            }
        }
        for (at, column) in layout.parameters.iter().zip(&columns.parameters) {
            free(*at, &[*column]);
        }
        let mut lifted = from.lifted.clone();
        lifted.retract_from(&from.lifted, &split.problem, layout, &all);
        let mut gaps = from.gaps.clone();
        for (index, first) in columns.gaps.iter().enumerate() {
            let Some(first) = first else { continue };
            for body in 0..split.problem.collisions[index].sides.len() {
                for row in 0..GAP {
                    gaps[index][body][GAP + row] += delta[first + GAP * body + row];
                }
            }
        }
        self.followed(lifted, gaps)
    }

    /// Lengths of a step, by which damping weighs the unknowns, in the order of the columns.
    pub fn by_unknown(&self, of: impl Fn(Part) -> Vec<f64>, gap: f64) -> DVector<f64> {
        let Setting { split, columns, .. } = self.setting;
        let mut lengths = DVector::repeat(columns.layout.size(), f64::NAN);
        let mut set = |columns: &[usize], values: &[f64]| {
            for (column, value) in columns.iter().zip(values) {
                lengths[*column] = *value;
            }
        };
        for (piece, own) in columns.pieces.iter().enumerate() {
            if !split.follows[piece] {
                set(own, &of(Part::Piece(piece)));
            }
        }
        for (event, own) in columns.events.iter().enumerate() {
            if own.len() == 1 {
                set(own, &of(Part::Event(event)));
            }
        }
        for at in columns.nodes.iter().flatten() {
            set(&[*at], &of(Part::Event(0)));
        }
        for (p, at) in columns.parameters.iter().enumerate() {
            set(&[*at], &of(Part::Parameter(p)));
        }
        for value in lengths.iter_mut().filter(|value| value.is_nan()) {
            *value = gap;
        }
        lengths
    }

    /// The values of its system, with derivatives that mean nothing: for methods that use none.
    pub fn values(&self, guidance: &Guidance, place: &Place, out: &mut System) {
        if !place.exists {
            out.cost = f64::INFINITY;
            return;
        }
        let Setting {
            split,
            columns,
            grid,
            ..
        } = self.setting;
        let lifted = &mut *self.system.borrow_mut();
        self.inner.evaluate(guidance, &place.lifted, lifted);
        out.cost = lifted.cost;
        if let Some(weight) = self.gap_weight() {
            let gaps = lifted.priced.iter().flat_map(|gaps| &gaps.values);
            out.cost += 0.5 * weight * gaps.map(|v| v * v).sum::<f64>();
        }
        for (index, (lifted, block)) in lifted.blocks.iter().zip(&mut out.blocks).enumerate() {
            let is_collision = index < split.problem.collisions.len();
            let skipped = usize::from(is_collision && columns.times_follow[index]);
            let end = match is_collision && grid.shoots() {
                true => lifted.leads.end,
                false => lifted.values.len(),
            };
            block.values.clear();
            block.values.extend_from_slice(&lifted.values[skipped..end]);
        }
    }

    /// The price of velocity gaps.
    fn add_gaps(&self, place: &Place, (system, chains): (&System, &Chains), out: &mut System) {
        let Some(weight) = self.gap_weight() else {
            return;
        };
        let Setting {
            split,
            columns,
            grid,
            ..
        } = self.setting;
        let pattern = &columns.layout.structure.pattern;
        let collisions = system.priced.iter().take(split.problem.collisions.len());
        for (index, gaps) in collisions.enumerate() {
            out.cost += 0.5 * weight * gaps.values.iter().map(|v| v * v).sum::<f64>();
            if let Some(first) = columns.gaps[index] {
                for row in 0..gaps.values.len() {
                    let value = place.gaps[index][row / GAP][GAP + row % GAP];
                    out.gradient[first + row] += weight * value;
                    out.hessian.add(pattern, first + row, first + row, weight);
                }
                continue;
            }
            debug_assert!(!grid.shoots());
            let parts = of_collision(&split.problem, index);
            let own = columns.layout.structure.blocks[index].unknowns(0);
            let rows: Vec<usize> = (0..gaps.values.len()).collect();
            let gaps_pattern = &self.inner.layout.structure.priced[index];
            let lifted = unknowns(self.inner.layout, &parts);
            let by = rows_of((gaps, gaps_pattern), &rows, &lifted);
            let by = chains.chained(&by, &parts, own);
            let values = DVector::from_column_slice(&gaps.values);
            let (pull, square) = (by.tr_mul(&values) * weight, by.tr_mul(&by) * weight);
            for (i, at) in own.iter().enumerate() {
                out.gradient[*at] += pull[i];
                for (j, other) in own[..=i].iter().enumerate() {
                    out.hessian.add(pattern, *at, *other, square[(i, j)]);
                }
            }
        }
    }

    fn fill_rows(&self, place: &Place, (system, chains): (&System, &Chains), out: &mut System) {
        let Setting {
            split,
            columns,
            grid,
            ..
        } = self.setting;
        let problem = &split.problem;
        let blocks = &columns.layout.structure.blocks;
        let mut next = 0;
        for (index, collision) in problem.collisions.iter().enumerate() {
            let lifted = &system.blocks[index];
            let skipped = usize::from(columns.times_follow[index]);
            let end = if grid.shoots() {
                lifted.leads.end
            } else {
                lifted.values.len()
            };
            let rows: Vec<usize> = (skipped..end).collect();
            let parts = of_collision(problem, index);
            let from = rows_of(
                (lifted, &self.inner.layout.structure.blocks[index]),
                &rows,
                &unknowns(self.inner.layout, &parts),
            );
            let mut at = 0;
            let mut kept = Vec::new();
            for part in parts {
                let is_after = collision.sides.iter().any(|s| part == Part::Piece(s.after));
                if !(grid.shoots() && is_after) {
                    kept.push((at, part));
                }
                at += part.width();
            }
            let by = chains.chained_from(&from, &kept, blocks[index].unknowns(0));
            let out = &mut out.blocks[index];
            fill_block(lifted, &rows, &by, (out, &blocks[index]));
            out.leads = lifted.leads.start - skipped..lifted.leads.end - skipped;
        }
        next += problem.collisions.len();
        for goal in 0..problem.goals.len() {
            let lifted = &system.blocks[next];
            let rows: Vec<usize> = (0..lifted.values.len()).collect();
            let parts = of_goal(problem, goal);
            let from = rows_of(
                (lifted, &self.inner.layout.structure.blocks[next]),
                &rows,
                &unknowns(self.inner.layout, &parts),
            );
            let by = chains.chained(&from, &parts, blocks[next].unknowns(0));
            fill_block(lifted, &rows, &by, (&mut out.blocks[next], &blocks[next]));
            next += 1;
        }
        for _ in 0..problem.bounded.len() + problem.cones.len() {
            out.blocks[next].clone_from(&system.blocks[next]);
            next += 1;
        }
        for (left, right) in &split.joins {
            let gap = join::between(&self.inner, &place.lifted, *left, *right);
            let block: &mut Block = &mut out.blocks[next];
            let target = blocks[next].unknowns(0);
            gap.fill(chains, (*left, *right), target, (block, &blocks[next]));
            next += 1;
        }
    }
}

impl Program for Model<'_> {
    type Point = Place;
    type Guidance = Guidance;

    fn structure(&self) -> &Structure {
        &self.setting.columns.layout.structure
    }

    /// Objective and constraints at a place; an infinite objective where there is no such motion.
    fn evaluate(&self, guidance: &Guidance, place: &Place, out: &mut System) {
        if !place.exists {
            out.cost = f64::INFINITY;
            return;
        }
        let Setting {
            split,
            columns,
            grid,
            ..
        } = self.setting;
        let lifted = &mut *self.system.borrow_mut();
        self.inner.evaluate(guidance, &place.lifted, lifted);
        let lifted = &*lifted;
        let chains = Chains::new(split, columns, *grid, (self.inner.layout, lifted));
        out.cost = lifted.cost;
        out.gradient.fill(0.0);
        out.hessian.clear();
        chains.add_objective(&self.inner, lifted, out);
        self.add_gaps(place, (lifted, &chains), out);
        self.fill_rows(place, (lifted, &chains), out);
    }

    fn retract(&self, from: &Place, step: &DVector<f64>, to: &mut Place) {
        *to = self.moved(from, step);
    }

    /// The program's lengths; of velocity gaps \[units\].
    fn damping(&self) -> DVector<f64> {
        const GAP: f64 = 5.0;
        let layout = self.inner.layout;
        // Pieces of a flight know less than the whole.
        let (least, _) = self.information();
        let own = self.inner.damping() * (least / self.inner.information().0);
        let times = layout.events.iter().chain(&layout.nodes).flatten();
        let of_time: Vec<f64> = times.take(1).map(|at| own[*at]).collect();
        let of = |part: Part| match part {
            Part::Piece(piece) => own.as_slice()[layout.arcs[piece]..][..STATE].to_vec(),
            Part::Event(_) => of_time.clone(),
            Part::Parameter(p) => vec![own[layout.parameters[p]]],
        };
        self.by_unknown(of, 10.0 * least / (GAP * GAP))
    }

    fn information(&self) -> (f64, f64) {
        let problem = self.problem();
        (problem.least_information(), problem.information())
    }

    /// Chained rows say nothing of theirs.
    fn add_curvature(&self, _: (&Place, &System), _: &[f64], _: &mut Envelope) {}
}
