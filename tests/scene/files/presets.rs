//! Every object at hand, dropped, bounces as physics has it, through the program.

use std::path::Path;

use enact::config::{PRESETS, scene_from_toml};
use enact::math::Pose;
use enact::motion::{LinkIndex, Mark, PoseSample, Scene, Stamp, TakeEvent, TrackIndex};
use enact::physics::contact::Feature;
use enact_tools::perform::recording::write_events_of;
use enact_tools::replay::Program;
use nalgebra::{Isometry3, UnitQuaternion, Vector3};

use super::{folder, stdout};

const ENACT: Program = Program(env!("CARGO_BIN_EXE_enact"));
const GRAVITY_M_S2: f64 = 9.80665;
const RATE_HZ: f64 = 400.0;
/// It falls so long.
const FALL_S: f64 = 0.3;

/// The point by which it touches in its axes, whose origin is its centre of mass: of the feature that the scene has it
/// bounce by, otherwise of its first corner. Turned so that the point is below the centre of mass, what it does at the
/// impact is known without a model of impacts: it comes back at a share of its speed, and does not turn.
fn lowest_m(scene: &Scene) -> Vector3<f64> {
    let link = &scene.links[LinkIndex(0)];
    let collision = scene.events.iter().find_map(|event| event.kind.collision());
    let contacts = &collision.expect("a bounce").contacts;
    let named = contacts.first().and_then(|contact| contact.feature);
    let corner = |of: &Feature| matches!(of, Feature::Point { .. });
    let feature = match named {
        Some(named) => link.features[named].geometry,
        None => { link.features.iter().map(|of| of.geometry) }
            .find(corner)
            .expect("a corner"),
    };
    match feature {
        Feature::Point { point_m, radius_m } => {
            let down = point_m.try_normalize(1e-9).unwrap_or_else(Vector3::z);
            point_m + down * radius_m
        }
        Feature::Rim {
            centre_m,
            axis,
            radius_m,
        } => {
            // On the side where a handle is not.
            let aside = link.link_from_given.rotation * -Vector3::x();
            let across = aside - axis * axis.dot(&aside);
            centre_m + across.normalize() * radius_m
        }
        other => panic!("{} is no corner and no rim", other.kind()),
    }
}

/// The coefficient of the bounce.
fn restitution(scene: &Scene) -> f64 {
    let collision = scene.events.iter().find_map(|event| event.kind.collision());
    scene.law_of(collision.expect("a bounce")).restitution
}

/// When it ends: on its way down again.
fn end_s(scene: &Scene) -> f64 {
    FALL_S + 1.5 * restitution(scene) * FALL_S
}

/// Readings of a fall and a bounce, a millimetre and half a degree off, and marks.
fn drop_of(scene: &Scene) -> Vec<TakeEvent> {
    let lowest_m = lowest_m(scene);
    let (restitution, end_s) = (restitution(scene), end_s(scene));
    let down = UnitQuaternion::rotation_between(&lowest_m, &-Vector3::z());
    let down = down.unwrap_or_else(|| {
        UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI)
    });
    let speed_m_s = GRAVITY_M_S2 * FALL_S;
    let stamp = |time_s: f64| Stamp(1_700_000_000_000_000_000 + (time_s * 1e9) as i64);
    let count = (end_s * RATE_HZ) as usize;
    let mut events: Vec<TakeEvent> = (0..=count)
        .map(|index| {
            let time_s = index as f64 / RATE_HZ;
            let since_s = time_s - FALL_S;
            let speed_m_s = if since_s < 0.0 {
                -speed_m_s
            } else {
                restitution * speed_m_s
            };
            let up_m = speed_m_s * since_s - 0.5 * GRAVITY_M_S2 * since_s * since_s;
            let noise = |pace: f64, size: f64| {
                Vector3::new(0.0, 2.0, 4.0).map(|of| size * (pace * index as f64 + of).sin())
            };
            let place_m = Vector3::z() * (lowest_m.norm() + up_m) + noise(12.9, 1e-3);
            let turn = UnitQuaternion::from_scaled_axis(noise(78.2, 8e-3)) * down;
            let pose: Pose = Isometry3::from_parts(place_m.into(), turn);
            let pose = pose * scene.tracks[TrackIndex(0)].link_from_tracker;
            let q = pose.rotation.coords;
            let sample =
                PoseSample::new(stamp(time_s), pose.translation.vector, [q.x, q.y, q.z, q.w]);
            TakeEvent::Pose {
                track: TrackIndex(0),
                stream: 0,
                sample,
            }
        })
        .collect();
    for (time_s, event) in [(FALL_S, "bounce"), (end_s, "landing")] {
        let event = Some(event.to_owned());
        events.push(TakeEvent::Mark(Mark {
            stamp: stamp(time_s),
            event,
        }));
    }
    events
}

#[test]
fn every_object_bounces_through_the_program() {
    let folder = folder();
    for preset in PRESETS {
        let name = preset.name;
        let file = format!("{name}.toml");
        let mut new = vec!["scene", "new", name, "--stamps", "physical", "-o", &file];
        // The one whose bounce a rule gives.
        new.extend(
            ["--material", "tennis-ball"]
                .iter()
                .filter(|_| name == "ball"),
        );
        stdout(folder.path(), &new, 0);
        let text = std::fs::read_to_string(folder.path().join(&file)).expect("a scene");
        let scene = scene_from_toml(&text).expect("a scene");
        let path = folder.path().join(format!("{name}.mcap"));
        write_events_of(&scene, &text, &drop_of(&scene), Path::new(&path)).expect("written");
        let replayed = ENACT.report(&path, &[]);
        let said = &replayed.said;
        assert_eq!(said["verdict"], "physical", "{name}: {said}");
        let bounce = said["events"].as_array().expect("events").iter();
        let bounce = { bounce }
            .find(|of| of["name"] == "bounce")
            .expect("the bounce");
        let time_s = bounce["time_s"].as_f64().expect("a time");
        assert!((time_s - FALL_S).abs() < 0.01, "{name}: {time_s} s");
        let last = said["events"]
            .as_array()
            .and_then(|of| of.last())
            .expect("the end");
        let time_s = last["time_s"].as_f64().expect("a time");
        assert!((time_s - end_s(&scene)).abs() < 0.02, "{name}: {time_s} s");
    }
}
