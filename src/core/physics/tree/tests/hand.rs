//! Trees that hang from a hand, against closed forms, other integrations and laws of mechanics.

use nalgebra::{DMatrix, UnitQuaternion, Vector3};

use super::examples::{GRAVITY, PIN, UNIVERSAL, bush, rod, rods, some_state};
use crate::math::differentiate::jacobian;
use crate::math::random::Random;
use crate::motion::held::{Curve, Knot};
use crate::physics::State;
use crate::physics::driven::Driven;
use crate::physics::tree::tableau::DORMAND_PRINCE;
use crate::physics::tree::{Carrier, Flow, Hand, JointKind, Snapshot, Tree, TreeState};

/// A place along a line and two turns one after the other, each as `[value, rate, acceleration]` of time.
struct Moves {
    place: fn(f64) -> [Vector3<f64>; 3],
    axes: [Vector3<f64>; 2],
    turns: fn(f64) -> [[f64; 3]; 2],
}

impl std::fmt::Debug for Moves {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Moves")
    }
}

impl Carrier for Moves {
    fn at(&self, time_s: f64) -> Driven {
        let [position_m, velocity_m_s, acceleration_m_s2] = (self.place)(time_s);
        let ([first, second], [outer, inner]) = (self.axes, (self.turns)(time_s));
        let turned = |axis: Vector3<f64>, by: f64| UnitQuaternion::from_scaled_axis(axis * by);
        let back = turned(second, inner[0]).inverse() * first;
        Driven {
            state: State {
                position_m,
                orientation: turned(first, outer[0]) * turned(second, inner[0]),
                velocity_m_s,
                angular_velocity_rad_s: back * outer[1] + second * inner[1],
            },
            acceleration_m_s2,
            angular_acceleration_rad_s2: back * outer[2]
                - second.cross(&back) * (inner[1] * outer[1])
                + second * inner[2],
        }
    }
}

pub const STILL: fn(f64) -> [[f64; 3]; 2] = |_| [[0.0; 3]; 2];
const HERE: fn(f64) -> [Vector3<f64>; 3] = |_| [Vector3::zeros(); 3];
const AXES: [Vector3<f64>; 2] = [Vector3::new(0.0, 0.0, 1.0), Vector3::new(0.6, 0.8, 0.0)];

pub fn hand(place: fn(f64) -> [Vector3<f64>; 3], turns: fn(f64) -> [[f64; 3]; 2]) -> Hand {
    Hand::new(Moves {
        place,
        axes: AXES,
        turns,
    })
}

/// Swung to and fro and turned about two axes.
pub fn swung() -> Hand {
    let place = |t: f64| {
        let (s, c) = (7.0 * t).sin_cos();
        let along = Vector3::new(0.2, -0.1, 0.3);
        let on = Vector3::new(1.0, 2.0, -0.5);
        [
            along * s + on * t,
            along * (7.0 * c) + on,
            along * (-49.0 * s),
        ]
    };
    hand(place, |t: f64| {
        let (s, c) = (5.0 * t).sin_cos();
        [
            [0.8 * s, 4.0 * c, -20.0 * s],
            [0.5 * c + t, 1.0 - 2.5 * s, -12.5 * c],
        ]
    })
}

fn at(state: TreeState, time_s: f64) -> TreeState {
    TreeState { time_s, ..state }
}

fn flown(tree: &Tree, gravity: &Vector3<f64>, from: &TreeState, for_s: f64) -> TreeState {
    let mut flow = Flow::new(tree, gravity, DORMAND_PRINCE);
    flow.begin(from, false);
    flow.reach(for_s, 5e-4);
    flow.state()
}

fn apart(tree: &Tree, a: &TreeState, b: &TreeState) -> f64 {
    let off = tree.minus(a, b);
    off.iter().fold(0.0, |most, x| most.max(x.abs()))
}

/// A hand at rest is the world; one that flies evenly leaves motions against it as they are, and one that falls takes
/// gravity away.
#[test]
fn hands_that_rest_fly_evenly_or_fall() {
    let tree = bush(false);
    let state = some_state(&tree, &mut Random::default(), 1.0, 3.0);
    let clamped = |gravity: &Vector3<f64>| flown(&tree, gravity, &state, 0.3);
    let in_hand = |place| {
        let tree = tree.clone().in_hand(hand(place, STILL));
        flown(&tree, &GRAVITY, &at(state.clone(), 0.4), 0.3)
    };
    let world = clamped(&GRAVITY);
    assert!(apart(&tree, &in_hand(HERE), &world) < 1e-12);
    assert!((in_hand(HERE).time_s - 0.7).abs() < 1e-15);
    let evenly = in_hand(|t| {
        let on = Vector3::new(3.0, -2.0, 5.0);
        [on * t, on, Vector3::zeros()]
    });
    assert!(apart(&tree, &evenly, &world) < 1e-10);
    let falls = in_hand(|t| [GRAVITY * (0.5 * t * t), GRAVITY * t, GRAVITY]);
    let weightless = clamped(&Vector3::zeros());
    assert!(apart(&tree, &falls, &weightless) < 1e-10);
    assert!(apart(&tree, &world, &weightless) > 0.1, "gravity counts");
}

