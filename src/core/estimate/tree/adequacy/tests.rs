//! Changes by what a scene keeps fixed, and residuals with their derivatives, against other differences.

use nalgebra::{DVector, Vector3};

use super::candidates::{STEP, candidates, change};
use super::linear::Linear;
use crate::config::scene_from_toml;
use crate::estimate::tree::part::Part;
use crate::estimate::tree::point::TreePoint;
use crate::estimate::tree::problem::TreeProblem;
use crate::estimate::tree::program::TreeProgram;
use crate::math::differentiate;
use crate::math::random::Random;
use crate::motion::{MarkTime, Quantity, Sample, Scene, Seen, Sketch, Stamp, TrackSketch};
use crate::optimise::Program;
use crate::optimise::active::ActiveSet;

/// Two rods on universal joints; the second's end hits a table, and its tip is asked to be somewhere.
const SCENE: &str = r#"
name = "rods"

[timing]
stamps = "physical"

[weights]
position_mm = 10

[[surface]]
name = "table"
point_mm = [0, 0, -300]
normal = [0, 0, 1]

[[body]]
name = "upper"
shape = { kind = "cylinder", length_mm = 200, radius_mm = 5 }
mass_g = 100
tracked = false

[[body]]
name = "lower"
shape = { kind = "cylinder", length_mm = 200, radius_mm = 5 }
mass_g = 60
features_mm = { end = [0, 0, -100] }

[[body.track]]
sees = "point"
tracker = { position_mm = [0, 0, -80] }

[[joint]]
name = "nail"
kind = "pin"
axis = [1, 0, 0]
parent_at_mm = [0, 0, 100]
child = "upper"
child_at_mm = [0, 0, 100]

[[joint]]
name = "elbow"
kind = "universal"
axes = [[1, 0, 0], [0, 1, 0]]
parent = "upper"
parent_at_mm = [0, 0, -100]
child = "lower"
child_at_mm = [0, 0, 100]

[[event]]
name = "start"
kind = "start"

[[event]]
name = "hit"
kind = "collision"
body = "lower"
feature = "end"
surface = "table"
restitution = 0.5
friction = 0.1

[[event]]
name = "end"
kind = "end"

[[goal]]
event = "end"
body = "lower"
point_mm = [0, 0, -100]
position_mm = [100, 200, 300]
"#;

fn sketch(scene: &Scene) -> Sketch {
    let mut random = Random::default();
    let sample = |index: usize, at_m: Vector3<f64>| Sample {
        stamp: Stamp(index as i64 * 10_000_000),
        acted_s: 0.01 * index as f64,
        seen: Seen::Point(at_m),
    };
    let samples = (0..11).map(|index| sample(index, Vector3::from_fn(|_, _| random.signed())));
    let track = TrackSketch::new(samples.collect());
    let mark = |mark_s: f64| {
        Some(MarkTime {
            acted_s: mark_s,
            sd_s: 0.01,
            counted: 1.0,
        })
    };
    let marks_s = vec![0.0, 0.043, 0.1];
    Sketch {
        origin: Stamp(0),
        tracks: scene.tracks.iter().map(|_| track.clone()).collect(),
        contacts_s: Default::default(),
        cuts_sd_s: Default::default(),
        marks: marks_s.iter().map(|mark_s| mark(*mark_s)).collect(),
        marks_s,
    }
}

/// A motion of that scene that is no optimum, with the rows that act.
fn posed() -> (Scene, TreeProblem, TreePoint, ActiveSet) {
    let scene = scene_from_toml(SCENE).expect("a valid scene");
    let mut problem = TreeProblem::new(&scene, &sketch(&scene));
    problem.step_s = 0.01;
    let mut random = Random::default();
    let delta: Vec<f64> = (0..problem.width()).map(|_| random.signed()).collect();
    let state = problem.forest.retract(&problem.forest.at_rest(), &delta);
    let mut point = TreePoint::new(&problem, vec![state]);
    point.event_times_s[0] += 0.003;
    let program = TreeProgram::new(&problem, point.clone());
    let system = program.evaluated(&Part::whole(), &point);
    let active = ActiveSet::of(
        &system,
        &vec![0.0; system.row_count()],
        program.information().1,
    );
    (scene, problem, point, active)
}

