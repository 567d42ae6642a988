//! What goals ask, what a scene only guesses, and contacts that last.

use enact::config::scene_from_toml;
use enact::motion::{
    About, Event, Fits, Goal, GoalTarget, LinkIndex, Mark, PoseSample, Quantity, Stamp, TakeEvent,
    TrackIndex, Verdict,
};
use enact::pipeline::Pipeline;
use enact_tools::case::Case;
use enact_tools::nonsense::Asked;
use enact_tools::nonsense::wrong::Wrong;
use enact_tools::perform::{Acting, Style};
use nalgebra::Vector3;

use super::thrown;

/// A throw whose end must be elsewhere: nothing in the scene is wrong.
#[test]
fn a_goal_that_asks_for_another_motion_is_no_mistake_of_the_scene() {
    for seed in 6100..6104 {
        let mut asked = Wrong::Nothing.asked(&thrown(), seed).expect("a throw");
        asked.scene.weights = enact::motion::Weights {
            position_m: 0.01,
            orientation_rad: 0.1,
        };
        let free = asked.answered().expect("an answer");
        let end = asked.scene.events.len() - 1;
        asked.scene.events[end] = Event {
            time: enact::motion::EventTime {
                is_free: Some(true),
                ..asked.scene.events[end].time
            },
            ..asked.scene.events[end].clone()
        };
        let last = free.estimate.arcs.last().expect("flights");
        let place_m = enact::physics::flow::position(
            &asked.scene.links[LinkIndex(0)].body,
            &asked.scene.gravity_m_s2,
            &last.state,
            last.end_s - last.epoch_s,
        );
        let there_m = place_m + Vector3::new(0.03, -0.02, 0.0);
        asked.scene.goals.push(Goal {
            event: end,
            link: LinkIndex(0),
            target: GoalTarget::PositionWithin {
                lower_m: there_m,
                upper_m: there_m,
            },
        });
        let outcome = asked.answered().expect("an answer");
        let estimate = &outcome.estimate;
        assert_eq!(
            estimate.verdict,
            Verdict::Physical,
            "{seed}: {:?}",
            estimate.doubts
        );
        assert!(
            estimate.suspects.is_empty(),
            "{seed}: {:?}",
            estimate.suspects
        );
        let led = estimate
            .doubts
            .iter()
            .find(|doubt| doubt.about == About::Led);
        assert!(led.expect("it is said").value > 2.0, "{seed}");
        let freed = asked.freed().expect("an answer").freed;
        assert!(freed.is_empty(), "{seed}: nothing is wrong: {freed:?}");
    }
}

/// A pencil in a tempo of its own, in a steady hand.
fn pencil(seed: u64) -> Asked {
    let acting = Acting {
        distortion: 0.25,
        ..Acting::default()
    };
    let case = Case::pencil(Style::Tip, &acting, seed);
    Asked {
        scene: case.scene().clone(),
        events: case.performance.events.clone(),
    }
}

/// In a tempo that is not known a restitution that is guessed 0.1 wrong moves the bounce by tens of milliseconds: the
/// performance tells it.
#[test]
fn a_guessed_restitution_is_told_in_an_unknown_tempo() {
    for seed in 6200..6203 {
        let mut asked = pencil(seed);
        let right = asked.answered().expect("an answer").estimate;
        assert!(right.suspects.is_empty(), "{seed}: {:?}", right.suspects);
        assert_eq!(right.fits(), Fits::Yes, "{seed}");
        let law = asked.scene.contact_laws.keys().next().expect("a law");
        let truth = asked.scene.contact_laws[law].restitution;
        asked.scene.contact_laws[law].restitution -= 0.1;
        let estimate = asked.answered().expect("an answer").estimate;
        assert_ne!(estimate.fits(), Fits::Yes, "{seed}");
        let first = &estimate.suspects.first().expect("a suspect").values;
        assert!(
            matches!(first[0].0, Quantity::Restitution { .. }),
            "{seed}: {first:?}"
        );
        let freed = asked.freed().expect("an answer");
        let found = &freed.estimate.parameters[0];
        let sd = found.sd.expect("it is determined");
        assert!(
            (found.value - truth).abs() < 4.0 * sd && sd < 0.05,
            "{seed}: {found:?}"
        );
    }
}

