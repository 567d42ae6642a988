//! Where the unknowns of a grid sit, and which of them each part of the problem depends upon.
//!
//! As in the program: along time, so that the normal matrix is a narrow envelope. What many pieces
//! follow from comes after the sample times of all of them.

use std::collections::BTreeSet;

use enact::estimate::unknowns::layout::Layout;
use enact::optimise::block::BlockPattern;
use enact::physics::state::DIMENSION as STATE;

use super::parts::{Part, gravity, of_collision, of_goal};
use super::split::{Grid, Split};

/// Unknowns of a velocity gap of one body.
pub const GAP: usize = STATE / 2;

/// Where everything is.
pub struct Columns {
    /// Unknowns that each piece's state depends upon, in order.
    pub pieces: Vec<Vec<usize>>,
    /// Unknowns that each event's time depends upon; empty where it is fixed.
    pub events: Vec<Vec<usize>>,
    /// Of each sample time.
    pub nodes: Vec<Option<usize>>,
    /// Of each parameter.
    pub parameters: Vec<usize>,
    /// First of each collision's velocity gaps, where they are unknowns.
    pub gaps: Vec<Option<usize>>,
    /// Whether a collision's time follows from its first contact.
    pub times_follow: Vec<bool>,
    /// As the program's solver takes it; of the unknowns' places only patterns and blocks count:
    /// collisions, goals, bounded parameters, cones, joins.
    pub layout: Layout,
}

/// What other things depend upon.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Source {
    Node(usize),
    Piece(usize),
    Gap(usize),
    Event(usize),
    Parameter(usize),
}

impl Columns {
    /// Of the pieces of a grid, given the layout of the lifted problem.
    pub fn new(split: &Split, lifted: &Layout, grid: Grid) -> Self {
        let problem = &split.problem;
        let times_follow = problem.collisions.iter();
        let times_follow: Vec<bool> = times_follow
            .map(|c| grid.finds_times() && !c.touches_by_goal)
            .collect();
        let mut columns = Self {
            pieces: vec![Vec::new(); problem.arcs.len()],
            events: vec![Vec::new(); problem.event_is_free.len()],
            nodes: vec![None; problem.nodes_acted_s.len()],
            parameters: vec![0; problem.parameters.len()],
            gaps: vec![None; problem.collisions.len()],
            times_follow,
            layout: lifted.clone(),
        };
        let (pieces, events) = columns.sources(split, grid);
        let size = columns.place(split, lifted, grid, (&pieces, &events));
        let found = |sources: &BTreeSet<Source>| -> Vec<usize> {
            let all = sources.iter().flat_map(|source| columns.of(split, *source));
            all.collect::<BTreeSet<usize>>().into_iter().collect()
        };
        let own: Vec<Vec<usize>> = pieces.iter().map(found).collect();
        let times: Vec<Vec<usize>> = events.iter().map(found).collect();
        (columns.pieces, columns.events) = (own, times);
        columns.couple(split, grid, size);
        columns
    }

    /// What pieces and events follow from, in the end.
    fn sources(&self, split: &Split, grid: Grid) -> (Vec<BTreeSet<Source>>, Vec<BTreeSet<Source>>) {
        let problem = &split.problem;
        let own = |piece: usize| BTreeSet::from([Source::Piece(piece)]);
        let mut pieces: Vec<BTreeSet<Source>> = (0..problem.arcs.len()).map(own).collect();
        let free = problem.event_is_free.iter().enumerate();
        let mut events: Vec<BTreeSet<Source>> = free
            .map(|(event, is_free)| {
                is_free
                    .then_some(Source::Event(event))
                    .into_iter()
                    .collect()
            })
            .collect();
        for (index, collision) in problem.collisions.iter().enumerate() {
            let mut before = BTreeSet::new();
            for side in &collision.sides {
                before.extend(&pieces[side.before]);
            }
            let parameters = gravity(problem).map(|part| match part {
                Part::Parameter(p) => Source::Parameter(p),
                Part::Piece(p) => Source::Piece(p),
                Part::Event(e) => Source::Event(e),
            });
            before.extend(parameters);
            if self.times_follow[index] {
                events[collision.event] = before.clone();
            }
            if !grid.shoots() {
                continue;
            }
            before.extend(&events[collision.event]);
            before.extend(collision.restitution_parameter.map(Source::Parameter));
            before.extend(collision.friction_parameter.map(Source::Parameter));
            before.extend(collision.tangential_parameter.map(Source::Parameter));
            before.extend(collision.tilts.iter().map(|(_, p)| Source::Parameter(*p)));
            if problem.velocity_gap_weight.is_some() {
                before.insert(Source::Gap(index));
            }
            for side in &collision.sides {
                if split.follows[side.after] {
                    pieces[side.after].clone_from(&before);
                }
            }
        }
        (pieces, events)
    }

