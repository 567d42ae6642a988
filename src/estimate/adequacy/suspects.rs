//! Who is to blame for a misfit: the quantities that the scene keeps fixed and whose change would
//! explain most of it, by Rao's test ([`score`](super::score)).

mod candidates;
mod trial;

use self::candidates::groups;
pub(super) use self::trial::tried;
use super::hand::Hand;
use super::score::{Extended, Scores};
use crate::estimate::context::SolveContext;
use crate::estimate::covariance::bins::Bins;
use crate::estimate::layout::Layout;
use crate::estimate::point::Point;
use crate::estimate::problem::Problem;
use crate::estimate::recipe::Solution;
use crate::motion::{FreeParameter, Quantity, Scene, Segment, Sketch, Suspect};
use crate::optimise::kkt::Kkt;

/// Greatest probability of a suspect's score under a right value, of all together (Bonferroni).
const LEVEL: f64 = 1e-3;
/// Least share of the misfit that a suspect explains.
const LEAST_SHARE: f64 = 0.1;
/// Share of the misfit that no wander of a hand has in common with one wrong quantity.
const ALL: f64 = 0.9;

/// The samples' errors that scores are compared with.
pub(super) struct Errors<'a> {
    /// Variances of white noise, of positions and orientations, in squared units.
    pub(super) white: [f64; 2],
    /// The hand's wander over the bins, where the flights show one.
    pub(super) hands: Option<&'a [Hand; 2]>,
    /// Whether the misfit is beyond the white noise and the wander, if there is one.
    pub(super) is_exceeded: bool,
    /// The bins.
    pub(super) bins: &'a Bins,
}

impl Errors<'_> {
    /// Number of independent data: under a wander the samples of a bin are one.
    fn data(&self, context: &SolveContext) -> f64 {
        let count = match self.hands {
            Some(_) => self.bins.count(),
            None => context.problem.sample_count(),
        };
        6.0 * count as f64
    }

    /// Decrease of Schwarz's criterion where an objective becomes so many times less by as many
    /// quantities.
    fn gain(&self, context: &SolveContext, ratio: f64, quantities: usize) -> f64 {
        let data = self.data(context);
        data * ratio.ln() - quantities as f64 * data.ln()
    }

    /// What white noise leaves of the objective.
    fn floor(&self, context: &SolveContext) -> f64 {
        1.5 * context.problem.sample_count() as f64 * (self.white[0] + self.white[1])
    }
}

/// A problem with more parameters than that of a solution.
struct Wider {
    problem: Problem,
    layout: Layout,
    /// The first of them among the parameters,
    first: usize,
    /// and all.
    added: Vec<FreeParameter>,
}

impl Wider {
    fn new(
        context: &SolveContext,
        (scene, sketch, segments): (&Scene, &Sketch, &[Segment]),
        added: Vec<FreeParameter>,
    ) -> Self {
        let mut wider = scene.clone();
        wider.parameters.extend(added.iter().cloned());
        let mut problem = Problem::new(&wider, sketch, segments);
        problem.velocity_gap_weight = context.problem.velocity_gap_weight;
        Self {
            layout: Layout::new(&problem),
            problem,
            first: scene.parameters.len(),
            added,
        }
    }

    /// A point of the narrower problem, with the added parameters as they begin.
    fn point(&self, narrow: &Point) -> Point {
        let mut point = narrow.clone();
        let initial = self.added.iter().map(|free| free.initial);
        point.parameters.extend(initial);
        point
    }
}

/// Which quantities are looked into.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Which {
    /// Those by which flights are differentiated in closed form.
    Cheap,
    /// All.
    All,
}

/// Those that score high, the one with the greatest gain first.
pub(super) fn scored(
    (context, solution): (&SolveContext, &Solution),
    (scene, sketch, segments): (&Scene, &Sketch, &[Segment]),
    (noise, which): (&Errors, Which),
) -> Vec<Suspect> {
    let groups = groups(scene, which);
    let mut free: Vec<FreeParameter> = Vec::new();
    for quantity in groups.iter().flatten() {
        if !free.iter().any(|free| free.quantity == *quantity) {
            // Without bounds, whose rows the solution's multipliers do not have.
            free.push(FreeParameter {
                lower: f64::NEG_INFINITY,
                upper: f64::INFINITY,
                ..scene.freed(*quantity, scene.value_of(*quantity))
            });
        }
    }
    let wider = Wider::new(context, (scene, sketch, segments), free);
    let point = wider.point(&solution.point);
    let epochs_s = context.epochs_s.clone();
    let extended = SolveContext::new(&wider.problem, &wider.layout, epochs_s, &point);
    let Some(kkt) = Kkt::new(context, &solution.system, &solution.multipliers) else {
        return Vec::new();
    };
    let multipliers = &solution.multipliers;
    let of = Extended {
        context: &extended,
        point: &point,
        multipliers,
    };
    let scores = Scores::new(&of, (context, &kkt), noise.bins, wider.first);
    let cost = solution.system.cost;
    let floor = noise.floor(context);
    let misfit = (cost - floor).max(f64::MIN_POSITIVE);
    let level = LEVEL / groups.len().max(1) as f64;
    let mut suspects: Vec<Suspect> = groups
        .iter()
        .filter_map(|group| {
            let at = |quantity: &Quantity| {
                wider
                    .added
                    .iter()
                    .position(|free| free.quantity == *quantity)
            };
            let indices: Vec<usize> = group.iter().map(at).collect::<Option<_>>()?;
            let lengths: Vec<f64> = group.iter().map(|quantity| quantity.typical()).collect();
            let scored = scores.of(&indices, &lengths, (noise.white, noise.hands))?;
            let values = group.iter().zip(&scored.changes).map(|(quantity, change)| {
                let [lower, upper] = quantity.limits();
                let given = scene.value_of(*quantity);
                (*quantity, (given + change).clamp(lower, upper))
            });
            let values: Vec<(Quantity, f64)> = values.collect();
            // A quantity that would have to leave what is physical explains nothing.
            let moves = values.iter().any(|(q, value)| *value != scene.value_of(*q));
            let left = (cost - scored.decrease)
                .max(floor.min(cost))
                .max(1e-3 * cost);
            let gain = noise.gain(context, cost / left, group.len());
            let suspect = Suspect {
                values,
                explains: (scored.decrease / misfit).clamp(0.0, 1.0),
                gain,
                probability: scored.probability,
            };
            // A wander that looks just like one wrong quantity would be a coincidence.
            let is_told = suspect.probability < level || suspect.explains >= ALL;
            let is_suspect =
                moves && suspect.gain > 0.0 && is_told && suspect.explains >= LEAST_SHARE;
            is_suspect.then_some(suspect)
        })
        .collect();
    suspects.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    suspects
}
