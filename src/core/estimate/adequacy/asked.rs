//! Whether a motion explains a performance, and which quantity that the scene keeps fixed is wrong: the same of bodies by
//! themselves and of joined ones.
//!
//! Errors are a process that takes any size, so that what is left is always explained by some hand. A wrong scene shows where
//! one quantity explains it better ([`wrong`]), where the hand would have strayed farther than any does, and where there was
//! none.

use crate::estimate::covariance::in_time::Strayed;
use crate::estimate::wander::likelihood::{FittedErrors, NoiseAlone, Restricted};
use crate::estimate::wander::wrong::{self, Judgement, KeptQuantity, Looker, WrongQuantity};
use crate::motion::{Fit, FitUntold, Fits, Observer, Quantity, Scene, Suspect};

/// A hand that strays farther than this, in units of the scene's weights, is none.
const FAR: f64 = 10.0;
/// Share of the wander that has to go with what a hand that drifts steadily is like.
const DRIFT: f64 = 0.5;
/// Of a link's length, how far elsewhere a joint must show for a motion to be said to fit.
const SHOWN_SHARE: f64 = 0.1;
/// Greatest number of suspects.
const MOST: usize = 4;

/// How a quantity is looked at: a hand that drifts steadily is like a clock that is slow, another gravity or drag, but its
/// wander stays where one of them is free. Where quantities are tried, what a slope may not tell is, too.
fn kept(scene: &Scene, strayed: Strayed, is_tried: bool, quantity: Quantity) -> KeptQuantity {
    let given = scene.value_of(quantity);
    let is_like_drift = matches!(
        quantity,
        Quantity::ClockRate { .. }
            | Quantity::ClockOffset { .. }
            | Quantity::Gravity { .. }
            | Quantity::Force { .. }
            | Quantity::LinearDrag { .. }
            | Quantity::QuadraticDrag { .. }
            | Quantity::Lift { .. }
    );
    KeptQuantity {
        typical: quantity.typical(),
        explains_least: match is_like_drift && strayed.may_be_hand() {
            true => DRIFT,
            false => 0.0,
        },
        room: scene.limits_of(quantity).map(|limit| limit - given),
        // What sticks does so with any more friction.
        tried_from: (is_tried && matches!(quantity, Quantity::Friction { .. })).then_some(-given),
    }
}

/// What is asked of how a motion fits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::estimate) enum FitAsked {
    /// Whether the motion explains the performance, and what is suspected where it does not.
    WithSuspects,
    /// The first alone: suspects that cannot change it are not tried, and are not to be relied upon.
    Alone,
}

/// What is asked of a motion.
pub(in crate::estimate) struct Asked<'a> {
    /// Whether suspects are wanted, too.
    pub(in crate::estimate) of_fit: FitAsked,
    /// What is said to be true.
    pub(in crate::estimate) scene: &'a Scene,
    /// What it keeps fixed, in the order of the columns.
    pub(in crate::estimate) quantities: &'a [Quantity],
    /// Root mean square residual: position \[m\], orientation \[rad\].
    pub(in crate::estimate) joint: [f64; 2],
    /// Whether what rests explains its samples better.
    pub(in crate::estimate) is_far: bool,
    /// Who may have strayed.
    pub(in crate::estimate) strayed: Strayed,
    /// How quantities are tried by which a motion may be far off; their slopes decide where it is none.
    pub(in crate::estimate) trials: Option<&'a dyn Trials>,
}

/// Quantities set free for a trial.
pub(in crate::estimate) trait Trials {
    /// What a quantity explains where the motion is found again with it free, from where its slope leads; `None` where that
    /// leads to no motion. `fixed` is what follows of the errors where it is not.
    fn tried(
        &self,
        quantity: Quantity,
        near: &WrongQuantity,
        fixed: &FittedErrors,
        observer: &mut dyn Observer,
    ) -> Option<WrongQuantity>;
}

/// Looks at quantities one by one, as is asked.
struct AskedLooker<'a> {
    asked: &'a Asked<'a>,
    trials: Option<&'a dyn Trials>,
    observer: &'a mut dyn Observer,
}

impl Looker for AskedLooker<'_> {
    fn should_stop(&mut self) -> bool {
        self.observer.should_stop()
    }

    fn tried(&mut self, near: WrongQuantity, fixed: &FittedErrors) -> Option<WrongQuantity> {
        let Some(trials) = self.trials else {
            return Some(near);
        };
        let quantity = self.asked.quantities[near.index];
        trials.tried(quantity, &near, fixed, self.observer)
    }
}

