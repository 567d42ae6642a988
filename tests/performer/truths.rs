//! The performance maker's truths obey physics, meet their goals and pass through nothing; its
//! recordings are made again byte for byte.

use enact::motion::{FreeBody, LinkIndex, TrackIndex};
use enact_tools::perform;
use enact_tools::perform::recording;
use std::path::Path;

use enact::math::Pose;

use enact::physics::contact::Feature::Point;
use enact::physics::{State, flow};
use enact_tools::perform::encounter::{Encounter, still};
use enact_tools::perform::{Acting, Style, Truth, bounces, perform, simulate};
use nalgebra::Vector3;

fn truths() -> Vec<Truth> {
    let mut truths: Vec<_> = Style::ALL.iter().map(|style| style.truth()).collect();
    truths.extend([1, 8].map(|count| bounces(count, 3).unwrap()));
    truths
}

/// Kinetic and potential energy [J], and angular momentum about the centre of mass [N m s, world].
fn invariants(truth: &Truth, state: &State) -> (f64, Vector3<f64>) {
    let body = &truth.scene.links[LinkIndex(0)].body;
    let omega = state.angular_velocity_rad_s;
    let momentum = body.moments_kg_m2().component_mul(&omega);
    let energy = 0.5 * body.mass_kg() * state.velocity_m_s.norm_squared()
        + 0.5 * momentum.dot(&omega)
        - body.mass_kg() * truth.scene.gravity_m_s2.dot(&state.position_m);
    (energy, state.orientation * momentum)
}

fn advance(truth: &Truth, state: &State, duration_s: f64) -> State {
    flow::advance(
        &truth.scene.links[LinkIndex(0)].body,
        &truth.scene.gravity_m_s2,
        state,
        duration_s,
    )
}

/// The contact of a bounce, for the estimator's own law of it.
fn encounter(truth: &Truth, event: usize) -> Encounter {
    Encounter::of(&truth.scene, &truth.parameters, event).unwrap()
}

/// The body's true pose every half millisecond.
fn poses(truth: &Truth) -> impl Iterator<Item = (f64, Pose)> {
    let steps = (truth.duration_s / 5e-4) as usize;
    (0..=steps)
        .map(move |step| truth.duration_s * step as f64 / steps as f64)
        .map(move |time_s| (time_s, truth.world_from_body(LinkIndex(0), time_s)))
}

#[test]
fn goals_are_met_to_rounding() {
    for style in Style::ALL {
        let truth = style.truth();
        assert_eq!(truth.scene.goals.len(), 1);
        assert!(
            truth.goal_miss() < 1e-13,
            "{style:?} misses by {}",
            truth.goal_miss()
        );
        let again = simulate(&truth.scene, &[], &[truth.arcs[0].state], truth.duration_s).unwrap();
        assert_eq!(again, truth);
    }
}

#[test]
fn flight_conserves_energy_and_angular_momentum() {
    for truth in truths() {
        for arc in &truth.arcs {
            let (energy, momentum) = invariants(&truth, &arc.state);
            for step in 1..=10 {
                let time_s = arc.start_s + (arc.end_s - arc.start_s) * f64::from(step) / 10.0;
                let later = advance(&truth, &arc.state, time_s - arc.start_s);
                let (e, m) = invariants(&truth, &later);
                assert!(
                    (e - energy).abs() < 1e-13 * energy.abs(),
                    "{}",
                    truth.scene.name
                );
                assert!((m - momentum).norm() < 1e-13 * momentum.norm());
            }
        }
    }
}

#[test]
fn a_bounce_happens_at_contact_and_loses_the_energy_it_should() {
    for truth in truths() {
        let body = &truth.scene.links[LinkIndex(0)].body;
        let mut collisions = 0;
        for (index, event) in truth.scene.events.iter().enumerate() {
            let Some(collision) = event.kind.collision() else {
                continue;
            };
            let restitution = truth.scene.law_of(collision).restitution;
            collisions += 1;
            let bounce = encounter(&truth, index);
            let arc = &truth.arcs[index];
            assert_eq!((arc.end_s, truth.arcs[index + 1].start_s), {
                let time_s = truth.event_times_s[index];
                (time_s, time_s)
            });
            let before = advance(&truth, &arc.state, arc.end_s - arc.start_s);
            let after = &truth.arcs[index + 1].state;
            let gap_m = bounce.gap_m(&before, &still());
            assert!(gap_m.abs() < 1e-14, "{gap_m}");
            assert!((after.position_m - before.position_m).norm() < 1e-13);

            let normal = bounce.face_normal;
            let in_body = before.orientation.inverse_transform_vector(&normal);
            let arm = bounce.point_m.cross(&in_body);
            let inverse_inertia =
                1.0 / body.mass_kg() + arm.dot(&arm.component_div(&body.moments_kg_m2()));
            let speed = normal.dot(&before.velocity_m_s) + arm.dot(&before.angular_velocity_rad_s);
            let lost = 0.5 * (1.0 - restitution * restitution) * speed * speed / inverse_inertia;
            let (energy, energy_after) =
                (invariants(&truth, &before).0, invariants(&truth, after).0);
            assert!((energy - energy_after - lost).abs() < 1e-13 * energy);
            assert!(speed < -0.5);
            let (back, _) = bounce.before(after, &still());
            assert!(back.minus(&before).norm() < 1e-12);
        }
        assert_eq!(collisions + 1, truth.arcs.len());
    }
}

