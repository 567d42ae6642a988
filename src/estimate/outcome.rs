//! The solver's result as an estimate of the scene: events, arcs, gaps, residuals and verdict.

use super::context::SolveContext;
use super::held_motion;
use super::observed::Observer;
use super::point::Point;
use super::problem::{Problem, TimeSide, unit};
use super::recipe::Solution;
use super::timing;
use crate::math::so3;
use crate::motion::{
    ArcEstimate, AtBound, Counters, DurationEstimate, End, Estimate, EventEstimate, Gap, Measured,
    ParameterEstimate, Progress, Reason, SampleTime, Scene, Segment, SegmentResidual, Sketch,
    Verdict,
};
use crate::optimise::System;
use crate::physics::{Dynamics, State};

/// Greatest gaps of a physical motion: rounding.
pub const PHYSICAL: Gap = Gap {
    position_m: 1e-9,
    orientation_rad: 1e-9,
    velocity_m_s: 1e-8,
    angular_velocity_rad_s: 1e-7,
};

/// Least interval between events that are not at the bound of their order \[s\].
const APART_S: f64 = 1e-9;
/// Greatest violation of a bound of a time \[s\].
const PHYSICAL_TIME_S: f64 = 1e-9;
/// A quantity is at its bound if it is nearer to it than this share of a typical change of it.
const NEAR: f64 = 1e-6;

/// The estimate of a scene from the solver's solution, without standard deviations; `errors` are
/// the residuals of its samples ([`errors`]), `counters` the work.
pub fn estimate(
    scene: &Scene,
    sketch: &Sketch,
    segments: &[Segment],
    context: &SolveContext,
    (solution, errors): (&Solution, &[Vec<[f64; 6]>]),
    counters: Counters,
) -> Estimate {
    let problem = context.problem;
    let point = &solution.point;
    let events = events(scene, sketch, problem, solution);
    let arcs = arcs(problem, context, point, &events);
    let (verdict, end) = judge(problem, solution, (&events, &arcs));
    let parameters = problem.parameters.iter().zip(&point.parameters);
    let sample_times = sample_times(sketch, segments, problem, point);
    let held = held_motion::estimates((scene, sketch), problem, point, &sample_times);
    Estimate {
        verdict,
        reason: Reason::from(end),
        doubts: Vec::new(),
        objective: 2.0 * solution.system.cost,
        gravity_m_s2: problem.gravity(&point.parameters),
        arcs,
        residuals: residuals(problem, errors),
        held,
        sample_times,
        events,
        duration: DurationEstimate {
            duration_s: timing::duration(context, point).duration_s,
            sd_s: None,
        },
        parameters: parameters
            .enumerate()
            .map(|(index, (free, value))| ParameterEstimate {
                name: free.name.clone(),
                value: *value,
                sd: None,
                at_bound: parameter_bound(problem, point, index),
                lower: free.lower,
                upper: free.upper,
            })
            .collect(),
        fit: None,
        suspects: Vec::new(),
        undetermined: Vec::new(),
        counters,
    }
}

fn events(
    scene: &Scene,
    sketch: &Sketch,
    problem: &Problem,
    solution: &Solution,
) -> Vec<EventEstimate> {
    let point = &solution.point;
    (0..scene.events.len())
        .map(|event| EventEstimate {
            event,
            time_s: timing::event_time_s(problem, point, event),
            sd_s: None,
            is_fixed: !scene.time_is_free(event) && is_at_mark(problem, event),
            at_bound: time_bound(problem, point, event),
            acted_s: sketch.marks_s[event],
            gap: gap(problem, &solution.system, event),
        })
        .collect()
}

/// Whether the time of an event that is not free is given: by physical stamps, or as the zero of
/// time. In an unknown tempo it is as certain as the time map at its mark.
fn is_at_mark(problem: &Problem, event: usize) -> bool {
    !problem.times_are_unknown() || timing::is_zero(problem, event)
}

/// The bound at which the time of an event is.
fn time_bound(problem: &Problem, point: &Point, event: usize) -> Option<AtBound> {
    let bounds = problem.time_bounds.iter();
    let mut at = bounds.filter(|bound| {
        let off_s = bound.time_s(problem, point) - point.event_times_s[event];
        bound.event == event && off_s.abs() <= NEAR * unit::TIME_S
    });
    at.find_map(|bound| match bound.side {
        TimeSide::Earliest => Some(AtBound::Lower),
        TimeSide::Latest => Some(AtBound::Upper),
        TimeSide::Only => None,
    })
}

