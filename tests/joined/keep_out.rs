//! Joined bodies keep out of things: what a hand's wander leads into a wall, a floor or a board is mended, and what can only
//! be had through something is never called physical.

use enact::config::scene_from_toml;
use enact::motion::{About, Doubt, Estimate, TakeEvent, Verdict};
use enact::physics::tree::Snapshot;
use enact::pipeline::{Outcome, Pipeline};
use enact::verify::overlaps;
use enact_tools::tree_impacts::{Acted, Form, Struck, strike};
use enact_tools::trees::{self, Jointed, Kind, ROD_M, TreeActing, TreePerformance};
use nalgebra::Vector3;

/// How far the true rods pass \[m\],
const PASSES_M: f64 = 0.001;
/// and how far they are in a wall through which they are led.
const THROUGH_M: f64 = 0.08;
/// Radius of a rod \[m\].
const RADIUS_M: f64 = 0.005;
/// Half the thickness of a wall \[m\].
const HALF_M: f64 = 0.02;
/// How many times as far as a usual hand one strays that leads rods into things.
const STRAYING: f64 = 1.7;
/// Greatest share by which a motion is farther from its samples for being kept out.
const FARTHER: f64 = 1.2;

const PENDULUMS: [Kind; 3] = [
    Kind::pendulum(2, Jointed::Pin),
    Kind::pendulum(2, Jointed::Universal),
    Kind::pendulum(2, Jointed::Ball),
];

/// What is beside a motion: something to a side of it.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Beside {
    Wall,
    Floor,
    Board,
}

impl Beside {
    /// The ways to it from the motion.
    fn ways(self) -> Vec<Vector3<f64>> {
        match self {
            Self::Wall => vec![Vector3::y(), -Vector3::y(), Vector3::x(), -Vector3::x()],
            Self::Floor | Self::Board => vec![-Vector3::z()],
        }
    }

    /// It, so far away along a way \[m\].
    fn toml(self, way: &Vector3<f64>, off_m: f64) -> String {
        let list = |of: Vector3<f64>| format!("[{:?}, {:?}, {:?}]", of.x, of.y, of.z);
        let surface = format!(
            "\n[[surface]]\nname = \"floor\"\npoint_mm = {}\nnormal = [0, 0, 1]\n",
            list(way * (1e3 * off_m))
        );
        match self {
            Self::Floor => surface,
            Self::Board => surface + "size_mm = [3000, 3000]\nthickness_mm = 30\n",
            Self::Wall => {
                let half_m = Vector3::repeat(3.0) - way.abs() * (3.0 - HALF_M);
                format!(
                    "\n[[obstacle]]\nname = \"wall\"\nshape = {{ kind = \"cuboid\", size_mm = {} }}\nposition_mm = {}\n",
                    list(half_m * 2e3),
                    list(way * (1e3 * (off_m + HALF_M)))
                )
            }
        }
    }
}

/// How far the true rods reach along a way \[m\], and at which share of the motion.
fn reach(performance: &TreePerformance, way: &Vector3<f64>) -> (f64, f64) {
    let (scene, tree) = (&performance.scene, performance.tree());
    let states = trees::motion(
        scene,
        &tree,
        &performance.truth,
        performance.duration_s,
        2000.0,
    );
    let mut snapshot = Snapshot::new(&tree, &scene.gravity_m_s2);
    let mut farthest = (f64::NEG_INFINITY, 0.0);
    for (index, state) in states.iter().enumerate() {
        snapshot.set(state);
        for link in 0..scene.links.len() {
            let of = snapshot.link_state(link);
            let along = way.dot(&(of.orientation * Vector3::z()));
            let off_m = 0.5 * ROD_M * along.abs() + RADIUS_M * (1.0 - along * along).sqrt();
            let reach_m = way.dot(&of.position_m) + off_m;
            if reach_m > farthest.0 {
                farthest = (reach_m, index as f64 / states.len() as f64);
            }
        }
    }
    farthest
}

/// Rods that pass so far beside something on their way, as a hand acts them.
fn beside(
    kind: &Kind,
    what: Beside,
    distortion: f64,
    passes_m: f64,
    seed: u64,
) -> Option<TreePerformance> {
    let acting = TreeActing {
        asks_start: false,
        ..TreeActing::of(distortion)
    };
    let mut performance = trees::perform(kind, &acting, seed);
    let ways = what.ways();
    let tried = (0..ways.len()).map(|at| ways[(at + seed as usize) % ways.len()]);
    let mut reaches = tried.map(|way| (way, reach(&performance, &way)));
    let (way, (reach_m, _)) = reaches.find(|(_, (_, share))| (0.15..0.85).contains(share))?;
    performance.scene_toml += &what.toml(&way, reach_m + passes_m);
    performance.scene = scene_from_toml(&performance.scene_toml).expect("a valid scene");
    Some(performance)
}

fn pipeline(performance: &TreePerformance) -> Pipeline {
    Pipeline::of(
        performance.scene.clone(),
        performance.events.iter().cloned(),
    )
}

fn grave(estimate: &Estimate) -> Vec<&Doubt> {
    let doubts = estimate.doubts.iter();
    doubts
        .filter(|doubt| doubt.about.best() != Verdict::Physical)
        .collect()
}

fn has(estimate: &Estimate, about: About) -> bool {
    estimate.doubts.iter().any(|doubt| doubt.about == about)
}

