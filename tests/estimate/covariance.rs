//! Errors are as large as the estimate says: under white noise, under hands that wander as slowly as
//! a flight and more slowly, with times known and unknown, with parameters free or at a bound.

use enact::math::Pose;
use enact::motion::{Estimate, ParameterEstimate, TrackIndex, Undetermined, Verdict};
use enact_tools::case::{Case, Posed};
use enact_tools::dense::Uncertainty;
use enact_tools::perform::{Acting, Style, Truth};
use enact_tools::ways;
use enact_tools::ways::Way;

const SEEDS: u64 = 100;
/// Of the ways in which nothing is white.
const WAY_SEEDS: u64 = 60;

/// White noise and nothing else.
fn white_noise() -> Acting {
    Acting {
        distortion: 0.0,
        resolution_m: 0.0,
        resolution_quaternion: 0.0,
        mark_error_s: 0.0,
        noise_position_m: 0.0005,
        noise_orientation_rad: 0.3_f64.to_radians(),
        // Few samples: the test is about many seeds.
        rate_hz: 60.0,
        ..Acting::timing_known()
    }
}

/// A pencil tracked at its centre of mass and weighed by that noise: all residuals are of one
/// unit and independent.
fn truth(style: Style, acting: &Acting) -> Truth {
    let mut scene = style.truth().scene;
    scene.tracks[TrackIndex(0)].link_from_tracker = Pose::identity();
    scene.weights.position_m = acting.noise_position_m;
    scene.weights.orientation_rad = acting.noise_orientation_rad;
    style.truth_in(&scene).unwrap()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

#[test]
fn errors_are_as_large_as_the_covariance_says() {
    for style in Style::ALL {
        let acting = white_noise();
        let truth = truth(style, &acting);
        let (mut squares, mut factors) = (Vec::new(), Vec::new());
        let (mut covered, mut intervals, mut rank) = (0, 0, 0);
        for seed in 0..SEEDS {
            let case = Case::new(&truth, &acting, seed);
            let outcome = case.estimated(&mut ()).unwrap();
            let estimate = &outcome.estimate;
            assert_eq!(
                estimate.verdict,
                Verdict::Physical,
                "{seed}: {:?}",
                estimate.reason
            );
            let posed = Posed::new(case.scene(), &outcome.sketch);
            let offset_s = case.offset_s(&posed, &outcome.sketch);
            let uncertainty = Uncertainty::of(&case, &posed, offset_s).unwrap();
            rank = uncertainty.rank();
            squares.push(uncertainty.normalised_square(&uncertainty.library));
            factors.push(mean(&uncertainty.white));
            for event in &estimate.events {
                let true_s = case.performance.truth.event_times_s[event.event] + offset_s;
                let sd_s = event.sd_s.expect("both events are estimated");
                covered += usize::from((event.time_s - true_s).abs() <= 1.96 * sd_s);
                intervals += 1;
            }
        }
        // Twelve numbers of each arc and two times, less contact, continuity and goal.
        assert_eq!(rank, 2 * 12 + 2 - 1 - 12 - 6);
        let ratio = mean(&squares) / rank as f64;
        assert!((ratio - 1.0).abs() < 0.15, "{}: {ratio}", style.as_str());
        let factor = mean(&factors);
        assert!((factor - 1.0).abs() < 0.1, "{}: {factor}", style.as_str());
        let share = covered as f64 / intervals as f64;
        assert!(
            (0.92..0.995).contains(&share),
            "{}: {share}",
            style.as_str()
        );
    }
}

#[test]
fn variances_of_the_weights_are_those_of_dense_algebra() {
    for style in Style::ALL {
        let acting = white_noise();
        let case = Case::new(&truth(style, &acting), &acting, 1);
        let outcome = case.estimated(&mut ()).unwrap();
        let posed = Posed::new(case.scene(), &outcome.sketch);
        let uncertainty = Uncertainty::of(&case, &posed, 0.0).unwrap();
        for (event, at) in posed.layout.events.iter().enumerate() {
            let at = at.expect("both events are estimated");
            let ratio = uncertainty.library[(at, at)] / uncertainty.exact[(at, at)];
            assert!(
                (ratio - 1.0).abs() < 0.02,
                "{} event {event}: {ratio}",
                style.as_str()
            );
        }
    }
}

/// Errors and reported standard deviations of every event and parameter that is estimated.
fn errors(way: &Way, seed: u64) -> Vec<(f64, Option<f64>)> {
    let case = way.case(seed).expect("no data are needed");
    let outcome = case.estimated(&mut ()).unwrap();
    let estimate = &outcome.estimate;
    if estimate.verdict != Verdict::Physical {
        return Vec::new();
    }
    let posed = Posed::new(case.scene(), &outcome.sketch);
    let offset_s = case.offset_s(&posed, &outcome.sketch);
    let truth = &case.performance.truth;
    let events = estimate.events.iter();
    let events = events.filter(|event| posed.problem.event_is_free[event.event]);
    let events = events.map(|event| {
        let true_s = truth.event_times_s[event.event] + offset_s;
        (event.time_s - true_s, event.sd_s)
    });
    let parameters = estimate.parameters.iter().zip(&truth.parameters);
    let parameters = parameters.map(|(found, truth)| (found.value - truth, found.sd));
    events.chain(parameters).collect()
}

fn way(name: &str) -> Way {
    let mut ways = ways::all().into_iter();
    ways.find(|way| way.name == name).expect("one of the ways")
}

#[test]
fn intervals_hold_however_slowly_the_hand_wanders() {
    for name in [
        "tip, known",
        "tip, known, wander of 5 flights",
        "tip, known, rough, 1 flight",
        "eraser, known, restitution and gravity free",
        "eraser, known, restitution and gravity free, wander of 5 flights",
        "eraser, unknown, restitution free",
    ] {
        let way = way(name);
        let all: Vec<Vec<(f64, Option<f64>)>> =
            (0..WAY_SEEDS).map(|seed| errors(&way, seed)).collect();
        let quantities = all.iter().map(Vec::len).max().unwrap();
        for quantity in 0..quantities {
            let runs = all.iter().filter_map(|run| run.get(quantity));
            let runs: Vec<(f64, f64)> = runs
                .map(|(error, sd)| (*error, sd.expect("determined")))
                .collect();
            let share = |width: f64| {
                let holds = runs.iter().filter(|(error, sd)| error.abs() <= width * sd);
                holds.count() as f64 / runs.len() as f64
            };
            let what = format!("{name}, {quantity}: {} runs", runs.len());
            assert!(runs.len() > 50, "{what}");
            // The uncertainty of the hand itself is not in them.
            assert!(share(1.96) >= 0.8, "{what}: {}", share(1.96));
            assert!(share(0.6745) >= 0.3, "{what}: {}", share(0.6745));
            // Wide is no art.
            let squares =
                |of: fn(&(f64, f64)) -> f64| mean(&runs.iter().map(of).collect::<Vec<_>>());
            let ratio = (squares(|run| run.1 * run.1) / squares(|run| run.0 * run.0)).sqrt();
            assert!(ratio < 4.0, "{what}: {ratio}");
        }
    }
}

fn sd(estimate: &Estimate, name: &str) -> Option<f64> {
    let mut all = estimate.parameters.iter();
    all.find(|parameter| parameter.name == name)?.sd
}

/// With neither gravity nor the tempo known, everything may as well be slower and lighter.
#[test]
fn what_nothing_determines_has_no_deviation() {
    let way = way("eraser, unknown, restitution and gravity free");
    for seed in 0..3 {
        let outcome = way.case(seed).unwrap().estimated(&mut ()).unwrap();
        let estimate = &outcome.estimate;
        assert_eq!(sd(estimate, "gravity"), None, "{seed}");
        let is_gravity = |of: &ParameterEstimate| of.name == "gravity";
        let gravity = estimate.parameters.iter().position(is_gravity).unwrap();
        let gravity = Undetermined::Parameter(gravity);
        assert!(estimate.undetermined.contains(&gravity), "{seed}");
        for event in &estimate.events {
            assert_eq!(event.sd_s, None, "{seed}");
        }
    }
}

/// A bound keeps a parameter from its best value; it is no better known for that.
#[test]
fn a_parameter_at_its_bound_is_not_certain() {
    let acting = Acting::timing_known();
    let mut truth = ways::freed(Style::Tip.truth(), false);
    let free = &mut truth.scene.parameters[0];
    (free.initial, free.lower, free.upper) = (0.55, 0.5, 0.6);
    let outcome = Case::new(&truth, &acting, 0).estimated(&mut ()).unwrap();
    let estimate = &outcome.estimate;
    assert!((estimate.parameters[0].value - 0.6).abs() < 1e-6);
    let sd = sd(estimate, "restitution").unwrap();
    // The truth is 0.15 beyond the bound.
    assert!(sd > 0.05 && sd < 0.2, "{sd}");
}
