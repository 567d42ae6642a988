//! Fits all segments and places the fits on one time line (paper §6.2.1).

use std::borrow::Cow;

use super::ballistic::{self, Place};
use super::between::{self, FITTED_MIN, is_fitted};
use super::clock;
use super::fit::ArcFit;
use super::readings::Readings;
use super::turn::{self, OrientationReading};
use super::{
    aliased, carried, crossing, keyed, open_times, pointing, released, roll, swing, tied, unseen,
};
use crate::motion::{Guess, Observer, Quantity, Scene, Segment, Sketch, SupportedBy, Timing};
use crate::physics::State;
use crate::physics::support::StuckPart;

/// Greatest number of choices of fits.
const GUESSES_MAX: usize = 5;

/// Greatest number of choices of which those are taken that go together.
const COMPARED_MAX: usize = 64;

/// Root mean square angle \[rad\] above which the fit of a rotation may be ambiguous: below it, no
/// measured performance had two minima.
const AMBIGUOUS_RMS_RAD: f64 = 0.35;

/// Rate of physical against acted time where no segment determines it: a typical one.
const RATE_OTHERWISE: f64 = 0.4;

/// Guesses and the iterations they took.
#[derive(Clone, Debug)]
pub struct Guessed {
    /// The best first, at least one; more than one only where orientations fit in several ways or are
    /// not seen.
    pub guesses: Vec<Guess>,
    /// Iterations of all fits together.
    pub fit_iterations: usize,
}

