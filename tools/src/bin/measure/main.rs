//! Measurements of the program, on performances whose truth is known and on real recordings.
//!
//! ```text
//! cargo run --release -p enact-tools --bin measure                          # everything, in hours
//! cargo run --release -p enact-tools --bin measure -- --quick               # that everything runs, in a minute
//! cargo run --release -p enact-tools --bin measure -- --only flow peers     # two subjects
//! cargo run --release -p enact-tools --bin measure -- --draw                # pages and drawings from the numbers
//! ```
//!
//! Every subject leaves a [`record::Record`] in `tools/results`: tables, figures, raw numbers, and
//! on what they were measured. Its page and its drawings are made from that alone. Run it on a
//! machine that does nothing else: times are measured.

mod accuracy;
mod adequacy;
mod answer;
mod calibrate;
mod clatter;
mod core_time;
mod cost;
mod damage;
mod diagnosis;
mod draw;
mod durations;
mod elbow;
mod failure;
mod figure;
mod fit;
mod fit_peers;
mod flow;
mod goals;
mod held;
mod joined;
mod joined_cost;
mod joined_peers;
mod joined_shooting;
mod joined_stress;
mod jointly;
mod keyframes;
mod ladder;
mod mechanisms;
mod methods;
mod nonsense;
mod objects;
mod options;
mod page;
mod parts;
mod peers;
mod phases;
mod posing;
mod record;
mod rest;
mod run;
mod scenes;
mod sequences;
mod slowly;
mod speed;
mod spent;
mod statistics;
mod stress;
mod struck;
mod struck_open;
mod table;
mod tosses;
mod trees;
mod uncertainty;
mod wander;

use std::time::Instant;

use anyhow::Result;
use clap::Parser;

use options::Options;
use record::Record;
use run::Run;

/// What is measured.
struct Subject {
    /// Of its files.
    name: &'static str,
    /// In the list of pages.
    title: &'static str,
    /// The page, with places for figures and tables.
    text: &'static str,
    /// Measures it.
    run: fn(&Options, &mut Record) -> Result<()>,
}

macro_rules! subject {
    ($name:literal, $title:literal, $run:path) => {
        Subject {
            name: $name,
            title: $title,
            text: include_str!(concat!("pages/", $name, ".md")),
            run: $run,
        }
    };
}

