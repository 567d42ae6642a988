//! Errors of a hand as a process in time, beside samples weighed one by one: how near the truth motions come, how often
//! intervals hold it, and which mistakes of a scene show.

use anyhow::Result;
use enact::math::Pose;
use enact::motion::{Performer, Quantity, Scene, Verdict, Weights};
use enact::physics::tree::Snapshot;
use enact::pipeline::{Outcome, Pipeline};
use enact_tools::case::{Case, Posed};
use enact_tools::nonsense::Asked;
use enact_tools::nonsense::wrong::Wrong;
use enact_tools::perform::{Acting, Style, bounces};
use enact_tools::trees::{self, Jointed, Kind, TreeActing, TreePerformance};
use serde::Serialize;

use crate::core_time::CoreTime;
use crate::options::Options;
use crate::record::Record;
use crate::statistics::{median, rms};
use crate::table::{Table, number, percent};

/// Performances of a row.
const PERFORMANCES: u64 = 40;
/// Instants of a flight at which intervals along it are looked at.
const INSTANTS: usize = 11;
/// Half the width of a 95 % interval, in deviations.
const INTERVAL: f64 = 1.96;
/// How samples are weighed.
const WEIGHED: [(&str, Performer); 2] = [
    ("one by one", Performer::Nobody),
    ("as a process", Performer::Hand),
];
/// Wrong scenes that are asked.
const WRONGS: [Wrong; 6] = [
    Wrong::Restitution,
    Wrong::Inertia,
    Wrong::Gravity,
    Wrong::GravityDirection,
    Wrong::TableHeight,
    Wrong::Clock,
];

/// What is performed.
#[derive(Clone, Copy)]
enum Performed {
    Pencil,
    Cube(usize),
}

impl Performed {
    fn case(self, acting: &Acting, seed: u64) -> Option<Case> {
        match self {
            Self::Pencil => Some(Case::pencil(Style::Tip, acting, seed)),
            Self::Cube(count) => Some(Case::new(&bounces(count, seed).ok()?, acting, seed)),
        }
    }

    fn name(self) -> String {
        match self {
            Self::Pencil => "a pencil".to_owned(),
            Self::Cube(count) => format!("a cube, bounces: {count}"),
        }
    }
}

/// A hand, by its wander's size and pace; at random where there is none.
type Hand = Option<[f64; 2]>;

const HANDS: [(&str, Hand); 6] = [
    ("usual, compressed 2.5 times", Some([1.0, 2.5])),
    ("usual, in real time", Some([1.0, 1.0])),
    ("usual, stretched 2.5 times", Some([1.0, 0.4])),
    ("a quarter, in real time", Some([0.25, 1.0])),
    ("twice, in real time", Some([2.0, 1.0])),
    ("drawn, with round kinks", None),
];

/// Whether stamps are physical times, or the tempo is unknown and slow.
#[derive(Clone, Copy)]
enum Stamps {
    Physical,
    Tempo,
}

impl Stamps {
    fn name(self) -> &'static str {
        match self {
            Self::Physical => "physical",
            Self::Tempo => "tempo",
        }
    }

    fn acting(self, hand: Hand, seed: u64) -> Acting {
        let of_stamps = match self {
            Self::Physical => Acting::timing_known(),
            Self::Tempo => Acting::default(),
        };
        match hand {
            Some([distortion, wander_pace]) => Acting {
                distortion,
                wander_pace,
                ..of_stamps
            },
            None => {
                let drawn = Acting::drawn(seed);
                Acting {
                    distortion: drawn.distortion,
                    wander_pace: drawn.wander_pace,
                    kink_s: drawn.kink_s,
                    rate_hz: drawn.rate_hz,
                    mark_error_s: match self {
                        Self::Physical => 0.5 / drawn.rate_hz,
                        Self::Tempo => of_stamps.mark_error_s,
                    },
                    ..of_stamps
                }
            }
        }
    }
}

