//! Order of the unknowns: along time, so that the normal matrix has a narrow envelope.
//!
//! Between two events come the sample times (where they are unknown), then the states of the
//! arcs that end at the next event, those of held bodies at it, the times of waypoints on these arcs, then that event's time; parameters, which everything may
//! share, come last. Bodies that never meet are not coupled and come one after the other.

use std::ops::Range;

use typed_index_collections::TiVec;

use crate::estimate::problem::weave::WovenArc;
use crate::estimate::problem::{Arc, EventMark, Problem};
use crate::motion::MechanismIndex;
use crate::optimise::Structure;
use crate::optimise::envelope::Pattern;
use crate::physics::state;

/// Indices of the unknowns: the first of every part.
#[derive(Clone, Debug)]
pub struct Layout {
    /// Index of each arc's state: as many unknowns as the arc's dynamics has dimensions.
    pub arcs: Vec<usize>,
    /// Index of each held body's state at a collision.
    pub held: Vec<usize>,
    /// Index of each event's time, where it is free.
    pub events: Vec<Option<usize>>,
    /// Index of each node's time, where it is unknown. The first node is fixed: it is the zero of
    /// time.
    pub nodes: Vec<Option<usize>>,
    /// Index of each parameter.
    pub parameters: Vec<usize>,
    /// Which unknowns are coupled by a residual, by the rows of every constraint
    /// ([`Problem::constraints`]) and by its priced rows.
    pub structure: Structure,
}

impl Layout {
    /// The layout of a problem.
    pub fn new(problem: &Problem) -> Self {
        let mut next = 0;
        let mut take = |count: usize| {
            next += count;
            next - count
        };
        let mut arcs = vec![0; problem.arcs.len()];
        let mut held = vec![0; problem.held.len()];
        let mut events = vec![None; problem.event_is_free.len()];
        let mut nodes = vec![None; problem.nodes_acted_s.len()];
        let mut next_node = 1;
        let groups = groups(problem);
        let count = groups.iter().max().map_or(0, |last| last + 1);
        let is_waypoint = |event: usize| problem.waypoints.iter().any(|of| of.event == event);
        // An event at which no flight ends belongs to the first group.
        let owner = |event: usize| {
            let mut ending = problem.arcs.iter().filter(|arc| arc.end == Some(event));
            ending.next().map_or(0, |arc| groups[arc.mechanism])
        };
        // One round per event and one for what ends without any.
        let rounds = (0..events.len()).map(Some).chain([None]);
        for (group, event) in (0..count).flat_map(|g| rounds.clone().map(move |event| (g, event))) {
            let is_here = |arc: &usize| {
                let arc = &problem.arcs[*arc];
                arc.end == event && groups[arc.mechanism] == group
            };
            let here: Vec<usize> = (0..arcs.len()).filter(is_here).collect();
            if problem.times_are_unknown() {
                let last = here
                    .iter()
                    .filter_map(|arc| problem.arcs[*arc].ends())
                    .map(|[_, last]| last.node)
                    .max();
                while last.is_some_and(|last| next_node <= last) {
                    nodes[next_node] = Some(take(1));
                    next_node += 1;
                }
            }
            for arc in here {
                arcs[arc] = take(state::DIMENSION);
            }
            for (at, of) in held.iter_mut().zip(&problem.held) {
                if event == Some(of.event) && group == owner(of.event) {
                    *at = take(state::DIMENSION);
                }
            }
            // Waypoints come after their flight.
            let passed = problem.waypoints.iter().filter(|of| {
                let arc = &problem.arcs[of.arc];
                arc.end == event && groups[arc.mechanism] == group
            });
            for waypoint in passed {
                events[waypoint.event] = Some(take(1));
            }
            if let Some(event) = event
                && problem.event_is_free[event]
                && !is_waypoint(event)
                && group == owner(event)
            {
                events[event] = Some(take(1));
            }
        }
        let parameters: Vec<usize> = problem.parameters.iter().map(|_| take(1)).collect();
        let mut layout = Self {
            arcs,
            held,
            events,
            nodes,
            parameters,
            structure: Structure {
                pattern: Pattern::new(0, []),
                blocks: Vec::new(),
                priced: Vec::new(),
            },
        };
        for constraint in problem.constraints() {
            let [rows, priced] = constraint.patterns(problem, &layout);
            layout.structure.blocks.push(rows);
            layout.structure.priced.push(priced);
        }
        layout.structure.pattern = Pattern::new(next, layout.couplings(problem));
        layout
    }

    /// Number of unknowns.
    pub fn size(&self) -> usize {
        self.structure.size()
    }

    /// Unknowns that hold an arc's state.
    pub fn state(&self, arc: usize) -> Range<usize> {
        self.arcs[arc]..self.arcs[arc] + state::DIMENSION
    }