#[test]
fn the_pencils_do_what_their_names_say() {
    for (style, feature, half_turns) in [(Style::Tip, "tip", 2.0), (Style::Eraser, "eraser", 1.0)] {
        let truth = style.truth();
        assert!((0.7..1.0).contains(&truth.duration_s));
        let bounce = truth.scene.events[0].kind.collision().unwrap();
        let touching = bounce.contacts[0].feature.unwrap();
        let features = &truth.scene.links[bounce.link].features;
        assert_eq!(features[touching].name, feature);
        assert!((0.5..=0.8).contains(&truth.scene.law_of(bounce).restitution));
        let bounce_s = truth.event_times_s[0];
        assert!(bounce_s > 0.2 && truth.duration_s - bounce_s > 0.2);
        let encounter = encounter(&truth, 0);
        let before = advance(&truth, &truth.arcs[0].state, bounce_s);
        assert!(encounter.speed_m_s(&before, &still()) < -1.0);

        // The way of the pencil's axis after the bounce, and its spin about itself.
        let axes: Vec<_> = poses(&truth)
            .filter(|(time_s, _)| *time_s >= bounce_s)
            .map(|(_, pose)| pose.rotation * Vector3::z())
            .collect();
        let turned: f64 = axes.windows(2).map(|pair| pair[0].angle(&pair[1])).sum();
        assert!(
            (turned / std::f64::consts::PI - half_turns).abs() < 0.1,
            "{turned}"
        );
        assert!(truth.arcs[1].state.angular_velocity_rad_s.z.abs() > 10.0);
        let lean = axes.last().unwrap().angle(&Vector3::z()).to_degrees();
        assert!((1.0..10.0).contains(&lean), "it leans by {lean}°");
    }
}

#[test]
fn the_pencils_pass_through_neither_table_nor_mug() {
    for style in Style::ALL {
        let truth = style.truth();
        let pencil = truth.scene.links[LinkIndex(0)].shape.solid().unwrap();
        let obstacles: Vec<_> = truth
            .scene
            .obstacles
            .iter()
            .map(|o| {
                (
                    o.name.as_str(),
                    o.shape.solid().unwrap(),
                    o.world_from_shape,
                )
            })
            .collect();
        assert_eq!(obstacles.len(), 9);
        for (time_s, pose) in poses(&truth) {
            for end in [-0.095, 0.095] {
                let point = pose * nalgebra::Point3::new(0.0, 0.0, end);
                assert!(
                    point.z > -1e-12,
                    "{style:?} is under the table at {time_s} s"
                );
            }
            for (name, obstacle, world_from_shape) in &obstacles {
                let distance_m = pencil
                    .distance_m(&pose, obstacle, world_from_shape)
                    .unwrap();
                let least_m = if *name == "mug floor" { 1e-4 } else { 0.015 };
                assert!(
                    distance_m > least_m,
                    "{style:?} at {time_s} s: {name} {distance_m} m"
                );
            }
        }
        // It does arrive at the floor, inside.
        let last = truth.world_from_body(LinkIndex(0), truth.duration_s);
        let (_, floor, world_from_floor) = &obstacles[0];
        assert!(pencil.distance_m(&last, floor, world_from_floor).unwrap() < 1e-3);
    }
}

