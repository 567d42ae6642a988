//! One answer from many takes: the optimum of all of them in one problem, the same for any order and any number of threads, and
//! what `enact fit` says, writes, refuses and leaves alone.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use enact::config::{scene_from_toml, share};
use enact::jointly::{JointParameter, JointSearch, SearchTurn};
use enact::motion::{Scene, TakeEvent, TakeShare};
use enact::pipeline::{Pipeline, SharedTake};
use enact_tools::fits::{BallTruth, Over};
use nalgebra::DVector;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde_json::Value;
use tempfile::TempDir;

/// Names that most tests share.
const SHARED: [&str; 4] = [
    "ball.restitution",
    "ball.friction",
    "gravity",
    "ball.tracker",
];

fn truth(seed: u64) -> BallTruth {
    BallTruth::drawn(&mut ChaCha8Rng::seed_from_u64(seed))
}

/// Motions of takes, which begin at the truth.
fn motions(truth: &BallTruth, count: usize, seed: u64) -> (Vec<JointParameter>, Vec<SharedTake>) {
    let names = SHARED.map(str::to_owned);
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let (mut scene, takes) = truth.takes(count, &mut random);
    let parameters = share(&mut scene, &names).expect("they are free");
    let values = truth.values();
    for parameter in &parameters {
        let free = &mut scene.parameters[*parameter];
        let known = values.iter().find(|(name, _)| *name == free.name);
        free.initial = known.expect("its truth").1;
    }
    let motions = takes.into_iter().map(|events| {
        let pipeline = Pipeline::of(scene.clone(), events);
        pipeline.shared(&parameters, &mut ()).expect("a motion")
    });
    let motions = motions.collect();
    let asked = parameters.iter();
    let asked = asked.map(|of| JointParameter::new(&scene.parameters[*of], false));
    (asked.collect(), motions)
}

fn asked(joint: &JointSearch, motions: &mut [SharedTake]) -> Vec<Option<TakeShare>> {
    let each = motions.iter_mut().enumerate();
    each.map(|(at, motion)| motion.at(&joint.asked(at), &mut ()))
        .collect()
}

fn solved(parameters: Vec<JointParameter>, motions: &mut [SharedTake]) -> JointSearch {
    let own = motions
        .iter_mut()
        .map(|motion| motion.at(&motion.values(), &mut ()));
    let own: Vec<Option<TakeShare>> = own.collect();
    let mut joint = JointSearch::new(parameters, &own);
    loop {
        let shares = asked(&joint, motions);
        match joint.turn(&shares) {
            SearchTurn::Again => {}
            SearchTurn::Found => return joint,
            SearchTurn::Lost => panic!("lost"),
        }
    }
}

fn cost(motions: &[SharedTake], values: &DVector<f64>) -> f64 {
    let costs = motions.iter().map(|motion| {
        let share = motion.clone().at(values, &mut ());
        share.expect("a motion near by").cost
    });
    costs.sum()
}

#[test]
fn gradient_and_curvature_of_a_share_are_those_of_differences() {
    let (parameters, mut motions) = motions(&truth(31), 2, 32);
    for motion in &mut motions {
        let here = motion.values();
        let share = motion.at(&here, &mut ()).expect("a motion");
        for (at, parameter) in parameters.iter().enumerate() {
            let step = 1e-5 * parameter.length;
            let at_step = |by: f64| {
                let mut there = here.clone();
                there[at] += by;
                motion.clone().at(&there, &mut ()).expect("a motion")
            };
            let [less, more] = [at_step(-step), at_step(step)];
            let slope = (more.cost - less.cost) / (2.0 * step);
            let size = share.curvature[(at, at)] * step;
            let off = (slope - share.gradient[at]).abs();
            assert!(
                off <= 1e-3 * size.max(share.gradient[at].abs()),
                "{}: {off}",
                parameter.name
            );
            let change = (more.gradient - less.gradient) / (2.0 * step);
            for other in 0..parameters.len() {
                let of = share.curvature[(other, at)];
                let size = (share.curvature[(at, at)] * share.curvature[(other, other)]).sqrt();
                let off = (change[other] - of).abs();
                assert!(
                    off <= 1e-3 * size,
                    "{} {other}: {off} of {size}",
                    parameter.name
                );
            }
        }
    }
}

