//! Motions keep out of things: a hand's wander that leads a cube into a wall is mended, a motion that meets nothing stays as
//! it is, and one that can only be had through a wall is never called physical.

use enact::math::Pose;
use enact::motion::{
    About, Doubt, Fits, Goal, GoalTarget, LinkIndex, Obstacle, Scene, TakeEvent, Verdict,
};
use enact::physics::Shape;
use enact::pipeline::{Outcome, Pipeline, Preview};
use enact::verify::overlaps;
use enact_tools::case::Case;
use enact_tools::goals::{Pair, Quantity, Set};
use enact_tools::perform::{Acting, Truth, bounces, hat_box};
use nalgebra::Vector3;

const CUBE: LinkIndex = LinkIndex(0);
/// How far the true cube passes a wall \[m\].
const PASSES_M: f64 = 0.001;
/// Half the thickness of a wall \[m\].
const HALF_M: f64 = 0.02;
/// Greatest share by which a motion is farther from its samples for being kept out.
const FARTHER: f64 = 1.2;

fn wall(name: &str, middle_m: Vector3<f64>) -> Obstacle {
    Obstacle {
        name: name.to_owned(),
        shape: Shape::Cuboid {
            half_extents_m: Vector3::new(3.0, HALF_M, 3.0),
        },
        world_from_shape: Pose::from_parts(middle_m.into(), nalgebra::UnitQuaternion::identity()),
    }
}

/// How far the corners of the true cube reach along y \[m\].
fn reach_m(truth: &Truth) -> f64 {
    const TIMES: usize = 4000;
    let features = &truth.scene.links[CUBE].features;
    let times_s = (0..=TIMES).map(|at| at as f64 * truth.duration_s / TIMES as f64);
    let reaches = times_s.flat_map(|time_s| {
        let pose = truth.world_from_body(CUBE, time_s);
        let places = features
            .iter()
            .map(move |corner| pose * nalgebra::Point3::from(corner.geometry.place_m()));
        places.map(|place| place.y)
    });
    reaches.fold(f64::NEG_INFINITY, f64::max)
}

/// A cube that bounces once and passes beside a wall, as a hand acts it.
fn beside_a_wall(seed: u64, acting: &Acting) -> Case {
    let mut truth = bounces(1, seed).expect("a cube that bounces");
    if acting.is_timing_known() {
        truth.scene.timing = enact::motion::Timing::Known;
    }
    let side_m = reach_m(&truth) + PASSES_M + HALF_M;
    truth
        .scene
        .obstacles
        .push(wall("wall", Vector3::new(0.0, side_m, 0.0)));
    Case::new(&truth, acting, seed)
}

fn grave(outcome: &Outcome) -> Vec<&Doubt> {
    let doubts = outcome.estimate.doubts.iter();
    doubts
        .filter(|doubt| doubt.about.best() != Verdict::Physical)
        .collect()
}

fn overlap_m(outcome: &Outcome) -> f64 {
    let found = overlaps(&outcome.scene, &outcome.estimate, &mut ());
    found.iter().map(|of| of.depth_m).fold(0.0, f64::max)
}

#[test]
fn a_cube_that_a_hand_led_into_a_wall_is_kept_out_of_it() {
    for acting in [Acting::timing_known(), Acting::default()] {
        let mut mended = 0;
        for seed in 70..76 {
            let case = beside_a_wall(seed, &acting);
            let before = case.estimated(&mut ()).expect("an estimate");
            let after = case.pipeline().finish(&mut ()).expect("an answer");
            assert_eq!(grave(&after), Vec::<&Doubt>::new(), "{seed}");
            assert_eq!(after.estimate.verdict, Verdict::Physical, "{seed}");
            let tolerance_m = after.scene.tolerance_m;
            assert!(overlap_m(&after) <= tolerance_m, "{seed}");
            let mut doubts = after.estimate.doubts.iter();
            if doubts.any(|of| of.about == About::EndTouches) {
                // It meets the wall at the end, which is marked a moment later: nothing is kept out.
                continue;
            }
            let is_told = after
                .estimate
                .doubts
                .iter()
                .any(|of| of.about == About::KeptOut);
            if overlap_m(&before) <= tolerance_m {
                assert_eq!(before.estimate.arcs, after.estimate.arcs, "{seed}");
                assert!(!is_told, "{seed}");
                continue;
            }
            mended += 1;
            assert!(is_told, "{seed}: what is only just passed is said");
            let [free, kept] = [&before, &after].map(|of| of.estimate.objective);
            assert!(
                kept >= free * (1.0 - 1e-9) && kept <= FARTHER * free,
                "{seed}: {free} {kept}"
            );
        }
        assert!(mended >= 2, "{mended} of six were led into the wall");
    }
}

#[test]
fn a_motion_that_meets_nothing_stays_as_it_is() {
    let acting = Acting::timing_known();
    let case = beside_a_wall(70, &acting);
    let answer = |walls: Vec<Obstacle>| {
        let mut scene: Scene = case.scene().clone();
        scene.obstacles = walls;
        let take: Vec<TakeEvent> = case.performance.events.clone();
        let outcome = Pipeline::of(scene, take)
            .finish(&mut ())
            .expect("an answer");
        outcome.estimate
    };
    let far = wall("far wall", Vector3::new(0.0, 9.0, 0.0));
    assert_eq!(answer(Vec::new()), answer(vec![far]));
}

