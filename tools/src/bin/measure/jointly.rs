//! Scenes of joined bodies with one thing wrong: whether that is seen, and what is blamed.

use anyhow::Result;
use enact::motion::{Fits, Scene, TakeEvent, Verdict};
use enact::pipeline::Pipeline;
use enact_tools::elbow::{self, Reads};
use enact_tools::joint_wrongs::Wrong;
use enact_tools::tree_impacts::{Acted, Form, Struck, strike};
use enact_tools::trees::{Jointed, Kind, TreeActing, perform};
use serde::Serialize;

use crate::core_time::{ANSWER_S, CoreLimit, CoreTime};
use crate::options::Options;
use crate::record::Record;
use crate::statistics::median;
use crate::table::{Table, number, percent, share};

/// Performances of a row.
const PERFORMANCES: u64 = 10;
/// What is wrong where a hand wanders, besides nothing.
const UNDER_A_HAND: [Wrong; 3] = [Wrong::Long(0.1), Wrong::Long(0.2), Wrong::Gravity(0.9)];
/// Least readings of a flight of the elbow.
const LEAST: usize = 10;

/// What was said of one performance.
#[derive(Serialize)]
struct Said {
    of: String,
    is_motion: bool,
    /// `yes`, `unknown` or `no`; none where that was not told.
    fits: Option<&'static str>,
    /// Whether what is wrong is suspected first, and whether first or as well as the first.
    is_first: bool,
    is_named: bool,
    suspects: Vec<(String, f64)>,
    seconds: f64,
}

impl Said {
    fn of(of: String, wrong: Wrong, scene: Scene, events: &[TakeEvent]) -> Self {
        let is_it = |quantity| wrong.is_of(&scene, quantity);
        Self::told(of, &scene, events, &is_it)
    }

    fn told(
        of: String,
        scene: &Scene,
        events: &[TakeEvent],
        is_it: &dyn Fn(enact::motion::Quantity) -> bool,
    ) -> Self {
        let time = CoreTime::begin();
        let limit = &mut CoreLimit(&time, ANSWER_S);
        let outcome = Pipeline::of(scene.clone(), events.iter().cloned()).finish(limit);
        let seconds = time.seconds();
        let estimate = outcome.expect("an estimate").estimate;
        let suspects = &estimate.suspects;
        let is_culprit = |suspect: &enact::motion::Suspect| {
            suspect.values.iter().any(|(quantity, _)| is_it(*quantity))
        };
        let first = suspects.first();
        let mut rivals = suspects.iter().filter(|other| {
            first.is_some_and(|first| *other == first || first.is_rivalled_by(other))
        });
        Self {
            of,
            is_motion: estimate.verdict != Verdict::Failed,
            fits: estimate.fit.is_ok().then(|| estimate.fits().as_str()),
            is_first: first.is_some_and(is_culprit),
            is_named: rivals.any(is_culprit),
            suspects: suspects
                .iter()
                .flat_map(|suspect| &suspect.values)
                .map(|(quantity, value)| (scene.name_of_quantity(*quantity), *value))
                .collect(),
            seconds,
        }
    }
}

/// Scenes as they are performed: a name, the scene file, how many rods there are, what was recorded.
type Performed = (String, usize, Vec<TakeEvent>);

/// What performs a seed.
type Performer = Box<dyn Fn(u64) -> Performed>;

/// Kinds of performances.
fn kinds() -> Vec<(String, Performer)> {
    let mut kinds: Vec<(String, Performer)> = Vec::new();
    let pendulum = Kind::pendulum;
    for (wander, words) in [
        (0.0, "noise"),
        (0.25, "a quarter of a hand"),
        (1.0, "a hand"),
    ] {
        for (name, kind) in [
            ("two rods, pins, the tip seen", pendulum(2, Jointed::Pin)),
            (
                "two rods, universal, the tip seen",
                pendulum(2, Jointed::Universal),
            ),
            ("chain, a point seen", Kind::CHAIN),
        ] {
            if !kind.is_clamped && wander > 0.0 {
                // With one point of it seen, noise alone hides nearly all.
                continue;
            }
            let acting = TreeActing {
                asks_start: !kind.is_clamped,
                ..TreeActing::of(wander)
            };
            kinds.push((
                format!("{name}; {words}"),
                Box::new(move |seed| {
                    let performed = perform(&kind, &acting, seed);
                    (performed.scene_toml, kind.links, performed.events)
                }),
            ));
        }
        for (name, hangs_m) in [
            ("two rods that hit, seen", Some(0.35)),
            ("flail that hits, seen", None),
        ] {
            let struck = Struck {
                form: Form::Rod,
                links: 2,
                joints: Jointed::Universal,
                hangs_m,
                impacts: 1,
                law: [0.5, 0.2],
            };
            kinds.push((
                format!("{name}; {words}"),
                Box::new(move |seed| {
                    let performed = strike(&struck, &Acted::of(wander), seed);
                    (performed.scene_toml, struck.links, performed.events)
                }),
            ));
        }
    }
    kinds
}

