//! Bodies joined in trees that hit a table, through the program.

use enact::config::scene_from_toml;
use enact::motion::{About, Against, Doubt, Estimate, Fits, LinkIndex, Place, Scene, Verdict};
use enact::physics::tree::Snapshot;
use enact::verify;
use enact_tools::replay::Program;
use enact_tools::tree_impacts::{Acted, Form, Strike, Struck, strike};
use enact_tools::trees::Jointed;
use nalgebra::Vector3;
use tempfile::TempDir;

const ENACT: Program = Program(env!("CARGO_BIN_EXE_enact"));

const fn struck(links: usize, joints: Jointed, hangs_m: Option<f64>, impacts: usize) -> Struck {
    Struck {
        form: Form::Rod,
        links,
        joints,
        hangs_m,
        impacts,
        law: [0.5, 0.2],
    }
}

/// A pendulum above the table, a flail, a flail that hits twice, and a chain.
const KINDS: [Struck; 4] = [
    struck(2, Jointed::Universal, Some(0.35), 1),
    struck(2, Jointed::Ball, None, 1),
    struck(2, Jointed::Pin, None, 2),
    struck(3, Jointed::Universal, None, 1),
];

/// Times of the impacts, as estimated \[s\].
fn hits_s(estimate: &Estimate) -> Vec<f64> {
    let free = estimate.events.iter().filter(|event| !event.is_fixed);
    free.map(|event| event.time_s).collect()
}

/// From exact samples and marks, motion and times of impacts come back.
#[test]
fn an_exact_sketch_gives_motion_and_impacts_back() {
    for kind in &KINDS {
        for seed in 8000..8003 {
            let strike = strike(kind, &Acted::EXACT, seed);
            let estimate = strike.finished().estimate;
            assert_eq!(estimate.verdict, Verdict::Physical, "{kind:?} {seed}");
            for (found_s, true_s) in hits_s(&estimate).iter().zip(&strike.impacts_s) {
                let off_s = (found_s - true_s).abs();
                // The prior on the rates at the start draws by as much.
                assert!(off_s < 2e-5, "{kind:?} {seed}: {off_s}");
            }
            let off = strike.coordinates_off(&estimate);
            assert!(off < 0.005, "{kind:?} {seed}: {off}");
        }
    }
}

/// Rough sketches: what hits touches, its normal speed turns round by the law, no energy is created, goals are met.
#[test]
fn rough_sketches_bounce_by_the_law() {
    let mut physical = 0;
    for kind in &KINDS {
        for seed in 8010..8014 {
            let strike = strike(kind, &Acted::of(1.0), seed);
            let outcome = strike.finished();
            let estimate = &outcome.estimate;
            physical += usize::from(estimate.verdict == Verdict::Physical);
            if estimate.verdict != Verdict::Physical {
                continue;
            }
            for goal in strike.scene.goals_attained(estimate) {
                assert!(goal.is_met(), "{kind:?} {seed}: {goal:?}");
            }
            bounces(&strike, estimate, kind.hangs_m.is_none());
        }
    }
    assert!(physical >= 14, "{physical} of 16");
}