/// Central differences by every quantity that may be suspected, against extrapolated ones.
#[test]
fn changes_by_quantities_are_those_of_extrapolated_differences() {
    let (scene, problem, point, active) = posed();
    let all = candidates(&scene, &problem);
    let is_there = |of: fn(&Quantity) -> bool| all.iter().any(of);
    assert!(is_there(|of| matches!(of, Quantity::JointPlace { .. })));
    assert!(is_there(|of| matches!(of, Quantity::JointTurn { .. })));
    assert!(is_there(|of| matches!(of, Quantity::Mass { .. })));
    assert!(is_there(|of| matches!(of, Quantity::Gravity { .. })));
    assert!(is_there(|of| matches!(of, Quantity::Restitution { .. })));
    assert!(is_there(|of| matches!(of, Quantity::Friction { .. })));
    assert!(is_there(|of| matches!(of, Quantity::SurfaceHeight { .. })));
    assert!(is_there(|of| matches!(
        of,
        Quantity::TrackerPosition { .. }
    )));
    let mut changed = 0;
    for quantity in all {
        let typical = quantity.typical();
        let value = scene.value_of(quantity);
        let given = change(
            &scene,
            &problem,
            &point,
            &active,
            quantity,
            value,
            STEP * typical,
        )
        .expect("a motion");
        let given: Vec<f64> = given.residuals.iter().chain(&given.rows).copied().collect();
        let at = |by: &[f64]| {
            let with = problem.with(&scene, &[(quantity, value + by[0] * typical)]);
            let linear = Linear::new(&with.expect("a scene"), &point, &active).expect("a motion");
            linear
                .residuals
                .iter()
                .chain(linear.rows())
                .copied()
                .collect()
        };
        let numeric = differentiate::jacobian(given.len(), 1, at);
        let size = given.iter().fold(0.0, |most: f64, of| most.max(of.abs())) * typical;
        changed += usize::from(size > 1e-6);
        for (row, given) in given.iter().enumerate() {
            let error = (numeric[row][0] - given * typical).abs();
            assert!(
                error < 1e-4 * (1e-3 + size),
                "{quantity:?} {row}: {error} of {size}"
            );
        }
    }
    assert!(changed > 20, "{changed}");
}

/// Residuals make up the cost, their derivatives are those of differences, and a step within what rows leave free, or
/// along with a quantity, leaves the rows as they are.
#[test]
fn a_linearised_motion_is_what_the_program_evaluates() {
    let (scene, problem, point, active) = posed();
    let linear = Linear::new(&problem, &point, &active).expect("a motion");
    let anchor = TreeProgram::new(&problem, point.clone());
    let system = anchor.evaluated(&Part::whole(), &point);
    let cost = 0.5 * linear.residuals.norm_squared();
    assert!((cost - system.cost).abs() < 1e-9 * system.cost);
    let held = linear.held();
    let moved = |step: &DVector<f64>| {
        let mut there = point.clone();
        point.retract(&problem, step, &mut there);
        Linear::new(&problem, &there, &active).expect("a motion")
    };
    for column in 0..held.basis.ncols() {
        let step = held.basis.column(column) * 1e-6;
        let [before, after] = [-1.0, 1.0].map(|sign| moved(&(&step * sign)));
        let change = Linear::change(&before, &after, 2e-6);
        let off = (change.residuals - held.free.column(column)).amax();
        assert!(off < 1e-4 * (1.0 + held.free.amax()), "{column}: {off}");
        assert!(change.rows.amax() < 1e-4, "{column}: {}", change.rows);
    }
    // Along with a quantity that moves the rows.
    let quantity = candidates(&scene, &problem)[2];
    let by = change(
        &scene,
        &problem,
        &point,
        &active,
        quantity,
        scene.value_of(quantity),
        1e-5,
    );
    let by = by.expect("a motion");
    assert!(by.rows.amax() > 1.0, "{}", by.rows);
    let share = 1e-5;
    let moved = |by_quantity: f64| {
        let value = scene.value_of(quantity) + by_quantity;
        let with = problem.with(&scene, &[(quantity, value)]).expect("a scene");
        let mut there = point.clone();
        point.retract(&problem, &(held.follow(&by) * by_quantity), &mut there);
        Linear::new(&with, &there, &active).expect("a motion")
    };
    let change = Linear::change(&moved(-share), &moved(share), 2.0 * share);
    assert!(
        change.rows.amax() < 1e-3 * by.rows.amax(),
        "{}",
        change.rows
    );
    let total = linear.total(&held, &by);
    let off = (change.residuals - &total).amax();
    assert!(off < 1e-3 * (1.0 + total.amax()), "{off}");
}
