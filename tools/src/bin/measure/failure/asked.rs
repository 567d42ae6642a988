//! Problems and what peers make of them.

use anyhow::Result;
use enact::motion::Sketch;
use rayon::prelude::*;

use super::troubles::Trouble;
use crate::options::Options;
use crate::peers::{self, PEERS};
use crate::posing::{posing, with_marks_as_they_are};
use enact_tools::case::{Case, Posed};
use enact_tools::export;
use enact_tools::methods::Task;

/// Performances of each setting, and how long peers may take \[s\].
pub const SEEDS: u64 = 30;
pub const LIMIT_S: f64 = 1.0;
/// Starts among which the best optimum is.
pub const STARTS: usize = 6;

/// One performance of one setting of a trouble.
pub struct Asked {
    /// Index of the trouble.
    pub trouble: usize,
    /// Index of its setting.
    pub setting: usize,
    /// Index of the performance.
    pub index: u64,
    /// Problem, guesses, best known objective; none where segmentation refused it, which fails
    /// every method.
    pub task: Option<Task>,
    /// The same with the performer's marks as they are.
    pub as_they_are: Option<Posed>,
    /// What peers make of it.
    pub peers: Vec<peers::Answer>,
}

/// Every problem of this part, trouble by trouble, setting by setting.
pub fn cases(troubles: &[Trouble], options: &Options) -> Vec<Asked> {
    let mut all = Vec::new();
    for (trouble, of) in troubles.iter().enumerate() {
        for setting in 0..of.settings.len() {
            let seeds = options.seeds(SEEDS).enumerate();
            all.extend(seeds.map(|(index, seed)| (trouble, setting, index as u64, seed)));
        }
    }
    let made = all
        .into_par_iter()
        .filter_map(|(trouble, setting, index, seed)| {
            let of = &troubles[trouble];
            // A seed without a motion is no performance.
            let case = (of.make)(of.settings[setting], seed).ok()?;
            let posing = posing(&case, seed, options.either(3, STARTS)).ok();
            let raw = posing.as_ref().filter(|_| of.acts_before);
            let as_they_are = raw.and_then(|posing| as_they_are(&case, &posing.sketch));
            let task = posing.map(|posing| posing.task);
            // Without any optimum there is nothing to miss.
            let is_task = task.as_ref().is_none_or(|task| task.best.is_some());
            is_task.then_some(Asked {
                trouble,
                setting,
                index,
                task,
                as_they_are,
                peers: Vec::new(),
            })
        });
    made.collect()
}

fn as_they_are(case: &Case, sketch: &Sketch) -> Option<Posed> {
    let sketch = with_marks_as_they_are(case, sketch)?;
    enact::segment::cut(case.scene(), &sketch).ok()?;
    Some(Posed::without_marks(case.scene(), &sketch))
}

/// Asks the peers for the same, in two processes: here only success counts.
pub fn ask_peers(asked: &mut [Asked]) -> Result<()> {
    let mut given: Vec<&mut Asked> = asked
        .iter_mut()
        .filter(|asked| asked.task.is_some())
        .collect();
    let settings = peers::Settings {
        repeats: 1,
        limit_s: LIMIT_S,
        tolerance: 1e-8,
        from: "start",
        peers: PEERS,
    };
    let half = given.len().div_ceil(2).max(1);
    let halves = given.par_chunks_mut(half).map(|asked| -> Result<()> {
        let tasks = asked.iter().filter_map(|asked| asked.task.as_ref());
        let problem =
            |task: &Task| export::problem("", &task.problem, &task.layout, &task.guesses[0], &[]);
        let problems: Vec<export::Problem> = tasks.map(problem).collect();
        let report = peers::solve(&problems, &settings)?;
        for answer in report.into_iter().flat_map(|report| report.answers) {
            asked[answer.problem].peers.push(answer);
        }
        Ok(())
    });
    halves.collect()
}
