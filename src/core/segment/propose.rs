//! Proposes marks from the stream alone: the cuts with the best free flights between them.
//!
//! The cost of a stretch is the residual sum of squares of the best flight through its positions
//! and of the best straight line through its integrated angular momentum (`prefix.rs`), in the
//! scene's units of residual. The cost of a cut is the squared distance between the features that
//! should touch there. The cuts of least total cost are found by dynamic programming over a grid of
//! places, then moved sample by sample.

use super::prefix::PrefixSums;
use super::toss::{Toss, ends_s, toss};
use crate::motion::{
    Collision, Partner, Sample, Scene, Seen, Sketch, Stamp, TrackIndex, TrackSketch,
};
use crate::physics::contact::Feature;

/// Places of the grid for cuts, evenly over the stream, for few cuts,
const PLACES: usize = 320;
/// and places per cut for many.
const PLACES_PER_CUT: usize = 12;
/// Greatest number of cuts that are proposed.
const CUTS_MAX: usize = 60;
/// Least number of samples between two cuts.
const KEEP_SAMPLES: usize = 5;
/// Weight of the distance between the features that should touch, in samples.
const TOUCH_WEIGHT: f64 = 10.0;
/// Least [`Proposal::score`] of a clear proposal.
pub const CLEAR_SCORE: f64 = 2.0;
/// Least number of places of superfluous cuts that tell what one gains.
const PLACES_MIN: usize = 10;
/// One more flight gains more from white noise by this over the number of degrees of freedom, as its variance is
/// the less known the fewer they are.
const FEW: f64 = 12.0;
/// Greatest score; that of a cut where a superfluous one would gain nothing.
const SCORE_MAX: f64 = 1e6;

/// A proposed collision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Proposal {
    /// What shows it.
    pub track: TrackIndex,
    /// The collision it stands for (index into `Scene::events`), if as many were searched for as
    /// the scene has.
    pub event: Option<usize>,
    /// Acted time [s since `Sketch::origin`].
    pub acted_s: f64,
    /// Decrease of the cost by this cut over the decrease by one superfluous cut at its best place;
    /// at most 10⁶. Above one, the kink is stronger than the wander of the hand. Where flights are too
    /// short for superfluous cuts, the kink is compared with a smooth bend.
    pub score: f64,
}

impl Proposal {
    /// The acted time on the clock of the samples.
    pub fn stamp(&self, sketch: &Sketch) -> Stamp {
        sketch.origin.after(self.acted_s)
    }
}

/// When the motion starts and ends [s since `Sketch::origin`]: at release and with the flight after the last
/// collision of a whole toss, otherwise at the first and the last sample.
pub fn ends_of_motion_s(scene: &Scene, sketch: &Sketch) -> Option<[f64; 2]> {
    let samples = || sketch.tracks.iter().flat_map(|track| &track.samples);
    let first_s = samples().map(|of| of.acted_s).min_by(f64::total_cmp)?;
    let last_s = samples().map(|of| of.acted_s).max_by(f64::total_cmp)?;
    Some(ends_s(scene, sketch).unwrap_or([first_s, last_s]))
}

