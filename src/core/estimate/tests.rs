//! Compares derivatives of the whole problem with numeric ones, on a scene in which every quantity
//! that can be free is free; and tests active bounds.

use nalgebra::{DVector, Matrix6, UnitQuaternion, UnitVector3, Vector3};
use typed_index_collections::TiVec;

use crate::estimate::problem::Problem;
use crate::estimate::schedule::recipe::{self, Recipe};
use crate::estimate::terms::context::{Guidance, SolveContext};
use crate::estimate::unknowns::layout::Layout;
use crate::estimate::unknowns::point::Point;
use crate::math::{Pose, differentiate};
use crate::motion::{
    ArcGuess, Collision, Cone, ContactLaw, ContactLawIndex, Event, EventKind, Feature, FreeBody,
    FreeParameter, Goal, GoalTarget, Guess, LinkIndex, MarkTime, Partner, Performer, Quantity,
    Sample, Scene, Seen, Sees, Segment, Sketch, Stamp, Surface, Timing, Touching, Track,
    TrackIndex, TrackSketch, VelocityGaps, View, Weighing, Weights,
};
use crate::optimise::finish::Tolerances;
use crate::optimise::{Program, Schedule, System};
use crate::physics::{Body, Drag, Shape, State, contact, flow, impact};

mod approach;
mod clearance;
pub(super) mod conditions;
mod held;
mod laws;
mod sliding;
mod sticking;
mod waypoints;
pub(in crate::estimate) mod woven;

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

/// The law of the one bounce.
const LAW: ContactLawIndex = ContactLawIndex(0);

