//! The hat and the box obey physics, meet their goals and touch nothing but what they should;
//! the bent scene and the die ask for more than physics can do.

use std::f64::consts::TAU;

use enact::math::{Pose, so3};
use enact::motion::{GoalTarget, LinkIndex, Quantity, Scene};
use enact::physics::contact::Feature::Point;
use enact::physics::impact::{Law, Side};
use enact::physics::{State, flow};
use enact_tools::perform::encounter::{Encounter, still};
use enact_tools::perform::truth::Flight;
use enact_tools::perform::{Truth, die, flips, hat_box, simulate};
use nalgebra::{Point3, Vector3};

const HAT: LinkIndex = LinkIndex(0);
const BOX: LinkIndex = LinkIndex(1);

fn advance(truth: &Truth, link: LinkIndex, state: &State, duration_s: f64) -> State {
    let body = &truth.scene.links[link].body;
    flow::advance(body, &truth.scene.gravity_m_s2, state, duration_s)
}

/// A link's states just before and just after an event that concerns it.
fn around(truth: &Truth, link: LinkIndex, event: usize) -> (State, State) {
    let time_s = truth.event_times_s[event];
    let mechanism = truth.scene.mechanism_of(link);
    let mut arcs = truth.arcs.iter().filter(|arc| arc.mechanism == mechanism);
    let ended = arcs.find(|arc| arc.end_s == time_s).unwrap();
    let begun = arcs.next().unwrap();
    assert_eq!(begun.start_s, time_s);
    (
        advance(truth, link, &ended.state, ended.end_s - ended.epoch_s),
        begun.state,
    )
}

/// Kinetic energy [J], momentum [N s] and angular momentum about the origin [N m s].
fn balance(truth: &Truth, link: LinkIndex, state: &State) -> (f64, Vector3<f64>, Vector3<f64>) {
    let body = &truth.scene.links[link].body;
    let omega = state.angular_velocity_rad_s;
    let spin = body.moments_kg_m2().component_mul(&omega);
    let momentum = state.velocity_m_s * body.mass_kg();
    (
        0.5 * momentum.dot(&state.velocity_m_s) + 0.5 * spin.dot(&omega),
        momentum,
        state.orientation * spin + state.position_m.cross(&momentum),
    )
}

fn moments(truth: &Truth) -> impl Iterator<Item = f64> {
    let duration_s = truth.duration_s;
    let steps = (duration_s / 5e-4) as usize;
    (0..=steps).map(move |step| duration_s * step as f64 / steps as f64)
}

fn corners(scene: &Scene, link: LinkIndex) -> Vec<Point3<f64>> {
    let features = scene.links[link].features.iter();
    let corners = features.filter_map(|feature| match feature.geometry {
        Point { point_m, .. } => Some(point_m.into()),
        _ => None,
    });
    corners.collect()
}

fn value(truth: &Truth, wanted: impl Fn(Quantity) -> bool) -> f64 {
    let parameters = truth.scene.parameters.iter().zip(&truth.parameters);
    let mut found = parameters.filter(|(parameter, _)| wanted(parameter.quantity));
    *found.next().unwrap().1
}

#[test]
fn the_hat_and_the_box_end_where_they_should() {
    let truth = hat_box::truth();
    let equalities = truth
        .scene
        .goals
        .iter()
        .filter(|goal| matches!(goal.target, GoalTarget::Pose { .. }));
    assert_eq!((equalities.count(), truth.scene.goals.len()), (2, 3));
    assert!(truth.goal_miss() < 1e-12, "{}", truth.goal_miss());
    let initial = [HAT, BOX].map(|link| truth.state(link, 0.0));
    let again = simulate(&truth.scene, &truth.parameters, &initial, truth.duration_s);
    assert_eq!(again.unwrap(), truth);
    let mechanism = |link| truth.scene.mechanism_of(link);
    let arcs = |link| {
        truth
            .arcs
            .iter()
            .filter(move |arc| arc.mechanism == mechanism(link))
    };
    assert_eq!((arcs(HAT).count(), arcs(BOX).count()), (2, 3));
    for arc in &truth.arcs {
        assert!((0.25..0.6).contains(&(arc.end_s - arc.start_s)));
        assert!(arc.state.velocity_m_s.norm() < 5.0);
        assert!(arc.state.angular_velocity_rad_s.norm() < 8.0);
    }
}