/// Proposals for all collisions of the scene, in its order; for each track those that concern
/// it. A collision of two tracks is proposed from the stream of its first. `count`, if given, is
/// the number of collisions searched for on each track, in place of the scene's.
///
/// Empty where a stream is too short, or where there are more than sixty collisions.
pub fn propose(scene: &Scene, sketch: &Sketch, count: Option<usize>) -> Vec<Proposal> {
    let mut proposals = Vec::new();
    let tracks = sketch.tracks.iter_enumerated();
    // What is held has no flights to be fitted.
    for (index, track) in tracks.filter(|(index, _)| scene.sees_moving(*index)) {
        let mechanism = scene.mechanism_seen_by(index);
        let events: Vec<usize> = (0..scene.events.len())
            .filter(|event| {
                let collision = scene.events[*event].kind.collision();
                collision.is_some_and(|collision| scene.takes_part(mechanism, collision))
            })
            .collect();
        let collisions = if count.is_none_or(|count| count == events.len()) {
            events.iter().copied().map(Some).collect()
        } else {
            vec![None; count.unwrap_or(0)]
        };
        let toss = toss(scene, index, track);
        let flown = toss.map(|toss| FlownPart::new(track, &toss, collisions.len()));
        let stream =
            ProposedStream::new(scene, index, flown.as_ref().map_or(track, |of| &of.track));
        let cuts = match &flown {
            Some(flown) => flown.cuts(scene, index, &collisions),
            None => stream.best_cuts(&collisions),
        };
        let Some(cuts) = cuts else {
            continue;
        };
        let shown = flown.as_ref().map_or(0, |flown| flown.impacts.len());
        let scores = stream.scores_past(shown, &cuts, 1);
        for ((event, cut), score) in collisions.into_iter().zip(&cuts).zip(scores) {
            let is_of_first = event
                .and_then(|event| scene.events[event].kind.collision())
                .is_none_or(|collision| scene.tracks_in(collision).next() == Some(index));
            if is_of_first {
                proposals.push(Proposal {
                    track: index,
                    event,
                    acted_s: stream.time_s(*cut),
                    score,
                });
            }
        }
    }
    proposals.sort_by(|a, b| {
        let order = a.event.cmp(&b.event);
        order.then(a.acted_s.total_cmp(&b.acted_s))
    });
    proposals
}

/// What flies of a toss, from its release on.
struct FlownPart {
    track: TrackSketch,
    /// Where flights end by impacts: as many as are seen of those that are wanted.
    impacts: Vec<usize>,
}

impl FlownPart {
    fn new(track: &TrackSketch, toss: &Toss, collisions: usize) -> Self {
        let begin = toss.flights[0].start;
        let impacts = toss.flights.iter().map(|flight| flight.end - begin);
        // The last of several flights need not end by one.
        let seen = toss.flights.len().saturating_sub(1).max(1);
        let impacts: Vec<usize> = impacts.take(collisions.min(seen)).collect();
        // Up to the end of the flight after the last; to the end of all where not all are seen.
        let end = match (toss.flights.get(collisions), impacts.last()) {
            (Some(flight), _) => flight.end,
            (None, Some(last)) if impacts.len() == collisions => begin + last + 2 * KEEP_SAMPLES,
            (None, _) => track.samples.len(),
        };
        let end = end.clamp(begin, track.samples.len());
        Self {
            track: TrackSketch::new(track.samples[begin..end].to_vec()),
            impacts,
        }
    }

    /// The impacts, and those that follow them by least cost.
    fn cuts(
        &self,
        scene: &Scene,
        index: TrackIndex,
        events: &[Option<usize>],
    ) -> Option<Vec<usize>> {
        let mut cuts = self.impacts.clone();
        let from = cuts.last().copied().unwrap_or(0);
        if cuts.len() < events.len() {
            let rest = TrackSketch::new(self.track.samples[from..].to_vec());
            let more = ProposedStream::new(scene, index, &rest).best_cuts(&events[cuts.len()..])?;
            cuts.extend(more.into_iter().map(|cut| from + cut));
        }
        Some(cuts)
    }
}

/// One track's samples, with the costs of its stretches.
pub(super) struct ProposedStream<'a> {
    scene: &'a Scene,
    samples: &'a [Sample],
    positions: PrefixSums,
    turns: Option<PrefixSums>,
}

impl<'a> ProposedStream<'a> {
    pub(super) fn new(scene: &'a Scene, index: TrackIndex, track: &'a TrackSketch) -> Self {
        Self {
            turns: Some(PrefixSums::of_turns(scene, index, track)),
            ..Self::of_positions(scene, index, track)
        }
    }

