//! Bodies in the hand, through the program: a ball on a racket, a box and a paddle, a die on a moving
//! ramp, against their truth.

use enact::config::scene_from_toml;
use enact::motion::{Fits, LinkIndex, Scene, Stamp, TakeEvent, TrackIndex, Verdict};
use enact::physics::flow;
use enact::pipeline::{Outcome, Pipeline, PipelineError};
use enact::sampling::SampledMotion;
use enact::segment::SegmentError;
use enact_tools::perform::held::{Game, HeldTake, SLOW, Seen, play, play_in};
use proptest::prelude::*;

const BALL: LinkIndex = LinkIndex(0);
const RACKET: LinkIndex = LinkIndex(1);

fn finished(take: &HeldTake) -> Outcome {
    let pipeline = Pipeline::of(take.scene.clone(), take.events.clone());
    pipeline.finish(&mut ()).expect("an estimate")
}

/// The first performances of a game from a seed on.
fn plays(game: Game, seen: &Seen, first: u64) -> impl Iterator<Item = HeldTake> {
    (first..).filter_map(move |seed| play(game, seen, seed))
}

fn scene_with(game: Game, more: &str) -> Scene {
    scene_from_toml(&format!("{}\n{more}", game.toml())).expect("a valid scene")
}

/// How far a parameter is from its true value, in its standard deviations.
fn deviations(outcome: &Outcome, name: &str, truth: f64) -> f64 {
    let parameters = &outcome.estimate.parameters;
    let found = parameters.iter().find(|parameter| parameter.name == name);
    let found = found.unwrap_or_else(|| panic!("no {name}"));
    let sd = found
        .sd
        .unwrap_or_else(|| panic!("{name} is not determined"));
    (found.value - truth) / sd
}

#[test]
fn games_are_told_as_they_were() {
    for game in Game::ALL {
        for take in plays(game, &Seen::default(), 100).take(2) {
            let outcome = finished(&take);
            let estimate = &outcome.estimate;
            let what = || {
                format!(
                    "{game:?} {:?} {:?} {:?}",
                    estimate.reason, estimate.doubts, estimate.fit
                )
            };
            assert_eq!(estimate.verdict, Verdict::Physical, "{}", what());
            let fit = estimate.fit.as_ref().expect("it was asked");
            assert_ne!(fit.fits, Fits::No, "{}", what());
            for (event, hit_s) in estimate.events.iter().zip(&take.hits_s) {
                let off_s = event.time_s - hit_s;
                let sd_s = event.sd_s.expect("determined");
                assert!(off_s.abs() < 4.0 * sd_s, "{off_s} {sd_s} {}", what());
                assert!(sd_s < 2e-3, "{sd_s}");
            }
            for (event, touching) in take.touching.iter().enumerate() {
                let collision = outcome.scene.events[event].kind.collision();
                let contacts = &collision.expect("a hit").contacts;
                assert_eq!(contacts, &vec![*touching], "{}", what());
            }
            if game == Game::Racket {
                let off = deviations(&outcome, "bounce.restitution", 0.85);
                assert!(off.abs() < 4.0, "{off}");
            }
            let checks = outcome.verification.as_ref().expect("it was checked");
            let balance = &checks.balance;
            assert!(balance.impact_energy < 1e-8, "{balance:?}");
            assert!(balance.impact_angular_momentum < 1e-8, "{balance:?}");
            assert!(checks.single_shot.missed.is_empty(), "{checks:?}");
            for (after, hit_s) in take.after.iter().zip(&take.hits_s) {
                let arcs = estimate.arcs.iter();
                let arc = arcs
                    .min_by(|a, b| {
                        let off = |start_s: f64| (start_s - hit_s).abs();
                        off(a.start_s).total_cmp(&off(b.start_s))
                    })
                    .expect("a flight");
                let body = outcome.scene.body_of(arc.mechanism);
                let state = flow::advance(
                    body,
                    &estimate.gravity_m_s2,
                    &arc.state,
                    hit_s - arc.epoch_s,
                );
                let off = state.minus(after);
                assert!(off.fixed_rows::<3>(0).norm() < 3e-3, "{off} {}", what());
                assert!(off.fixed_rows::<3>(6).norm() < 0.05, "{off} {}", what());
            }
        }
    }
}

