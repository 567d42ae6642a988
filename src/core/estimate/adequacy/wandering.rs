//! Whether a motion explains a performance whose errors are a process in time, and which quantity that the scene keeps fixed
//! is wrong: the same of bodies by themselves and of joined ones.
//!
//! The process takes any size, so that what is left is always explained by some hand. A wrong scene shows where one quantity
//! explains it better ([`wrong`]), or where the hand would have strayed farther than any does.

use nalgebra::DMatrix;
use statrs::distribution::{ContinuousCDF, FisherSnedecor};

use super::suspects::{Which, Wider, candidates, unbounded};
use super::{Judged, farther_than_rest, rms, score};
use crate::estimate::covariance::bins::Residuals;
use crate::estimate::covariance::linearised::{LinearisedSolution, free_directions};
use crate::estimate::problem::weave::Weave;
use crate::estimate::schedule::recipe::Solution;
use crate::estimate::terms::context::{Guidance, SolveContext};
use crate::estimate::terms::woven;
use crate::estimate::unknowns::point::Point;
use crate::estimate::wander::Process;
use crate::estimate::wander::likelihood::{FittedErrors, Restricted};
use crate::estimate::wander::series::SeriesRows;
use crate::estimate::wander::wrong::{self, Judgement, KeptQuantity};
use crate::motion::{
    Fit, FitUntold, Fits, Observer, Performance, Quantity, Scene, Suspect, Tested, WholeFit,
};
use crate::optimise::Program;
use crate::optimise::kkt::Kkt;

/// Above this probability of the data under white noise they fit without a wander.
const WELL: f64 = 1e-3;
/// A hand that strays farther than this, in units of the scene's weights, is none.
const FAR: f64 = 10.0;
/// A motion that is nearer to its samples than this share of the distance of bodies that rest is not compared with these.
const FAR_SHARE: f64 = 0.5;
/// By how much `−2 log` of the likelihood of what rests may be less by chance: odds of a thousand.
const BY_CHANCE: f64 = 13.8;
/// Share of the wander that has to go with what a hand that drifts steadily is like.
const DRIFT: f64 = 0.5;
/// Of a link's length, how far elsewhere a joint must show for a motion to be said to fit.
const SHOWN_SHARE: f64 = 0.1;
/// Greatest number of suspects.
const MOST: usize = 4;
/// Least number of contrasts that tell anything.
const LEAST_FREEDOM: f64 = 6.0;

/// How well a solution explains its samples, and what in the scene is wrong; fails where samples tell too little and where the
/// observer stops it.
pub(super) fn judge(
    context: &SolveContext,
    weave: &Weave,
    solution: &Solution,
    errors: &[Residuals],
    performance: Performance,
    observer: &mut dyn Observer,
) -> Result<Judged, FitUntold> {
    let (scene, problem) = (performance.scene, context.problem);
    let kkt = Kkt::new(context, &solution.system, &solution.multipliers);
    let kkt = kkt.ok_or(FitUntold::FewSamples)?;
    let free = free_directions(context, &solution.system, &kkt).ok_or(FitUntold::FewSamples)?;
    let quantities = candidates(scene, Which::All);
    let added = quantities
        .iter()
        .map(|quantity| unbounded(scene, *quantity));
    let wider = Wider::new(context, performance, added.collect());
    let point = wider.point(&solution.point);
    let epochs_s = context.epochs_s.clone();
    let extended = SolveContext::new(&wider.problem, &wider.layout, epochs_s, &point);
    let system = extended.evaluated(&Guidance::none(), &point);
    let further = score::directions(&extended, &system, context, &kkt, wider.first);
    let count = free.ncols();
    let mut directions = DMatrix::zeros(extended.layout.size(), count + further.len());
    directions.view_mut((0, 0), free.shape()).copy_from(&free);
    for (at, direction) in further.iter().enumerate() {
        directions.set_column(count + at, direction);
    }
    let linearised = LinearisedSolution::new(&extended, &point, &directions, count, 0.0);
    let linearised = linearised.ok_or(FitUntold::FewSamples)?;
    let restricted = linearised.restricted();
    let joint = rms(problem, errors);
    let may_rest = farther_than_rest(problem, joint[0] / FAR_SHARE);
    let asked = Asked {
        scene,
        quantities: &quantities,
        joint,
        is_far: may_rest && is_likelier_at_rest(context, weave, &solution.point, restricted.rows),
    };
    let fitted = restricted.at(&weave.processes);
    let fitted = fitted.ok_or(FitUntold::FewSamples)?;
    let (fit, suspects) = asked.judged(&restricted, &fitted, observer)?;
    Ok(Judged {
        fit,
        suspects,
        start: None,
    })
}

