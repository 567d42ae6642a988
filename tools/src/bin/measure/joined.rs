//! The recipe on trees: chains and pendulums from the sketch, beside the same solver from the true state.

use anyhow::Result;
use enact::estimate::tree::{Detail, TreeProblem, estimate, solve};
use enact::motion::{Estimate, Observer, Scene, TakeEvent, Verdict};
use enact::physics::tree::TreeState;
use enact::pipeline::Pipeline;
use enact::segment::clean::clean;
use enact_tools::trees::{Jointed, Kind, TreeActing, TreePerformance, perform};
use serde::Serialize;

use crate::core_time::{ANSWER_S, CoreLimit, CoreTime};
use crate::options::Options;
use crate::record::Record;
use crate::statistics::{largest, median};
use crate::table::{Table, number, percent, share};

/// Of the wander of a usual hand.
const DISTORTIONS: [f64; 3] = [1.0, 2.0, 4.0];
/// An objective within this of the best known one, relative, is as good.
const SAME: f64 = 1e-4;

/// What came of one start.
#[derive(Serialize)]
pub struct Solved {
    pub verdict: String,
    /// Whether it is a motion: doubted ones, far from their sketch, obey the laws too.
    pub is_motion: bool,
    objective: Option<f64>,
    pub iterations: usize,
    pub evaluations: usize,
    pub seconds: f64,
    /// State at the start.
    #[serde(skip)]
    pub state: Option<TreeState>,
}

impl Solved {
    pub fn of(estimate: Option<&Estimate>, seconds: f64) -> Self {
        let Some(estimate) = estimate else {
            return Self {
                verdict: "refused".to_owned(),
                is_motion: false,
                objective: None,
                iterations: 0,
                evaluations: 0,
                seconds,
                state: None,
            };
        };
        let knots = estimate.trees.first().map(|tree| &tree.knots);
        let first = knots.and_then(|knots| knots.first());
        Self {
            verdict: format!("{:?}", estimate.verdict).to_lowercase(),
            is_motion: estimate.verdict != Verdict::Failed,
            objective: Some(estimate.objective).filter(|objective| objective.is_finite()),
            iterations: estimate.counters.iterations,
            evaluations: estimate.counters.evaluations,
            seconds,
            state: first.map(|knot| knot.state.clone()),
        }
    }

    /// The objective of a motion.
    pub fn best(&self) -> Option<f64> {
        self.objective.filter(|_| self.is_motion)
    }
}

/// One performance.
#[derive(Serialize)]
struct Performed {
    seed: u64,
    sketched: Solved,
    from_truth: Solved,
    /// Of the true motion, which the best one is below.
    truth_objective: f64,
}

impl Performed {
    fn of(kind: &Kind, distortion: f64, seed: u64) -> Self {
        let performance = perform(kind, &TreeActing::of(distortion), seed);
        Self {
            seed,
            sketched: sketched(&performance),
            from_truth: solved_from(&performance, performance.truth.clone()),
            truth_objective: performance.truth_cost(),
        }
    }

    /// The lower objective of those of motions.
    fn best(&self) -> Option<f64> {
        let both = [self.sketched.best(), self.from_truth.best()];
        both.into_iter().flatten().reduce(f64::min)
    }

    /// Whether one of the two found the best known motion.
    fn has_best(&self, solved: &Solved) -> bool {
        let found = solved.best().zip(self.best());
        found.is_some_and(|(found, best)| found <= best * (1.0 + SAME))
    }
}

/// The program, from the recording.
pub fn sketched(performance: &TreePerformance) -> Solved {
    let time = CoreTime::begin();
    let events = performance.events.iter().cloned();
    let limit = &mut CoreLimit(&time, ANSWER_S);
    let outcome = Pipeline::of(performance.scene.clone(), events).finish(limit);
    let estimate = outcome.as_ref().ok().map(|outcome| &outcome.estimate);
    Solved::of(estimate, time.seconds())
}

/// Its solver, from a state at the start.
pub fn solved_from(performance: &TreePerformance, start: TreeState) -> Solved {
    let time = CoreTime::begin();
    let (scene, events) = (&performance.scene, &performance.events);
    let estimate = from_state((scene, events), start, &mut CoreLimit(&time, ANSWER_S));
    Solved::of(estimate.as_ref(), time.seconds())
}

