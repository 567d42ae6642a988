//! The estimate is physical, meets its goals, and is the optimum that a start from the truth
//! finds; many more seeds and starts are the subject `answer` of `measure`.

use enact::motion::Verdict;
use enact_tools::case::Case;
use enact_tools::errors::{goal_gap, simulated_goal_gap};
use enact_tools::perform::{Acting, Style};
use enact_tools::starts::{is_best, optimum_from_truth};

/// Of goals, metres and radians.
const GAP: f64 = 1e-9;
/// Simulation from the first state carries rounding through a bounce.
const SIMULATED_GAP: f64 = 1e-8;

fn assert_right(style: Style, acting: &Acting, seeds: std::ops::Range<u64>) {
    for seed in seeds {
        let at = format!("{} {}× seed {seed}", style.as_str(), acting.distortion);
        let case = Case::pencil(style, acting, seed).one_by_one();
        let outcome = case.estimated(&mut ()).unwrap();
        let estimate = &outcome.estimate;
        assert_eq!(
            estimate.verdict,
            Verdict::Physical,
            "{at}: {:?}",
            estimate.reason
        );
        let (gap_m, gap_rad) = goal_gap(&case, estimate);
        assert!(
            gap_m < GAP && gap_rad < GAP,
            "{at}: {gap_m} m, {gap_rad} rad"
        );
        let (gap_m, gap_rad) = simulated_goal_gap(&case, estimate);
        assert!(
            gap_m < SIMULATED_GAP && gap_rad < SIMULATED_GAP,
            "{at}, simulated: {gap_m} m, {gap_rad} rad"
        );
        if let Some(known) = optimum_from_truth(&case, &outcome) {
            let objective = estimate.objective;
            assert!(
                is_best(objective, known.objective),
                "{at}: {objective} above {} from the {}",
                known.objective,
                known.start
            );
        }
    }
}

fn known(distortion: f64) -> Acting {
    Acting {
        distortion,
        ..Acting::timing_known()
    }
}

#[test]
fn tip_first_at_known_times() {
    assert_right(Style::Tip, &known(1.0), 0..10);
}

#[test]
fn eraser_first_at_known_times() {
    assert_right(Style::Eraser, &known(1.0), 0..10);
}

#[test]
fn tip_first_at_known_times_four_times_as_badly() {
    assert_right(Style::Tip, &known(4.0), 0..10);
}

#[test]
fn eraser_first_at_known_times_four_times_as_badly() {
    assert_right(Style::Eraser, &known(4.0), 0..10);
}

#[test]
fn both_at_an_unknown_tempo() {
    for style in Style::ALL {
        assert_right(style, &Acting::default(), 0..5);
    }
}