    /// [`ProposedStream::new`] without the cost of rotations, which is half the work.
    pub(super) fn of_positions(
        scene: &'a Scene,
        index: TrackIndex,
        track: &'a TrackSketch,
    ) -> Self {
        Self {
            scene,
            samples: &track.samples,
            positions: PrefixSums::of_positions(scene, index, track),
            turns: None,
        }
    }

    /// The first sample after an acted time.
    pub(super) fn cut_at(&self, acted_s: f64) -> usize {
        self.samples.partition_point(|s| s.acted_s <= acted_s)
    }

    /// Acted time of a cut: the middle between the last sample before it and the first after it.
    pub(super) fn time_s(&self, cut: usize) -> f64 {
        0.5 * (self.samples[cut - 1].acted_s + self.samples[cut].acted_s)
    }

    /// Residual sum of squares of the best flight through samples `begin..end`, in units of
    /// residual.
    fn cost(&self, begin: usize, end: usize) -> f64 {
        let weights = &self.scene.weights;
        let turns = self.turns.as_ref().map_or(0.0, |t| t.cost(begin, end));
        self.positions.cost(begin, end) / weights.position_m.powi(2)
            + turns / weights.orientation_rad.powi(2)
    }

    /// [`ProposedStream::cost`] between two cuts, or ends of the stream: samples beside a cut are left out.
    fn between(&self, from: usize, to: usize) -> f64 {
        let count = self.samples.len();
        let begin = if from == 0 { 0 } else { (from + 1).min(count) };
        let end = if to == count {
            to
        } else {
            to.saturating_sub(1)
        };
        self.cost(begin, end)
    }

    /// Cost of the distance between the features that should touch at a cut, in the units of
    /// [`ProposedStream::cost`].
    fn apart(&self, event: Option<usize>, cut: usize) -> f64 {
        let collision = event.and_then(|event| self.scene.events[event].kind.collision());
        let Some(collision) = collision else {
            return 0.0;
        };
        // A mark may lie after the last sample.
        let at = cut.min(self.samples.len() - 1);
        let gap_m = gap_m(self.scene, collision, &self.samples[at]);
        TOUCH_WEIGHT * (gap_m / self.scene.weights.position_m).powi(2)
    }

    /// The cuts of least cost, one per event, in order; `None` where they do not fit.
    pub(super) fn best_cuts(&self, events: &[Option<usize>]) -> Option<Vec<usize>> {
        let count = self.samples.len();
        if events.is_empty() {
            return Some(Vec::new());
        }
        if events.len() > CUTS_MAX || count < (events.len() + 1) * KEEP_SAMPLES {
            return None;
        }
        let most = PLACES.max(PLACES_PER_CUT * events.len());
        let stride = count.div_ceil(most);
        // Places of cuts between the beginning and the end.
        let mut places = vec![0];
        places.extend((KEEP_SAMPLES..=count - KEEP_SAMPLES).step_by(stride));
        places.push(count);
        let last = places.len() - 1;
        let keep = KEEP_SAMPLES.max(2);
        let mut between = vec![f64::INFINITY; places.len() * places.len()];
        for i in 0..last {
            for j in i + 1..=last {
                if places[j] >= places[i] + keep {
                    between[j * places.len() + i] = self.between(places[i], places[j]);
                }
            }
        }
        // Least cost with the cut at each place, and the place of the cut before it.
        let mut costs: Vec<f64> = (0..=last)
            .map(|i| if i == 0 { 0.0 } else { f64::INFINITY })
            .collect();
        let mut from = Vec::new();
        let step = |costs: &[f64], j: usize| {
            let row = &between[j * places.len()..][..j];
            let sums = row.iter().zip(costs).map(|(a, b)| a + b);
            let best = sums.enumerate().min_by(|a, b| a.1.total_cmp(&b.1));
            best.unwrap_or((0, f64::INFINITY))
        };
        for event in events {
            let steps: Vec<(usize, f64)> = (0..last).map(|j| step(&costs, j)).collect();
            costs = (0..last)
                .map(|j| {
                    steps[j].1
                        + if j == 0 {
                            0.0
                        } else {
                            self.apart(*event, places[j])
                        }
                })
                .collect();
            from.push(steps);
        }
        let (mut place, cost) = step(&costs, last);
        if !cost.is_finite() {
            return None;
        }
        let mut cuts = Vec::new();
        for steps in from.iter().rev() {
            cuts.push(places[place]);
            place = steps[place].0;
        }
        cuts.reverse();
        self.settle(events, &mut cuts, stride);
        Some(cuts)
    }