/// The end is asked for within the wall.
#[test]
fn what_can_only_be_had_through_a_wall_is_not_physical() {
    let case = beside_a_wall(70, &Acting::timing_known());
    let mut scene = case.scene().clone();
    let end = scene.events.len() - 1;
    let truth = &case.performance.truth;
    let mut pose = truth.world_from_body(CUBE, truth.duration_s);
    let inward_m = scene.obstacles[0].world_from_shape.translation.y - HALF_M - pose.translation.y;
    pose.translation.y += inward_m;
    scene.goals.push(Goal {
        event: end,
        link: CUBE,
        target: GoalTarget::Pose {
            world_from_body: pose,
        },
    });
    let pipeline = Pipeline::of(scene, case.performance.events.clone());
    let outcome = pipeline.finish(&mut ()).expect("an answer");
    assert_ne!(outcome.estimate.verdict, Verdict::Physical);
    assert!(
        grave(&outcome)
            .iter()
            .any(|doubt| doubt.about == About::Overlap)
    );
}

/// A hat and a box that land at five metres a second, whose end is marked to within some milliseconds: the motion goes on
/// into the table until its mark. Of the plate in the hat several corners come down at once.
#[test]
fn a_motion_ends_where_it_touches_if_its_end_is_marked_later() {
    let (mut early, mut well) = (0, 0);
    for seed in 70..78 {
        let mut truth = hat_box::truth();
        truth.scene.goals.clear();
        let case = Case::new(&truth, &Acting::timing_known(), seed);
        let outcome = case.pipeline().finish(&mut ()).expect("an answer");
        let is_well = grave(&outcome).is_empty() && outcome.estimate.fits() != Fits::No;
        well += usize::from(is_well);
        let end = outcome.estimate.events.last().expect("an end");
        let doubts = &outcome.estimate.doubts;
        let Some(told) = doubts.iter().find(|of| of.about == About::EndTouches) else {
            continue;
        };
        early += 1;
        let made_s = outcome.marks_made_s[end.event].expect("a mark");
        assert!((made_s - end.time_s - told.value).abs() < 1e-6, "{seed}");
        // The performance ends about there: its mark was later, or the box met the hat before.
        let off_s = end.time_s - truth.duration_s;
        assert!(off_s.abs() < 0.04, "{seed}: {off_s}");
    }
    assert!(early >= 3, "{early} of eight");
    assert!(well >= 6, "{well} of eight");
}

/// The second bounce of a cube of which the scene knows one is too long before the end for a mark.
#[test]
fn a_bounce_that_the_scene_does_not_know_is_no_early_end() {
    for seed in 70..74 {
        let truth = bounces(2, seed).expect("a cube that bounces twice");
        let case = Case::new(&truth, &Acting::timing_known(), seed);
        let mut scene = case.scene().clone();
        scene.events.remove(1);
        let mut marks = 0;
        let mut is_of_second = |event: &TakeEvent| {
            marks += usize::from(event.mark().is_some());
            event.mark().is_some() && marks == 2
        };
        let mut events = case.performance.events.clone();
        events.retain(|event| !is_of_second(event));
        let outcome = Pipeline::of(scene, events).finish(&mut ());
        let outcome = outcome.expect("an answer");
        let is_well = outcome.estimate.verdict == Verdict::Physical
            && outcome.estimate.fits() != Fits::No
            && outcome.estimate.suspects.is_empty();
        assert!(!is_well, "{seed}: {:?}", outcome.estimate.doubts);
    }
}

/// Goals that lead a motion far away are met by one that nothing else speaks against.
#[test]
fn what_goals_lead_far_away_is_no_misfit() {
    let (mut far, mut all) = (0, 0);
    let asked = [Quantity::Turn, Quantity::BouncedSpin];
    for (seed, quantity) in (60_030..60_045).flat_map(|seed| asked.map(|of| (seed, of))) {
        let Some(mut pair) = Pair::of_one(seed) else {
            continue;
        };
        let mut truth = pair.truth.clone();
        let goal = pair.goal((quantity, Set::Exact), true, None);
        truth.scene.goals.push(goal.expect("a goal"));
        let acting = Acting {
            distortion: 2.0,
            ..Acting::timing_known()
        };
        let outcome = Case::new(&truth, &acting, seed).pipeline().finish(&mut ());
        let estimate = outcome.expect("an answer").estimate;
        let has = |about: About| estimate.doubts.iter().any(|of| of.about == about);
        all += 1;
        if has(About::Led) && has(About::Ambiguity) && estimate.verdict == Verdict::Physical {
            far += 1;
            assert_ne!(estimate.fits(), Fits::No, "{seed}");
        }
    }
    assert!(far >= 1, "{far} of {all}");
}

#[test]
fn a_preview_says_that_it_goes_into_something() {
    let said = (70..76).map(|seed| {
        let case = beside_a_wall(seed, &Acting::timing_known());
        let mut preview = Preview::new(case.scene().clone());
        for event in &case.performance.events {
            preview.push(event.clone());
        }
        let previewed = preview
            .estimate(&mut ())
            .expect("an estimate")
            .expect("a motion");
        let doubts = &previewed.outcome.estimate.doubts;
        let is_said = doubts.iter().any(|doubt| doubt.about == About::Overlap);
        let tolerance_m = previewed.outcome.scene.tolerance_m;
        assert_eq!(
            is_said,
            overlap_m(previewed.outcome) > tolerance_m,
            "{seed}"
        );
        is_said
    });
    assert!(said.filter(|is_said| *is_said).count() >= 2);
}