/// The bound at which a parameter is, or that of the cone that it is in.
fn parameter_bound(problem: &Problem, point: &Point, index: usize) -> Option<AtBound> {
    let free = &problem.parameters[index];
    let value = point.parameters[index];
    let is_at = |bound: f64| (value - bound).abs() <= NEAR * free.length();
    let mut cones = problem.cones.iter();
    let is_at_cone = cones.any(|cone| {
        let [a, b] = cone.parameters.map(|of| point.parameters[of]);
        cone.parameters.contains(&index) && a.hypot(b) >= cone.limit * (1.0 - NEAR)
    });
    match () {
        () if is_at_cone => Some(AtBound::Cone),
        () if is_at(free.lower) => Some(AtBound::Lower),
        () if is_at(free.upper) => Some(AtBound::Upper),
        () => None,
    }
}

/// Largest remaining gap of each kind at an event.
fn gap(problem: &Problem, system: &System, event: usize) -> Gap {
    let rows = system.blocks.iter().zip(&system.priced);
    let constraints = problem.constraints().zip(rows);
    let at_event = constraints.filter(|(constraint, _)| constraint.event() == Some(event));
    at_event
        .map(|(constraint, rows)| constraint.gap(problem, rows.into()))
        .fold(Gap::default(), |a, b| a.max(&b))
}

/// The verdict and how the estimation ended. A motion whose events or flights are not in order of time
/// (paper eq. 7) fails.
fn judge(
    problem: &Problem,
    solution: &Solution,
    (events, arcs): (&[EventEstimate], &[ArcEstimate]),
) -> (Verdict, End) {
    let is_bent = problem.velocity_gap_weight.is_some();
    let finished = &solution.finished;
    let progress = Progress {
        violation: Measured {
            value: finished.violation,
            bound: finished.tolerances.violation,
        },
        decrease: Measured {
            value: finished.decrease,
            bound: finished.tolerances.decrease,
        },
    };
    let end = match (finished.converged, solution.stopped) {
        (true, _) => End::Converged(progress),
        (false, true) => End::Stopped(progress),
        (false, false) => End::NoProgress(progress),
    };
    let mut states = solution.point.arcs.iter().chain(&solution.point.held);
    let finite = states.all(State::is_finite);
    if !finite || !solution.system.cost.is_finite() {
        return (Verdict::Failed, End::NotFinite);
    }
    // Events of bodies that never meet need no order.
    let time_s = |event: Option<usize>| {
        let found = events.iter().find(|of| Some(of.event) == event)?;
        Some((found.event, found.time_s))
    };
    for arc in &problem.arcs {
        // Where nothing but their order holds two events apart, they are at its bound.
        let least_s = if arc.is_informed() { 0.0 } else { APART_S };
        if let (Some(start), Some(end)) = (time_s(arc.start), time_s(arc.end))
            && end.1 - start.1 < least_s
        {
            let reversed = End::EventsReversed {
                first: start.0,
                last: end.0,
                interval_s: end.1 - start.1,
            };
            return (Verdict::Failed, reversed);
        }
    }
    // A flight without an event at an end extends to its samples.
    if let Some(arc) = arcs.iter().find(|arc| arc.end_s < arc.start_s) {
        let reversed = End::FlightReversed {
            mechanism: arc.mechanism,
            start_s: arc.start_s,
            end_s: arc.end_s,
        };
        return (Verdict::Failed, reversed);
    }
    let joins = |event: &EventEstimate| {
        event.gap.position_m <= PHYSICAL.position_m
            && event.gap.orientation_rad <= PHYSICAL.orientation_rad
    };
    let obeys = |event: &EventEstimate| {
        event.gap.velocity_m_s <= PHYSICAL.velocity_m_s
            && event.gap.angular_velocity_rad_s <= PHYSICAL.angular_velocity_rad_s
    };
    let blocks = problem.constraints().zip(&solution.system.blocks);
    let off_s = blocks.map(|(constraint, rows)| constraint.time_gap_s(rows));
    let is_off = off_s.fold(0.0, f64::max) > PHYSICAL_TIME_S;
    if is_off || !events.iter().all(joins) {
        return (Verdict::Failed, end);
    }
    if events.iter().all(obeys) {
        return (Verdict::Physical, end);
    }
    // Without priced gaps, remaining ones mean that the solve did not converge.
    if !finished.converged || !is_bent {
        return (Verdict::Failed, end);
    }
    let bent = events.iter().filter(|event| !obeys(event));
    let jumps = End::VelocityJumps {
        events: bent.map(|event| event.event).collect(),
        progress,
    };
    (Verdict::Plausible, jumps)
}

