//! The solver's result as an estimate of the scene.

use nalgebra::DVector;

use super::adequacy;
use super::problem::{RATE_SD_RAD_S, TreeProblem};
use super::solve::{self, Solved};
use super::weak;
use crate::estimate::constraint::quantity;
use crate::estimate::outcome::progress;
use crate::estimate::problem::unit;
use crate::motion::{
    Counters, DurationEstimate, End, Estimate, EventEstimate, Gap, GoalUnit, JointTree, MotionPart,
    Observer, Reason, SampleTime, Scene, Sketch, TrackIndex, TrackResidual, TreeEstimate, TreeKnot,
    Undetermined, Verdict,
};
use crate::physics::tree::{Snapshot, TreeState};

/// Share of a direction's information below which the prior says more of it than the sketch.
const TOLD: f64 = 0.5;
/// A part of an open direction is named where it has this share of the greatest part.
const NAMED: f64 = 0.3;

/// The estimate of a scene of joined bodies, from a first guess of its state at the beginning.
pub fn estimate(
    scene: &Scene,
    sketch: &Sketch,
    problem: TreeProblem,
    start: TreeState,
    observer: &mut dyn Observer,
) -> Estimate {
    let solved = solve::solve(problem, start, observer);
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
    let joined = scene.joint_tree(problem.mechanism).expect("a tree");
    let judged = (verdict == Verdict::Physical)
        .then(|| adequacy::judge((scene, joined), problem, solution, observer))
        .flatten();
    let (fit, suspects) = judged.unzip();
    let events = (0..scene.events.len()).map(|event| of_event(&solved, sketch, event));
    let mut sample_times: Vec<SampleTime> = Vec::new();
    for sample in &problem.samples {
        let is_again = |of: &SampleTime| of.track == sample.track && of.stamp == sample.stamp;
        if !sample_times.iter().rev().take(4).any(is_again) {
            sample_times.push(SampleTime {
                track: sample.track,
                stamp: sample.stamp,
                time_s: sample.time_s,
                is_open: false,
            });
        }
    }
    Estimate {
        verdict,
        reason: Reason::from(end),
        doubts: Vec::new(),
        objective: 2.0 * solution.system.cost,
        gravity_m_s2: problem.gravity_m_s2,
        arcs: Vec::new(),
        held: Vec::new(),
        events: events.collect(),
        duration: DurationEstimate {
            duration_s: problem.span_s[1] - problem.span_s[0],
            sd_s: Some(0.0),
        },
        parameters: Vec::new(),
        residuals: Vec::new(),
        sample_times,
        fit,
        suspects: suspects.unwrap_or_default(),
        rivals: 0,
        undetermined: if is_finite {
            open(&solved, joined)
        } else {
            Vec::new()
        },
        trees: (!knots.is_empty())
            .then(|| TreeEstimate {
                mechanism: problem.mechanism,
                residuals: residuals(problem, &knots),
                knots,
                step_s: problem.step_s,
                rate_sd_rad_s: RATE_SD_RAD_S,
            })
            .into_iter()
            .collect(),
        counters: Counters {
            iterations: solution.work.iterations,
            evaluations: solution.work.evaluations,
            factorisations: solution.work.factorisations,
            starts: 1,
            ..Counters::default()
        },
    }
}

/// An event of the scene as estimated.
fn of_event(solved: &Solved, sketch: &Sketch, event: usize) -> EventEstimate {
    let mut within = solved.problem.events.iter();
    let within = within.position(|of| of.event == event);
    let time_s = match within {
        Some(within) => solved.solution.point.event_times_s[within],
        None => sketch.marks_s[event],
    };
    EventEstimate {
        event,
        time_s,
        sd_s: None,
        is_fixed: within.is_none(),
        at_bound: None,
        acted_s: time_s,
        gap: gap(solved, event, within),
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
        let count = problem.events[within].touch_row_count();
        if count > 0 {
            gap.velocity_m_s = gap.velocity_m_s.max(off(0) * unit::VELOCITY_M_S);
        }
        if count > 1 {
            gap.position_m = gap.position_m.max(off(1) * unit::POSITION_M);
        }
    }
    gap
}

fn residuals(problem: &TreeProblem, knots: &[TreeKnot]) -> Vec<TrackResidual> {
    let mut sums: Vec<(TrackIndex, [(usize, f64); 2])> = Vec::new();
    let mut snapshot = Snapshot::new(&problem.tree, &problem.gravity_m_s2);
    for sample in &problem.samples {
        let at = knots.partition_point(|knot| knot.time_s < sample.time_s);
        snapshot.set(&knots[at.min(knots.len() - 1)].state);
        let link = snapshot.link_state(sample.place);
        let valued = quantity::valued(&sample.quantity, &link, None, &sample.point_m);
        let square = (valued.value - sample.seen).norm_squared();
        let kind = usize::from(sample.quantity.unit() != GoalUnit::Metre);
        if !sums.iter().any(|(track, _)| *track == sample.track) {
            sums.push((sample.track, [(0, 0.0); 2]));
        }
        let of_track = sums.iter_mut().find(|(track, _)| *track == sample.track);
        let (_, of_kinds) = of_track.expect("just added");
        of_kinds[kind].0 += 1;
        of_kinds[kind].1 += square;
    }
    let rms = |(count, square): (usize, f64)| (count > 0).then(|| (square / count as f64).sqrt());
    let lines = sums.into_iter().map(|(track, kinds)| TrackResidual {
        track,
        samples: kinds[0].0.max(kinds[1].0),
        position_rms_m: rms(kinds[0]),
        orientation_rms_rad: rms(kinds[1]),
    });
    lines.collect()
}

/// Parts of the state at the beginning of which the prior says more than sketch and goals do.
fn open(solved: &Solved, joined: &JointTree) -> Vec<Undetermined> {
    let problem = &solved.problem;
    let directions = weak::directions(problem, &solved.solution, TOLD);
    let parts = directions.iter().flat_map(|of| parts(problem, joined, of));
    let mut open = Vec::new();
    for part in parts {
        if !open.contains(&part) {
            open.push(part);
        }
    }
    open
}

/// The parts of the state that a direction moves most.
fn parts(problem: &TreeProblem, joined: &JointTree, direction: &DVector<f64>) -> Vec<Undetermined> {
    let tree = &problem.tree;
    let freedoms = tree.freedoms();
    let scale = |at: usize| direction[at] / problem.unit_of(at);
    let mut sizes: Vec<(f64, Undetermined)> = Vec::new();
    for (place, link) in joined.links().enumerate() {
        let columns = tree.columns_of(place);
        let flight = if place == 0 {
            freedoms - tree.angular_freedoms()
        } else {
            0
        };
        let mut add = |range: std::ops::Range<usize>, part: MotionPart| {
            let size = range.map(|at| scale(at).powi(2)).sum::<f64>().sqrt();
            sizes.push((size, Undetermined::Link { link, part }));
        };
        add(0..flight, MotionPart::Position);
        add(columns.clone(), MotionPart::Orientation);
        add(freedoms..freedoms + flight, MotionPart::Velocity);
        add(
            freedoms + columns.start..freedoms + columns.end,
            MotionPart::Spin,
        );
    }
    let most = sizes.iter().map(|(size, _)| *size).fold(0.0, f64::max);
    let named = sizes.into_iter().filter(|(size, _)| *size >= NAMED * most);
    named.map(|(_, part)| part).collect()
}
