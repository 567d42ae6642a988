//! The joint answer of takes that are exact quadratics, against what is known of these: sums of normal equations, answers
//! without one take, the analysis of variance, and how often intervals hold.

use nalgebra::{DMatrix, DVector};

use super::{JointParameter, JointSearch, SearchTurn, Standout};
use crate::math::random::Random;
use crate::motion::TakeShare;

/// A take that says `½ (v − own)ᵀ S (v − own)`.
struct Quadratic {
    own: DVector<f64>,
    curvature: DMatrix<f64>,
}

impl Quadratic {
    fn share(&self, values: &DVector<f64>) -> TakeShare {
        let off = values - &self.own;
        let gradient = &self.curvature * &off;
        TakeShare {
            values: values.clone(),
            cost: 0.5 * off.dot(&gradient),
            gradient,
            curvature: self.curvature.clone(),
            residual: [1e-3, 1e-2],
            samples: [50, 50],
        }
    }
}

fn parameter(name: &str, is_drawn: bool) -> JointParameter {
    JointParameter {
        name: name.to_owned(),
        initial: 0.2,
        lower: f64::NEG_INFINITY,
        upper: f64::INFINITY,
        prior_sd: None,
        length: 0.5,
        is_drawn,
    }
}

fn shares(joint: &JointSearch, takes: &[Quadratic]) -> Vec<Option<TakeShare>> {
    let each = takes.iter().enumerate();
    each.map(|(at, take)| Some(take.share(&joint.asked(at))))
        .collect()
}

/// The search's end, with what the takes say there.
fn solved(
    parameters: Vec<JointParameter>,
    takes: &[Quadratic],
) -> (JointSearch, Vec<Option<TakeShare>>) {
    let own: Vec<Option<TakeShare>> = takes.iter().map(|of| Some(of.share(&of.own))).collect();
    let mut joint = JointSearch::new(parameters, &own);
    loop {
        let said = shares(&joint, takes);
        match joint.turn(&said) {
            SearchTurn::Again => {}
            SearchTurn::Found => return (joint, said),
            SearchTurn::Lost => panic!("lost after {} rounds", joint.rounds()),
        }
    }
}

/// Takes of random information whose own values are off the truth as that says, `noise` times as much, and by a spread of the
/// first one.
fn drawn(
    count: usize,
    truth: &[f64; 2],
    spread: f64,
    noise: f64,
    random: &mut Random,
) -> Vec<Quadratic> {
    let each = (0..count).map(|_| {
        let root = DMatrix::from_fn(2, 2, |_, _| random.normal());
        let size = 2500.0 * (0.8 * random.normal()).exp();
        let curvature = (&root * root.transpose() + DMatrix::identity(2, 2)) * size;
        let factor = curvature.clone().cholesky().expect("definite");
        let normal = DVector::from_fn(2, |_, _| noise * random.normal());
        let off = factor.l().transpose().lu().solve(&normal).expect("regular");
        let mut own = DVector::from_row_slice(truth) + off;
        own[0] += spread * random.normal();
        Quadratic { own, curvature }
    });
    each.collect()
}

#[test]
fn the_optimum_is_that_of_the_summed_normal_equations_with_priors_once() {
    let mut random = Random::default();
    let takes = drawn(7, &[0.3, -0.1], 0.1, 1.0, &mut random);
    let mut parameters = vec![parameter("a", false), parameter("b", false)];
    parameters[1].prior_sd = Some(0.01);
    let (joint, _) = solved(parameters, &takes);
    let mut information = DMatrix::from_diagonal(&DVector::from_vec(vec![0.0, 1e4]));
    let mut right = DVector::from_vec(vec![0.0, 1e4 * 0.2]);
    for take in &takes {
        information += &take.curvature;
        right += &take.curvature * &take.own;
    }
    let expected = information.lu().solve(&right).expect("regular");
    assert!((joint.values() - expected).amax() < 1e-12);
    assert!(joint.rounds() < 5, "{} rounds", joint.rounds());
}

#[test]
fn a_bound_holds_the_answer_and_the_others_follow() {
    let mut random = Random::default();
    let takes = drawn(6, &[0.3, -0.1], 0.0, 1.0, &mut random);
    let mut parameters = vec![parameter("a", false), parameter("b", false)];
    parameters[0].upper = 0.25;
    parameters[0].initial = 0.25;
    let (joint, said) = solved(parameters, &takes);
    let values = joint.values();
    assert_eq!(values[0], 0.25);
    let (mut information, mut right) = (0.0, 0.0);
    for take in &takes {
        information += take.curvature[(1, 1)];
        right +=
            take.curvature[(1, 1)] * take.own[1] + take.curvature[(1, 0)] * (take.own[0] - 0.25);
    }
    assert!((values[1] - right / information).abs() < 1e-12);
    let (intervals, _) = joint.intervals(&said);
    assert!(intervals[0].is_at_bound && intervals[0].sd.is_none());
    assert!(intervals[1].sd.is_some());
}

#[test]
fn what_only_a_combination_tells_is_named_and_stays() {
    let along = DVector::from_vec(vec![1.0, 1.0]);
    let take = |own: f64| Quadratic {
        own: DVector::from_vec(vec![own, 0.0]),
        curvature: &along * along.transpose() * 1e4,
    };
    let takes = [take(0.3), take(0.4), take(0.5)];
    let (joint, said) = solved(vec![parameter("a", false), parameter("b", false)], &takes);
    let [weak] = joint.weak() else {
        panic!("{:?}", joint.weak());
    };
    let parts: Vec<usize> = weak.parts.iter().map(|(at, _)| *at).collect();
    assert!(parts.contains(&0) && parts.contains(&1) && weak.sd > 1e3);
    assert!(
        weak.parts[0].1 * weak.parts[1].1 < 0.0,
        "they change against each other"
    );
    let values = joint.values();
    assert!((values[0] + values[1] - 0.4).abs() < 1e-9, "{values}");
    let (intervals, _) = joint.intervals(&said);
    assert!(intervals.iter().all(|of| of.is_weak && of.ends.is_none()));
}

