//! Bodies joined in trees: pendulums and a chain from the path of one point, through the program.

use std::path::Path;

use enact::config::scene_from_toml;
use enact::motion::{
    About, Covariance, Estimate, GoalSet, GoalTarget, LinkIndex, Performer, TakeEvent, Verdict,
    Weighing,
};
use enact::physics::tree::Snapshot;
use enact::pipeline::{Outcome, Pipeline};
use enact::sampling::SampledMotion;
use enact::verify;
use enact_tools::replay::Program;
use enact_tools::trees::{self, Jointed, Kind, TreeActing, TreePerformance};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use tempfile::TempDir;

const ENACT: Program = Program(env!("CARGO_BIN_EXE_enact"));

fn finished(performance: &TreePerformance) -> Outcome {
    let events = performance.events.iter().cloned();
    let outcome = Pipeline::of(performance.scene.clone(), events).finish(&mut ());
    outcome.expect("an estimate")
}

/// A usual hand, and nothing asked but where the tip ends.
fn hung() -> TreeActing {
    TreeActing {
        asks_start: false,
        ..TreeActing::of(1.0)
    }
}

const PENDULUMS: [Kind; 3] = [
    Kind::pendulum(2, Jointed::Pin),
    Kind::pendulum(2, Jointed::Universal),
    Kind::pendulum(2, Jointed::Ball),
];

/// From exact samples of its tip a pendulum's motion comes back, as far as they determine it.
#[test]
fn an_exact_sketch_gives_the_motion_back() {
    let exact = TreeActing {
        wander_m: 0.0,
        noise_m: 0.0,
        ..hung()
    };
    for kind in &PENDULUMS[..2] {
        for seed in 8000..8003 {
            let performance = trees::perform(kind, &exact, seed);
            let outcome = finished(&performance);
            let estimate = &outcome.estimate;
            assert_eq!(estimate.verdict, Verdict::Physical, "{kind:?} {seed}");
            let tree = performance.tree();
            let found = &estimate.trees[0].knots[0].state;
            let off = tree.minus(found, &performance.truth);
            let off = off.iter().fold(0.0, |most: f64, of| most.max(of.abs()));
            // The prior on the rates draws by as much.
            assert!(off < 0.02, "{kind:?} {seed}: {off}");
        }
    }
}

/// Rough sketches: the motion is nearer to the samples than the true one, all goals are met, and the joints hold
/// in every frame that is written.
#[test]
fn pendulums_meet_their_goals_and_stay_joined() {
    for kind in &PENDULUMS {
        for seed in 8010..8014 {
            let mut performance = trees::perform(kind, &hung(), seed);
            for performer in [Performer::Nobody, Performer::Unsaid] {
                performance.scene.performer = performer;
                let outcome = finished(&performance);
                let estimate = &outcome.estimate;
                assert_eq!(estimate.verdict, Verdict::Physical, "{kind:?} {seed}");
                for goal in performance.scene.goals_attained(estimate) {
                    assert!(goal.is_met(), "{kind:?} {seed}: {goal:?}");
                }
                let truth = performance.truth_cost();
                let is_nearer = estimate.objective < truth;
                assert!(
                    is_nearer || performer == Performer::Unsaid,
                    "{kind:?} {seed}: {truth}"
                );
                stay_joined(&performance, &outcome);
            }
        }
    }
}

/// The end of each rod is where the next begins.
fn stay_joined(performance: &TreePerformance, outcome: &Outcome) {
    let motion = SampledMotion::new(
        &outcome.scene,
        &outcome.sketch,
        &outcome.estimate,
        None,
        100.0,
    );
    let motion = motion.expect("frames");
    let end = |link: usize, frame: usize, up: f64| {
        let sample = &motion.estimates[LinkIndex(link)][frame];
        let [x, y, z, w] = sample.quaternion_xyzw;
        let turn = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z));
        sample.position_m + turn * Vector3::new(0.0, 0.0, up * 0.5 * trees::ROD_M)
    };
    let frames = motion.estimates[LinkIndex(0)].len();
    assert!(frames > 80, "{frames}");
    for link in 1..performance.scene.links.len() {
        for frame in 0..frames {
            let apart_m = (end(link - 1, frame, -1.0) - end(link, frame, 1.0)).norm();
            assert!(apart_m < 1e-9, "{link} {frame}: {apart_m}");
        }
    }
}

