//! Waypoints: what is unknown, what keeps them within their flights, and derivatives of what holds there.

use super::*;
use crate::estimate::posing::waypoint;
use crate::estimate::problem::arc_condition::ArcCondition;
use crate::estimate::problem::{Arc, Ordered, TimeSide, Waypoint};
use crate::motion::{BodyPoint, Condition, GoalQuantity, GoalSet, Moment};
use crate::physics::flow;

const UNKNOWN: Timing = Timing::Unknown {
    tempo_sd_per_sqrt_s: 0.5,
};

/// Events with waypoints: one in the flight before the bounce, two in that after it.
const BEFORE: usize = 0;
const BOUNCE: usize = 1;
const FIRST: usize = 2;
const SECOND: usize = 3;
const LANDING: usize = 4;
const MARKS_S: [f64; 5] = [0.08, 0.22, 0.3, 0.38, 0.45];

/// A scene of [`scene`] or [`meeting`] with waypoints of its first link, and goals at them.
fn passing(mut scene: Scene, offset: f64) -> (Scene, Sketch, Vec<Segment>, Guess) {
    let (mut sketch, mut segments, mut guess) = sketch(&scene, offset);
    let link = LinkIndex(0);
    let place = |event: usize| [BOUNCE, LANDING][event];
    for (at, name) in [(BEFORE, "before"), (FIRST, "first"), (SECOND, "second")] {
        let waypoint = Event::new(name, EventKind::Waypoint(link));
        scene.events.insert(at, waypoint);
    }
    for goal in &mut scene.goals {
        goal.place_events(place);
    }
    for free in &mut scene.parameters {
        free.quantity = free.quantity.at_event(place);
    }
    for segment in &mut segments {
        segment.start_event = segment.start_event.map(place);
        segment.end_event = segment.end_event.map(place);
    }
    sketch.marks_s = MARKS_S.to_vec();
    sketch.marks = MARKS_S
        .iter()
        .map(|mark_s| mark(mark_s + 0.01 * offset))
        .collect();
    guess.event_times_s = MARKS_S.to_vec();

    let pose = Pose::from_parts(
        Vector3::new(0.02, 0.06, 0.3).into(),
        UnitQuaternion::from_euler_angles(0.3, -0.1, 0.4),
    );
    let condition = |quantity, set, sd| {
        GoalTarget::Condition(Condition {
            quantity,
            set,
            moment: Moment::Before,
            sd,
        })
    };
    let other = (scene.links.len() > 1).then_some(LinkIndex(1));
    let fixed = BodyPoint::Fixed(Vector3::new(0.02, -0.01, 0.07));
    let turn = GoalQuantity::Turn {
        from: UnitQuaternion::from_euler_angles(0.9, 0.5, -0.4),
        seen_from: other,
    };
    let beside = GoalQuantity::Position {
        point: fixed,
        seen_from: other,
    };
    let targets = [
        (
            BEFORE,
            GoalTarget::Pose {
                world_from_body: pose,
            },
        ),
        (
            FIRST,
            GoalTarget::PositionWithin {
                lower_m: Vector3::new(0.1, f64::NEG_INFINITY, 0.2),
                upper_m: Vector3::new(0.1, f64::INFINITY, 0.3),
            },
        ),
        (FIRST, condition(turn, GoalSet::about_zero(None), None)),
        (
            SECOND,
            condition(
                GoalQuantity::Velocity { point: fixed },
                GoalSet::point(Vector3::new(0.3, 0.1, 0.2)),
                None,
            ),
        ),
        (
            SECOND,
            condition(beside, GoalSet::point(Vector3::zeros()), Some(0.02)),
        ),
        (
            SECOND,
            condition(
                GoalQuantity::Time { since: Some(FIRST) },
                GoalSet::point(Vector3::new(0.1, 0.0, 0.0)),
                None,
            ),
        ),
    ];
    let goals = targets.map(|(event, target)| Goal {
        event,
        link,
        target,
    });
    scene.goals.extend(goals);
    (scene, sketch, segments, guess)
}

#[test]
fn a_waypoint_is_one_unknown_and_cuts_nothing() {
    for timing in [Timing::Known, UNKNOWN] {
        for of in [scene(timing), meeting(timing, 0.05)] {
            let (before, segments_before, _) = sketch(&of, 1.0);
            let without = Layout::new(&Problem::new(&of, &before, &segments_before)).size();
            let (scene, sketch, segments, _) = passing(of, 1.0);
            let problem = Problem::new(&scene, &sketch, &segments);
            assert_eq!(segments.len(), segments_before.len());
            assert_eq!(Layout::new(&problem).size(), without + 3);
            let of_first = |end: usize| {
                let mut arcs = problem.arcs.iter();
                let is_it = |arc: &Arc| {
                    arc.mechanism == scene.mechanism_of(LinkIndex(0)) && arc.end == Some(end)
                };
                arcs.position(is_it).unwrap()
            };
            let waypoint = |event, end| Waypoint {
                event,
                arc: of_first(end),
            };
            let expected = [
                waypoint(BEFORE, BOUNCE),
                waypoint(FIRST, LANDING),
                waypoint(SECOND, LANDING),
            ];
            assert_eq!(problem.waypoints, expected);
            for condition in &problem.conditions {
                let is_time = |of: &ArcCondition| of.condition.quantity.is_time();
                assert!(
                    is_time(condition) || condition.arcs[0] == of_first(LANDING),
                    "{condition:?}"
                );
            }
        }
    }
}