/// Fits every segment by itself and places the fits on one time line: where the tempo is unknown,
/// time between two marks runs at the mean rate of the fits there, or of all. Segments with too few
/// samples for a fit follow from their neighbours.
pub fn guess(
    scene: &Scene,
    sketch: &Sketch,
    segments: &[Segment],
    observer: &mut dyn Observer,
) -> Guessed {
    if keyed::applies(scene, sketch, segments) {
        let mut guesses = keyed::guesses(scene, sketch, segments, GUESSES_MAX, observer);
        for guess in &mut guesses {
            open_times::place(scene, sketch, segments, guess);
        }
        if !guesses.is_empty() {
            return Guessed {
                guesses,
                fit_iterations: 0,
            };
        }
    }
    let known = match scene.timing {
        Timing::Known | Timing::Edited => Some(1.0),
        Timing::Unknown { .. } => None,
    };
    let evened = known
        .is_none()
        .then(|| clock::even(scene, sketch, segments));
    let sketch = evened.as_ref().unwrap_or(sketch);
    let readings = segments
        .iter()
        .map(|segment| Readings::of(scene, sketch, segment));
    let readings: Vec<Readings> = readings.collect();
    let middle_s = |segment: &Segment| match sketch.span_s(segment) {
        Some([first_s, last_s]) if is_fitted(segment) => 0.5 * (first_s + last_s),
        _ => between_marks_s(sketch, segment),
    };
    let rates = rates(scene, segments, &readings, &middle_s, known);
    let time_line = GuessedTimes::new(scene, sketch, segments, &rates);
    let parameters = scene.parameters.iter().map(|free| free.initial);
    let mut parameters: Vec<f64> = parameters.collect();
    for (event, contact_s) in &sketch.contacts_s {
        let free = scene.parameter_of(Quantity::ContactDuration { event: *event });
        if let Some(free) = free {
            let of = &scene.parameters[free];
            parameters[free] = contact_s.clamp(of.lower, of.upper);
        }
    }
    let mut fit_iterations = 0;
    let mut fits: Vec<Vec<ArcFit>> = Vec::new();
    let mut arcs = Vec::new();
    let parts = segments.iter().map(|segment| {
        let support = scene
            .body_between(segment.mechanism, segment.ends())
            .support();
        support.and_then(|support| support.stuck())
    });
    let parts: Vec<Option<StuckPart>> = parts.collect();
    for (((segment, readings), rate), part) in
        segments.iter().zip(&readings).zip(&rates).zip(&parts)
    {
        let middle_s = middle_s(segment);
        let epoch_s = time_line.at(middle_s);
        let samples = sketch.samples_in(segment);
        let times_s = samples.map(|sample| time_line.at(sample.acted_s));
        arcs.push(between::open(epoch_s, times_s.collect()));
        if !is_fitted(segment) {
            continue;
        }
        // What is stuck to another body flies as both together do.
        let readings = &part.map_or(Cow::Borrowed(readings), |part| {
            Cow::Owned(readings.of_whole(&part))
        });
        let whole = part.map(|part| part.whole());
        let body = whole.as_ref().unwrap_or(scene.body_of(segment.mechanism));
        let mut pull_m_s2 = body.pull_m_s2(&scene.gravity_m_s2);
        let phase = scene.phase_between(segment.mechanism, segment.ends());
        let phase = phase.filter(|_| part.is_none());
        if phase.is_some() {
            // On a surface friction decides.
            pull_m_s2 = ballistic::acceleration_m_s2(&readings.places, middle_s) / (rate * rate);
        }
        let mut state = State::at_rest();
        if !readings.places.is_empty() {
            let flight = ballistic::fit(&readings.places, middle_s, &pull_m_s2, Some(*rate));
            state.position_m = flight.position_m;
            state.velocity_m_s = flight.acted_velocity_m_s / *rate;
        }
        if let Some(SupportedBy::Pivot(at)) = phase.map(|phase| &phase.by) {
            let since = |acted_s: &f64| time_line.at(*acted_s) - epoch_s;
            let turns = match &readings.lever_m {
                Some(point_m) => {
                    let places = readings.places.iter();
                    let places: Vec<Place> =
                        places.map(|(s, place_m)| (since(s), *place_m)).collect();
                    tied::turns(at, point_m, &places)
                }
                None => {
                    let turns = readings.turns.iter();
                    turns
                        .map(|(acted_s, turn)| (since(acted_s), *turn))
                        .collect()
                }
            };
            let found = tied::state(at, &turns, &state).unwrap_or(state);
            fits.push(vec![ArcFit::of(found, 0.0)]);
            continue;
        }
        if let Some(lever_m) = &readings.lever_m {
            let since = |(acted_s, place_m): &Place| (time_line.at(*acted_s) - epoch_s, *place_m);
            let places: Vec<Place> = readings.places.iter().map(since).collect();
            fits.push(swing::fits(&places, lever_m, &pull_m_s2, &state));
            continue;
        }
        if readings.turns.is_empty() {
            fits.push(vec![ArcFit::of(state, 0.0)]);
            continue;
        }
        let turns = readings.turns.iter();
        let turns = turns.map(|(acted_s, turn)| (time_line.at(*acted_s) - epoch_s, *turn));
        let turns: Vec<OrientationReading> = turns.collect();
        if let Some((phase, turn)) = phase.zip(carried::turn(&turns)) {
            let state = State {
                orientation: turn.orientation,
                angular_velocity_rad_s: turn.angular_velocity_rad_s,
                ..state
            };
            fits.push(vec![ArcFit::of(state, 0.0)]);
            let law = phase.friction_law();
            let free = law.and_then(|law| scene.parameter_of(Quantity::Friction { law }));
            let body = scene.body_between(segment.mechanism, segment.ends());
            let pull_m_s2 = body.pull_m_s2(&scene.gravity_m_s2);
            let told = carried::friction(&body, &pull_m_s2, &turn, &state.velocity_m_s);
            if let Some((free, told)) = free.zip(told).filter(|_| known.is_some()) {
                let of = &scene.parameters[free];
                parameters[free] = told.clamp(of.lower, of.upper);
            }
            continue;
        }
        let turn = turn::fit(body, &turns);
        fit_iterations += turn.iterations;
        let count = turns.len() as f64;
        let mut all = vec![turn];
        if let Some((axis, shown)) = &readings.pointed {
            let since = |(acted_s, way): &Place| (time_line.at(*acted_s) - epoch_s, *way);
            let shown: Vec<Place> = shown.iter().map(since).collect();
            let (found, iterations) = pointing::fits(body, axis, &shown, turn);
            fit_iterations += iterations;
            all = found;
        } else if !observer.should_stop()
            && turn.square_rad2 > count * AMBIGUOUS_RMS_RAD * AMBIGUOUS_RMS_RAD
        {
            let (others, iterations) = turn::alternatives(body, &turns, turn, observer);
            fit_iterations += iterations;
            all = others;
        }
        let turned = all.iter().map(|turn| {
            let state = State {
                orientation: turn.orientation,
                angular_velocity_rad_s: turn.angular_velocity_rad_s,
                ..state
            };
            ArcFit::of(state, turn.square_rad2)
        });
        fits.push(turned.collect());
    }
    let fitted = parts.iter().zip(segments).filter(|(_, of)| is_fitted(of));
    for ((part, _), fits) in fitted.zip(&mut fits) {
        if let Some(part) = part {
            fits.iter_mut()
                .for_each(|fit| fit.state = part.of_body(&fit.state));
        }
    }
    let marks_s = sketch.marks_s.iter();
    let guess = Guess {
        arcs,
        event_times_s: marks_s.map(|mark_s| time_line.at(*mark_s)).collect(),
        parameters,
    };
    let is_pointed = readings.iter().any(|of| of.pointed.is_some());
    let most = if is_pointed {
        COMPARED_MAX
    } else {
        GUESSES_MAX
    };
    let fitted = combine(segments, &guess, &fits, most);
    let rolled = roll::guesses(scene, segments, &readings, fitted).into_iter();
    let filled = rolled.flat_map(|guess| unseen::guesses(scene, segments, &readings, guess));
    let mut guesses: Vec<Guess> = filled.collect();
    if known.is_some() {
        for guess in &mut guesses {
            crossing::place(scene, sketch, segments, guess);
        }
        let turned = guesses.into_iter();
        let turned = turned.flat_map(|guess| aliased::guesses(scene, segments, &readings, guess));
        guesses = turned.collect();
    }
    for guess in &mut guesses {
        released::place(scene, sketch, segments, &rates, guess);
        between::fill(scene, segments, &guess.event_times_s, &mut guess.arcs);
        open_times::place(scene, sketch, segments, guess);
    }
    Guessed {
        guesses,
        fit_iterations,
    }
}