/// Errors of estimates, all of a row together.
#[derive(Default, Serialize)]
struct Errors {
    performances: usize,
    physical: usize,
    suspected: usize,
    times_ms: Vec<f64>,
    deviations: Vec<f64>,
    positions_mm: Vec<f64>,
    turns_deg: Vec<f64>,
    velocities_mm_s: Vec<f64>,
    spins_rad_s: Vec<f64>,
    took_ms: Vec<f64>,
    /// Of places, turns, velocities and spins along the motion.
    along: [Held; 4],
}

/// Intervals that hold the truth.
#[derive(Clone, Copy, Default, Serialize)]
struct Held {
    held: usize,
    told: usize,
}

impl Held {
    fn add(&mut self, off: f64, sd: Option<f64>) {
        let Some(sd) = sd else { return };
        self.held += usize::from(off.abs() < INTERVAL * sd);
        self.told += 1;
    }
}

impl Errors {
    /// Of the answers to all performances.
    fn of(case: impl Fn(u64) -> Option<Case>, performer: Performer, options: &Options) -> Self {
        let mut errors = Self::default();
        for mut case in options.seeds(PERFORMANCES).filter_map(case) {
            case.performance.truth.scene.performer = performer;
            let time = CoreTime::begin();
            let Ok(outcome) = case.pipeline().finish(&mut ()) else {
                continue;
            };
            errors.took_ms.push(1e3 * time.seconds());
            errors.performances += 1;
            errors.add(&case, &outcome);
        }
        errors
    }

    /// A row's, after its names.
    fn cells(&self) -> [String; 15] {
        let held = self.deviations.iter().filter(|of| **of < INTERVAL);
        let sizes_ms: Vec<f64> = self.times_ms.iter().map(|of| of.abs()).collect();
        let [places, turns, velocities, spins] = self.along;
        [
            self.performances.to_string(),
            percent(self.physical, self.performances),
            percent(self.suspected, self.performances),
            number(rms(&self.times_ms)),
            number(median(&sizes_ms)),
            percent(held.count(), self.deviations.len()),
            number(median(&self.positions_mm)),
            number(median(&self.turns_deg)),
            number(median(&self.velocities_mm_s)),
            number(median(&self.spins_rad_s)),
            number(median(&self.took_ms)),
            percent(places.held, places.told),
            percent(turns.held, turns.told),
            percent(velocities.held, velocities.told),
            percent(spins.held, spins.told),
        ]
    }

    fn add(&mut self, case: &Case, outcome: &Outcome) {
        let estimate = &outcome.estimate;
        self.physical += usize::from(estimate.verdict == Verdict::Physical);
        self.suspected += usize::from(!estimate.suspects.is_empty());
        let posed = Posed::new(case.scene(), &outcome.sketch);
        let offset_s = case.offset_s(&posed, &outcome.sketch);
        let truth = &case.performance.truth;
        let free = |event: &usize| posed.problem.event_is_free[*event];
        for event in estimate.events.iter().filter(|of| free(&of.event)) {
            let off_s = event.time_s - offset_s - truth.event_times_s[event.event];
            self.times_ms.push(1e3 * off_s);
            self.deviations
                .extend(event.sd_s.map(|sd_s| off_s.abs() / sd_s));
        }
        for (index, arc) in estimate.arcs.iter().enumerate() {
            let true_state = case.true_state(index, arc.epoch_s, offset_s);
            let off = arc.state.minus(&true_state);
            let block = |at: usize| off.fixed_rows::<3>(3 * at).norm();
            self.positions_mm.push(1e3 * block(0));
            self.turns_deg.push(block(1).to_degrees());
            self.velocities_mm_s.push(1e3 * block(2));
            self.spins_rad_s.push(block(3));
            self.add_along(case, outcome, index, offset_s);
        }
    }

