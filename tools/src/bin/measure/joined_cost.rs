//! How the cost of one evaluation with derivatives, and of a whole answer, grows with links, segments and duration of
//! joined bodies.

mod show;

use std::hint::black_box;

use anyhow::Result;
use enact::estimate::tree::part::Part;
use enact::estimate::tree::program::TreeProgram;
use enact::estimate::tree::{EXACTLY, TreePoint, TreeProblem};
use enact::optimise::Program;
use enact::physics::tree::tableau::DORMAND_PRINCE;
use enact::physics::tree::{Flow, TreeState};
use enact::pipeline::Pipeline;
use enact::segment::clean::clean;
use enact_tools::tree_stress::cases::gentle;
use enact_tools::tree_stress::{Hard, Performance};
use enact_tools::trees::{Jointed, RATE_HZ};
use serde::Serialize;

use crate::core_time::{CoreLimit, CoreTime, call_s};
use crate::joined::Solved;
use crate::options::Options;
use crate::record::Record;
use crate::statistics::median;

/// How joints are called.
const JOINTS: [(&str, Jointed); 3] = [
    ("pins", Jointed::Pin),
    ("universal", Jointed::Universal),
    ("balls", Jointed::Ball),
];
const LINKS: [usize; 7] = [1, 2, 4, 8, 16, 32, 64];
const SEGMENTS: [usize; 6] = [1, 2, 4, 8, 16, 32];
const DURATIONS_S: [f64; 6] = [0.45, 0.9, 1.8, 3.6, 7.2, 14.4];
/// Rods of what is cut, and of what lasts longer.
const CUT: usize = 3;
/// Of what does not grow otherwise \[s\].
const USUAL_S: f64 = 0.9;
/// Whole answers of each size; larger sizes are left out once one takes this long \[s\].
const ANSWERS: u64 = 3;
const LONG_S: f64 = 2.5;
/// After which an answer is told to stop \[s on a core\].
const LIMIT_S: f64 = 5.0;

/// One evaluation, taken apart.
#[derive(Serialize)]
struct Evaluated {
    curve: String,
    /// Links, segments or seconds.
    size: f64,
    /// Directions in which derivatives are told, of a segment,
    directions: usize,
    /// and steps of the integrator in all.
    steps: usize,
    /// Motion alone, told at every sample \[s\].
    plain_s: f64,
    /// The same with its derivatives by the start \[s\].
    derived_s: f64,
    /// Of the whole program: residuals, rows, gradient and Hessian \[s\].
    whole_s: f64,
}

/// Whole answers of a size.
#[derive(Serialize)]
struct Whole {
    curve: String,
    size: f64,
    all: Vec<Solved>,
}

impl Whole {
    fn middle(&self, of: impl Fn(&Solved) -> f64) -> f64 {
        median(&self.all.iter().map(of).collect::<Vec<f64>>())
    }

    /// Whether fewer than half are motions.
    fn has_failed(&self) -> bool {
        2 * self.all.iter().filter(|of| of.is_motion).count() < self.all.len()
    }
}

/// Runs it.
pub fn run(options: &Options, record: &mut Record) -> Result<()> {
    let (mut evaluated, mut whole) = (Vec::new(), Vec::new());
    let seeds = || options.seeds(ANSWERS);
    let most = options.either(4, LINKS.len());
    for (name, joints) in JOINTS {
        for links in LINKS.into_iter().take(most) {
            let hard = gentle(links, joints, USUAL_S);
            let performance = hard.perform(seeds().start);
            evaluated.push(Evaluated::of(
                (name, links as f64),
                (&performance, 1),
                options.quick,
            ));
        }
        answers(
            name,
            &mut whole,
            &LINKS.map(|links| links as f64)[..most],
            |links| (gentle(links as usize, joints, USUAL_S), seeds()),
        );
        eprintln!("  links, {name}");
    }
    let performance = gentle(CUT, Jointed::Universal, USUAL_S).perform(seeds().start);
    for segments in SEGMENTS.into_iter().take(most) {
        let what = ("segments", segments as f64);
        evaluated.push(Evaluated::of(what, (&performance, segments), options.quick));
    }
    let longer = |duration_s: f64| gentle(CUT, Jointed::Universal, duration_s);
    let durations_s = &DURATIONS_S[..most.min(DURATIONS_S.len())];
    for duration_s in durations_s {
        let performance = longer(*duration_s).perform(seeds().start);
        let what = ("duration", *duration_s);
        evaluated.push(Evaluated::of(what, (&performance, 1), options.quick));
    }
    answers("duration", &mut whole, durations_s, |duration_s| {
        (longer(duration_s), seeds())
    });
    show::show(&evaluated, &whole, record);
    record.numbers("evaluations", &evaluated)?;
    record.numbers("answers", &whole)
}

