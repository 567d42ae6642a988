//! Bodies and trees that nothing ties to each other, through the pipeline: each comes out as it does alone.

use enact::config::scene_from_toml;
use enact::math::Pose;
use enact::motion::{
    About, Fits, Mark, PoseSample, Quantity, Scene, Stamp, TakeEvent, TrackIndex, Verdict,
};
use enact::pipeline::{Outcome, Pipeline};
use nalgebra::{Translation3, UnitQuaternion, Vector3};

const RATE_HZ: f64 = 100.0;
const BOUNCE_S: f64 = 0.41;
const END_S: f64 = 0.8;
const RADIUS_M: f64 = 0.02;
const FALL_M_S2: f64 = -9.80665;

/// A ball that bounces once. `of_ball` and `further` are further keys of the ball, and tables.
fn ball_toml(of_ball: &str, further: &str) -> String {
    format!(
        "name = \"ball\"\n[timing]\nstamps = \"physical\"\n[weights]\nposition_mm = 10\n\
         [[body]]\nname = \"ball\"\nshape = {{ kind = \"sphere\", radius_mm = 20 }}\nmass_g = 50\n{of_ball}\n\
         [[surface]]\nname = \"table\"\npoint_mm = [0, 0, 0]\nnormal = [0, 0, 1]\n\
         [[event]]\nname = \"start\"\nkind = \"start\"\n\
         [[event]]\nname = \"bounce\"\nkind = \"collision\"\nbody = \"ball\"\nsurface = \"table\"\n\
         restitution = 0.7\nfriction = 0\n\
         [[event]]\nname = \"end\"\nkind = \"end\"\n{further}"
    )
}

/// A lamp that hangs from a nail at a place.
fn lamp_toml(nail_mm: [f64; 3]) -> String {
    format!(
        "[[body]]\nname = \"lamp\"\nshape = {{ kind = \"cylinder\", length_mm = 200, radius_mm = 10 }}\nmass_g = 200\n\
         [[joint]]\nname = \"hook\"\nkind = \"ball\"\nparent_at_mm = {nail_mm:?}\nchild = \"lamp\"\nchild_at_mm = [0, 0, 100]\n"
    )
}

/// The lamp beside the ball, at rest below its nail.
struct Lamp {
    nail_mm: [f64; 3],
}

const FAR: Lamp = Lamp {
    nail_mm: [5000.0, 0.0, 1500.0],
};

/// Errors of a hand: they wander by millimetres.
fn wander_m(time_s: f64, phase: f64) -> Vector3<f64> {
    let of = |rate: f64, phase: f64| 0.003 * (rate * time_s + phase).sin();
    Vector3::new(of(5.0, phase), of(7.0, 1.0 + phase), of(4.0, 2.0 + phase))
}

fn poses(track: usize, at_m: impl Fn(f64) -> Vector3<f64>) -> Vec<TakeEvent> {
    let times_s = (0..=(END_S * RATE_HZ) as usize).map(|count| count as f64 / RATE_HZ);
    times_s
        .map(|time_s| TakeEvent::Pose {
            track: TrackIndex(track),
            stream: 0,
            sample: PoseSample::from_pose(
                Stamp((time_s * 1e9).round() as i64),
                &Pose::from_parts(Translation3::from(at_m(time_s)), UnitQuaternion::identity()),
            ),
        })
        .collect()
}

/// A take of the ball, and of the lamp where there is one.
fn take(lamp: Option<&Lamp>) -> Vec<TakeEvent> {
    let from_m = Vector3::new(0.1, -0.2, 0.5);
    let fall = Vector3::new(0.0, 0.0, FALL_M_S2);
    let way_m = RADIUS_M - from_m.z - 0.5 * FALL_M_S2 * BOUNCE_S * BOUNCE_S;
    let thrown = Vector3::new(0.7, 0.2, way_m / BOUNCE_S);
    let at_bounce_m = from_m + thrown * BOUNCE_S + fall * (0.5 * BOUNCE_S * BOUNCE_S);
    let arrives = thrown + fall * BOUNCE_S;
    let leaves = Vector3::new(arrives.x, arrives.y, -0.7 * arrives.z);
    let mut events = poses(0, |time_s| {
        let after_s = time_s - BOUNCE_S;
        wander_m(time_s, 0.3)
            + match after_s > 0.0 {
                false => from_m + thrown * time_s + fall * (0.5 * time_s * time_s),
                true => at_bounce_m + leaves * after_s + fall * (0.5 * after_s * after_s),
            }
    });
    if let Some(lamp) = lamp {
        let centre_m = Vector3::from(lamp.nail_mm) * 1e-3 - Vector3::new(0.0, 0.0, 0.1);
        events.extend(poses(1, |time_s| centre_m + wander_m(time_s, 1.9)));
    }
    for (name, time_s) in [("start", 0.0), ("bounce", BOUNCE_S), ("end", END_S)] {
        events.push(TakeEvent::Mark(Mark {
            stamp: Stamp((time_s * 1e9_f64).round() as i64),
            event: Some(name.to_owned()),
        }));
    }
    events
}

