//! Timing unknown: what it costs when samples are many, and how certain the times are that come out.

use enact::motion::Verdict;
use enact_tools::case::{Case, Posed};
use enact_tools::dense::Uncertainty;
use enact_tools::perform::{Acting, Style, bounces};

/// A pencil, tip first, acted slowly, in about so many samples.
fn sampled(count: f64) -> Case {
    let truth = Style::Tip.truth();
    let slow = Acting::default();
    let rate_hz = count / truth.duration_s / slow.slowdown;
    let acting = Acting {
        rate_hz,
        stamp_jitter_s: 0.05 / rate_hz,
        ..slow
    };
    Case::new(&truth, &acting, 1).one_by_one()
}

#[test]
fn a_faster_tracker_takes_no_more_iterations_and_no_more_memory() {
    let mut iterations = Vec::new();
    let mut durations_s = Vec::new();
    for count in [1e2, 1e3, 1e4] {
        let case = sampled(count);
        let outcome = case.estimated(&mut ()).unwrap();
        let estimate = &outcome.estimate;
        assert_eq!(estimate.verdict, Verdict::Physical, "{:?}", estimate.reason);
        assert_eq!(estimate.sample_times.len(), outcome.counts.used);
        let times_s = || estimate.sample_times.iter().map(|sample| sample.time_s);
        assert!(times_s().zip(times_s().skip(1)).all(|(a, b)| a < b));
        iterations.push(estimate.counters.iterations);
        durations_s.push(estimate.duration.duration_s);
        let posed = Posed::new(case.scene(), &outcome.sketch);
        let (used, stored) = (outcome.counts.used, posed.layout.structure.pattern.stored());
        // Twelve rows of a state over the nodes of its flight, three entries of a node's own.
        assert!(stored < 16 * used.min(450) + 1000, "{used}: {stored}");
    }
    let (least, most) = (iterations.iter().min(), iterations.iter().max());
    // Each time that samples are assigned again takes a few more.
    assert!(most.unwrap() <= &(2 * least.unwrap()), "{iterations:?}");
    // Two draws of the same hand, at another rate: the optimum is about the same.
    let off = (durations_s[2] - durations_s[1]).abs() / durations_s[1];
    assert!(off < 0.03, "{durations_s:?}");
}

#[test]
fn a_longer_performance_takes_memory_as_it_has_samples() {
    let mut per_sample = Vec::new();
    for count in [2, 20] {
        let acting = Acting {
            distortion: 0.25,
            ..Acting::default()
        };
        let case = Case::new(&bounces(count, 1).unwrap(), &acting, 1).one_by_one();
        let mut sketch = case.performance.sketch();
        enact::segment::refine(case.scene(), &mut sketch);
        let posed = Posed::new(case.scene(), &sketch);
        let samples = posed.problem.sample_count();
        assert_eq!(posed.problem.nodes_acted_s.len(), samples);
        per_sample.push(posed.layout.structure.pattern.stored() as f64 / samples as f64);
    }
    assert!(per_sample[1] < 1.2 * per_sample[0], "{per_sample:?}");
}

#[test]
fn an_end_without_an_unknown_of_its_own_is_as_certain_as_dense_algebra_says() {
    for style in Style::ALL {
        let mut truth = style.truth();
        truth.scene.goals.clear();
        let acting = Acting {
            rate_hz: 40.0,
            mark_error_s: 0.0,
            ..Acting::default()
        };
        let case = Case::new(&truth, &acting, 1).one_by_one();
        let outcome = case.estimated(&mut ()).unwrap();
        let posed = Posed::new(case.scene(), &outcome.sketch);
        assert_eq!(posed.layout.events[1], None);
        let uncertainty = Uncertainty::of(&case, &posed, 0.0).unwrap();
        let last = posed.layout.nodes.last().unwrap().unwrap();
        // With the weights for the errors, and with the errors that the residuals show.
        let [stated, exact] = [&uncertainty.library, &uncertainty.exact].map(|of| of[(last, last)]);
        assert!((stated / exact - 1.0).abs() < 0.02, "{stated} {exact}");
        let exact_s = uncertainty.sds[last].expect("it is determined");
        let estimate = &outcome.estimate;
        let sd_s = estimate.events[1].sd_s.expect("it is determined");
        let name = style.as_str();
        assert!(
            (sd_s / exact_s - 1.0).abs() < 0.02,
            "{name}: {sd_s} {exact_s}"
        );
        // No contact bends this time line, and the first sample is its zero.
        assert_eq!(estimate.duration.sd_s, Some(sd_s), "{name}");
        assert!(estimate.duration.is_determined() && estimate.undetermined.is_empty());
    }
}