    /// Moves each cut in turn to its best place within `reach`, with the others fixed; two rounds.
    fn settle(&self, events: &[Option<usize>], cuts: &mut [usize], reach: usize) {
        for index in (0..cuts.len()).chain(0..cuts.len()) {
            let (before, after) = self.neighbours(cuts, index);
            let least = (before + KEEP_SAMPLES).max(cuts[index].saturating_sub(reach));
            let most = (after.saturating_sub(KEEP_SAMPLES)).min(cuts[index] + reach);
            let cost = |cut: usize| {
                self.between(before, cut)
                    + self.between(cut, after)
                    + self.apart(events[index], cut)
            };
            if let Some(best) = (least..=most).min_by(|a, b| cost(*a).total_cmp(&cost(*b))) {
                cuts[index] = best;
            }
        }
    }

    /// Cost of the stretches on either side of a cut, and the least cost with the cut at every
    /// `stride`-th place between its neighbours.
    pub(super) fn elsewhere(&self, cuts: &[usize], index: usize, stride: usize) -> (f64, f64) {
        let (before, after) = self.neighbours(cuts, index);
        let cost = |cut: usize| self.between(before, cut) + self.between(cut, after);
        let places = before + KEEP_SAMPLES..(after + 1).saturating_sub(KEEP_SAMPLES);
        let best = places
            .step_by(stride)
            .map(cost)
            .fold(f64::INFINITY, f64::min);
        (cost(cuts[index]), best)
    }

    fn neighbours(&self, cuts: &[usize], index: usize) -> (usize, usize) {
        let before = index.checked_sub(1).map_or(0, |before| cuts[before]);
        let after = cuts.get(index + 1).copied();
        (before, after.unwrap_or(self.samples.len()))
    }

    /// Cost of all stretches and cuts; that of a stretch too short for a flight's fit is zero.
    pub(super) fn total(&self, events: &[Option<usize>], cuts: &[usize]) -> f64 {
        let apart = events.iter().zip(cuts);
        let apart: f64 = apart.map(|(event, cut)| self.apart(*event, *cut)).sum();
        let ends = self.ends(cuts);
        let stretches = ends.windows(2).map(|pair| self.between(pair[0], pair[1]));
        apart + stretches.sum::<f64>()
    }

    /// Whether cuts are in order and leave two samples between them.
    pub(super) fn has_room(&self, cuts: &[usize]) -> bool {
        let ends = self.ends(cuts);
        ends.windows(2).all(|pair| pair[0] + 4 <= pair[1])
    }

    fn ends(&self, cuts: &[usize]) -> Vec<usize> {
        let cuts = cuts.iter().copied();
        [0].into_iter()
            .chain(cuts)
            .chain([self.samples.len()])
            .collect()
    }

    /// [`Proposal::score`] of each cut; superfluous cuts are tried at every `stride`-th place.
    pub(super) fn scores(&self, cuts: &[usize], stride: usize) -> Vec<f64> {
        self.scores_past(0, cuts, stride)
    }

