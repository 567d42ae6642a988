//! Joined bodies that meet bodies by themselves or another tree, through the program.

use enact::config::scene_from_toml;
use enact::motion::{About, Estimate, Scene, Verdict};
use enact::physics::flow;
use enact::physics::tree::{ForestSnapshot, TreeState};
use enact::verify;
use enact_tools::replay::Program;
use enact_tools::tree_impacts::Acted;
use enact_tools::tree_meetings::{Meet, Met, meet};
use enact_tools::trees::Jointed;
use nalgebra::Vector3;
use tempfile::TempDir;

const ENACT: Program = Program(env!("CARGO_BIN_EXE_enact"));

const fn of(links: usize, joints: Jointed, hangs_m: Option<f64>, met: Met) -> Meet {
    Meet {
        links,
        joints,
        hangs_m,
        met,
        law: [0.5, 0.2],
    }
}

/// A flail that hits a box in flight, a hanging one, a chain's end on a ball, two pendulums.
const KINDS: [Meet; 4] = [
    of(2, Jointed::Ball, None, Met::Box),
    of(2, Jointed::Universal, Some(0.9), Met::Box),
    of(3, Jointed::Universal, None, Met::Ball),
    of(2, Jointed::Pin, Some(0.9), Met::Pendulum),
];

fn hit_s(estimate: &Estimate) -> f64 {
    let mut free = estimate.events.iter().filter(|event| !event.is_fixed);
    free.next().expect("one impact").time_s
}

/// From exact samples and marks, motion and time of the impact come back.
#[test]
fn an_exact_sketch_gives_motion_and_meeting_back() {
    for kind in &KINDS {
        for seed in 8100..8102 {
            let strike = meet(kind, &Acted::EXACT, seed);
            let estimate = strike.finished().estimate;
            assert_eq!(estimate.verdict, Verdict::Physical, "{kind:?} {seed}");
            let off_s = (hit_s(&estimate) - strike.impacts_s[0]).abs();
            // The prior on the rates at the start draws by as much.
            assert!(off_s < 2e-5, "{kind:?} {seed}: {off_s}");
            let off = strike.coordinates_off(&estimate);
            assert!(off < 0.005, "{kind:?} {seed}: {off}");
        }
    }
}

/// Rough sketches: what meets touches, its normal speed turns round by the law, no energy is created, and what flies
/// keeps its momentum together.
#[test]
fn rough_sketches_meet_by_the_law() {
    let mut physical = 0;
    for kind in &KINDS {
        for seed in 8110..8112 {
            let strike = meet(kind, &Acted::of(1.0), seed);
            let estimate = strike.finished().estimate;
            if estimate.verdict != Verdict::Physical {
                continue;
            }
            physical += 1;
            for goal in strike.scene.goals_attained(&estimate) {
                assert!(goal.is_met(), "{kind:?} {seed}: {goal:?}");
            }
            meets(&strike.scene, &estimate);
        }
    }
    assert!(physical >= 6, "{physical} of 8");
}