fn bounces(strike: &Strike, estimate: &Estimate, is_free: bool) {
    let (_, joined) = strike.scene.joint_trees().next().expect("a tree");
    let tree = strike.scene.tree_model(joined);
    let knots = &estimate.trees[0].knots;
    let mut pairs = knots
        .windows(2)
        .filter(|pair| pair[0].time_s == pair[1].time_s);
    for event in estimate.events.iter().filter(|event| !event.is_fixed) {
        let pair = pairs.next().expect("a state on either side");
        assert_eq!(pair[0].time_s, event.time_s);
        let collision = strike.scene.events[event.event]
            .kind
            .collision()
            .expect("a collision");
        let place = joined.place_of(collision.link).expect("of the tree");
        let feature = collision.contacts[0].feature.expect("named");
        let of_link = &strike.scene.links[collision.link].features[feature].geometry;
        let enact::physics::contact::Feature::Point { point_m, .. } = *of_link else {
            panic!("a point");
        };
        let both = [0, 1].map(|side| {
            let mut snapshot = Snapshot::new(&tree, &estimate.gravity_m_s2);
            snapshot.set(&pair[side].state);
            let state = snapshot.link_state(place);
            let lever_m = snapshot.point(place, &point_m) - state.position_m;
            let spin = state.orientation * state.angular_velocity_rad_s;
            let speed_m_s = (state.velocity_m_s + spin.cross(&lever_m)).z;
            let links = joined.links().enumerate();
            let momenta = links.map(|(place, link)| {
                let mass_kg = strike.scene.links[link].body.mass_kg();
                snapshot.link_state(place).velocity_m_s * mass_kg
            });
            (
                snapshot.point(place, &point_m).z,
                speed_m_s,
                snapshot.energy(0.0),
                momenta.sum::<Vector3<f64>>(),
            )
        });
        let [before, after] = both;
        assert!(before.0.abs() < 1e-6 && after.0.abs() < 1e-6, "{both:?}");
        assert!(
            before.1 < -0.1 && (after.1 + 0.5 * before.1).abs() < 1e-6,
            "{both:?}"
        );
        assert!(after.2 < before.2, "{both:?}");
        let knocks = estimate.knocks(&strike.scene, event);
        assert_eq!(knocks.len(), 1);
        assert!(
            (knocks[0].approach_m_s() + before.1).abs() < 1e-6,
            "{knocks:?}"
        );
        assert!(
            (knocks[0].parting_m_s() - after.1).abs() < 1e-6,
            "{knocks:?}"
        );
        let off = (after.3 - before.3 - knocks[0].impulse_n_s).norm();
        assert!(!is_free || off < 1e-7, "{off} of {knocks:?}");
    }
    assert!(pairs.next().is_none());
}

/// Where the last rod's end is at its first impact [m, world].
fn landed_m(strike: &Strike, estimate: &Estimate) -> nalgebra::Vector3<f64> {
    let (_, joined) = strike.scene.joint_trees().next().expect("a tree");
    let tree = strike.scene.tree_model(joined);
    let mut snapshot = Snapshot::new(&tree, &estimate.gravity_m_s2);
    let time_s = hits_s(estimate)[0];
    let knots = &estimate.trees[0].knots;
    let knot = knots.iter().find(|knot| knot.time_s == time_s);
    snapshot.set(&knot.expect("a state at the impact").state);
    let link = strike.scene.links.last_key().expect("rods");
    let end = strike.scene.links[link].features.first().expect("its end");
    let enact::physics::contact::Feature::Point { point_m, .. } = end.geometry else {
        panic!("a point");
    };
    snapshot.point(joined.place_of(link).expect("of the tree"), &point_m)
}

/// What hits lands where a goal asks, some millimetres from where it would.
#[test]
fn what_hits_lands_where_a_goal_asks() {
    for kind in &KINDS[..2] {
        for seed in 8070..8073 {
            let mut strike = strike(kind, &Acted::of(0.5), seed);
            let found = strike.finished().estimate;
            assert_eq!(found.verdict, Verdict::Physical, "{kind:?} {seed}");
            let at_m = landed_m(&strike, &found) + nalgebra::Vector3::new(0.006, -0.004, 0.0);
            let asked = format!(
                "[[goal]]\nevent = \"hit 1\"\nbody = \"rod {}\"\ncontact = true\n\
                 position_mm = [{}, {}, 0]\n\n[[goal]]",
                kind.links,
                1e3 * at_m.x,
                1e3 * at_m.y
            );
            let text = strike.scene_toml.replacen("[[goal]]", &asked, 1);
            strike.scene = scene_from_toml(&text).expect("a valid scene");
            let led = strike.finished().estimate;
            assert_eq!(led.verdict, Verdict::Physical, "{kind:?} {seed}");
            let off_m = (landed_m(&strike, &led) - at_m).norm();
            assert!(off_m < 1e-6, "{kind:?} {seed}: {off_m}");
        }
    }
}