#[test]
fn every_parameter_is_within_its_bounds_and_none_is_what_the_scene_begins_with() {
    let truth = hat_box::truth();
    for (parameter, value) in truth.scene.parameters.iter().zip(&truth.parameters) {
        assert!(
            (parameter.lower..=parameter.upper).contains(value),
            "{}",
            parameter.name
        );
        assert!((value - parameter.initial).abs() > 0.005);
    }
    let [cone] = truth.scene.cones[..] else {
        panic!("one cone");
    };
    let tilt_rad = cone.parameters.map(|p| truth.parameters[p]);
    let tilt_rad = tilt_rad[0].hypot(tilt_rad[1]);
    assert!((cone.limit.to_degrees() - 6.0).abs() < 1e-12);
    assert!((3.0..4.0).contains(&tilt_rad.to_degrees()));
    let meeting = Encounter::of(&truth.scene, &truth.parameters, 1).unwrap();
    let angle_rad = meeting.push_normal.angle(&meeting.face_normal);
    assert!((angle_rad - tilt_rad).abs() < 1e-12);
}

#[test]
fn the_meeting_keeps_momentum_and_loses_the_energy_it_should() {
    let truth = hat_box::truth();
    for (event, links) in [(0, vec![BOX]), (1, vec![BOX, HAT])] {
        let encounter = Encounter::of(&truth.scene, &truth.parameters, event).unwrap();
        let law = truth.scene.events[event].kind.collision().unwrap().law;
        let pairs: Vec<(State, State)> = links
            .iter()
            .map(|link| around(&truth, *link, event))
            .collect();
        let other = pairs.get(1).copied().unwrap_or((still(), still()));
        let (before, after) = ((pairs[0].0, other.0), (pairs[0].1, other.1));
        assert!(encounter.gap_m(&before.0, &before.1).abs() < 1e-15);
        for (before, after) in &pairs {
            assert!((after.position_m - before.position_m).norm() < 1e-13);
            assert!(before.orientation.angle_to(&after.orientation) < 1e-13);
        }
        let speed = encounter.speed_m_s(&before.0, &before.1);
        let parted = encounter.speed_m_s(&after.0, &after.1);
        let restitution = value(&truth, |q| q == Quantity::Restitution { law });
        assert!(speed < -1.0, "they meet at {speed} m/s");
        assert!((parted + restitution * speed).abs() < 1e-13);

        let total = |of: fn(&(State, State)) -> &State| {
            let balances = pairs
                .iter()
                .zip(&links)
                .map(|(pair, link)| balance(&truth, *link, of(pair)));
            balances.fold((0.0, Vector3::zeros(), Vector3::zeros()), |a, b| {
                (a.0 + b.0, a.1 + b.1, a.2 + b.2)
            })
        };
        let (energy, momentum, spin) = total(|pair| &pair.0);
        let (energy_after, momentum_after, spin_after) = total(|pair| &pair.1);
        let lost = 0.5
            * (1.0 - restitution * restitution)
            * speed
            * speed
            * encounter.mass_kg(&before.0, &before.1);
        assert!((energy - energy_after - lost).abs() < 1e-13 && lost > 0.01);
        if links.len() == 2 {
            assert!((momentum_after - momentum).norm() < 1e-14);
            assert!((spin_after - spin).norm() < 1e-14);
        }
    }
}

