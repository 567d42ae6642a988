//! The methods that the charts compare with the program's: their derivatives are exact, and from a
//! sketch that is nearly the truth every one of them ends where the program does.

use enact::estimate::schedule::recipe::{self, Recipe};
use enact::estimate::terms::context::Guidance;
use enact::optimise::Program;
use enact::optimise::finish::Tolerances;
use enact::physics::Body;
use enact::physics::body::Symmetry;
use enact_tools::case::{Case, Posed};
use enact_tools::methods;
use enact_tools::methods::model::Model;
use enact_tools::methods::program::with_three_moments;
use enact_tools::methods::setting::Setting;
use enact_tools::methods::{Answer, Grid, Method, Task, stages};
use enact_tools::perform::{Acting, Style, bounces, die, flips, hat_box};
use nalgebra::DVector;

const GRIDS: [Grid; 5] = [
    Grid::Lifted,
    Grid::Implicit,
    Grid::Shooting { intervals: 1 },
    Grid::Shooting { intervals: 3 },
    Grid::Shooting { intervals: 5 },
];

fn posed(case: &Case) -> Posed {
    let outcome = case.estimated(&mut ()).expect("an estimate");
    case.posed_without_marks(&outcome).0
}

fn slightly(acting: Acting) -> Acting {
    Acting {
        distortion: 0.1,
        mark_error_s: 0.2 * acting.mark_error_s,
        ..acting
    }
}

fn scenes() -> Vec<(&'static str, Case)> {
    let known = slightly(Acting::timing_known());
    let unknown = slightly(Acting::default());
    let cube = |count| bounces(count, 3).expect("a bouncing cube");
    let scenes = vec![
        ("cube, 2", Case::new(&cube(2), &known, 3)),
        ("cube, 4", Case::new(&cube(4), &known, 3)),
        ("cube, 2, unknown", Case::new(&cube(2), &unknown, 3)),
        ("tip", Case::pencil(Style::Tip, &known, 3)),
        ("eraser, unknown", Case::pencil(Style::Eraser, &unknown, 3)),
        ("hat and box", Case::new(&hat_box::truth(), &known, 3)),
        (
            "die",
            Case::new(&die::reference(), &slightly(Acting::edited()), 3),
        ),
        (
            "flips",
            Case::new(&flips(1, 3).expect("a flipping brick"), &known, 3),
        ),
    ];
    let scenes = scenes.into_iter();
    scenes
        .map(|(name, case)| (name, case.one_by_one()))
        .collect()
}

/// Directions in which derivatives are compared with differences.
fn direction(size: usize, seed: usize) -> DVector<f64> {
    DVector::from_fn(size, |i, _| {
        ((i * 7919 + seed * 104_729) % 1000) as f64 / 500.0 - 1.0
    })
}

#[test]
fn derivatives_are_those_of_the_values() {
    for (name, case) in scenes() {
        let posed = posed(&case);
        for grid in GRIDS {
            let setting = Setting::new(&posed.problem, &posed.guesses[0], grid);
            let model = Model::new(&setting);
            let start = model.start();
            assert!(start.exists, "{name}, {grid:?}");
            let guidance = Guidance {
                event_times_s: setting.split.start.event_times_s.clone(),
                event_sd_s: (!posed.problem.times_are_unknown()).then_some(0.01),
                ..Guidance::none()
            };
            let at = model.evaluated(&guidance, &start);
            let mut system = at.clone();
            for seed in 0..3 {
                // A tenth of a millisecond, of a millimetre, …
                let scale = model.by_unknown(
                    |part| match part {
                        methods::parts::Part::Piece(_) => vec![1e-2; 12],
                        _ => vec![1e-4],
                    },
                    1e-2,
                );
                let along = direction(at.gradient.len(), seed).component_mul(&scale);
                let mut values = |step: f64| {
                    let place = model.moved(&start, &(&along * step));
                    model.evaluate(&guidance, &place, &mut system);
                    let rows: Vec<f64> = system.values().collect();
                    (system.cost, DVector::from_vec(rows))
                };
                let difference = |f: &mut dyn FnMut(f64) -> (f64, DVector<f64>), step: f64| {
                    let [(a, u), (b, v)] = [f(step), f(-step)];
                    let [(c, w), (d, x)] = [f(2.0 * step), f(-2.0 * step)];
                    let cost = (8.0 * (a - b) - (c - d)) / (12.0 * step);
                    (cost, ((u - v) * 8.0 - (w - x)) / (12.0 * step))
                };
                let exact = at.gradient.dot(&along);
                let size = at.gradient.component_mul(&along).norm() + exact.abs();
                // What one shot after many bounces does is far from linear but in the smallest.
                let steps = [4e-3, 4e-4, 4e-5].map(|step| difference(&mut values, step));
                let error = |difference: &(f64, DVector<f64>)| (difference.0 - exact).abs();
                let (cost, rows) = steps
                    .into_iter()
                    .min_by(|a, b| error(a).total_cmp(&error(b)))
                    .expect("some steps");
                assert!(
                    (cost - exact).abs() < 1e-6 * size + 1e-9 * at.cost,
                    "{name}, {grid:?}: {cost} for {exact}"
                );
                let mut change = Vec::new();
                at.along(model.structure(), &along, &mut change);
                for (row, (numeric, exact)) in rows.iter().zip(&change).enumerate() {
                    assert!(
                        (numeric - exact).abs() < 1e-6 * (1.0 + exact.abs()),
                        "{name}, {grid:?}, row {row}: {numeric} for {exact}"
                    );
                }
            }
        }
    }
}