/// What is said of how times lean on a guess is what another guess makes of them.
#[test]
fn times_lean_on_a_guess_as_another_guess_moves_them() {
    let mut most_s: f64 = 0.0;
    for seed in 6210..6214 {
        let mut asked = pencil(seed);
        let bounce = |asked: &Asked| {
            let outcome = asked.answered().expect("an answer");
            let mut events = outcome.estimate.events.into_iter();
            let bounce = events.find(|event| event.leaning.is_some());
            bounce.expect("its restitution is a guess")
        };
        let as_said = bounce(&asked);
        let leaning = as_said.leaning.expect("a guess");
        let law = asked.scene.contact_laws.keys().next().expect("a law");
        assert_eq!(leaning.quantity, Quantity::Restitution { law });
        assert_eq!(leaning.value, asked.scene.contact_laws[law].restitution);
        // A tenth of the change, for it is said to first order and with the hand as it is.
        asked.scene.contact_laws[law].restitution += 0.1 * leaning.change;
        let moved_s = bounce(&asked).time_s - as_said.time_s;
        let said_s = 0.1 * leaning.later_s;
        assert!(
            (moved_s - said_s).abs() < 0.6 * moved_s.abs().max(5e-4),
            "{seed}: {moved_s} {said_s}"
        );
        most_s = most_s.max(leaning.later_s.abs());
    }
    assert!(most_s > 0.002, "{most_s}");
}

const BALL_TOML: &str = r#"
name = "a soft ball"
hand = "none"
[timing]
stamps = "physical"
[[body]]
name = "ball"
shape = { kind = "sphere", radius_mm = 30 }
mass_g = 60
restitution = 0.7
[[surface]]
name = "mat"
point_mm = [0, 0, 0]
normal = [0, 0, 1]
[[event]]
name = "hit"
kind = "collision"
body = "ball"
surface = "mat"
[[event]]
name = "end"
kind = "end"
[[free]]
quantity = "ball.restitution"
"#;

/// A ball that stays on the mat for 20 ms and leaves at 0.7 of its speed: the mat is not deeper than the scene says.
#[test]
fn a_contact_that_lasts_is_suspected_beside_the_height() {
    let (lasts_s, restitution, speed_m_s) = (0.02, 0.7, 3.6);
    let height_m = |time_s: f64| {
        let (hit_s, gravity_m_s2) = (speed_m_s / 9.80665, 9.80665);
        let since_s = time_s - hit_s;
        match since_s {
            _ if since_s < 0.0 => 0.03 + 0.5 * gravity_m_s2 * (hit_s * hit_s - time_s * time_s),
            _ if since_s < lasts_s => 0.03,
            _ => {
                let free_s = since_s - lasts_s;
                0.03 + restitution * speed_m_s * free_s - 0.5 * gravity_m_s2 * free_s * free_s
            }
        }
    };
    let mut events: Vec<TakeEvent> = (0..200)
        .map(|sample| {
            let time_s = sample as f64 / 240.0;
            // A tenth of a millimetre of what no model has.
            let wobble_m = 1e-4 * (37.0 * sample as f64).sin();
            TakeEvent::Pose {
                track: TrackIndex(0),
                stream: 0,
                sample: PoseSample::new(
                    Stamp((1e9 * time_s) as i64),
                    Vector3::new(wobble_m, -wobble_m, height_m(time_s) + wobble_m),
                    [0.0, 0.0, 0.0, 1.0],
                ),
            }
        })
        .collect();
    let mark = |time_s: f64, name: &str| {
        TakeEvent::Mark(Mark {
            stamp: Stamp((1e9 * time_s) as i64),
            event: Some(name.into()),
        })
    };
    events.push(mark(speed_m_s / 9.80665 + 0.01, "hit"));
    events.push(mark(0.82, "end"));
    let scene = scene_from_toml(BALL_TOML).expect("a scene");
    let pipeline = Pipeline::of(scene, events);
    let outcome = pipeline.finish(&mut ()).expect("an estimate");
    let (first, others) = outcome.estimate.suspects.split_first().expect("suspects");
    let rivals = others.iter().filter(|other| first.is_rivalled_by(other));
    let mut alike = [first].into_iter().chain(rivals);
    let lasting = alike.find_map(|suspect| match suspect.values[..] {
        [(Quantity::ContactDuration { .. }, value_s)] => Some(value_s),
        _ => None,
    });
    let lasting_s = lasting.expect("the contact is suspected as much as anything");
    assert!((lasting_s - lasts_s).abs() < 0.003, "{lasting_s}");
    let freed = pipeline
        .with_free_auto(true)
        .finish(&mut ())
        .expect("an estimate");
    assert!(
        freed.freed.is_empty(),
        "height and duration are not told apart: {:?}",
        freed.freed
    );
}
