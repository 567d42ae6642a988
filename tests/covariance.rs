//! Under white noise of the size the weights say, errors are as large as the covariance says.

#[path = "../tools/study/case.rs"]
mod case;
#[path = "../tools/study/dense.rs"]
mod dense;
#[path = "../tools/perform/mod.rs"]
mod perform;

use case::{Case, Posed};
use dense::Uncertainty;
use enact::math::Pose;
use enact::motion::Verdict;
use perform::{Acting, Style, Truth};

const SEEDS: u64 = 200;

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
    scene.bodies[0].body_from_tracker = Pose::identity();
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
                "{seed}: {}",
                estimate.reason
            );
            let posed = Posed::new(case.scene(), &outcome.sketch);
            let offset_s = case.offset_s(&posed, &outcome.sketch);
            let uncertainty = Uncertainty::of(&case, &posed, offset_s).unwrap();
            rank = uncertainty.rank();
            squares.push(uncertainty.normalised_square(&uncertainty.library));
            factors.push(uncertainty.variance_factor);
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
        assert!((ratio - 1.0).abs() < 0.1, "{}: {ratio}", style.word());
        let factor = mean(&factors);
        assert!((factor - 1.0).abs() < 0.1, "{}: {factor}", style.word());
        let share = covered as f64 / intervals as f64;
        assert!((share - 0.95).abs() < 0.04, "{}: {share}", style.word());
    }
}

#[test]
fn standard_deviations_of_events_are_those_of_dense_algebra() {
    for style in Style::ALL {
        let acting = white_noise();
        let case = Case::new(&truth(style, &acting), &acting, 1);
        let outcome = case.estimated(&mut ()).unwrap();
        let posed = Posed::new(case.scene(), &outcome.sketch);
        let uncertainty = Uncertainty::of(&case, &posed, 0.0).unwrap();
        for (event, at) in posed.layout.events.iter().enumerate() {
            let at = at.expect("both events are estimated");
            let exact_s = (uncertainty.exact[(at, at)] * uncertainty.variance_factor).sqrt();
            let sd_s = outcome.estimate.events[event].sd_s.unwrap();
            let ratio = sd_s / exact_s;
            assert!(
                (ratio - 1.0).abs() < 0.02,
                "{} event {event}: {ratio}",
                style.word()
            );
        }
    }
}