/// The sum of the costs alone, without any derivative of the program, is least there: to 1e-8 of each parameter's length.
#[test]
fn the_joint_optimum_is_where_the_sum_of_costs_is_least() {
    let (parameters, mut motions) = motions(&truth(41), 5, 42);
    let joint = solved(parameters.clone(), &mut motions);
    let found = joint.values();
    let shares = asked(&joint, &mut motions);
    let curvature = shares.iter().flatten().map(|of| of.curvature.clone());
    let curvature = curvature.reduce(|a, b| a + b).expect("shares");
    let middle = cost(&motions, &found);
    for (at, parameter) in parameters.iter().enumerate() {
        let sd = curvature[(at, at)].sqrt().recip();
        let at_step = |by: f64| {
            let mut there = found.clone();
            there[at] += by * sd;
            cost(&motions, &there)
        };
        assert!(at_step(-1.0) > middle && at_step(1.0) > middle);
        // The odd part with its third order taken off, by two steps.
        let odd = |by: f64| 0.5 * (at_step(by) - at_step(-by)) / by;
        let slope = (4.0 * odd(0.1) - odd(0.2)) / 3.0;
        let off = slope * sd / parameter.length;
        assert!(off.abs() < 1e-8, "{}: {off:e}", parameter.name);
    }
}

/// Ten balls that fly in one scene share its gravity, which the program estimates in one problem.
#[test]
fn ten_takes_have_the_optimum_of_ten_bodies_in_one_problem() {
    let count = 10;
    let body = |name: &str| {
        format!(
            "[[body]]\nname = \"{name}\"\nshape = {{ kind = \"sphere\", radius_mm = 30 }}\nmass_g = 110\n"
        )
    };
    let scene = |bodies: &str| {
        let toml = format!(
            "name = \"flights\"\nhand = \"none\"\n[timing]\nstamps = \"physical\"\n{bodies}\
             [[event]]\nname = \"go\"\nkind = \"start\"\n[[event]]\nname = \"end\"\nkind = \"end\"\n\
             [[free]]\nquantity = \"gravity.x\"\n[[free]]\nquantity = \"gravity.y\"\n[[free]]\nquantity = \"gravity.z\"\n"
        );
        scene_from_toml(&toml).expect("a scene")
    };
    let mut random = ChaCha8Rng::seed_from_u64(51);
    let truth = truth(52);
    let flights: Vec<Vec<TakeEvent>> = (0..count).map(|_| truth.flight(0.4, &mut random)).collect();
    let names: Vec<String> = (0..count).map(|at| format!("ball {at}")).collect();
    let together = scene(&names.iter().map(|name| body(name)).collect::<String>());
    let marks = flights[0].iter().filter(|event| event.mark().is_some());
    let poses = flights.iter().enumerate().flat_map(|(at, events)| {
        events.iter().filter_map(move |event| match event {
            TakeEvent::Pose { stream, sample, .. } => Some(TakeEvent::Pose {
                track: at.into(),
                stream: *stream,
                sample: *sample,
            }),
            TakeEvent::Mark(_) => None,
        })
    });
    let all: Vec<TakeEvent> = poses.chain(marks.cloned()).collect();
    let stacked = Pipeline::of(together, all)
        .estimate(&mut ())
        .expect("an estimate");
    let alone: Scene = scene(&body("ball"));
    let parameters: Vec<usize> = (0..3).collect();
    let motions = flights.into_iter().map(|events| {
        let pipeline = Pipeline::of(alone.clone(), events);
        pipeline.shared(&parameters, &mut ()).expect("a motion")
    });
    let mut motions: Vec<SharedTake> = motions.collect();
    let free = alone.parameters.iter();
    let joint = solved(
        free.map(|of| JointParameter::new(of, false)).collect(),
        &mut motions,
    );
    for (of, value) in stacked
        .estimate
        .parameters
        .iter()
        .zip(joint.values().iter())
    {
        let off = (of.value - value).abs();
        assert!(off < 1e-8 * 9.81, "{}: {} and {value}", of.name, of.value);
    }
}

/// The program in a folder, with so many threads.
pub(crate) fn fit(folder: &Path, threads: usize, arguments: &[String]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_enact"));
    command.arg("fit").args(arguments).current_dir(folder);
    let threads = threads.to_string();
    command
        .env("RAYON_NUM_THREADS", threads)
        .env("NO_COLOR", "1");
    command.output().expect("it runs")
}

