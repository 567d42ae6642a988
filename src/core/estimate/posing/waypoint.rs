//! Waypoints: moments of flights at which goals hold.
//!
//! The flight is not cut. A waypoint adds one unknown, its time `τ`, and the rows of its goals are those
//! of goals at any event: a quantity of `Φ(q_a, τ)`, of which `τ` is no end. It stays within the flight,
//! and after the waypoints before it:
//!
//! ```text
//! τ_start ≤ τ_1 ≤ τ_2 ≤ … ≤ τ_end
//! ```
//!
//! where a flight without an event at an end begins or ends with its samples. Beside its goals, its mark
//! tells when it is; where neither does, its time is undetermined.

use super::conditions::flight_at;
use crate::estimate::constraint::At;
use crate::estimate::problem::{
    Arc, ArcSample, EventMark, Ordered, Problem, TimeBound, TimeSide, Waypoint,
};
use crate::estimate::terms::context::SolveContext;
use crate::estimate::unknowns::point::Point;
use crate::motion::{Goal, GoalTarget, LinkIndex, MechanismIndex, Moment, Scene, Sketch, Timing};
use crate::optimise::block::Block;

/// The waypoints whose flights are there.
pub(in crate::estimate) fn waypoints(scene: &Scene, arcs: &[Arc]) -> Vec<Waypoint> {
    let events = scene.events.iter().enumerate();
    let all = events.filter_map(|(event, of)| Some((event, of.kind.waypoint()?)));
    let on_arcs = all.filter_map(|(event, link)| {
        let mechanism = scene.mechanism_of(link);
        let arc = flight_at(scene, arcs, mechanism, event, Moment::Before)?;
        Some(Waypoint { event, arc })
    });
    on_arcs.collect()
}

/// What keeps waypoints within the flights of the bodies that their goals are about.
pub(in crate::estimate) fn kept_within(
    scene: &Scene,
    sketch: &Sketch,
    nodes_acted_s: &[f64],
    arcs: &[Arc],
    waypoints: &[Waypoint],
    event_is_free: &[bool],
) -> (Vec<Ordered>, Vec<TimeBound>) {
    let (mut ordered, mut bounds) = (Vec::new(), Vec::new());
    for waypoint in waypoints {
        let event = waypoint.event;
        let mut keep = |side: TimeSide, neighbour: Option<usize>, sample: Option<&ArcSample>| {
            let at_s = match neighbour {
                Some(other) if event_is_free[other] => {
                    let events = match side {
                        TimeSide::Earliest => [other, event],
                        _ => [event, other],
                    };
                    ordered.push(Ordered { events });
                    return;
                }
                // Where times are unknown, an event beyond the nodes is at the last of them.
                Some(other) => Some(match (scene.timing, nodes_acted_s) {
                    (Timing::Unknown { .. }, [first_s, .., last_s]) => {
                        sketch.marks_s[other].clamp(*first_s, *last_s)
                    }
                    _ => sketch.marks_s[other],
                }),
                None => sample.map(|sample| sample.time_s(nodes_acted_s)),
            };
            bounds.extend(at_s.map(|acted_s| TimeBound {
                event,
                side,
                acted_s,
                nodes: match scene.timing {
                    Timing::Unknown { .. } => EventMark::nodes_about(nodes_acted_s, acted_s),
                    Timing::Known | Timing::Edited => None,
                },
                half_width_s: f64::INFINITY,
            }));
        };
        let own = arcs[waypoint.arc].mechanism;
        for mechanism in mechanisms(scene, event, own) {
            let Some(arc) = flight_at(scene, arcs, mechanism, event, Moment::Before) else {
                continue;
            };
            let is_beside = |other: &usize| {
                let is_own = waypoints
                    .iter()
                    .any(|of| of.event == *other && of.arc == arc);
                scene.concerns(*other, mechanism) || mechanism == own && is_own
            };
            let [first, last] = arcs[arc].ends().map_or([None; 2], |ends| ends.map(Some));
            let before = (0..event).rev().find(is_beside);
            let after = (event + 1..scene.events.len()).find(is_beside);
            keep(TimeSide::Earliest, before, first);
            keep(TimeSide::Latest, after, last);
        }
    }
    (ordered, bounds)
}

/// The mechanism of a waypoint, and those that its goals are about.
fn mechanisms(scene: &Scene, event: usize, own: MechanismIndex) -> Vec<MechanismIndex> {
    let mut all = vec![own];
    let here = scene.goals.iter().filter(|goal| goal.event == event);
    for goal in here {
        let links = goal_links(goal).map(|link| scene.mechanism_of(link));
        for mechanism in links {
            if !all.contains(&mechanism) {
                all.push(mechanism);
            }
        }
    }
    all
}

/// The links whose states a goal is about: none of a time.
fn goal_links(goal: &Goal) -> impl Iterator<Item = LinkIndex> {
    let (own, other) = match &goal.target {
        GoalTarget::Condition(of) if of.quantity.is_time() => (None, None),
        GoalTarget::Condition(of) => (Some(goal.link), of.quantity.seen_from()),
        _ => (Some(goal.link), None),
    };
    own.into_iter().chain(other)
}

