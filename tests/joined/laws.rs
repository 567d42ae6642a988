//! Laws of impacts of joined bodies that are free: restitution and friction, estimated with the motion.

use enact::config::scene_from_toml;
use enact::motion::{
    About, AtBound, Estimate, FreeParameter, JointEnd, LinkIndex, Quantity, Verdict,
};
use enact::pipeline::Pipeline;
use enact_tools::tree_impacts::{Acted, Form, Strike, Struck, strike};
use enact_tools::trees::{self, Jointed, Kind, TreeActing};

const LAW: [f64; 2] = [0.5, 0.2];

/// A pendulum above the table, and a chain.
const KINDS: [Struck; 2] = [
    Struck {
        form: Form::Rod,
        links: 2,
        joints: Jointed::Universal,
        hangs_m: Some(0.35),
        impacts: 1,
        law: LAW,
    },
    Struck {
        form: Form::Rod,
        links: 3,
        joints: Jointed::Universal,
        hangs_m: None,
        impacts: 1,
        law: LAW,
    },
];

/// The same performance with restitution and friction free, from other values than the true ones.
fn freed(mut strike: Strike, bounds: [f64; 2]) -> Strike {
    let mut laws = strike.scene.events.iter();
    let law = laws.find_map(|event| Some(event.kind.collision()?.law));
    let law = law.expect("a collision");
    let free = |name: &str, quantity, initial: f64, [lower, upper]: [f64; 2]| FreeParameter {
        name: name.to_owned(),
        quantity,
        initial,
        lower,
        upper,
        prior_sd: None,
    };
    strike.scene.parameters = vec![
        free("restitution", Quantity::Restitution { law }, 0.7, bounds),
        free("friction", Quantity::Friction { law }, 0.35, [0.0, 1.0]),
    ];
    strike
}

fn finished(strike: &Strike) -> Estimate {
    let events = strike.events.iter().cloned();
    let outcome = Pipeline::of(strike.scene.clone(), events).finish(&mut ());
    outcome.expect("an estimate").estimate
}

/// From exact samples the law comes back; friction where the contact slid, which is said.
#[test]
fn an_exact_sketch_gives_the_law_back() {
    let exact = Acted {
        distortion: 0.0,
        noise: 0.0,
        mark_sd_s: 0.0,
    };
    let mut slid = 0;
    for kind in &KINDS {
        for seed in 8300..8302 {
            let estimate = finished(&freed(strike(kind, &exact, seed), [0.0, 1.0]));
            assert_eq!(estimate.verdict, Verdict::Physical, "{kind:?} {seed}");
            let [restitution, friction] = &estimate.parameters[..] else {
                panic!("two parameters");
            };
            let off = (restitution.value - LAW[0]).abs();
            assert!(off < 2e-3, "{kind:?} {seed}: {off}");
            assert_eq!(restitution.at_bound, None);
            if friction.sd.is_some() {
                slid += 1;
                let off = (friction.value - LAW[1]).abs();
                assert!(off < 5e-3, "{kind:?} {seed}: {off}");
            }
        }
    }
    assert!(slid > 0);
}

/// What hits a bumper gains what that gives, and no doubt is about its energy.
#[test]
fn a_bumper_gives_joined_bodies_energy() {
    let exact = Acted {
        distortion: 0.0,
        noise: 0.0,
        mark_sd_s: 0.0,
    };
    for kind in &KINDS {
        for (friction, seed) in [(0.0, 8320), (LAW[1], 8320), (LAW[1], 8321)] {
            let kind = Struck {
                law: [1.25, friction],
                ..*kind
            };
            let mut performed = freed(strike(&kind, &exact, seed), [0.0, 2.0]);
            performed.scene.parameters.truncate(1);
            let estimate = finished(&performed);
            let found = estimate.parameters[0].value;
            assert!((found - 1.25).abs() < 2e-3, "{kind:?}: {found}");
            // Rods may go through each other.
            let doubts = &estimate.doubts;
            let is_right = doubts.iter().all(|doubt| doubt.about == About::Overlap);
            assert!(is_right, "{kind:?} {seed}: {doubts:?}");
            assert_ne!(estimate.verdict, Verdict::Failed, "{kind:?} {seed}");
        }
    }
}