fn scene(text: &str) -> Scene {
    scene_from_toml(text).expect("a valid scene")
}

fn finished(text: &str, lamp: Option<&Lamp>) -> Outcome {
    let outcome = Pipeline::of(scene(text), take(lamp)).finish(&mut ());
    outcome.expect("an estimate")
}

/// The same ball alone and beside a lamp: it comes out the same to the last bit, is verified, and it is told whether both
/// fit.
#[test]
fn a_lamp_far_away_changes_nothing_of_a_ball() {
    for of_ball in ["", "drag_quadratic_per_m = 0.1\nforce_m_s2 = [0, 0, 0.1]"] {
        for free in ["", "[[free]]\nquantity = \"bounce.restitution\"\n"] {
            let alone = finished(&ball_toml(of_ball, free), None);
            let text = ball_toml(of_ball, free) + &lamp_toml(FAR.nail_mm);
            let beside = finished(&text, Some(&FAR));
            let [one, other] = [&alone.estimate, &beside.estimate];
            assert_eq!(one.arcs, other.arcs, "{of_ball:?} {free:?}");
            assert_eq!(one.residuals, other.residuals);
            assert_eq!(one.parameters, other.parameters);
            for (alone, beside) in one.events.iter().zip(&other.events) {
                assert_eq!(alone, beside);
            }
            let [alone_of, of] = [&alone, &beside].map(|of| of.verification.as_ref());
            let (alone_of, of) = (alone_of.expect("checks"), of.expect("checks"));
            assert_eq!(alone_of.touches, of.touches);
            let [ball, lamp] = &of.single_shot.deviations[1..] else {
                panic!("an end of each: {:?}", of.single_shot.deviations);
            };
            assert_eq!(Some(ball), alone_of.single_shot.deviations.last());
            assert!(
                lamp.position_m < 1e-7 && lamp.angular_velocity_rad_s < 1e-5,
                "{lamp:?}"
            );
            assert!(of.balance.flight_energy < 1e-6, "{:?}", of.balance);
            assert_eq!(one.verdict, Verdict::Physical);
            assert_eq!(other.verdict, Verdict::Physical, "{:?}", other.doubts);
            let fit = other.fit.as_ref().expect("it is told");
            let of_ball_alone = one.fit.as_ref().expect("it is told");
            assert!(fit.whole.is_some() && fit.parts == of_ball_alone.parts);
            assert!(other.fits() != Fits::No);
            // Every sample is accounted for.
            let counts = &beside.counts;
            assert_eq!(
                counts.used + counts.dropped.values().sum::<usize>(),
                counts.read
            );
            assert!(counts.dropped.len() == alone.counts.dropped.len());
        }
    }
}

/// Each by itself goes through the other: that is seen.
#[test]
fn a_lamp_in_the_way_is_overlapped() {
    // Where the ball is after a fifth of a second, and its hook 100 mm above.
    let lamp = Lamp {
        nail_mm: [240.0, -160.0, 700.0],
    };
    let text = ball_toml("", "") + &lamp_toml(lamp.nail_mm);
    let outcome = finished(&text, Some(&lamp));
    let doubts = outcome.estimate.doubts.iter();
    let overlaps: Vec<_> = doubts
        .filter(|doubt| doubt.about == About::Overlap)
        .collect();
    assert_eq!(overlaps.len(), 1, "{:?}", outcome.estimate.doubts);
    assert!(overlaps[0].value > 0.005, "{overlaps:?}");
    assert!(outcome.estimate.verdict > Verdict::Physical);
    let deepest = outcome.verification.expect("checks").deepest;
    assert!(deepest.is_some_and(|deepest| deepest.depth_m == overlaps[0].value));
}

