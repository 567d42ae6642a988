//! Which clearances are asked for as rounds go on.

use crate::estimate::problem::clearance::{ClearSolids, Clears};
use crate::motion::{About, Doubt, Penetration, Place};

/// A clearance that is kept already.
pub(in crate::estimate) struct KeptClearance<C> {
    pub(in crate::estimate) of: C,
    /// Whether it holds the motion.
    pub(in crate::estimate) is_held: bool,
    /// When its features are nearest now \[s\], where that is told.
    pub(in crate::estimate) least_s: Option<f64>,
}

/// The distances that are kept already: where they hold the motion, of the features that are nearest now, as asked anew, unless
/// these are at the same face and the others stay where they are.
pub(in crate::estimate) fn renewed<C: Clears>(
    all: impl Iterator<Item = KeptClearance<C>>,
    anew: impl Fn(&Penetration) -> Option<C>,
) -> Vec<C> {
    let mut kept: Vec<C> = Vec::new();
    for KeptClearance {
        mut of,
        is_held,
        least_s,
    } in all
    {
        if let Some(least_s) = least_s {
            of.solids_mut().around_s = least_s;
        }
        let solids = of.solids();
        let nearest = Penetration {
            link: solids.link,
            against: solids.against,
            time_s: solids.around_s,
            depth_m: f64::NAN,
            point_m: nalgebra::Vector3::zeros(),
        };
        let depth_m = solids.depth_m;
        let again = is_held.then(|| anew(&nearest)).flatten();
        let again = again.filter(|again| !again.solids().shares_face(of.solids()));
        let mut of = again.unwrap_or(of);
        of.solids_mut().depth_m = depth_m;
        let is_kept =
            |other: &C| other.is_beside(&of) && other.solids().touches == of.solids().touches;
        if !kept.iter().any(is_kept) {
            kept.push(of);
        }
    }
    kept
}

/// Clearances with another one. Of those of the same solids at about the same time stay those at the same face: where a box
/// comes down on a plate each of its corners must keep out. Beside another face they would ask for too much.
pub(in crate::estimate) fn with<C: Clears>(clearances: Vec<C>, mut of: C) -> Vec<C> {
    let (beside, mut all): (Vec<C>, Vec<C>) = clearances
        .into_iter()
        .partition(|other| other.is_beside(&of));
    let depth_m = beside.iter().map(|other| other.solids().depth_m);
    let depth_m = depth_m.fold(of.solids().depth_m, f64::max);
    let solids = of.solids();
    let stays = |other: &C| {
        let other = other.solids();
        other.shares_face(solids) && other.touches != solids.touches
    };
    all.extend(beside.into_iter().filter(stays));
    of.solids_mut().depth_m = depth_m;
    all.push(of);
    all
}

/// What is held out of something, and only just passes it, as a doubt that is only to be known: that of solids at about the
/// same time once.
pub(in crate::estimate) fn just_passed<'c, C: Clears + 'c>(
    held: impl Iterator<Item = &'c C>,
    tolerance_m: f64,
    least_s: impl Fn(&C) -> Option<f64>,
) -> Vec<Doubt> {
    let mut each: Vec<&C> = Vec::new();
    for of in held {
        if !each.iter().any(|other| other.is_beside(of)) {
            each.push(of);
        }
    }
    let doubts = each.into_iter().map(|of| {
        let ClearSolids {
            link,
            against,
            around_s,
            depth_m,
            ..
        } = *of.solids();
        Doubt {
            about: About::KeptOut,
            place: Place::Inside {
                link,
                against,
                time_s: least_s(of).unwrap_or(around_s),
            },
            value: depth_m,
            bound: tolerance_m,
        }
    });
    doubts.collect()
}