/// What the solver makes of a take from a state at the start; none where that cannot be read.
pub fn from_state(
    (scene, events): (&Scene, &[TakeEvent]),
    start: TreeState,
    observer: &mut dyn Observer,
) -> Option<Estimate> {
    let (sketch, _) = clean(scene, events).ok()?;
    let problem = TreeProblem::new(scene, &sketch);
    let solved = solve(&problem, &[(1.0, start)], observer);
    Some(estimate(scene, &sketch, &solved, Detail::Whole, observer))
}

fn kinds() -> Vec<(String, Kind)> {
    let mut kinds = vec![("the chain".to_owned(), Kind::CHAIN)];
    let joints = [
        ("pins", Jointed::Pin),
        ("universal", Jointed::Universal),
        ("balls", Jointed::Ball),
    ];
    for links in [2, 3, 4, 5, 6, 8] {
        kinds.extend(joints.map(|(name, joints)| {
            (
                format!("pendulum of {links}, {name}"),
                Kind::pendulum(links, joints),
            )
        }));
    }
    kinds
}

/// Performances of a row: fewer of what takes seconds each, and of rougher hands.
fn performances(kind: &Kind, distortion: f64) -> u64 {
    match kind.links {
        ..=SHORT if distortion == DISTORTIONS[0] => 100,
        ..=SHORT => 20,
        4 => 5,
        _ => 2,
    }
}

/// Most links of what is summed up as short.
const SHORT: usize = 3;

/// Runs it.
pub fn run(options: &Options, record: &mut Record) -> Result<()> {
    let header = [
        "motion",
        "hand",
        "performances",
        "motions",
        "best known",
        "from the truth: motions",
        "best known",
        "iterations",
        "evaluations",
        "time, ms",
        "longest, ms",
        "from the truth: iterations",
        "time, ms",
    ];
    let mut table = Table::new("recipe", "", &header);
    let mut numbers = Vec::new();
    // Of the chain, of short pendulums, of long ones.
    let mut shares = [[(0, 0); DISTORTIONS.len()]; 3];
    for (name, kind) in kinds() {
        let length = usize::from(kind.is_clamped) + usize::from(kind.links > SHORT);
        for (distortion, counted) in DISTORTIONS.into_iter().zip(&mut shares[length]) {
            // A quick run leaves out what takes seconds each.
            let is_slow = distortion > DISTORTIONS[0] || kind.is_clamped && kind.links > 3;
            if options.quick && is_slow || !options.wants(&format!("{name}, {distortion}x")) {
                continue;
            }
            let seeds = options.seeds(performances(&kind, distortion));
            let all: Vec<Performed> = seeds
                .map(|seed| Performed::of(&kind, distortion, seed))
                .collect();
            let of = |of: &dyn Fn(&Performed) -> f64| all.iter().map(of).collect::<Vec<f64>>();
            let times_s = of(&|one| one.sketched.seconds);
            table.row([
                name.clone(),
                format!("{distortion}×"),
                all.len().to_string(),
                share(&all, |one| one.sketched.is_motion),
                share(&all, |one| one.has_best(&one.sketched)),
                share(&all, |one| one.from_truth.is_motion),
                share(&all, |one| one.has_best(&one.from_truth)),
                number(median(&of(&|one| one.sketched.iterations as f64))),
                number(median(&of(&|one| one.sketched.evaluations as f64))),
                number(1e3 * median(&times_s)),
                number(1e3 * largest(&times_s)),
                number(median(&of(&|one| one.from_truth.iterations as f64))),
                number(1e3 * median(&of(&|one| one.from_truth.seconds))),
            ]);
            eprintln!("  {name}, {distortion}x");
            counted.0 += all.iter().filter(|one| one.has_best(&one.sketched)).count();
            counted.1 += all.len();
            numbers.push((name.clone(), distortion, all));
        }
    }
    let [chain, short, long] = shares.map(|shares| {
        let said = DISTORTIONS.iter().zip(shares);
        let said = said.filter(|(_, (_, of))| *of > 0);
        let said = said.map(|(distortion, (found, of))| {
            format!("{} of {of} at {distortion}×", percent(found, of))
        });
        said.collect::<Vec<String>>().join(", ")
    });
    record.say(format!(
        "From their sketches the best known motion is found of chains in {chain}; of pendulums of 2 and 3 rods in {short}; of 4 to 8 rods in {long}."
    ));
    record.table(table);
    record.numbers("joined", &numbers)
}