#[test]
fn from_nearly_the_truth_all_methods_end_where_the_program_does() {
    for (name, case) in scenes() {
        let posed = posed(&case);
        let guess = &posed.guesses[0];
        let own = recipe::solve(
            &posed.problem,
            &posed.layout,
            guess,
            &Recipe::default(),
            &mut (),
        );
        assert!(own.finished.converged, "{name}");
        for grid in GRIDS {
            let setting = Setting::new(&posed.problem, guess, grid);
            let model = Model::new(&setting);
            let start = model.start();
            let end = stages::solve(&model, start, &Recipe::default());
            let judged = methods::judged(
                &posed.problem,
                &posed.layout,
                guess,
                &setting.whole(&end.place),
            );
            let off = judged.objective / (2.0 * own.system.cost) - 1.0;
            println!(
                "{name}, {grid:?}: {} {:e} {:e}, {} iterations for {}",
                end.converged, off, judged.violation, end.iterations, own.work.factorisations
            );
            // No motion meets what is asked of the die: its one shot goes astray.
            if name == "die" && grid == (Grid::Shooting { intervals: 1 }) {
                continue;
            }
            assert!(end.converged, "{name}, {grid:?}");
            assert!(off.abs() < 1e-7, "{name}, {grid:?}: {off:e}");
            assert!(
                judged.violation < 1e-6,
                "{name}, {grid:?}: {:e}",
                judged.violation
            );
        }
    }
}

/// The best of one bounce of a cube, by a method without any derivative and by another flow.
#[test]
fn sampling_and_the_general_flow_end_there_too() {
    let cube = bounces(1, 3).expect("a bouncing cube");
    let posed = posed(&Case::new(&cube, &slightly(Acting::timing_known()), 3));
    let task = Task {
        problem: posed.problem,
        layout: posed.layout,
        guesses: posed.guesses,
        best: None,
        seed: 3,
    };
    let answer = |method| -> Answer { task.answer(method, &Tolerances::default()) };
    let best = answer(Method::Program).judged.objective;
    for (method, near) in [(Method::Sampling(5_000), 1e-9), (Method::FullFlow, 1e-8)] {
        let other = answer(method);
        assert!(other.succeeds(best), "{other:?}");
        assert!(other.error(best) < near, "{other:?} for {best}");
    }
}

#[test]
fn nudged_bodies_have_three_moments() {
    for moments in [[1.0, 1.0, 1.0], [1.0, 1.0, 1.5], [0.01, 1.0, 1.0]] {
        let body = Body::new(1.0, moments.into()).expect("a body");
        let nudged = with_three_moments(&body);
        assert_eq!(nudged.symmetry(), Symmetry::Asymmetric);
        let change = (nudged.moments_kg_m2() - body.moments_kg_m2()).norm();
        assert!(change < 2e-13);
    }
}
