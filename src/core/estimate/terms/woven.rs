//! The objective where samples err in time: residuals and their derivatives go through the filter of their track, from
//! flight to flight.
//!
//! Positions are in world axes, turns in the body's, which both go on through an impact.

use nalgebra::{DMatrix, DVector};

use super::objective::Objective;
use super::observed::{Observed, SampleObserver};
use crate::estimate::problem::Problem;
use crate::estimate::problem::weave::{Weave, WovenTrack};
use crate::estimate::terms::context::SolveContext;
use crate::estimate::unknowns::point::Point;
use crate::estimate::wander::series::Series;
use crate::estimate::wander::{Filter, Means};
use crate::physics::state;

/// A sample of a track with its residual.
struct WovenResidual<'o> {
    /// Its flight's place among the track's.
    place: usize,
    /// When it was taken \[s, acted\].
    acted_s: f64,
    /// Which kinds it shows.
    kinds: [bool; 2],
    observed: &'o Observed,
}

/// The samples of one track and kind until now.
struct WovenStrand {
    kind: usize,
    filter: Filter,
    means: Means,
    /// Numbers of parameters.
    parameters: usize,
    /// Flights whose states have columns now, by their place in the track.
    places: Vec<usize>,
    /// Products of the columns: residual, parameters, states.
    gram: DMatrix<f64>,
    numbers: Vec<f64>,
}

impl WovenStrand {
    fn new(weave: &Weave, track: &WovenTrack, kind: usize) -> Self {
        let parameters = track.parameters.len();
        Self {
            kind,
            filter: Filter::new(&weave.processes[kind]),
            means: Means::new(3 * (1 + parameters)),
            parameters,
            places: Vec::new(),
            gram: DMatrix::zeros(1 + parameters, 1 + parameters),
            numbers: Vec::new(),
        }
    }

    /// Number of columns.
    fn columns(&self) -> usize {
        1 + self.parameters + state::DIMENSION * self.places.len()
    }

    /// Goes on to a flight, and forgets those that no longer count.
    fn begin(&mut self, place: usize, remembered: usize) {
        let first = 3 * (1 + self.parameters);
        let forgotten = self.places.iter().filter(|of| **of + remembered < place);
        let forgotten = forgotten.count();
        self.places.drain(..forgotten);
        self.means
            .remove(first..first + 3 * state::DIMENSION * forgotten);
        self.places.push(place);
        self.means.extend(3 * state::DIMENSION);
        self.gram = DMatrix::zeros(self.columns(), self.columns());
    }

    /// Adds a sample of the last flight.
    fn add(&mut self, of: &WovenResidual, track: &WovenTrack) {
        let (observed, woven) = (of.observed, &track.arcs[of.place]);
        let (kind, columns) = (self.kind, self.columns());
        self.numbers.clear();
        self.numbers.resize(3 * columns, 0.0);
        let mut set = |column: usize, six: &[f64; 6]| {
            for (number, of) in self.numbers[3 * column..]
                .iter_mut()
                .zip(&six[3 * kind..][..3])
            {
                *number += of;
            }
        };
        set(0, &observed.residual);
        for (acting, by) in woven.acting.iter().zip(&observed.by_acting) {
            let place = track.parameters.binary_search(&acting.parameter);
            set(1 + place.expect("it acts on the track"), by);
        }
        for (at, by) in observed.by_state.iter().enumerate() {
            set(columns - state::DIMENSION + at, by);
        }
        self.means
            .whiten(&self.filter.next(of.acted_s), &mut self.numbers);
        for (column, one) in self.numbers.chunks_exact(3).enumerate() {
            let rows = self.numbers.chunks_exact(3).enumerate().skip(column);
            for (row, other) in rows {
                self.gram[(row, column)] +=
                    one[0] * other[0] + one[1] * other[1] + one[2] * other[2];
            }
        }
    }
}

impl Objective<'_> {
    /// Adds the residuals of all samples; infinitely many where no body has such moments.
    pub(in crate::estimate) fn add_woven(&mut self, weave: &Weave) {
        let (context, point) = (self.context, self.point);
        for track in &weave.tracks {
            let mut strands = [0, 1].map(|kind| WovenStrand::new(weave, track, kind));
            let mut place = None;
            let is_body = each(context, point, track, &mut |of| {
                let at = of.place;
                if place.replace(at) != Some(at) {
                    for strand in &mut strands {
                        self.add_strand(strand, track);
                        strand.begin(at, track.arcs[at].remembered);
                    }
                }
                for strand in strands.iter_mut().filter(|strand| of.kinds[strand.kind]) {
                    strand.add(of, track);
                }
            });
            if !is_body {
                self.add_cost(f64::INFINITY);
                return;
            }
            for strand in &strands {
                self.add_strand(strand, track);
            }
        }
    }

    /// Adds the products of a strand since its last flight began.
    fn add_strand(&mut self, strand: &WovenStrand, track: &WovenTrack) {
        let layout = self.context.layout;
        let parameters = track.parameters.iter().map(|at| layout.parameters[*at]);
        let arcs = strand.places.iter().map(|place| track.arcs[*place].arc);
        let states = arcs.flat_map(|arc| layout.state(arc));
        let unknowns: Vec<usize> = parameters.chain(states).collect();
        self.add_cost(0.5 * strand.gram[(0, 0)]);
        for (column, one) in unknowns.iter().enumerate() {
            self.gradient[*one] += strand.gram[(1 + column, 0)];
            for (row, other) in unknowns.iter().enumerate().skip(column) {
                self.add_pair(*other, *one, strand.gram[(1 + row, 1 + column)]);
            }
        }
    }
}

