//! Bodies joined in trees that hit a table, at one corner or several, bodies by themselves and each other: how often a motion is found, and how near it is to the true one.

use anyhow::Result;
use enact::motion::Verdict;
use enact::pipeline::Pipeline;
use enact_tools::tree_impacts::{Acted, Form, Strike, Struck, strike};
use enact_tools::tree_meetings::{Meet, Met, meet};
use enact_tools::trees::Jointed;
use serde::Serialize;

use crate::core_time::{ANSWER_S, CoreLimit, CoreTime};
use crate::options::Options;
use crate::record::Record;
use crate::statistics::{largest, median};
use crate::table::{Table, number, percent, share};

/// Of the wander of a usual hand.
pub const DISTORTIONS: [f64; 3] = [0.5, 1.0, 2.0];
/// Performances of a row.
const PERFORMANCES: u64 = 10;

/// What hits what.
pub enum Kind {
    /// A table.
    Table(Struck),
    /// Something that moves.
    Moving(Meet),
}

impl Kind {
    /// A performance of it.
    pub fn perform(&self, acted: &Acted, seed: u64) -> Strike {
        match self {
            Self::Table(struck) => strike(struck, acted, seed),
            Self::Moving(of) => meet(of, acted, seed),
        }
    }
}

/// What came of one performance.
#[derive(Serialize)]
struct Performed {
    seed: u64,
    verdict: String,
    doubts: Vec<String>,
    is_motion: bool,
    is_physical: bool,
    /// Greatest error of an impact's time, and of its mark \[s\]; none where no motion is found.
    impact_off_s: Option<f64>,
    mark_off_s: f64,
    /// Root mean square distance of all bodies' centres from the true ones \[m\].
    off_m: Option<f64>,
    evaluations: usize,
    seconds: f64,
}

impl Performed {
    fn of(kind: &Kind, acted: &Acted, seed: u64) -> Self {
        let strike = kind.perform(acted, seed);
        let time = CoreTime::begin();
        let events = strike.events.iter().cloned();
        let limit = &mut CoreLimit(&time, ANSWER_S);
        let outcome = Pipeline::of(strike.scene.clone(), events).finish(limit);
        let seconds = time.seconds();
        let outcome = outcome.expect("an estimate");
        let estimate = &outcome.estimate;
        let is_motion = estimate.verdict != Verdict::Failed;
        let greatest =
            |offs: &mut dyn Iterator<Item = f64>| offs.fold(0.0, |a: f64, b| a.max(b.abs()));
        let free = estimate.events.iter().filter(|event| !event.is_fixed);
        let both = free.zip(&strike.impacts_s);
        let impact_off_s = greatest(&mut both.clone().map(|(found, truth)| found.time_s - truth));
        let marks_s = &outcome.sketch.marks_s;
        let mark_off_s = greatest(&mut both.map(|(found, truth)| marks_s[found.event] - truth));
        Self {
            seed,
            verdict: format!("{:?}", estimate.verdict).to_lowercase(),
            doubts: estimate
                .doubts
                .iter()
                .map(|of| of.about.as_str().to_owned())
                .collect(),
            is_motion,
            is_physical: estimate.verdict == Verdict::Physical,
            impact_off_s: is_motion.then_some(impact_off_s),
            mark_off_s,
            off_m: is_motion.then(|| strike.off_m(estimate)),
            evaluations: estimate.counters.evaluations,
            seconds,
        }
    }
}

fn kinds() -> Vec<(String, Kind)> {
    let mut kinds = Vec::new();
    let law = [0.5, 0.2];
    let joints = [
        ("pins", Jointed::Pin),
        ("universal", Jointed::Universal),
        ("balls", Jointed::Ball),
    ];
    for (what, links, hangs_m, impacts) in [
        ("pendulum of 2", 2, Some(0.35), 1),
        ("flail of 2", 2, None, 1),
        ("flail of 2, two impacts", 2, None, 2),
        ("chain of 3", 3, None, 1),
    ] {
        kinds.extend(joints.map(|(name, joints)| {
            let struck = Struck {
                form: Form::Rod,
                links,
                joints,
                hangs_m,
                impacts,
                law,
            };
            (format!("{what}, {name}"), Kind::Table(struck))
        }));
    }
    kinds.extend(meetings(law));
    kinds.extend(landings());
    kinds
}