pub(crate) fn words(files: &[PathBuf], more: &[&str]) -> Vec<String> {
    let files = files.iter().map(|file| file.display().to_string());
    files
        .chain(more.iter().map(|word| (*word).to_owned()))
        .collect()
}

/// The lines of a schema.
pub(crate) fn lines(output: &Output, schema: &str) -> Vec<Value> {
    let said = String::from_utf8_lossy(&output.stdout);
    let lines = said
        .lines()
        .map(|line| serde_json::from_str(line).expect("a line"));
    lines
        .filter(|line: &Value| line["schema"] == schema)
        .collect()
}

#[test]
fn the_answer_is_the_same_to_the_bit_for_any_order_and_number_of_threads() {
    let folder = TempDir::new().expect("folder");
    let mut files = truth(61).write(6, 62, folder.path()).expect("takes");
    let shared = [
        "--shared",
        "ball.restitution,gravity",
        "--drawn",
        "ball.tracker.z",
        "--format",
        "ndjson",
    ];
    let one = fit(folder.path(), 1, &words(&files, &shared));
    files.reverse();
    files.swap(0, 3);
    let other = fit(folder.path(), 3, &words(&files, &shared));
    let [one, other] = [one, other].map(|of| lines(&of, "enact.fit/1"));
    assert_eq!(one.len(), 1, "{one:?}");
    assert_eq!(one[0].to_string(), other[0].to_string());
}

/// Reduces and solves in turns until there is an answer; how many rounds that takes.
fn apart(folder: &Path, files: &[PathBuf], shared: &[&str], output: &str) -> usize {
    for round in 0..40 {
        // Side by side, as on several machines.
        for part in files.chunks(4) {
            let made = fit(
                folder,
                1,
                &words(part, &[shared, &["--reduce", "blocks"]].concat()),
            );
            assert_eq!(made.status.code(), Some(0), "{made:?}");
        }
        let arguments = ["--solve", "blocks", "-o", output];
        let solved = fit(folder, 1, &words(&[], &arguments));
        assert!(matches!(solved.status.code(), Some(0 | 3)), "{solved:?}");
        if folder.join(output).exists() {
            return round;
        }
        assert_eq!(solved.status.code(), Some(0), "{solved:?}");
    }
    panic!("no answer");
}

#[test]
fn takes_that_are_reduced_apart_have_nearly_the_same_answer() {
    let folder = TempDir::new().expect("folder");
    let mut truth = truth(91);
    truth.restitution.sd = 0.03;
    let files = truth.write(10, 92, folder.path()).expect("takes");
    let shared = [
        "--shared",
        "ball.friction,gravity",
        "--drawn",
        "ball.restitution",
    ];
    let here = fit(
        folder.path(),
        2,
        &words(&files, &[&shared[..], &["-o", "here.toml"]].concat()),
    );
    assert!(matches!(here.status.code(), Some(0 | 3)), "{here:?}");
    apart(folder.path(), &files, &shared, "apart.toml");
    let [here, apart] = ["here.toml", "apart.toml"].map(|name| {
        let text = fs::read_to_string(folder.path().join(name)).expect("an answer");
        let table: toml::Table = text.parse().expect("TOML");
        let quantities = table["quantity"].as_array().expect("a list").clone();
        let numbers = quantities.into_iter().flat_map(|of| {
            let name = of["name"].as_str().expect("a name").to_owned();
            ["value", "lower", "upper"].map(|key| {
                let number = of.get(key).and_then(|of| of.as_array()?[0].as_float());
                (format!("{name} {key}"), number)
            })
        });
        numbers.collect::<Vec<_>>()
    });
    assert_eq!(here.len(), apart.len());
    for (here, apart) in here.chunks(3).zip(apart.chunks(3)) {
        // Weights of samples are found anew in each round: the answers differ by little of their intervals.
        let wide = here[2].1.unwrap_or(1.0) - here[1].1.unwrap_or(0.0);
        for ((name, here), (_, apart)) in here.iter().zip(apart) {
            let off = here.unwrap_or(0.0) - apart.unwrap_or(0.0);
            assert!(off.abs() < 0.05 * wide, "{name}: {here:?} and {apart:?}");
        }
    }
}