    /// The same where the path itself shows a jump of the velocity at the first so many: nothing smooth
    /// explains those.
    fn scores_past(&self, shown: usize, cuts: &[usize], stride: usize) -> Vec<f64> {
        let spared = |before: usize, cut: usize, after: usize| {
            // One flight through the whole stretch, with the same samples left out.
            let whole = self.between(before, after);
            whole - self.between(before, cut) - self.between(cut, after)
        };
        let ends = self.ends(cuts);
        let mut tried = 0;
        let superfluous = ends
            .windows(2)
            .flat_map(|pair| {
                let (before, after) = (pair[0], pair[1]);
                (before + 2 * KEEP_SAMPLES..(after + 1).saturating_sub(2 * KEEP_SAMPLES))
                    .step_by(stride)
                    .map(move |cut| spared(before, cut, after))
            })
            .inspect(|_| tried += stride)
            .fold(0.0, f64::max);
        (0..cuts.len())
            .map(|index| {
                let (before, after) = self.neighbours(cuts, index);
                let gain = spared(before, cuts[index], after).max(0.0);
                let score = if gain > 0.0 {
                    (gain / superfluous).min(SCORE_MAX)
                } else {
                    0.0
                };
                if tried < PLACES_MIN && index >= shown {
                    score.min(self.sharpness(before, cuts[index], after))
                } else {
                    score
                }
            })
            .collect()
    }

    /// How much nearer the flights on either side of a cut are to their samples than a smooth bend is that
    /// has as many numbers, over what one more flight would gain from white noise. For stretches that
    /// have no room for superfluous cuts: a wandering hand bends, and only an impact kinks.
    fn sharpness(&self, before: usize, cut: usize, after: usize) -> f64 {
        let begin = if before == 0 { 0 } else { before + 1 };
        let end = if after == self.samples.len() {
            after
        } else {
            after - 1
        };
        let weights = &self.scene.weights;
        let of_turns = self
            .turns
            .as_ref()
            .map(|turns| (turns, weights.orientation_rad));
        let kinds = [Some((&self.positions, weights.position_m)), of_turns];
        let (mut gain, mut noise) = (0.0, 0.0);
        for (sums, unit) in kinds.into_iter().flatten() {
            let parts = (begin..cut.saturating_sub(1)).chain(cut + 1..end);
            let (bent, count) = sums.bent(parts);
            let kinked = sums.cost(begin, cut.saturating_sub(1)) + sums.cost(cut + 1, end);
            let numbers = sums.numbers() as f64;
            let freedom = (3.0 * count as f64 - 2.0 * numbers).max(1.0);
            gain += (bent - kinked) / unit.powi(2);
            noise += numbers * kinked / freedom * (1.0 + FEW / freedom) / unit.powi(2);
        }
        if gain > 0.0 {
            (gain / noise).min(SCORE_MAX)
        } else {
            0.0
        }
    }
}

/// Largest distance between the features that should touch \[m\], for points and planes; for others
/// a bound by the link's size, or zero; zero where no pose is seen.
fn gap_m(scene: &Scene, collision: &Collision, sample: &Sample) -> f64 {
    let link = &scene.links[collision.link];
    let Seen::Pose {
        position_m,
        orientation,
    } = sample.seen
    else {
        return 0.0;
    };
    if collision.partner != Partner::World {
        return 0.0;
    }
    let gaps = collision.contacts.iter().filter_map(|touching| {
        let (point_m, normal) = scene.surfaces[touching.other?].plane()?;
        let centre_m = (position_m - point_m).dot(&normal);
        let height_m = |feature: &Feature| match feature {
            Feature::Point { point_m, radius_m } => {
                Some(centre_m + (orientation * point_m).dot(&normal) - radius_m)
            }
            _ => None,
        };
        let named = touching.feature.map(|feature| &link.features[feature]);
        let height_m = match named {
            Some(feature) => height_m(&feature.geometry),
            None => link
                .features
                .iter()
                .filter_map(|feature| height_m(&feature.geometry))
                .min_by(f64::total_cmp),
        };
        Some(
            height_m
                .unwrap_or_else(|| (centre_m - link.shape.radius_m()).max(0.0))
                .abs(),
        )
    });
    gaps.fold(0.0, f64::max)
}

#[cfg(test)]
mod tests;
