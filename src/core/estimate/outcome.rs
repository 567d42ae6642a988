//! The solver's result as an estimate of the scene: events, arcs, gaps, residuals and verdict.

pub(in crate::estimate) mod held_motion;

use nalgebra::Vector3;

use crate::estimate::constraint::bound::at_bound;
use crate::estimate::covariance::residuals::Residuals;
use crate::estimate::covariance::timing;
use crate::estimate::problem::{Problem, TimeSide, View, unit};
use crate::estimate::schedule::recipe::Solution;
use crate::estimate::terms::context::SolveContext;
use crate::estimate::terms::observed::SampleObserver;
use crate::estimate::unknowns::point::Point;
use crate::motion::{
    ArcEstimate, AtBound, Counters, DurationEstimate, End, Estimate, EventEstimate, FitUntold, Gap,
    Measured, ParameterEstimate, Progress, Reason, SampleTime, Scene, SegmentResidual, Sketch,
    Verdict,
};
use crate::optimise::System;
use crate::optimise::finish::Finished;
use crate::physics::State;

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
/// A time is at its bound if it is nearer to it than this share of a typical change of it.
const NEAR: f64 = 1e-6;

/// The estimate of a scene from the solver's solution, without standard deviations; `errors` are
/// the residuals of its samples ([`errors`]), `counters` the work.
pub fn estimate(
    scene: &Scene,
    sketch: &Sketch,
    context: &SolveContext,
    solution: &Solution,
    errors: &[Residuals],
    counters: Counters,
) -> Estimate {
    let problem = context.problem;
    let point = &solution.point;
    let mut events = events(scene, sketch, problem, solution);
    let arcs = arcs(problem, context, point, &events);
    let (verdict, end) = judge(problem, solution, &events, &arcs);
    let parameters = problem.parameters.iter().zip(&point.parameters);
    let sample_times = sample_times(problem, point);
    held_motion::place(problem, sketch, &sample_times, &mut events);
    let held = held_motion::estimates(scene, sketch, problem, point, &sample_times);
    let grips = held_motion::grips(scene, sketch, problem, point, &events, &sample_times);
    Estimate {
        verdict,
        reason: Reason::from(end),
        doubts: Vec::new(),
        objective: 2.0 * solution.system.cost,
        gravity_m_s2: problem.gravity(&point.parameters),
        residuals: residuals(problem, errors),
        held,
        grips,
        trees: Vec::new(),
        sample_times,
        duration: DurationEstimate {
            duration_s: match problem.grips.is_empty() {
                true => timing::duration(context, point).duration_s,
                false => held_motion::lasting_s(problem, &arcs, &events),
            },
            sd_s: None,
        },
        arcs,
        events,
        parameters: parameters
            .enumerate()
            .map(|(index, (free, value))| ParameterEstimate {
                name: free.name.clone(),
                value: *value,
                sd: None,
                at_bound: at_bound(
                    &problem.parameters,
                    &problem.cones,
                    &point.parameters,
                    index,
                ),
                lower: free.lower,
                upper: free.upper,
            })
            .collect(),
        fit: Err(FitUntold::NotAsked),
        suspects: Vec::new(),
        rivals: 0,
        contact_rivals: Vec::new(),
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
            contact_s: problem.contact_s(Some(event), &point.parameters),
            sd_s: None,
            is_fixed: !scene.time_is_free(event) && is_at_mark(problem, event),
            at_bound: time_bound(problem, point, event),
            acted_s: sketch.marks_s[event],
            gap: gap(problem, &solution.system, event),
            leaning: None,
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

/// Largest remaining gap of each kind at an event.
fn gap(problem: &Problem, system: &System, event: usize) -> Gap {
    let rows = system.blocks.iter().zip(&system.priced);
    let constraints = problem.constraints().zip(rows);
    let at_event = constraints.filter(|(constraint, _)| constraint.event() == Some(event));
    at_event
        .map(|(constraint, rows)| constraint.gap(problem, rows.into()))
        .fold(Gap::default(), |a, b| a.max(&b))
}

/// How near to its tolerances the finish came.
pub(super) fn progress(finished: &Finished) -> Progress {
    let measured = |value, bound| Measured { value, bound };
    let tolerances = &finished.tolerances;
    Progress {
        violation: measured(finished.violation, tolerances.violation),
        decrease: measured(finished.decrease, tolerances.decrease),
    }
}

/// The verdict and how the estimation ended. A motion whose events or flights are not in order of time
/// (paper eq. 7) fails.
fn judge(
    problem: &Problem,
    solution: &Solution,
    events: &[EventEstimate],
    arcs: &[ArcEstimate],
) -> (Verdict, End) {
    let is_bent = problem.velocity_gap_weight.is_some();
    let finished = &solution.finished;
    let progress = progress(finished);
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
    let mut ordered = problem.ordered.iter().map(|of| of.events);
    let interval_s = |[first, last]: [usize; 2]| events[last].time_s - events[first].time_s;
    if let Some([first, last]) = ordered.find(|of| interval_s(*of) < -PHYSICAL_TIME_S) {
        let reversed = End::EventsReversed {
            first,
            last,
            interval_s: interval_s([first, last]),
        };
        return (Verdict::Failed, reversed);
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
        let views = problem.arcs[arc].views.iter();
        views.flat_map(move |view| {
            let samples = view.samples.iter();
            samples.map(move |s| problem.sample_time_s(arc, view.track, s, point))
        })
    };
    let mut arcs: Vec<ArcEstimate> = problem
        .arcs
        .iter()
        .enumerate()
        .map(|(index, arc)| {
            let start_s = match arc.start {
                Some(event) => events[event].left_s(),
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
                support: problem
                    .body_at(index, &point.parameters)
                    .and_then(|body| body.support()),
                certainty: None,
            }
        })
        .collect();
    arcs.sort_by(|a, b| {
        let order = a.mechanism.cmp(&b.mechanism);
        order.then(a.start_s.total_cmp(&b.start_s))
    });
    arcs
}

/// Residuals of every sample, view by view, in units: position, then orientation.
pub fn errors(problem: &Problem, context: &SolveContext, point: &Point) -> Vec<Residuals> {
    let gravity = problem.gravity(&point.parameters);
    let views = problem.views().map(|(arc, view)| {
        let body = problem.body_at(arc, &point.parameters);
        let body = &body.expect("moments that the solution has");
        let (of, epoch_s) = ((arc, view), context.epochs_s[arc]);
        let mut observer = SampleObserver::new(problem, of, (body, &gravity), epoch_s, point);
        let samples = 0..view.samples.len();
        Residuals {
            kinds: view.kinds(),
            each: samples
                .map(|sample| observer.residual(sample, &point.node_times_s))
                .collect(),
        }
    });
    views.collect()
}

/// What every view leaves, in the order of the estimate's arcs.
fn residuals(problem: &Problem, errors: &[Residuals]) -> Vec<SegmentResidual> {
    let rms = |view: usize, (of, kind): (&View, usize)| {
        let errors = &errors[view];
        let squares = errors.each.iter().enumerate().map(|(sample, error)| {
            let three = Vector3::from_fn(|axis, _| error[3 * kind + axis]);
            // Of a whitened residual the size, not the direction.
            let unit = match of.whitenings.get(sample) {
                Some(whitening) => {
                    let block = whitening.fixed_view::<3, 3>(3 * kind, 3 * kind);
                    block.determinant().cbrt().recip()
                }
                None => of.units[kind],
            };
            (three * unit).norm_squared()
        });
        let mean = squares.sum::<f64>() / errors.each.len().max(1) as f64;
        errors.kinds[kind].then(|| mean.sqrt())
    };
    let order = order(problem).into_iter().enumerate();
    let ordered = order.flat_map(|(place, arc)| {
        let numbers = problem.views_of(arc);
        let views = problem.arcs[arc].views.iter().zip(numbers);
        views.map(move |(view, number)| SegmentResidual {
            arc: place,
            track: view.track,
            samples: view.samples.len(),
            position_rms_m: rms(number, (view, 0)),
            orientation_rms_rad: rms(number, (view, 1)),
        })
    });
    ordered.collect()
}

/// The problem's arcs in the order of the estimate's: mechanism by mechanism, in order of time.
fn order(problem: &Problem) -> Vec<usize> {
    let mut order: Vec<usize> = (0..problem.arcs.len()).collect();
    order.sort_by_key(|arc| problem.arcs[*arc].mechanism);
    order
}

/// The physical times of all samples, in the order of [`residuals`].
fn sample_times(problem: &Problem, point: &Point) -> Vec<SampleTime> {
    let mut times = Vec::new();
    for arc in order(problem) {
        for view in &problem.arcs[arc].views {
            for sample in &view.samples {
                times.push(SampleTime {
                    track: view.track,
                    stamp: sample.stamp,
                    time_s: problem.sample_time_s(arc, view.track, sample, point),
                    is_open: sample.open.is_some(),
                });
            }
        }
    }
    times
}
