//! One answer from many takes of joined bodies.

use std::path::{Path, PathBuf};

use enact::config::{scene_from_toml, share};
use enact::pipeline::Pipeline;
use enact_tools::beside::Beside;
use enact_tools::perform::recording::write_events_of;
use enact_tools::trees::{self, Jointed, Kind, TreeActing, TreePerformance};
use tempfile::TempDir;

use crate::fit::{fit, lines, words};

const PENDULUM: Kind = Kind::pendulum(2, Jointed::Pin);

fn performed(seed: u64) -> TreePerformance {
    let acting = TreeActing {
        asks_start: false,
        ..TreeActing::of(0.0)
    };
    trees::perform(&PENDULUM, &acting, seed)
}

/// Takes of which the scene says what is not so.
fn written(folder: &Path, count: u64, seed: u64, said: impl Fn(&str) -> String) -> Vec<PathBuf> {
    let each = (0..count).map(|take| {
        let path = folder.join(format!("take_{take}.mcap"));
        let mut performance = performed(seed + take);
        performance.scene_toml = said(&performance.scene_toml);
        performance.scene = scene_from_toml(&performance.scene_toml).expect("a scene");
        performance.write(&path).expect("a recording");
        path
    });
    each.collect()
}

#[test]
fn gradient_and_curvature_of_a_share_are_those_of_differences() {
    let performance = performed(8301);
    let mut scene = performance.scene.clone();
    let names = ["gravity.y", "gravity.z", "joint 2.child.z"].map(str::to_owned);
    let parameters = share(&mut scene, &names).expect("they are free");
    let lengths: Vec<f64> = parameters
        .iter()
        .map(|of| scene.parameters[*of].length())
        .collect();
    let pipeline = Pipeline::of(scene, performance.events.iter().cloned());
    let mut take = pipeline.shared(&parameters, &mut ()).expect("a motion");
    let here = take.values();
    let share = take.at(&here, &mut ()).expect("a share");
    for (at, length) in lengths.iter().enumerate() {
        let step = 1e-5 * length;
        let [less, more] = [-step, step].map(|by| {
            let mut there = here.clone();
            there[at] += by;
            take.clone().at(&there, &mut ()).expect("a share")
        });
        let size = share.curvature[(at, at)] * step;
        let slope = (more.cost - less.cost) / (2.0 * step);
        let off = (slope - share.gradient[at]).abs();
        assert!(
            off <= 1e-2 * size.max(share.gradient[at].abs()),
            "{at}: {off} of {size}"
        );
        let change = (more.gradient - less.gradient) / (2.0 * step);
        for (other, change) in change.iter().enumerate() {
            let of = share.curvature[(other, at)];
            let size = (share.curvature[(at, at)] * share.curvature[(other, other)]).sqrt();
            // Second derivatives of a motion are those of a coarse reading of it.
            assert!(
                (change - of).abs() <= 3e-2 * size,
                "{at} {other}: {change} {of} {size}"
            );
        }
    }
}

/// The scene says another gravity: twelve swings say what is true, and that the joint is where it says.
#[test]
fn takes_of_a_pendulum_tell_gravity_and_where_its_joint_is() {
    let folder = TempDir::new().expect("folder");
    let files = written(folder.path(), 12, 8310, |scene| {
        format!("gravity_m_s2 = [0, 0, -9.6]\n{scene}")
    });
    let asked = [
        "--shared",
        "gravity.z,joint 2.child.z",
        "--format",
        "ndjson",
    ];
    let output = fit(folder.path(), 2, &words(&files, &asked));
    let answers = lines(&output, "enact.fit/1");
    let [answer] = answers.as_slice() else {
        panic!("{output:?}");
    };
    assert_eq!(answer["takes"], 12);
    let known = [
        ("gravity.z", -9.80665, 0.02),
        ("joint 2.child.z", 0.0, 1e-4),
    ];
    for (name, truth, width) in known {
        let mut parameters = answer["parameters"].as_array().expect("a list").iter();
        let of = parameters.find(|of| of["name"] == name).expect("told");
        let [lower, upper] = [0, 1].map(|end| of["interval"][end].as_f64().expect("an end"));
        assert!(lower <= truth && truth <= upper, "{of}");
        assert!(upper - lower < width, "{of}");
    }
}

/// What moves apart from joined bodies is another problem.
#[test]
fn joined_bodies_and_others_apart_from_them_are_refused_by_name() {
    let folder = TempDir::new().expect("folder");
    let of = Beside::of(8520);
    let toml = of.toml("", "");
    let scene = scene_from_toml(&toml).expect("a scene");
    let path = folder.path().join("take.mcap");
    write_events_of(&scene, &toml, &of.take(), &path).expect("a recording");
    let asked = ["--shared", "bounce.restitution"];
    let output = fit(folder.path(), 1, &words(&[path], &asked));
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("others that move apart from them"), "{said}");
}
