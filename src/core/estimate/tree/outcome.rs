//! The solver's result as an estimate of the scene.

use nalgebra::DVector;

use super::adequacy::certainty::Certainty;
use super::adequacy::{self, linearised::Linearised};
use super::motions::{Motions, motions};
use super::observability;
use super::optimum::Solved;
use super::problem::TreeProblem;
use super::time_line::TimeLine;
use crate::estimate::constraint::bound::at_bound;
use crate::estimate::outcome::progress;
use crate::estimate::problem::unit;
use crate::motion::{
    AtBound, Counters, DurationEstimate, End, Estimate, EventEstimate, FitUntold, Gap, GoalUnit,
    LinkIndex, MotionPart, Observer, ParameterEstimate, Reason, SampleTime, Scene, Sketch,
    Undetermined, Verdict,
};

/// Share of a direction's information below which the prior says more of it than the sketch.
const TOLD: f64 = 0.5;
/// A part of an open direction is named where it has this share of the greatest part.
const NAMED: f64 = 0.3;
/// A time is at its bound if it is nearer to it than this share of a typical change of it.
const NEAR: f64 = 1e-6;

/// How much is told of a motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Detail {
    /// The motion: enough to check it.
    Motion,
    /// How certain it is and how well it fits, too.
    Whole,
}

/// A solved problem as the estimate of its scene with joined bodies.
pub fn estimate(
    scene: &Scene,
    sketch: &Sketch,
    solved: &Solved,
    detail: Detail,
    observer: &mut dyn Observer,
) -> Estimate {
    let (problem, solution) = (&solved.problem, &solved.solution);
    let finished = &solution.finished;
    let progress = progress(finished);
    let is_finite = solution.system.cost.is_finite() && solution.point.is_finite();
    let (verdict, end) = match (is_finite, finished.converged, solution.stopped) {
        (false, ..) => (Verdict::Failed, End::NotFinite),
        (_, true, _) => (Verdict::Physical, End::Converged(progress)),
        (_, false, true) => (Verdict::Failed, End::Stopped(progress)),
        (_, false, false) => (Verdict::Failed, End::NoProgress(progress)),
    };
    let knots = if is_finite {
        problem.knots(&solution.point)
    } else {
        Vec::new()
    };
    let is_whole = detail == Detail::Whole;
    let judged = match () {
        () if !is_whole => Err(FitUntold::NotAsked),
        () if verdict != Verdict::Physical => Err(FitUntold::NoMotion),
        () if problem.tempo.is_some() => Err(FitUntold::UnknownTempo),
        // Without time for it nothing is told to be determined.
        () if observer.should_stop() => Err(FitUntold::Stopped),
        () => Ok(()),
    };
    let told = problem.as_told(&solution.point);
    let line = &solution.point.time_line(problem);
    let is_asked =
        line.is_unknown() || !problem.events.is_empty() || !problem.parameters.is_empty();
    let is_asked = is_whole && finished.converged && is_asked;
    let has_time = !observer.should_stop();
    let linearised = ((judged.is_ok() || is_asked) && has_time)
        .then(|| Linearised::new(problem, solution))
        .flatten();
    let judged = judged.and_then(|()| {
        let of = linearised.as_ref().ok_or(FitUntold::FewSamples)?;
        adequacy::judge(scene, of, observer)
    });
    let (fit, suspects) = match judged {
        Ok((fit, suspects)) => (Ok(fit), suspects),
        Err(untold) => (Err(untold), Vec::new()),
    };
    let certainty = linearised.filter(|_| is_asked).and_then(Certainty::new);
    let sd_of = |moment: Vec<(usize, f64)>| certainty.as_ref()?.sd(&moment);
    let events = (0..scene.events.len()).map(|event| of_event(solved, line, &sd_of, sketch, event));
    let events: Vec<EventEstimate> = events.collect();
    let motions = match knots.is_empty() {
        true => Motions::default(),
        false => motions(&told, line, scene, &knots, &events),
    };
    let [from_s, to_s] = line.physical_span_s();
    let mut sample_times: Vec<SampleTime> = Vec::new();
    for sample in &problem.samples {
        let is_again = |of: &SampleTime| of.track == sample.track && of.stamp == sample.stamp;
        if !sample_times.iter().rev().take(4).any(is_again) {
            sample_times.push(SampleTime {
                track: sample.track,
                stamp: sample.stamp,
                time_s: line.time_s(sample.acted_s),
                is_open: false,
            });
        }
    }
    let duration = DurationEstimate {
        duration_s: to_s - from_s,
        sd_s: match line.is_unknown() {
            true => sd_of(line.moment(problem, problem.span_s[1])),
            false => Some(0.0),
        },
    };
    let mut undetermined = match is_finite && is_whole {
        true => open(solved, scene),
        false => Vec::new(),
    };
    if is_finite && !duration.is_determined() {
        undetermined.push(Undetermined::Duration);
    }
    let parameters = problem.parameters.iter().zip(&solution.point.parameters);
    let parameters = parameters.enumerate().map(|(index, (free, value))| {
        let at_bound = at_bound(
            &problem.parameters,
            &problem.cones,
            &solution.point.parameters,
            index,
        );
        let moment = vec![(problem.unknown_of_parameter(index), 1.0)];
        // A bound is a prior of half the width.
        let half_width = at_bound.map_or(0.0, |_| 0.5 * free.length());
        ParameterEstimate {
            name: free.name.clone(),
            value: *value,
            sd: sd_of(moment).map(|sd| sd.hypot(half_width)),
            at_bound,
            lower: free.lower,
            upper: free.upper,
        }
    });
    let parameters: Vec<ParameterEstimate> = parameters.collect();
    for (index, parameter) in parameters.iter().enumerate() {
        if is_finite && parameter.sd.is_none() {
            undetermined.push(Undetermined::Parameter(index));
        }
    }
    Estimate {
        verdict,
        reason: Reason::from(end),
        doubts: Vec::new(),
        objective: 2.0 * solution.system.cost,
        gravity_m_s2: told.gravity_m_s2,
        arcs: motions.arcs,
        held: problem.hands.clone(),
        grips: Vec::new(),
        events,
        duration,
        parameters,
        residuals: motions.residuals,
        sample_times,
        fit,
        suspects,
        rivals: 0,
        contact_rivals: Vec::new(),
        undetermined,
        trees: motions.trees,
        counters: Counters {
            iterations: solution.work.iterations,
            evaluations: solution.work.evaluations,
            factorisations: solution.work.factorisations,
            starts: 1,
            ..Counters::default()
        },
    }
}