/// What does not follow from the law, does not touch, or goes through the table, is doubted.
#[test]
fn motions_that_break_the_law_are_doubted() {
    let strike = strike(&KINDS[0], &Acted::of(0.5), 8020);
    let outcome = strike.finished();
    let doubts = |estimate: &Estimate| -> Vec<About> {
        let doubts = verify::joined::doubts(
            &outcome.scene,
            &outcome.sketch,
            &outcome.marks_made_s,
            estimate,
        );
        doubts.iter().map(|doubt| doubt.about).collect()
    };
    let estimate = &outcome.estimate;
    assert_eq!(doubts(estimate), []);
    let time_s = hits_s(estimate)[0];
    let after = estimate.trees[0]
        .knots
        .iter()
        .rposition(|knot| knot.time_s == time_s);
    let after = after.expect("the state after the impact");

    let mut faster = estimate.clone();
    for knot in &mut faster.trees[0].knots[after..] {
        knot.state.rates[0] += 0.01;
    }
    assert_eq!(doubts(&faster).first(), None, "only positions are compared");
    for knot in &mut faster.trees[0].knots[after + 1..] {
        knot.state.coordinates[0] += 1e-4;
    }
    assert!(doubts(&faster).contains(&About::Steps));

    // The impact does not happen.
    let mut through = estimate.clone();
    through.trees[0].knots.remove(after);
    assert!(doubts(&through).contains(&About::Gap));

    // It happens 20 ms too soon, high above the table.
    let mut soon = estimate.clone();
    soon.events[1].time_s -= 0.02;
    for knot in &mut soon.trees[0].knots[after - 1..=after] {
        knot.time_s -= 0.02;
    }
    soon.trees[0]
        .knots
        .sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
    assert!(doubts(&soon).contains(&About::Gap));
}

/// What no sketch leads to, of a motion that is right in its own scene: a law that adds energy, a table on whose other
/// side the rods fly, rods so thick that they are inside of the table and of each other.
#[test]
fn what_a_scene_forbids_is_doubted() {
    let strike = strike(&KINDS[3], &Acted::of(0.5), 8021);
    let outcome = strike.finished();
    let doubts = |scene: &Scene| -> Vec<Doubt> {
        verify::joined::doubts(
            scene,
            &outcome.sketch,
            &outcome.marks_made_s,
            &outcome.estimate,
        )
    };
    let has = |doubts: &[Doubt], about: About| doubts.iter().any(|doubt| doubt.about == about);
    assert_eq!(doubts(&strike.scene), []);
    let mut gaining = strike.scene.clone();
    for law in &mut gaining.contact_laws {
        (law.restitution, law.friction) = (2.0, 0.0);
    }
    assert!(has(&doubts(&gaining), About::Energy));
    let said = |from: &str, to: &str| {
        let text = strike.scene_toml.replace(from, to);
        assert_ne!(text, strike.scene_toml);
        scene_from_toml(&text).expect("a valid scene")
    };
    let under = doubts(&said("normal = [0, 0, 1]", "normal = [0, 0, -1]"));
    assert!(has(&under, About::Receding) && has(&under, About::Overlap));
    let thick = doubts(&said("radius_mm = 2", "radius_mm = 90"));
    assert!(has(&thick, About::Overlap));
    let mut deep = said(
        "point_mm = [0, 0, 0]\nnormal",
        "point_mm = [0, 0, -9000]\nnormal",
    );
    assert!(!has(&doubts(&deep), About::Overlap));
    for link in &mut deep.links {
        link.shape = said("radius_mm = 2", "radius_mm = 90").links[LinkIndex(0)]
            .shape
            .clone();
    }
    let inside = doubts(&deep);
    let of_links = |doubt: &Doubt| match doubt.place {
        Place::Inside { link, against, .. } => {
            [Against::Link(LinkIndex(0)), Against::Link(LinkIndex(2))].contains(&against)
                && link != LinkIndex(1)
        }
        _ => false,
    };
    assert!(inside.iter().any(of_links), "{inside:?}");
}

