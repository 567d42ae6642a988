//! Derivatives of the whole problem against numeric ones, on a scene in which everything that
//! can be free is free; and bounds that act.

use nalgebra::{DVector, UnitQuaternion, Vector3};

use super::finish::Tolerances;
use super::layout::Layout;
use super::point::Point;
use super::problem::Problem;
use super::recipe::{self, Recipe};
use super::system::{Frame, Guidance, System};
use crate::math::{Pose, differentiate};
use crate::motion::{
    ArcGuess, BodySketch, Collision, Event, EventKind, Feature, FreeParameter, Goal, GoalTarget,
    Guess, Quantity, Sample, Scene, SceneBody, Segment, Sketch, Stamp, Surface, Timing,
    VelocityGaps, Weights,
};
use crate::physics::{Body, Shape, State, contact, flow};

const GRAVITY: Vector3<f64> = Vector3::new(0.0, 0.0, -9.8);

fn parameter(name: &str, quantity: Quantity, initial: f64, bounds: (f64, f64)) -> FreeParameter {
    FreeParameter {
        name: name.into(),
        quantity,
        initial,
        lower: bounds.0,
        upper: bounds.1,
        prior_sd: Some(0.3),
    }
}

/// A rod that bounces once, with every kind of goal and parameter.
fn scene(timing: Timing) -> Scene {
    let event = |name: &str, kind| Event {
        name: name.into(),
        kind,
    };
    let bounce = EventKind::Collision(Collision::bounce(0, 0, 0, 0.6));
    Scene {
        name: "rod".into(),
        gravity_m_s2: GRAVITY,
        timing,
        marks_topic: "/marks".into(),
        bodies: vec![SceneBody {
            name: "rod".into(),
            topic: "/rod".into(),
            body: Body::new(0.01, Vector3::new(3e-5, 3e-5, 1e-6)).unwrap(),
            shape: Shape::Sphere { radius_m: 0.1 },
            body_from_tracker: Pose::identity(),
            features: vec![Feature {
                name: "tip".into(),
                geometry: contact::Feature::corner(Vector3::new(0.0, 0.01, -0.1)),
            }],
        }],
        surfaces: vec![Surface {
            name: "table".into(),
            geometry: contact::Feature::face(
                Vector3::zeros(),
                Vector3::new(0.05, 0.1, 1.0).normalize(),
            ),
            obstacle: None,
        }],
        obstacles: Vec::new(),
        events: vec![event("bounce", bounce), event("landing", EventKind::End)],
        goals: vec![
            Goal {
                event: 1,
                body: 0,
                target: GoalTarget::Pose {
                    world_from_body: Pose::from_parts(
                        Vector3::new(0.3, 0.1, 0.2).into(),
                        UnitQuaternion::from_euler_angles(0.2, 0.4, -0.3),
                    ),
                },
            },
            Goal {
                event: 0,
                body: 0,
                target: GoalTarget::PositionWithin {
                    lower_m: Vector3::new(-1.0, f64::NEG_INFINITY, 0.0),
                    upper_m: Vector3::new(1.0, f64::INFINITY, 0.5),
                },
            },
        ],
        cones: Vec::new(),
        velocity_gaps: VelocityGaps::WhenNeeded,
        settle_s: None,
        parameters: vec![
            parameter("g", Quantity::Gravity { axis: 2 }, -9.7, (-11.0, -8.0)),
            parameter("e", Quantity::Restitution { event: 0 }, 0.55, (0.3, 0.9)),
            parameter(
                "t0",
                Quantity::Tilt {
                    event: 0,
                    tangent: 0,
                },
                0.03,
                (-0.1, 0.1),
            ),
            parameter(
                "t1",
                Quantity::Tilt {
                    event: 0,
                    tangent: 1,
                },
                -0.02,
                (-0.1, 0.1),
            ),
        ],
        weights: Weights {
            position_m: 0.01,
            orientation_rad: 0.1,
        },
    }
}

fn states() -> [State; 2] {
    [
        State {
            position_m: Vector3::new(0.02, 0.05, 0.3),
            orientation: UnitQuaternion::from_euler_angles(0.3, -0.2, 0.5),
            velocity_m_s: Vector3::new(0.5, -0.2, -1.0),
            angular_velocity_rad_s: Vector3::new(3.0, -2.0, 6.0),
        },
        State {
            position_m: Vector3::new(0.2, 0.0, 0.25),
            orientation: UnitQuaternion::from_euler_angles(1.3, 0.2, -0.5),
            velocity_m_s: Vector3::new(0.6, -0.1, 0.8),
            angular_velocity_rad_s: Vector3::new(-4.0, 5.0, 6.0),
        },
    ]
}