/// Calls for every sample of a track, in order of time. Whether the parameters make a body at all.
fn each(
    context: &SolveContext,
    point: &Point,
    track: &WovenTrack,
    call: &mut dyn FnMut(&WovenResidual),
) -> bool {
    let problem: &Problem = context.problem;
    let gravity_m_s2 = problem.gravity(&point.parameters);
    let Some(bodies) = problem.bodies_at(&point.parameters) else {
        return false;
    };
    let mut memory = Vec::new();
    for (place, woven) in track.arcs.iter().enumerate() {
        let arc = &problem.arcs[woven.arc];
        let flight = (&point.arcs[woven.arc], context.epochs_s[woven.arc]);
        let body = &bodies[arc.mechanism];
        let observers = arc.views.iter().map(|view| {
            let of = (woven.arc, view);
            SampleObserver::new(
                problem,
                of,
                (body, &gravity_m_s2),
                flight,
                &point.parameters,
            )
            .in_body_axes(&woven.acting)
        });
        let mut observers: Vec<SampleObserver> = observers.collect();
        for sample in &woven.samples {
            let observed = observers[sample.view].observed_in(
                sample.sample,
                &point.node_times_s,
                std::mem::take(&mut memory),
            );
            let kinds = arc.views[sample.view].kinds();
            call(&WovenResidual {
                place,
                acted_s: sample.acted_s,
                kinds,
                observed: &observed,
            });
            memory = observed.by_acting;
        }
    }
    true
}

/// One unit of residuals of a track \[m or rad\], infinite where none are seen.
fn unit(problem: &Problem, track: &WovenTrack, kind: usize) -> f64 {
    let views = track.arcs.iter().flat_map(|of| &problem.arcs[of.arc].views);
    let of_track = views.filter(|view| view.track == track.track);
    let units = of_track.map(|view| view.units[kind]);
    units.fold(f64::INFINITY, f64::min)
}

/// Residuals of all samples and their derivatives along directions of the unknowns, a column each; the residuals are the
/// last column. `None` where the parameters make no body.
pub(in crate::estimate) fn rows(
    context: &SolveContext,
    point: &Point,
    weave: &Weave,
    directions: &DMatrix<f64>,
) -> Option<(Vec<Series>, DMatrix<f64>)> {
    let layout = context.layout;
    let mut all: Vec<Series> = Vec::new();
    let mut numbers: Vec<DVector<f64>> = Vec::new();
    for track in &weave.tracks {
        let of_kind = all.len();
        for kind in 0..2 {
            all.push(Series {
                track: track.track,
                kind,
                times_s: Vec::new(),
                rows: Vec::new(),
                unit: unit(context.problem, track, kind),
            });
        }
        let is_body = each(context, point, track, &mut |of| {
            let (woven, observed) = (&track.arcs[of.place], of.observed);
            let states = layout.state(woven.arc).zip(&observed.by_state);
            let acting = woven
                .acting
                .iter()
                .map(|of| layout.parameters[of.parameter]);
            let by: Vec<(usize, &[f64; 6])> =
                states.chain(acting.zip(&observed.by_acting)).collect();
            for kind in (0..2).filter(|kind| of.kinds[*kind]) {
                let series = &mut all[of_kind + kind];
                series.times_s.push(of.acted_s);
                series.rows.push(numbers.len());
                for axis in 3 * kind..3 * kind + 3 {
                    let mut row = DVector::zeros(directions.ncols() + 1);
                    for (unknown, six) in &by {
                        for (to, along) in row.iter_mut().zip(&directions.row(*unknown)) {
                            *to += six[axis] * along;
                        }
                    }
                    row[directions.ncols()] = observed.residual[axis];
                    numbers.push(row);
                }
            }
        });
        if !is_body {
            return None;
        }
    }
    all.retain(|of| !of.rows.is_empty());
    let columns = DMatrix::from_fn(numbers.len(), directions.ncols() + 1, |row, column| {
        numbers[row][column]
    });
    Some((all, columns))
}