#[test]
fn the_cube_bounces_on_its_lowest_corner_as_often_as_asked() {
    for (count, seed) in [(1, 0), (2, 5), (8, 1), (20, 2), (60, 9)] {
        let truth = bounces(count, seed).unwrap();
        assert_eq!(truth.scene.events.len(), count + 1);
        assert_eq!(bounces(count, seed).unwrap(), truth);
        let corners = &truth.scene.links[LinkIndex(0)].features;
        for (time_s, pose) in poses(&truth) {
            let lowest_m = corners
                .iter()
                .map(|corner| match corner.geometry {
                    Point { point_m, .. } => (pose * nalgebra::Point3::from(point_m)).z,
                    _ => panic!("corners are points"),
                })
                .fold(f64::INFINITY, f64::min);
            assert!(
                lowest_m > -1e-9,
                "{count} bounces, seed {seed}, {time_s} s: {lowest_m}"
            );
        }
        for arc in &truth.arcs[..count] {
            assert!(arc.end_s - arc.start_s > 0.1);
        }
        let scene =
            enact::config::scene_from_toml(&perform::bounces::scene_toml(&truth.scene)).unwrap();
        assert_eq!(scene.events, truth.scene.events);
        assert_eq!(
            scene.links[LinkIndex(0)].body,
            truth.scene.links[LinkIndex(0)].body
        );
        for (read, made) in scene.links[LinkIndex(0)].features.iter().zip(corners) {
            assert_eq!(read.name, made.name);
            let (Point { point_m: a, .. }, Point { point_m: b, .. }) =
                (read.geometry, made.geometry)
            else {
                panic!("corners are points");
            };
            assert!((a - b).norm() < 1e-15);
        }
    }
}

#[test]
fn a_motion_that_does_not_happen_is_refused() {
    let truth = Style::Tip.truth();
    let mut upward = truth.arcs[0].state;
    upward.velocity_m_s.z = 30.0;
    let refused = simulate(&truth.scene, &[], &[upward], 0.5);
    assert!(matches!(
        refused,
        Err(perform::TruthError::NoContact { event: 0, .. })
    ));
    let mut twice = truth.scene.clone();
    let (link, track) = (
        twice.links[LinkIndex(0)].clone(),
        twice.tracks[TrackIndex(0)].clone(),
    );
    twice.add(FreeBody {
        name: link.name,
        topic: track.topic,
        body: link.body,
        shape: link.shape,
        body_from_tracker: track.link_from_tracker,
        features: link.features,
    });
    let refused = simulate(&twice, &[], &[truth.arcs[0].state], 0.5);
    let bodies = perform::TruthError::Bodies {
        count: 2,
        expected: 1,
    };
    assert_eq!(refused, Err(bodies));
}

#[test]
fn the_same_seed_gives_the_same_bytes_and_another_does_not() {
    let folder = tempfile::tempdir().unwrap();
    let truth = Style::Eraser.truth();
    let bytes = |name: &str, seed| {
        let path = folder.path().join(name);
        let performance = perform(&truth, &Acting::default(), seed);
        recording::write(&performance, Style::Eraser.scene_toml(), &path).unwrap();
        std::fs::read(path).unwrap()
    };
    let once = bytes("once.mcap", 4);
    assert_eq!(once, bytes("again.mcap", 4));
    assert_ne!(once, bytes("other.mcap", 5));
}

#[test]
fn kept_recordings_are_made_again_byte_for_byte() {
    let folder = tempfile::tempdir().unwrap();
    let kept_in = Path::new(env!("CARGO_MANIFEST_DIR")).join("recordings");
    for kept in recording::kept() {
        let path = folder.path().join(kept.name);
        kept.write(&path).unwrap();
        let (made, stored) = (
            std::fs::read(path).unwrap(),
            std::fs::read(kept_in.join(kept.name)),
        );
        assert!(
            made == stored.unwrap(),
            "{}: run `cargo run -p enact-tools --bin perform -- --all -o recordings` if that is meant",
            kept.name
        );
        assert!(made.len() < 300_000);
    }
}

#[test]
fn the_attached_truth_is_the_truth() {
    let kept = &recording::kept()[0];
    let performance = perform(&(kept.truth)(), &kept.acting, kept.seed);
    let json: serde_json::Value =
        serde_json::from_str(&recording::truth_json(&performance)).unwrap();
    let truth = &performance.truth;
    let near = |value: &serde_json::Value, expected: f64| {
        (value.as_f64().unwrap() - expected).abs() <= 5.1e-10
    };
    assert!(near(&json["duration_s"], truth.duration_s));
    assert_eq!(json["events"][0]["name"], "bounce");
    assert!(near(&json["events"][0]["time_s"], truth.event_times_s[0]));
    assert!(near(
        &json["arcs"][1]["velocity_m_s"][2],
        truth.arcs[1].state.velocity_m_s.z
    ));
    let times = json["samples"][0]["times_s"].as_array().unwrap();
    assert_eq!(times.len(), performance.sample_times_s[TrackIndex(0)].len());
    assert_eq!(
        times.len(),
        json["samples"][0]["stamps_ns"].as_array().unwrap().len()
    );
    assert!(near(
        &times[100],
        performance.sample_times_s[TrackIndex(0)][100]
    ));
}