#[test]
fn blocks_that_are_there_are_kept_and_those_of_another_fit_are_refused() {
    let folder = TempDir::new().expect("folder");
    let files = truth(93).write(3, 94, folder.path()).expect("takes");
    let reduce = ["--shared", "gravity", "--reduce", "blocks"];
    let solve = ["--solve", "blocks"];
    let run = |arguments: &[String]| fit(folder.path(), 1, arguments);
    let said = |of: &Output| String::from_utf8_lossy(&of.stdout).into_owned();
    let first = run(&words(&files[..2], &reduce));
    assert!(
        said(&first).contains("round 0: 2 blocks made, 0 were there"),
        "{first:?}"
    );
    let again = run(&words(&files, &reduce));
    assert!(
        said(&again).contains("round 0: 1 blocks made, 2 were there"),
        "{again:?}"
    );
    let asks = run(&words(&[], &solve));
    assert!(
        said(&asks).contains("asks 3 takes again, round 1"),
        "{asks:?}"
    );
    // A name that means nothing leaves no blocks.
    let misnamed = run(&words(
        &files,
        &["--shared", "grvity", "--reduce", "misnamed"],
    ));
    assert_eq!(misnamed.status.code(), Some(1), "{misnamed:?}");
    let folder_of = folder.path().join("misnamed/round-0");
    assert_eq!(fs::read_dir(folder_of).expect("list").count(), 0);
    // Half of the round is not the round.
    run(&words(&files[..1], &reduce));
    let asks = run(&words(&[], &solve));
    assert!(
        said(&asks).contains("asks 3 takes again, round 1"),
        "{asks:?}"
    );
    // A file that is none, and a take that came too late.
    let stray = folder.path().join("blocks/round-0/stray.json");
    fs::write(&stray, "{}").expect("write");
    let refused = run(&words(&[], &solve));
    assert_eq!(refused.status.code(), Some(1));
    assert!(
        String::from_utf8_lossy(&refused.stderr).contains("stray.json"),
        "{refused:?}"
    );
    fs::remove_file(&stray).expect("remove");
    let other = ["--shared", "ball.restitution", "--reduce", "others"];
    run(&words(&files[..1], &other));
    for entry in fs::read_dir(folder.path().join("others/round-0")).expect("list") {
        let entry = entry.expect("a file");
        fs::copy(
            entry.path(),
            folder.path().join("blocks/round-0/other.json"),
        )
        .expect("copy");
    }
    let refused = run(&words(&[], &solve));
    assert_eq!(refused.status.code(), Some(1));
    let why = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert!(
        why.contains("expected") && why.contains("as in that of"),
        "{why}"
    );
}

#[test]
fn an_answer_holds_the_truth_on_takes_held_out_and_goes_into_the_scene() {
    let folder = TempDir::new().expect("folder");
    let truth = truth(71);
    let files = truth.write(10, 72, folder.path()).expect("takes");
    let names = SHARED.join(",");
    let arguments = [
        "--shared",
        &names,
        "--hold-out",
        "0.3",
        "-o",
        "fit.toml",
        "--page",
        "fit.html",
    ];
    let made = fit(
        folder.path(),
        2,
        &words(&files, &[&arguments[..], &["--format", "ndjson"]].concat()),
    );
    assert_eq!(made.status.code(), Some(0), "{made:?}");
    let line = &lines(&made, "enact.fit/1")[0];
    assert_eq!(
        (&line["takes"], &line["held_out"]["takes"]),
        (&7.into(), &3.into())
    );
    assert_eq!(line["held_out"]["better"], 3);
    for (name, value) in truth.values() {
        let parameters = line["parameters"].as_array().expect("a list");
        let of = parameters.iter().find(|of| of["name"] == name).expect("it");
        let off = (of["value"].as_f64().expect("a number") - value).abs();
        let sd = of["sd"].as_f64().expect("a number");
        // Eight numbers of one answer: a t of six degrees of freedom is within so many deviations in all of them.
        assert!(off < 6.0 * sd, "{name}: {off} of {sd}");
    }
    let page = fs::read_to_string(folder.path().join("fit.html")).expect("a page");
    for part in [
        "Parameters",
        "held out",
        "Correlations",
        "Residuals",
        "take_0003.mcap",
    ] {
        assert!(page.contains(part), "{part}");
    }
    let toml = fs::read_to_string(folder.path().join("fit.toml")).expect("a file");
    assert_eq!(toml.matches("sha256 = ").count(), 10);
    fs::write(folder.path().join("scene.toml"), BallTruth::scene_toml()).expect("write");
    let mut command = Command::new(env!("CARGO_BIN_EXE_enact"));
    command.args([
        "scene",
        "calibrated",
        "scene.toml",
        "fit.toml",
        "-o",
        "fitted.toml",
    ]);
    let put = command
        .current_dir(folder.path())
        .output()
        .expect("it runs");
    assert!(put.status.success(), "{put:?}");
    let fitted = fs::read_to_string(folder.path().join("fitted.toml")).expect("a scene");
    let fitted = scene_from_toml(&fitted).expect("a scene");
    let law = &fitted.contact_laws.raw[0];
    assert!((law.restitution - truth.restitution.mean).abs() < 0.01);
    assert!((fitted.gravity_m_s2 - truth.gravity_m_s2).norm() < 0.1);
    let mount = fitted.tracks.raw[0].link_from_tracker.translation.vector;
    assert!((mount - truth.tracker_m).norm() < 1e-3, "{mount}");
}