/// Whether places that samples show are likelier of bodies that rest, with their likeliest errors, than of the motion: no one
/// quantity is to blame for that. How far a hand strays does not tell it, for one that strays far from small motions shows these
/// all the same.
fn is_likelier_at_rest(
    context: &SolveContext,
    weave: &Weave,
    point: &Point,
    rows: &SeriesRows,
) -> bool {
    let likeliest = || {
        let (series, columns) = woven::places(context, point, weave)?;
        let places = SeriesRows::new(&series, &columns);
        let size = columns.ncols();
        let at_rest = Restricted {
            rows: &places,
            free: size - 1,
            priors: &DMatrix::zeros(size, size),
            least: 0.0,
        };
        let at_rest = at_rest.likeliest(&[Process::EXPECTED; 2])?;
        let moving = Restricted {
            rows: &rows.of_kind(0).select(&[rows.count() - 1]),
            free: 0,
            priors: &DMatrix::zeros(1, 1),
            least: 0.0,
        };
        let moving = moving.at(&[weave.processes[0], Process::EXPECTED])?;
        // Restricted likelihoods of other means are not comparable.
        let at_rest = at_rest.merit - at_rest.information.ln_determinant();
        Some(at_rest + BY_CHANCE < moving.merit)
    };
    rows.shows(0) && likeliest().unwrap_or(false)
}

/// How a quantity is looked at: a hand that drifts steadily is like a clock that is slow, another gravity or drag, but its
/// wander stays where one of them is free.
fn kept(quantity: Quantity) -> KeptQuantity {
    let is_like_drift = matches!(
        quantity,
        Quantity::ClockRate { .. }
            | Quantity::ClockOffset { .. }
            | Quantity::Gravity { .. }
            | Quantity::Force { .. }
            | Quantity::LinearDrag { .. }
            | Quantity::QuadraticDrag { .. }
    );
    KeptQuantity {
        typical: quantity.typical(),
        explains_least: if is_like_drift { DRIFT } else { 0.0 },
    }
}

/// What is asked of a motion.
pub(in crate::estimate) struct Asked<'a> {
    /// What is said to be true.
    pub(in crate::estimate) scene: &'a Scene,
    /// What it keeps fixed, in the order of the columns.
    pub(in crate::estimate) quantities: &'a [Quantity],
    /// Root mean square residual: position \[m\], orientation \[rad\].
    pub(in crate::estimate) joint: [f64; 2],
    /// Whether what rests explains its samples better.
    pub(in crate::estimate) is_far: bool,
}