impl Asked<'_> {
    /// The answer, and what is suspected.
    pub(in crate::estimate) fn judged(
        &self,
        of: &Restricted,
        fitted: &FittedErrors,
        observer: &mut dyn Observer,
    ) -> Result<(Fit, Vec<Suspect>), FitUntold> {
        let alone = NoiseAlone::of(of, fitted).ok_or(FitUntold::FewSamples)?;
        let is_noise = alone.explains();
        // Noise that explains residuals does not rule out a wander, which is as likely then.
        let told = match self.strayed {
            Strayed::Tracker => &alone.fitted,
            Strayed::Hand | Strayed::MaybeHand | Strayed::NoHand => fitted,
        };
        // Where noise does not explain what a tracker saw, its size alone decides.
        let is_decided = self.is_far || self.strayed == Strayed::Tracker || is_no_hand(of, told);
        let is_idle = self.of_fit == FitAsked::Alone && is_decided;
        // What noise explains is not far off.
        let trials = self.trials.filter(|_| !is_noise && !is_idle);
        let each = self.quantities.iter();
        let kept = each.map(|of| kept(self.scene, self.strayed, trials.is_some(), *of));
        let kept: Vec<KeptQuantity> = kept.collect();
        let mut looker = AskedLooker {
            asked: self,
            trials,
            observer,
        };
        let judgement = wrong::judge(of, told, &kept, self.strayed.apart_s(), &mut looker);
        let judgement = judgement.ok_or(FitUntold::Stopped)?;
        // A tracker's slow errors are as large as the scene says.
        let is_as_said = self.strayed == Strayed::Tracker && self.is_within_weights(of);
        let suspects = match is_as_said {
            true => Vec::new(),
            false => self.suspects(&judgement),
        };
        let fits = match () {
            () if !suspects.is_empty() || self.is_far => Fits::No,
            () if is_as_said => Fits::Yes,
            () if is_no_hand(of, told) => Fits::No,
            () => self
                .without_suspects(&alone)
                .max(match self.hides_joints(&judgement) {
                    true => Fits::Unknown,
                    false => Fits::Yes,
                }),
        };
        let each = self.quantities.iter().zip(&judgement.shows);
        let joints = each.clone().filter_map(|(quantity, shows)| {
            let is_place = matches!(quantity, Quantity::JointPlace { .. });
            is_place.then_some(*shows)
        });
        let noise = if is_noise { &alone.fitted } else { fitted };
        let fit = Fit {
            fits,
            joint: self.joint,
            noise: [0, 1].map(|kind| {
                3_f64.sqrt() * noise.errors.processes[kind].noise_sd * of.rows.unit(kind)
            }),
            by_noise: alone.test,
            is_noise,
            is_of_hand: self.strayed == Strayed::Hand,
            shown_m: joints.reduce(f64::max),
            untold: each
                .filter(|(_, shows)| shows.is_infinite())
                .map(|(quantity, _)| *quantity)
                .collect(),
        };
        Ok((fit, suspects))
    }

    /// What is left where nothing is suspected.
    fn without_suspects(&self, alone: &NoiseAlone) -> Fits {
        match self.strayed {
            Strayed::Hand | Strayed::MaybeHand => Fits::Yes,
            Strayed::NoHand | Strayed::Tracker if alone.explains() => Fits::Yes,
            Strayed::NoHand => Fits::Unknown,
            Strayed::Tracker => Fits::No,
        }
    }

    /// Whether residuals are not greater than the scene's weights say.
    fn is_within_weights(&self, of: &Restricted) -> bool {
        let mut kinds = (0..2).filter(|kind| of.rows.shows(*kind));
        kinds.all(|kind| self.joint[kind] <= 3_f64.sqrt() * of.rows.unit(kind))
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

    /// What is wrong.
    fn suspects(&self, judgement: &Judgement) -> Vec<Suspect> {
        let each = judgement.wrong.iter().map(|wrong| {
            let quantity = self.quantities[wrong.index];
            let [lower, upper] = self.scene.limits_of(quantity);
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

/// Whether errors are slow ones that are greater than any of a hand.
fn is_no_hand(of: &Restricted, fitted: &FittedErrors) -> bool {
    let strays = (0..2).filter(|kind| of.rows.shows(*kind));
    let strays = strays.map(|kind| fitted.errors.processes[kind].stray_variance().sqrt());
    strays.fold(0.0, f64::max) > FAR
}

/// The likeliest, and those that explain the performance as well. Of the components of one thing, the one that explains
/// best stands for all.
fn together(mut suspects: Vec<Suspect>) -> Vec<Suspect> {
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