/// The paper's chain: its whole configuration at the start and the place of its end are hard, one point is seen.
#[test]
fn the_chain_flies_to_its_hook_and_what_nothing_tells_is_named() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let kept = root.join("recordings/chain.mcap");
    let folder = TempDir::new().unwrap();
    let (name, performance) = trees::kept();
    let again = folder.path().join(name);
    performance.write(&again).unwrap();
    assert!(std::fs::read(&kept).unwrap() == std::fs::read(&again).unwrap());
    let report = ENACT.report(&again, &[]).said;
    assert_eq!(report["verdict"], "physical", "{report}");
    let goals = report["goals"].as_array().unwrap();
    assert_eq!(goals.len(), 4, "{report}");
    assert!(goals.iter().all(|goal| goal["is_met"] == true), "{report}");
    let open = report["undetermined"].as_array().unwrap();
    assert!(open.iter().any(|name| name == "spin of rod 1"), "{report}");
    assert!(report["residual_mm"].as_f64().unwrap() < 20.0, "{report}");
}

/// A sketch that no pendulum moves along is not called physical.
#[test]
fn what_no_pendulum_does_is_doubted() {
    let mut performance = trees::perform(&PENDULUMS[0], &hung(), 8020);
    for (index, event) in performance.events.iter_mut().enumerate() {
        if let TakeEvent::Pose { sample, .. } = event {
            // Far out of its plane and its reach.
            sample.position_m += Vector3::new(0.3, 0.0, 0.004 * index as f64);
        }
    }
    let estimate = finished(&performance).estimate;
    assert_ne!(estimate.verdict, Verdict::Physical);
    let mut doubts = estimate.doubts.iter();
    assert!(
        estimate.verdict == Verdict::Failed || doubts.any(|doubt| doubt.about == About::Residual)
    );
}

/// A goal that weighs pulls, and does not hold: the less deviation, the nearer.
#[test]
fn a_wish_draws_as_much_as_it_weighs() {
    let performance = trees::perform(&PENDULUMS[0], &hung(), 8060);
    let mut off_m = Vec::new();
    for sd_m in [1e-3, 1e-2, 1.0] {
        let mut wished = performance.clone();
        let GoalTarget::Condition(condition) = &mut wished.scene.goals[0].target else {
            panic!("a goal for the tip");
        };
        let GoalSet::Box { lower, upper } = &mut condition.set else {
            panic!("a place");
        };
        // A hand's width from where it ended.
        lower.z += 0.05;
        upper.z += 0.05;
        condition.sd = Some(sd_m);
        let estimate = finished(&wished).estimate;
        assert_eq!(estimate.verdict, Verdict::Physical, "{sd_m}");
        let attained = wished.scene.goals_attained(&estimate);
        off_m.push(attained[0].distance);
    }
    assert!(off_m[0] > 1e-9, "{off_m:?}");
    // A hand seldom strays as fast as a pendulum swings: where it would have to, the sketch draws as well.
    assert!(off_m[0] < 0.9 * off_m[1], "{off_m:?}");
    assert!(off_m[1] < off_m[2], "{off_m:?}");
}

