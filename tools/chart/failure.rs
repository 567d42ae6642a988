//! Success rate of each method as one trouble grows.
//!
//! [`cases`] makes every problem once, with where to start and the best known answer, so that other
//! solvers may be asked the same. Marks and outliers act before any solve: all methods get what the
//! program's segmentation makes of them, unless a curve says otherwise.

use anyhow::Result;
use enact::estimate::finish::Tolerances;
use enact::estimate::recipe::{self, Recipe};
use rayon::prelude::*;

use crate::case::{Case, Posed};
use crate::figure::{Axis, Curve, Figure, Mark};
use crate::methods::{Grid, Method, Task};
use crate::tasks::{posing, with_marks_as_they_are};
use crate::troubles::{Trouble, troubles};
use crate::{Book, Options};

/// Performances of each setting.
const SEEDS: u64 = 24;
/// Evaluations of the evolution strategy.
const EVALUATIONS: usize = 10_000;
/// And the most performances that it is asked.
const SAMPLED: u64 = 8;
/// Starts among which the best optimum is.
const STARTS: usize = 8;

/// One performance of one setting of a trouble.
pub struct Posed1 {
    /// Index of the trouble.
    pub trouble: usize,
    /// Index of its setting.
    pub setting: usize,
    /// Problem, guesses, best; none where segmentation refused, which fails every method.
    pub task: Option<Task>,
    /// The same with the performer's marks as they are: problem, guesses.
    as_they_are: Option<Posed>,
}

/// Every problem of this part, trouble by trouble, setting by setting.
pub fn cases(troubles: &[Trouble], quick: bool) -> Vec<Posed1> {
    let seeds = if quick { 3 } else { SEEDS };
    let mut all = Vec::new();
    for (trouble, of) in troubles.iter().enumerate() {
        for setting in 0..of.settings.len() {
            all.extend((0..seeds).map(|seed| (trouble, setting, seed)));
        }
    }
    let made = all.into_par_iter().filter_map(|(trouble, setting, seed)| {
        let of = &troubles[trouble];
        // A seed without a motion is no performance.
        let case = (of.make)(of.settings[setting], seed).ok()?;
        let posing = posing(&case, seed, if quick { 4 } else { STARTS });
        let as_they_are = posing.as_ref().ok().filter(|_| of.acts_before);
        let as_they_are = as_they_are.and_then(|posing| as_they_are_posed(&case, &posing.sketch));
        Some(Posed1 {
            trouble,
            setting,
            task: posing.ok().map(|posing| posing.task),
            as_they_are,
        })
    });
    made.collect()
}