impl Asked<'_> {
    /// The answer, and what is suspected.
    pub(in crate::estimate) fn judged(
        &self,
        of: &Restricted,
        fitted: &FittedErrors,
        observer: &mut dyn Observer,
    ) -> Result<(Fit, Vec<Suspect>), FitUntold> {
        let kept: Vec<KeptQuantity> = self.quantities.iter().map(|of| kept(*of)).collect();
        let judgement = wrong::judge(of, fitted, &kept, &mut || observer.should_stop());
        let judgement = judgement.ok_or(FitUntold::Stopped)?;
        let whole = self.whole(of, fitted, &judgement);
        let whole = whole.ok_or(FitUntold::FewSamples)?;
        let suspects = self.suspects(&judgement);
        let strays = (0..2).filter(|kind| of.rows.shows(*kind));
        let strays = strays.map(|kind| fitted.processes[kind].wander_variance().sqrt());
        let is_no_hand = strays.fold(0.0, f64::max) > FAR;
        let fits = match () {
            () if !suspects.is_empty() || self.is_far || is_no_hand => Fits::No,
            () if self.hides_joints(&judgement) => Fits::Unknown,
            () => Fits::Yes,
        };
        // What noise makes.
        let alone =
            [0, 1].map(|kind| 3_f64.sqrt() * fitted.processes[kind].noise_sd * of.rows.unit(kind));
        let fit = Fit {
            fits,
            joint: self.joint,
            alone,
            parts: Vec::new(),
            whole: Some(whole),
        };
        Ok((fit, suspects))
    }

    /// Whether a joint that is elsewhere by more than a share of its link would not show.
    fn hides_joints(&self, judgement: &Judgement) -> bool {
        let each = self.quantities.iter().zip(&judgement.shows);
        let mut shares = each.filter_map(|(quantity, shows_m)| match quantity {
            Quantity::JointPlace { child, .. } => {
                Some(shows_m / (2.0 * self.scene.links[*child].radius_m()))
            }
            _ => None,
        });
        shares.any(|share| share > SHOWN_SHARE)
    }

    fn whole(
        &self,
        of: &Restricted,
        fitted: &FittedErrors,
        judgement: &Judgement,
    ) -> Option<WholeFit> {
        let alone = &judgement.by_noise;
        let freedom = (3 * of.rows.samples()) as f64 - of.free as f64;
        if freedom < LEAST_FREEDOM {
            return None;
        }
        let last = alone.left.nrows() - 1;
        let statistic = alone.left[(last, last)] / freedom;
        let law = FisherSnedecor::new(freedom, freedom).ok()?;
        let by_noise = Tested {
            statistic,
            freedom: freedom as usize,
            noise_freedom: freedom as usize,
            probability: law.sf(statistic),
        };
        let each = self.quantities.iter().zip(&judgement.shows);
        let joints = each.clone().filter_map(|(quantity, shows)| {
            let is_place = matches!(quantity, Quantity::JointPlace { .. });
            is_place.then_some(*shows)
        });
        Some(WholeFit {
            by_noise,
            is_noise: by_noise.probability >= WELL,
            log_odds_of_wander: 0.5 * (alone.merit - fitted.merit),
            shown_m: joints.reduce(f64::max),
            untold: each
                .filter(|(_, shows)| shows.is_infinite())
                .map(|(quantity, _)| *quantity)
                .collect(),
        })
    }

    fn suspects(&self, judgement: &Judgement) -> Vec<Suspect> {
        let each = judgement.wrong.iter().map(|wrong| {
            let quantity = self.quantities[wrong.index];
            let [lower, upper] = quantity.limits();
            let value = (self.scene.value_of(quantity) + wrong.change).clamp(lower, upper);
            Suspect {
                values: vec![(quantity, value)],
                explains: wrong.explains,
                gain: 2.0 * wrong.log_odds,
                probability: (-wrong.log_odds).exp(),
            }
        });
        together(each.collect())
    }
}

/// The likeliest, and those that explain the performance as well. Of the components of one thing, the one that explains
/// best stands for all.
pub(in crate::estimate) fn together(mut suspects: Vec<Suspect>) -> Vec<Suspect> {
    suspects.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    let mut kept: Vec<Suspect> = Vec::new();
    for suspect in suspects {
        let is_of_first = kept
            .first()
            .is_none_or(|first| first.is_rivalled_by(&suspect));
        if is_of_first && !kept.iter().any(|better| better.is_same_as(&suspect)) {
            kept.push(suspect);
        }
    }
    kept.truncate(MOST);
    kept
}
