//! Part 5: how little data is enough, and how certain the estimate is: errors against noise, rate
//! and number of samples beside the Cramér–Rao bound, and the coverage of reported intervals.

use anyhow::Result;
use enact::motion::{TakeEvent, Verdict};
use nalgebra::DMatrix;
use serde::Serialize;

use crate::Options;
use crate::book::Book;
use crate::covariance::{KINDS, rms_by_kind, weighed, white_noise};
use crate::figure::{Axis, Curve, Figure, Mark};
use crate::statistics::rms;
use enact_tools::case::{Case, Posed};
use enact_tools::dense::{self, Uncertainty};
use enact_tools::perform::{Acting, Style, Truth, bounces};

/// Shares of intervals, and their half widths in standard deviations of a normal distribution.
const INTERVALS: [(f64, f64); 3] = [(50.0, 0.674_49), (90.0, 1.644_85), (95.0, 1.959_96)];
/// Beyond this many standard deviations a tail holds 2.5 %.
const TWO_SIDED: f64 = 1.96;

/// One setting of a sweep.
struct Setting {
    /// Across.
    x: f64,
    truth: Truth,
    acting: Acting,
    /// Only samples this near to the first event are there \[s\].
    window_s: Option<f64>,
}

/// What became of one.
#[derive(Serialize)]
struct Level {
    x: f64,
    seeds: u64,
    /// Estimates that converged to a physical motion.
    estimated: usize,
    /// Samples used, of the last.
    samples: usize,
    /// Rms error and bound of the first event's time \[s\].
    event_s: [f64; 2],
    /// Rms errors of each kind of unknown, and their bounds.
    errors: [f64; 5],
    bounds: [f64; 5],
    /// Of all event times: how many there are, how many have no standard deviation, how many lie
    /// within each interval.
    events: usize,
    without_sd: usize,
    covered: [usize; 3],
}

/// Runs it.
pub fn run(options: &Options, book: &mut Book) -> Result<()> {
    let seeds = if options.quick { 20 } else { 400 };
    let noise = sweep(noise_levels(), seeds);
    let rate = sweep(rates(), seeds);
    let number = sweep(numbers(), seeds);
    let hand = sweep(hands(), seeds);
    let of_noise = "noise per axis, in units of 0.5 mm and 0.3°";
    let of_rate = "samples per second";
    let of_number = "samples in either flight";
    let pencil = "Pencil, tip first, timing known, white noise, weighed by it.";
    let cube = "Cube with one bounce and no goals, 1000 samples per second, seen only near the bounce; \
                white noise of 0.5 mm and 0.3° per axis.";
    for (name, what, label, note, levels) in [
        ("noise", "noise", of_noise, pencil, &noise),
        ("rate", "sample rate", of_rate, pencil, &rate),
        ("number", "number of samples", of_number, cube, &number),
    ] {
        let note = format!("{note} {seeds} performances per point.");
        book.keep(event_times(name, what, label, &note, levels))?;
        book.keep(efficiency(name, what, label, &note, levels))?;
    }
    let title = "Intervals of event times hold the truth as often as they say, at any noise";
    book.keep(coverage("coverage_noise", title, of_noise, pencil, &noise))?;
    let title = "With a wandering hand instead of white noise, intervals of event times hold the truth this often";
    let label = "wander, in units of 2 cm and 8°";
    let note = "Pencil, tip first, timing known, the hand's smooth wander and the tracker's noise, default weights.";
    book.keep(coverage("coverage_hand", title, label, note, &hand))?;
    let all = [
        ("noise", noise),
        ("rate", rate),
        ("number", number),
        ("hand", hand),
    ];
    book.numbers("data", &all)
}

fn noise_levels() -> Vec<Setting> {
    let factors = [0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0];
    let setting = |x: f64| {
        let white = white_noise();
        let acting = Acting {
            noise_position_m: x * white.noise_position_m,
            noise_orientation_rad: x * white.noise_orientation_rad,
            ..white
        };
        pencil(x, acting)
    };
    factors.map(setting).into()
}

fn rates() -> Vec<Setting> {
    let rates_hz = [
        8.0, 10.0, 12.0, 15.0, 20.0, 30.0, 60.0, 125.0, 250.0, 500.0, 1000.0,
    ];
    let setting = |x: f64| {
        let acting = Acting {
            rate_hz: x,
            ..white_noise()
        };
        pencil(x, acting)
    };
    rates_hz.map(setting).into()
}

fn pencil(x: f64, acting: Acting) -> Setting {
    Setting {
        x,
        truth: weighed(Style::Tip, &acting),
        acting,
        window_s: None,
    }
}