/// The middle between the marks of a segment that a collision begins.
fn between_marks_s(sketch: &Sketch, segment: &Segment) -> f64 {
    let mark_s = |event: Option<usize>| event.map(|event| sketch.marks_s[event]);
    let start_s = mark_s(segment.start_event).expect("the others have samples");
    0.5 * (start_s + mark_s(segment.end_event).unwrap_or(start_s))
}

/// The guess with every choice of the fitted flights' fits, those with the least sum of squares
/// first.
fn combine(segments: &[Segment], guess: &Guess, fits: &[Vec<ArcFit>], most: usize) -> Vec<Guess> {
    let mut choices: Vec<(f64, Vec<ArcFit>)> = vec![(0.0, Vec::new())];
    for fits in fits {
        choices = choices
            .iter()
            .flat_map(|(square, chosen)| {
                fits.iter().map(move |fit| {
                    let chosen: Vec<ArcFit> = chosen.iter().copied().chain([*fit]).collect();
                    (square + fit.square_rad2, chosen)
                })
            })
            .collect();
        choices.sort_by(|a, b| a.0.total_cmp(&b.0));
        choices.truncate(most);
    }
    choices
        .into_iter()
        .map(|(_, chosen)| {
            let mut guess = guess.clone();
            let arcs = guess.arcs.iter_mut().zip(segments);
            let fitted = arcs.filter(|(_, segment)| is_fitted(segment));
            for ((arc, _), fit) in fitted.zip(chosen) {
                arc.state = fit.state;
            }
            guess
        })
        .collect()
}