#[test]
fn a_waypoint_stays_within_its_flight_and_in_order() {
    let (mut scene, sketch, segments, _) = passing(scene(Timing::Known), 0.0);
    let problem = Problem::new(&scene, &sketch, &segments);
    for events in [
        [BEFORE, BOUNCE],
        [BOUNCE, FIRST],
        [FIRST, SECOND],
        [SECOND, LANDING],
    ] {
        assert!(problem.ordered.contains(&Ordered { events }), "{events:?}");
    }
    // Before the first flight's first sample there is no flight.
    let [bound] = problem.time_bounds[..] else {
        panic!("{:?}", problem.time_bounds);
    };
    assert_eq!((bound.event, bound.side), (BEFORE, TimeSide::Earliest));
    let first_s = problem.arcs[0].ends().unwrap()[0].time_s(&problem.nodes_acted_s);
    assert_eq!(bound.acted_s, first_s);

    // An end that is given is no unknown, and bounds all the same; so does a time that is fixed.
    scene.events[LANDING].time.is_free = Some(false);
    scene.events[SECOND].time.is_free = Some(false);
    let problem = Problem::new(&scene, &sketch, &segments);
    let bounds = problem.time_bounds.iter();
    let sides: Vec<_> = bounds.map(|of| (of.event, of.side, of.acted_s)).collect();
    for expected in [
        (SECOND, TimeSide::Latest, MARKS_S[LANDING]),
        (
            SECOND,
            TimeSide::Only,
            sketch.marks[SECOND].unwrap().acted_s,
        ),
    ] {
        assert!(sides.contains(&expected), "{sides:?}");
    }
}

#[test]
fn what_holds_at_waypoints_has_exact_derivatives() {
    for timing in [Timing::Known, UNKNOWN] {
        let scenes = [
            scene(timing),
            meeting(timing, 0.05),
            modelled(scene(timing)),
            modelled(meeting(timing, 0.05)),
        ];
        for of in scenes {
            let (scene, sketch, segments, guess) = passing(of, 1.0);
            let problem = Problem::new(&scene, &sketch, &segments);
            let goals = problem.goals.iter().filter(|of| of.event != BOUNCE);
            assert!(goals.count() >= 4 && problem.conditions.len() == 4);
            let layout = Layout::new(&problem);
            let point = Point::new(&problem, &guess);
            let context = SolveContext::new(&problem, &layout, recipe::epochs_s(&guess), &point);
            let lengths: Vec<f64> = lengths(&layout).iter().map(|l| 0.3 * l).collect();
            assert_exact_rows(&context, &Guidance::none(), &point, &lengths);
        }
    }
}

/// From a mark that is off by more than half a turn a waypoint is found where the flight passes its goal.
#[test]
fn a_waypoint_begins_where_its_flight_comes_nearest() {
    let (mut scene, sketch, segments, mut guess) = passing(scene(Timing::Known), 0.0);
    scene.goals.retain(|goal| goal.event == LANDING);
    let problem = Problem::new(&scene, &sketch, &segments);
    let arc = problem.waypoints[1].arc;
    guess.arcs[arc].state.angular_velocity_rad_s *= 5.0;
    let passed_s = MARKS_S[FIRST] + 0.08;
    let there = flow::advance(
        &scene.links[LinkIndex(0)].body,
        &GRAVITY,
        &guess.arcs[arc].state,
        passed_s - guess.arcs[arc].epoch_s,
    );
    let turned = guess.arcs[arc].state.angular_velocity_rad_s.norm() * 0.08;
    assert!(turned > std::f64::consts::PI, "{turned}");
    let aligned_s = |target: Option<GoalTarget>| {
        let mut scene = scene.clone();
        scene.goals.extend(target.map(|target| Goal {
            event: FIRST,
            link: LinkIndex(0),
            target,
        }));
        let problem = Problem::new(&scene, &sketch, &segments);
        let layout = Layout::new(&problem);
        let mut point = Point::new(&problem, &guess);
        let context = SolveContext::new(&problem, &layout, recipe::epochs_s(&guess), &point);
        waypoint::align(&context, &mut point);
        point.event_times_s[FIRST]
    };
    let pose = GoalTarget::Pose {
        world_from_body: there.world_from_body(),
    };
    let found_s = aligned_s(Some(pose));
    assert!((found_s - passed_s).abs() < 0.006, "{found_s} {passed_s}");
    // Without a goal it stays at its mark.
    assert_eq!(aligned_s(None), MARKS_S[FIRST]);
}