/// In the order of the list of pages.
const SUBJECTS: &[Subject] = &[
    subject!(
        "answer",
        "how often the motion is the right one, and what it takes",
        answer::run
    ),
    subject!(
        "accuracy",
        "how exactly exact performances are recovered",
        accuracy::run
    ),
    subject!(
        "uncertainty",
        "how certain an estimate is, and whether it says so",
        uncertainty::run
    ),
    subject!(
        "wander",
        "errors of a hand as a process in time",
        wander::run
    ),
    subject!(
        "scenes",
        "right performances of scenes drawn at random",
        scenes::run
    ),
    subject!(
        "phases",
        "slides, rolls, rests, hands and contacts that last",
        phases::run
    ),
    subject!("fit", "one answer from many takes", fit::run),
    subject!(
        "fit_peers",
        "one answer from many takes, beside MuJoCo's system identification",
        fit_peers::run
    ),
    subject!("peers", "general solvers on the same problems", peers::run),
    subject!(
        "methods",
        "other methods of estimation on the same problems",
        methods::run
    ),
    subject!(
        "failure",
        "where methods and peers fail as a trouble grows",
        failure::run
    ),
    subject!(
        "stress",
        "where the program fails, and what it says then",
        stress::run
    ),
    subject!(
        "nonsense",
        "wrong models, right ones, and real recordings of no flight",
        nonsense::run
    ),
    subject!(
        "adequacy",
        "wrong scenes, whether they are seen and what is blamed",
        adequacy::run
    ),
    subject!(
        "ladder",
        "errors and intervals of predictions as parameters are freed",
        ladder::run
    ),
    subject!(
        "diagnosis",
        "mistakes in scenes and drivers, and whether they are named",
        diagnosis::run
    ),
    subject!(
        "damage",
        "outliers, wrong units, marks that are off or absent",
        damage::run
    ),
    subject!(
        "sequences",
        "what touches, where scenes leave that open",
        sequences::run
    ),
    subject!(
        "clatter",
        "corners that hit within milliseconds, with few samples between",
        clatter::run
    ),
    subject!(
        "goals",
        "goals of every kind that a motion near the performed one meets",
        goals::run
    ),
    subject!(
        "parts",
        "trackers that see points, directions, orientations: what is found and what is said to be open",
        parts::run
    ),
    subject!(
        "held",
        "bodies in the hand: how often intervals of their states hold, and what bounces off them",
        held::run
    ),
    subject!(
        "keyframes",
        "sketches of a few poses, exact and imprecise",
        keyframes::run
    ),
    subject!(
        "rest",
        "dice that are asked to show a face at rest",
        rest::run
    ),
    subject!(
        "calibrate",
        "how often the intervals of calibrated clocks hold",
        calibrate::run
    ),
    subject!(
        "spent",
        "how near the truth in what time: fewer samples, previews, stopped early",
        spent::run
    ),
    subject!(
        "cost",
        "time and memory against samples, bounces and bodies",
        cost::run
    ),
    subject!(
        "speed",
        "kinds of sketches beside full poses with as many residuals",
        speed::run
    ),
    subject!(
        "flow",
        "the free turn of a body beside other ways to compute it",
        flow::run
    ),
    subject!(
        "joined",
        "chains and pendulums from their sketches: how often, in what time",
        joined::run
    ),
    subject!(
        "joined_peers",
        "general solvers on chains and pendulums",
        joined_peers::run
    ),
    subject!(
        "joined_cost",
        "how cost grows with links, segments and duration of joined bodies",
        joined_cost::run
    ),
    subject!(
        "joined_shooting",
        "single beside multiple shooting of chains and pendulums: where each stops to converge",
        joined_shooting::run
    ),
    subject!(
        "joined_stress",
        "joined bodies that are hard, or scenes of them that are wrong: what is found and what is said",
        joined_stress::run
    ),
    subject!(
        "slowly",
        "chains and pendulums in slow motion whose tempo is not known",
        slowly::run
    ),
    subject!(
        "struck",
        "joined bodies that hit a table: how often, how near to the truth, in what time",
        struck::run
    ),
    subject!(
        "struck_open",
        "joined bodies that hit something, where the scene does not say what touches: how often it is inferred rightly",
        struck_open::run
    ),
    subject!(
        "elbow",
        "real tosses of two boxes joined by a hinge: residuals, gravity, a wrong hinge, the first impact",
        elbow::run
    ),
    subject!(
        "jointly",
        "wrong scenes of joined bodies: whether they are seen and what is blamed",
        jointly::run
    ),
    subject!(
        "trees",
        "the motion of chains and pendulums by several integrators, and what its derivatives cost",
        trees::run
    ),
    subject!(
        "mechanisms",
        "accelerations of trees, with derivatives, beside Pinocchio's and MuJoCo's",
        mechanisms::run
    ),
    subject!(
        "tosses",
        "real tosses of a cube: gravity, impacts, predictions",
        tosses::run
    ),
    subject!(
        "objects",
        "real tosses of household objects, smoothed: what is explained and what is named",
        objects::run
    ),
    subject!(
        "durations",
        "how long motions last that were acted in a tempo of their own",
        durations::run
    ),
];

fn main() -> Result<()> {
    let options = Options::parse();
    if let Some(size) = &options.memory {
        let bytes = cost::memory::peak_bytes(size);
        println!("{}", bytes.map_or(String::new(), |bytes| bytes.to_string()));
        return Ok(());
    }
    let is_known = |name: &String| SUBJECTS.iter().any(|subject| subject.name == name);
    if let Some(name) = options.only.iter().find(|name| !is_known(name)) {
        let names: Vec<&str> = SUBJECTS.iter().map(|subject| subject.name).collect();
        anyhow::bail!("no subject {name:?}; there are {}", names.join(", "));
    }
    for subject in SUBJECTS {
        if options.draw
            || !(options.only.is_empty() || options.only.iter().any(|n| n == subject.name))
        {
            continue;
        }
        eprintln!("{}", subject.name);
        let here = Run::here(options.quick);
        let mut record = Record::default();
        record.run.clone_from(&here);
        let begin = Instant::now();
        (subject.run)(&options, &mut record)?;
        let seconds = begin.elapsed().as_secs_f64();
        eprintln!("{}: {seconds:.1} s", subject.name);
        record.run = Run { seconds, ..here };
        // What leaves rows out is no measurement of the subject.
        if options.rows.is_none() {
            record.save(&options.folder, subject.name)?;
        }
    }
    page::write_all(&options.folder, SUBJECTS)
}