    /// Unknowns of a flight of which samples err in time: its state, then its nodes' times where these are unknown.
    pub fn woven(&self, of: &WovenArc) -> impl Iterator<Item = usize> {
        let nodes = self.nodes[of.moved.clone()].iter();
        self.state(of.arc).chain(nodes.flatten().copied())
    }

    /// Unknowns that hold components of gravity.
    pub fn gravity(&self, problem: &Problem) -> Vec<usize> {
        problem
            .gravity_parameters
            .iter()
            .flatten()
            .map(|p| self.parameters[*p])
            .collect()
    }

    /// Unknowns of a mark's residual: its event's time and the times of both nodes.
    pub fn of_mark(&self, mark: &EventMark) -> [Option<usize>; 3] {
        let node = |side: usize| mark.nodes.and_then(|nodes| self.nodes[nodes[side]]);
        [self.events[mark.event], node(0), node(1)]
    }

    /// Every pair of coupled unknowns, or at least the first column of each row.
    fn couplings(&self, problem: &Problem) -> Vec<(usize, usize)> {
        let mut couplings = Vec::new();
        let mut clique = |members: &[usize]| {
            if let Some(first) = members.iter().min() {
                couplings.extend(members.iter().map(|member| (*member, *first)));
            }
        };
        let gravity = self.gravity(problem);
        for (index, arc) in problem.arcs.iter().enumerate() {
            let mut members: Vec<usize> = self.state(index).collect();
            members.extend(&gravity);
            let acting = arc.acting.iter().map(|a| self.parameters[a.parameter]);
            members.extend(acting);
            clique(&members);
            let own = members.len();
            let mut before = None;
            for sample in arc.samples() {
                let place = (sample.node, sample.share > 0.0);
                // The next sample between the same nodes couples nothing more.
                if before.replace(place) == Some(place) {
                    continue;
                }
                members.extend(self.nodes[sample.node]);
                if sample.share > 0.0 {
                    members.extend(self.nodes[sample.node + 1]);
                }
                clique(&members);
                members.truncate(own);
            }
        }
        for hand in problem.weave.iter().flat_map(|weave| &weave.hands) {
            let parameters = hand.parameters.iter().map(|at| self.parameters[*at]);
            let shared: Vec<usize> = parameters.collect();
            for (place, woven) in hand.arcs.iter().enumerate() {
                let arcs = &hand.arcs[place - woven.remembered..=place];
                let own = arcs.iter().flat_map(|of| self.woven(of));
                clique(&own.chain(shared.iter().copied()).collect::<Vec<_>>());
            }
        }
        let structure = &self.structure;
        for pattern in structure.blocks.iter().chain(&structure.priced) {
            for members in pattern.cliques() {
                clique(&members.collect::<Vec<_>>());
            }
        }
        for mark in &problem.marks {
            clique(&self.of_mark(mark).into_iter().flatten().collect::<Vec<_>>());
        }
        for (of, at) in problem.held.iter().zip(&self.held) {
            let others = of.others(self).into_iter().flatten();
            let all = (*at..*at + state::DIMENSION).chain(others);
            clique(&all.collect::<Vec<_>>());
        }
        // The tempo prior compares neighbouring rates: three times in a row.
        for three in self.nodes.windows(3) {
            clique(&three.iter().flatten().copied().collect::<Vec<_>>());
        }
        couplings
    }
}

/// For every mechanism its group, numbered from zero: mechanisms at one event are in one group, and all
/// mechanisms are where their samples share unknown times.
fn groups(problem: &Problem) -> TiVec<MechanismIndex, usize> {
    let mut groups: TiVec<MechanismIndex, usize> = (0..problem.bodies.len()).collect();
    let mut join = |members: &[MechanismIndex]| {
        let Some(first) = members.iter().map(|one| groups[*one]).min() else {
            return;
        };
        let joined: Vec<usize> = members.iter().map(|one| groups[*one]).collect();
        for group in &mut groups {
            if joined.contains(group) {
                *group = first;
            }
        }
    };
    if problem.times_are_unknown() {
        join(&problem.bodies.keys().collect::<Vec<_>>());
    }
    for (event, is_free) in problem.event_is_free.iter().enumerate() {
        let at = |arc: &&Arc| arc.end == Some(event) || arc.start == Some(event);
        let flying = problem.arcs.iter().filter(at).map(|arc| arc.mechanism);
        if *is_free {
            join(&flying.collect::<Vec<_>>());
        }
    }
    for collision in &problem.collisions {
        join(
            &collision
                .sides
                .iter()
                .map(|side| side.mechanism)
                .collect::<Vec<_>>(),
        );
    }
    let mut numbers: Vec<usize> = groups.iter().copied().collect();
    numbers.sort_unstable();
    numbers.dedup();
    let number = |group: &usize| numbers.binary_search(group).expect("it is one of them");
    groups.iter().map(number).collect()
}
