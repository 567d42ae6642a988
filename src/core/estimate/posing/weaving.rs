//! Samples that err in time: which err together, and which are left out.
//!
//! A hand does not feel an impact, so that its errors go on through it. Near an impact it rounds the motion's kink, which is
//! no error of the process: samples there are left out.

use nalgebra::{Matrix3, Vector3};

use super::gravity;
use crate::estimate::problem::influence::Acting;
use crate::estimate::problem::weave::{Weave, WovenArc, WovenSample, WovenTrack};
use crate::estimate::problem::{Arc, Problem};
use crate::estimate::wander::{Filter, Process};

/// Samples are left out so near to an impact \[s\],
const KINK_S: f64 = 0.04;
/// but no more of a flight at either end than this share.
const KINK_SHARE: f64 = 0.1;
/// What is left of an influence that is forgotten.
const FORGOTTEN: f64 = 1e-9;

impl Problem {
    /// The same problem where samples err in time; those near impacts, which are at the
    /// events' times \[s\], are left out.
    pub fn woven(&self, processes: [Process; 2], event_times_s: &[f64]) -> Self {
        let mut tracks: Vec<WovenTrack> = Vec::new();
        for (index, arc) in self.arcs.iter().enumerate() {
            let counted_s = self.counted_s(arc, event_times_s);
            for (view, of) in arc.views.iter().enumerate() {
                let at = match tracks.iter().position(|track| track.track == of.track) {
                    Some(at) => at,
                    None => {
                        tracks.push(WovenTrack {
                            track: of.track,
                            arcs: Vec::new(),
                            parameters: Vec::new(),
                        });
                        tracks.len() - 1
                    }
                };
                let track = &mut tracks[at];
                if track.arcs.last().is_none_or(|last| last.arc != index) {
                    track.arcs.push(WovenArc {
                        arc: index,
                        acting: Vec::new(),
                        samples: Vec::new(),
                        remembered: 0,
                    });
                }
                let woven = track.arcs.last_mut().expect("just added");
                let samples = (0..of.samples.len()).map(|sample| WovenSample {
                    view,
                    sample,
                    acted_s: of.samples[sample].time_s(&self.nodes_acted_s),
                });
                let is_counted =
                    |of: &WovenSample| (counted_s[0]..=counted_s[1]).contains(&of.acted_s);
                woven.samples.extend(samples.filter(is_counted));
            }
        }
        for track in &mut tracks {
            for woven in &mut track.arcs {
                woven
                    .samples
                    .sort_by(|a, b| a.acted_s.total_cmp(&b.acted_s));
            }
            let remembered = remembered(track, &processes);
            for (woven, remembered) in track.arcs.iter_mut().zip(remembered) {
                woven.remembered = remembered;
            }
        }
        self.woven_as(&Weave { processes, tracks })
    }

    /// The same problem where the samples err as those of another one that differs in its parameters alone.
    pub fn woven_as(&self, other: &Weave) -> Self {
        let mut weave = other.clone();
        for track in &mut weave.tracks {
            track.parameters.clear();
            for woven in &mut track.arcs {
                woven.acting = self.acting_on(&self.arcs[woven.arc]);
                let parameters = woven.acting.iter().map(|acting| acting.parameter);
                track.parameters.extend(parameters);
            }
            track.parameters.sort_unstable();
            track.parameters.dedup();
        }
        Self {
            weave: Some(weave),
            ..self.clone()
        }
    }

    /// Between which acted times samples of a flight count \[s\].
    fn counted_s(&self, arc: &Arc, event_times_s: &[f64]) -> [f64; 2] {
        let time_s = |event: Option<usize>| event.map(|event| event_times_s[event]);
        let (start_s, end_s) = (time_s(arc.start), time_s(arc.end));
        let length_s = match (start_s, end_s) {
            (Some(start_s), Some(end_s)) => end_s - start_s,
            _ => f64::INFINITY,
        };
        let kink_s = KINK_S.min(KINK_SHARE * length_s);
        let is_kink = |event: Option<usize>| {
            let mut collisions = self.collisions.iter();
            event.is_some() && collisions.any(|of| Some(of.event) == event)
        };
        let from_s = start_s.filter(|_| is_kink(arc.start));
        let to_s = end_s.filter(|_| is_kink(arc.end));
        [
            from_s.map_or(f64::NEG_INFINITY, |from_s| from_s + kink_s),
            to_s.map_or(f64::INFINITY, |to_s| to_s - kink_s),
        ]
    }

    /// Parameters that act on a flight, with free gravity where it is a plain parabola, too.
    fn acting_on(&self, arc: &Arc) -> Vec<Acting> {
        if !arc.acting.is_empty() {
            return arc.acting.clone();
        }
        gravity(&self.gravity_parameters).collect()
    }
}

/// For every flight of a track the number of flights before it whose residuals still tell of its errors.
fn remembered(track: &WovenTrack, processes: &[Process; 2]) -> Vec<usize> {
    let mut counts = vec![0; track.arcs.len()];
    for process in processes {
        let mut filter = Filter::new(process);
        let scale = process.stationary().map_diagonal(f64::sqrt);
        let unscale = scale.map(|of| of.max(f64::MIN_POSITIVE).recip());
        // Of each flight before, by its place: what its end has become.
        let mut before: Vec<(usize, Matrix3<f64>)> = Vec::new();
        for (place, arc) in track.arcs.iter().enumerate() {
            for sample in &arc.samples {
                let gain = filter.next(sample.acted_s);
                for (first, left) in &mut before {
                    counts[place] = counts[place].max(place - *first);
                    *left = gain.forgets() * *left;
                }
                before.retain(|(_, left)| relative(left, &scale, &unscale) > FORGOTTEN);
            }
            before.push((place, Matrix3::identity()));
        }
    }
    counts
}

/// The greatest entry of a matrix, in standard deviations of the process.
fn relative(matrix: &Matrix3<f64>, scale: &Vector3<f64>, unscale: &Vector3<f64>) -> f64 {
    (Matrix3::from_diagonal(unscale) * matrix * Matrix3::from_diagonal(scale)).amax()
}
