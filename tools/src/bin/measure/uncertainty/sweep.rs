//! How little data is enough: what is swept.

use anyhow::Result;
use enact::motion::{TakeEvent, TrackIndex};

use super::bound::Level;
use super::figures::{coverage, efficiency, event_times};
use super::{weighed, white_noise};
use crate::options::Options;
use crate::record::Record;
use enact_tools::case::Case;
use enact_tools::perform::{Acting, Style, Truth, bounces};

/// Performances of a setting.
const SEEDS: u64 = 400;

/// One setting of a sweep.
pub struct Setting {
    /// Across.
    pub x: f64,
    truth: Truth,
    acting: Acting,
    /// Only samples this near to the first event are there \[s\].
    window_s: Option<f64>,
}

impl Setting {
    /// Its performance of a seed.
    pub fn case(&self, seed: u64) -> Case {
        let mut case = Case::new(&self.truth, &self.acting, seed);
        if let Some(window_s) = self.window_s {
            narrow(&mut case, window_s);
        }
        case
    }
}

/// Runs it.
pub fn run(options: &Options, record: &mut Record) -> Result<()> {
    let sweep = |settings: Vec<Setting>| -> Vec<Level> {
        let levels = settings.iter();
        levels
            .map(|setting| Level::of(setting, options.seeds(SEEDS)))
            .collect()
    };
    let noise = sweep(noise_levels());
    let rate = sweep(rates());
    let number = sweep(numbers());
    let hand = sweep(hands());
    let of_noise = "noise per axis, in units of 0.5 mm and 0.3°";
    let pencil = "Pencil, tip first, timing known, white noise, weighed by it.";
    let cube = "Cube with one bounce and no goals, 1000 samples per second, seen only near the bounce; \
                white noise of 0.5 mm and 0.3° per axis.";
    for (name, what, label, note, levels) in [
        ("noise", "noise", of_noise, pencil, &noise),
        ("rate", "sample rate", "samples per second", pencil, &rate),
        (
            "number",
            "number of samples",
            "samples in either flight",
            cube,
            &number,
        ),
    ] {
        let seeds = options.seeds(SEEDS);
        let note = format!("{note} {} performances per point.", seeds.end - seeds.start);
        record.figure(event_times(name, what, label, &note, levels));
        record.figure(efficiency(name, what, label, &note, levels));
    }
    let title = "Intervals of event times hold the truth as often as they say, at any noise";
    record.figure(coverage("coverage_noise", title, of_noise, pencil, &noise));
    let title = "With a wandering hand instead of white noise, intervals of event times hold the truth this often";
    let label = "wander, in units of 2 cm and 8°";
    let note = "Pencil, tip first, timing known, the hand's smooth wander and the tracker's noise, default weights.";
    record.figure(coverage("coverage_hand", title, label, note, &hand));
    record.numbers(
        "sweeps",
        &[
            ("noise", noise),
            ("rate", rate),
            ("number", number),
            ("hand", hand),
        ],
    )
}

fn pencil(x: f64, acting: Acting) -> Setting {
    Setting {
        x,
        truth: weighed(Style::Tip, &acting),
        acting,
        window_s: None,
    }
}

fn noise_levels() -> Vec<Setting> {
    let setting = |x: f64| {
        let white = white_noise();
        let acting = Acting {
            noise_position_m: x * white.noise_position_m,
            noise_orientation_rad: x * white.noise_orientation_rad,
            ..white
        };
        pencil(x, acting)
    };
    [0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0].map(setting).into()
}

fn rates() -> Vec<Setting> {
    let rates_hz = [
        8.0, 10.0, 12.0, 15.0, 20.0, 30.0, 60.0, 125.0, 250.0, 500.0, 1000.0,
    ];
    let setting = |rate_hz: f64| {
        let acting = Acting {
            rate_hz,
            ..white_noise()
        };
        pencil(rate_hz, acting)
    };
    rates_hz.map(setting).into()
}

fn numbers() -> Vec<Setting> {
    const RATE_HZ: f64 = 1000.0;
    let acting = Acting {
        rate_hz: RATE_HZ,
        ..white_noise()
    };
    let mut truth = bounces(1, 1).expect("a motion with one bounce");
    truth.scene.tracks[TrackIndex(0)].link_from_tracker = enact::math::Pose::identity();
    truth.scene.weights.position_m = acting.noise_position_m;
    truth.scene.weights.orientation_rad = acting.noise_orientation_rad;
    let setting = |x: f64| Setting {
        x,
        truth: truth.clone(),
        acting,
        window_s: Some((x + 0.5) / RATE_HZ),
    };
    [2.0, 3.0, 4.0, 5.0, 7.0, 10.0, 20.0, 50.0, 100.0]
        .map(setting)
        .into()
}

fn hands() -> Vec<Setting> {
    let setting = |distortion: f64| Setting {
        x: distortion,
        truth: Style::Tip.truth(),
        acting: Acting {
            distortion,
            ..Acting::timing_known()
        },
        window_s: None,
    };
    [0.1, 0.25, 0.5, 1.0, 2.0, 4.0].map(setting).into()
}

/// Leaves the samples near the first event, and marks within them.
fn narrow(case: &mut Case, window_s: f64) {
    let centre_s = case.performance.truth.event_times_s[0];
    let is_near = |case: &Case, event: &TakeEvent| match event {
        TakeEvent::Pose { track, sample, .. } => {
            (case.hidden_s(*track, sample.stamp) - centre_s).abs() < window_s
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