/// Logarithm of how likely the samples are about a motion, over all that their errors may be: of two motions of the
/// same sketch the difference is that of the odds. `None` where something there is no number.
pub fn evidence(solved: &Solved) -> Option<f64> {
    Linearised::new(&solved.problem, &solved.solution)?.evidence()
}

/// An event of the scene as estimated.
fn of_event(
    solved: &Solved,
    line: &TimeLine,
    sd_of: &dyn Fn(Vec<(usize, f64)>) -> Option<f64>,
    sketch: &Sketch,
    event: usize,
) -> EventEstimate {
    let problem = &solved.problem;
    let within = problem.events.iter().position(|of| of.event == event);
    let (time_s, acted_s) = match within {
        Some(within) => {
            let time_s = solved.solution.point.event_times_s[within];
            (time_s, line.acted_s(time_s).0)
        }
        None => {
            let acted_s = sketch.marks_s[event];
            (line.time_s(acted_s), acted_s)
        }
    };
    let window_s = within.and_then(|within| problem.events[within].window_s);
    let is_given = within.is_none() || window_s.is_some_and(|[from_s, to_s]| from_s == to_s);
    let is_fixed = is_given && !(line.is_unknown() && acted_s > problem.span_s[0]);
    let at_bound = window_s
        .filter(|_| !is_given)
        .and_then(|[earliest_s, latest_s]| {
            let is_at = |bound_s: f64| (acted_s - bound_s).abs() <= NEAR * unit::TIME_S;
            let bounds = [(AtBound::Lower, earliest_s), (AtBound::Upper, latest_s)];
            let mut bounds = bounds.into_iter();
            bounds.find_map(|(bound, bound_s)| is_at(bound_s).then_some(bound))
        });
    let moment = || match within {
        Some(within) => vec![(problem.unknown_of_event(within), 1.0)],
        None => line.moment(problem, acted_s),
    };
    EventEstimate {
        contact_s: 0.0,
        event,
        time_s,
        sd_s: (!is_fixed).then(|| sd_of(moment())).flatten(),
        is_fixed,
        at_bound,
        acted_s,
        gap: gap(solved, event, within),
        leaning: None,
    }
}

