//! An estimate as the guess for the next one, from a few samples more.

use crate::motion::{ArcEstimate, ArcGuess, Estimate, Guess, Scene, Segment, Sketch};
use crate::physics::flow;

/// Samples over which the last tempo is read, to go on with.
const TEMPO_SAMPLES: usize = 8;

/// What is estimated already.
pub(super) struct Known<'a> {
    pub(super) segments: &'a [Segment],
    pub(super) estimate: &'a Estimate,
}

/// The known estimate, carried over to a sketch of the same events: samples that it has not seen
/// go on at its last tempo. `None` where the segments are others.
pub(super) fn guess(
    known: &Known,
    scene: &Scene,
    sketch: &Sketch,
    segments: &[Segment],
) -> Option<Guess> {
    let line = TimeLine::new(known, sketch, segments)?;
    let arcs = segments.iter().map(|segment| {
        let arc = known.arc(segment)?;
        let samples = &sketch.bodies[segment.body].samples[segment.samples.clone()];
        let times_s = || samples.iter().map(|sample| line.at(sample.acted_s));
        let middle_s = 0.5 * (samples.first()?.acted_s + samples.last()?.acted_s);
        let epoch_s = line.at(middle_s);
        let body = &scene.bodies[segment.body].body;
        let since_s = epoch_s - (arc.epoch_s + line.shift_s);
        Some(ArcGuess {
            epoch_s,
            state: flow::advance(body, &known.estimate.gravity_m_s2, &arc.state, since_s),
            sample_times_s: times_s().collect(),
        })
    });
    let events = known.estimate.events.iter();
    Some(Guess {
        arcs: arcs.collect::<Option<_>>()?,
        event_times_s: events.map(|event| event.time_s + line.shift_s).collect(),
        parameters: known.estimate.parameters.iter().map(|p| p.value).collect(),
    })
}

impl Known<'_> {
    /// The flight that this segment continues.
    fn arc(&self, segment: &Segment) -> Option<&ArcEstimate> {
        let mut of_body = self.segments.iter().filter(|s| s.body == segment.body);
        // A body's segments are in order of time, as its arcs are.
        let at = of_body.position(|s| {
            (s.start_event, s.end_event) == (segment.start_event, segment.end_event)
        })?;
        let mut arcs = self.estimate.arcs.iter();
        arcs.by_ref().filter(|arc| arc.body == segment.body).nth(at)
    }
}

/// Acted to physical time, linear between samples that have both.
pub(super) struct TimeLine {
    /// Acted, physical \[s\].
    knots: Vec<(f64, f64)>,
    /// Physical per acted time before the first knot and after the last.
    rates: (f64, f64),
    /// From the known estimate's zero of time to the sketch's \[s\].
    shift_s: f64,
}

impl TimeLine {
    pub(super) fn new(known: &Known, sketch: &Sketch, segments: &[Segment]) -> Option<Self> {
        let mut knots: Vec<(f64, f64)> = known
            .estimate
            .sample_times
            .iter()
            .map(|sample| (sample.stamp.seconds_since(sketch.origin), sample.time_s))
            .collect();
        knots.sort_by(|a, b| a.0.total_cmp(&b.0));
        knots.dedup_by_key(|knot| knot.0);
        if knots.len() < 2 {
            return None;
        }
        let ends = knots.len().min(TEMPO_SAMPLES);
        let rate = |part: &[(f64, f64)]| {
            let (first, last) = (part[0], part[part.len() - 1]);
            (last.1 - first.1) / (last.0 - first.0)
        };
        let rates = (rate(&knots[..ends]), rate(&knots[knots.len() - ends..]));
        let mut line = Self {
            knots,
            rates,
            shift_s: 0.0,
        };
        // The first sample that is used has its acted time: a convention of the estimation.
        let firsts = segments.iter().map(|segment| {
            let samples = &sketch.bodies[segment.body].samples;
            samples[segment.samples.start].acted_s
        });
        let first_s = firsts.min_by(f64::total_cmp)?;
        line.shift_s = first_s - line.at(first_s);
        let is_sound = line.rates.0 > 0.0 && line.rates.1 > 0.0 && line.shift_s.is_finite();
        is_sound.then_some(line)
    }

    fn at(&self, acted_s: f64) -> f64 {
        let after = self.knots.partition_point(|knot| knot.0 <= acted_s);
        let from = self.knots[after.saturating_sub(1)];
        let rate = match (after, self.knots.get(after)) {
            (0, _) => self.rates.0,
            (_, None) => self.rates.1,
            (_, Some(next)) => (next.1 - from.1) / (next.0 - from.0),
        };
        self.shift_s + from.1 + (acted_s - from.0) * rate
    }

    /// The acted time of a physical one of the known estimate's.
    pub(super) fn acted_s(&self, time_s: f64) -> f64 {
        let after = self.knots.partition_point(|knot| knot.1 <= time_s);
        let from = self.knots[after.saturating_sub(1)];
        let rate = match (after, self.knots.get(after)) {
            (0, _) => self.rates.0,
            (_, None) => self.rates.1,
            (_, Some(next)) => (next.1 - from.1) / (next.0 - from.0),
        };
        from.0 + (time_s - from.1) / rate
    }
}
