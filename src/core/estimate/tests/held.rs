//! The rod of these tests hits a board that somebody holds.

use nalgebra::{UnitQuaternion, Vector3};

use super::*;
use crate::motion::held::{Curve, Driven, Knot, Meeting, StateCovariance};
use crate::motion::{Grip, Held, HeldMotion, InHand, SupportPhase, SupportedBy};
use crate::physics::state::StateTangent;

/// The board of [`meeting`](super::meeting), held.
pub(super) fn held(timing: Timing, friction: f64) -> Scene {
    let mut scene = meeting(timing, friction);
    let board = &mut scene.links[LinkIndex(1)];
    board.body = Body::IMMOVABLE;
    board.held = Some(Held::default());
    scene.tracks[TrackIndex(1)].link_from_tracker = Pose::from_parts(
        Vector3::new(-0.03, 0.2, 0.04).into(),
        UnitQuaternion::from_euler_angles(0.2, 0.5, -0.3),
    );
    scene
}

/// The same with all quantities of its tracker free beside the rod's.
pub(super) fn modelled_held(timing: Timing) -> Scene {
    let mut scene = modelled(held(timing, 9.0));
    scene.links[LinkIndex(1)].body = Body::IMMOVABLE;
    scene.parameters.retain(|free| {
        let link = match free.quantity {
            Quantity::Force { link, .. }
            | Quantity::Centre { link, .. }
            | Quantity::LinearDrag { link }
            | Quantity::QuadraticDrag { link }
            | Quantity::Lift { link }
            | Quantity::Moment { link, .. }
            | Quantity::Mass { link } => link,
            _ => LinkIndex(0),
        };
        link == LinkIndex(0)
    });
    let track = TrackIndex(1);
    let mut add = |quantity: Quantity, value: f64| {
        let [lower, upper] = quantity.limits();
        let name = format!("{quantity:?}");
        let free = parameter(&name, quantity, value, (lower, upper));
        scene.parameters.push(free);
    };
    for axis in 0..3 {
        let size = 0.1 * axis as f64 - 0.07;
        add(Quantity::TrackerPosition { track, axis }, size);
        add(Quantity::TrackerOrientation { track, axis }, 2.0 * size);
    }
    if timing == Timing::Known {
        add(Quantity::ClockRate { track }, 0.05);
        add(Quantity::ClockOffset { track }, 0.006);
    }
    scene
}

/// How the board's tracker moves about the bounce, `acted` times as long as the rod's samples.
pub(super) fn track(pace: f64) -> TrackSketch {
    let knot = |time_s: f64, size: f64| Knot {
        time_s: time_s * pace,
        driven: Driven {
            state: State {
                position_m: Vector3::new(0.05, -0.02, 0.02) * size,
                orientation: UnitQuaternion::from_scaled_axis(Vector3::new(0.2, 0.3, -0.4) * size),
                velocity_m_s: Vector3::new(0.4, -0.3, 0.6) * size,
                angular_velocity_rad_s: Vector3::new(2.0, -1.0, 3.0) * size,
            },
            acceleration_m_s2: Vector3::new(3.0, 5.0, -4.0) * size,
            angular_acceleration_rad_s2: Vector3::new(-6.0, 7.0, 5.0) * size,
        }
        .at_rate(1.0 / pace),
    };
    let root = StateCovariance::from_fn(|row, column| {
        let sd = [0.03, 0.1, 0.5, 1.5][row / 3];
        let off = 0.2 * ((3 * row + 5 * column) as f64).sin();
        sd * if row == column {
            1.0
        } else {
            off * f64::from(u8::from(row > column))
        }
    });
    let meeting = Meeting {
        event: 0,
        acted_s: 0.22 * pace,
        covariance: root * root.transpose(),
        acceleration_sds: [1.0, 1.0],
    };
    TrackSketch {
        held: Some(HeldMotion {
            curve: Curve::new(vec![knot(0.05, 1.0), knot(0.45, -0.8)]),
            meetings: vec![meeting],
            noise_sd: [1e-3, 1e-3],
            counted: 0.7,
        }),
        ..TrackSketch::default()
    }
}

/// A state that is off the smoothed one.
pub(super) fn moved_off(state: &State, size: f64) -> State {
    state.retract(&StateTangent::from_fn(|row, _| {
        size * [0.02, 0.1, 0.3, 1.0][row / 3] * (1.0 + row as f64).sin()
    }))
}

#[test]
fn a_board_that_is_held_is_not_deflected() {
    let scene = held(Timing::Known, 0.05);
    let (sketch, segments, guess) = sketch(&scene, 0.0);
    let problem = Problem::new(&scene, &sketch, &segments);
    assert_eq!((problem.arcs.len(), problem.held.len()), (2, 1));
    let layout = Layout::new(&problem);
    let point = Point::new(&problem, &guess);
    let context = SolveContext::new(&problem, &layout, recipe::epochs_s(&guess), &point);
    // Contact, approach, and the rod's twelve.
    let system = context.evaluated(&Guidance::none(), &point);
    assert_eq!(system.blocks[0].values.len(), 2 + 12);
    // Unknowns: two flights, the board's state, two events, parameters.
    assert_eq!(layout.size(), 24 + 12 + 2 + scene.parameters.len());
    let state = problem.held[0].expected(&problem, &point);
    assert_eq!(state, point.held[0]);
}

const TEMPO: Timing = Timing::Unknown {
    tempo_sd_per_sqrt_s: 0.5,
};

/// A hand takes the rod at the bounce; what it lets go is the same the other way round.
#[test]
fn the_rows_and_the_gradient_where_a_hand_takes_a_body_are_exact() {
    for timing in [Timing::Known, TEMPO] {
        let mut scene = modelled_rod(timing);
        let link = LinkIndex(0);
        scene.events[0].kind = EventKind::Change(link);
        scene
            .parameters
            .retain(|free| free.quantity.event().is_none());
        scene.cones.clear();
        scene.phases.push(SupportPhase {
            name: "taken".into(),
            link,
            by: SupportedBy::Hand(InHand {
                tumbles: false,
                track: TrackIndex(0),
                link_from_tracker: scene.tracks[TrackIndex(0)].link_from_tracker,
            }),
            events: [0, 1],
        });
        let (mut sketch, segments, guess) = sketch(&scene, 0.01);
        let motion = track(1.0).held.expect("a motion");
        sketch.tracks[TrackIndex(0)].grips = vec![Grip { phase: 0, motion }];
        let mut problem = Problem::new(&scene, &sketch, &segments);
        assert_eq!((problem.held.len(), problem.changes.len()), (1, 1));
        let mut point = Point::new(&problem, &guess);
        point.held[0] = moved_off(&point.held[0], 0.7);
        for keeps_velocities in [false, true] {
            problem.changes[0].keeps_velocities = keeps_velocities;
            problem.changes[0].sides.reverse();
            let layout = Layout::new(&problem);
            let context = SolveContext::new(&problem, &layout, recipe::epochs_s(&guess), &point);
            let lengths = lengths(&layout);
            assert_exact_rows(&context, &Guidance::none(), &point, &lengths);
            let size = layout.size();
            let system = moved(
                &context,
                &Guidance::none(),
                &point,
                &lengths,
                &vec![0.0; size],
            );
            let numeric = differentiate::jacobian(1, size, |d| {
                vec![moved(&context, &Guidance::none(), &point, &lengths, d).cost]
            });
            for at in 0..size {
                let expected = system.gradient[at] * lengths[at];
                let off = (numeric[0][at] - expected).abs();
                assert!(off < 1e-7 * (1.0 + expected.abs()), "{at}: {off}");
            }
        }
    }
}
