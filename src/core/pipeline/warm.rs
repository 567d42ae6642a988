//! An estimate as the guess for the next one, which has a few more samples.

use crate::motion::{ArcEstimate, ArcGuess, Estimate, Guess, Scene, Segment, Sketch, TimeMap};
use crate::physics::flow;

/// An existing estimate.
pub(super) struct Known<'a> {
    pub(super) segments: &'a [Segment],
    pub(super) estimate: &'a Estimate,
}

/// The known estimate as a guess for a sketch of the same events: new samples continue at its last
/// tempo. `None` where the segments differ.
pub(super) fn guess(
    known: &Known,
    scene: &Scene,
    sketch: &Sketch,
    segments: &[Segment],
) -> Option<Guess> {
    let map = TimeMap::new(&known.estimate.sample_times, sketch.origin)?;
    // Convention of the estimation: the first sample used has its acted time as physical time.
    let firsts = segments.iter();
    let firsts = firsts.filter_map(|segment| Some(sketch.span_s(segment)?[0]));
    let first_s = firsts.min_by(f64::total_cmp)?;
    let shift_s = first_s - map.physical_s(first_s);
    let arcs = segments.iter().map(|segment| {
        let arc = known.arc(segment)?;
        let samples = sketch.samples_in(segment);
        let times_s = samples.map(|sample| shift_s + map.physical_s(sample.acted_s));
        let epoch_s = match sketch.span_s(segment) {
            Some([first_s, last_s]) => shift_s + map.physical_s(0.5 * (first_s + last_s)),
            None => shift_s + 0.5 * (arc.start_s + arc.end_s),
        };
        let body = &scene.body_between(segment.mechanism, segment.ends());
        let since_s = epoch_s - (arc.epoch_s + shift_s);
        Some(ArcGuess {
            epoch_s,
            state: flow::advance(body, &known.estimate.gravity_m_s2, &arc.state, since_s),
            sample_times_s: times_s.collect(),
        })
    });
    let events = known.estimate.events.iter();
    Some(Guess {
        arcs: arcs.collect::<Option<_>>()?,
        event_times_s: events.map(|event| event.time_s + shift_s).collect(),
        parameters: known.estimate.parameters.iter().map(|p| p.value).collect(),
    })
}

impl Known<'_> {
    /// The flight that this segment continues.
    fn arc(&self, segment: &Segment) -> Option<&ArcEstimate> {
        let mut of_it = self
            .segments
            .iter()
            .filter(|s| s.mechanism == segment.mechanism);
        // A mechanism's segments are in order of time, as its arcs are.
        let at = of_it.position(|s| {
            (s.start_event, s.end_event) == (segment.start_event, segment.end_event)
        })?;
        let mut arcs = self.estimate.arcs.iter();
        arcs.by_ref()
            .filter(|arc| arc.mechanism == segment.mechanism)
            .nth(at)
    }
}