#[test]
fn bad_files_cost_a_line_each_and_what_is_no_take_is_left_alone() {
    let folder = TempDir::new().expect("folder");
    let mut files = truth(81).write(5, 82, folder.path()).expect("takes");
    let bad = folder.path().join("bad.mcap");
    fs::write(&bad, b"no recording").expect("write");
    let twice = folder.path().join("zz_twice.mcap");
    fs::copy(&files[1], &twice).expect("copy");
    files.extend([bad, twice]);
    let said = fit(
        folder.path(),
        2,
        &words(
            &files,
            &["--shared", "ball.restitution,gravity", "--format", "ndjson"],
        ),
    );
    assert_eq!(said.status.code(), Some(3), "{said:?}");
    let takes = lines(&said, "enact.fit_take/1");
    let parts: Vec<&str> = takes
        .iter()
        .map(|of| of["part"].as_str().expect("text"))
        .collect();
    assert_eq!(parts[..5], ["fitted"; 5]);
    assert_eq!(parts[5..], ["left_out", "left_alone"]);
    assert!(
        takes[6]["why"]
            .as_str()
            .expect("why")
            .contains("same recording")
    );
    let line = &lines(&said, "enact.fit/1")[0];
    assert_eq!((&line["takes"], &line["left_out"]), (&5.into(), &1.into()));
}

#[test]
fn what_is_not_asked_or_means_nothing_is_refused_and_no_gain_is_said() {
    let folder = TempDir::new().expect("folder");
    let mut truth = truth(91);
    let files = truth.write(4, 92, folder.path()).expect("takes");
    for (arguments, why) in [
        (&[][..], "nothing is asked for"),
        (&["--shared", "ball.bounciness"][..], "unknown quantity"),
        (
            &["--shared", "gravity.z", "--drawn", "gravity"][..],
            "named twice",
        ),
        (&["--shared", "ball.mass"][..], "cancels"),
        (
            &["--shared", "gravity", "--hold-out", "0.1"][..],
            "no take is left",
        ),
    ] {
        let said = fit(folder.path(), 2, &words(&files, arguments));
        assert_eq!(said.status.code(), Some(1), "{arguments:?}: {said:?}");
        let error = String::from_utf8_lossy(&said.stderr).into_owned();
        assert!(error.contains(why), "{arguments:?}: {error}");
    }
    // Where the scene is right there is nothing to gain.
    truth.gravity_m_s2 = nalgebra::Vector3::new(0.0, 0.0, -9.80665);
    truth.tracker_m = nalgebra::Vector3::zeros();
    (truth.restitution, truth.friction) = (Over::same(0.5), Over::same(0.1));
    let right = folder.path().join("right");
    fs::create_dir(&right).expect("folder");
    let codes: Vec<Option<i32>> = (0..4)
        .map(|seed| {
            let files = truth.write(4, 900 + seed, &right).expect("takes");
            let toml = BallTruth::scene_toml().replace("friction = 0.3", "friction = 0.1");
            fs::write(right.join("scene.toml"), toml).expect("write");
            let more = [
                "--scene",
                "scene.toml",
                "--shared",
                "gravity",
                "--hold-out",
                "0.5",
            ];
            let said = fit(&right, 2, &words(&files, &more));
            let words = String::from_utf8_lossy(&said.stderr).into_owned();
            assert_eq!(
                said.status.code() == Some(3),
                words.contains("no gain"),
                "{words}"
            );
            said.status.code()
        })
        .collect();
    assert!(codes.contains(&Some(3)), "{codes:?}");
}
