//! Where methods fail: one performance of each kind of trouble. What must hold always: no panic,
//! no number that is not finite, and never the verdict `physical` where an independent look says
//! otherwise; and what is said must be what is stated here. The whole study, with a hundred
//! seeds of each and many starts, is the subject `stress` of `measure`.

use enact_tools::case::Case;
use enact_tools::perform::Style;
use enact_tools::starts::SAME;
use enact_tools::stress::{Finding, Judged, Timing, all, asked, judged};

/// What must hold whatever happens.
#[track_caller]
fn assert_honest(judged: &Judged, at: &str) {
    assert!(!judged.said.starts_with("panic"), "{at}: {}", judged.reason);
    assert!(!judged.has_nan, "{at}: not finite; says {}", judged.reason);
    if let Some(Finding::Disagrees(what)) = &judged.finding {
        panic!("{at}: says physical, but {what}");
    }
    assert!(!judged.said.is_empty(), "{at}: says nothing");
}

/// A trouble at seed 0.
#[track_caller]
fn made(theme: &str, name: &str, timing: Timing) -> Case {
    let at = format!("{theme}: {name}, {}", timing.as_str());
    let mut troubles = all().into_iter();
    let trouble = troubles
        .find(|t| t.theme == theme && t.name == name && t.timing == timing)
        .unwrap_or_else(|| panic!("no trouble {at}"));
    (trouble.make)(0).unwrap_or_else(|error| panic!("{at}: {error}"))
}

/// What the program says of it.
#[track_caller]
fn says(theme: &str, name: &str, timing: Timing) -> Judged {
    let judged = asked(&made(theme, name, timing));
    assert_honest(&judged, &format!("{theme}: {name}, {}", timing.as_str()));
    judged
}

#[track_caller]
fn assert_says(theme: &str, name: &str, timing: Timing, expected: &str) {
    let Judged { said, reason, .. } = says(theme, name, timing);
    assert!(
        said.starts_with(expected),
        "{theme}: {name}, {}: says {said:?} ({reason}), expected {expected:?}",
        timing.as_str()
    );
}

/// What it says of the tip-first pencil without any trouble.
fn untroubled(timing: Timing) -> Judged {
    asked(&Case::pencil(Style::Tip, &timing.acting(1.0), 0))
}

/// Rows that take longer than a test should: the study has them.
fn is_long(theme: &str, name: &str, timing: Timing) -> bool {
    let is_slow = timing == Timing::Unknown;
    let count = name.split(' ').next().and_then(|word| word.parse().ok());
    match theme {
        "bounces" => count.is_some_and(|count: usize| count > if is_slow { 2 } else { 8 }),
        "goals" => is_slow || name.contains("box"),
        "mass ratio" | "weights" | "units" | "spin" => is_slow,
        "nearly equal moments" => is_slow || !name.ends_with("1e-9"),
        "tempo" => name.contains("10 ×"),
        _ => false,
    }
}

#[test]
fn every_trouble_is_answered_honestly() {
    let mut count = 0;
    for trouble in all() {
        if is_long(trouble.theme, &trouble.name, trouble.timing) {
            continue;
        }
        let timing = trouble.timing.as_str();
        let at = format!("{}: {}, {timing}", trouble.theme, trouble.name);
        let case = (trouble.make)(1).unwrap_or_else(|error| panic!("{at}: {error}"));
        assert_honest(&asked(&case), &at);
        count += 1;
    }
    assert!(count > 100, "only {count} troubles");
}

#[test]
fn hard_motions_are_physical_at_known_times() {
    for (theme, name) in [
        ("bounces", "8 of a cube, 1×"),
        ("approach", "0.03 m/s against a wall"),
        ("restitution", "0 at a wall"),
        ("restitution", "1 at a wall"),
        ("inertia ratio", "1 : 1e-4"),
        ("nearly equal moments", "sphere, 1e-12"),
        ("spin", "0 rad/s about the pencil"),
        ("spin", "200 rad/s about the pencil"),
        ("drop", "vertical, no rotation"),
    ] {
        assert_says(theme, name, Timing::Known, "physical");
    }
}

#[test]
fn a_vertical_drop_is_physical_in_an_unknown_tempo() {
    assert_says("drop", "vertical, no rotation", Timing::Unknown, "physical");
}

#[test]
fn late_and_early_marks_change_nothing_within_reach() {
    for timing in Timing::ALL {
        let events_s = |case: &Case| -> Vec<f64> {
            let estimate = case.estimated(&mut ()).expect("an estimate").estimate;
            assert_eq!(estimate.verdict.as_str(), "physical");
            estimate.events.iter().map(|event| event.time_s).collect()
        };
        let right_s = events_s(&Case::pencil(Style::Tip, &timing.acting(1.0), 0));
        for samples in [-5, 5] {
            let name = format!("bounce {samples:+} samples");
            for (shifted_s, right_s) in events_s(&made("marks", &name, timing)).iter().zip(&right_s)
            {
                let moved_s = (shifted_s - right_s).abs();
                // Five samples are 42 ms.
                assert!(moved_s < 0.006, "{name}, {}: {moved_s} s", timing.as_str());
            }
        }
    }
}

