//! What the recipe's parts are for: performances at which each of them shows. They were found by
//! leaving the part out.

use enact::motion::Verdict;
use enact_tools::case::Case;
use enact_tools::perform::{Acting, Style, bounces};

fn at(distortion: f64, acting: Acting) -> Acting {
    Acting {
        distortion,
        ..acting
    }
}

/// Without a second try after a finish that does not converge these need velocity gaps.
#[test]
fn what_the_first_finish_does_not_meet_is_met_by_another() {
    for seed in [0, 1] {
        let cube = bounces(4, seed).expect("a bouncing cube");
        let case = Case::new(&cube, &at(4.0, Acting::default()), seed);
        let outcome = case.estimated(&mut ()).expect("an estimate");
        let estimate = &outcome.estimate;
        let why = &estimate.reason;
        assert_eq!(estimate.verdict, Verdict::Physical, "seed {seed}: {why:?}");
    }
}

/// Without a weight that rises where multipliers are slow these take three fifths more.
#[test]
fn strange_performances_take_hundreds_of_iterations_and_not_thousands() {
    let strange = [
        (Style::Eraser, Acting::timing_known(), 1),
        (Style::Eraser, Acting::default(), 0),
        (Style::Tip, Acting::default(), 0),
    ];
    let mut iterations = 0;
    for (style, acting, seed) in strange {
        let case = Case::pencil(style, &at(8.0, acting), seed);
        let outcome = case.estimated(&mut ()).expect("an estimate");
        assert_eq!(outcome.estimate.verdict, Verdict::Physical);
        iterations += outcome.estimate.counters.iterations;
    }
    assert!(iterations < 1000, "{iterations} iterations");
}