/// Whole answers, the smallest first, until one takes long.
fn answers(
    curve: &str,
    all: &mut Vec<Whole>,
    sizes: &[f64],
    of: impl Fn(f64) -> (Hard, std::ops::Range<u64>),
) {
    for size in sizes {
        let (hard, seeds) = of(*size);
        let answers = seeds.map(|seed| answer(&hard.perform(seed)));
        let whole = Whole {
            curve: curve.to_owned(),
            size: *size,
            all: answers.collect(),
        };
        let is_long = whole.middle(|of| of.seconds) > LONG_S;
        all.push(whole);
        if is_long {
            break;
        }
    }
}

fn answer(performance: &Performance) -> Solved {
    let time = CoreTime::begin();
    let events = performance.strike.events.iter().cloned();
    let limit = &mut CoreLimit(&time, LIMIT_S);
    let outcome = Pipeline::of(performance.said.clone(), events).finish(limit);
    let estimate = outcome.as_ref().ok().map(|outcome| &outcome.estimate);
    Solved::of(estimate, time.seconds())
}

impl Evaluated {
    fn of(
        (curve, size): (&str, f64),
        (performance, segments): (&Performance, usize),
        quick: bool,
    ) -> Self {
        let (scene, states) = (&performance.said, &performance.strike.states);
        let (sketch, _) = clean(scene, &performance.strike.events).expect("a sketch");
        let mut problem = TreeProblem::new(scene, &sketch);
        let [from_s, to_s] = problem.span_s;
        let samples = states.len() - 1;
        // Nodes at samples, as evenly as these allow.
        let at: Vec<usize> = (0..segments).map(|cut| cut * samples / segments).collect();
        problem.nodes_s = at.iter().map(|at| from_s + *at as f64 / RATE_HZ).collect();
        problem.step_s = EXACTLY[0];
        let nodes: Vec<TreeState> = at.iter().map(|at| states[*at].clone()).collect();
        let point = TreePoint::new(&problem, nodes);
        let program = TreeProgram::new(&problem, point.clone());
        let part = Part::whole();
        let mut system = program.evaluated(&part, &point);
        let tree = &problem.forest.trees()[0];
        let mut flow = Flow::new(tree, &problem.gravity_m_s2, DORMAND_PRINCE);
        let mut jacobian = nalgebra::DMatrix::zeros(problem.width(), problem.width());
        let mut fly = |has_derivatives: bool| {
            flow.begin(black_box(&states[0]), has_derivatives);
            for sample in 1..=samples {
                flow.reach(sample as f64 / RATE_HZ, problem.step_s);
                black_box(flow.state());
                if has_derivatives {
                    flow.jacobian(&mut jacobian);
                    black_box(&jacobian);
                }
            }
        };
        // Turn by turn, for what else the machine does.
        let mut least_s = [f64::INFINITY; 3];
        for _ in 0..2 {
            let times_s = [
                call_s(quick, || fly(false)),
                call_s(quick, || fly(true)),
                call_s(quick, || {
                    program.evaluate(&part, black_box(&point), &mut system)
                }),
            ];
            for (least_s, time_s) in least_s.iter_mut().zip(times_s) {
                *least_s = least_s.min(time_s);
            }
        }
        let [plain_s, derived_s, whole_s] = least_s;
        Self {
            curve: curve.to_owned(),
            size,
            directions: problem.width(),
            steps: ((to_s - from_s) / problem.step_s).ceil() as usize,
            plain_s,
            derived_s,
            whole_s,
        }
    }
}
