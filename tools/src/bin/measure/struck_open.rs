//! Joined bodies that hit something, in scenes that do not say what touches: how often it is inferred rightly, what is
//! said where it is not, and what that costs.

use anyhow::Result;
use enact::motion::{EventKind, Scene, Touching, Undetermined, Verdict};
use enact::pipeline::{Outcome, Pipeline};
use enact_tools::tree_impacts::{Acted, Form, Strike, Struck};
use enact_tools::trees::Jointed;
use serde::Serialize;

use crate::core_time::{ANSWER_S, CoreLimit, CoreTime};
use crate::options::Options;
use crate::record::Record;
use crate::statistics::{largest, median};
use crate::struck::{DISTORTIONS, Kind, meetings};
use crate::table::{Table, number, percent, share};

/// Performances of a row.
const PERFORMANCES: u64 = 50;

/// What came of one performance.
#[derive(Serialize)]
struct Performed {
    seed: u64,
    /// Choices of what touches, those that the ranking does not rule out, and those that were solved.
    choices: f64,
    likely: usize,
    solves: usize,
    /// With what touches named: the verdict, the objective, and how long it took \[s\].
    named_verdict: String,
    named_objective: f64,
    named_s: f64,
    /// With it open.
    verdict: String,
    objective: f64,
    open_s: f64,
    /// What was inferred, and the truth.
    inferred: Vec<String>,
    truth: Vec<String>,
    is_motion: bool,
    is_right: bool,
    /// Whether nothing else is said to be possible, and whether the truth is among what is.
    is_certain: bool,
    has_truth: bool,
    doubts: Vec<String>,
    rivals: Vec<String>,
}

impl Performed {
    fn of(kind: &Kind, acted: &Acted, seed: u64) -> Self {
        let strike = kind.perform(acted, seed);
        let (named, named_s) = finished(&strike, strike.scene.clone());
        let open = opened(&strike.scene);
        let events = open.open_events();
        let (outcome, open_s) = finished(&strike, open);
        let estimate = &outcome.estimate;
        let words = |scene: &Scene| -> Vec<String> {
            let words = events
                .iter()
                .filter_map(|event| scene.contact_words(*event));
            words.collect()
        };
        let [inferred, truth] = [&outcome.scene, &strike.scene].map(words);
        let rivals = estimate.contact_rivals.iter();
        let work = outcome.search.expect("what touches was inferred");
        let is_open = |event: &usize| {
            estimate
                .undetermined
                .contains(&Undetermined::Contact(*event))
        };
        // At every event at which something else touched.
        let has_truth =
            events
                .iter()
                .zip(inferred.iter().zip(&truth))
                .all(|(event, (found, truth))| {
                    found == truth
                        || estimate.contact_rivals.iter().any(|of| {
                            of.event == *event
                                && strike.scene.words_of(*event, &of.contacts).as_ref()
                                    == Some(truth)
                        })
                });
        Self {
            seed,
            choices: work.sequences,
            likely: work.nodes,
            solves: work.solves,
            named_verdict: word(named.estimate.verdict),
            named_objective: named.estimate.objective,
            named_s,
            verdict: word(estimate.verdict),
            objective: estimate.objective,
            open_s,
            is_motion: estimate.verdict != Verdict::Failed,
            is_right: inferred == truth,
            is_certain: !events.iter().any(is_open),
            has_truth,
            inferred,
            truth,
            doubts: estimate
                .doubts
                .iter()
                .map(|of| of.about.as_str().to_owned())
                .collect(),
            rivals: rivals
                .map(|of| {
                    let what = strike.scene.words_of(of.event, &of.contacts);
                    format!("{} {}", what.unwrap_or_default(), of.standing.as_str())
                })
                .collect(),
        }
    }

    fn is(&self, is_right: bool, verdict: &str, is_certain: bool) -> bool {
        (self.is_right, self.verdict.as_str(), self.is_certain) == (is_right, verdict, is_certain)
    }
}

fn word(verdict: Verdict) -> String {
    format!("{verdict:?}").to_lowercase()
}

fn finished(strike: &Strike, scene: Scene) -> (Outcome, f64) {
    let time = CoreTime::begin();
    let events = strike.events.iter().cloned();
    let limit = &mut CoreLimit(&time, ANSWER_S);
    let outcome = Pipeline::of(scene, events).finish(limit);
    (outcome.expect("an estimate"), time.seconds())
}

/// The scene without a word of what touches: neither features nor surface.
fn opened(scene: &Scene) -> Scene {
    let mut open = scene.clone();
    for event in &mut open.events {
        if let EventKind::Collision(collision) = &mut event.kind {
            collision.contacts = vec![Touching {
                feature: None,
                other: None,
            }];
        }
    }
    open
}

