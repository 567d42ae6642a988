//! What the stages cost, one thread, from the take as it was recorded.
//!
//! ```text
//! cargo bench -p enact-tools --bench estimate
//! cargo bench -p enact-tools --bench estimate -- cold
//! ```
//!
//! `cold` is the pipeline up to the estimate with nothing prepared, `warm` a preview that goes on
//! from the one before; the other groups are the parts of `cold`, and `after` what follows: the checks, and settling. The
//! performances are those of `tools/perform` with seed 1.

use enact::config::scene_from_toml;
use enact::motion::Sketch;
use enact_tools::beside::Beside;
use enact_tools::case::{Case, Posed, estimated};
use enact_tools::perform::{Acting, Style, bounces};

const SEED: u64 = 1;

fn main() {
    divan::main();
}

fn known(style: Style) -> Case {
    Case::pencil(style, &Acting::timing_known(), SEED)
}

fn unknown(style: Style) -> Case {
    Case::pencil(style, &Acting::default(), SEED)
}

/// A cube that bounces ten times.
fn cube() -> Case {
    let truth = bounces(10, SEED).expect("a motion with ten bounces");
    let acting = Acting {
        distortion: 0.25,
        ..Acting::timing_known()
    };
    Case::new(&truth, &acting, SEED)
}

/// The sketch with refined marks, as the pipeline leaves it, and the problem it poses.
fn posed(case: &Case) -> (Sketch, Posed) {
    let outcome = case
        .estimated(&mut ())
        .expect("there is something to estimate from");
    let posed = Posed::new(case.scene(), &outcome.sketch);
    (outcome.sketch, posed)
}

mod after {
    use enact::motion::{Estimate, Scene};
    use enact::settle::settle;
    use enact::verify::verify;

    use super::*;

    /// As long as a scene file would ask for [s].
    const SETTLE_S: f64 = 3.0;

    fn of(case: &Case) -> (Scene, Estimate) {
        let outcome = case.estimated(&mut ()).expect("an estimate");
        (case.scene().clone(), outcome.estimate)
    }

    #[divan::bench]
    fn verify_pencil_tip(bencher: divan::Bencher) {
        let (scene, estimate) = of(&known(Style::Tip));
        bencher.bench_local(|| verify(&scene, &estimate));
    }

    #[divan::bench]
    fn verify_pencil_eraser(bencher: divan::Bencher) {
        let (scene, estimate) = of(&known(Style::Eraser));
        bencher.bench_local(|| verify(&scene, &estimate));
    }

    #[divan::bench]
    fn verify_cube_ten_bounces(bencher: divan::Bencher) {
        let (scene, estimate) = of(&cube());
        bencher.bench_local(|| verify(&scene, &estimate));
    }

    #[divan::bench]
    fn verify_hat_and_box(bencher: divan::Bencher) {
        let case = Case::new(
            &enact_tools::perform::hat_box::truth(),
            &Acting::timing_known(),
            SEED,
        );
        let (scene, estimate) = of(&case);
        bencher.bench_local(|| verify(&scene, &estimate));
    }

    #[divan::bench]
    fn settle_pencil_tip(bencher: divan::Bencher) {
        let (scene, estimate) = of(&known(Style::Tip));
        bencher.bench_local(|| settle(&scene, &estimate, SETTLE_S));
    }
}

mod cold {
    use super::*;

    fn run(bencher: divan::Bencher, case: &Case) {
        let (scene, events) = (case.scene(), &case.performance.events);
        bencher.bench_local(|| estimated(scene, events, &mut ()));
    }

    #[divan::bench]
    fn pencil_tip_known(bencher: divan::Bencher) {
        run(bencher, &known(Style::Tip));
    }

    #[divan::bench]
    fn pencil_eraser_known(bencher: divan::Bencher) {
        run(bencher, &known(Style::Eraser));
    }