/// Reach of the search on either side of a mark, in its standard deviations.
const REACH_DEVIATIONS: f64 = 4.0;
/// Greatest time and greatest angle that a body turns between two times that are tried \[s, rad\].
const STEP_S: f64 = 0.005;
const STEP_RAD: f64 = 0.25;
/// Greatest number of times that are tried.
const STEPS_MAX: f64 = 2000.0;

/// Moves waypoints to where the unchanged arcs of `point` come nearest to their goals, near their marks.
/// From a mark that is off by a tenth of a second, a body that turns fast would be led to another turn.
pub(in crate::estimate) fn align(context: &SolveContext, point: &mut Point) {
    for waypoint in &context.problem.waypoints {
        align_one(context, point, waypoint);
    }
}

fn align_one(context: &SolveContext, point: &mut Point, waypoint: &Waypoint) {
    let problem = context.problem;
    let event = waypoint.event;
    let [from_s, to_s] = reach_s(problem, point, waypoint);
    if !(to_s > from_s) {
        return;
    }
    let spin_rad_s = point.arcs[waypoint.arc].angular_velocity_rad_s.norm();
    let step_s = STEP_S.min(STEP_RAD / spin_rad_s);
    let steps = ((to_s - from_s) / step_s).ceil().clamp(1.0, STEPS_MAX);
    let mut there = point.clone();
    let mut missed = |time_s: f64| {
        there.event_times_s[event] = time_s;
        miss(context, &there, event)
    };
    let now_s = point.event_times_s[event].clamp(from_s, to_s);
    let grid = (0..=steps as usize).map(|step| from_s + (to_s - from_s) * step as f64 / steps);
    // The mark first: it stays where nothing is nearer.
    let tried = [now_s].into_iter().chain(grid);
    let tried = tried.map(|time_s| (missed(time_s), time_s));
    let best = tried.min_by(|a, b| a.0.total_cmp(&b.0));
    point.event_times_s[event] = best.map_or(now_s, |(_, time_s)| time_s);
}

/// The part of its flight in which a waypoint is looked for: after the waypoint before it, within its
/// bounds, near its mark \[s\].
fn reach_s(problem: &Problem, point: &Point, waypoint: &Waypoint) -> [f64; 2] {
    let arc = &problem.arcs[waypoint.arc];
    let [first_s, last_s] = match arc.ends() {
        Some(ends) => ends.map(|sample| sample.time_s(&point.node_times_s)),
        None => [f64::NEG_INFINITY, f64::INFINITY],
    };
    let time_s = |event: Option<usize>| event.map(|event| point.event_times_s[event]);
    let mut from_s = time_s(arc.start).unwrap_or(first_s);
    let mut to_s = time_s(arc.end).unwrap_or(last_s);
    let others = problem.waypoints.iter();
    for before in others.filter(|of| of.arc == waypoint.arc && of.event < waypoint.event) {
        from_s = from_s.max(point.event_times_s[before.event]);
    }
    for bound in problem
        .time_bounds
        .iter()
        .filter(|of| of.event == waypoint.event)
    {
        let bound_s = bound.time_s(problem, point);
        if bound.side != TimeSide::Latest {
            from_s = from_s.max(bound_s);
        }
        if bound.side != TimeSide::Earliest {
            to_s = to_s.min(bound_s);
        }
    }
    if let Some(mark) = problem.marks.iter().find(|of| of.event == waypoint.event) {
        let term = mark.term(problem, point);
        let sd_s = mark.counted.sqrt() / term.jacobian[0].abs();
        let marked_s = point.event_times_s[waypoint.event] - term.residual / term.jacobian[0];
        from_s = from_s.max(marked_s - REACH_DEVIATIONS * sd_s);
        to_s = to_s.min(marked_s + REACH_DEVIATIONS * sd_s);
    }
    [from_s, to_s]
}

/// Sum of squared violations of a waypoint's goals, in units, and of its mark, in standard deviations.
fn miss(context: &SolveContext, point: &Point, event: usize) -> f64 {
    let (problem, structure) = (context.problem, &context.layout.structure);
    let mut at = At::new(problem, point, &context.epochs_s);
    let (mut rows, mut priced) = (Block::default(), Block::default());
    let marks = problem.marks.iter().filter(|mark| mark.event == event);
    let off = marks.map(|mark| mark.term(problem, point).residual.powi(2) / mark.counted);
    let mut sum: f64 = off.sum();
    let patterns = structure.blocks.iter().zip(&structure.priced);
    for (constraint, patterns) in problem.constraints().zip(patterns) {
        if constraint.event() != Some(event) {
            continue;
        }
        let both = [(patterns.0, &mut rows), (patterns.1, &mut priced)];
        constraint.fill(&mut at, both);
        // A wish weighs no more than what is hard.
        let weight = constraint.price(problem, 1.0).min(1.0);
        for (block, weight) in [(&rows, 1.0), (&priced, weight)] {
            let each = 0..block.values.len();
            let violations = each.map(|row| block.violation(row).powi(2));
            sum += weight * violations.sum::<f64>();
        }
    }
    if sum.is_nan() { f64::INFINITY } else { sum }
}