const EPOCHS_S: [f64; 2] = [0.1, 0.35];
const SAMPLES: usize = 9;

/// Samples of both arcs, off the flights by `offset`, and a guess at the flights.
fn sketch(scene: &Scene, offset: f64) -> (Sketch, Vec<Segment>, Guess) {
    let mut samples = Vec::new();
    let mut arcs = Vec::new();
    for (arc, state) in states().into_iter().enumerate() {
        let times_s: Vec<f64> = (0..SAMPLES)
            .map(|i| 0.25 * arc as f64 + 0.02 * i as f64 + 0.01)
            .collect();
        for time_s in &times_s {
            let body = &scene.bodies[0].body;
            let there = flow::advance(body, &GRAVITY, &state, time_s - EPOCHS_S[arc]);
            let wave = offset * (30.0 * time_s).sin();
            samples.push(Sample {
                stamp: Stamp((time_s * 1e9) as i64),
                acted_s: *time_s,
                position_m: there.position_m + Vector3::new(0.03, -0.02, 0.01) * wave,
                orientation: there.orientation
                    * UnitQuaternion::from_scaled_axis(Vector3::new(0.3, 0.2, -0.4) * wave),
            });
        }
        arcs.push(ArcGuess {
            epoch_s: EPOCHS_S[arc],
            state,
            sample_times_s: times_s,
        });
    }
    let segment = |samples, start_event, end_event| Segment {
        body: 0,
        start_event,
        end_event,
        samples,
    };
    (
        Sketch {
            origin: Stamp(0),
            bodies: vec![BodySketch { samples }],
            marks_s: vec![0.22, 0.45],
        },
        vec![
            segment(0..SAMPLES, None, Some(0)),
            segment(SAMPLES..2 * SAMPLES, Some(0), Some(1)),
        ],
        Guess {
            arcs,
            event_times_s: vec![0.22, 0.45],
        },
    )
}

/// A step of each unknown over which the problem is smooth.
fn lengths(layout: &Layout) -> Vec<f64> {
    let mut lengths = vec![0.1; layout.size()];
    layout
        .nodes
        .iter()
        .flatten()
        .for_each(|at| lengths[*at] = 0.003);
    layout.parameters.iter().for_each(|at| lengths[*at] = 0.05);
    lengths
}

/// Runs `check` on system, frame, point and step lengths for known and unknown times.
fn each_timing(offset: f64, check: impl Fn(&Frame, &Guidance, &Point, &[f64])) {
    for timing in [
        Timing::Known,
        Timing::Unknown {
            tempo_sd_per_sqrt_s: 0.5,
        },
    ] {
        let mut scene = scene(timing);
        if offset == 0.0 {
            scene
                .parameters
                .iter_mut()
                .for_each(|free| free.prior_sd = None);
            scene.parameters[0].initial = GRAVITY.z;
        }
        let (sketch, segments, guess) = sketch(&scene, offset);
        let problem = Problem::new(&scene, &sketch, &segments);
        let layout = Layout::new(&problem);
        let point = Point::new(&problem, &guess);
        let frame = Frame::new(&problem, &layout, EPOCHS_S.to_vec(), &point);
        check(&frame, &Guidance::none(&problem), &point, &lengths(&layout));
    }
}

/// The system at `point` moved by `d`, in units of `lengths`.
fn moved(frame: &Frame, guidance: &Guidance, point: &Point, lengths: &[f64], d: &[f64]) -> System {
    let delta = DVector::from_iterator(d.len(), d.iter().zip(lengths).map(|(d, l)| d * l));
    let mut there = point.clone();
    there.retract_from(point, frame.problem, frame.layout, &delta);
    let mut system = System::new(frame);
    system.evaluate(frame, guidance, &there);
    system
}

#[test]
fn the_gradient_of_the_objective_is_exact() {
    each_timing(1.0, |frame, guidance, point, lengths| {
        let size = frame.layout.size();
        let exact = moved(frame, guidance, point, lengths, &vec![0.0; size]).gradient;
        let numeric = differentiate::jacobian(1, size, |d| {
            vec![moved(frame, guidance, point, lengths, d).cost]
        });
        for at in 0..size {
            let expected = exact[at] * lengths[at];
            let error = (numeric[0][at] - expected).abs();
            assert!(
                error < 1e-7 * (1.0 + expected.abs()),
                "{at}: {} {expected}",
                numeric[0][at]
            );
        }
    });
}

