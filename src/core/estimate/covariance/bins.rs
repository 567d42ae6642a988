//! Bins of consecutive samples of a track, whose mean residuals show a slow wander.

use std::collections::BTreeSet;

use crate::estimate::problem::{ArcSample, Problem, View};
use crate::estimate::unknowns::point::Point;
use crate::motion::TrackIndex;

/// A residual, position then orientation in body axes, in the problem's units; or its change.
pub type Six = [f64; 6];

/// Products of two changes of all residuals, summed: of positions and of orientations.
pub fn products(a: &[Six], b: &[Six]) -> [f64; 2] {
    let mut products = [0.0; 2];
    for (a, b) in a.iter().zip(b) {
        for axis in 0..6 {
            products[axis / 3] += a[axis] * b[axis];
        }
    }
    products
}

/// The residuals of one view's samples.
#[derive(Clone, Debug, PartialEq)]
pub struct Residuals {
    /// Whether the view sees positions, and whether orientations or directions: the others are zero.
    pub kinds: [bool; 2],
    /// Sample by sample.
    pub each: Vec<Six>,
}

/// Number of bins of a track per flight, and its maximum.
const PER_FLIGHT: usize = 4;
const MOST: usize = 16;

/// Consecutive samples of one track.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bin {
    /// The track.
    pub track: TrackIndex,
    /// Whether positions, and whether orientations or directions are seen.
    pub kinds: [bool; 2],
    /// Mean time of the samples \[s\].
    pub time_s: f64,
    /// Mean acted time of the samples \[s\].
    pub acted_s: f64,
    /// Number of samples.
    pub samples: usize,
}

impl Bin {
    fn of(track: TrackIndex, kinds: [bool; 2]) -> Self {
        Self {
            track,
            kinds,
            time_s: 0.0,
            acted_s: 0.0,
            samples: 0,
        }
    }

    fn add(&mut self, time_s: f64, acted_s: f64) {
        self.samples += 1;
        self.time_s += (time_s - self.time_s) / self.samples as f64;
        self.acted_s += (acted_s - self.acted_s) / self.samples as f64;
    }
}

/// All samples in bins.
#[derive(Clone, Debug, PartialEq)]
pub struct Bins {
    /// Track by track, in order of time.
    pub bins: Vec<Bin>,
    /// The bin of every sample, view by view.
    pub of_samples: Vec<usize>,
    /// Mean duration of a flight \[s\].
    pub flight_s: f64,
}

impl Bins {
    /// Bins of every track: four of equal size per flight, fewer with many flights; with more than
    /// sixteen flights, neighbouring flights share one.
    pub fn new(problem: &Problem, point: &Point) -> Self {
        let all: Vec<usize> = (0..problem.arcs.len()).collect();
        Self::of(problem, point, &all)
    }

    /// The bins of some arcs alone, in order of time.
    pub fn of(problem: &Problem, point: &Point, arcs: &[usize]) -> Self {
        Self::with(problem, point, arcs, PER_FLIGHT)
    }

    /// As many bins of one arc alone as there may be, in order of time.
    pub fn fine(problem: &Problem, point: &Point, arc: usize) -> Self {
        Self::with(problem, point, &[arc], MOST)
    }

    /// The bins of some arcs with so many per flight at most.
    fn with(problem: &Problem, point: &Point, arcs: &[usize], most: usize) -> Self {
        let views = arcs.iter().flat_map(|arc| &problem.arcs[*arc].views);
        let views: Vec<&View> = views.collect();
        let mut bins: Vec<Bin> = Vec::new();
        let mut of_samples = vec![0; views.iter().map(|view| view.samples.len()).sum()];
        let (mut flights_s, mut all_flights) = (0.0, 0);
        let series = |view: &View| (view.track, view.kinds());
        let all: BTreeSet<(TrackIndex, [bool; 2])> = views.iter().map(|v| series(v)).collect();
        for of in all {
            let is_of = |view: &&&View| series(view) == of && !view.samples.is_empty();
            let flights = views.iter().filter(is_of).count();
            let per_flight = (MOST / flights.max(1)).clamp(1, most);
            let (mut next, mut flight, mut last) = (0, 0, None);
            for view in &views {
                let count = view.samples.len();
                if is_of(&view) {
                    for (index, sample) in view.samples.iter().enumerate() {
                        let place = (
                            flight * MOST / flights.max(MOST),
                            index * per_flight / count,
                        );
                        if last.replace(place) != Some(place) {
                            bins.push(Bin::of(of.0, of.1));
                        }
                        of_samples[next + index] = bins.len() - 1;
                        let bin = bins.last_mut().expect("one was begun");
                        let acted_s = problem.nodes_acted_s[sample.node];
                        bin.add(point.node_times_s[sample.node], acted_s);
                    }
                    let time_s = |sample: &ArcSample| point.node_times_s[sample.node];
                    flights_s += time_s(&view.samples[count - 1]) - time_s(&view.samples[0]);
                    flight += 1;
                }
                next += count;
            }
            all_flights += flight;
        }
        Self {
            bins,
            of_samples,
            flight_s: flights_s / all_flights.max(1) as f64,
        }
    }

    /// Number of bins.
    pub fn count(&self) -> usize {
        self.bins.len()
    }

    /// Number of mean residuals that are seen.
    pub fn dimension(&self) -> usize {
        let kinds = self.bins.iter().flat_map(|bin| bin.kinds);
        3 * kinds.filter(|is_seen| *is_seen).count()
    }

    /// Means of sums over the bins.
    pub fn means(&self, sums: &[Six]) -> Vec<Six> {
        let means = sums.iter().zip(&self.bins);
        means
            .map(|(sum, bin)| sum.map(|sum| sum / bin.samples as f64))
            .collect()
    }

    /// Means of every sample's residual.
    pub fn mean_residuals(&self, residuals: &[Residuals]) -> Vec<Six> {
        let mut sums = vec![[0.0; 6]; self.count()];
        for (residual, bin) in residuals
            .iter()
            .flat_map(|of| &of.each)
            .zip(&self.of_samples)
        {
            for (sum, residual) in sums[*bin].iter_mut().zip(residual) {
                *sum += residual;
            }
        }
        self.means(&sums)
    }
}