#[test]
fn scenes_of_joined_bodies_that_make_no_sense_are_refused() {
    let whole = trees::perform(&PENDULUMS[1], &hung(), 8040).scene_toml;
    assert!(scene_from_toml(&whole).is_ok());
    for (from, to, said) in [
        (
            "child = \"rod 2\"",
            "child = \"rod 1\"",
            "hangs from itself",
        ),
        ("parent = \"rod 1\"", "parent = \"rod 3\"", "rod 3"),
        (
            "kind = \"universal\"",
            "kind = \"hinge\"",
            "expected \"pin\"",
        ),
        (
            "axes = [[1, 0, 0], [0, 1, 0]]",
            "axes = [[1, 0, 0], [2, 0, 0]]",
            "parallel",
        ),
        (
            "axes = [[1, 0, 0], [0, 1, 0]]",
            "axis = [1, 0, 0]",
            "needs axes",
        ),
        (
            "stamps = \"physical\"",
            "stamps = \"edited\"",
            "\"physical\" or \"tempo\"",
        ),
        (
            "kind = \"end\"",
            "kind = \"end\"\nbody = \"rod 1\"",
            "does not apply",
        ),
        (
            "tracked = false",
            "tracked = false\ntopic = \"/x\"",
            "expected none of them",
        ),
        (
            "kind = \"end\"",
            "kind = \"end\"\ntime = \"free\"",
            "begins and ends at the marks",
        ),
    ] {
        let text = whole.replacen(from, to, 1);
        assert_ne!(text, whole, "{from}");
        let error = scene_from_toml(&text).unwrap_err().to_string();
        assert!(error.contains(said), "{said}: {error}");
    }
}

#[test]
fn goals_of_joints_that_make_no_sense_are_refused() {
    let whole = include_str!("../../config/chain.toml");
    for (from, to, said) in [
        ("joint = \"joint 2\"", "joint = \"joint 9\"", "joint 9"),
        ("angles_deg = [", "angles_deg = [1, ", "has 3 numbers"),
        (
            "angles_deg = [",
            "position_mm = [0, 0, 0]\nangles_deg = [",
            "position_mm",
        ),
        (
            "joint = \"joint 2\"",
            "joint = \"joint 2\"\nbody = \"rod 1\"",
            "one of body, joint",
        ),
        (
            "[[body.track]]\nsees = \"point\"\ntracker = { position_mm = [0, 0, 0.0] }",
            "tracked = false",
            "no tracker sees",
        ),
    ] {
        let text = whole.replacen(from, to, 1);
        assert_ne!(text, whole, "{from}");
        let error = scene_from_toml(&text).unwrap_err().to_string();
        assert!(error.contains(said), "{said}: {error}");
    }
}

/// The tables of the document are a scene.
#[test]
fn the_document_shows_a_scene_that_is_one() {
    let text = include_str!("../../docs/joints.md");
    let tables = text.split("```toml\n").skip(1);
    let tables = tables.map(|rest| rest.split("```").next().expect("an end"));
    let (in_hand, hanging): (Vec<&str>, Vec<&str>) =
        tables.partition(|of| of.contains("held = true"));
    let head = "name = \"pendulum\"\n[timing]\nstamps = \"physical\"\n\
                [[event]]\nname = \"start\"\nkind = \"start\"\n";
    let whole = |tables: &[&str]| {
        head.to_owned() + &tables.join("\n") + "\n[[event]]\nname = \"end\"\nkind = \"end\"\n"
    };
    // The handle takes the nail's place.
    let (before, nail) = hanging[0].split_once("[[joint]]").expect("the nail");
    let (_, elbow) = nail.split_once("[[joint]]").expect("the elbow");
    let held = whole(&[before, "[[joint]]", elbow, in_hand[0]]);
    let held = scene_from_toml(&held).expect("a valid scene");
    let (_, joined) = held.joint_trees().next().expect("a tree");
    assert_eq!(held.hand_of(joined), Some(LinkIndex(2)));
    assert_eq!(in_hand.len(), 1);
    let whole = whole(&hanging);
    let scene = scene_from_toml(&whole).expect("a valid scene");
    let (_, joined) = scene.joint_trees().next().expect("a tree");
    assert_eq!((joined.joints.len(), joined.base), (2, None));
    assert_eq!((scene.goals.len(), scene.events.len()), (1, 4));
    assert_eq!(scene.forest().freedoms(), 9);
    assert_eq!(scene.tree_model(joined).freedoms(), 3);
}

