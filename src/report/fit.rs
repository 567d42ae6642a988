//! The answer whether a motion fits, in words, and what it rests on.

use crate::motion::{Estimate, Fit, Fits, Scene};

/// The answer for people: whether a motion fits (`fits` as files have it), and whether that was told.
pub fn fit_words(fits: &str, is_tested: bool) -> &'static str {
    match fits {
        "yes" => "fits well",
        "no" => "does not fit",
        _ if is_tested => "off beyond the noise",
        _ => "fit not told",
    }
}

/// Why it is not told or not known whether a motion fits, what a wander hides where joined bodies are said to fit, and what tumbles;
/// none where the answer says it all.
pub(super) fn fit_note(scene: &Scene, estimate: &Estimate) -> Option<String> {
    let tumbles = estimate.grips.iter().filter_map(|grip| {
        let phase = &scene.phases[grip.phase];
        let lasts_s = grip.span_s[1] - grip.span_s[0];
        let body = &scene.links[phase.link].name;
        phase.tumbles().then(|| {
            format!("`{body}` tumbles for {lasts_s:.3} s: there it goes as it was seen, and nothing is explained")
        })
    });
    let notes: Vec<String> = answer_note(estimate).into_iter().chain(tumbles).collect();
    (!notes.is_empty()).then(|| notes.join("; "))
}

/// What the answer alone does not say.
fn answer_note(estimate: &Estimate) -> Option<String> {
    let fit = match &estimate.fit {
        // What failed or is too far says so by its doubts and its reason.
        _ if estimate.fits() == Fits::No => return None,
        Err(untold) => return Some(untold.sentence().to_owned()),
        Ok(fit) => fit,
    };
    let hides = hidden(fit).map_or(String::new(), |what| format!(", which hides {what}"));
    match fit.fits {
        Fits::Unknown if fit.is_noise => Some(format!("noise explains what is left{hides}")),
        Fits::Unknown => Some(format!(
            "more is left than noise; a wander of the hand may be the reason{hides}"
        )),
        Fits::Yes if !fit.is_noise => Some(format!("what is left is a wander of the hand{hides}")),
        _ => None,
    }
}

/// What of joints does not show.
fn hidden(fit: &Fit) -> Option<String> {
    let shown_m = fit.shown_m?;
    Some(match shown_m.is_finite() {
        true => format!("joints that are up to {:.0} mm elsewhere", 1e3 * shown_m),
        false => "wherever joints are".to_owned(),
    })
}

/// Names of what samples would tell nothing of, were it wrong.
pub(super) fn not_told(scene: &Scene, estimate: &Estimate) -> Vec<String> {
    let untold = estimate.fit.iter().flat_map(|fit| &fit.untold);
    untold.map(|of| scene.name_of_quantity(*of)).collect()
}
