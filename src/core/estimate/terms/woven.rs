//! The objective where samples err in time: residuals and their derivatives go through the filter of their hand, from
//! flight to flight.
//!
//! Positions are in world axes, turns in the body's, which both go on through an impact.

use nalgebra::{DMatrix, DVector};

use super::objective::Objective;
use super::observed::{Observed, SampleObserver};
use crate::estimate::problem::weave::{Weave, WovenArc, WovenHand, WovenSample};
use crate::estimate::problem::{ArcSample, Problem};
use crate::estimate::terms::context::SolveContext;
use crate::estimate::unknowns::point::Point;
use crate::estimate::wander::filter::weighed;
use crate::estimate::wander::series::Series;
use crate::estimate::wander::white::WhiteProducts;
use crate::estimate::wander::{Filter, Means, SampleInstant};
use crate::physics::state;

/// A sample of a hand with its residual.
struct WovenResidual<'o> {
    /// Its flight's place among the hand's.
    place: usize,
    woven: &'o WovenSample,
    /// Which kinds it shows.
    kinds: [bool; 2],
    sample: &'o ArcSample,
    observed: &'o Observed,
}

/// The samples of one hand and kind until now.
struct WovenStrand {
    kind: usize,
    filter: Filter,
    means: Means,
    /// Numbers of parameters.
    parameters: usize,
    /// Flights that have columns now, by their place in the hand.
    places: Vec<usize>,
    /// Residual, parameters, then of each flight its state and its nodes: of the samples since the last flight began.
    white: WhiteProducts,
    numbers: Vec<f64>,
}

impl WovenStrand {
    fn new(weave: &Weave, hand: &WovenHand, kind: usize) -> Self {
        let parameters = hand.parameters.len();
        Self {
            kind,
            filter: Filter::new(&weave.processes[kind]),
            means: Means::new(3 * (1 + parameters)),
            parameters,
            places: Vec::new(),
            white: WhiteProducts::new(1 + parameters),
            numbers: Vec::new(),
        }
    }

    /// Number of columns.
    fn columns(&self, hand: &WovenHand) -> usize {
        let own = self.places.iter().map(|place| width(&hand.arcs[*place]));
        1 + self.parameters + own.sum::<usize>()
    }

    /// Goes on to a flight, and forgets those that no longer count.
    fn begin(&mut self, place: usize, hand: &WovenHand) {
        let first = 3 * (1 + self.parameters);
        let remembered = hand.arcs[place].remembered;
        let forgotten = self.places.iter().filter(|of| **of + remembered < place);
        let forgotten: Vec<usize> = forgotten.copied().collect();
        let numbers = forgotten.iter().map(|place| 3 * width(&hand.arcs[*place]));
        self.means.remove(first..first + numbers.sum::<usize>());
        self.places.drain(..forgotten.len());
        self.places.push(place);
        self.means.extend(3 * width(&hand.arcs[place]));
        self.white = WhiteProducts::new(self.columns(hand));
    }

    /// Adds a sample of the last flight.
    fn add(&mut self, of: &WovenResidual, hand: &WovenHand) {
        let (observed, woven) = (of.observed, &hand.arcs[of.place]);
        let (kind, columns) = (self.kind, self.columns(hand));
        let own = columns - width(woven);
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
            let place = hand.parameters.binary_search(&acting.parameter);
            set(1 + place.expect("it acts on the hand"), by);
        }
        for (at, by) in observed.by_state.iter().enumerate() {
            set(own + at, by);
        }
        for (node, share) in of.sample.shares() {
            if let Some(at) = woven.moved.clone().position(|moved| moved == node) {
                let by = observed.by_time.map(|by| by * share);
                set(own + state::DIMENSION + at, &by);
            }
        }
        self.means.whiten(
            &self.filter.next(&of.woven.instant(kind)),
            &mut self.numbers,
        );
        self.white.push(&self.numbers);
    }
}

/// Number of a flight's own unknowns: its state and the times of its nodes.
fn width(of: &WovenArc) -> usize {
    state::DIMENSION + of.moved.len()
}

