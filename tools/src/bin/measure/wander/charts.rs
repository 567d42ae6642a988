//! Errors along a motion, and beside the least that any unbiased estimate can have.

use enact::motion::{Performer, Verdict};
use enact::pipeline::Outcome;
use enact_tools::case::{Case, Posed};
use enact_tools::dense;
use enact_tools::perform::Acting;
use serde::Serialize;

use super::{PERFORMANCES, Performed, Stamps, WEIGHED};
use crate::figure::{Axis, Curve, Figure, Mark};
use crate::options::Options;
use crate::record::Record;
use crate::statistics::{median, rms};

/// Instants of a flight.
const INSTANTS: usize = 11;
/// Sizes of hands, the usual one being 1.
const SIZES: [f64; 5] = [0.03, 0.1, 0.3, 1.0, 3.0];

/// What is drawn of a chart's points.
#[derive(Default, Serialize)]
struct Drawn {
    weighed: &'static str,
    points: Vec<[f64; 2]>,
}

/// Draws both.
pub(super) fn run(options: &Options, record: &mut Record) -> anyhow::Result<()> {
    let along = along(options);
    let efficiency = efficiency(options);
    record.figure(figure_along(&along));
    record.figure(figure_of_efficiency(&efficiency));
    record.numbers("charts", &(along, efficiency))
}

/// Answers to performances of a motion by a hand of a size in real time, samples weighed so, that are physical.
fn answers(
    performed: Performed,
    size: f64,
    performer: Performer,
    options: &Options,
) -> Vec<(Case, Outcome)> {
    let acting = |seed: u64| Stamps::Physical.acting(Some([size, 1.0]), seed);
    let cases = options
        .seeds(PERFORMANCES)
        .filter_map(|seed| performed.case(&acting(seed), seed));
    let answered = cases.filter_map(|mut case| {
        case.performance.truth.scene.performer = performer;
        let outcome = case.pipeline().finish(&mut ()).ok()?;
        (outcome.estimate.verdict == Verdict::Physical).then_some((case, outcome))
    });
    answered.collect()
}

/// Median errors of the velocity along the flights of a cube that bounces four times [mm/s].
fn along(options: &Options) -> Vec<Drawn> {
    let drawn = WEIGHED.map(|(weighed, performer)| {
        let answers = answers(Performed::Cube(4), 1.0, performer, options);
        let mut points = Vec::new();
        for flight in 0..5 {
            for instant in 0..INSTANTS {
                let share = instant as f64 / (INSTANTS - 1) as f64;
                let off = answers.iter().map(|(case, outcome)| {
                    let (scene, estimate) = (&outcome.scene, &outcome.estimate);
                    let posed = Posed::new(case.scene(), &outcome.sketch);
                    let offset_s = case.offset_s(&posed, &outcome.sketch);
                    let arc = &estimate.arcs[flight];
                    let time_s = arc.start_s + share * (arc.end_s - arc.start_s);
                    let found = scene.flown(arc, &estimate.gravity_m_s2, time_s);
                    let truth = case.true_state(flight, time_s, offset_s);
                    1e3 * (found.velocity_m_s - truth.velocity_m_s).norm()
                });
                points.push([flight as f64 + share, median(&off.collect::<Vec<_>>())]);
            }
        }
        Drawn { weighed, points }
    });
    drawn.into()
}

fn figure_along(drawn: &[Drawn]) -> Figure {
    Figure {
        name: "wander_along".to_owned(),
        title: "Error of the velocity along a cube's five flights: as a process slow errors of the hand are not followed"
            .to_owned(),
        note: format!(
            "A usual hand in real time, physical stamps; medians of {PERFORMANCES} performances. Flights are \
             drawn equally long, impacts are at 1 to 4."
        ),
        x: Axis::linear("flight"),
        y: Axis::logarithmic("velocity [mm/s]"),
        curves: curves(drawn),
    }
}

/// Root mean square errors of a pencil's bounce over the least that an unbiased estimate can have which knows how the hand errs,
/// by the hand's size.
fn efficiency(options: &Options) -> Vec<Drawn> {
    let drawn = WEIGHED.map(|(weighed, performer)| {
        let points = SIZES.map(|size| {
            let (mut off_s, mut bounds_s) = (Vec::new(), Vec::new());
            for (case, outcome) in answers(Performed::Pencil, size, performer, options) {
                let posed = Posed::new(case.scene(), &outcome.sketch);
                let acting: Acting = Stamps::Physical.acting(Some([size, 1.0]), 0);
                let bound = dense::bound_of_hand(&case, &posed, &outcome.sketch, &acting);
                let first = posed.layout.events.iter().position(Option::is_some);
                let Some((bound, event)) = bound.zip(first) else {
                    continue;
                };
                let at = posed.layout.events[event].expect("just found");
                let offset_s = case.offset_s(&posed, &outcome.sketch);
                let true_s = case.performance.truth.event_times_s[event] + offset_s;
                off_s.push(outcome.estimate.events[event].time_s - true_s);
                bounds_s.push(bound[(at, at)].sqrt());
            }
            [size, rms(&off_s) / rms(&bounds_s)]
        });
        Drawn {
            weighed,
            points: points.into(),
        }
    });
    drawn.into()
}

fn figure_of_efficiency(drawn: &[Drawn]) -> Figure {
    let mut curves = curves(drawn);
    let ends = [SIZES[0], SIZES[SIZES.len() - 1]].map(|size| Mark::at(size, 1.0));
    curves.push(Curve::bound("Cramér–Rao bound", ends.into()));
    Figure {
        name: "wander_efficiency".to_owned(),
        title: "Error of a pencil's bounce over the bound that the hand's true covariance sets: 1 is as good as can be"
            .to_owned(),
        note: format!(
            "Physical stamps, a hand in real time; root mean squares of {PERFORMANCES} performances a point. The \
             bound knows how the hand errs; the program tells it from the residuals."
        ),
        x: Axis::logarithmic("wander, in units of 2 cm and 8°"),
        y: Axis::logarithmic("rms error over its bound"),
        curves,
    }
}

fn curves(drawn: &[Drawn]) -> Vec<Curve> {
    let curves = drawn.iter().map(|of| {
        let points = of.points.iter().map(|[x, y]| Mark::at(*x, *y)).collect();
        match of.weighed == WEIGHED[1].0 {
            true => Curve::ours(of.weighed, points),
            false => Curve::new(of.weighed, points),
        }
    });
    curves.collect()
}
