//! Answers end by their work, wherever a take leads: on every machine at the same place.

use enact::motion::{Counted, Observer, WorkLimited};
use enact_tools::scenes::{Asked, DrawnScene};

/// Looks at samples of a whole answer at most: about ten seconds of a core.
const MOST: usize = 12_000_000;

/// Counts looks.
struct Looks(usize);

impl Observer for Looks {
    fn worked(&mut self, looks: usize) -> bool {
        self.0 += looks;
        false
    }
}

/// Whatever is thrown, by whatever hand, before whatever tracker: many of these show next to nothing of a motion.
#[test]
fn every_answer_ends_within_its_work() {
    let mut most = 0;
    for seed in 90_000..90_012 {
        for is_timing_known in [true, false] {
            let Some(scene) = DrawnScene::new(seed, is_timing_known) else {
                continue;
            };
            let mut looks = Looks(0);
            let outcome = scene.case(Asked::Position).pipeline().finish(&mut looks);
            assert!(outcome.is_ok(), "{seed} {is_timing_known}");
            assert!(
                looks.0 <= MOST,
                "{seed} {is_timing_known}: {} looks",
                looks.0
            );
            most = most.max(looks.0);
        }
    }
    // Some of them are long.
    assert!(most > 100_000, "{most}");
}

fn limited(observer: &mut dyn Observer, looks: usize, steps: usize) -> WorkLimited<'_> {
    WorkLimited {
        observer,
        looks,
        steps,
    }
}

#[test]
fn a_stage_ends_when_both_its_looks_and_its_steps_are_used_up() {
    let mut nobody = ();
    let mut few_looks = limited(&mut nobody, 25, 5);
    let taken = (0..).take_while(|_| !few_looks.worked(10)).count();
    assert_eq!((taken, few_looks.is_used_up()), (4, true));
    let mut nobody = ();
    let mut many_looks = limited(&mut nobody, 100, 5);
    let taken = (0..).take_while(|_| !many_looks.worked(10)).count();
    assert_eq!((taken, many_looks.should_stop()), (9, true));
}

#[test]
fn work_of_a_part_is_work_of_the_whole() {
    let mut nobody = ();
    let mut whole = limited(&mut nobody, 100, 0);
    let mut counted = Counted {
        observer: &mut whole,
        steps: 0,
        looks: 0,
    };
    let mut part = limited(&mut counted, 1000, 0);
    assert!(!part.worked(60) && !part.should_stop());
    assert!(part.worked(60) && part.should_stop());
    // It is not the part's own limit.
    assert!(!part.is_used_up());
    assert_eq!((counted.steps, counted.looks), (4, 120));
    assert!(whole.is_used_up());
}