/// With another table than the one that was hit, or with another law.
#[test]
fn a_scene_that_says_the_wrong_thing_is_not_physical() {
    for kind in &KINDS[..2] {
        let right = strike(kind, &Acted::of(0.5), 8030);
        let estimate = right.finished().estimate;
        assert_eq!(estimate.verdict, Verdict::Physical, "{kind:?}");
        let was = estimate.objective;
        let wrong = [
            // 60 mm above what was hit: the motion comes from and goes to below it.
            (
                "name = \"table\"\npoint_mm = [0, 0, 0]",
                "name = \"table\"\npoint_mm = [0, 0, 60]",
            ),
            // No restitution comes near the one with which it was acted.
            ("restitution = 0.5", "restitution = 0.0"),
        ];
        for (from, to) in wrong {
            let mut said = right.clone();
            said.scene_toml = right.scene_toml.replace(from, to);
            assert_ne!(said.scene_toml, right.scene_toml);
            said.scene = scene_from_toml(&said.scene_toml).expect("a valid scene");
            let estimate = said.finished().estimate;
            let is_worse = estimate.objective > 2.0 * was;
            // Or a hand strays from it less than what is said to be wrong explains.
            let is_doubted = estimate.verdict != Verdict::Physical;
            let is_suspected = estimate.fits() == Fits::No && !estimate.suspects.is_empty();
            assert!(is_doubted || is_worse || is_suspected, "{kind:?} {to}");
        }
    }
}

/// A goal at a waypoint is met, at a time of its own.
#[test]
fn a_waypoint_has_a_time_of_its_own() {
    let mut said = strike(&KINDS[1], &Acted::of(0.5), 8041);
    let estimate = said.finished().estimate;
    let (_, joined) = said.scene.joint_trees().next().expect("a tree");
    let tree = said.scene.tree_model(joined);
    let hit_s = said.impacts_s[0];
    let [by_s, mark_s] = [0.6 * hit_s, 0.6 * hit_s + 0.01];
    let mut snapshot = Snapshot::new(&tree, &estimate.gravity_m_s2);
    snapshot.set(&estimate.trees[0].state(&tree, &estimate.gravity_m_s2, by_s));
    let at_mm = snapshot.link_state(0).position_m * 1e3;
    let waypoint = "[[event]]\nname = \"by\"\nkind = \"waypoint\"\nbody = \"rod 1\"\n\n[[event]]\nname = \"hit 1\"";
    let goal = format!(
        "\n[[goal]]\nevent = \"by\"\nbody = \"rod 1\"\nposition_mm = [{:?}, {:?}, {:?}]\n",
        at_mm.x, at_mm.y, at_mm.z
    );
    said.scene_toml = said
        .scene_toml
        .replace("[[event]]\nname = \"hit 1\"", waypoint)
        + &goal;
    said.scene = scene_from_toml(&said.scene_toml).expect("a valid scene");
    said.mark("by", mark_s);
    let outcome = said.finished();
    let found = &outcome.estimate;
    assert_eq!(found.verdict, Verdict::Physical);
    for goal in said.scene.goals_attained(found) {
        assert!(goal.is_met(), "{goal:?}");
    }
    let found_s = hits_s(found)[0];
    assert!((found_s - by_s).abs() < 1e-3, "{found_s} {by_s}");
}

/// The whole program reads it, reports the impact and writes every frame.
#[test]
fn the_program_reports_the_impact() {
    let strike = strike(&KINDS[1], &Acted::of(0.5), 8050);
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("flail.mcap");
    strike.write(&path).unwrap();
    let report = ENACT.report(&path, &[]).said;
    assert_eq!(report["verdict"], "physical", "{report}");
    let hit = &report["events"][1];
    assert_eq!(hit["name"], "hit 1", "{report}");
    let off_s = hit["time_s"].as_f64().unwrap() - strike.impacts_s[0];
    assert!(off_s.abs() < 0.01, "{report}");
}

#[test]
fn what_is_not_done_of_impacts_is_refused() {
    let whole = strike(&KINDS[1], &Acted::of(1.0), 8060).scene_toml;
    assert!(scene_from_toml(&whole).is_ok());
    for (from, to, said) in [
        (
            "surface = \"table\"\nrestitution",
            "other = \"rod 1\"\nrestitution",
            "no joint ties",
        ),
        (
            "feature = \"end\"\nsurface",
            "features = [\"end\", \"top\"]\nsurface",
            "friction is for one contact",
        ),
        (
            "[[goal]]",
            "[[goal]]\nevent = \"hit 1\"\nbody = \"rod 1\"\ncontact = true\nposition_mm = [0, 0, 0]\n[[goal]]",
            "touches nothing",
        ),
    ] {
        let text = whole.replacen(from, to, 1);
        assert_ne!(text, whole, "{from}");
        let error = scene_from_toml(&text).unwrap_err().to_string();
        assert!(error.contains(said), "{to}: {error}");
    }
}