#[test]
fn the_hand_goes_through_the_collisions_in_what_is_written() {
    let take = plays(Game::Racket, &Seen::default(), 200)
        .next()
        .expect("one");
    let outcome = finished(&take);
    let (scene, sketch, estimate) = (&outcome.scene, &outcome.sketch, &outcome.estimate);
    let motion = SampledMotion::new(scene, sketch, estimate, None, 240.0).expect("frames");
    let frames = &motion.estimates[RACKET];
    assert!(frames.len() > 200 && frames.windows(2).all(|two| two[0].stamp < two[1].stamp));
    assert!(motion.sketches[RACKET].len() > 100);
    let held = estimate.held_motion(RACKET).expect("it is held");
    assert_eq!(held.passed.len(), 3);
    for passed in &held.passed {
        let stamp = enact::sampling::stamp(motion.zero, passed.time_s);
        let frame = frames.iter().find(|frame| frame.stamp == stamp);
        let frame = frame.expect("a frame at the collision");
        assert!((frame.position_m - passed.state.position_m).norm() < 1e-12);
        // Where it was truly.
        let truth = take.swing.state(passed.time_s);
        let off = passed.state.minus(&truth);
        assert!(off.fixed_rows::<3>(0).norm() < 2e-3, "{off}");
        assert!(off.fixed_rows::<3>(6).norm() < 0.1, "{off}");
    }
    let [start_s, end_s] = estimate.extent_s().expect("flights");
    let first = enact::sampling::stamp(motion.zero, start_s);
    let last = enact::sampling::stamp(motion.zero, end_s);
    assert_eq!(
        (frames[0].stamp, frames[frames.len() - 1].stamp),
        (first, last)
    );
}

/// A racket at rest is a table in its place; one that moves evenly is that table seen from a train.
#[test]
fn at_rest_it_is_a_surface_and_from_a_train_too() {
    let seen = Seen {
        speed_m_s: 0.0,
        position_sd_m: 0.0,
        orientation_sd_rad: 0.0,
        ..Seen::default()
    };
    let take = plays(Game::Racket, &seen, 300).next().expect("one");
    let first = take.events.iter().find_map(|event| match event {
        TakeEvent::Pose { track, sample, .. } if *track == TrackIndex(1) => Some(*sample),
        _ => None,
    });
    let first = first.expect("a sample");
    let held = finished(&take);
    let [x, y, z, w] = first.quaternion_xyzw;
    let turn = nalgebra::UnitQuaternion::new_normalize(nalgebra::Quaternion::new(w, x, y, z));
    let pose = enact::math::Pose::from_parts(first.position_m.into(), turn);
    let pose = pose * take.scene.tracks[TrackIndex(1)].link_from_tracker.inverse();
    let point = pose * nalgebra::Point3::new(0.0, 0.0, 0.005) * 1000.0;
    let normal = pose.rotation * nalgebra::Vector3::z();
    let toml = Game::Racket.toml();
    let (before, rest) = toml
        .split_once("[[body]]\nname = \"racket\"")
        .expect("a racket");
    let (_, after) = rest.split_once("[[event]]").expect("events");
    let surface = format!(
        "[[surface]]\nname = \"racket\"\npoint_mm = [{:?}, {:?}, {:?}]\nnormal = [{:?}, {:?}, {:?}]\n\n[[event]]{}",
        point.x, point.y, point.z, normal.x, normal.y, normal.z, after
    );
    let surface = surface.replace("other = \"racket\"", "surface = \"racket\"");
    let surface = surface.replace("other_feature = \"end +z\"\n", "");
    let table = scene_from_toml(&format!("{before}{surface}")).expect("a valid scene");
    let of_ball = |event: &&TakeEvent| {
        !matches!(
            event,
            TakeEvent::Pose {
                track: TrackIndex(1),
                ..
            }
        )
    };
    let events: Vec<TakeEvent> = take.events.iter().filter(of_ball).cloned().collect();
    let fixed = Pipeline::of(table, events)
        .finish(&mut ())
        .expect("an estimate");
    let same = |one: &Outcome,
                other: &Outcome,
                within: f64,
                back: &dyn Fn(f64) -> nalgebra::Vector3<f64>| {
        assert_eq!(one.estimate.verdict, other.estimate.verdict);
        for (a, b) in one.estimate.events.iter().zip(&other.estimate.events) {
            assert!(
                (a.time_s - b.time_s).abs() < within,
                "{} {}",
                a.time_s,
                b.time_s
            );
        }
        for (a, b) in one.estimate.arcs.iter().zip(&other.estimate.arcs) {
            let body = one.scene.body_of(a.mechanism);
            let gravity = &one.estimate.gravity_m_s2;
            let there = flow::advance(body, gravity, &b.state, a.epoch_s - b.epoch_s);
            let off = a.state.position_m - back(a.epoch_s) - there.position_m;
            assert!(off.norm() < within, "{off}");
        }
        let [a, b] = [one, other].map(|outcome| outcome.estimate.parameters[0].value);
        assert!((a - b).abs() < within, "{a} {b}");
    };
    same(&held, &fixed, 1e-9, &|_| nalgebra::Vector3::zeros());
    // The same from a train.
    let train = nalgebra::Vector3::new(-1.5, 0.7, 0.4);
    let mut moving = take.clone();
    let origin = moving.events.iter().filter_map(|event| match event {
        TakeEvent::Pose { sample, .. } => Some(sample.stamp),
        TakeEvent::Mark(_) => None,
    });
    let origin: Stamp = origin.min().expect("samples");
    for event in &mut moving.events {
        if let TakeEvent::Pose { sample, .. } = event {
            sample.position_m += train * sample.stamp.seconds_since(origin);
        }
    }
    same(&finished(&moving), &held, 1e-9, &|time_s| train * time_s);
}