    #[divan::bench]
    fn pencil_tip_unknown(bencher: divan::Bencher) {
        run(bencher, &unknown(Style::Tip));
    }

    #[divan::bench]
    fn pencil_eraser_unknown(bencher: divan::Bencher) {
        run(bencher, &unknown(Style::Eraser));
    }

    #[divan::bench]
    fn cube_ten_bounces_known(bencher: divan::Bencher) {
        run(bencher, &cube());
    }

    /// To be held against the next: what a lamp adds that nothing ties to it.
    #[divan::bench]
    fn ball(bencher: divan::Bencher) {
        let of = Beside::of(SEED);
        let scene = scene_from_toml(&of.ball_toml("", "")).expect("a valid scene");
        let events = of.take_of_ball();
        bencher.bench_local(|| estimated(&scene, &events, &mut ()));
    }

    #[divan::bench]
    fn ball_beside_a_lamp(bencher: divan::Bencher) {
        let of = Beside::of(SEED);
        let (scene, events) = (of.scene(), of.take());
        bencher.bench_local(|| estimated(&scene, &events, &mut ()));
    }
}

/// The preview after eight samples more, from the one before: to be held against `cold`.
mod warm {
    use enact::motion::TakeEvent;
    use enact::pipeline::Preview;

    use super::*;

    /// Samples that have come since the preview before.
    const NEW: usize = 8;

    /// In the second flight, open at its end: the landing's mark has not come.
    fn run(bencher: divan::Bencher, case: &Case) {
        let mut events = case.performance.events.clone();
        let is_mark = |event: &TakeEvent| matches!(event, TakeEvent::Mark(_));
        let landing = events.iter().rposition(is_mark).expect("a mark");
        events.truncate(landing);
        let new = events.split_off(events.len() - NEW);
        let mut before = Preview::new(case.scene().clone());
        events.into_iter().for_each(|event| before.push(event));
        before.estimate(&mut ()).expect("an estimate");
        bencher
            .with_inputs(|| (before.clone(), new.clone()))
            .bench_local_values(|(mut preview, new)| {
                new.into_iter().for_each(|event| preview.push(event));
                let previewed = preview.estimate(&mut ()).expect("an estimate");
                assert!(previewed.is_some_and(|previewed| previewed.is_warm));
                preview
            });
    }

    #[divan::bench]
    fn pencil_tip_known(bencher: divan::Bencher) {
        run(bencher, &known(Style::Tip));
    }

    #[divan::bench]
    fn pencil_eraser_known(bencher: divan::Bencher) {
        run(bencher, &known(Style::Eraser));
    }

    #[divan::bench]
    fn pencil_tip_unknown(bencher: divan::Bencher) {
        run(bencher, &unknown(Style::Tip));
    }

    #[divan::bench]
    fn pencil_eraser_unknown(bencher: divan::Bencher) {
        run(bencher, &unknown(Style::Eraser));
    }
}

mod segment {
    use super::*;

    /// Marks only: the sketch is cleaned already.
    fn run(bencher: divan::Bencher, case: &Case) {
        let sketch = case.performance.sketch();
        bencher
            .with_inputs(|| sketch.clone())
            .bench_local_values(|mut sketch| {
                enact::segment::refine(case.scene(), &mut sketch);
                sketch
            });
    }

    #[divan::bench]
    fn refine_known(bencher: divan::Bencher) {
        run(bencher, &known(Style::Tip));
    }

    #[divan::bench]
    fn refine_unknown(bencher: divan::Bencher) {
        run(bencher, &unknown(Style::Tip));
    }

    #[divan::bench]
    fn refine_ten_bounces(bencher: divan::Bencher) {
        run(bencher, &cube());
    }
}

mod initialise {
    use super::*;

    fn run(bencher: divan::Bencher, case: &Case) {
        let (sketch, posed) = posed(case);
        bencher.bench_local(|| {
            enact::initialise::guess(case.scene(), &sketch, &posed.segments, &mut ())
        });
    }

