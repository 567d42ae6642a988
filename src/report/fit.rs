//! What the answer whether joined bodies fit rests on, in words.

use crate::motion::{Estimate, Fits, Scene, Verdict, WholeFit};

/// Why it is not told or not known whether a motion of joined bodies fits, and what a wander hides where it is said to fit; none
/// where the answer says it all, and of bodies by themselves.
pub(super) fn fit_note(estimate: &Estimate) -> Option<String> {
    if estimate.trees.is_empty() || estimate.verdict == Verdict::Failed {
        return None;
    }
    let Some(fit) = &estimate.fit else {
        return Some("samples are too few to tell whether it fits".to_owned());
    };
    let whole = fit.whole.as_ref()?;
    match fit.fits {
        Fits::Unknown if whole.is_noise => Some(format!(
            "noise explains what is left, and hides {}",
            hidden(whole)
        )),
        Fits::Unknown => Some(format!(
            "more is left than noise; a wander of the hand may be the reason, and hides {}",
            hidden(whole)
        )),
        Fits::Yes if !whole.is_noise => Some(format!(
            "what is left is a wander of the hand, which hides {}",
            hidden(whole)
        )),
        _ => None,
    }
}

fn hidden(whole: &WholeFit) -> String {
    if whole.shown_m.is_finite() {
        format!(
            "joints that are up to {:.0} mm elsewhere",
            1e3 * whole.shown_m
        )
    } else {
        "wherever joints are".to_owned()
    }
}

/// Names of what samples would tell nothing of, were it wrong.
pub(super) fn not_told(scene: &Scene, estimate: &Estimate) -> Vec<String> {
    let whole = estimate.fit.as_ref().and_then(|fit| fit.whole.as_ref());
    let untold = whole.iter().flat_map(|whole| &whole.untold);
    untold.map(|of| scene.name_of_quantity(*of)).collect()
}