#[test]
fn a_tracker_whose_clock_or_place_is_off_is_told() {
    let free = "[[free]]\nquantity = \"racket.clock.offset\"\ninitial = 0\n";
    let scene = scene_with(Game::Racket, free);
    let seen = Seen {
        clock_offset_s: 0.012,
        ..Seen::default()
    };
    let take = (400..).find_map(|seed| play_in(&scene, Game::Racket, &seen, seed));
    let outcome = finished(&take.expect("one"));
    assert_eq!(outcome.estimate.verdict, Verdict::Physical);
    let off = deviations(&outcome, "racket.clock.offset", 0.012);
    assert!(off.abs() < 4.0, "{off} {:?}", outcome.estimate.parameters);
    // A tracker that sits 8 mm higher than the scene says.
    let free = "[[free]]\nquantity = \"racket.tracker.z\"\ninitial = 0\n";
    let mut scene = scene_with(Game::Racket, free);
    scene.tracks[TrackIndex(1)]
        .link_from_tracker
        .translation
        .vector
        .z += 0.008;
    let take = (400..).find_map(|seed| play_in(&scene, Game::Racket, &Seen::default(), seed));
    let mut take = take.expect("one");
    take.scene.tracks[TrackIndex(1)]
        .link_from_tracker
        .translation
        .vector
        .z -= 0.008;
    let outcome = finished(&take);
    let off = deviations(&outcome, "racket.tracker.z", 0.008);
    assert!(off.abs() < 4.0, "{off} {:?}", outcome.estimate.parameters);
    // With the correction in its place the scene's tracker is where it was.
    let z_m = outcome.scene.tracks[TrackIndex(1)]
        .link_from_tracker
        .translation
        .vector
        .z;
    assert!((z_m - 0.008).abs() < 4e-3, "{z_m}");
}

#[test]
fn acted_slowly_the_hand_has_the_speed_of_the_motion() {
    let toml = Game::Racket.toml().replace("\"physical\"", "\"tempo\"");
    let scene = scene_from_toml(&toml).expect("a valid scene");
    let take = (500..).find_map(|seed| play_in(&scene, Game::Racket, &Seen::default(), seed));
    let take = take.expect("one");
    let outcome = finished(&take);
    let estimate = &outcome.estimate;
    assert_eq!(estimate.verdict, Verdict::Physical, "{:?}", estimate.reason);
    let duration_s = estimate.duration.duration_s;
    let hits_s: Vec<f64> = estimate.events.iter().map(|event| event.time_s).collect();
    for (two, truth) in hits_s.windows(2).zip(take.hits_s.windows(2)) {
        let (found, true_s) = (two[1] - two[0], truth[1] - truth[0]);
        assert!(
            (found / true_s - 1.0).abs() < 0.1,
            "{found} {true_s} of {duration_s}, {SLOW}"
        );
    }
    let held = estimate.held_motion(RACKET).expect("it is held");
    for (passed, hit_s) in held.passed.iter().zip(&take.hits_s) {
        let truth = take.swing.state(*hit_s);
        let off = passed.state.velocity_m_s - truth.velocity_m_s;
        assert!(off.norm() < 0.3, "{off} of {}", truth.velocity_m_s);
    }
}

#[test]
fn a_die_comes_to_rest_beside_a_ramp_that_is_carried_on() {
    let scene = scene_from_toml(&format!("settle_s = 3\n{}", Game::Ramp.toml()));
    let scene = scene.expect("a valid scene");
    let take = (600..).find_map(|seed| play_in(&scene, Game::Ramp, &Seen::default(), seed));
    let outcome = finished(&take.expect("one"));
    let settled = outcome.settled.expect("it goes on");
    let ramp = &settled.links[RACKET].poses;
    assert_eq!(ramp.len(), settled.links[BALL].poses.len());
    // The ramp stands where its track ends.
    let last = &ramp[ramp.len() - 2..];
    assert!((last[0].translation.vector - last[1].translation.vector).norm() < 1e-9);
}