/// Rate of each segment; where a fit gives none, the median of the others.
fn rates(
    scene: &Scene,
    segments: &[Segment],
    readings: &[Readings],
    middle_s: &impl Fn(&Segment) -> f64,
    known: Option<f64>,
) -> Vec<f64> {
    let found: Vec<Option<f64>> = segments
        .iter()
        .zip(readings)
        .map(|(segment, readings)| {
            known.or_else(|| {
                // How fast friction stops what a surface carries is not known, nor so the tempo by it.
                let phase = scene.phase_between(segment.mechanism, segment.ends());
                if phase.is_some() {
                    return None;
                }
                let body = scene.body_of(segment.mechanism);
                let pull_m_s2 = body.pull_m_s2(&scene.gravity_m_s2);
                let places = &readings.places;
                let fit = || ballistic::fit(places, middle_s(segment), &pull_m_s2, None);
                (places.len() >= FITTED_MIN).then(fit)?.rate
            })
        })
        .collect();
    let mut sorted: Vec<f64> = found.iter().flatten().copied().collect();
    sorted.sort_by(f64::total_cmp);
    let median = sorted
        .get(sorted.len() / 2)
        .copied()
        .unwrap_or(RATE_OTHERWISE);
    // A performer's tempo does not change by more than this from one flight to the next.
    found
        .iter()
        .map(|rate| rate.unwrap_or(median).clamp(median / 3.0, median * 3.0))
        .collect()
}

/// Acted to physical time, linear between breaks.
struct GuessedTimes {
    acted_s: Vec<f64>,
    physical_s: Vec<f64>,
    rate_before: f64,
    rate_after: f64,
}

impl GuessedTimes {
    /// Breaks at the marks of collisions; between them the mean rate of the segments there.
    fn new(scene: &Scene, sketch: &Sketch, segments: &[Segment], rates: &[f64]) -> Self {
        let fitted = || {
            let with_rates = segments.iter().zip(rates);
            with_rates.filter(|(segment, _)| is_fitted(segment))
        };
        let span_s =
            |segment: &Segment| sketch.span_s(segment).expect("samples of a fitted flight");
        if fitted().next().is_none() {
            // Nothing is seen of what flies: it goes on from a hand.
            let rate = rates.first().copied().unwrap_or(1.0);
            return Self {
                acted_s: vec![0.0],
                physical_s: vec![0.0],
                rate_before: rate,
                rate_after: rate,
            };
        }
        let first_s = fitted()
            .map(|(segment, _)| span_s(segment)[0])
            .fold(f64::INFINITY, f64::min);
        let mut acted_s = vec![first_s];
        acted_s.extend((0..scene.events.len()).filter_map(|event| {
            let is_collision = scene.events[event].kind.collision().is_some();
            is_collision.then_some(sketch.marks_s[event])
        }));
        let logs = fitted().map(|(_, rate)| rate.ln());
        let mean_rate = (logs.sum::<f64>() / fitted().count() as f64).exp();
        let rate_in = |from_s: f64, to_s: f64| {
            let (mut sum, mut weight) = (0.0, 0.0);
            for (segment, rate) in fitted() {
                let [begin_s, end_s] = span_s(segment);
                let overlap_s = end_s.min(to_s) - begin_s.max(from_s);
                if overlap_s > 0.0 {
                    sum += overlap_s * rate.ln();
                    weight += overlap_s;
                }
            }
            if weight > 0.0 {
                (sum / weight).exp()
            } else {
                mean_rate
            }
        };
        let mut physical_s = vec![first_s];
        for pair in acted_s.windows(2) {
            let last_s = physical_s[physical_s.len() - 1];
            physical_s.push(last_s + (pair[1] - pair[0]) * rate_in(pair[0], pair[1]));
        }
        Self {
            rate_before: rate_in(f64::NEG_INFINITY, *acted_s.get(1).unwrap_or(&f64::INFINITY)),
            rate_after: rate_in(acted_s[acted_s.len() - 1], f64::INFINITY),
            acted_s,
            physical_s,
        }
    }

    fn at(&self, acted_s: f64) -> f64 {
        let after = self.acted_s.partition_point(|a| *a <= acted_s);
        if after == 0 {
            return self.physical_s[0] + (acted_s - self.acted_s[0]) * self.rate_before;
        }
        let (from, start_s) = (self.acted_s[after - 1], self.physical_s[after - 1]);
        let rate = self.acted_s.get(after).map_or(self.rate_after, |next| {
            (self.physical_s[after] - start_s) / (next - from)
        });
        start_s + (acted_s - from) * rate
    }
}
