//! Starts from keyframes: of a few poses per flight, whole motions through all of them.
//!
//! Two poses of a flight say where its centre of mass flies, but not how many turns the body makes
//! between them; one pose says neither. What happens at the collisions decides: a flight arrives
//! with its feature on the surface, in the pose in which the next one begins, and leaves with the
//! velocities of the impact. So flights are followed one after the other ([`follow`]): every turn of
//! a flight that its own poses allow ([`turns`]) is a way to go on, and the ways that join best are
//! kept. The first flight of a single pose is found by shooting ([`shoot`]).

mod flown;
mod follow;
mod shoot;
mod turns;

use self::flown::keys;
use self::follow::{KeyedCourse, Way};
use crate::motion::{ArcGuess, Guess, Observer, Quantity, Scene, Segment, Sketch};
use crate::physics::State;

/// Whether the flights of a sketch start from keyframes: few poses of every flight, of the first of
/// each body at least one that is whole.
pub(super) fn applies(scene: &Scene, sketch: &Sketch, segments: &[Segment]) -> bool {
    let begins = |index: usize| {
        let mut before = segments[..index].iter();
        before.all(|other| other.mechanism != segments[index].mechanism)
    };
    let is_enough = |(index, segment): (usize, &Segment)| {
        keys(sketch, segment).is_some_and(|keys| !(keys.is_empty() && begins(index)))
    };
    scene.is_keyframed(sketch) && segments.iter().enumerate().all(is_enough)
}

/// The best motions through the keyframes, as guesses, no more than `most`; none where no motion
/// was found for some body.
pub(super) fn guesses(
    scene: &Scene,
    sketch: &Sketch,
    segments: &[Segment],
    most: usize,
    observer: &mut dyn Observer,
) -> Vec<Guess> {
    let mut of_all: Vec<(Vec<usize>, Vec<Way>)> = Vec::new();
    for mechanism in scene.mechanisms.keys().filter(|of| !scene.is_apart(*of)) {
        let own: Vec<usize> = (0..segments.len())
            .filter(|index| segments[*index].mechanism == mechanism)
            .collect();
        let course = KeyedCourse::new(scene, sketch, mechanism, &own, segments);
        // The first flight of a single pose is found by shooting at what it hits, where all impacts
        // are known.
        let is_aimed = course.samples.len() > 1 && course.is_known();
        let mut ways = Vec::new();
        if course.samples[0].len() == 1 && is_aimed {
            ways = shoot::ways(&course, most, observer);
        }
        if ways.is_empty() {
            ways = course.ways(most, observer);
        }
        if ways.is_empty() {
            return Vec::new();
        }
        of_all.push((own, ways));
    }
    let count = of_all.iter().map(|(_, ways)| ways.len()).max().unwrap_or(0);
    (0..count)
        .map(|rank| {
            let chosen = of_all
                .iter()
                .map(|(own, ways)| (own.as_slice(), &ways[rank.min(ways.len() - 1)]));
            guess(scene, sketch, segments, chosen)
        })
        .collect()
}

/// A guess of all mechanisms, each with its flights and a way through them.
fn guess<'w>(
    scene: &Scene,
    sketch: &Sketch,
    segments: &[Segment],
    chosen: impl Iterator<Item = (&'w [usize], &'w Way)>,
) -> Guess {
    let mut guess = Guess {
        arcs: segments
            .iter()
            .map(|segment| ArcGuess {
                epoch_s: 0.0,
                state: State::at_rest(),
                sample_times_s: sketch.samples_in(segment).map(|of| of.acted_s).collect(),
            })
            .collect(),
        event_times_s: sketch.marks_s.clone(),
        parameters: scene.parameters.iter().map(|free| free.initial).collect(),
    };
    for (own, way) in chosen {
        for (flight, (index, flown)) in own.iter().zip(&way.flights).enumerate() {
            let offset_s = way.offsets_s[flight];
            let arc = &mut guess.arcs[*index];
            (arc.epoch_s, arc.state) = (flown.epoch_s + offset_s, flown.state);
            let track = segments[*index].views[0].track;
            let clock = Quantity::FlightClock { track, flight };
            if let Some(clock) = scene.parameter_of(clock) {
                guess.parameters[clock] = offset_s;
            }
            if let (Some(event), Some(time_s)) =
                (segments[*index].end_event, way.ends_s.get(flight))
            {
                guess.event_times_s[event] = *time_s;
            }
        }
    }
    guess
}