    /// Intervals along a flight.
    fn add_along(&mut self, case: &Case, outcome: &Outcome, index: usize, offset_s: f64) {
        let (scene, estimate) = (&outcome.scene, &outcome.estimate);
        let arc = &estimate.arcs[index];
        let Some(certainty) = &arc.certainty else {
            return;
        };
        let body = scene.body_of(arc.mechanism);
        let gravity_m_s2 = &estimate.gravity_m_s2;
        for instant in 0..INSTANTS {
            let share = instant as f64 / (INSTANTS - 1) as f64;
            let time_s = arc.start_s + share * (arc.end_s - arc.start_s);
            let lasts_s = time_s - arc.epoch_s;
            let state = scene.flown(arc, gravity_m_s2, time_s);
            let off = state.minus(&case.true_state(index, time_s, offset_s));
            let sds =
                certainty.deviation(body, gravity_m_s2, &arc.state, lasts_s, &Pose::identity());
            for (part, sds) in sds.parts().into_iter().enumerate() {
                for (axis, sd) in sds.into_iter().enumerate() {
                    self.along[part].add(off[3 * part + axis], sd);
                }
            }
        }
    }
}

/// Runs it.
pub fn run(options: &Options, record: &mut Record) -> Result<()> {
    bodies(options, record)?;
    joined(options, record)?;
    wrong(options, record)
}

fn bodies(options: &Options, record: &mut Record) -> Result<()> {
    let header = [
        "stamps",
        "motion",
        "hand",
        "samples weighed",
        "performances",
        "physical",
        "suspected",
        "times, ms rms",
        "times, ms",
        "95 % intervals hold",
        "positions, mm",
        "turns, °",
        "velocities, mm/s",
        "spins, rad/s",
        "took, ms",
        "along: places hold",
        "turns",
        "velocities",
        "spins",
    ];
    let mut table = Table::new("bodies", "", &header);
    let mut all = Vec::new();
    let [mut suspected, mut right] = [0; 2];
    let motions = [Performed::Pencil, Performed::Cube(1), Performed::Cube(4)];
    let performed = [Stamps::Physical, Stamps::Tempo]
        .into_iter()
        .flat_map(|stamps| motions.map(|of| (stamps, of)));
    for (stamps, performed) in performed {
        for (hand, of) in HANDS {
            for (weighed, performer) in WEIGHED {
                let case = |seed: u64| performed.case(&stamps.acting(of, seed), seed);
                let errors = Errors::of(case, performer, options);
                if performer == Performer::Hand {
                    suspected += errors.suspected;
                    right += errors.performances;
                }
                let names = [stamps.name(), &performed.name(), hand, weighed].map(str::to_owned);
                table.row(names.clone().into_iter().chain(errors.cells()));
                eprintln!("  {}", names.join(", "));
                all.push((names, errors));
            }
        }
    }
    record.table(table);
    record.numbers("bodies", &all)?;
    record.say(format!(
        "Of {right} right throws whose errors are taken for a process {suspected} are suspected."
    ));
    Ok(())
}

fn joined(options: &Options, record: &mut Record) -> Result<()> {
    let header = [
        "motion",
        "samples weighed",
        "performances",
        "physical",
        "places of links, mm",
        "spins of links, rad/s",
        "took, ms",
    ];
    let mut table = Table::new("joined", "", &header);
    for (name, kind) in [
        (
            "pendulum of 2, universal",
            Kind::pendulum(2, Jointed::Universal),
        ),
        ("pendulum of 3, pins", Kind::pendulum(3, Jointed::Pin)),
        ("the chain", Kind::CHAIN),
    ] {
        for (weighed, performer) in WEIGHED {
            let (mut places, mut spins, mut took) = (Vec::new(), Vec::new(), Vec::new());
            let mut physical = 0;
            for seed in options.seeds(PERFORMANCES / 2) {
                let performance = trees::perform(&kind, &TreeActing::of(1.0), seed);
                let scene = Scene {
                    performer,
                    ..performance.scene.clone()
                };
                let events = performance.events.iter().cloned();
                let time = CoreTime::begin();
                let Ok(outcome) = Pipeline::of(scene, events).finish(&mut ()) else {
                    continue;
                };
                took.push(1e3 * time.seconds());
                physical += usize::from(outcome.estimate.verdict == Verdict::Physical);
                let [place_mm, spin_rad_s] = off(&performance, &outcome, kind.links);
                places.push(place_mm);
                spins.push(spin_rad_s);
            }
            table.row([
                name.to_owned(),
                weighed.to_owned(),
                places.len().to_string(),
                percent(physical, places.len()),
                number(median(&places)),
                number(median(&spins)),
                number(median(&took)),
            ]);
            eprintln!("  {name}, {weighed}");
        }
    }
    record.table(table);
    Ok(())
}

