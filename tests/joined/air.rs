//! Forces, drag and lift on joined bodies, given and free.

use enact::config::scene_from_toml;
use enact::motion::{Estimate, LinkIndex, Quantity, Scene, TakeEvent, Verdict};
use enact::physics::Body;
use enact::pipeline::Pipeline;
use enact_tools::beside::Beside;
use enact_tools::trees::{self, Jointed, Kind, TreeActing, TreePerformance};

/// What pushes every rod.
const PUSHES: &str =
    "force_m_s2 = [0.7, 1.5, 0.5]\ndrag_linear_per_s = 0.6\ndrag_quadratic_per_m = 0.2\n";

/// Rods that are pushed, seen with white noise alone.
fn pushed(kind: &Kind, noise_m: f64, seed: u64) -> TreePerformance {
    let acting = TreeActing {
        wander_m: 0.0,
        noise_m,
        asks_start: !kind.is_clamped,
        ..TreeActing::of(0.0)
    };
    trees::perform_as(kind, &acting, seed, |text| {
        text.replace("mass_g = 100\n", &format!("mass_g = 100\n{PUSHES}"))
    })
}

fn finished(scene: Scene, events: &[TakeEvent]) -> Estimate {
    let outcome = Pipeline::of(scene, events.iter().cloned()).finish(&mut ());
    outcome.expect("an estimate").estimate
}

/// Of a pendulum that is pushed by wind and slowed by the air, what pushes it comes back from exact samples; so does that
/// of a chain that flies.
#[test]
fn an_exact_sketch_gives_the_air_back() {
    for kind in [Kind::pendulum(2, Jointed::Pin), Kind::CHAIN] {
        let performance = pushed(&kind, 0.0, 8400);
        let link = LinkIndex(1);
        for (quantity, initial) in [
            (Quantity::LinearDrag { link }, 0.3),
            (Quantity::QuadraticDrag { link }, 0.5),
            (Quantity::Force { link, axis: 1 }, 1.0),
        ] {
            let mut scene = performance.scene.clone();
            let truth = scene.value_of(quantity);
            scene.parameters = vec![scene.freed(quantity, initial)];
            let estimate = finished(scene, &performance.events);
            let said = (kind, quantity, &estimate.reason, &estimate.doubts);
            assert_eq!(estimate.verdict, Verdict::Physical, "{said:?}");
            let found = estimate.parameters[0].value;
            let off = (found - truth).abs() / quantity.typical();
            assert!(off < 0.02, "{said:?}: {found} for {truth}");
        }
    }
}

/// From a tracker that is hardly wrong, drag is as certain as it is said to be.
#[test]
fn drag_is_told_within_its_deviation() {
    let quantity = Quantity::QuadraticDrag { link: LinkIndex(1) };
    // What pins let turn stays in a plane, out of which a goal holds nothing.
    for joints in [Jointed::Pin, Jointed::Universal] {
        let within = (8410..8420).filter(|seed| {
            let performance = pushed(&Kind::pendulum(2, joints), 2e-4, *seed);
            let mut scene = performance.scene.clone();
            scene.parameters = vec![scene.freed(quantity, 0.0)];
            let estimate = finished(scene, &performance.events);
            let found = &estimate.parameters[0];
            let said = (found, &estimate.reason, &estimate.doubts);
            let sd = found.sd.unwrap_or_else(|| panic!("{seed}: {said:?}"));
            assert!(sd > 1e-4, "{said:?}");
            (found.value - 0.2).abs() < 2.0 * sd
        });
        let within = within.count();
        assert!(within >= 8, "{joints:?}: {within} of 10");
    }
}

/// A goal that ties the ball to the lamp and asks next to nothing.
const TIE: &str = "[[goal]]\nevent = \"end\"\nbody = \"ball\"\nrelative_to = \"lamp\"\nposition_mm = [0, 0, 300]\nsd_mm = 1e6\n";

/// A ball that is tied to a lamp is found by the flow of trees. Each of its flights, flown by the body by itself with the same
/// force, drag and lift, ends where the next one begins.
#[test]
fn a_ball_that_is_tied_to_a_lamp_flies_in_the_air_as_by_itself() {
    let of_ball = "force_m_s2 = [0.2, 0, 0]\ndrag_quadratic_per_m = 0.1\nlift = 0.01";
    for seed in 8500..8503 {
        let of = Beside::of(seed);
        let scene = scene_from_toml(&of.toml(of_ball, TIE)).expect("a valid scene");
        let estimate = finished(scene.clone(), &of.take());
        let [first, second] = estimate.arcs.as_slice() else {
            panic!("{seed}: two flights");
        };
        let gravity_m_s2 = &estimate.gravity_m_s2;
        let ends = scene.flown(first, gravity_m_s2, first.end_s).position_m;
        let begins = scene.flown(second, gravity_m_s2, second.start_s).position_m;
        assert!((ends - begins).norm() < 1e-7, "{seed}: {ends} {begins}");
        let mut still = scene.clone();
        let body = &mut still.links[LinkIndex(0)].body;
        *body = Body::new(body.mass_kg(), body.moments_kg_m2()).expect("a body");
        let without = still.flown(first, gravity_m_s2, first.end_s).position_m;
        assert!((without - begins).norm() > 1e-3, "{seed}: the air matters");
    }
}

/// A ball that the air slows and pushes a little moves alike by itself and as a tree of one link, tied to a lamp.
#[test]
fn a_ball_in_the_air_moves_alike_beside_a_lamp() {
    let of_ball = "force_m_s2 = [0.02, 0, 0]\ndrag_quadratic_per_m = 0.02";
    for seed in 8500..8503 {
        let of = Beside::of(seed);
        let [alone, tied] = ["", TIE].map(|further| {
            let scene = scene_from_toml(&of.toml(of_ball, further)).expect("a valid scene");
            assert_eq!(scene.groups().len(), if further.is_empty() { 2 } else { 1 });
            let estimate = finished(scene.clone(), &of.take());
            (scene, estimate)
        });
        assert_ne!(tied.1.verdict, Verdict::Failed);
        let ends_m = [&alone, &tied].map(|(scene, estimate)| {
            let ends = estimate.arcs.iter().map(|arc| {
                let flown = scene.flown(arc, &estimate.gravity_m_s2, arc.end_s);
                flown.position_m
            });
            ends.collect::<Vec<_>>()
        });
        assert!(!ends_m[0].is_empty() && ends_m[0].len() == ends_m[1].len());
        for (one, other) in ends_m[0].iter().zip(&ends_m[1]) {
            assert!((one - other).norm() < 0.01, "{seed}: {one} {other}");
        }
    }
}