/// What ties a ball to a lamp makes them one group: a collision, a goal about both, gravity, an unknown tempo.
#[test]
fn groups_are_what_nothing_ties() {
    let groups = |further: &str, replaced: [&str; 2]| {
        let text = ball_toml("", further) + &lamp_toml(FAR.nail_mm);
        scene(&text.replace(replaced[0], replaced[1]))
            .groups()
            .len()
    };
    let none = ["", ""];
    assert_eq!(groups("", none), 2);
    assert_eq!(
        groups("[[free]]\nquantity = \"bounce.restitution\"\n", none),
        2
    );
    assert_eq!(
        groups("[[free]]\nquantity = \"ball.drag.linear\"\n", none),
        2
    );
    let goal = "[[goal]]\nevent = \"end\"\nbody = \"ball\"\nrelative_to = \"lamp\"\nposition_mm = [0, 0, 300]\n";
    assert_eq!(groups(goal, none), 1);
    assert_eq!(groups("", ["\"physical\"", "\"tempo\""]), 1);
    // A collision of both, and a law that collisions of both have.
    assert_eq!(
        groups(
            "",
            [
                "surface = \"table\"\nrestitution",
                "other = \"lamp\"\nrestitution"
            ]
        ),
        1
    );
}

/// What is refused of joined bodies is refused of what is tied to them, and not of a ball by itself.
#[test]
fn a_ball_by_itself_is_refused_nothing() {
    let read = |of_ball: &str, further: &str| {
        scene_from_toml(&(ball_toml(of_ball, further) + &lamp_toml(FAR.nail_mm)))
    };
    let gravity = "[[free]]\nquantity = \"gravity.z\"\n";
    assert!(read("", gravity).is_err());
    let scene = read("", "[[free]]\nquantity = \"ball.drag.linear\"\n").expect("valid");
    assert!(matches!(
        scene.parameters[0].quantity,
        Quantity::LinearDrag { .. }
    ));
    let tied = "[[goal]]\nevent = \"end\"\nbody = \"ball\"\nrelative_to = \"lamp\"\nposition_mm = [0, 0, 300]\n";
    let drag = "drag_linear_per_s = 0.1";
    assert!(read(drag, "").is_ok());
    let said = read(drag, tied)
        .expect_err("it flies with the lamp")
        .to_string();
    assert!(said.contains("neither force nor drag"), "{said}");
}

/// Collisions of the ball are counted, and all goes on until it rests: the ball on the table, the lamp on its hook.
#[test]
fn bounces_are_counted_beside_a_lamp_and_all_comes_to_rest() {
    let text = ball_toml("", "") + &lamp_toml(FAR.nail_mm);
    let counted = text.replace("restitution = 0.7", "count = [1, 3]\nrestitution = 0.7");
    assert!(counted != text);
    let counted = format!("settle_s = 20\n{counted}");
    let unnamed = take(Some(&FAR)).into_iter().map(|event| match event {
        TakeEvent::Mark(mark) => TakeEvent::Mark(Mark {
            event: None,
            ..mark
        }),
        pose => pose,
    });
    let outcome = Pipeline::of(scene(&counted), unnamed).finish(&mut ());
    let outcome = outcome.expect("an estimate");
    assert_eq!(outcome.estimate.verdict, Verdict::Physical);
    let names = outcome.scene.events.iter().map(|event| event.name.as_str());
    assert_eq!(names.collect::<Vec<_>>().len(), 3);
    let settled = outcome.settled.expect("it goes on");
    let [ball, lamp] = [0, 1].map(|link| {
        let poses = &settled.links[enact::motion::LinkIndex(link)].poses;
        poses.last().expect("poses").translation.vector
    });
    assert!((ball.z - RADIUS_M).abs() < 2e-3, "{ball}");
    let nail_m = Vector3::from(FAR.nail_mm) * 1e-3;
    assert!(((lamp - nail_m).norm() - 0.1).abs() < 1e-3, "{lamp}");
}
