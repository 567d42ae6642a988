//! Who is to blame for a misfit: the quantities that the scene keeps fixed and whose change would
//! explain most of it, by Rao's test ([`score`](super::score)).

use super::alone::Alone;
use super::hand::Hand;
use super::score::{Extended, Scores};
use crate::estimate::context::SolveContext;
use crate::estimate::covariance::bins::Bins;
use crate::estimate::layout::Layout;
use crate::estimate::problem::Problem;
use crate::estimate::recipe::{self, Recipe, Solution};
use crate::motion::{
    FreeParameter, Observer, Quantity, Quiet, Scene, Segment, Sketch, Suspect, Timing,
};
use crate::optimise::Schedule;
use crate::optimise::finish::Tolerances;
use crate::optimise::kkt::Kkt;

/// Greatest probability of a suspect's score under a right value, of all together (Bonferroni).
const LEVEL: f64 = 1e-3;
/// Least share of the misfit that a suspect explains.
const LEAST_SHARE: f64 = 0.1;
/// Share of the misfit that no wander of a hand has in common with one wrong quantity.
const ALL: f64 = 0.9;
/// Greatest number of quantities that are set free to see what they explain,
const TRIED: usize = 8;
/// and of suspects.
const MOST: usize = 3;

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
    let mut wider = scene.clone();
    for quantity in groups.iter().flatten() {
        if !is_free(&wider, *quantity) {
            wider.parameters.push(freed(scene, *quantity));
        }
    }
    let mut problem = Problem::new(&wider, sketch, segments);
    problem.velocity_gap_weight = context.problem.velocity_gap_weight;
    let layout = Layout::new(&problem);
    let mut point = solution.point.clone();
    let first = scene.parameters.len();
    let added = &wider.parameters[first..];
    point
        .parameters
        .extend(added.iter().map(|free| free.initial));
    let extended = SolveContext::new(&problem, &layout, context.epochs_s.clone(), &point);
    let Some(kkt) = Kkt::new(context, &solution.system, &solution.multipliers) else {
        return Vec::new();
    };
    let multipliers = &solution.multipliers;
    let of = Extended {
        context: &extended,
        point: &point,
        multipliers,
    };
    let scores = Scores::new(&of, (context, &kkt), noise.bins, first);
    let data = noise.data(context);
    let cost = solution.system.cost;
    let floor = floor(context, noise);
    let misfit = (cost - floor).max(f64::MIN_POSITIVE);
    let level = LEVEL / groups.len().max(1) as f64;
    let mut suspects: Vec<Suspect> = groups
        .iter()
        .filter_map(|group| {
            let at = |quantity: &Quantity| added.iter().position(|free| free.quantity == *quantity);
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
            let gain = data * (cost / left).ln() - group.len() as f64 * data.ln();
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

/// The best of those that score high, by what they explain when they are set free: where a value is
/// far off, the score's linear prediction no longer ranks them.
pub(super) fn tried(
    (context, solution): (&SolveContext, &Solution),
    (scene, sketch, segments): (&Scene, &Sketch, &[Segment]),
    (mut scored, noise, alone): (Vec<Suspect>, &Errors, &Alone),
    observer: &mut dyn Observer,
) -> Vec<Suspect> {
    scored.truncate(TRIED);
    scored.extend(unscored(scene, &scored, noise.is_exceeded));
    let cost = solution.system.cost;
    let data = noise.data(context);
    let tried = scored.into_iter().filter_map(|suspect| {
        let mut wider = scene.clone();
        let free = suspect.values.iter().map(|(quantity, value)| {
            let [lower, upper] = quantity.limits();
            FreeParameter {
                initial: *value,
                lower,
                upper,
                ..freed(scene, *quantity)
            }
        });
        wider.parameters.extend(free);
        let mut problem = Problem::new(&wider, sketch, segments);
        problem.velocity_gap_weight = context.problem.velocity_gap_weight;
        let layout = Layout::new(&problem);
        let first = scene.parameters.len();
        let added = &wider.parameters[first..];
        // The flights by themselves are near the motion where the value is far off.
        let trial = Recipe::of(trial());
        let starts = [
            (&alone.point, trial.clone()),
            (&solution.point, trial.from_the_last()),
        ];
        let found = starts.into_iter().find_map(|(start, recipe)| {
            let mut point = start.clone();
            point
                .parameters
                .extend(added.iter().map(|free| free.initial));
            let from = (point, context.epochs_s.clone());
            let found = recipe::solve_from(&problem, &layout, from, &recipe, &mut Quiet(observer));
            found.finished.converged.then_some(found)
        })?;
        let quantities = suspect.values.iter().map(|(quantity, _)| *quantity);
        let values = quantities.zip(found.point.parameters[first..].iter().copied());
        let values: Vec<(Quantity, f64)> = values.collect();
        let left = found.system.cost.max(f64::MIN_POSITIVE);
        let gain = data * (cost / left).ln() - values.len() as f64 * data.ln();
        let misfit = (cost - floor(context, noise)).max(f64::MIN_POSITIVE);
        let explains = ((cost - left) / misfit).clamp(0.0, 1.0);
        let is_suspect = gain > 0.0 && explains >= LEAST_SHARE;
        is_suspect.then_some(Suspect {
            values,
            explains,
            gain,
            ..suspect
        })
    });
    let mut tried: Vec<Suspect> = tried.collect();
    tried.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    let mut suspects: Vec<Suspect> = Vec::new();
    for suspect in tried {
        // Of the components of one thing, those that explain best stand for all.
        if !suspects.iter().any(|better| better.is_same_as(&suspect)) {
            suspects.push(suspect);
        }
    }
    suspects.truncate(MOST);
    suspects
}

/// The schedule of a trial: to compare objectives a few digits are enough, and what needs more steps
/// than this is no explanation.
fn trial() -> Schedule {
    Schedule {
        multiplier_rounds: (4, 10),
        retries: 0,
        tolerances: Tolerances {
            violation: 1e-6,
            decrease: 1e-6,
            steps: 15,
        },
        ..Schedule::default()
    }
}

/// What is tried though it did not score high: coefficients of friction, of which all above some value
/// are alike where a contact sticks, from zero, where it slides, if the misfit is beyond any wander; and the clock's rate where gravity
/// scored or gravity where the rate did, which are the same to a motion.
fn unscored(scene: &Scene, scored: &[Suspect], is_exceeded: bool) -> Vec<Suspect> {
    let has_scored = |is_it: &dyn Fn(Quantity) -> bool| {
        let mut values = scored.iter().flat_map(|suspect| &suspect.values);
        values.any(|(quantity, _)| is_it(*quantity))
    };
    let is_rate = |quantity| matches!(quantity, Quantity::ClockRate { .. });
    let is_gravity = |quantity| matches!(quantity, Quantity::Gravity { .. });
    let groups = groups(scene, Which::All).into_iter();
    let others = groups.filter_map(|group| match group[..] {
        [quantity] if has_scored(&|scored| scored == quantity) => None,
        [quantity @ Quantity::Friction { .. }] => is_exceeded.then_some((quantity, 0.0)),
        [quantity @ Quantity::ClockRate { .. }] => {
            has_scored(&is_gravity).then(|| (quantity, scene.value_of(quantity)))
        }
        [quantity @ Quantity::Gravity { .. }] => {
            has_scored(&is_rate).then(|| (quantity, scene.value_of(quantity)))
        }
        _ => None,
    });
    let suspect = |value| Suspect {
        values: vec![value],
        explains: 0.0,
        gain: 0.0,
        probability: 1.0,
    };
    others.map(suspect).collect()
}

/// What white noise leaves of the objective.
fn floor(context: &SolveContext, noise: &Errors) -> f64 {
    1.5 * context.problem.sample_count() as f64 * (noise.white[0] + noise.white[1])
}

/// Quantities that are suspected together: the components of one thing. Gravity's size is one more
/// thing than its vector.
fn groups(scene: &Scene, which: Which) -> Vec<Vec<Quantity>> {
    let is_alone = scene.mechanisms.len() == 1;
    let is_candidate = |quantity: &Quantity| {
        let means_something = match quantity {
            Quantity::LinearDrag { .. }
            | Quantity::QuadraticDrag { .. }
            | Quantity::Moment { .. }
            | Quantity::Mass { .. }
                if which == Which::Cheap =>
            {
                false
            }
            // Of one body, a force is gravity.
            Quantity::Force { .. } => !is_alone,
            Quantity::ClockRate { .. } | Quantity::ClockOffset { .. } => {
                scene.timing == Timing::Known
            }
            _ => true,
        };
        means_something
            && !is_free(scene, *quantity)
            && scene.untold(*quantity).is_none()
            && is_supported(scene, *quantity)
    };
    let mut groups: Vec<Vec<Quantity>> = Vec::new();
    for quantity in scene.quantities().into_iter().filter(is_candidate) {
        match groups
            .iter_mut()
            .find(|group| is_of_one(group[0], quantity))
        {
            Some(group) => group.push(quantity),
            None => groups.push(vec![quantity]),
        }
    }
    let size = Quantity::Gravity {
        axis: scene.gravity_m_s2.iamax(),
    };
    if groups
        .iter()
        .any(|group| group.len() > 1 && group.contains(&size))
    {
        groups.push(vec![size]);
    }
    groups
}

/// Whether two quantities are components of one thing.
fn is_of_one(a: Quantity, b: Quantity) -> bool {
    let thing = |quantity: Quantity| match quantity {
        Quantity::Gravity { .. } => Quantity::Gravity { axis: 0 },
        Quantity::Force { link, .. } => Quantity::Force { link, axis: 0 },
        Quantity::Centre { link, .. } => Quantity::Centre { link, axis: 0 },
        Quantity::TrackerPosition { track, .. } => Quantity::TrackerPosition { track, axis: 0 },
        Quantity::TrackerOrientation { track, .. } => {
            Quantity::TrackerOrientation { track, axis: 0 }
        }
        Quantity::Tilt { event, .. } => Quantity::Tilt { event, tangent: 0 },
        Quantity::SurfaceTilt { surface, .. } => Quantity::SurfaceTilt {
            surface,
            tangent: 0,
        },
        other => other,
    };
    thing(a) == thing(b)
}

fn is_free(scene: &Scene, quantity: Quantity) -> bool {
    scene
        .parameters
        .iter()
        .any(|free| free.quantity == quantity)
}

/// Whether the contacts of all collisions are supported with that quantity free.
fn is_supported(scene: &Scene, quantity: Quantity) -> bool {
    if !matches!(quantity, Quantity::Friction { .. } | Quantity::Tilt { .. }) {
        return true;
    }
    let mut wider = scene.clone();
    wider.parameters.push(freed(scene, quantity));
    (0..wider.events.len()).all(|event| wider.contact_set(event).is_ok())
}

fn freed(scene: &Scene, quantity: Quantity) -> FreeParameter {
    FreeParameter {
        name: scene.name_of_quantity(quantity),
        quantity,
        initial: scene.value_of(quantity),
        lower: f64::NEG_INFINITY,
        upper: f64::INFINITY,
        prior_sd: None,
    }
}
