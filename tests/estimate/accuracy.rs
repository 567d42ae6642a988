//! Exact performances are recovered exactly: to rounding where the stamps are physical times,
//! and where the tempo is unknown but constant, which is what its prior expects.

use enact::motion::Verdict;
use enact_tools::case::Case;
use enact_tools::errors::Errors;
use enact_tools::perform::{Acting, Style, Truth, bounces};

/// The truth through a perfect tracker. Its sampling interval is a whole number of nanoseconds,
/// for stamps are.
fn exact() -> Acting {
    Acting {
        rate_hz: 125.0,
        ..Acting::exact()
    }
}

fn exact_slowly() -> Acting {
    Acting {
        slowdown: 2.5,
        ..exact()
    }
}

fn motions() -> Vec<(&'static str, Truth)> {
    vec![
        ("tip", Style::Tip.truth()),
        ("eraser", Style::Eraser.truth()),
        (
            "three bounces",
            bounces(3, 1).expect("a motion with three bounces"),
        ),
    ]
}

/// Largest relative error of states and of estimated event times must not exceed `limit`.
fn assert_recovered(acting: &Acting, limit: f64) {
    for (name, mut truth) in motions() {
        // Marks are stamps, exact to a nanosecond, and the last is put at the last sample.
        truth.scene.mark_sd_s = Some(1e3);
        let case = Case::new(&truth, acting, 0);
        let outcome = case.estimated(&mut ()).unwrap();
        let estimate = &outcome.estimate;
        assert_eq!(
            estimate.verdict,
            Verdict::Physical,
            "{name}: {:?}",
            estimate.reason
        );
        let errors = Errors::of(&case, &outcome);
        assert!(errors.worst() <= limit, "{name}: {errors:?}");
        assert!(errors.sample_time <= limit, "{name}: {errors:?}");
    }
}

#[test]
fn exact_motions_at_known_times_come_back_to_nine_digits() {
    assert_recovered(&exact(), 1e-9);
}

#[test]
fn exact_motions_at_an_unknown_constant_tempo_come_back_to_six_digits() {
    assert_recovered(&exact_slowly(), 1e-6);
}

#[test]
fn a_tempo_that_varies_is_found_to_a_hundredth() {
    let acting = Acting {
        tempo_variation: 0.3,
        ..exact_slowly()
    };
    for style in Style::ALL {
        for seed in 0..3 {
            let case = Case::pencil(style, &acting, seed);
            let outcome = case.estimated(&mut ()).unwrap();
            assert_eq!(outcome.estimate.verdict, Verdict::Physical);
            let errors = Errors::of(&case, &outcome);
            // The clock ran at twice to half its mean; the prior still pulls it to a steady one.
            assert!(
                errors.event_time < 0.01,
                "{} {seed}: {errors:?}",
                style.as_str()
            );
            assert!(
                errors.sample_time < 0.02,
                "{} {seed}: {errors:?}",
                style.as_str()
            );
        }
    }
}
