//! Standard deviations of an estimate, and quantities that the performance does not determine.

use std::collections::BTreeMap;

use nalgebra::DVector;

use crate::estimate::covariance::timing;
use crate::estimate::covariance::{Covariance, Moment};
use crate::estimate::problem::MovedBy;
use crate::estimate::problem::influence::Influence;
use crate::estimate::schedule::recipe::Solution;
use crate::estimate::terms::context::SolveContext;
use crate::estimate::unknowns::point::Point;
use crate::motion::{
    AtBound, Estimate, FlightCertainty, FlightChange, MotionPart, Scene, Undetermined, Verdict,
};
use crate::optimise::System;
use crate::optimise::kkt::DAMPING;

/// Greatest change of the time that samples span, in its standard deviations without constraints, before constraints
/// count as contradicting the samples. No performance of a pencil came near it, up to four times
/// the distortion; every second one of 98 real tosses, with stamps stretched in time, exceeds it.
const CONTRADICTION: f64 = 1.0;

/// Sets the standard deviations of events, duration and parameters of an estimate, `None` for fixed
/// or undetermined ones, and lists what is undetermined. Where the matrix cannot be factorised,
/// nothing is determined.
pub fn fill(
    estimate: &mut Estimate,
    scene: &Scene,
    context: &SolveContext,
    solution: &Solution,
    covariance: Option<&Covariance>,
) {
    let sds = |moments: &[Moment]| match covariance {
        Some(covariance) => covariance.sds(moments),
        None => vec![None; moments.len()],
    };
    let events =
        (0..scene.events.len()).map(|event| timing::event_moment(context, &solution.point, event));
    let parameters = context.layout.parameters.iter().map(|at| vec![(*at, 1.0)]);
    let lasting = timing::duration(context, &solution.point).moment;
    let moments: Vec<Moment> = events.chain(parameters).chain([lasting]).collect();
    let mut each = moments.iter().zip(sds(&moments));
    // At a bound the deviation covers what the performance asks for beyond it.
    let covering = |sd: Option<f64>, moment: &Moment, at_bound: Option<AtBound>| {
        let covariance = covariance.filter(|_| at_bound.is_some());
        let beyond = covariance.map_or(0.0, |covariance| covariance.beyond_bounds(moment));
        sd.map(|sd| sd.hypot(beyond))
    };
    let mut undetermined_times = Vec::new();
    for (event, (moment, sd_s)) in estimate.events.iter_mut().zip(&mut each) {
        if event.is_fixed {
            continue;
        }
        let sd_s = sd_s.filter(|_| shows_hand(context, &solution.point, event.event));
        let cut_sd_s = context.problem.cuts_sd_s.get(&event.event);
        event.sd_s = covering(sd_s, moment, event.at_bound)
            .map(|sd_s| sd_s.hypot(cut_sd_s.copied().unwrap_or(0.0)));
        if !moment.is_empty() && sd_s.is_none() {
            undetermined_times.push(Undetermined::EventTime(event.event));
        }
    }
    let parameters = estimate.parameters.iter_mut().enumerate();
    for ((index, parameter), (moment, sd)) in parameters.zip(&mut each) {
        parameter.sd = covering(sd, moment, parameter.at_bound);
        if sd.is_none() {
            estimate.undetermined.push(Undetermined::Parameter(index));
        }
    }
    estimate.undetermined.extend(undetermined_times);
    if context.problem.keeps_starts || !context.problem.regulariser.is_empty() {
        let open = undetermined_motion(context, sds);
        estimate.undetermined.extend(open);
    }
    let (lasting, own_s) = each.next().expect("the last moment is the duration's");
    // A fixed time line has no deviation.
    let own_s = if lasting.is_empty() { Some(0.0) } else { own_s };
    let contradiction_s = covariance.map_or(0.0, |covariance| {
        contradiction_s(context, &solution.system, covariance)
    });
    estimate.duration.sd_s = own_s.map(|own_s| own_s.hypot(contradiction_s));
    if !estimate.duration.is_determined() {
        estimate.undetermined.push(Undetermined::Duration);
    }
}

/// Whether the body's own tracker shows that a hand lets go of it at an event; where it is no such event, that does not count.
fn shows_hand(context: &SolveContext, point: &Point, event: usize) -> bool {
    let problem = context.problem;
    let mut changes = problem.changes.iter().filter(|of| of.event == event);
    changes.all(|of| match of.sides {
        [MovedBy::Hand(held), MovedBy::Arc(arc)] if of.keeps_velocities => {
            let held = &problem.held[held];
            !held.strays || held.shows_hand(problem, point, arc)
        }
        _ => true,
    })
}

