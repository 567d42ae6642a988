//! Bodies and trees that nothing ties to each other, through the pipeline: each comes out as it does alone.

use enact::config::scene_from_toml;
use enact::motion::{About, Fits, LinkIndex, Mark, Quantity, TakeEvent, Verdict};
use enact::pipeline::{Outcome, Pipeline};
use enact_tools::beside::Beside;
use nalgebra::Vector3;

fn finished(text: &str, events: Vec<TakeEvent>) -> Outcome {
    let scene = scene_from_toml(text).expect("a valid scene");
    let outcome = Pipeline::of(scene, events).finish(&mut ());
    outcome.expect("an estimate")
}

/// The same ball alone and beside a lamp: it comes out the same to the last bit, is verified, and it is told whether both
/// fit.
#[test]
fn a_lamp_far_away_changes_nothing_of_a_ball() {
    let drag = "drag_quadratic_per_m = 0.1\nforce_m_s2 = [0, 0, 0.1]";
    let free = "[[free]]\nquantity = \"bounce.restitution\"\n";
    let (mut physical, mut fits, mut right) = (0, 0, 0);
    for seed in 8500..8516 {
        let of = Beside::of(seed);
        for (of_ball, further) in [("", ""), (drag, ""), ("", free)] {
            let alone = finished(&of.ball_toml(of_ball, further), of.take_of_ball());
            let beside = finished(&of.toml(of_ball, further), of.take());
            is_as_alone(&alone, &beside);
            let is_right = of_ball.is_empty();
            right += usize::from(is_right);
            physical += usize::from(is_right && beside.estimate.verdict == Verdict::Physical);
            fits += usize::from(is_right && beside.estimate.fits() != Fits::No);
        }
    }
    assert!(
        8 * physical >= 7 * right && 8 * fits >= 7 * right,
        "{physical} {fits} of {right}"
    );
}

fn is_as_alone(alone: &Outcome, beside: &Outcome) {
    let [one, other] = [&alone.estimate, &beside.estimate];
    assert_eq!(one.arcs, other.arcs);
    assert_eq!(one.residuals, other.residuals);
    assert_eq!(one.parameters, other.parameters);
    assert_eq!(one.events, other.events);
    let [alone_of, of] = [alone, beside].map(|of| of.verification.as_ref());
    let (alone_of, of) = (alone_of.expect("checks"), of.expect("checks"));
    assert_eq!(alone_of.touches, of.touches);
    let Some(([lamp], before)) = of
        .single_shot
        .deviations
        .split_last_chunk::<1>()
        .map(|(a, b)| (b, a))
    else {
        panic!("an end of the lamp");
    };
    assert_eq!(before, alone_of.single_shot.deviations);
    assert!(
        lamp.position_m < 1e-7 && lamp.angular_velocity_rad_s < 1e-5,
        "{lamp:?}"
    );
    assert!(of.balance.flight_energy < 1e-6, "{:?}", of.balance);
    assert_eq!(other.trees.len(), 1);
    assert_eq!((one.verdict, &one.doubts), (other.verdict, &other.doubts));
    let fit = other.fit.as_ref().expect("it is told");
    let fit_alone = one.fit.as_ref().expect("it is told");
    // Of the two, what tells less: the lamp has a joint, the ball none.
    assert!(fit.shown_m.is_some() && fit_alone.shown_m.is_none());
    assert!(fit.by_noise.probability <= fit_alone.by_noise.probability);
    assert!(other.fits() >= one.fits());
    // Every sample is accounted for.
    let counts = &beside.counts;
    assert_eq!(
        counts.used + counts.dropped.values().sum::<usize>(),
        counts.read
    );
    assert_eq!(counts.dropped, alone.counts.dropped);
}

/// Each by itself goes through the other: that is seen.
#[test]
fn a_lamp_in_the_way_is_overlapped() {
    let mut of = Beside::of(8510);
    // Its middle is where the ball is after a fifth of a second.
    let middle_m = of.ball_m(0.2);
    of.nail_mm = [middle_m.x, middle_m.y, middle_m.z + 0.1].map(|m| 1e3 * m);
    let outcome = finished(&of.toml("", ""), of.take());
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
        let text = Beside::of(8520).toml("", further);
        let text = text.replace(replaced[0], replaced[1]);
        scene_from_toml(&text)
            .expect("a valid scene")
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
    let read =
        |of_ball: &str, further: &str| scene_from_toml(&Beside::of(8530).toml(of_ball, further));
    let gravity = "[[free]]\nquantity = \"gravity.z\"\n";
    assert!(read("", gravity).is_ok());
    assert!(read("", "[[free]]\nquantity = \"lamp.clock.rate\"\n").is_err());
    let scene = read("", "[[free]]\nquantity = \"ball.drag.linear\"\n").expect("valid");
    assert!(matches!(
        scene.parameters[0].quantity,
        Quantity::LinearDrag { .. }
    ));
    let tied = "[[goal]]\nevent = \"end\"\nbody = \"ball\"\nrelative_to = \"lamp\"\nposition_mm = [0, 0, 300]\n";
    let clock = |further: &str| {
        read(
            "",
            &format!("[[free]]\nquantity = \"ball.clock.rate\"\n{further}"),
        )
    };
    assert!(clock("").is_ok());
    let said = clock(tied).expect_err("it flies with the lamp").to_string();
    assert!(said.contains("clocks are given"), "{said}");
    // Both may be hit by what gives energy.
    for further in ["", tied] {
        let text = Beside::of(8530).toml("", further);
        let with = text.replace("restitution =", "bumper = true\nrestitution =");
        assert!(with != text);
        assert!(scene_from_toml(&with).is_ok());
    }
}

/// Collisions of the ball are counted, and all goes on until it rests: the ball on the table, the lamp on its hook.
#[test]
fn bounces_are_counted_beside_a_lamp_and_all_comes_to_rest() {
    let of = Beside::of(8540);
    let text = of.toml("", "");
    let counted = text.replace("restitution =", "count = [1, 3]\nrestitution =");
    assert!(counted != text);
    let counted = format!("settle_s = 20\n{counted}");
    let unnamed = of.take().into_iter().map(|event| match event {
        TakeEvent::Mark(mark) => TakeEvent::Mark(Mark {
            event: None,
            ..mark
        }),
        pose => pose,
    });
    let counted = scene_from_toml(&counted).expect("a valid scene");
    let outcome = Pipeline::of(counted, unnamed).finish(&mut ());
    let outcome = outcome.expect("an estimate");
    let doubts = &outcome.estimate.doubts;
    assert_eq!(outcome.estimate.verdict, Verdict::Physical, "{doubts:?}");
    let names = outcome.scene.events.iter().map(|event| event.name.as_str());
    assert_eq!(names.collect::<Vec<_>>().len(), 3);
    let settled = outcome.settled.expect("it goes on");
    let [ball, lamp] = [0, 1].map(|link| {
        let poses = &settled.links[LinkIndex(link)].poses;
        poses.last().expect("poses").translation.vector
    });
    assert!((ball.z - 0.02).abs() < 2e-3, "{ball}");
    let nail_m = Vector3::from(of.nail_mm) * 1e-3;
    assert!(((lamp - nail_m).norm() - 0.1).abs() < 1e-3, "{lamp}");
}