/// Gap, normal speed, kinetic energy and momentum, from states of links alone.
fn meets(scene: &Scene, estimate: &Estimate) {
    let time_s = hit_s(estimate);
    let forest = scene.forest();
    let after = scene.forest_state(estimate, &forest, time_s).unwrap();
    let mut before = after.clone();
    for motion in &estimate.trees {
        let knot = motion.knots.iter().find(|knot| knot.time_s == time_s);
        let rates = forest.rates_of(usize::from(motion.mechanism));
        before.rates[rates].copy_from_slice(&knot.expect("a state before").state.rates);
    }
    for arc in estimate.arcs.iter().filter(|arc| arc.end_s == time_s) {
        let body = scene.body_of(arc.mechanism);
        let state = flow::advance(
            body,
            &estimate.gravity_m_s2,
            &arc.state,
            time_s - arc.epoch_s,
        );
        let rates = forest.rates_of(usize::from(arc.mechanism));
        before.rates[rates].copy_from_slice(&TreeState::of_body(&state).rates);
    }
    let touch = scene.tree_touch(1).expect("a named contact");
    let other = touch.at.other.expect("a link");
    let both = [&before, &after].map(|state| {
        let mut snapshot = ForestSnapshot::new(&forest, &estimate.gravity_m_s2);
        snapshot.set(state);
        let [a, b] = [touch.at.place, other].map(|place| snapshot.link_state(place));
        let frames = [&a, &b].map(enact::physics::contact::Frame::of);
        let at = touch.at.contacts.as_slice()[0]
            .touch(&frames[0], &frames[1])
            .unwrap();
        let speed = |of: &enact::physics::State, point_m: &Vector3<f64>| {
            let spin = of.angular_velocity_rad_s.cross(point_m);
            at.normal.dot(&(of.velocity_m_s + of.orientation * spin))
        };
        let speed_m_s = speed(&a, &at.on_a_m) - speed(&b, &at.on_b_m);
        let (mut energy_j, mut momenta) = (0.0, [Vector3::zeros(); 2]);
        let of_a = scene.mechanism_of(scene.forest_links().nth(touch.at.place).expect("A"));
        for (place, link) in scene.forest_links().enumerate() {
            let (body, of) = (&scene.links[link].body, snapshot.link_state(place));
            let spin = of.angular_velocity_rad_s;
            let turning = spin.component_mul(&body.moments_kg_m2()).dot(&spin);
            energy_j += 0.5 * (body.mass_kg() * of.velocity_m_s.norm_squared() + turning);
            let side = usize::from(scene.mechanism_of(link) != of_a);
            momenta[side] += of.velocity_m_s * body.mass_kg();
        }
        (at.gap_m, speed_m_s, energy_j, momenta)
    });
    let [was, is] = both;
    assert!(was.0.abs() < 1e-6 && is.0.abs() < 1e-6, "{both:?}");
    assert!(
        was.1 < -0.1 && (is.1 + 0.5 * was.1).abs() < 1e-6,
        "{both:?}"
    );
    assert!(is.2 < was.2, "{both:?}");
    if forest.trees().iter().all(|tree| tree.translations() > 0) {
        let all = [is.3, was.3].map(|of| of[0] + of[1]);
        assert!((all[0] - all[1]).norm() < 1e-9, "{both:?}");
    }
    // What is told of it is what both sides do; what hangs from the world gives some of it there.
    let mut events = estimate.events.iter();
    let event = events.find(|event| event.time_s == time_s).expect("it");
    let knocks = estimate.knocks(scene, event);
    assert_eq!(knocks.len(), 1);
    assert!(
        (knocks[0].approach_m_s() + was.1).abs() < 1e-6,
        "{knocks:?}"
    );
    assert!((knocks[0].parting_m_s() - is.1).abs() < 1e-6, "{knocks:?}");
    let of_a = forest.tree_of(touch.at.place).0;
    for (tree, of) in forest.trees().iter().enumerate() {
        let (side, sign) = if tree == of_a { (0, 1.0) } else { (1, -1.0) };
        let gained = (is.3[side] - was.3[side]) * sign;
        let off = (gained - knocks[0].impulse_n_s).norm();
        assert!(of.translations() == 0 || off < 1e-7, "{off} of {gained}");
    }
}