/// Where the links are: as the hand carries those that hang from the world.
#[test]
fn links_are_carried() {
    let tree = bush(false);
    let state = at(some_state(&tree, &mut Random::default(), 1.0, 3.0), 0.37);
    let hung = tree.clone().in_hand(swung());
    let mut clamped = Snapshot::new(&tree, &GRAVITY);
    let mut carried = Snapshot::new(&hung, &GRAVITY);
    clamped.set(&state);
    carried.set(&state);
    let held = swung().0.at(0.37).state;
    for link in 0..tree.link_count() {
        let (own, moved) = (clamped.link_state(link), carried.link_state(link));
        let pose = held.world_from_body() * own.world_from_body();
        let spin = held.orientation * held.angular_velocity_rad_s;
        let place = held.orientation * own.position_m;
        let expected = State {
            position_m: pose.translation.vector,
            orientation: pose.rotation,
            velocity_m_s: held.velocity_m_s
                + spin.cross(&place)
                + held.orientation * own.velocity_m_s,
            angular_velocity_rad_s: own.angular_velocity_rad_s
                + own.orientation.inverse() * held.angular_velocity_rad_s,
        };
        assert!(moved.minus(&expected).norm() < 1e-12, "{link}");
    }
}

/// The scalar equation `θ̈ = f(t, θ)` by Runge's and Kutta's method.
fn scalar(f: impl Fn(f64, f64) -> f64, [mut angle, mut rate]: [f64; 2], for_s: f64) -> [f64; 2] {
    let steps = 20_000;
    let h = for_s / steps as f64;
    for step in 0..steps {
        let t = step as f64 * h;
        let (a1, v1) = (f(t, angle), rate);
        let (a2, v2) = (f(t + 0.5 * h, angle + 0.5 * h * v1), rate + 0.5 * h * a1);
        let (a3, v3) = (f(t + 0.5 * h, angle + 0.5 * h * v2), rate + 0.5 * h * a2);
        let (a4, v4) = (f(t + h, angle + h * v3), rate + h * a3);
        angle += h / 6.0 * (v1 + 2.0 * v2 + 2.0 * v3 + v4);
        rate += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
    }
    [angle, rate]
}

/// A rod on a pin in a hand that turns about the vertical with `ω`: with `J = I + m c²`,
/// `J θ̈ = −m g c sin θ + ω² (J − I₃) sin θ cos θ`; and one whose pin goes up and down.
#[test]
fn a_governor_and_a_driven_pendulum() {
    let gravity = Vector3::new(0.0, 0.0, -9.81);
    let tree = Tree::new(&rods(1, PIN, PIN)).unwrap();
    let body = rod(0.1, 0.3);
    let [across, _, along] = body.moments_kg_m2().into();
    let whole = across + 0.1 * 0.15 * 0.15;
    let weighs = 0.1 * 9.81 * 0.15;
    let turning = tree
        .clone()
        .in_hand(hand(HERE, |t| [[12.0 * t, 12.0, 0.0], [0.0; 3]]));
    let spread = 144.0 * (whole - along);
    let equation = |_: f64, a: f64| (-weighs * a.sin() + spread * a.sin() * a.cos()) / whole;
    let start = TreeState {
        coordinates: vec![0.4],
        rates: vec![-1.0],
        time_s: 0.1,
    };
    let end = flown(&turning, &gravity, &start, 1.5);
    let [angle, rate] = scalar(equation, [0.4, -1.0], 1.5);
    assert!((end.coordinates[0] - angle).abs() < 1e-9);
    assert!((end.rates[0] - rate).abs() < 1e-8);
    let balanced = (weighs / spread).acos();
    let still = TreeState {
        coordinates: vec![balanced],
        rates: vec![0.0],
        time_s: 0.3,
    };
    let stays = flown(&turning, &gravity, &still, 0.5);
    assert!(balanced > 0.5 && (stays.coordinates[0] - balanced).abs() < 1e-9);

    let shaken = tree.in_hand(hand(
        |t| {
            let (s, c) = (60.0 * t).sin_cos();
            let up = Vector3::z() * 0.02;
            [up * c, up * (-60.0 * s), up * (-3600.0 * c)]
        },
        STILL,
    ));
    let equation = |t: f64, a: f64| {
        let up = -72.0 * (60.0 * (t + 0.1)).cos();
        -0.1 * (9.81 + up) * 0.15 * a.sin() / whole
    };
    let end = flown(&shaken, &gravity, &start, 1.5);
    let [angle, rate] = scalar(equation, [0.4, -1.0], 1.5);
    assert!((end.coordinates[0] - angle).abs() < 1e-9);
    assert!((end.rates[0] - rate).abs() < 1e-8);
}