fn error_of(take: &HeldTake, keep: impl Fn(&TakeEvent) -> bool) -> PipelineError {
    let events = take.events.iter().filter(|event| keep(event)).cloned();
    let result = Pipeline::of(take.scene.clone(), events).finish(&mut ());
    result.expect_err("no estimate")
}

fn is_of_racket(event: &TakeEvent) -> bool {
    matches!(event, TakeEvent::Pose { track, .. } if *track == TrackIndex(1))
}

#[test]
fn a_hand_that_was_not_seen_is_an_error_that_says_where() {
    let take = plays(Game::Racket, &Seen::default(), 700)
        .next()
        .expect("one");
    let none = error_of(&take, |event| !is_of_racket(event));
    assert!(
        matches!(&none, PipelineError::Segment(SegmentError::NoSamplesOfBody { body, .. }) if body == "racket"),
        "{none}"
    );
    let mut kept = 0;
    let counts: Vec<bool> = take
        .events
        .iter()
        .map(|event| {
            kept += usize::from(is_of_racket(event));
            !is_of_racket(event) || kept < 4
        })
        .collect();
    let mut few = take.clone();
    let mut counts = counts.into_iter();
    few.events.retain(|_| counts.next().unwrap_or(false));
    let few = Pipeline::of(few.scene, few.events)
        .finish(&mut ())
        .expect_err("too few");
    assert!(few.to_string().contains("racket"), "{few}");
    // A gap about the second bounce.
    let first = take.events.iter().find_map(|event| match event {
        TakeEvent::Pose { sample, .. } => Some(sample.stamp),
        TakeEvent::Mark(_) => None,
    });
    let first = first.expect("samples");
    let gap = error_of(&take, |event| match event {
        TakeEvent::Pose { sample, .. } if is_of_racket(event) => {
            let since_s = sample.stamp.seconds_since(first);
            (since_s - take.hits_s[1]).abs() > 0.15
        }
        _ => true,
    });
    assert!(
        matches!(&gap, PipelineError::Segment(SegmentError::HeldUnseen { event, .. }) if event == "bounce 2"),
        "{gap}"
    );
    assert!(gap.to_string().contains("record the body there"), "{gap}");
    // Numbers that are none.
    let mut nothing = take.clone();
    for event in &mut nothing.events {
        if let TakeEvent::Pose { track, sample, .. } = event
            && *track == TrackIndex(1)
        {
            sample.position_m.y = f64::NAN;
        }
    }
    let error = Pipeline::of(nothing.scene, nothing.events).finish(&mut ());
    let error = error.expect_err("no estimate").to_string();
    assert!(
        error.contains("racket") && error.contains("not finite"),
        "{error}"
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    /// Whatever is missing or broken of the hand's stream, there is an error or a finite motion.
    #[test]
    fn broken_streams_of_the_hand_never_break_the_program(
        seed in 0..1000_u64,
        every in 1..40_usize,
        from in 0.0..1.0_f64,
        wild in 0.0..5.0_f64,
    ) {
        let Some(take) = play(Game::Paddle, &Seen::default(), seed) else {
            return Ok(());
        };
        let count = take.events.len();
        let mut events = Vec::new();
        for (index, mut event) in take.events.into_iter().enumerate() {
            if is_of_racket(&event) {
                let share = index as f64 / count as f64;
                if !index.is_multiple_of(every) || (share > from && share < from + 0.1) {
                    continue;
                }
                if let TakeEvent::Pose { sample, .. } = &mut event
                    && index.is_multiple_of(7)
                {
                    sample.position_m.x += wild;
                }
            }
            events.push(event);
        }
        match Pipeline::of(take.scene, events).finish(&mut ()) {
            Err(error) => prop_assert!(!error.to_string().is_empty()),
            Ok(outcome) => {
                let held = &outcome.estimate.held;
                let is_finite = held.iter().all(|held| held.state(0.3).is_finite());
                prop_assert!(outcome.estimate.verdict == Verdict::Failed || is_finite);
            }
        }
    }
}

#[test]
fn the_page_shows_the_scene_that_is_played() {
    let page = include_str!("../../docs/held.md");
    assert!(page.contains(Game::Racket.toml().trim_end()));
}