#[test]
fn influence_is_what_leaving_a_take_out_does() {
    let mut random = Random::default();
    let takes = drawn(6, &[0.3, -0.1], 0.05, 1.0, &mut random);
    let two = || vec![parameter("a", false), parameter("b", false)];
    let (joint, said) = solved(two(), &takes);
    let judged = joint.judged(&said, &joint.intervals(&said).0);
    for left_out in 0..takes.len() {
        let others = takes.iter().enumerate().filter(|(at, _)| *at != left_out);
        let others: Vec<Quadratic> = others
            .map(|(_, of)| Quadratic {
                own: of.own.clone(),
                curvature: of.curvature.clone(),
            })
            .collect();
        let (without, _) = solved(two(), &others);
        let change = without.values() - joint.values();
        let told = &judged[left_out].as_ref().expect("takes part").influence;
        assert!(
            (told - &change).amax() < 1e-9 * change.amax().max(1e-3),
            "{told} {change}"
        );
    }
}

#[test]
fn a_take_that_differs_is_named_with_its_parameter() {
    let mut random = Random::default();
    let mut takes = drawn(12, &[0.3, -0.1], 0.0, 1.0, &mut random);
    takes[4].own[1] += 0.7;
    let (joint, said) = solved(vec![parameter("a", false), parameter("b", false)], &takes);
    let judged = joint.judged(&said, &joint.intervals(&said).0);
    for (at, of) in judged.iter().enumerate() {
        let of = of.as_ref().expect("takes part");
        let is_named = of
            .standout
            .iter()
            .any(|why| matches!(why, Standout::Differs { parameter: 1, .. }));
        assert_eq!(is_named, at == 4, "{at}: {of:?}");
    }
}

/// Of takes of the same information the restricted likelihood is that of the analysis of variance.
#[test]
fn the_spread_of_alike_takes_is_that_of_the_analysis_of_variance() {
    let mut random = Random::default();
    let information = 4e4;
    let takes: Vec<Quadratic> = (0..9)
        .map(|_| Quadratic {
            own: DVector::from_vec(vec![0.3 + 0.02 * random.normal()]),
            curvature: DMatrix::from_element(1, 1, information),
        })
        .collect();
    let (joint, said) = solved(vec![parameter("a", true)], &takes);
    let count = takes.len() as f64;
    let mean = takes.iter().map(|of| of.own[0]).sum::<f64>() / count;
    let squares = takes.iter().map(|of| (of.own[0] - mean).powi(2));
    let total = squares.sum::<f64>() / (count - 1.0);
    let expected = (total - 1.0 / information).sqrt();
    let (intervals, _) = joint.intervals(&said);
    let spread = intervals[0].spread.expect("drawn");
    assert!((joint.values()[0] - mean).abs() < 1e-10);
    assert!(
        (spread.sd / expected - 1.0).abs() < 1e-6,
        "{} {expected}",
        spread.sd
    );
    assert!(spread.ends[0] < spread.sd && spread.sd < spread.ends[1]);
    // With takes of equal weight the sandwich is the variance of the mean, with all but one degrees of freedom.
    let sd = (total / count).sqrt();
    let told = intervals[0].sd.expect("told");
    assert!((told / sd - 1.0).abs() < 1e-6, "{told} {sd}");
    assert!((intervals[0].freedom - (count - 1.0)).abs() < 1e-6);
}

/// How often the interval of the first parameter holds its truth, and that of its spread, of so many answers.
fn coverage(
    count: usize,
    spread: f64,
    noise: f64,
    is_drawn: bool,
    random: &mut Random,
) -> [f64; 2] {
    const ANSWERS: usize = 400;
    let (mut held, mut spreads) = (0, 0);
    for _ in 0..ANSWERS {
        let truth = [0.3 + 0.1 * random.normal(), 0.1 * random.normal()];
        let takes = drawn(count, &truth, spread, noise, random);
        let (joint, said) = solved(
            vec![parameter("a", is_drawn), parameter("b", false)],
            &takes,
        );
        let (intervals, _) = joint.intervals(&said);
        let ends = intervals[0].ends.expect("an interval");
        held += usize::from(ends[0] <= truth[0] && truth[0] <= ends[1]);
        let told = intervals[0].spread.map_or([0.0; 2], |of| of.ends);
        spreads += usize::from(told[0] <= spread && spread <= told[1]);
    }
    [held, spreads].map(|of| of as f64 / ANSWERS as f64)
}

#[test]
fn intervals_hold_with_and_without_a_spread_whatever_the_noise_is_said_to_be() {
    let mut random = Random::default();
    for count in [6, 12, 30] {
        for spread in [0.0, 0.05] {
            for noise in [0.4, 1.0, 2.5] {
                let [held, _] = coverage(count, spread, noise, false, &mut random);
                let case = format!("{count} takes, spread {spread}, noise {noise}: {held}");
                assert!((0.905..=0.985).contains(&held), "{case}");
            }
        }
    }
}

#[test]
fn intervals_of_what_is_drawn_hold_and_so_do_those_of_its_spread() {
    let mut random = Random::default();
    for count in [8, 20] {
        let [held, spreads] = coverage(count, 0.05, 1.0, true, &mut random);
        assert!(
            (0.905..=0.985).contains(&held),
            "{count} takes: mean {held}"
        );
        assert!(
            (0.89..=0.985).contains(&spreads),
            "{count} takes: spread {spreads}"
        );
    }
}