#[test]
fn they_touch_nothing_but_what_they_should() {
    let truth = hat_box::truth();
    let scene = &truth.scene;
    let [hat_solid, box_solid] = [HAT, BOX].map(|link| scene.links[link].shape.solid().unwrap());
    let (board_m, board) = scene.surfaces[1].plane().unwrap();
    let (bounce_s, meeting_s) = (truth.event_times_s[0], truth.event_times_s[1]);
    for time_s in moments(&truth) {
        let [hat, cube] = [HAT, BOX].map(|link| truth.world_from_body(link, time_s));
        // A corner approaches at 1 m/s or more, and parts at a tenth of that.
        let apart = |event_s: f64| {
            (time_s - event_s)
                .abs()
                .min((truth.duration_s - time_s).abs())
        };
        let distance_m = hat_solid.distance_m(&hat, &box_solid, &cube).unwrap();
        let least_m = if apart(meeting_s) < 0.01 { -1e-7 } else { 1e-4 };
        assert!(distance_m > least_m, "{distance_m} m at {time_s} s");
        for corner in corners(scene, BOX) {
            let corner = cube * corner;
            assert!(corner.z > 1e-3);
            let off_m = board.dot(&(corner.coords - board_m));
            let least_m = if apart(bounce_s) < 0.01 { -1e-12 } else { 1e-4 };
            assert!(off_m > least_m, "{off_m} m off the board at {time_s} s");
            // Side and brim are cloth, and no box goes through cloth.
            let in_hat = hat.inverse_transform_point(&corner);
            let beside_m = in_hat.coords.xy().norm();
            let is_level = (-0.055..0.041).contains(&in_hat.z);
            let is_through = is_level && (0.1..0.14).contains(&beside_m);
            assert!(!is_through, "{beside_m} m at {time_s} s");
        }
        // The plate, and the rim of the brim.
        for (height_m, radius_m) in [(0.045, 0.1), (-0.055, 0.14)] {
            let centre = hat * Point3::new(0.0, 0.0, height_m);
            let axis = hat.rotation * Vector3::z();
            let lowest = |normal: &Vector3<f64>| radius_m * normal.cross(&axis).norm();
            assert!(centre.z - lowest(&Vector3::z()) > -1e-12, "{time_s} s");
            assert!(board.dot(&(centre.coords - board_m)) > lowest(&board));
        }
    }
    let [hat, cube] = [HAT, BOX].map(|link| truth.world_from_body(link, truth.duration_s));
    let gap_m = hat_solid.distance_m(&hat, &box_solid, &cube).unwrap();
    assert!(
        (gap_m - 2e-4).abs() < 1e-6,
        "the box ends {gap_m} m above the crown"
    );
}

#[test]
fn the_bent_scene_is_the_same_with_two_more_goals() {
    let (truth, bent) = (hat_box::truth(), hat_box::bent_reference());
    let mut scene = bent.scene.clone();
    assert_eq!(scene.goals.split_off(truth.scene.goals.len()).len(), 2);
    scene.name.clone_from(&truth.scene.name);
    assert_eq!(scene, truth.scene);
    assert!(!bent.is_physical && bent.goal_miss() < 1e-12);
    let bounce = Encounter::of(&bent.scene, &bent.parameters, 0).unwrap();
    let gap_m = bounce.gap_m(&around(&bent, BOX, 0).0, &still());
    assert!(gap_m.abs() < 1e-14, "{gap_m}");
}

/// What no push at a corner accounts for: `I Δω − p × Rᵀ m Δv`, relative to `I` [rad/s], at a
/// collision of a cube between two flights. Any push at `p` has a remainder of zero, along
/// whatever normal and with whatever friction.
fn unaccounted_rad_s(
    truth: &Truth,
    link: LinkIndex,
    corner: &Vector3<f64>,
    pair: (State, State),
) -> f64 {
    let cube = &truth.scene.links[link].body;
    let (before, after) = pair;
    let push = after
        .orientation
        .inverse_transform_vector(&(after.velocity_m_s - before.velocity_m_s))
        * cube.mass_kg();
    let turn = after.angular_velocity_rad_s - before.angular_velocity_rad_s;
    (turn - corner.cross(&push) / cube.moments_kg_m2().x).norm()
}

/// The least that the worst remainder can be on flights from pose to pose, corners touching at
/// the inner ones: over durations of 0.05 to 0.6 s of each flight, and a turn more or less.
fn least_unaccounted_rad_s(
    truth: &Truth,
    link: LinkIndex,
    poses: &[Pose],
    corners: &[Vector3<f64>],
) -> f64 {
    let flight = Flight::of(&truth.scene, link);
    // Velocities at both ends of every way to fly from one pose to the next.
    let ways = |pair: &[Pose]| -> Vec<(State, State)> {
        let durations = (5..=60).map(|step| f64::from(step) / 100.0);
        let all = durations.flat_map(|t| [-1.0, 0.0, 1.0].map(|turns| (t, turns)));
        all.map(|(t, turns)| {
            let begun = flight.between(&pair[0], &pair[1], t, turns);
            (begun, flight.advance(&begun, t))
        })
        .collect()
    };
    let flights: Vec<_> = poses.windows(2).map(ways).collect();
    let mut worst = vec![0.0_f64; flights[0].len()];
    for (pair, corner) in flights.windows(2).zip(corners) {
        let after = |(begun, _): &(State, State)| {
            let befores = pair[0].iter().zip(&worst).map(|((_, ended), worst)| {
                unaccounted_rad_s(truth, link, corner, (*ended, *begun)).max(*worst)
            });
            befores.fold(f64::INFINITY, f64::min)
        };
        worst = pair[1].iter().map(after).collect();
    }
    worst.into_iter().fold(f64::INFINITY, f64::min)
}