/// Tells how certain the flights of a motion are.
pub fn fill_flights(
    estimate: &mut Estimate,
    context: &SolveContext,
    point: &Point,
    covariance: &Covariance,
) {
    if estimate.verdict == Verdict::Failed {
        return;
    }
    for (index, state) in point.arcs.iter().enumerate() {
        let mechanism = context.problem.arcs[index].mechanism;
        let mut flights = estimate.arcs.iter_mut();
        let flight = flights.find(|arc| arc.mechanism == mechanism && arc.state == *state);
        if let Some(flight) = flight {
            flight.certainty = Some(certainty(context, point, covariance, index));
        }
    }
}

/// How certain a flight is, with what was estimated of what acts on it.
fn certainty(
    context: &SolveContext,
    point: &Point,
    covariance: &Covariance,
    arc: usize,
) -> FlightCertainty {
    let (problem, layout) = (context.problem, context.layout);
    let gravity = problem.gravity_parameters.iter().enumerate();
    let gravity =
        gravity.filter_map(|(axis, parameter)| Some((Influence::Pull(axis), (*parameter)?)));
    let own = problem.arcs[arc].acting.iter();
    let own = own.map(|acting| (acting.influence, acting.parameter));
    let mut acting: BTreeMap<usize, FlightChange> = BTreeMap::new();
    for (influence, parameter) in gravity.chain(own) {
        if let Some(change) = influence.on_flight(point.parameters[parameter]) {
            acting.insert(parameter, change);
        }
    }
    let parameters = acting.keys().map(|parameter| layout.parameters[*parameter]);
    let unknowns: Vec<usize> = layout.state(arc).chain(parameters).collect();
    FlightCertainty {
        variance: covariance.jointly(&unknowns),
        acting: acting.into_values().collect(),
    }
}

/// Parts of mechanisms' states that the performance does not determine, in whichever flight. What no
/// track sees at all of a flight is open, even where impacts and goals seem to tell it: they may tell
/// another motion as well.
fn undetermined_motion(
    context: &SolveContext,
    sds: impl Fn(&[Moment]) -> Vec<Option<f64>>,
) -> Vec<Undetermined> {
    let mut undetermined = Vec::new();
    for (index, arc) in context.problem.arcs.iter().enumerate() {
        let state = context.layout.state(index);
        let moments: Vec<Moment> = state.map(|at| vec![(at, 1.0)]).collect();
        for (of_part, part) in sds(&moments).chunks(3).zip(MotionPart::ALL) {
            let mechanism = arc.mechanism;
            let open = Undetermined::Motion { mechanism, part };
            let is_blind = arc.sample_count() > 0 && !arc.shows(part.kind());
            let is_open = is_blind || of_part.iter().any(Option::is_none);
            if is_open && !undetermined.contains(&open) {
                undetermined.push(open);
            }
        }
    }
    undetermined
}

/// Covariances take the constraints as exact. Whether the samples agree with them is tested by the
/// change of the time `t_n` that the samples span when all constraints are released: the Newton
/// step on the objective alone, compared with its standard deviation (Hausman's test),
///
/// ```text
/// |e_nᵀ H⁻¹ g| > sd(t_n without constraints)
/// ```
///
/// Where a contact, an impact or a goal distorts the time line so, the deviation covers both
/// answers.
///
/// This is the change of the time that the samples span by the constraints \[s\]; zero where it is within
/// [`CONTRADICTION`] deviations, or where times are known.
fn contradiction_s(context: &SolveContext, system: &System, covariance: &Covariance) -> f64 {
    let Some(Some(last)) = context.layout.nodes.last().copied() else {
        return 0.0;
    };
    let pattern = &context.layout.structure.pattern;
    let mut matrix = system.hessian.clone();
    for row in 0..pattern.size() {
        let diagonal = matrix.get(pattern, row, row);
        matrix.add(pattern, row, row, DAMPING * (1.0 + diagonal));
    }
    if matrix.factorise(pattern).is_err() {
        return 0.0;
    }
    let mut x = DVector::zeros(pattern.size());
    x[last] = 1.0;
    matrix.solve(pattern, &mut x);
    let moved_s = system.gradient.dot(&x).abs();
    let open_s = covariance
        .sd_of_answer(x[last], &x)
        .unwrap_or(f64::INFINITY);
    if moved_s > CONTRADICTION * open_s {
        moved_s
    } else {
        0.0
    }
}
