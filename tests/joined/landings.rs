//! Joined bodies that come down on several corners at once, through the program.

use enact::config::scene_from_toml;
use enact::motion::{About, Estimate, Scene, Verdict};
use enact::physics::contact::Frame;
use enact::physics::tree::ForestSnapshot;
use enact_tools::replay::Program;
use enact_tools::tree_impacts::Acted;
use enact_tools::tree_meetings::{Meet, Met, meet};
use enact_tools::trees::Jointed;
use tempfile::TempDir;

const ENACT: Program = Program(env!("CARGO_BIN_EXE_enact"));

const fn of(links: usize, joints: Jointed, corners: usize) -> Meet {
    Meet {
        links,
        joints,
        hangs_m: None,
        met: Met::Table(corners),
        law: [0.5, 0.0],
    }
}

/// On an edge, and on a face.
const KINDS: [Meet; 4] = [
    of(2, Jointed::Ball, 2),
    of(2, Jointed::Pin, 3),
    of(3, Jointed::Universal, 2),
    of(3, Jointed::Universal, 3),
];

/// From exact samples and marks, motion and time of the impact come back.
#[test]
fn an_exact_sketch_gives_motion_and_landing_back() {
    for kind in &KINDS {
        let strike = meet(kind, &Acted::EXACT, 8400);
        let estimate = strike.finished().estimate;
        assert_eq!(estimate.verdict, Verdict::Physical, "{kind:?}");
        let off_s = (estimate.events[1].time_s - strike.impacts_s[0]).abs();
        // The prior on the rates at the start draws by as much.
        assert!(off_s < 2e-5, "{kind:?}: {off_s}");
        let off = strike.coordinates_off(&estimate);
        assert!(off < 0.005, "{kind:?}: {off}");
    }
}

/// Rough sketches: every corner touches, its normal speed turns round by the law, and energy is lost.
#[test]
fn rough_sketches_land_by_the_law() {
    let mut physical = 0;
    for kind in &KINDS {
        for seed in 8410..8412 {
            let strike = meet(kind, &Acted::of(1.0), seed);
            let estimate = strike.finished().estimate;
            if estimate.verdict != Verdict::Physical {
                continue;
            }
            physical += 1;
            for goal in strike.scene.goals_attained(&estimate) {
                assert!(goal.is_met(), "{kind:?} {seed}: {goal:?}");
            }
            lands(&strike.scene, &estimate);
        }
    }
    assert!(physical >= 6, "{physical} of 8");
}

/// Gaps, normal speeds and kinetic energy on both sides of the impact, from states of links alone.
fn lands(scene: &Scene, estimate: &Estimate) {
    let (motion, time_s) = (&estimate.trees[0], estimate.events[1].time_s);
    let at_hit: Vec<_> = motion
        .knots
        .iter()
        .filter(|of| of.time_s == time_s)
        .collect();
    let touch = scene.tree_touch(1).expect("named corners");
    let forest = scene.forest();
    let mut snapshot = ForestSnapshot::new(&forest, &estimate.gravity_m_s2);
    let both = [0, 1].map(|side| {
        snapshot.set(&at_hit[side].state);
        let link = snapshot.link_state(touch.at.place);
        let spin = link.orientation * link.angular_velocity_rad_s;
        let corners = touch.at.contacts.as_slice().iter().map(|contact| {
            let at = contact.touch(&Frame::of(&link), &Frame::world()).unwrap();
            let lever_m = link.orientation * at.on_a_m;
            (at.gap_m, (link.velocity_m_s + spin.cross(&lever_m)).z)
        });
        let corners: Vec<(f64, f64)> = corners.collect();
        (corners, snapshot.kinetic_energy_at(&touch.at))
    });
    let [(before, was_j), (after, is_j)] = &both;
    assert!(before.len() > 1 && before.len() == after.len());
    for (before, after) in before.iter().zip(after) {
        assert!(before.0.abs() < 1e-6 && after.0.abs() < 1e-6, "{both:?}");
        let rebound = after.1 + 0.5 * before.1;
        assert!(before.1 < 0.0 && rebound.abs() < 1e-6, "{both:?}");
    }
    assert!(is_j < was_j, "{both:?}");
}

/// Where the best motion that lands on all corners would have one of them pull, it is doubted, and the report says so. Of this
/// sketch only the motion does whose samples count one by one.
#[test]
fn a_corner_that_pulls_is_doubted() {
    let mut strike = meet(&KINDS[1], &Acted::of(1.0), 8403);
    strike.scene_toml.insert_str(0, "hand = \"none\"\n");
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("flail.mcap");
    strike.write(&path).unwrap();
    let report = ENACT.report(&path, &[]).said;
    assert_eq!(report["verdict"], "plausible", "{report}");
    let doubts = report["doubts"].as_array().expect("doubts");
    let pull = doubts
        .iter()
        .find(|of| of["quantity"] == About::Pull.as_str());
    let pull = pull.expect("a corner that pulls");
    assert_eq!(pull["at"], "hit 1", "{report}");
    let text = pull["text"].as_str().expect("words");
    assert!(
        text.starts_with("at `hit 1` one of the contacts pulls"),
        "{text}"
    );
}

/// Where the scene does not say on what, it is inferred.
#[test]
fn the_surface_below_is_inferred() {
    let mut strike = meet(&KINDS[0], &Acted::of(0.5), 8420);
    let named = strike.finished();
    assert_eq!(named.estimate.verdict, Verdict::Physical);
    let open = strike.scene_toml.replacen("]\nsurface = \"table\"", "]", 1);
    assert_ne!(open, strike.scene_toml);
    strike.scene = scene_from_toml(&open).expect("a valid scene");
    let inferred = strike.finished();
    assert_eq!(inferred.inferred, [1]);
    assert_eq!(inferred.estimate.verdict, Verdict::Physical);
    let off = inferred.estimate.objective / named.estimate.objective - 1.0;
    assert!(off.abs() < 1e-6, "{off}");
}

/// An edge along the axis of the one pin that a plank hangs on: both corners always come down together.
#[test]
fn corners_that_always_touch_together_are_refused() {
    let scene = |axis: &str| {
        format!(
            "name = \"gate\"\n[timing]\nstamps = \"physical\"\n\
             [[surface]]\nname = \"table\"\npoint_mm = [0, 0, 0]\nnormal = [0, 0, 1]\n\
             [[body]]\nname = \"plank\"\nshape = {{ kind = \"cuboid\", size_mm = [60, 40, 300] }}\nmass_g = 100\n\
             [[joint]]\nname = \"nail\"\nkind = {axis}\nparent_at_mm = [0, 0, 250]\n\
             child = \"plank\"\nchild_at_mm = [0, 0, 150]\n\
             [[event]]\nname = \"start\"\nkind = \"start\"\n\
             [[event]]\nname = \"hit\"\nkind = \"collision\"\nbody = \"plank\"\n\
             features = [\"corner -x -y -z\", \"corner +x -y -z\"]\nsurface = \"table\"\nrestitution = 0.5\n\
             [[event]]\nname = \"end\"\nkind = \"end\"\n"
        )
    };
    let error = scene_from_toml(&scene("\"pin\"\naxis = [1, 0, 0]")).unwrap_err();
    let said = error.to_string();
    assert!(said.contains("always touch together"), "{said}");
    scene_from_toml(&scene("\"ball\"")).expect("a ball joint lets one come down first");
}
