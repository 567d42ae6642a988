//! Whether an answer is an explanation, and whether what it says instead is so.

use enact_tools::objects::scene::Trust;

use super::answer::Answer;
use super::facts::Facts;

/// A motion through the filter is no farther from the samples than this, in standard deviations.
const FILTERED: f64 = 1.0;
/// Without a filter to go through: the samples are no farther from the motion.
const UNFILTERED: f64 = 2.0;
/// Solids overlap, by the program's own bound \[mm\].
const DEPTH_MM: f64 = 1.0;
/// Energy after over before beyond which some is made.
const ENERGY: f64 = 1.0 + 1e-6;
/// Acceleration off gravity that no fall has [m/s²].
const OFF_M_S2: f64 = 2.5;
/// A flight of so many samples is one of keyframes to the program.
const FEW: usize = 6;
/// Residual in weights beyond which several motions fit, by the program's own bound.
const AMBIGUOUS: f64 = 8.0;

/// Residual of a flight in weights that is too far, by the program's own bound.
const FAR: f64 = 30.0;

/// What became of a question.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Judged {
    /// Physical, and nothing that is checked without the program speaks against it.
    Explained,
    /// Physical, and something speaks against it.
    Doubted,
    /// Not physical, and why is said.
    Named,
    /// Not physical, and nothing is said.
    Unnamed,
}

impl Judged {
    pub fn new(answer: &Answer, trust: &Trust) -> Self {
        match (answer.is_physical, against(answer, trust).is_empty()) {
            (true, true) => Self::Explained,
            (true, false) => Self::Doubted,
            (false, _) if answer.said.is_empty() => Self::Unnamed,
            (false, _) => Self::Named,
        }
    }

    pub fn as_str(self) -> &'static str {
        match self {
            Self::Explained => "explained",
            Self::Doubted => "physical, doubted here",
            Self::Named => "named",
            Self::Unnamed => "**not named**",
        }
    }
}

/// Whether a motion through the filter is near the samples \[mm\].
pub fn is_near(filtered_mm: f64, trust: &Trust) -> bool {
    filtered_mm <= FILTERED * trust.position_mm * 3.0_f64.sqrt()
}

/// What speaks against a motion without the program.
pub fn against(answer: &Answer, trust: &Trust) -> Vec<&'static str> {
    let Some(found) = &answer.checked else {
        return vec!["no motion"];
    };
    let far = match found.filtered_mm {
        Some(filtered_mm) => !is_near(filtered_mm, trust),
        None => found.residual.0 > UNFILTERED * trust.position_mm * 3.0_f64.sqrt(),
    };
    let turned = found.residual.1 > UNFILTERED * trust.orientation_deg * 3.0_f64.sqrt();
    let all = [
        (far, "positions"),
        (turned, "orientations"),
        (
            found.depth_mm.is_some_and(|depth| depth > DEPTH_MM),
            "table",
        ),
        (
            found.energy_ratio.is_some_and(|ratio| ratio > ENERGY),
            "energy",
        ),
    ];
    all.into_iter()
        .filter(|(is, _)| *is)
        .map(|(_, what)| what)
        .collect()
}

/// What is said, each with whether it is so: `✓` where the samples or a check of its own show it, `?`
/// where they do not tell, `✗` where they show that it is not.
pub fn said(answer: &Answer, facts: &Facts, trust: &Trust, off_m_s2: f64) -> String {
    let told = answer.said.iter().map(|word| {
        let mark = match is_so(word, answer, facts, (trust, off_m_s2)) {
            Some(true) => " ✓",
            Some(false) => " ✗",
            None => " ?",
        };
        format!("{word}{mark}")
    });
    told.collect::<Vec<_>>().join(", ")
}

/// Whether something that is said is so; `None` where that is not seen.
pub fn is_so(
    word: &str,
    answer: &Answer,
    facts: &Facts,
    (trust, off_m_s2): (&Trust, f64),
) -> Option<bool> {
    let found = answer.checked.as_ref();
    match word {
        "fall" | "fall direction" => Some(off_m_s2 > OFF_M_S2),
        "rivals" | "keyframes" => {
            let samples = [facts.first, facts.second].map(|[first, last]| last + 1 - first);
            Some(samples.into_iter().min() <= Some(FEW))
        }
        "overlap" => found.and_then(|found| Some(found.depth_mm? > DEPTH_MM)),
        "ambiguity" => found.map(|found| {
            let (position, turn) = found.residual;
            (position / trust.position_mm).max(turn / trust.orientation_deg) > AMBIGUOUS
        }),
        "residual" => found.and_then(|found| {
            let (position, turn) = found.residual;
            let far = (position / trust.position_mm).max(turn / trust.orientation_deg) > FAR;
            // One flight may be far where both together are not.
            far.then_some(true)
        }),
        // One impact does not do what two do.
        "velocities jump" => (!facts.second_is_seen).then_some(true),
        _ => None,
    }
}