fn numbers() -> Vec<Setting> {
    const RATE_HZ: f64 = 1000.0;
    let acting = Acting {
        rate_hz: RATE_HZ,
        ..white_noise()
    };
    let mut truth = bounces(1, 1).expect("a motion with one bounce");
    truth.scene.bodies[0].body_from_tracker = enact::math::Pose::identity();
    truth.scene.weights.position_m = acting.noise_position_m;
    truth.scene.weights.orientation_rad = acting.noise_orientation_rad;
    let counts = [2.0, 3.0, 4.0, 5.0, 7.0, 10.0, 20.0, 50.0, 100.0];
    let setting = |x: f64| Setting {
        x,
        truth: truth.clone(),
        acting,
        window_s: Some((x + 0.5) / RATE_HZ),
    };
    counts.map(setting).into()
}

fn hands() -> Vec<Setting> {
    let distortions = [0.1, 0.25, 0.5, 1.0, 2.0, 4.0];
    let setting = |x: f64| Setting {
        x,
        truth: Style::Tip.truth(),
        acting: Acting {
            distortion: x,
            ..Acting::timing_known()
        },
        window_s: None,
    };
    distortions.map(setting).into()
}

fn sweep(settings: Vec<Setting>, seeds: u64) -> Vec<Level> {
    let levels = settings.iter();
    levels.map(|setting| level(setting, seeds)).collect()
}

/// Squares that are summed over the seeds.
#[derive(Default)]
struct Sums {
    event: [Vec<f64>; 2],
    errors: [Vec<f64>; 5],
    bounds: [Vec<f64>; 5],
}

fn level(setting: &Setting, seeds: u64) -> Level {
    let mut level = Level {
        x: setting.x,
        seeds,
        estimated: 0,
        samples: 0,
        event_s: [f64::NAN; 2],
        errors: [f64::NAN; 5],
        bounds: [f64::NAN; 5],
        events: 0,
        without_sd: 0,
        covered: [0; 3],
    };
    let mut sums = Sums::default();
    for seed in 0..seeds {
        let mut case = Case::new(&setting.truth, &setting.acting, seed);
        if let Some(window_s) = setting.window_s {
            narrow(&mut case, window_s);
        }
        level.add(&case, &mut sums);
    }
    level.event_s = [0, 1].map(|index| rms(&sums.event[index]));
    level.errors = std::array::from_fn(|kind| rms(&sums.errors[kind]));
    level.bounds = std::array::from_fn(|kind| rms(&sums.bounds[kind]));
    level
}

/// Leaves the samples near the first event, and marks within them.
fn narrow(case: &mut Case, window_s: f64) {
    let centre_s = case.performance.truth.event_times_s[0];
    let is_near = |case: &Case, event: &TakeEvent| match event {
        TakeEvent::Pose { body, sample, .. } => {
            (case.hidden_s(*body, sample.stamp) - centre_s).abs() < window_s
        }
        TakeEvent::Mark(_) => true,
    };
    let events = std::mem::take(&mut case.performance.events);
    let near = events.into_iter().filter(|event| is_near(case, event));
    let mut events: Vec<TakeEvent> = near.collect();
    let stamps = events.iter().filter_map(|event| match event {
        TakeEvent::Pose { sample, .. } => Some(sample.stamp),
        TakeEvent::Mark(_) => None,
    });
    let last = stamps.max();
    for event in &mut events {
        if let (TakeEvent::Mark(mark), Some(last)) = (event, last) {
            mark.stamp = mark.stamp.min(last);
        }
    }
    case.performance.events = events;
}

impl Level {
    fn add(&mut self, case: &Case, sums: &mut Sums) {
        let Ok(outcome) = case.estimated(&mut ()) else {
            return;
        };
        let estimate = &outcome.estimate;
        if estimate.verdict != Verdict::Physical {
            return;
        }
        self.estimated += 1;
        self.samples = outcome.counts.used;
        let posed = Posed::new(case.scene(), &outcome.sketch);
        let offset_s = case.offset_s(&posed, &outcome.sketch);
        for event in &estimate.events {
            if !posed.problem.event_is_free[event.event] {
                continue;
            }
            let true_s = case.performance.truth.event_times_s[event.event] + offset_s;
            let error_s = (event.time_s - true_s).abs();
            self.events += 1;
            self.without_sd += usize::from(event.sd_s.is_none());
            for (covered, (_, width)) in self.covered.iter_mut().zip(INTERVALS) {
                let holds = event.sd_s.is_some_and(|sd_s| error_s <= width * sd_s);
                *covered += usize::from(holds);
            }
        }
        let bound = dense::bound(case, &posed, &outcome.sketch);
        let uncertainty = Uncertainty::of(case, &posed, offset_s);
        if let (Some(bound), Some(uncertainty)) = (bound, uncertainty) {
            sums.add(&posed, &bound, &uncertainty);
        }
    }

    /// Spread of an rms of that many normal errors, 95 %.
    fn spread(&self, value: f64) -> Option<[f64; 2]> {
        let share = TWO_SIDED / (2.0 * self.estimated as f64).sqrt();
        Some([value * (1.0 - share).max(0.0), value * (1.0 + share)])
    }