/// Force and moment by which the hand changes the momenta give, at its velocities, the power by which energy changes.
#[test]
fn energy_changes_by_the_power_of_the_hand() {
    let tree = Tree::new(&rods(3, JointKind::Ball, UNIVERSAL)).unwrap();
    let tree = tree.in_hand(swung());
    let start = at(some_state(&tree, &mut Random::default(), 1.0, 3.0), 0.2);
    let step_s = 1e-3;
    let told = |of_s: f64| {
        let mut snapshot = Snapshot::new(&tree, &GRAVITY);
        snapshot.set(&flown(&tree, &GRAVITY, &start, of_s));
        let (centre, momentum, spin) = snapshot.momentum();
        (
            snapshot.energy(0.0),
            centre,
            momentum,
            centre.cross(&momentum) + spin,
        )
    };
    for of_s in [0.05, 0.31] {
        // Differences of fourth order.
        let near: Vec<_> = [-2.0, -1.0, 1.0, 2.0]
            .map(|by| told(of_s + by * step_s))
            .to_vec();
        let weights = [1.0 / 12.0, -8.0 / 12.0, 8.0 / 12.0, -1.0 / 12.0].map(|w| w / step_s);
        let rate = |of: &dyn Fn(usize) -> Vector3<f64>| -> Vector3<f64> {
            (0..4).map(|at| of(at) * weights[at]).sum()
        };
        let power: f64 = (0..4).map(|at| near[at].0 * weights[at]).sum();
        let weight = GRAVITY * tree.mass_kg();
        let force = rate(&|at| near[at].2) - weight;
        let held = swung().0.at(0.2 + of_s).state;
        // The first joint is at the held body's centre.
        let moment =
            rate(&|at| near[at].3) - told(of_s).1.cross(&weight) - held.position_m.cross(&force);
        let spin = held.orientation * held.angular_velocity_rad_s;
        let given = force.dot(&held.velocity_m_s) + moment.dot(&spin);
        assert!(power.abs() > 0.5, "{power}");
        assert!(
            (power - given).abs() < 1e-7 * power.abs(),
            "{power} {given}"
        );
    }
}

/// Derivatives of the flow by the start's tangent and by time, and of links' states by the tangent.
#[test]
fn derivatives_are_those_of_differences() {
    let tree = bush(false).in_hand(swung());
    let start = at(some_state(&tree, &mut Random::default(), 0.8, 2.0), 0.1);
    let size = 2 * tree.freedoms();
    let end = |from: &TreeState, for_s: f64| {
        let mut flow = Flow::new(&tree, &GRAVITY, DORMAND_PRINCE);
        flow.begin(from, false);
        flow.reach(for_s, 4e-3);
        flow.state()
    };
    // Within a step, and at the end of one.
    for for_s in [0.0935, 0.096] {
        let here = end(&start, for_s);
        let numeric = jacobian(size, size, |by| {
            tree.minus(&end(&tree.retract(&start, by), for_s), &here)
        });
        let by_time = jacobian(size, 1, |by| tree.minus(&end(&start, for_s + by[0]), &here));
        let mut exact = Flow::new(&tree, &GRAVITY, DORMAND_PRINCE);
        exact.begin(&start, true);
        exact.reach(for_s, 4e-3);
        let mut by = DMatrix::zeros(size, size);
        exact.jacobian(&mut by);
        let rate = exact.rate();
        for row in 0..size {
            assert!((by_time[row][0] - rate[row]).abs() < 2e-5, "{row}");
            for column in 0..size {
                let off = (numeric[row][column] - by[(row, column)]).abs();
                assert!(off < 2e-6, "{row} {column}: {off}");
            }
        }
    }
    for link in 0..tree.link_count() {
        let seen = |state: &TreeState| {
            let mut snapshot = Snapshot::new(&tree, &GRAVITY);
            snapshot.set(state);
            snapshot.link_state(link)
        };
        let here = seen(&start);
        let numeric = jacobian(12, size, |by| {
            seen(&tree.retract(&start, by))
                .minus(&here)
                .as_slice()
                .to_vec()
        });
        let by_time = jacobian(12, 1, |by| {
            let later = seen(&at(start.clone(), start.time_s + by[0]));
            later.minus(&here).as_slice().to_vec()
        });
        let mut exact = DMatrix::zeros(12, size);
        let mut snapshot = Snapshot::new(&tree, &GRAVITY);
        snapshot.set(&start);
        let carried = snapshot.link_carried(link);
        for row in 0..12 {
            let off = (by_time[row][0] - carried[row]).abs();
            assert!(off < 1e-6, "{link} {row}: {off}");
        }
        snapshot.link_jacobian(link, &mut exact);
        for row in 0..12 {
            for column in 0..size {
                let off = (numeric[row][column] - exact[(row, column)]).abs();
                assert!(off < 1e-6, "{link} {row} {column}: {off}");
            }
        }
    }
}