/// Joints within their limits say nothing; one beyond them is doubted and named.
#[test]
fn joints_beyond_their_limits_are_doubted() {
    let within = trees::perform(&PENDULUMS[1], &hung(), 8052);
    let estimate = finished(&within).estimate;
    let tree = within.tree();
    let [_, angles] = tree.angles_of(1).expect("a universal joint");
    let knots = estimate.trees[0].knots.iter();
    let of_second = knots.map(|knot| knot.state.coordinates[angles.end - 1].to_degrees());
    let most_deg = of_second.fold(f64::NEG_INFINITY, f64::max);
    for (limit_deg, is_doubted) in [(most_deg + 1.0, false), (most_deg - 5.0, true)] {
        let limits =
            format!("name = \"joint 2\"\nlimits_deg = [[-720, 720], [-720, {limit_deg:?}]]");
        let text = within.scene_toml.replace("name = \"joint 2\"", &limits);
        let mut said = within.clone();
        said.scene = scene_from_toml(&text).expect("a valid scene");
        let estimate = finished(&said).estimate;
        let found: Vec<_> = estimate
            .doubts
            .iter()
            .map(|of| (of.about, of.place.name(&said.scene)))
            .collect();
        match is_doubted {
            true => assert_eq!(found, [(About::Limit, Some("joint 2"))]),
            false => assert_eq!(found, []),
        }
        assert_eq!(estimate.verdict == Verdict::Physical, !is_doubted);
    }
    for (limits, said) in [
        ("[[-90, 90]]", "expected 2"),
        ("[[-90, 90], [90, -90]]", "least angle first"),
    ] {
        let limits = format!("name = \"joint 2\"\nlimits_deg = {limits}");
        let text = within.scene_toml.replace("name = \"joint 2\"", &limits);
        let error = scene_from_toml(&text).unwrap_err().to_string();
        assert!(error.contains(said), "{error}");
    }
}

/// What hangs and is let go swings back as the energy says.
#[test]
fn energy_is_kept_over_the_motion() {
    let performance = trees::perform(&PENDULUMS[1], &hung(), 8050);
    let estimate = finished(&performance).estimate;
    let tree = performance.tree();
    let mut snapshot = Snapshot::new(&tree, &estimate.gravity_m_s2);
    let energies = estimate.trees[0].knots.iter().map(|knot| {
        snapshot.set(&knot.state);
        snapshot.energy(0.0)
    });
    let energies: Vec<f64> = energies.collect();
    let most = energies.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let least = energies.iter().copied().fold(f64::INFINITY, f64::min);
    // Steps are so long that half of them lead every link to within 3e-8 m.
    assert!(most - least < 3e-7, "{least} {most}");
}

/// A motion of three seconds is found; that further nodes lead to one flow from its start is tested beside them.
#[test]
fn a_long_motion_is_found() {
    let kind = Kind {
        duration_s: 3.0,
        ..Kind::pendulum(3, Jointed::Pin)
    };
    let performance = trees::perform(&kind, &TreeActing::of(1.0), 7101);
    let estimate = finished(&performance).estimate;
    assert_eq!(estimate.verdict, Verdict::Physical, "{:?}", estimate.doubts);
    let off = estimate.trees[0].residuals[0].position_rms_m;
    assert!(off.is_some_and(|off_m| off_m < 0.025), "{off:?}");
}

/// Of this chain growing as a rule leads to no optimum, and growing on legs to a doubted motion at 45.13: other rates at the
/// start lead to a nearer one.
#[test]
fn other_rates_lead_to_a_motion_where_the_rule_does_not() {
    let performance = trees::perform(&Kind::CHAIN, &TreeActing::of(1.0), 8046);
    let estimate = finished(&performance).estimate;
    assert_eq!(estimate.verdict, Verdict::Physical, "{:?}", estimate.doubts);
    assert!(estimate.objective < 38.0, "{}", estimate.objective);
}

/// How fast a chain spins is told weakly: along that there is a lower optimum than the one of 195.04 that growing leads to.
#[test]
fn a_lower_optimum_is_found_along_what_is_told_weakly() {
    let mut performance = trees::perform(&Kind::CHAIN, &TreeActing::of(1.0), 7005);
    performance.scene.performer = Performer::Nobody;
    let estimate = finished(&performance).estimate;
    assert_eq!(estimate.verdict, Verdict::Physical, "{:?}", estimate.doubts);
    assert!(estimate.objective < 194.5, "{}", estimate.objective);
}