    fn mark(&self, y: f64) -> Mark {
        let most = self.seeds as usize;
        let all = self.estimated == most;
        Mark {
            spread: self.spread(y),
            failed: 2 * self.estimated < most,
            setting: (!all).then(|| format!("{} of {most}", self.estimated)),
            ..Mark::at(self.x, y)
        }
    }
}

impl Sums {
    fn add(&mut self, posed: &Posed, bound: &DMatrix<f64>, uncertainty: &Uncertainty) {
        let sd = |at: usize| bound[(at, at)].max(0.0).sqrt();
        if let Some(at) = posed.layout.events[0] {
            self.event[0].push(uncertainty.error[at]);
            self.event[1].push(sd(at));
        }
        let errors = rms_by_kind(posed, |at| uncertainty.error[at]);
        let bounds = rms_by_kind(posed, sd);
        for kind in 0..5 {
            self.errors[kind].push(errors[kind]);
            self.bounds[kind].push(bounds[kind]);
        }
    }
}

fn event_times(name: &str, what: &str, label: &str, note: &str, levels: &[Level]) -> Figure {
    let bounds = levels.iter().map(|l| Mark::at(l.x, 1e3 * l.event_s[1]));
    let errors = levels
        .iter()
        .map(|level| level.mark(1e3 * level.event_s[0]));
    Figure {
        name: format!("data_{name}"),
        title: format!(
            "How exactly the bounce is timed, against {what}, beside the least error any unbiased estimate can have"
        ),
        note: format!(
            "{note} Rms error; bars: 95 % of such an rms. Beside a point: how many gave a physical motion, where not all."
        ),
        x: Axis::logarithmic(label),
        y: Axis::logarithmic("rms error of the bounce's time [ms]"),
        curves: vec![
            Curve::ours("the program", errors.collect()),
            Curve::bound("Cramér–Rao bound", bounds.collect()),
        ],
    }
}

fn efficiency(name: &str, what: &str, label: &str, note: &str, levels: &[Level]) -> Figure {
    let of_kind = |kind: usize| {
        let marks = levels.iter().filter(|level| level.bounds[kind] > 0.0);
        let marks = marks.map(|level| Mark {
            setting: None,
            ..level.mark(level.errors[kind] / level.bounds[kind])
        });
        Curve::new(KINDS[kind], marks.collect())
    };
    let ends = [levels.first(), levels.last()].into_iter().flatten();
    let mut curves: Vec<Curve> = (0..5).map(of_kind).collect();
    curves.push(Curve::bound(
        "the bound",
        ends.map(|l| Mark::at(l.x, 1.0)).collect(),
    ));
    Figure {
        name: format!("data_{name}_efficiency"),
        title: format!(
            "Errors of all unknowns over their Cramér–Rao bounds, against {what}: 1 is as good as can be"
        ),
        note: format!(
            "{note} Rms over all unknowns of a kind; bars: 95 % of the rms of as many independent errors."
        ),
        x: Axis::logarithmic(label),
        y: Axis::linear("rms error over its bound"),
        curves,
    }
}

fn coverage(name: &str, title: &str, label: &str, note: &str, levels: &[Level]) -> Figure {
    let mut curves = Vec::new();
    for (index, (share, _)) in INTERVALS.into_iter().enumerate() {
        let mark = |level: &Level| {
            let (held, of) = (level.covered[index] as f64, level.events as f64);
            Mark {
                spread: Some(wilson(held, of)),
                failed: 2 * level.estimated < level.seeds as usize,
                ..Mark::at(level.x, 100.0 * held / of)
            }
        };
        let name = format!("{share} % intervals");
        curves.push(Curve::new(name, levels.iter().map(mark).collect()));
    }
    let ends = || [levels.first(), levels.last()].into_iter().flatten();
    for (share, _) in INTERVALS {
        let ends = ends().map(|level| Mark::at(level.x, share)).collect();
        curves.push(Curve::bound("as they say", ends));
    }
    let seeds = levels.first().map_or(0, |level| level.seeds);
    Figure {
        name: format!("data_{name}"),
        title: title.to_owned(),
        note: format!(
            "{note} {seeds} performances per point, bounce and landing; bars: 95 % intervals of the share."
        ),
        x: Axis::logarithmic(label),
        y: Axis::linear("intervals that hold the truth [%]"),
        curves,
    }
}

/// Wilson's 95 % interval of a share, in per cent.
fn wilson(held: f64, of: f64) -> [f64; 2] {
    let (share, square) = (held / of, TWO_SIDED * TWO_SIDED);
    let middle = (share + square / (2.0 * of)) / (1.0 + square / of);
    let half = TWO_SIDED * (share * (1.0 - share) / of + square / (4.0 * of * of)).sqrt()
        / (1.0 + square / of);
    [100.0 * (middle - half), 100.0 * (middle + half)]
}
