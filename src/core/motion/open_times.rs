//! Samples whose times are not known: the time of each is a free parameter of the scene.

use super::index::TrackIndex;
use super::scene::{FreeParameter, Quantity, Scene, Timing};
use super::sketch::{Segment, Sketch, View};

impl Scene {
    /// The scene with the time of every sample free that is not known: within what is said of it, and
    /// between the times of its neighbours in its flight. Samples that no flight uses have none.
    ///
    /// Where nothing says when a sketch, or a flight on a clock of its own, is at all, its first
    /// sample keeps its stamp: it is the zero of time.
    pub fn with_sample_times(mut self, sketch: &Sketch, segments: &[Segment]) -> Scene {
        let mut free: Vec<FreeParameter> = Vec::new();
        let views = segments.iter().flat_map(|segment| &segment.views);
        for view in views {
            if sketch.tracks[view.track].open_times_s.is_empty() {
                continue;
            }
            let zero = self.zero_of(sketch, segments, view);
            free.extend(view.samples.clone().filter_map(|sample| {
                let is_zero = zero == Some((view.track, sample));
                let bounds = bounds_s(sketch, view, sample).filter(|_| !is_zero)?;
                Some(self.free_time(view.track, sample, bounds))
            }));
        }
        self.parameters.extend(free);
        self
    }

    fn free_time(&self, track: TrackIndex, sample: usize, bounds_s: [f64; 2]) -> FreeParameter {
        let [lower, upper] = bounds_s;
        FreeParameter {
            lower,
            upper,
            ..self.freed(
                Quantity::SampleTime { track, sample },
                0.0f64.clamp(lower, upper),
            )
        }
    }

    /// The sample that is the zero of the clock on which a view is; `None` where something says when
    /// that is: a time, an interval, or the mark of an event.
    fn zero_of(
        &self,
        sketch: &Sketch,
        segments: &[Segment],
        view: &View,
    ) -> Option<(TrackIndex, usize)> {
        let is_edited = self.timing == Timing::Edited;
        if !is_edited && sketch.marks.iter().any(Option::is_some) {
            return None;
        }
        let views = segments.iter().flat_map(|segment| &segment.views);
        let shared = views.filter(|other| !is_edited || *other == view);
        let samples = || {
            let each = |view: &View| {
                let track = view.track;
                view.samples.clone().map(move |sample| (track, sample))
            };
            shared.clone().flat_map(each)
        };
        let is_told = |(track, sample): (TrackIndex, usize)| {
            let range_s = sketch.tracks[track].open_times_s.get(&sample);
            range_s
                .is_none_or(|[earliest_s, latest_s]| earliest_s.is_finite() || latest_s.is_finite())
        };
        if samples().any(is_told) {
            return None;
        }
        let acted_s =
            |(track, sample): &(TrackIndex, usize)| sketch.tracks[*track].samples[*sample].acted_s;
        samples().min_by(|a, b| acted_s(a).total_cmp(&acted_s(b)))
    }
}

/// The least and the greatest that may be added to the time of a sample: by what is said of it, and
/// by what is said of the others of its view; `None` where its time is known.
fn bounds_s(sketch: &Sketch, view: &View, sample: usize) -> Option<[f64; 2]> {
    let of_track = &sketch.tracks[view.track];
    let own = *of_track.open_times_s.get(&sample)?;
    let acted_s = |index: usize| of_track.samples[index].acted_s;
    let range_s = |index: usize| {
        let open = of_track.open_times_s.get(&index);
        let [from_s, to_s] = open.copied().unwrap_or([0.0; 2]);
        [acted_s(index) + from_s, acted_s(index) + to_s]
    };
    let before = (view.samples.start..sample).map(|index| range_s(index)[0] - acted_s(sample));
    let after = (sample + 1..view.samples.end).map(|index| range_s(index)[1] - acted_s(sample));
    let bounds = [before.fold(own[0], f64::max), after.fold(own[1], f64::min)];
    // Intervals in no order leave nothing: the order of times will not be met, and that is told.
    Some(if bounds[0] <= bounds[1] { bounds } else { own })
}