/// What the equations of motion do not lead to, and what no hand makes, is doubted.
#[test]
fn knots_that_do_not_follow_from_the_first_are_doubted() {
    let performance = trees::perform(&PENDULUMS[1], &hung(), 8051);
    let outcome = finished(&performance);
    let estimate = &outcome.estimate;
    let doubts = |estimate: &Estimate| -> Vec<About> {
        let doubts = verify::joined::doubts(
            &performance.scene,
            &outcome.sketch,
            &outcome.marks_made_s,
            estimate,
        );
        doubts.iter().map(|doubt| doubt.about).collect()
    };
    assert_eq!(doubts(estimate), []);
    let mut moved = estimate.clone();
    moved.trees[0].knots.last_mut().unwrap().state.coordinates[0] += 1e-4;
    assert_eq!(doubts(&moved), [About::Steps]);
    let mut unknown = estimate.clone();
    unknown.trees[0].knots[3].state.coordinates[0] = f64::NAN;
    assert!(doubts(&unknown).contains(&About::Steps));
    let mut whirled = estimate.clone();
    whirled.trees[0].knots[2].state.rates[0] = 2000.0;
    assert_eq!(doubts(&whirled), [About::Speed, About::Spin]);
}

/// Samples whose messages say how far they err.
fn with_messages(performance: &TreePerformance, sd_m: impl Fn(usize) -> f64) -> TreePerformance {
    let mut said = performance.clone();
    for track in &mut said.scene.tracks {
        track.weighing = Weighing::Messages;
    }
    for (at, event) in said.events.iter_mut().enumerate() {
        if let TakeEvent::Pose { sample, .. } = event {
            let mut rows = [0.0; 36];
            for axis in 0..6 {
                rows[7 * axis] = sd_m(at).powi(2);
            }
            sample.covariance = Some(Covariance::of_rows(&rows));
        }
    }
    said
}

/// Messages that say what the scene's weights say lead to the same motion; of rough and good samples, those that say
/// so lead nearer to the truth.
#[test]
fn samples_weigh_what_their_messages_say() {
    let acting = TreeActing {
        wander_m: 0.0,
        noise_m: 0.001,
        ..hung()
    };
    let [mut weighed_m, mut alike_m] = [0.0; 2];
    for seed in 8020..8024 {
        let mut performance = trees::perform(&PENDULUMS[0], &acting, seed);
        performance.scene.performer = Performer::Nobody;
        let own_m = performance.scene.weights.position_m;
        let [given, said] =
            [performance.clone(), with_messages(&performance, |_| own_m)].map(|of| {
                let outcome = finished(&of);
                outcome.estimate.trees[0].knots[0].state.clone()
            });
        let off = performance.tree().minus(&given, &said);
        assert!(off.iter().all(|off| off.abs() < 1e-5), "{seed}: {off:?}");
        // Every other sample is off by centimetres.
        let is_rough = |at: usize| at % 2 == 1;
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        for (at, event) in performance.events.iter_mut().enumerate() {
            if let TakeEvent::Pose { sample, .. } = event
                && is_rough(at)
            {
                sample.position_m +=
                    Vector3::from_fn(|_, _| 0.03 * random.sample::<f64, _>(StandardNormal));
            }
        }
        let said = with_messages(&performance, |at| if is_rough(at) { 0.03 } else { 0.001 });
        for (of, sum_m) in [(&said, &mut weighed_m), (&performance, &mut alike_m)] {
            let found = &finished(of).estimate.trees[0].knots[0].state;
            let off = performance.tree().minus(found, &performance.truth);
            *sum_m += off.iter().map(|off| off * off).sum::<f64>();
        }
    }
    assert!(weighed_m < 0.1 * alike_m, "{weighed_m} {alike_m}");
}