/// A rod that bounces once, with every kind of goal and parameter.
pub(super) fn scene(timing: Timing) -> Scene {
    let event = |name: &str, kind| {
        let mut event = Event::new(name, kind);
        event.time.is_free = Some(true);
        event
    };
    let bounce = EventKind::Collision(Collision::bounce(LinkIndex(0), 0, 0, LAW));
    let mut scene = Scene {
        name: "rod".into(),
        gravity_m_s2: GRAVITY,
        timing,
        mark_sd_s: None,
        marks_topic: "/marks".into(),
        links: TiVec::new(),
        mechanisms: TiVec::new(),
        tracks: TiVec::new(),
        surfaces: vec![Surface {
            name: "table".into(),
            geometry: contact::Feature::face(
                Vector3::zeros(),
                Vector3::new(0.05, 0.1, 1.0).normalize(),
            ),
            obstacle: None,
        }],
        obstacles: Vec::new(),
        phases: Vec::new(),
        contact_laws: TiVec::from(vec![ContactLaw::frictionless("bounce", 0.6)]),
        events: vec![event("bounce", bounce), event("landing", EventKind::End)],
        goals: vec![
            Goal {
                event: 1,
                link: LinkIndex(0),
                target: GoalTarget::Pose {
                    world_from_body: Pose::from_parts(
                        Vector3::new(0.3, 0.1, 0.2).into(),
                        UnitQuaternion::from_euler_angles(0.2, 0.4, -0.3),
                    ),
                },
            },
            Goal {
                event: 0,
                link: LinkIndex(0),
                target: GoalTarget::PositionWithin {
                    lower_m: Vector3::new(-1.0, f64::NEG_INFINITY, 0.0),
                    upper_m: Vector3::new(1.0, f64::INFINITY, 0.5),
                },
            },
        ],
        cones: Vec::new(),
        velocity_gaps: VelocityGaps::WhenNeeded,
        settle_s: None,
        rest_goals: Vec::new(),
        parameters: vec![
            parameter("g", Quantity::Gravity { axis: 2 }, -9.7, (-11.0, -8.0)),
            parameter("e", Quantity::Restitution { law: LAW }, 0.55, (0.3, 0.9)),
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
        performer: Performer::Nobody,
        tolerance_m: Scene::TOLERANCE_M,
    };
    scene.add(FreeBody {
        name: "rod".into(),
        topic: "/rod".into(),
        body: Body::new(0.01, Vector3::new(3e-5, 3e-5, 1e-6)).unwrap(),
        shape: Shape::Sphere { radius_m: 0.1 },
        body_from_tracker: Pose::identity(),
        features: vec![Feature {
            name: "tip".into(),
            geometry: contact::Feature::corner(Vector3::new(0.0, 0.01, -0.1)),
        }],
    });
    scene
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

pub(super) const EPOCHS_S: [f64; 2] = [0.1, 0.35];

/// The same rod hits a board that flies, on its face, whose normal may tilt within a cone.
fn meeting(timing: Timing, friction: f64) -> Scene {
    let mut scene = scene(timing);
    let face = contact::Feature::face(
        Vector3::new(0.01, 0.0, 0.02),
        Vector3::new(-0.1, 0.2, 1.0).normalize(),
    );
    scene.add(FreeBody {
        name: "board".into(),
        topic: "/board".into(),
        body: Body::new(0.02, Vector3::new(4e-5, 4e-5, 7e-5)).unwrap(),
        shape: scene.links[LinkIndex(0)].shape.clone(),
        body_from_tracker: scene.tracks[TrackIndex(0)].link_from_tracker,
        features: vec![Feature {
            name: "top".into(),
            geometry: face,
        }],
    });
    let bounce = Collision {
        partner: Partner::Link(LinkIndex(1)),
        ..Collision::bounce(LinkIndex(0), 0, 0, LAW)
    };
    scene.events[0].kind = EventKind::Collision(bounce);
    scene.contact_laws[LAW].friction = friction;
    scene.cones.push(Cone {
        parameters: [2, 3],
        limit: 0.1,
    });
    if friction > 0.0 {
        let free = parameter("f", Quantity::Friction { law: LAW }, friction, (0.0, 20.0));
        scene.parameters.push(free);
    }
    scene
}

/// The rod lands flat, on three points at once.
fn landing(timing: Timing) -> Scene {
    let mut scene = scene(timing);
    let point = |name: &str, x, y| Feature {
        name: name.into(),
        geometry: contact::Feature::corner(Vector3::new(x, y, -0.1)),
    };
    let features = [point("east", 0.05, 0.0), point("west", -0.05, 0.01)];
    scene.links[LinkIndex(0)].features.extend(features);
    let mut bounce = Collision::bounce(LinkIndex(0), 0, 0, LAW);
    bounce.contacts = (0..3)
        .map(|feature| Touching {
            feature: Some(feature),
            other: Some(0),
        })
        .collect();
    scene.events[0].kind = EventKind::Collision(bounce);
    scene
}

/// The scene with every quantity free that its estimation could change, away from what is given.
fn modelled(mut scene: Scene) -> Scene {
    let track = TrackIndex(0);
    scene.tracks[track].link_from_tracker = Pose::from_parts(
        Vector3::new(0.02, -0.03, 0.05).into(),
        UnitQuaternion::from_euler_angles(0.4, -0.7, 1.1),
    );
    let drag = Drag {
        linear_per_s: 0.3,
        quadratic_per_m: 0.2,
    };
    for link in &mut scene.links {
        link.body = link.body.with_drag(drag).unwrap();
    }
    let mut add = |quantity: Quantity, value: f64| {
        let name = format!("{quantity:?}");
        let [lower, upper] = quantity.limits();
        scene
            .parameters
            .push(parameter(&name, quantity, value, (lower, upper)));
    };
    for link in scene.links.keys() {
        for axis in 0..3 {
            add(Quantity::Force { link, axis }, 0.2 - 0.3 * axis as f64);
            add(Quantity::Centre { link, axis }, 0.004 * axis as f64 - 0.003);
        }
        add(Quantity::LinearDrag { link }, 0.4);
        add(Quantity::QuadraticDrag { link }, 0.15);
        add(Quantity::Moment { link, axis: 0 }, 1.2);
        add(Quantity::Moment { link, axis: 2 }, 0.9);
    }
    if scene.links.len() > 1 {
        add(Quantity::Mass { link: LinkIndex(1) }, 1.3);
    }
    for axis in 0..3 {
        let shift_m = 0.01 - 0.004 * axis as f64;
        add(Quantity::TrackerPosition { track, axis }, shift_m);
        add(
            Quantity::TrackerOrientation { track, axis },
            0.2 * axis as f64 - 0.1,
        );
    }
    if scene.timing == Timing::Known {
        add(Quantity::ClockRate { track }, 0.03);
        add(Quantity::ClockOffset { track }, -0.004);
        // Beside each other, and beside the events that end and begin flights.
        let open = [
            (0, 0.003),
            (1, 0.005),
            (SAMPLES - 1, -0.002),
            (SAMPLES, -0.006),
        ];
        for (sample, added_s) in open {
            add(Quantity::SampleTime { track, sample }, added_s);
        }
        add(Quantity::ContactDuration { event: 0 }, 0.03);
    }
    add(Quantity::SurfaceHeight { surface: 0 }, 0.003);
    add(
        Quantity::SurfaceTilt {
            surface: 0,
            tangent: 0,
        },
        0.05,
    );
    add(
        Quantity::SurfaceTilt {
            surface: 0,
            tangent: 1,
        },
        -0.04,
    );
    scene
}

const SAMPLES: usize = 9;

/// Samples of two arcs of every link, off the flights by `offset`, and a guess at the flights.
pub(super) fn sketch(scene: &Scene, offset: f64) -> (Sketch, Vec<Segment>, Guess) {
    let marks_s = vec![0.22, 0.45];
    let mut tracks = TiVec::new();
    let mut segments = Vec::new();
    let mut arcs = Vec::new();
    for track in scene.tracks.keys() {
        let link = scene.link_seen_by(track);
        if link.held.is_some() {
            tracks.push(held::track(1.0));
            continue;
        }
        let mut samples = Vec::new();
        for (arc, mut state) in states().into_iter().enumerate() {
            // The second body flies below the first and turns otherwise.
            let other = usize::from(track) as f64;
            state.position_m += Vector3::new(0.02, -0.03, -0.25) * other;
            state.velocity_m_s += Vector3::new(-0.3, 0.1, 0.4) * other;
            state.angular_velocity_rad_s += Vector3::new(-2.0, 1.0, 3.0) * other;
            let body = scene.body_between(link.mechanism, [arc.checked_sub(1), Some(arc)]);
            let times_s: Vec<f64> = (0..SAMPLES)
                .map(|i| EPOCHS_S[arc] + 0.02 * (i as f64 - 4.0) + 0.001 * (i % 3) as f64)
                .collect();
            for (i, time_s) in times_s.iter().enumerate() {
                let s = time_s - EPOCHS_S[arc];
                let there = flow::advance(&body, &GRAVITY, &state, s);
                let wave = offset * (1.7 * i as f64 + arc as f64 + other).sin();
                samples.push(Sample::of_pose(
                    Stamp((time_s * 1e9) as i64),
                    *time_s,
                    there.position_m + Vector3::new(0.03, -0.02, 0.01) * wave,
                    there.orientation
                        * UnitQuaternion::from_scaled_axis(Vector3::new(0.3, 0.2, -0.4) * wave),
                ));
            }
            segments.push(Segment {
                mechanism: link.mechanism,
                start_event: arc.checked_sub(1),
                end_event: Some(arc),
                views: vec![View {
                    track,
                    samples: SAMPLES * arc..SAMPLES * (arc + 1),
                }],
            });
            arcs.push(ArcGuess {
                epoch_s: EPOCHS_S[arc],
                state,
                sample_times_s: times_s,
            });
        }
        tracks.push(TrackSketch::new(samples));
    }
    // Segments come in order of their ends, and so do the guesses of their arcs.
    let order = |arc: usize| {
        if segments.len() == 2 {
            arc
        } else {
            [0, 2, 1, 3][arc]
        }
    };
    let segments = (0..segments.len())
        .map(|i| segments[order(i)].clone())
        .collect();
    let arcs = (0..arcs.len()).map(|i| arcs[order(i)].clone()).collect();
    let sketch = Sketch {
        origin: Stamp(0),
        tracks,
        contacts_s: Default::default(),
        cuts_sd_s: Default::default(),
        marks_s: marks_s.clone(),
        // What nothing remains of has marks that say nothing.
        marks: marks_s
            .iter()
            .map(|mark_s| mark(mark_s + 0.01 * offset).filter(|_| offset > 0.0))
            .collect(),
    };
    let guess = Guess {
        arcs,
        event_times_s: marks_s,
        parameters: scene.parameters.iter().map(|free| free.initial).collect(),
    };
    (sketch, segments, guess)
}

fn modelled_rod(timing: Timing) -> Scene {
    modelled(scene(timing))
}

/// Adds clocks of the tracks that [`see_in_parts`] makes, and samples of theirs whose times are not known.
fn clocked(mut scene: Scene) -> Scene {
    let mut add = |quantity: Quantity, value: f64| {
        let name = format!("{quantity:?}");
        let limits = quantity.limits().into();
        let free = parameter(&name, quantity, value, limits);
        scene.parameters.push(free);
    };
    for track in [0, 1, 2, 4, 5].map(TrackIndex) {
        add(Quantity::ClockOffset { track }, -0.004);
    }
    if scene.timing == Timing::Known {
        for track in [1, 2, 4].map(TrackIndex) {
            add(Quantity::ClockRate { track }, 0.03);
        }
    }
    // The order of such samples is told by their own times alone, which it is where nodes are fixed.
    let open: &[(usize, usize)] = match scene.timing {
        Timing::Unknown { .. } => &[],
        _ => &[(0, 3), (0, 4), (1, 12), (3, 2), (4, 5)],
    };
    for (track, sample) in open.iter().copied() {
        let track = TrackIndex(track);
        add(Quantity::SampleTime { track, sample }, 0.002);
    }
    scene
}

fn is_of_time(quantity: Quantity) -> bool {
    matches!(
        quantity,
        Quantity::ClockOffset { .. } | Quantity::ClockRate { .. } | Quantity::SampleTime { .. }
    )
}

/// Adds tracks to the one that sees the pose of the first link: a point, a direction, an orientation
/// with a weight of its own, and poses with covariances.
fn see_in_parts(
    scene: &mut Scene,
    sketch: &mut Sketch,
    segments: &mut [Segment],
    guess: &mut Guess,
) {
    let axis = UnitVector3::new_normalize(Vector3::new(0.3, -0.5, 0.8));
    let own = Weights {
        position_m: 0.004,
        orientation_rad: 0.03,
    };
    let kinds = [
        (Sees::Point, Weighing::Own(own)),
        (Sees::Direction(axis), Weighing::Scene),
        (Sees::Orientation, Weighing::Own(own)),
        (Sees::Pose, Weighing::Messages),
        (Sees::Point, Weighing::Messages),
    ];
    let poses = sketch.tracks[TrackIndex(0)].samples.clone();
    for (number, (sees, weighing)) in kinds.into_iter().enumerate() {
        let place_m = Vector3::new(0.03, -0.02, 0.05) * (1.0 + number as f64);
        let turn = UnitQuaternion::from_euler_angles(0.2, 0.1 * number as f64, -0.4);
        let track = scene.tracks.push_and_get_key(Track {
            name: format!("part {number}"),
            topic: format!("/part/{number}"),
            link: LinkIndex(0),
            link_from_tracker: Pose::from_parts(place_m.into(), turn),
            sees,
            weighing,
        });
        let samples = poses.iter().map(|sample| {
            let Seen::Pose {
                position_m,
                orientation,
            } = sample.seen
            else {
                unreachable!("the first track sees poses");
            };
            let seen = match sees {
                Sees::Pose => sample.seen,
                Sees::Point => Seen::Point(position_m + orientation * place_m),
                Sees::Orientation => Seen::Orientation(orientation),
                Sees::Direction(axis) => Seen::Direction(orientation * axis),
            };
            Sample { seen, ..*sample }
        });
        let mut of_track = TrackSketch::new(samples.collect());
        if weighing == Weighing::Messages {
            let factor = Matrix6::from_fn(|row, column| {
                let size = if row < 3 { 0.01 } else { 0.1 };
                size * (1.0 + (row * 7 + column * 3) as f64 % 5.0) / 6.0
            });
            let covariance = factor * factor.transpose() + Matrix6::identity() * 1e-4;
            of_track.covariances = vec![covariance; poses.len()];
        }
        sketch.tracks.push(of_track);
        for (segment, arc) in segments.iter_mut().zip(&mut guess.arcs) {
            let samples = segment.views[0].samples.clone();
            let own_s = arc.sample_times_s[..samples.len()].to_vec();
            arc.sample_times_s.extend(own_s);
            segment.views.push(View { track, samples });
        }
    }
    // What the first tracker's corrections mean for its own samples only.
    assert!(segments.iter().all(|segment| segment.views.len() == 6));
}

fn mark(acted_s: f64) -> Option<MarkTime> {
    Some(MarkTime {
        acted_s,
        sd_s: 0.02,
        counted: 1.0,
    })
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

/// Runs `check` on context, guidance, point and step lengths: for one body, for two that stick and
/// that slide, for several contacts at once, for what slides on; with known and unknown times, and at a sampling rate
/// at which samples share nodes.
pub(super) fn each_case(offset: f64, check: impl Fn(&SolveContext, &Guidance, &Point, &[f64])) {
    let timings = [
        Timing::Known,
        Timing::Unknown {
            tempo_sd_per_sqrt_s: 0.5,
        },
    ];
    let cases = timings.into_iter().flat_map(|timing| {
        let scenes = [
            scene(timing),
            meeting(timing, 0.0),
            meeting(timing, 0.05),
            meeting(timing, 9.0),
            laws::springing(timing),
            held::held(timing, 0.0),
            held::held(timing, 9.0),
            landing(timing),
            sliding::sliding(timing),
            sticking::sticking(timing),
        ];
        let paces: &[f64] = if timing == Timing::Known {
            &[1.0]
        } else {
            &[1.0, 0.1]
        };
        let at = |scene: Scene| paces.iter().map(move |pace| (scene.clone(), *pace));
        let modelled = [
            modelled(scene(timing)),
            laws::lifted(timing),
            modelled(laws::springing(timing)),
            modelled(meeting(timing, 9.0)),
            held::modelled_held(timing),
        ];
        let modelled = modelled.into_iter().map(|scene| (scene, 1.0));
        let whole = scenes.into_iter().flat_map(at).chain(modelled);
        let whole = whole.map(|(scene, pace)| (scene, pace, false));
        // A body of which several tracks see parts, with gravity free and known.
        let mut falling = scene(timing);
        falling.parameters.remove(0);
        let clocked = clocked(falling.clone());
        let parts = [scene(timing), modelled_rod(timing), falling, clocked];
        let parts = parts.into_iter().map(|scene| (scene, 1.0, true));
        whole.chain(parts).collect::<Vec<_>>()
    });
    for (mut scene, pace, is_in_parts) in cases {
        if offset == 0.0 {
            scene
                .parameters
                .iter_mut()
                .for_each(|free| free.prior_sd = None);
            let mut free = scene.parameters.iter_mut();
            if let Some(g) = free.find(|free| free.quantity == Quantity::Gravity { axis: 2 }) {
                g.initial = GRAVITY.z;
            }
            for index in 0..scene.parameters.len() {
                let quantity = scene.parameters[index].quantity;
                if index >= 4 || is_of_time(quantity) {
                    scene.parameters[index].initial = scene.value_of(quantity);
                }
            }
        }
        let (mut sketch, mut segments, mut guess) = sketch(&scene, offset);
        let samples = sketch.tracks.iter_mut().flat_map(|body| &mut body.samples);
        samples.for_each(|sample| sample.acted_s *= pace);
        if is_in_parts {
            see_in_parts(&mut scene, &mut sketch, &mut segments, &mut guess);
        }
        for track in sketch
            .tracks
            .iter_mut()
            .filter(|track| track.held.is_some())
        {
            *track = held::track(pace);
        }
        let mut problem = Problem::new(&scene, &sketch, &segments);
        let mut shares = problem.arcs.iter().flat_map(|arc| arc.samples());
        assert_eq!(shares.any(|sample| sample.share > 0.0), pace < 1.0);
        let mut point = Point::new(&problem, &guess);
        for state in &mut point.held {
            *state = held::moved_off(state, offset);
        }
        for velocity_gap_weight in [None, (offset > 0.0).then_some(0.3)] {
            problem.velocity_gap_weight = velocity_gap_weight;
            let layout = Layout::new(&problem);
            let context = SolveContext::new(&problem, &layout, recipe::epochs_s(&guess), &point);
            check(&context, &Guidance::none(), &point, &lengths(&layout));
        }
    }
}

/// The system at `point` moved by `d`, in units of `lengths`.
fn moved(
    context: &SolveContext,
    guidance: &Guidance,
    point: &Point,
    lengths: &[f64],
    d: &[f64],
) -> System {
    let delta = DVector::from_iterator(d.len(), d.iter().zip(lengths).map(|(d, l)| d * l));
    let mut there = point.clone();
    context.retract(point, &delta, &mut there);
    context.evaluated(guidance, &there)
}

#[test]
fn the_gradient_of_the_objective_is_exact() {
    each_case(1.0, |context, guidance, point, lengths| {
        let size = context.layout.size();
        let exact = moved(context, guidance, point, lengths, &vec![0.0; size]).gradient;
        let numeric = differentiate::jacobian(1, size, |d| {
            vec![moved(context, guidance, point, lengths, d).cost]
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
    each_case(0.0, |context, guidance, point, lengths| {
        let size = context.layout.size();
        let system = moved(context, guidance, point, lengths, &vec![0.0; size]);
        assert!(system.cost < 1e-20);
        let numeric = differentiate::jacobian(size, size, |d| {
            moved(context, guidance, point, lengths, d)
                .gradient
                .as_slice()
                .to_vec()
        });
        for i in 0..size {
            for j in 0..=i {
                let expected =
                    system.hessian.get(&context.layout.structure.pattern, i, j) * lengths[j];
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
    each_case(1.0, assert_exact_rows);
}

/// The derivatives of all hard rows at a point against differences.
fn assert_exact_rows(context: &SolveContext, guidance: &Guidance, point: &Point, lengths: &[f64]) {
    let size = context.layout.size();
    let system = moved(context, guidance, point, lengths, &vec![0.0; size]);
    let numeric = differentiate::jacobian(system.row_count(), size, |d| {
        moved(context, guidance, point, lengths, d)
            .values()
            .collect()
    });
    let mut offset = 0;
    for (block, pattern) in system.blocks.iter().zip(&context.layout.structure.blocks) {
        let rows = block.values.len();
        assert_eq!(rows, pattern.row_count());
        for row in 0..rows {
            let (unknowns, by) = (pattern.unknowns(row), block.derivatives(pattern, row));
            for at in 0..size {
                let column = unknowns.iter().position(|unknown| *unknown == at);
                let expected = column.map_or(0.0, |column| by[column] * lengths[at]);
                let error = (numeric[offset + row][at] - expected).abs();
                assert!(
                    error < 1e-6 * (1.0 + expected.abs()),
                    "row {row} of {rows} from {offset}, unknown {at}: {} {expected}",
                    numeric[offset + row][at]
                );
            }
        }
        offset += rows;
    }
}

#[test]
fn sample_times_keep_their_order_under_any_step() {
    each_case(1.0, |context, _, point, _| {
        for scale in [-1.0, 1.0, 30.0] {
            let delta = DVector::from_fn(context.layout.size(), |at, _| scale * (at as f64).sin());
            let mut there = point.clone();
            context.retract(point, &delta, &mut there);
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
    sketch.marks.clear();
    segments.truncate(1);
    segments[0].end_event = None;
    guess.arcs.truncate(1);
    guess.event_times_s.clear();
    let problem = Problem::new(&scene, &sketch, &segments);
    let layout = Layout::new(&problem);
    let solve = |problem: &Problem| {
        let schedule = Schedule {
            tolerances: Tolerances {
                decrease: 1e-12,
                ..Tolerances::default()
            },
            ..Schedule::default()
        };
        let recipe = Recipe::of(schedule);
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

#[test]
fn the_meetings_approach_and_one_slides_and_the_other_sticks() {
    for (friction, sticks) in [(0.05, false), (9.0, true)] {
        let scene = meeting(Timing::Known, friction);
        let (sketch, segments, guess) = sketch(&scene, 0.0);
        let problem = Problem::new(&scene, &sketch, &segments);
        let collision = &problem.collisions[0];
        let before = |side: usize| {
            let arc = collision.sides[side].before;
            let body = problem.body_of(arc);
            let duration_s = guess.event_times_s[0] - guess.arcs[arc].epoch_s;
            flow::advance(body, &GRAVITY, &guess.arcs[arc].state, duration_s)
        };
        let states = [before(0), before(1)];
        let side = |side: usize| {
            let body = problem.body_of(collision.sides[side].before);
            let state = &states[side];
            impact::Side { body, state }
        };
        let law = impact::Law {
            friction,
            tilt_rad: [0.03, -0.02],
            ..impact::Law::frictionless(0.55)
        };
        let impact = collision
            .contacts
            .impact(&side(0), Some(&side(1)), &law)
            .unwrap();
        assert!(impact.speeds_m_s[0] < -0.1, "{impact:?}");
        assert_eq!(impact.sticks, sticks, "{impact:?}");
    }
}