fn overlap_m(outcome: &Outcome) -> f64 {
    let found = overlaps(&outcome.scene, &outcome.estimate, &mut ());
    found.iter().map(|of| of.depth_m).fold(0.0, f64::max)
}

/// A pendulum that bounces on a table, of which the scene does not say so.
fn without_impact(kind: &Struck, seed: u64) -> Pipeline {
    let strike = strike(kind, &Acted::of(1.0), seed);
    let mut scene = strike.scene.clone();
    let mut events = scene.events.iter();
    let hit = events.position(|event| event.kind.collision().is_some());
    let hit = hit.expect("an impact");
    let name = scene.events.remove(hit).name;
    scene.goals.retain(|goal| goal.event != hit);
    for goal in &mut scene.goals {
        goal.event -= usize::from(goal.event > hit);
    }
    let is_its = |of: &TakeEvent| {
        of.mark()
            .is_some_and(|mark| mark.event.as_ref() == Some(&name))
    };
    let events = strike.events.iter().filter(|of| !is_its(of));
    Pipeline::of(scene, events.cloned())
}

/// A pendulum of two rods that hits a table once.
const BOUNCING: Struck = Struck {
    form: Form::Rod,
    links: 2,
    joints: Jointed::Universal,
    hangs_m: Some(0.35),
    impacts: 1,
    law: [0.5, 0.2],
};

#[test]
fn rods_that_a_hand_led_into_something_are_kept_out_of_it() {
    let (mut tried, mut overlapped, mut mended) = (0, 0, 0);
    for (what, seeds) in [
        (Beside::Wall, 8210..8220),
        (Beside::Floor, 8213..8217),
        (Beside::Board, 8213..8217),
    ] {
        let kinds = PENDULUMS.iter();
        for (kind, seed) in kinds.flat_map(|kind| seeds.clone().map(move |seed| (kind, seed))) {
            let Some(performance) = beside(kind, what, STRAYING, PASSES_M, seed) else {
                continue;
            };
            let of = pipeline(&performance);
            let before = of.estimate(&mut ()).expect("an estimate");
            let after = of.finish(&mut ()).expect("an answer");
            let said = format!("{what:?} {kind:?} {seed}");
            tried += 1;
            if !has(&before.estimate, About::Overlap) {
                assert_eq!(before.estimate.trees, after.estimate.trees, "{said}");
                assert_eq!(before.estimate.counters, after.estimate.counters, "{said}");
                continue;
            }
            overlapped += 1;
            if after.estimate.verdict != Verdict::Physical {
                // It stays as it was.
                assert_eq!(before.estimate.trees, after.estimate.trees, "{said}");
                assert!(has(&after.estimate, About::Overlap), "{said}");
                continue;
            }
            mended += 1;
            assert_eq!(grave(&after.estimate), Vec::<&Doubt>::new(), "{said}");
            assert!(has(&after.estimate, About::KeptOut), "{said}");
            assert!(overlap_m(&after) <= after.scene.tolerance_m, "{said}");
            let [free, kept] = [&before, &after].map(|of| of.estimate.objective);
            assert!(
                kept >= free * (1.0 - 1e-9) && kept <= FARTHER * free,
                "{said}: {free} {kept}"
            );
            let steps = |of: &Outcome| of.estimate.counters.iterations;
            assert!(steps(&after) > steps(&before), "{said}");
            for goal in after.given.goals_attained(&after.estimate) {
                assert!(goal.is_met(), "{said}: {goal:?}");
            }
        }
    }
    assert!(tried >= 40 && overlapped >= 6, "{overlapped} of {tried}");
    assert!(mended >= 5, "{mended} of {overlapped}");
}

/// The scene knows no impact, so that the motion is far from its samples as well: it is not led farther from them.
#[test]
fn a_pendulum_whose_impact_is_missing_stays_doubted() {
    for seed in 8200..8204 {
        let pipeline = without_impact(&BOUNCING, seed);
        let outcome = pipeline.finish(&mut ()).expect("an answer");
        assert_ne!(outcome.estimate.verdict, Verdict::Physical, "{seed}");
        assert!(has(&outcome.estimate, About::Residual), "{seed}");
        assert!(!has(&outcome.estimate, About::KeptOut), "{seed}");
    }
}

/// What was acted goes through a wall, deeper than any hand strays: no motion out of it is as near.
#[test]
fn rods_that_were_led_through_a_wall_stay_doubted() {
    let mut through = 0;
    for (kind, seed) in [(&PENDULUMS[0], 8200), (&PENDULUMS[1], 8201)] {
        let Some(performance) = beside(kind, Beside::Wall, 1.0, -THROUGH_M, seed) else {
            continue;
        };
        let of = pipeline(&performance);
        let before = of.estimate(&mut ()).expect("an estimate");
        let after = of.finish(&mut ()).expect("an answer");
        through += 1;
        // Nothing else speaks against it, so that leading it out is tried.
        let is_overlap = |doubt: &&Doubt| doubt.about == About::Overlap;
        assert!(grave(&before.estimate).iter().all(is_overlap), "{seed}");
        assert_eq!(before.estimate.trees, after.estimate.trees, "{seed}");
        assert_ne!(after.estimate.verdict, Verdict::Physical, "{seed}");
        assert!(has(&after.estimate, About::Overlap), "{seed}");
        assert!(!has(&after.estimate, About::KeptOut), "{seed}");
    }
    assert!(through > 0, "both swing to a side on their way");
}