/// From a usual hand restitution and the time of the impact are as certain as they are said to be; what is off its bounds
/// stays at one.
#[test]
fn a_rough_sketch_tells_restitution_within_its_deviation() {
    let (mut physical, mut within, mut in_time) = (0, 0, 0);
    for kind in &KINDS {
        for seed in 8310..8313 {
            let performed = strike(kind, &Acted::of(1.0), seed);
            let estimate = finished(&freed(performed.clone(), [0.0, 1.0]));
            if estimate.verdict != Verdict::Physical {
                continue;
            }
            physical += 1;
            let found = &estimate.parameters[0];
            let sd = found.sd.expect("a deviation");
            within += usize::from((found.value - LAW[0]).abs() < 2.0 * sd);
            let mut hits = estimate.events.iter().filter(|event| !event.is_fixed);
            let hit = hits.next().expect("an impact");
            let off_s = (hit.time_s - performed.impacts_s[0]).abs();
            in_time += usize::from(off_s < 2.0 * hit.sd_s.expect("a deviation"));
        }
    }
    assert!(physical >= 4, "{physical} of 6");
    assert!(within + 2 >= physical, "{within} of {physical}");
    assert!(in_time + 2 >= physical, "{in_time} of {physical}");
    let exact = Acted {
        distortion: 0.0,
        noise: 0.0,
        mark_sd_s: 0.0,
    };
    let bounded = finished(&freed(strike(&KINDS[0], &exact, 8320), [0.6, 1.0]));
    let found = &bounded.parameters[0];
    assert!((found.value - 0.6).abs() < 1e-6, "{found:?}");
    assert_eq!(found.at_bound, Some(AtBound::Lower));
}

#[test]
fn clocks_of_scenes_with_joints_are_not_free() {
    let hung = TreeActing {
        asks_start: false,
        ..TreeActing::of(1.0)
    };
    let kind = Kind::pendulum(2, Jointed::Universal);
    let text = trees::perform(&kind, &hung, 8330).scene_toml;
    let text = format!("{text}\n[[free]]\nquantity = \"rod 2.clock.rate\"\n");
    let error = scene_from_toml(&text).unwrap_err().to_string();
    let said = "of joined bodies clocks are given";
    assert!(error.contains(said), "{error}");
}

/// Places of joints are free by the names that suspects have; axes are not.
#[test]
fn joints_are_free_by_name() {
    let kind = Kind::pendulum(2, Jointed::Pin);
    let text = trees::perform(&kind, &TreeActing::of(1.0), 8330).scene_toml;
    let child = LinkIndex(1);
    let place = |end, axis| Quantity::JointPlace { child, end, axis };
    for (name, quantity) in [
        ("joint 2.parent.z", place(JointEnd::Parent, 2)),
        ("joint 2.child.x", place(JointEnd::Child, 0)),
    ] {
        let text = format!("{text}\n[[free]]\nquantity = {name:?}\n");
        let scene = scene_from_toml(&text).expect("a valid scene");
        assert_eq!(scene.parameters[0].quantity, quantity, "{name}");
        assert_eq!(scene.name_of_quantity(quantity), name);
    }
    let text = format!("{text}\n[[free]]\nquantity = \"joint 2.turn.1\"\n");
    let error = scene_from_toml(&text).unwrap_err().to_string();
    assert!(error.contains("unknown quantity"), "{error}");
}

/// What else of a scene is free comes back from exact samples too: a body's mass, where its centre of mass is, where its tracker
/// is, where a joint is, and gravity; and the checks are those of the scene with these.
#[test]
fn an_exact_sketch_gives_the_scene_back() {
    let exact = TreeActing {
        wander_m: 0.0,
        noise_m: 0.0,
        asks_start: false,
        ..TreeActing::of(1.0)
    };
    for seed in 8000..8004 {
        let performance = trees::perform(&Kind::pendulum(2, Jointed::Pin), &exact, seed);
        let given = &performance.scene;
        let last = given.links.last_key().expect("links");
        let track = given.tracks.keys().next().expect("a track");
        let along = |axis| Quantity::Centre { link: last, axis };
        let quantities = [
            (Quantity::Gravity { axis: 2 }, -9.5),
            (Quantity::Mass { link: last }, 1.2),
            (along(2), 0.005),
            (Quantity::TrackerPosition { track, axis: 2 }, 0.004),
            (
                Quantity::JointPlace {
                    child: last,
                    end: JointEnd::Parent,
                    axis: 2,
                },
                0.01,
            ),
        ];
        for (quantity, initial) in quantities {
            let mut scene = given.clone();
            let truth = match quantity {
                Quantity::Gravity { .. } => given.gravity_m_s2.z,
                Quantity::Mass { .. } => 1.0,
                _ => 0.0,
            };
            scene.parameters = vec![scene.freed(quantity, initial)];
            let events = performance.events.iter().cloned();
            let outcome = Pipeline::of(scene, events)
                .finish(&mut ())
                .expect("an estimate");
            let estimate = &outcome.estimate;
            let said = (seed, quantity, &estimate.reason, &estimate.doubts);
            assert_eq!(estimate.verdict, Verdict::Physical, "{said:?}");
            let found = &estimate.parameters[0];
            let off = (found.value - truth).abs() / quantity.typical();
            assert!(off < 0.02, "{said:?}: {found:?}");
            assert_eq!(outcome.given.value_of(quantity), given.value_of(quantity));
        }
    }
}
