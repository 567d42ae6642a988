//! Times of events and the duration on the physical time line, with their uncertainty.
//!
//! An event whose time is an unknown has that unknown's deviation. Every other event is
//! interpolated at its mark between two nodes of the time map: its time, and the duration of the
//! motion, are linear combinations of unknowns. The zero of time is the first node.

use crate::estimate::problem::{Arc, ArcSample, Problem};
use crate::estimate::terms::context::SolveContext;
use crate::estimate::unknowns::point::Point;

/// A linear combination of unknowns, as indices with factors; empty for a fixed quantity.
pub type Moment = Vec<(usize, f64)>;

/// The clock on which an event is that ends an arc: the arc's own, unless the event's time is an
/// unknown of the common time line.
pub(in crate::estimate) fn clock_at(problem: &Problem, arc: &Arc, event: usize) -> Option<usize> {
    arc.clock.filter(|_| !problem.event_is_free[event])
}

/// In an edited sketch start and end are at the first and the last sample: the parameter that holds
/// the time of that sample, where it is not known.
fn open_at(problem: &Problem, arc: &Arc, event: usize) -> Option<usize> {
    if problem.event_is_free[event] || !problem.ends_are_samples {
        return None;
    }
    let [first, last] = arc.ends()?;
    let sample = if arc.end == Some(event) { last } else { first };
    sample.open
}

/// The parameters that are added to the time of an event at an arc.
fn added_at(problem: &Problem, arc: &Arc, event: usize) -> impl Iterator<Item = usize> {
    let added = [clock_at(problem, arc, event), open_at(problem, arc, event)];
    added.into_iter().flatten()
}

/// Physical time of an event at an arc \[s\], where sample times are known.
pub(in crate::estimate) fn time_at_s(
    problem: &Problem,
    point: &Point,
    arc: &Arc,
    event: usize,
) -> f64 {
    added_at(problem, arc, event).fold(point.event_times_s[event], |time_s, parameter| {
        time_s + point.parameters[parameter]
    })
}

/// The arc at whose end an event is, of several the last.
fn ended_by<'p>(problem: &'p Problem, point: &Point, event: usize) -> Option<&'p Arc> {
    let ended = problem.arcs.iter().filter(|arc| arc.end == Some(event));
    let time_s = |arc: &Arc| time_at_s(problem, point, arc, event);
    ended.max_by(|a, b| time_s(a).total_cmp(&time_s(b)))
}

/// Physical time of an event \[s\]; for one that is no unknown, at its mark on the clock of the
/// flight that it ends, or interpolated there.
pub(in crate::estimate) fn event_time_s(problem: &Problem, point: &Point, event: usize) -> f64 {
    if problem.event_is_free[event] || !problem.times_are_unknown() {
        return match ended_by(problem, point, event) {
            Some(arc) => time_at_s(problem, point, arc, event),
            None => point.event_times_s[event],
        };
    }
    let times_s = &point.node_times_s;
    let (node, share) = place(problem, event);
    if share > 0.0 {
        times_s[node] + share * (times_s[node + 1] - times_s[node])
    } else {
        times_s[node]
    }
}

/// The node at or before an event's mark and the share of the interval to the next; the first or
/// the last node where the mark lies outside of all.
pub(in crate::estimate) fn place(problem: &Problem, event: usize) -> (usize, f64) {
    let nodes = &problem.nodes_acted_s;
    let acted_s = problem.events_acted_s[event];
    let after = nodes.partition_point(|node| *node <= acted_s);
    match (after.checked_sub(1), nodes.get(after)) {
        (Some(before), Some(next)) => {
            let share = (acted_s - nodes[before]) / (next - nodes[before]);
            (before, share)
        }
        (Some(before), None) => (before, 0.0),
        _ => (0, 0.0),
    }
}

/// Whether an event that is no unknown lies at the first node, the zero of time, or before it.
pub(in crate::estimate) fn is_zero(problem: &Problem, event: usize) -> bool {
    place(problem, event) == (0, 0.0)
}

/// The time of an event as a linear combination of unknowns.
pub(in crate::estimate) fn event_moment(
    context: &SolveContext,
    point: &Point,
    event: usize,
) -> Moment {
    if let Some(at) = context.layout.events[event] {
        return vec![(at, 1.0)];
    }
    if let Some(arc) = ended_by(context.problem, point, event) {
        let added = added_at(context.problem, arc, event);
        let moment: Moment = added
            .map(|parameter| (context.layout.parameters[parameter], 1.0))
            .collect();
        if !moment.is_empty() {
            return moment;
        }
    }
    let (node, share) = place(context.problem, event);
    let part = |node: usize, share: f64| {
        let at = context.layout.nodes.get(node).copied().flatten()?;
        (share > 0.0).then_some((at, share))
    };
    let parts = [part(node, 1.0 - share), part(node + 1, share)];
    parts.into_iter().flatten().collect()
}

/// The duration of the motion.
pub(in crate::estimate) struct Duration {
    /// From the beginning of its first flight, or of what a hand does, to the end of its last \[s\].
    pub(in crate::estimate) duration_s: f64,
    /// The duration as a linear combination of unknowns.
    pub(in crate::estimate) moment: Moment,
}

/// The duration of the motion at a point.
pub(in crate::estimate) fn duration(context: &SolveContext, point: &Point) -> Duration {
    let (problem, layout) = (context.problem, context.layout);
    let at_event = |event: usize| {
        let time_s = event_time_s(problem, point, event);
        (time_s, event_moment(context, point, event))
    };
    let at_sample = |sample: &ArcSample| {
        let node = layout.nodes[sample.node];
        let open = sample.open.map(|parameter| layout.parameters[parameter]);
        let moment = [node, open].into_iter().flatten().map(|at| (at, 1.0));
        let time_s = sample.stamped_s(&point.node_times_s, &point.parameters);
        (time_s, moment.collect())
    };
    let ends = problem.arcs.iter().map(|arc| {
        // Only a flight that an impact begins may have no samples.
        let [first, last] = match arc.ends() {
            Some(ends) => ends.map(|sample| Some(at_sample(sample))),
            None => [None, None],
        };
        let start: Option<(f64, Moment)> = arc.start.map(at_event).or(first);
        let end: Option<(f64, Moment)> = arc.end.map(at_event).or(last);
        let start = start.expect("it begins with an event or a sample");
        let end = end.unwrap_or_else(|| start.clone());
        (start, end)
    });
    let grips = problem.grips.iter();
    let ends = ends.chain(grips.map(|[from, until]| (at_event(*from), at_event(*until))));
    let (starts, ends): (Vec<_>, Vec<_>) = ends.unzip();
    let (start_s, from) = starts
        .into_iter()
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .expect("a problem has arcs");
    let (end_s, mut moment) = ends
        .into_iter()
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .expect("a problem has arcs");
    moment.extend(from.into_iter().map(|(at, factor)| (at, -factor)));
    Duration {
        duration_s: (end_s - start_s).max(0.0),
        moment,
    }
}