#[test]
fn no_push_makes_the_bent_flights_of_the_box() {
    let bent = hat_box::bent_reference();
    let meeting = Encounter::of(&bent.scene, &bent.parameters, 1).unwrap();
    let times_s = &bent.event_times_s;
    let poses = [0, 1, 2].map(|event| bent.world_from_body(BOX, times_s[event]));
    let least = least_unaccounted_rad_s(&bent, BOX, &poses, &[meeting.point_m]);
    assert!(least > 0.3, "{least} rad/s");
    // The measure is right: it leaves nothing of the true motion's.
    let truth = hat_box::truth();
    let pair = around(&truth, BOX, 1);
    assert!(unaccounted_rad_s(&truth, BOX, &meeting.point_m, pair) < 1e-12);
}

#[test]
fn the_die_shows_its_faces_in_order_and_no_push_makes_its_flights() {
    let reference = die::reference();
    let scene = &reference.scene;
    assert_eq!(
        (scene.goals.len(), scene.cones.len(), reference.arcs.len()),
        (6, 6, 7)
    );
    assert!(reference.goal_miss() < 1e-12 && !reference.is_physical);
    let faces = [
        (1, Vector3::z()),
        (6, -Vector3::z()),
        (2, Vector3::x()),
        (5, -Vector3::x()),
        (3, Vector3::y()),
        (4, -Vector3::y()),
    ];
    let mut shown = Vec::new();
    for goal in &scene.goals {
        let GoalTarget::Pose { world_from_body } = &goal.target else {
            panic!("a pose");
        };
        let up = |face: &Vector3<f64>| (world_from_body.rotation * face).z;
        let top = faces
            .iter()
            .max_by(|a, b| up(&a.1).total_cmp(&up(&b.1)))
            .unwrap();
        let lean_deg = up(&top.1).acos().to_degrees();
        assert!((25.0..45.0).contains(&lean_deg));
        shown.push(top.0);
        // The named corner is the lowest, and exactly on the table.
        let encounter = Encounter::of(scene, &reference.parameters, goal.event).unwrap();
        let mut heights: Vec<f64> = corners(scene, LinkIndex(0))
            .iter()
            .map(|c| (world_from_body * c).z)
            .collect();
        heights.sort_by(f64::total_cmp);
        let touching = (world_from_body * Point3::from(encounter.point_m)).z;
        assert!(touching.abs() < 1e-16 && heights[0] == touching && heights[1] > 0.015);
        // It comes down and goes up.
        let (before, after) = around(&reference, LinkIndex(0), goal.event);
        assert!(encounter.speed_m_s(&before, &still()) < -0.8);
        assert!(encounter.speed_m_s(&after, &still()) > 0.5);
        assert!(after.angular_velocity_rad_s.norm() < TAU * 4.0);
    }
    assert_eq!(shown, [1, 6, 1, 3, 2, 3]);
    let goals: Vec<Pose> = scene
        .goals
        .iter()
        .map(|goal| reference.world_from_body(LinkIndex(0), reference.event_times_s[goal.event]))
        .collect();
    let touching = (1..5).map(|event| {
        let encounter = Encounter::of(scene, &reference.parameters, event);
        encounter.unwrap().point_m
    });
    let least = least_unaccounted_rad_s(
        &reference,
        LinkIndex(0),
        &goals,
        &touching.collect::<Vec<_>>(),
    );
    assert!(least > 0.5, "{least} rad/s");
}