/// Largest violation of each kind by the goals at an event, and by what touches at one within the motion.
fn gap(solved: &Solved, event: usize, within: Option<usize>) -> Gap {
    let mut gap = Gap::default();
    let rows = solved
        .problem
        .goals
        .iter()
        .zip(&solved.solution.system.blocks);
    for (goal, block) in rows.filter(|(goal, _)| goal.event == event) {
        let off = (0..block.values.len()).map(|row| block.violation(row).abs());
        let off = off.fold(0.0, f64::max) * goal.unit();
        match goal.condition.quantity.unit() {
            GoalUnit::Metre => gap.position_m = gap.position_m.max(off),
            GoalUnit::Radian => gap.orientation_rad = gap.orientation_rad.max(off),
            GoalUnit::MetrePerSecond => gap.velocity_m_s = gap.velocity_m_s.max(off),
            GoalUnit::RadianPerSecond => {
                gap.angular_velocity_rad_s = gap.angular_velocity_rad_s.max(off);
            }
            GoalUnit::Second => {}
        }
    }
    let problem = &solved.problem;
    if let Some(within) = within {
        let block = &solved.solution.system.blocks[problem.event_block(within)];
        let off = |row: usize| block.violation(row).abs();
        let [speeds, gaps] = problem.events[within].touch_row_counts();
        for row in 0..speeds {
            gap.velocity_m_s = gap.velocity_m_s.max(off(row) * unit::VELOCITY_M_S);
        }
        for row in speeds..speeds + gaps {
            gap.position_m = gap.position_m.max(off(row) * unit::POSITION_M);
        }
    }
    gap
}

/// Parts of the state at the beginning of which the prior says more than sketch and goals do.
fn open(solved: &Solved, scene: &Scene) -> Vec<Undetermined> {
    let problem = &solved.problem;
    let directions = observability::directions(problem, &solved.solution, TOLD);
    let parts = directions.iter().flat_map(|of| parts(problem, scene, of));
    let mut open = Vec::new();
    for part in parts {
        if !open.contains(&part) {
            open.push(part);
        }
    }
    open
}

/// The parts of the state that a direction moves most.
fn parts(problem: &TreeProblem, scene: &Scene, direction: &DVector<f64>) -> Vec<Undetermined> {
    let forest = &problem.forest;
    let freedoms = forest.freedoms();
    let scale = |at: usize| direction[at] / problem.unit_of(at);
    let mut sizes: Vec<(f64, Undetermined)> = Vec::new();
    for (place, link) in scene.forest_links().enumerate() {
        let (columns, flight) = (forest.columns_of(place), forest.flight_of(place));
        let mut add = |range: std::ops::Range<usize>, part: MotionPart| {
            let size = range.map(|at| scale(at).powi(2)).sum::<f64>().sqrt();
            sizes.push((size, part_of(scene, link, part)));
        };
        let rates = |of: &std::ops::Range<usize>| freedoms + of.start..freedoms + of.end;
        add(flight.clone(), MotionPart::Position);
        add(columns.clone(), MotionPart::Orientation);
        add(rates(&flight), MotionPart::Velocity);
        add(rates(&columns), MotionPart::Spin);
    }
    let most = sizes.iter().map(|(size, _)| *size).fold(0.0, f64::max);
    let named = sizes.into_iter().filter(|(size, _)| *size >= NAMED * most);
    named.map(|(_, part)| part).collect()
}

fn part_of(scene: &Scene, link: LinkIndex, part: MotionPart) -> Undetermined {
    let mechanism = scene.mechanism_of(link);
    match scene.joint_tree(mechanism) {
        Some(_) => Undetermined::Link { link, part },
        None => Undetermined::Motion { mechanism, part },
    }
}