    /// Gives every source its place; returns their number.
    fn place(
        &mut self,
        split: &Split,
        lifted: &Layout,
        grid: Grid,
        (pieces, events): (&[BTreeSet<Source>], &[BTreeSet<Source>]),
    ) -> usize {
        let problem = &split.problem;
        let last_use = |source: Source| {
            let by_piece = pieces.iter().zip(&lifted.arcs);
            let users = by_piece.filter(|(of, _)| of.contains(&source));
            users.map(|(_, at)| *at).max()
        };
        let mut order: Vec<(usize, Source)> = Vec::new();
        for (piece, follows) in split.follows.iter().enumerate() {
            if !follows {
                let source = Source::Piece(piece);
                order.push((last_use(source).unwrap_or(lifted.arcs[piece]), source));
            }
        }
        if grid.shoots() && problem.velocity_gap_weight.is_some() {
            for index in 0..problem.collisions.len() {
                let source = Source::Gap(index);
                order.extend(last_use(source).map(|at| (at, source)));
            }
        }
        for (event, sources) in events.iter().enumerate() {
            let source = Source::Event(event);
            if sources.contains(&source) {
                let at = last_use(source).or(lifted.events[event]);
                order.extend(at.map(|at| (at, source)));
            }
        }
        let nodes = lifted.nodes.iter().enumerate();
        order.extend(nodes.filter_map(|(node, at)| Some(((*at)?, Source::Node(node)))));
        let parameters = lifted.parameters.iter().enumerate();
        order.extend(parameters.map(|(p, at)| (*at, Source::Parameter(p))));
        order.sort_unstable();
        let mut next = 0;
        for (_, source) in order {
            let at = next;
            match source {
                Source::Node(node) => self.nodes[node] = Some(at),
                Source::Piece(piece) => self.pieces[piece] = (at..at + STATE).collect(),
                Source::Gap(index) => self.gaps[index] = Some(at),
                Source::Event(event) => self.events[event] = vec![at],
                Source::Parameter(p) => self.parameters[p] = at,
            }
            next += match source {
                Source::Piece(_) => STATE,
                Source::Gap(index) => GAP * problem.collisions[index].sides.len(),
                _ => 1,
            };
        }
        next
    }

    fn of(&self, split: &Split, source: Source) -> Vec<usize> {
        match source {
            Source::Node(node) => self.nodes[node].into_iter().collect(),
            Source::Piece(piece) => self.pieces[piece].clone(),
            Source::Gap(index) => {
                let bodies = split.problem.collisions[index].sides.len();
                let first = self.gaps[index].into_iter();
                first.flat_map(|at| at..at + GAP * bodies).collect()
            }
            Source::Event(event) => self.events[event].clone(),
            Source::Parameter(p) => vec![self.parameters[p]],
        }
    }

    /// Unknowns that a group of lifted columns depends upon.
    pub fn of_part(&self, part: Part) -> &[usize] {
        match part {
            Part::Piece(piece) => &self.pieces[piece],
            Part::Event(event) => &self.events[event],
            Part::Parameter(p) => std::slice::from_ref(&self.parameters[p]),
        }
    }

    fn union(&self, parts: impl IntoIterator<Item = Part>) -> Vec<usize> {
        let all = parts
            .into_iter()
            .flat_map(|part| self.of_part(part).to_vec());
        all.collect::<BTreeSet<usize>>().into_iter().collect()
    }

    /// Blocks and pattern.
    fn couple(&mut self, split: &Split, grid: Grid, size: usize) {
        let problem = &split.problem;
        let lifted = &self.layout.structure.blocks;
        let mut blocks = Vec::new();
        for (index, collision) in problem.collisions.iter().enumerate() {
            let contacts = collision.contacts.as_slice().len();
            let rows = match grid.shoots() {
                true if collision.touches_by_goal => contacts,
                true => 2 * contacts,
                false => lifted[index].row_count(),
            };
            let rows = rows - usize::from(self.times_follow[index]);
            let after = |part: &Part| {
                let afters = collision.sides.iter().map(|side| Part::Piece(side.after));
                grid.shoots() && afters.into_iter().any(|after| after == *part)
            };
            let parts = of_collision(problem, index).into_iter();
            let columns = self.union(parts.filter(|part| !after(part)));
            blocks.push(BlockPattern::dense(rows, columns));
        }
        for goal in 0..problem.goals.len() {
            let rows = lifted[blocks.len()].row_count();
            let columns = self.union(of_goal(problem, goal));
            blocks.push(BlockPattern::dense(rows, columns));
        }
        let bounded = problem
            .bounded
            .iter()
            .map(|of| std::slice::from_ref(&of.parameter));
        let cones = problem.cones.iter().map(|cone| cone.parameters.as_slice());
        blocks.extend(bounded.chain(cones).map(|parameters| {
            let columns = parameters.iter().map(|p| self.parameters[*p]);
            BlockPattern::dense(1, columns.collect())
        }));
        let joins = split.joins.iter();
        blocks.extend(joins.map(|(left, right)| {
            let both = [Part::Piece(*left), Part::Piece(*right)].into_iter();
            BlockPattern::dense(STATE, self.union(both.chain(gravity(problem))))
        }));
        let mut couplings = Vec::new();
        let mut clique = |members: &[usize]| {
            if let Some(first) = members.iter().min() {
                couplings.extend(members.iter().map(|member| (*member, *first)));
            }
        };
        for block in &blocks {
            for members in block.cliques() {
                clique(&members.collect::<Vec<_>>());
            }
        }
        for (piece, arc) in problem.arcs.iter().enumerate() {
            let own = self.union([Part::Piece(piece)].into_iter().chain(gravity(problem)));
            clique(&own);
            for sample in arc.samples() {
                let mut members = own.clone();
                members.extend(self.nodes[sample.node]);
                clique(&members);
            }
        }
        for three in self.nodes.windows(3) {
            clique(&three.iter().flatten().copied().collect::<Vec<_>>());
        }
        for time in &self.events {
            clique(time);
        }
        self.layout.structure.pattern = enact::optimise::envelope::Pattern::new(size, couplings);
        self.layout.structure.blocks = blocks;
        self.layout.structure.priced = Vec::new();
    }
}