    #[divan::bench]
    fn pencil_tip_known(bencher: divan::Bencher) {
        run(bencher, &known(Style::Tip));
    }

    #[divan::bench]
    fn pencil_tip_unknown(bencher: divan::Bencher) {
        run(bencher, &unknown(Style::Tip));
    }

    #[divan::bench]
    fn cube_ten_bounces_known(bencher: divan::Bencher) {
        run(bencher, &cube());
    }
}

/// One iteration of the finish at the guess: objective and constraints with all derivatives,
/// one factorisation, one step.
mod iteration {
    use enact::estimate::schedule::recipe::epochs_s;
    use enact::estimate::terms::context::{Guidance, SolveContext};
    use enact::estimate::unknowns::point::Point;
    use enact::optimise::Program;
    use enact::optimise::kkt::Kkt;

    use super::*;

    fn run(bencher: divan::Bencher, case: &Case) {
        let (_, posed) = posed(case);
        let (problem, guess) = (&posed.problem, &posed.guesses[0]);
        let point = Point::new(problem, guess);
        let context = SolveContext::new(problem, &posed.layout, epochs_s(guess), &point);
        let guidance = Guidance::none();
        let mut system = context.evaluated(&guidance, &point);
        let multipliers = vec![0.0; system.row_count()];
        bencher.bench_local(|| {
            context.evaluate(&guidance, &point, &mut system);
            let kkt = Kkt::new(&context, &system, &multipliers);
            kkt.map(|kkt| kkt.step(context.structure(), &system, None))
        });
    }

    #[divan::bench]
    fn pencil_tip_known(bencher: divan::Bencher) {
        run(bencher, &known(Style::Tip));
    }

    #[divan::bench]
    fn pencil_tip_unknown(bencher: divan::Bencher) {
        run(bencher, &unknown(Style::Tip));
    }

    #[divan::bench]
    fn cube_ten_bounces_known(bencher: divan::Bencher) {
        run(bencher, &cube());
    }
}

/// The solver alone, from the guess to the end of the finish: what the charts set beside the peers.
mod solve {
    use enact::estimate::schedule::recipe::{self, Recipe};
    use enact::estimate::unknowns::layout::Layout;

    use super::*;
    use enact_tools::perform::{die, hat_box};

    /// Scene by name.
    fn case(name: &str) -> Case {
        let of = |truth, acting: &Acting| Case::new(truth, acting, SEED);
        let timing_known = Acting::timing_known();
        let cube = |count| bounces(count, SEED).expect("a bouncing cube");
        match name {
            "tip" => known(Style::Tip),
            "eraser" => known(Style::Eraser),
            "tip_unknown" => unknown(Style::Tip),
            "eraser_unknown" => unknown(Style::Eraser),
            "cube_1" => of(&cube(1), &timing_known),
            "cube_2" => of(&cube(2), &timing_known),
            "cube_8" => of(&cube(8), &timing_known),
            "hat_box" => of(&hat_box::truth(), &timing_known),
            "die" => of(&die::reference(), &Acting::edited()),
            _ => unreachable!("no scene of that name"),
        }
    }

    #[divan::bench(args = [
        "tip", "eraser", "tip_unknown", "eraser_unknown", "cube_1", "cube_2", "cube_8", "hat_box", "die",
    ])]
    fn from_the_guess(bencher: divan::Bencher, name: &str) {
        let (_, mut posed) = posed(&case(name));
        // Whose flights are found to be bent: an exact motion there is not.
        if name == "die" {
            posed.problem = posed.problem.with_velocity_gaps();
            posed.layout = Layout::new(&posed.problem);
        }
        let recipe = Recipe::default();
        bencher.bench_local(|| {
            let guess = &posed.guesses[0];
            recipe::solve(&posed.problem, &posed.layout, guess, &recipe, &mut ())
        });
    }
}