#[test]
fn marks_that_make_no_sense_are_refused_with_the_reason() {
    for timing in Timing::ALL {
        let order = "refused: the mark of \"bounce #\" is at # s, expected after that of";
        assert_says("order", "marks named in reverse", timing, order);
    }
    let outside = "refused: the mark of \"bounce\" is at # s, outside the data";
    assert_says("marks", "bounce -50 samples", Timing::Known, outside);
}

#[test]
fn a_mark_too_many_or_too_few_changes_nothing_where_the_stream_is_clear() {
    let right = untroubled(Timing::Known).objective;
    for name in ["one missing", "one too many"] {
        let judged = says("marks", name, Timing::Known);
        assert_eq!(judged.said, "physical", "{name}");
        let objective = judged.objective;
        assert!(
            (objective / right - 1.0).abs() <= 0.25,
            "{name}: {objective}, expected about {right}"
        );
    }
}

#[test]
fn a_flight_almost_without_samples_is_not_called_what_it_is_not() {
    for name in ["350 ms in each flight", "500 ms in each flight"] {
        assert_honest(&says("dropouts", name, Timing::Known), name);
    }
}

#[test]
fn goals_that_cannot_hold_are_not_called_physical() {
    for (name, expected) in [
        ("two places at once", "failed: "),
        ("a bounce in mid-air", "failed: "),
        ("energy from nowhere, no velocity gaps", "failed: "),
        (
            "energy from nowhere, velocity gaps allowed",
            "plausible: velocities jump at bounce",
        ),
    ] {
        assert_says("goals", name, Timing::Known, expected);
    }
    // A motion through the table is not one that an independent look agrees with.
    let below = says("goals", "landing below the table", Timing::Known);
    assert_ne!(below.finding, Some(Finding::Agrees));
}

#[test]
fn the_optimum_does_not_depend_on_units_of_mass_or_on_the_size_of_both_weights() {
    let says = |theme: &str, name: &str| asked(&made(theme, name, Timing::Known).one_by_one());
    let right = asked(&Case::pencil(Style::Tip, &Timing::Known.acting(1.0), 0).one_by_one());
    let in_grams = says("units", "mass and moments × 1000");
    assert_eq!(in_grams.said, "physical");
    assert!((in_grams.objective / right.objective - 1.0).abs() <= SAME);
    for power in [-3, -1, 1, 3] {
        let scaled = says("weights", &format!("both × 1e{power}"));
        assert_eq!(scaled.said, "physical");
        let expected = right.objective * 100f64.powi(-power);
        assert!(
            (scaled.objective / expected - 1.0).abs() <= SAME,
            "1e{power}: {}, expected {expected}",
            scaled.objective
        );
    }
}

#[test]
fn units_that_are_wrong_by_a_thousand_show() {
    let right = untroubled(Timing::Known).objective;
    for name in ["positions in mm", "gravity in mm/s²"] {
        let judged = says("units", name, Timing::Known);
        // Where a motion with such gravity exists, it fits nothing.
        assert!(
            judged.said != "physical" || judged.objective > 100.0 * right,
            "{name}: {}, objective {}, usually {right}",
            judged.said,
            judged.objective
        );
    }
}

#[test]
fn a_spin_of_a_quarter_turn_per_sample_is_found() {
    let mut troubles = all().into_iter();
    let trouble = troubles
        .find(|t| t.name == "200 rad/s about the pencil" && t.timing == Timing::Known)
        .expect("a trouble");
    for seed in 0..3 {
        let case = (trouble.make)(seed).expect("a motion").one_by_one();
        let found = judged(&case, seed);
        let (objective, lowest) = (found.objective, found.lowest);
        assert!(found.is_best, "seed {seed}: {objective} above {lowest:?}");
    }
}

/// Wander of 2 cm and an approach of 3 cm/s: the samples alone would have the bounce before the first
/// of them, and the mark says that it was not.
#[test]
fn a_bounce_that_samples_put_before_all_of_them_is_where_its_mark_is() {
    let mut troubles = all().into_iter();
    let trouble = troubles
        .find(|t| t.name == "0.03 m/s against a wall" && t.timing == Timing::Known)
        .expect("a trouble");
    let mut case = (trouble.make)(95).expect("a motion");
    let judged = asked(&case);
    assert_honest(&judged, "approach, seed 95");
    assert_eq!(judged.said, "physical");
    case.performance.truth.scene.mark_sd_s = Some(10.0);
    let judged = asked(&case);
    assert_honest(&judged, "approach, seed 95, marks that say nothing");
    assert!(
        judged.said.starts_with("failed: ") || judged.said.starts_with("plausible: velocities"),
        "{}",
        judged.said
    );
}