fn arcs(
    problem: &Problem,
    context: &SolveContext,
    point: &Point,
    events: &[EventEstimate],
) -> Vec<ArcEstimate> {
    let times = |arc: usize| {
        problem.arcs[arc]
            .samples
            .iter()
            .map(move |s| problem.sample_time_s(arc, s, point))
    };
    let mut arcs: Vec<ArcEstimate> = problem
        .arcs
        .iter()
        .enumerate()
        .map(|(index, arc)| {
            let start_s = match arc.start {
                Some(event) => events[event].time_s,
                None => times(index).fold(f64::INFINITY, f64::min),
            };
            ArcEstimate {
                mechanism: arc.mechanism,
                epoch_s: context.epochs_s[index],
                state: point.arcs[index],
                start_s,
                // Without event and samples it ends where it begins.
                end_s: match arc.end {
                    Some(event) => events[event].time_s,
                    None => times(index).reduce(f64::max).unwrap_or(start_s),
                },
            }
        })
        .collect();
    arcs.sort_by(|a, b| {
        let order = a.mechanism.cmp(&b.mechanism);
        order.then(a.start_s.total_cmp(&b.start_s))
    });
    arcs
}

/// Residuals of every sample, arc by arc, in the problem's units: position, then orientation.
pub fn errors(problem: &Problem, context: &SolveContext, point: &Point) -> Vec<Vec<[f64; 6]>> {
    let gravity = problem.gravity(&point.parameters);
    let arcs = problem.arcs.iter().enumerate();
    let dynamics = problem.dynamics_at(&point.parameters);
    let dynamics = dynamics.expect("moments that the solution has");
    arcs.map(|(index, arc)| {
        let Dynamics::Free(body) = &dynamics[arc.mechanism];
        let flight = (&point.arcs[index], context.epochs_s[index]);
        let parameters = &point.parameters;
        let mut observer = Observer::new(problem, index, (body, &gravity), flight, parameters);
        let samples = arc.samples.iter();
        samples
            .map(|sample| {
                let [flown, seen] = observer.seen(sample, &point.node_times_s);
                let shift = (flown.0 - seen.0) / problem.position_unit_m;
                let turn = so3::log(&(seen.1.inverse() * flown.1)) / problem.orientation_unit_rad;
                [shift.x, shift.y, shift.z, turn.x, turn.y, turn.z]
            })
            .collect()
    })
    .collect()
}

fn residuals(problem: &Problem, errors: &[Vec<[f64; 6]>]) -> Vec<SegmentResidual> {
    let mut order: Vec<usize> = (0..problem.arcs.len()).collect();
    order.sort_by_key(|arc| problem.arcs[*arc].mechanism);
    let rms = |errors: &[[f64; 6]], part: std::ops::Range<usize>| {
        let squares = errors
            .iter()
            .map(|e| e[part.clone()].iter().map(|r| r * r).sum::<f64>());
        (squares.sum::<f64>() / errors.len().max(1) as f64).sqrt()
    };
    order
        .into_iter()
        .map(|index| SegmentResidual {
            track: problem.arcs[index].track,
            samples: errors[index].len(),
            position_rms_m: rms(&errors[index], 0..3) * problem.position_unit_m,
            orientation_rms_rad: rms(&errors[index], 3..6) * problem.orientation_unit_rad,
        })
        .collect()
}

fn sample_times(
    sketch: &Sketch,
    segments: &[Segment],
    problem: &Problem,
    point: &Point,
) -> Vec<SampleTime> {
    let mut order: Vec<usize> = (0..segments.len()).collect();
    order.sort_by_key(|segment| segments[*segment].mechanism);
    order
        .into_iter()
        .flat_map(|index| {
            let segment = &segments[index];
            let samples = sketch.samples_of(segment);
            samples
                .iter()
                .zip(&problem.arcs[index].samples)
                .map(move |(sample, arc)| SampleTime {
                    track: segment.track,
                    stamp: sample.stamp,
                    time_s: problem.sample_time_s(index, arc, point),
                })
        })
        .collect()
}