fn row(table: &mut Table, what: (String, String), all: &[Said]) {
    let says = |fits: Fits| share(all, |one| one.fits == Some(fits.as_str()));
    table.row([
        what.0,
        what.1,
        all.len().to_string(),
        share(all, |one| one.is_motion),
        says(Fits::Yes),
        says(Fits::Unknown),
        says(Fits::No),
        share(all, |one| one.is_first),
        share(all, |one| one.is_named),
        number(1e3 * median(&all.iter().map(|one| one.seconds).collect::<Vec<f64>>())),
    ]);
}

/// Runs it.
pub fn run(options: &Options, record: &mut Record) -> Result<()> {
    let header = [
        "motion",
        "wrong",
        "performances",
        "motions",
        "fits",
        "unknown",
        "does not fit",
        "named first",
        "named",
        "time, ms",
    ];
    let mut table = Table::new("jointly", "", &header);
    let mut numbers = Vec::new();
    let (mut alarms, mut right) = (0, 0);
    for (name, performed) in kinds() {
        let has_hand = !name.ends_with("noise");
        for wrong in Wrong::ALL {
            let what = (name.clone(), wrong.words());
            let is_left_out = has_hand && wrong != Wrong::Nothing && !UNDER_A_HAND.contains(&wrong);
            if is_left_out || !options.wants(&format!("{}, {}", what.0, what.1)) {
                continue;
            }
            let seeds = options.seeds(PERFORMANCES);
            let all: Vec<Said> = seeds
                .map(|seed| {
                    let (scene_toml, rods, events) = performed(seed);
                    let scene = wrong.scene(&scene_toml, rods);
                    Said::of(seed.to_string(), wrong, scene, &events)
                })
                .collect();
            if wrong == Wrong::Nothing {
                right += all.len();
                alarms += all
                    .iter()
                    .filter(|one| one.fits == Some(Fits::No.as_str()))
                    .count();
            }
            eprintln!("  {}, {}", what.0, what.1);
            row(&mut table, what.clone(), &all);
            numbers.push((what, all));
        }
    }
    let mut real = Table::new("jointly_elbow", "", &header);
    let files: Vec<_> = elbow::files().into_iter().step_by(2).collect();
    for off_mm in [0.0, 2.0, 5.0, 10.0] {
        let what = (
            "two hinged boxes, really tossed".to_owned(),
            format!("the hinge {off_mm} mm off"),
        );
        if !options.wants(&format!("{}, {}", what.0, what.1)) {
            continue;
        }
        let flights = files.iter().map(|file| (file, elbow::flight(file)));
        let flights = flights.filter(|(_, flight)| flight.len() >= LEAST);
        let all: Vec<Said> = flights
            .take(options.either(2, usize::MAX))
            .map(|(file, flight)| {
                let reads = Reads {
                    sees_both: true,
                    moment_kg_m2: Some(6.167e-4),
                    hinge_off_m: 1e-3 * off_mm,
                };
                let (scene, events) = elbow::take(&flight, &reads);
                let is_it =
                    |quantity| matches!(quantity, enact::motion::Quantity::JointPlace { .. });
                let toss = file.file_stem().unwrap_or_default().to_string_lossy();
                Said::told(toss.into_owned(), &scene, &events, &is_it)
            })
            .collect();
        if !all.is_empty() {
            row(&mut real, what.clone(), &all);
            numbers.push((what, all));
        }
    }
    record.say(format!(
        "Joined bodies whose scene is right: {} are said not to fit.",
        percent(alarms, right)
    ));
    record.table(table);
    record.table(real);
    record.numbers("jointly", &numbers)
}
