//! Single beside multiple shooting of joined bodies: the same problems on 1 to 20 segments, from two starts.

mod plain;
mod show;

use std::time::Instant;

use anyhow::Result;
use enact::estimate::tree::TreeProblem;
use enact::estimate::tree::on_nodes::{Start, solve_on_nodes};
use enact::initialise;
use enact::physics::tree::Flow;
use enact::physics::tree::tableau::DORMAND_PRINCE;
use enact::segment::clean::clean;
use enact_tools::trees::{Jointed, Kind, RATE_HZ, TreeActing, TreePerformance, motion, perform};
use nalgebra::DMatrix;
use serde::Serialize;

use crate::core_time::{CoreLimit, CoreTime};
use crate::options::Options;
use crate::record::Record;

/// Segments.
const SEGMENTS: [usize; 5] = [1, 2, 5, 10, 20];
/// Segments on which the true motion is followed to the best known one.
const OF_TRUTH: usize = 5;
const DURATIONS_S: [f64; 4] = [0.5, 1.0, 2.0, 4.0];
/// After which a solve is told to stop \[s on a core\].
const LIMIT_S: f64 = 2.0;
/// Rounds of all performances at most, and the time after which none begins \[s\].
const ROUNDS: u64 = 10;
const SPENT_S: f64 = 300.0;
/// An objective within this of the best known one, relative, is as good.
const SAME: f64 = 1e-4;

/// From where a problem is solved.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
enum From {
    /// The part of the sketch that counts grows, as the program's does.
    Grown,
    /// States are read off the sketch at each node.
    Plain,
    /// The true states, which nobody knows.
    Truth,
}

/// One solve.
#[derive(Serialize)]
struct Shot {
    segments: usize,
    from: From,
    /// Of a motion that obeys the laws and meets the goals.
    objective: Option<f64>,
    is_stopped: bool,
    is_best: bool,
    evaluations: usize,
    seconds: f64,
}

/// One performance.
#[derive(Serialize)]
struct Shots {
    kind: String,
    duration_s: f64,
    seed: u64,
    /// By how much errors of the true start grow to the end.
    growth: f64,
    all: Vec<Shot>,
}

fn kinds() -> Vec<(String, Kind)> {
    let mut kinds = Vec::new();
    for (name, joints, hanging, falling) in [
        ("pins", Jointed::Pin, &[2, 3, 5, 8][..], &[][..]),
        ("universal", Jointed::Universal, &[2, 3], &[2, 3]),
        ("balls", Jointed::Ball, &[2], &[]),
    ] {
        for links in hanging {
            let name = format!("pendulum of {links}, {name}");
            kinds.push((name, Kind::pendulum(*links, joints)));
        }
        for links in falling {
            let kind = Kind {
                is_clamped: false,
                ..Kind::pendulum(*links, joints)
            };
            kinds.push((format!("falling, {links}, {name}"), kind));
        }
    }
    kinds
}

impl Shots {
    fn of(name: &str, kind: &Kind, seed: u64) -> Self {
        let performance = perform(kind, &TreeActing::of(1.0), seed);
        let (scene, events) = (&performance.scene, &performance.events);
        let (sketch, _) = clean(scene, events).expect("a sketch");
        let problem = TreeProblem::new(scene, &sketch);
        let (_, first) = initialise::tree::starts(scene, &sketch, &problem.forest).swap_remove(0);
        let mut all = Vec::new();
        for segments in SEGMENTS {
            let cut = on(&problem, segments);
            let plain = plain::states(&cut, &first);
            all.push(Shot::of(&cut, From::Grown, Start::Continued(first.clone())));
            all.push(Shot::of(&cut, From::Plain, Start::Nodes(plain.nodes)));
        }
        let cut = on(&problem, OF_TRUTH);
        let tree = performance.tree();
        let truth = &performance.truth;
        let states = motion(scene, &tree, truth, kind.duration_s, RATE_HZ);
        let index = |node_s: &f64| ((node_s - cut.span_s[0]) * RATE_HZ).round() as usize;
        let states = cut
            .nodes_s
            .iter()
            .map(|node_s| states[index(node_s)].clone());
        let states = states.collect();
        all.push(Shot::of(&cut, From::Truth, Start::Nodes(states)));
        let best = all.iter().filter_map(|of| of.objective).reduce(f64::min);
        for shot in &mut all {
            let found = shot.objective.zip(best);
            shot.is_best = found.is_some_and(|(found, best)| found <= best * (1.0 + SAME));
        }
        Self {
            kind: name.to_owned(),
            duration_s: kind.duration_s,
            seed,
            growth: growth(&performance),
            all,
        }
    }
}

impl Shot {
    fn of(problem: &TreeProblem, from: From, start: Start) -> Self {
        let time = CoreTime::begin();
        let solved = solve_on_nodes(problem, start, &mut CoreLimit(&time, LIMIT_S));
        let solution = &solved.solution;
        let is_motion = solution.finished.converged && solution.system.cost.is_finite();
        Self {
            segments: problem.nodes_s.len(),
            from,
            objective: is_motion.then_some(2.0 * solution.system.cost),
            is_stopped: solution.stopped,
            is_best: false,
            evaluations: solution.work.evaluations,
            seconds: time.seconds(),
        }
    }
}

/// The problem with nodes at samples, as evenly as these allow.
fn on(problem: &TreeProblem, segments: usize) -> TreeProblem {
    let [from_s, to_s] = problem.span_s;
    let samples = ((to_s - from_s) * RATE_HZ).round() as usize;
    let mut stamps_s: Vec<f64> = problem.samples.iter().map(|of| of.acted_s).collect();
    stamps_s.dedup();
    let nodes_s = (0..segments).map(|cut| stamps_s[cut * samples / segments]);
    TreeProblem {
        nodes_s: nodes_s.collect(),
        ..problem.clone()
    }
}

/// The largest change of the end over one of the start, of any coordinate or rate, along the true motion.
fn growth(performance: &TreePerformance) -> f64 {
    /// Step of the integrator \[s\].
    const STEP_S: f64 = 1e-3;
    let tree = performance.tree();
    let mut flow = Flow::new(&tree, &performance.scene.gravity_m_s2, DORMAND_PRINCE);
    flow.begin(&performance.truth, true);
    flow.reach(performance.duration_s, STEP_S);
    let mut jacobian = DMatrix::zeros(2 * tree.freedoms(), 2 * tree.freedoms());
    flow.jacobian(&mut jacobian);
    jacobian.amax()
}

/// Runs it.
pub fn run(options: &Options, record: &mut Record) -> Result<()> {
    let begin = Instant::now();
    let mut all: Vec<Shots> = Vec::new();
    for seed in options.seeds(ROUNDS) {
        if !all.is_empty() && begin.elapsed().as_secs_f64() > SPENT_S {
            break;
        }
        for (name, kind) in kinds() {
            for duration_s in &DURATIONS_S[..options.either(1, DURATIONS_S.len())] {
                if !options.wants(&format!("{name}, {duration_s} s")) {
                    continue;
                }
                let kind = Kind {
                    duration_s: *duration_s,
                    ..kind
                };
                all.push(Shots::of(&name, &kind, seed));
            }
            eprintln!("  {name}, {seed}: {:.0} s", begin.elapsed().as_secs_f64());
        }
    }
    show::show(&all, record);
    record.numbers("joined_shooting", &all)
}