/// A box that does not follow from the law, one that is elsewhere, a law that adds energy.
#[test]
fn meetings_that_break_the_law_are_doubted() {
    let strike = meet(&KINDS[0], &Acted::of(0.5), 8120);
    let outcome = strike.finished();
    let doubts = |scene: &Scene, estimate: &Estimate| -> Vec<About> {
        let doubts =
            verify::joined::doubts(scene, &outcome.sketch, &outcome.marks_made_s, estimate);
        doubts.iter().map(|doubt| doubt.about).collect()
    };
    let (scene, estimate) = (&strike.scene, &outcome.estimate);
    assert_eq!(doubts(scene, estimate), []);
    assert_eq!(estimate.arcs.len(), 2, "a flight before and one after");

    // The box flies on as if nothing had hit it, or a little faster than it must.
    let mut through = estimate.clone();
    through.arcs[1].state.velocity_m_s = through.arcs[0].state.velocity_m_s;
    assert!(doubts(scene, &through).contains(&About::Steps));
    let mut faster = estimate.clone();
    faster.arcs[1].state.velocity_m_s.x += 1e-4;
    assert!(doubts(scene, &faster).contains(&About::Steps));

    // It is beside what hits it, in all of its motion.
    let mut beside = estimate.clone();
    for arc in &mut beside.arcs {
        arc.state.position_m += Vector3::new(0.01, 0.01, 0.01);
    }
    let found = doubts(scene, &beside);
    assert!(found.contains(&About::Gap), "{found:?}");
    // It has no motion.
    let mut none = estimate.clone();
    (none.arcs, none.residuals) = (Vec::new(), Vec::new());
    assert!(doubts(scene, &none).contains(&About::Steps));

    let mut gaining = scene.clone();
    for law in &mut gaining.contact_laws {
        (law.restitution, law.friction) = (2.0, 0.0);
    }
    assert!(doubts(&gaining, estimate).contains(&About::Energy));
    // Rods so thick that they are inside of the box.
    let text = strike
        .scene_toml
        .replace("radius_mm = 5.0", "radius_mm = 60.0");
    assert_ne!(text, strike.scene_toml);
    let thick = scene_from_toml(&text).expect("a valid scene");
    let found = doubts(&thick, estimate);
    assert!(found.contains(&About::Overlap), "{found:?}");
    // A box that was acted too fast for any hand, and far from its samples.
    let mut thrown = estimate.clone();
    for arc in &mut thrown.arcs {
        arc.state.velocity_m_s.x += 200.0;
    }
    assert!(doubts(scene, &thrown).contains(&About::Speed));
    let mut off = estimate.clone();
    off.residuals[0].position_rms_m = Some(0.08);
    assert!(doubts(scene, &off).contains(&About::Residual));
}

/// Without the meeting in its scene, or with another law, the motion is not as near.
#[test]
fn a_scene_that_says_the_wrong_law_is_not_physical() {
    let right = meet(&KINDS[0], &Acted::of(0.5), 8130);
    let estimate = right.finished().estimate;
    assert_eq!(estimate.verdict, Verdict::Physical);
    let mut said = right.clone();
    said.scene_toml = right
        .scene_toml
        .replace("other_feature = \"face +z\"", "other_feature = \"face -z\"");
    assert_ne!(said.scene_toml, right.scene_toml);
    said.scene = scene_from_toml(&said.scene_toml).expect("a valid scene");
    let wrong = said.finished().estimate;
    assert_ne!(wrong.verdict, Verdict::Physical, "hit on the other side");
}

/// The whole program reads it, reports the impact and the flights of the box, and writes every frame of all bodies.
#[test]
fn the_program_reports_the_meeting() {
    let strike = meet(&KINDS[0], &Acted::of(0.5), 8140);
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("flail_box.mcap");
    strike.write(&path).unwrap();
    let report = ENACT.report(&path, &[]).said;
    assert_eq!(report["verdict"], "physical", "{report}");
    let hit = &report["events"][1];
    assert_eq!(hit["name"], "hit 1", "{report}");
    let off_s = hit["time_s"].as_f64().unwrap() - strike.impacts_s[0];
    assert!(off_s.abs() < 0.01, "{report}");
    let segments = report["segments"].as_array().unwrap();
    let of = |body: &str| segments.iter().filter(|of| of["body"] == body).count();
    assert_eq!([of("rod 1"), of("rod 2"), of("box")], [1, 1, 2], "{report}");
}

#[test]
fn meetings_that_are_not_done_are_refused() {
    let whole = meet(&KINDS[0], &Acted::of(1.0), 8150).scene_toml;
    assert!(scene_from_toml(&whole).is_ok());
    let (from, to) = (
        "other = \"box\"\nother_feature = \"face +z\"",
        "other = \"rod 1\"\nother_feature = \"end -z\"",
    );
    let text = whole.replacen(from, to, 1);
    assert_ne!(text, whole, "{from}");
    let error = scene_from_toml(&text).unwrap_err().to_string();
    assert!(error.contains("no joint ties"), "{error}");
}
