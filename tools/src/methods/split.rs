//! What a method holds states at: arcs as the program has them, or pieces of a fixed grid.
//!
//! A fixed grid cuts arcs where a node falls into them. The piece after a node has its state there;
//! the piece after a collision has none of its own, it follows through the impact. Samples stay with
//! the arc that the segmentation gave them, so that every grid has the same optimum.

use enact::estimate::problem::{Arc, ArcCollision, Problem};
use enact::estimate::unknowns::point::Point;
use enact::motion::Guess;
use enact::physics::{State, flow};

use super::touch::touching;

/// Where states are held, and what follows from them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Grid {
    /// A state in the middle of every arc; event times are unknowns.
    Lifted,
    /// The same; the time of a collision follows from the state before it.
    Implicit,
    /// States at the beginnings of so many intervals of one length; collisions within them, and what
    /// comes after, follow.
    Shooting {
        /// One: single shooting.
        intervals: usize,
    },
}

impl Grid {
    /// Whether times of collisions follow from the state before them.
    pub fn finds_times(self) -> bool {
        self != Grid::Lifted
    }

    /// Whether the state after a collision follows from the one before.
    pub fn shoots(self) -> bool {
        matches!(self, Grid::Shooting { .. })
    }
}

/// A problem whose arcs are pieces.
pub struct Split {
    /// The problem; where velocity gaps have a price there, it is zero here.
    pub problem: Problem,
    /// Arc of the given problem that each piece is of.
    pub arc_of: Vec<usize>,
    /// Whether a piece's state follows from a collision.
    pub follows: Vec<bool>,
    /// Pieces before and after each node; the state of the one after is held at the node's time.
    pub joins: Vec<(usize, usize)>,
    /// Times at which the pieces' states are held \[s\].
    pub epochs_s: Vec<f64>,
    /// The arcs' own fits.
    pub start: Point,
}

/// Cuts the arcs of a problem for a grid.
pub fn split(problem: &Problem, guess: &Guess, grid: Grid) -> Split {
    let mut fits = Point::new(problem, guess);
    if grid.finds_times() {
        fits = touching(problem, guess, fits);
    }
    let gravity = problem.gravity(&fits.parameters);
    let nodes_s = nodes_s(&fits, grid);
    let mut split = Split {
        problem: Problem {
            arcs: Vec::new(),
            velocity_gap_weight: problem.velocity_gap_weight.map(|_| 0.0),
            ..problem.clone()
        },
        arc_of: Vec::new(),
        follows: Vec::new(),
        joins: Vec::new(),
        epochs_s: Vec::new(),
        start: Point {
            arcs: Vec::new(),
            ..fits.clone()
        },
    };
    // First and last piece of every arc.
    let mut ends = Vec::new();
    for (index, arc) in problem.arcs.iter().enumerate() {
        let [start_s, end_s] = extent_s(arc, &fits);
        let inner = nodes_s.iter().filter(|t| start_s < **t && **t < end_s);
        let cuts_s: Vec<f64> = inner.copied().collect();
        let after_collision = |c: &ArcCollision| c.sides.iter().any(|side| side.after == index);
        let follows = grid.shoots() && problem.collisions.iter().any(after_collision);
        let first = split.arc_of.len();
        for piece in 0..=cuts_s.len() {
            let from_s = piece.checked_sub(1).map(|cut| cuts_s[cut]);
            let to_s = cuts_s.get(piece).copied();
            let time_s = |node: usize| fits.node_times_s[node];
            let is_of = |node: usize| {
                from_s.is_none_or(|from_s| time_s(node) >= from_s)
                    && to_s.is_none_or(|to_s| time_s(node) < to_s)
            };
            let mut piece_of = arc.clone();
            for view in &mut piece_of.views {
                view.samples.retain(|sample| is_of(sample.node));
            }
            split.problem.arcs.push(piece_of);
            let follows = follows && piece == 0;
            let epoch_s = match (from_s, grid.shoots()) {
                (_, false) => guess.arcs[index].epoch_s,
                (Some(node_s), _) => node_s,
                (None, _) if follows => 0.5 * (start_s + to_s.unwrap_or(end_s)),
                (None, _) => start_s,
            };
            let body = &problem.bodies[arc.mechanism];
            let past_s = epoch_s - guess.arcs[index].epoch_s;
            let state: State = flow::advance(body, &gravity, &fits.arcs[index], past_s);
            if piece > 0 {
                split.joins.push((first + piece - 1, first + piece));
            }
            split.start.arcs.push(state);
            split.epochs_s.push(epoch_s);
            split.follows.push(follows);
            split.arc_of.push(index);
        }
        ends.push((first, split.arc_of.len() - 1));
    }
    tie(&mut split.problem, problem, &ends);
    split
}

/// Collisions and goals of the pieces.
fn tie(pieces: &mut Problem, problem: &Problem, ends: &[(usize, usize)]) {
    for collision in &mut pieces.collisions {
        for side in &mut collision.sides {
            side.before = ends[side.before].1;
            side.after = ends[side.after].0;
        }
    }
    for goal in &mut pieces.goals {
        let (first, last) = ends[goal.arc];
        let at_end = problem.arcs[goal.arc].end == Some(goal.event);
        goal.arc = if at_end { last } else { first };
    }
}

/// Times of the nodes within the motion \[s\].
fn nodes_s(fits: &Point, grid: Grid) -> Vec<f64> {
    let Grid::Shooting { intervals } = grid else {
        return Vec::new();
    };
    let times_s = &fits.node_times_s;
    let (first_s, last_s) = (times_s[0], times_s[times_s.len() - 1]);
    let share = |node: usize| node as f64 / intervals as f64;
    let nodes = (1..intervals).map(|node| first_s + share(node) * (last_s - first_s));
    nodes.collect()
}

/// From when to when an arc lasts \[s\].
fn extent_s(arc: &Arc, fits: &Point) -> [f64; 2] {
    let time_s = |event: usize| fits.event_times_s[event];
    let times_s = arc.samples().map(|s| s.time_s(&fits.node_times_s));
    let first_s = times_s.clone().fold(f64::INFINITY, f64::min);
    let last_s = times_s.fold(f64::NEG_INFINITY, f64::max);
    [
        arc.start.map_or(first_s, time_s),
        arc.end.map_or(last_s, time_s),
    ]
}
