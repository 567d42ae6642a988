//! Joined bodies that hit something, in scenes that do not say what touches, through the program.

use enact::config::scene_from_toml;
use enact::motion::{Observer, Phase, Scene, Standing, Undetermined, Verdict};
use enact::pipeline::{Outcome, Pipeline};
use enact_tools::replay::Program;
use enact_tools::tree_impacts::{Acted, Form, Strike, Struck, strike};
use enact_tools::tree_meetings::{Meet, Met, meet};
use enact_tools::trees::Jointed;
use tempfile::TempDir;

const ENACT: Program = Program(env!("CARGO_BIN_EXE_enact"));

const fn flail(form: Form, joints: Jointed) -> Struck {
    Struck {
        form,
        links: 2,
        joints,
        hangs_m: None,
        impacts: 1,
        law: [0.5, 0.2],
    }
}

/// The performance in a scene of which the text is changed.
fn said(strike: &Strike, change: impl Fn(&str) -> String) -> Strike {
    let scene_toml = change(&strike.scene_toml);
    assert_ne!(scene_toml, strike.scene_toml);
    Strike {
        scene: scene_from_toml(&scene_toml).expect("a valid scene"),
        scene_toml,
        ..strike.clone()
    }
}

/// Without a word of what touches.
fn opened(text: &str) -> String {
    let keys = ["feature = ", "surface = ", "other_feature = "];
    let lines = text.lines();
    let kept = lines.filter(|line| !keys.iter().any(|key| line.starts_with(key)));
    kept.map(|line| format!("{line}\n")).collect()
}

fn finished(strike: &Strike, observer: &mut dyn Observer) -> Outcome {
    let events = strike.events.iter().cloned();
    let outcome = Pipeline::of(strike.scene.clone(), events).finish(observer);
    outcome.expect("an estimate")
}

fn touches(scene: &Scene) -> Option<String> {
    scene.contact_words(1)
}

/// Of a recording whose scene is silent about it, the program infers, reports and marks what touches: an end of a rod, a
/// corner of a plank among 26 features, the face of a box that another feature of a rod hits.
#[test]
fn the_program_infers_what_touches() {
    let acted = Acted::of(0.5);
    let on_a_box = Meet {
        links: 2,
        joints: Jointed::Ball,
        hangs_m: None,
        met: Met::Box,
        law: [0.5, 0.2],
    };
    for right in [
        strike(&flail(Form::Rod, Jointed::Ball), &acted, 7150),
        strike(&flail(Form::Plank, Jointed::Ball), &acted, 7151),
        meet(&on_a_box, &acted, 7152),
    ] {
        let open = said(&right, opened);
        let folder = TempDir::new().unwrap();
        let path = folder.path().join("open.mcap");
        open.write(&path).unwrap();
        let report = ENACT.report(&path, &[]).said;
        let hit = &report["events"][1];
        assert_eq!(report["verdict"], "physical", "{report}");
        assert_eq!(hit["contact_inferred"], true, "{report}");
        let truth = touches(&right.scene).expect("it is named");
        assert_eq!(hit["contact"], truth.as_str(), "{report}");
    }
}

/// What is inferred leads to the very motion that it leads to where the scene names it.
#[test]
fn the_motion_is_that_of_the_scene_that_names_it() {
    let right = strike(&flail(Form::Rod, Jointed::Ball), &Acted::of(0.5), 7153);
    let named = finished(&right, &mut ());
    let open = finished(&said(&right, opened), &mut ());
    assert_eq!(open.scene, named.scene);
    assert_eq!(open.inferred, [1]);
    assert_eq!(open.estimate.contact_rivals, []);
    assert_eq!(open.estimate.trees, named.estimate.trees);
    assert_eq!(open.estimate.objective, named.estimate.objective);
}

/// Where what hit is not among what may, every motion is doubted: another part touches first.
#[test]
fn a_wrong_neighbour_is_not_physical() {
    let right = strike(&flail(Form::Rod, Jointed::Ball), &Acted::of(0.5), 7154);
    assert_eq!(touches(&right.scene).as_deref(), Some("end on table"));
    for wrong in [
        "near = [0, 0, -70.0]",
        "near = [0, 0, -70.0], middle = [0, 0, 0]",
    ] {
        let open = said(&right, |text| {
            opened(text).replace("end = [0, 0, -100.0]", wrong)
        });
        let outcome = finished(&open, &mut ());
        let verdict = outcome.estimate.verdict;
        assert_ne!(verdict, Verdict::Physical, "{:?}", touches(&outcome.scene));
    }
}

/// Two features in one place are not told apart by any performance: the account says so, and the motion is not called
/// determined.
#[test]
fn what_cannot_be_told_apart_is_said() {
    let right = strike(&flail(Form::Rod, Jointed::Ball), &Acted::of(0.5), 7155);
    let open = said(&right, |text| {
        let end = "end = [0, 0, -100.0]";
        opened(text).replace(end, &format!("{end}, beside = [0, 0, -100.0]"))
    });
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("open.mcap");
    open.write(&path).unwrap();
    let answer = ENACT.report(&path, &[]).said;
    let hit = &answer["events"][1];
    let both = ["end on table", "beside on table"];
    let other = both.iter().find(|of| hit["contact"] != **of).unwrap();
    let rivals = serde_json::json!([{ "contact": other, "standing": "alike" }]);
    assert_eq!(hit["contact_rivals"], rivals, "{answer}");
    assert_eq!(answer["determined"], false, "{answer}");
    let undetermined = answer["undetermined"].as_array().unwrap();
    assert!(
        undetermined.contains(&"contact of hit 1".into()),
        "{answer}"
    );
}

/// Stops so many questions after the likeliest contact has its motion.
struct Hasty {
    phases: usize,
    asked: usize,
}

impl Observer for Hasty {
    fn phase(&mut self, phase: Phase) {
        self.phases += usize::from(phase == Phase::Sequence);
    }

    fn should_stop(&mut self) -> bool {
        // The first is the ranking.
        self.asked -= usize::from(self.phases > 1).min(self.asked);
        self.asked == 0
    }
}

/// What was not tried, or led to no motion, is not ruled out: the contact is not certain then.
#[test]
fn a_rival_without_a_motion_is_not_ruled_out() {
    let right = strike(&flail(Form::Rod, Jointed::Ball), &Acted::of(0.5), 7155);
    let open = said(&right, |text| {
        let end = "end = [0, 0, -100.0]";
        opened(text).replace(end, &format!("{end}, beside = [0, 0, -100.0]"))
    });
    for (asked, standing) in [(1, Standing::Untried), (2, Standing::Lost)] {
        let hasty = &mut Hasty { phases: 0, asked };
        let outcome = finished(&open, hasty);
        let rivals = &outcome.estimate.contact_rivals;
        let standings: Vec<Standing> = rivals.iter().map(|of| of.standing).collect();
        assert_eq!(standings, [standing], "{rivals:?}");
        let undetermined = &outcome.estimate.undetermined;
        assert!(undetermined.contains(&Undetermined::Contact(1)));
    }
}