impl Objective<'_> {
    /// Adds the residuals of all samples; infinitely many where no body has such moments.
    pub(in crate::estimate) fn add_woven(&mut self, weave: &Weave) {
        let (context, point) = (self.context, self.point);
        for hand in &weave.hands {
            let mut strands = [0, 1].map(|kind| WovenStrand::new(weave, hand, kind));
            let mut place = None;
            let is_body = each(context, point, hand, &mut |of| {
                let at = of.place;
                if place.replace(at) != Some(at) {
                    for strand in &mut strands {
                        self.add_strand(strand, hand);
                        strand.begin(at, hand);
                    }
                }
                for strand in strands.iter_mut().filter(|strand| of.kinds[strand.kind]) {
                    strand.add(of, hand);
                }
            });
            if !is_body {
                self.add_cost(f64::INFINITY);
                return;
            }
            for strand in &mut strands {
                self.add_strand(strand, hand);
            }
        }
    }

    /// Adds the products of a strand since its last flight began.
    fn add_strand(&mut self, strand: &mut WovenStrand, hand: &WovenHand) {
        let layout = self.context.layout;
        let parameters = hand.parameters.iter().map(|at| layout.parameters[*at]);
        let arcs = strand.places.iter().map(|place| &hand.arcs[*place]);
        let own = arcs.flat_map(|arc| layout.woven(arc));
        let unknowns: Vec<usize> = parameters.chain(own).collect();
        let gram = std::mem::replace(&mut strand.white, WhiteProducts::new(0)).gram();
        self.add_cost(0.5 * gram[(0, 0)]);
        for (column, one) in unknowns.iter().enumerate() {
            self.gradient[*one] += gram[(1 + column, 0)];
            for (row, other) in unknowns.iter().enumerate().skip(column) {
                self.add_pair(*other, *one, gram[(1 + row, 1 + column)]);
            }
        }
    }
}

/// Calls for every sample of a hand, in order of time. Whether the parameters make a body at all.
fn each(
    context: &SolveContext,
    point: &Point,
    hand: &WovenHand,
    call: &mut dyn FnMut(&WovenResidual),
) -> bool {
    let problem: &Problem = context.problem;
    let gravity_m_s2 = problem.gravity(&point.parameters);
    let Some(bodies) = problem.bodies_at(&point.parameters) else {
        return false;
    };
    let mut memory = Vec::new();
    for (place, woven) in hand.arcs.iter().enumerate() {
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
            let view = &arc.views[sample.view];
            call(&WovenResidual {
                place,
                woven: sample,
                kinds: view.kinds(),
                sample: &view.samples[sample.sample],
                observed: &observed,
            });
            memory = observed.by_acting;
        }
    }
    true
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
    for hand in &weave.hands {
        let of_kind = all.len();
        for kind in 0..2 {
            all.push(Series {
                track: hand.track,
                kind,
                taken: Vec::new(),
                rows: Vec::new(),
                unit: hand.units[kind],
            });
        }
        let is_body = each(context, point, hand, &mut |of| {
            let (woven, observed) = (&hand.arcs[of.place], of.observed);
            let states = layout.state(woven.arc).zip(&observed.by_state);
            let acting = woven
                .acting
                .iter()
                .map(|of| layout.parameters[of.parameter]);
            let nodes = of.sample.shares().filter_map(|(node, share)| {
                let at = layout.nodes[node]?;
                Some((at, observed.by_time.map(|by| by * share)))
            });
            let own = states.chain(acting.zip(&observed.by_acting));
            let own = own.map(|(at, by)| (at, *by));
            let by: Vec<(usize, [f64; 6])> = own.chain(nodes).collect();
            for kind in (0..2).filter(|kind| of.kinds[*kind]) {
                let series = &mut all[of_kind + kind];
                series.taken.push(of.woven.instant(kind));
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

/// What every sample pulls with, `V⁻¹ r` in units, view by view: nothing where it is left out. `None` where the parameters make
/// no body.
pub(in crate::estimate) fn pulls(
    context: &SolveContext,
    point: &Point,
    weave: &Weave,
) -> Option<Vec<Vec<[f64; 6]>>> {
    let problem = context.problem;
    let of_view = problem
        .views()
        .map(|(_, view)| vec![[0.0; 6]; view.samples.len()]);
    let mut pulls: Vec<Vec<[f64; 6]>> = of_view.collect();
    for hand in &weave.hands {
        let mut taken: [Vec<SampleInstant>; 2] = Default::default();
        let mut residuals: [Vec<[f64; 3]>; 2] = Default::default();
        let is_body = each(context, point, hand, &mut |of| {
            for kind in (0..2).filter(|kind| of.kinds[*kind]) {
                let first = 3 * kind;
                taken[kind].push(of.woven.instant(kind));
                residuals[kind].push(std::array::from_fn(|axis| {
                    of.observed.residual[first + axis]
                }));
            }
        });
        if !is_body {
            return None;
        }
        for (kind, process) in weave.processes.iter().enumerate() {
            let mut weighed = weighed(process, &taken[kind], &residuals[kind]).into_iter();
            for arc in &hand.arcs {
                let first = problem.views_of(arc.arc).start;
                for of in &arc.samples {
                    if problem.arcs[arc.arc].views[of.view].kinds()[kind] {
                        let pull = weighed.next().expect("one for each");
                        pulls[first + of.view][of.sample][3 * kind..][..3].copy_from_slice(&pull);
                    }
                }
            }
        }
    }
    Some(pulls)
}