fn kinds() -> Vec<(String, Kind)> {
    let mut kinds = Vec::new();
    let law = [0.5, 0.2];
    for (what, form, links, joints, hangs_m, impacts) in [
        (
            "rods, pendulum of 2",
            Form::Rod,
            2,
            Jointed::Universal,
            Some(0.35),
            1,
        ),
        ("rods, flail of 2", Form::Rod, 2, Jointed::Ball, None, 1),
        (
            "rods, flail of 2, two impacts",
            Form::Rod,
            2,
            Jointed::Pin,
            None,
            2,
        ),
        (
            "rods, chain of 3",
            Form::Rod,
            3,
            Jointed::Universal,
            None,
            1,
        ),
        (
            "planks, pendulum of 2",
            Form::Plank,
            2,
            Jointed::Universal,
            Some(0.35),
            1,
        ),
        ("planks, flail of 2", Form::Plank, 2, Jointed::Ball, None, 1),
        (
            "planks, flail of 2, pins",
            Form::Plank,
            2,
            Jointed::Pin,
            None,
            1,
        ),
    ] {
        let struck = Struck {
            form,
            links,
            joints,
            hangs_m,
            impacts,
            law,
        };
        kinds.push((what.to_owned(), Kind::Table(struck)));
    }
    kinds.extend(meetings(law));
    kinds
}

/// Runs it.
pub fn run(options: &Options, record: &mut Record) -> Result<()> {
    let header = [
        "motion",
        "hand",
        "performances",
        "choices",
        "likely",
        "solved",
        "right",
        "right, physical, certain",
        "right, uncertain",
        "wrong, physical, certain",
        "wrong, doubted, certain",
        "wrong, uncertain, truth named",
        "wrong, uncertain, truth not named",
        "no motion",
        "named: no motion",
        "time, of that with it named",
        "longest, s",
    ];
    let mut table = Table::new("struck_open", "", &header);
    let mut numbers = Vec::new();
    let mut totals = DISTORTIONS.map(|_| (0, [0; 4]));
    for (name, kind) in kinds() {
        for (distortion, total) in DISTORTIONS.into_iter().zip(&mut totals) {
            // A quick run leaves out what takes many seconds each.
            let is_slow = distortion != 1.0 || !name.starts_with("planks, pendulum");
            if options.quick && is_slow || !options.wants(&format!("{name}, {distortion}x")) {
                continue;
            }
            let seeds = options.seeds(PERFORMANCES);
            let acted = Acted::of(distortion);
            let all: Vec<Performed> = seeds
                .map(|seed| Performed::of(&kind, &acted, seed))
                .collect();
            let of = |of: &dyn Fn(&Performed) -> f64| all.iter().map(of).collect::<Vec<f64>>();
            let wrong = |one: &Performed| one.is_motion && !one.is_right;
            table.row([
                name.clone(),
                format!("{distortion}×"),
                all.len().to_string(),
                number(median(&of(&|one| one.choices))),
                number(median(&of(&|one| one.likely as f64))),
                number(of(&|one| one.solves as f64).iter().sum::<f64>() / all.len() as f64),
                share(&all, |one| one.is_motion && one.is_right),
                share(&all, |one| one.is(true, "physical", true)),
                share(&all, |one| one.is_motion && one.is_right && !one.is_certain),
                share(&all, |one| one.is(false, "physical", true)),
                share(&all, |one| one.is(false, "plausible", true)),
                share(&all, |one| wrong(one) && !one.is_certain && one.has_truth),
                share(&all, |one| wrong(one) && !one.is_certain && !one.has_truth),
                share(&all, |one| !one.is_motion),
                share(&all, |one| one.named_verdict == "failed"),
                number(median(&of(&|one| one.open_s / one.named_s))),
                number(largest(&of(&|one| one.open_s))),
            ]);
            eprintln!("  {name}, {distortion}x");
            total.0 += all.len();
            let counts = [
                all.iter()
                    .filter(|one| one.is_motion && one.is_right)
                    .count(),
                all.iter()
                    .filter(|one| one.is(false, "physical", true))
                    .count(),
                all.iter()
                    .filter(|one| one.is(false, "plausible", true))
                    .count(),
                all.iter().filter(|one| !one.is_certain).count(),
            ];
            for (sum, count) in total.1.iter_mut().zip(counts) {
                *sum += count;
            }
            numbers.push((name.clone(), distortion, all));
        }
    }
    let said = DISTORTIONS.iter().zip(totals);
    let said: Vec<String> = said
        .map(|(distortion, (of, counts))| {
            let [right, physical, doubted, open] = counts.map(|count| percent(count, of));
            format!("{right} at {distortion}× ({physical} wrong, certain and physical, {doubted} wrong, certain and doubted, {open} said to be uncertain)")
        })
        .collect();
    record.say(format!(
        "What touches of joined bodies, where the scene does not say it, is inferred rightly in {}.",
        said.join(", ")
    ));
    record.table(table);
    record.numbers("struck_open", &numbers)
}