#[test]
fn the_hessian_is_exact_where_nothing_remains() {
    each_timing(0.0, |frame, guidance, point, lengths| {
        let size = frame.layout.size();
        let system = moved(frame, guidance, point, lengths, &vec![0.0; size]);
        assert!(system.cost < 1e-20);
        let numeric = differentiate::jacobian(size, size, |d| {
            moved(frame, guidance, point, lengths, d)
                .gradient
                .as_slice()
                .to_vec()
        });
        for i in 0..size {
            for j in 0..=i {
                let expected = system.hessian.get(&frame.layout.pattern, i, j) * lengths[j];
                let error = (numeric[i][j] - expected).abs();
                assert!(
                    error < 2e-5 * (1.0 + expected.abs()),
                    "{i} {j}: {} {expected}",
                    numeric[i][j]
                );
            }
        }
    });
}

#[test]
fn the_constraints_derivatives_are_exact_and_within_their_columns() {
    each_timing(1.0, |frame, guidance, point, lengths| {
        let size = frame.layout.size();
        let system = moved(frame, guidance, point, lengths, &vec![0.0; size]);
        let numeric = differentiate::jacobian(system.row_count(), size, |d| {
            moved(frame, guidance, point, lengths, d).values().collect()
        });
        let mut offset = 0;
        for (block, columns) in system.blocks.iter().zip(&frame.layout.blocks) {
            let rows = block.values.len();
            assert_eq!(block.jacobian.len(), rows * columns.len());
            for row in 0..rows {
                for at in 0..size {
                    let expected = columns
                        .iter()
                        .position(|column| *column == at)
                        .map_or(0.0, |column| {
                            block.jacobian[column * rows + row] * lengths[at]
                        });
                    let error = (numeric[offset + row][at] - expected).abs();
                    assert!(
                        error < 1e-6 * (1.0 + expected.abs()),
                        "row {row}, unknown {at}"
                    );
                }
            }
            offset += rows;
        }
    });
}

#[test]
fn sample_times_keep_their_order_under_any_step() {
    each_timing(1.0, |frame, _, point, _| {
        for scale in [-1.0, 1.0, 30.0] {
            let delta = DVector::from_fn(frame.layout.size(), |at, _| scale * (at as f64).sin());
            let mut there = point.clone();
            there.retract_from(point, frame.problem, frame.layout, &delta);
            assert!(there.node_times_s.windows(2).all(|pair| pair[0] < pair[1]));
        }
    });
}

/// One flight whose gravity is free but bounded away from the truth.
#[test]
fn a_bound_acts_and_the_step_finds_it() {
    let mut scene = scene(Timing::Known);
    scene.events.clear();
    scene.goals.clear();
    scene.parameters = vec![parameter(
        "g",
        Quantity::Gravity { axis: 2 },
        -9.2,
        (-9.5, -9.0),
    )];
    scene.parameters[0].prior_sd = None;
    let (mut sketch, mut segments, mut guess) = sketch(&scene, 0.005);
    sketch.marks_s.clear();
    segments.truncate(1);
    segments[0].end_event = None;
    guess.arcs.truncate(1);
    guess.event_times_s.clear();
    let problem = Problem::new(&scene, &sketch, &segments);
    let layout = Layout::new(&problem);
    let solve = |problem: &Problem| {
        let recipe = Recipe {
            tolerances: Tolerances {
                decrease: 1e-12,
                ..Tolerances::default()
            },
            ..Recipe::default()
        };
        recipe::solve(problem, &layout, &guess, &recipe, &mut ())
    };
    let bounded = solve(&problem);
    assert!(bounded.finished.converged, "{:?}", bounded.finished);
    assert!((bounded.point.parameters[0] + 9.5).abs() < 1e-10);
    // The multiplier pulls outwards: without the bound gravity would go on.
    assert!(bounded.multipliers[0] < -1e-3, "{:?}", bounded.multipliers);
    let mut free = problem.clone();
    free.parameters[0].lower = -20.0;
    let free = solve(&free);
    assert!(free.finished.converged && (free.point.parameters[0] + 9.8).abs() < 0.1);
    assert!(free.system.cost < bounded.system.cost);
}