#[test]
fn a_flight_between_poses_leads_from_one_to_the_other() {
    let reference = die::reference();
    let flight = Flight::of(&reference.scene, LinkIndex(0));
    let pose =
        |event: usize| reference.world_from_body(LinkIndex(0), reference.event_times_s[event]);
    for turns in [-1.0, 0.0, 2.0] {
        let begun = flight.between(&pose(0), &pose(1), 0.4, turns);
        let ended = flight.advance(&begun, 0.4);
        assert!((ended.position_m - pose(1).translation.vector).norm() < 1e-14);
        let left = so3::log(&(ended.orientation.inverse() * pose(1).rotation));
        assert!(left.norm() < 1e-12, "{turns} {}", left.norm());
    }
}

#[test]
fn the_estimators_law_agrees_on_the_meeting() {
    let truth = hat_box::truth();
    for (event, other) in [(0, None), (1, Some(HAT))] {
        let meeting = truth.scene.contact_set(event).unwrap().unwrap();
        let law = truth.scene.events[event].kind.collision().unwrap().law;
        let (before, after) = around(&truth, BOX, event);
        let partner = other.map(|link| around(&truth, link, event));
        let body_of = |link: LinkIndex| &truth.scene.links[link].body;
        let a = Side {
            body: body_of(BOX),
            state: &before,
        };
        let b = partner.as_ref().map(|(state, _)| Side {
            body: body_of(HAT),
            state,
        });
        let tilt_rad = [0, 1].map(|tangent| {
            let tilt = Quantity::Tilt { event, tangent };
            let mut names = truth.scene.parameters.iter();
            let index = names.position(|parameter| parameter.quantity == tilt);
            index.map_or(0.0, |index| truth.parameters[index])
        });
        let law = Law {
            restitution: value(&truth, |q| q == Quantity::Restitution { law }),
            friction: 0.0,
            tangential_restitution: 0.0,
            tilt_rad,
        };
        let impact = meeting.impact(&a, b.as_ref(), &law).unwrap();
        let expected = [Some(after), partner.map(|(_, after)| after)];
        for (found, expected) in impact.after.iter().zip(expected) {
            let Some(expected) = expected else { continue };
            let velocity = found.velocity_m_s - expected.velocity_m_s;
            let spin = found.angular_velocity_rad_s - expected.angular_velocity_rad_s;
            assert!(
                velocity.norm() < 1e-12 && spin.norm() < 1e-11,
                "{velocity} {spin}"
            );
        }
    }
}

#[test]
fn a_brick_flips_as_often_as_asked_and_lands_on_a_corner() {
    for (count, seed) in [(1, 0), (2, 1), (4, 2), (8, 3)] {
        let truth = flips(count, seed).unwrap();
        let (before, after) = around(&truth, LinkIndex(0), 0);
        let arc = &truth.arcs[0];
        let about_middle: Vec<f64> = (0..=1000)
            .map(|step| arc.end_s * f64::from(step) / 1e3)
            .map(|time_s| advance(&truth, LinkIndex(0), &arc.state, time_s))
            .map(|state| state.angular_velocity_rad_s.y)
            .collect();
        let flipped = about_middle.windows(2).filter(|w| w[0] * w[1] < 0.0);
        assert_eq!(flipped.count(), count, "{count} flips, seed {seed}");

        let lowest_m = |state: &State| {
            let heights = corners(&truth.scene, LinkIndex(0)).into_iter();
            let heights = heights.map(|corner| (state.world_from_body() * corner).z);
            heights.fold(f64::INFINITY, f64::min)
        };
        assert!(lowest_m(&before).abs() < 1e-9, "{}", lowest_m(&before));
        for time_s in moments(&truth) {
            let height_m = lowest_m(&truth.state(LinkIndex(0), time_s));
            assert!(height_m > -1e-9, "{height_m} m at {time_s} s");
        }
        let (energy_j, momentum, _) = balance(&truth, LinkIndex(0), &before);
        let (energy_after_j, momentum_after, _) = balance(&truth, LinkIndex(0), &after);
        assert!(energy_after_j < energy_j);
        // The table has no friction: the impulse is vertical.
        let impulse = momentum_after - momentum;
        assert!(impulse.xy().norm() < 1e-12 && impulse.z > 0.0);
    }
}