/// Root mean square errors of the links' places \[mm\] and spins [rad/s] at all samples.
fn off(performance: &TreePerformance, outcome: &Outcome, links: usize) -> [f64; 2] {
    let (tree, scene) = (performance.tree(), &performance.scene);
    let of_start = |start| {
        let (lasts_s, rate_hz) = (performance.duration_s, trees::RATE_HZ);
        trees::motion(scene, &tree, start, lasts_s, rate_hz)
    };
    let found = match outcome.estimate.trees.first().map(|of| &of.knots[..]) {
        Some([first, ..]) => of_start(&first.state),
        _ => return [f64::NAN; 2],
    };
    let mut snapshots = [(); 2].map(|()| Snapshot::new(&tree, &scene.gravity_m_s2));
    let (mut places_mm, mut spins_rad_s) = (Vec::new(), Vec::new());
    for (state, other) in of_start(&performance.truth).iter().zip(&found) {
        snapshots[0].set(state);
        snapshots[1].set(other);
        for link in 0..links {
            let [one, other] = [0, 1].map(|of| snapshots[of].link_state(link));
            places_mm.push(1e3 * (one.position_m - other.position_m).norm());
            let spin = one.angular_velocity_rad_s - other.angular_velocity_rad_s;
            spins_rad_s.push(spin.norm());
        }
    }
    [rms(&places_mm), rms(&spins_rad_s)]
}

fn wrong(options: &Options, record: &mut Record) -> Result<()> {
    let header = [
        "wrong",
        "hand",
        "samples weighed",
        "performances",
        "suspected",
        "named",
        "named first",
    ];
    let mut table = Table::new("wrong", "", &header);
    for wrong in WRONGS {
        for (hand, distortion) in [("noise", 0.0), ("a quarter", 0.25), ("whole", 1.0)] {
            let acting = Acting {
                distortion,
                wander_pace: 1.0,
                ..Acting::timing_known()
            };
            for (weighed, performer) in WEIGHED {
                let [mut asked, mut suspected, mut named, mut first] = [0; 4];
                for seed in options.seeds(PERFORMANCES / 2) {
                    let Ok(mut one) = wrong.asked(&acting, seed) else {
                        continue;
                    };
                    weigh(&mut one, performer);
                    let Ok(outcome) = one.answered() else {
                        continue;
                    };
                    let suspects = &outcome.estimate.suspects;
                    let is_of = |of: &(Quantity, f64)| wrong.is_of(of.0);
                    asked += 1;
                    suspected += usize::from(!suspects.is_empty());
                    named += usize::from(suspects.iter().any(|of| of.values.iter().any(is_of)));
                    first += usize::from(suspects.iter().take(1).any(|of| is_of(&of.values[0])));
                }
                table.row([
                    wrong.name().to_owned(),
                    hand.to_owned(),
                    weighed.to_owned(),
                    asked.to_string(),
                    percent(suspected, asked),
                    percent(named, asked),
                    percent(first, asked),
                ]);
            }
            eprintln!("  {}, {hand}", wrong.name());
        }
    }
    record.table(table);
    Ok(())
}

/// The weights of a usual hand.
fn weigh(asked: &mut Asked, performer: Performer) {
    asked.scene.performer = performer;
    asked.scene.weights = Weights {
        position_m: 0.01,
        orientation_rad: 0.1,
    };
}