/// Joined bodies of which a plank comes down on several corners at once, without friction.
fn landings() -> [(String, Kind); 4] {
    [
        ("flail of 2 on an edge", 2, Jointed::Ball, 2),
        ("flail of 2 on a face", 2, Jointed::Pin, 3),
        ("chain of 3 on an edge", 3, Jointed::Universal, 2),
        ("chain of 3 on a face", 3, Jointed::Universal, 3),
    ]
    .map(|(what, links, joints, corners)| {
        let of = Meet {
            links,
            joints,
            hangs_m: None,
            met: Met::Table(corners),
            law: [0.5, 0.0],
        };
        (what.to_owned(), Kind::Moving(of))
    })
}

/// Joined bodies that meet something that moves, by a law of restitution and friction.
pub fn meetings(law: [f64; 2]) -> [(String, Kind); 5] {
    [
        ("flail of 2 on a box", 2, Jointed::Ball, None, Met::Box),
        (
            "hanging flail of 2 on a box",
            2,
            Jointed::Universal,
            Some(0.9),
            Met::Box,
        ),
        (
            "chain of 3 on a ball",
            3,
            Jointed::Universal,
            None,
            Met::Ball,
        ),
        (
            "pendulum of 2 on another",
            2,
            Jointed::Pin,
            Some(0.9),
            Met::Pendulum,
        ),
        ("chain of 3 on itself", 3, Jointed::Pin, None, Met::Own),
    ]
    .map(|(what, links, joints, hangs_m, met)| {
        let of = Meet {
            links,
            joints,
            hangs_m,
            met,
            law,
        };
        (what.to_owned(), Kind::Moving(of))
    })
}

/// Runs it.
pub fn run(options: &Options, record: &mut Record) -> Result<()> {
    let header = [
        "motion",
        "hand",
        "performances",
        "motions",
        "physical",
        "impact off, ms",
        "mark off, ms",
        "bodies off, mm",
        "evaluations",
        "time, ms",
        "longest, ms",
    ];
    let mut table = Table::new("struck", "", &header);
    let mut numbers = Vec::new();
    let mut shares = DISTORTIONS.map(|_| (0, 0, 0));
    for (name, kind) in kinds() {
        for (distortion, counted) in DISTORTIONS.into_iter().zip(&mut shares) {
            if options.quick && distortion != 1.0
                || !options.wants(&format!("{name}, {distortion}x"))
            {
                continue;
            }
            let seeds = options.seeds(PERFORMANCES);
            let acted = Acted::of(distortion);
            let all: Vec<Performed> = seeds
                .map(|seed| Performed::of(&kind, &acted, seed))
                .collect();
            let of = |of: &dyn Fn(&Performed) -> Option<f64>| {
                all.iter().filter_map(of).collect::<Vec<f64>>()
            };
            let times_s = of(&|one| Some(one.seconds));
            table.row([
                name.clone(),
                format!("{distortion}×"),
                all.len().to_string(),
                share(&all, |one| one.is_motion),
                share(&all, |one| one.is_physical),
                number(1e3 * median(&of(&|one| one.impact_off_s))),
                number(1e3 * median(&of(&|one| Some(one.mark_off_s)))),
                number(1e3 * median(&of(&|one| one.off_m))),
                number(median(&of(&|one| Some(one.evaluations as f64)))),
                number(1e3 * median(&times_s)),
                number(1e3 * largest(&times_s)),
            ]);
            eprintln!("  {name}, {distortion}x");
            counted.0 += all.iter().filter(|one| one.is_motion).count();
            counted.1 += all.iter().filter(|one| one.is_physical).count();
            counted.2 += all.len();
            numbers.push((name.clone(), distortion, all));
        }
    }
    let said = DISTORTIONS.iter().zip(shares);
    let said: Vec<String> = said
        .map(|(distortion, (motions, physical, of))| {
            let [motions, physical] = [motions, physical].map(|found| percent(found, of));
            format!("{motions} ({physical} physical) at {distortion}×")
        })
        .collect();
    record.say(format!(
        "Pendulums, flails and chains that hit a table, a body by itself or each other: a motion is found of {}.",
        said.join(", ")
    ));
    record.table(table);
    record.numbers("struck", &numbers)
}