/// The flow is the same in one go and in two, and back.
#[test]
fn flows_in_a_hand_make_no_difference_of_where_they_begin() {
    let tree = bush(false).in_hand(swung());
    let start = at(some_state(&tree, &mut Random::default(), 0.8, 2.0), 0.1);
    let whole = flown(&tree, &GRAVITY, &start, 0.3);
    let half = flown(&tree, &GRAVITY, &start, 0.17);
    let again = flown(&tree, &GRAVITY, &half, 0.13);
    assert!(apart(&tree, &whole, &again) < 1e-9);
    let back = flown(&tree, &GRAVITY, &whole, -0.3);
    assert!(apart(&tree, &back, &start) < 1e-9);
    let mut stepped = Flow::new(&tree, &GRAVITY, DORMAND_PRINCE);
    stepped.begin(&start, false);
    stepped.advance(0.17, 340);
    stepped.advance(0.13, 260);
    assert!(apart(&tree, &stepped.state(), &whole) < 1e-9);
    assert!(tree.at_rest().time_s.is_nan(), "a time must be given");
}

/// Where the hand's motion goes through knots, steps end there: halving them makes no difference to speak of, however
/// rough the motion is, forth and back.
#[test]
fn steps_end_where_the_motion_of_the_hand_is_not_smooth() {
    let mut random = Random::default();
    let knots = (0..60).map(|index| {
        let time_s = 0.008 * index as f64 + 0.002 * random.signed();
        let mut vector =
            |size: f64| Vector3::new(random.signed(), random.signed(), random.signed()) * size;
        let mut driven = swung().0.at(time_s);
        driven.state.position_m += vector(2e-6);
        driven.acceleration_m_s2 += vector(5.0);
        driven.angular_acceleration_rad_s2 += vector(30.0);
        Knot { time_s, driven }
    });
    let curve = Curve::new(knots.collect());
    let tree = Tree::new(&rods(2, JointKind::Ball, UNIVERSAL)).unwrap();
    let tree = tree.in_hand(Hand::new(curve));
    let start = at(some_state(&tree, &mut random, 0.5, 2.0), 0.0213);
    let reached = |from: &TreeState, for_s: f64, step_s: f64| {
        let mut flow = Flow::new(&tree, &GRAVITY, DORMAND_PRINCE);
        flow.begin(from, false);
        flow.reach(0.3 * for_s, step_s);
        flow.reach(for_s, step_s);
        flow.state()
    };
    let end = reached(&start, 0.4, 3e-3);
    let fine = reached(&start, 0.4, 7.5e-4);
    let off = [6e-3, 3e-3].map(|step_s| apart(&tree, &fine, &reached(&start, 0.4, step_s)));
    // Of order eight: a step through a knot has a lower one.
    assert!(off[1] < 1e-7 && off[0] > 60.0 * off[1], "{off:?}");
    let back = apart(&tree, &start, &reached(&end, -0.4, 3e-3));
    assert!(back < 1e-6, "{back}");
    let mut flow = Flow::new(&tree, &GRAVITY, DORMAND_PRINCE);
    flow.begin(&start, false);
    flow.advance(0.15, 40);
    flow.advance(0.25, 70);
    let stepped = apart(&tree, &flow.state(), &end);
    assert!(stepped < 1e-6, "{stepped}");
    let size = 2 * tree.freedoms();
    let mut exact = Flow::new(&tree, &GRAVITY, DORMAND_PRINCE);
    exact.begin(&start, true);
    exact.reach(0.1, 6e-3);
    let mut by = DMatrix::zeros(size, size);
    exact.jacobian(&mut by);
    let here = exact.state();
    let numeric = jacobian(size, size, |by| {
        let moved = reached(&tree.retract(&start, by), 0.1, 6e-3);
        tree.minus(&moved, &here)
    });
    for row in 0..size {
        for column in 0..size {
            let off = (numeric[row][column] - by[(row, column)]).abs();
            assert!(off < 1e-6, "{row} {column}: {off}");
        }
    }
}
