//! The objective where samples err in time: residuals and their derivatives go through the filter of their hand, from
//! flight to flight.
//!
//! Positions are in world axes, turns in the body's, which both go on through an impact.

use std::collections::BTreeSet;

use nalgebra::{DMatrix, Vector3};

use super::objective::Objective;
use super::observed::{Observed, SampleObserver};
use crate::estimate::problem::weave::{Weave, WovenArc, WovenHand, WovenSample};
use crate::estimate::problem::{ArcSample, Problem};
use crate::estimate::terms::context::SolveContext;
use crate::estimate::unknowns::layout::Layout;
use crate::estimate::unknowns::point::Point;
use crate::estimate::wander::filter::weighed;
use crate::estimate::wander::series::Series;
use crate::estimate::wander::white::WhiteProducts;
use crate::estimate::wander::{Gain, Means};
use crate::motion::TrackIndex;
use crate::physics::state::{self, part};

/// A sample of a hand.
struct WovenTaken<'o> {
    /// Its flight's place among the hand's.
    place: usize,
    woven: &'o WovenSample,
    sample: &'o ArcSample,
}

/// The samples of one hand and kind until now.
struct WovenStrand {
    kind: usize,
    means: Means,
    /// Numbers of parameters.
    parameters: usize,
    /// Flights that have columns now, by their place in the hand.
    places: Vec<usize>,
    /// Number of columns before those of the nodes of the last flight.
    until_nodes: usize,
    /// Number of the first columns that no sample until now leaves at zero.
    used: usize,
    /// Residual, parameters, then of each flight its state and its nodes: of the samples since the last flight began.
    white: WhiteProducts,
    numbers: Vec<f64>,
}

impl WovenStrand {
    fn new(hand: &WovenHand, kind: usize) -> Self {
        let parameters = hand.parameters.len();
        Self {
            kind,
            means: Means::new(3 * (1 + parameters)),
            parameters,
            places: Vec::new(),
            until_nodes: 0,
            used: 0,
            white: WhiteProducts::new(1 + parameters),
            numbers: Vec::new(),
        }
    }

    /// Number of columns of a flight: what this kind shows of its state, and the times of its nodes.
    fn width(&self, of: &WovenArc) -> usize {
        shown(of, self.kind).len() + of.moved.len()
    }

    /// Number of columns.
    fn columns(&self, hand: &WovenHand) -> usize {
        let own = self.places.iter().map(|at| self.width(&hand.arcs[*at]));
        1 + self.parameters + own.sum::<usize>()
    }

    /// Goes on to a flight, and forgets those that no longer count; gives the products of those until now.
    fn begin(&mut self, place: usize, hand: &WovenHand) -> DMatrix<f64> {
        let first = 3 * (1 + self.parameters);
        let woven = &hand.arcs[place];
        let forgotten = self.places.iter();
        let forgotten = forgotten.take_while(|of| **of + woven.remembered < place);
        let forgotten = forgotten.count();
        let numbers = self.places.drain(..forgotten).collect::<Vec<_>>();
        let numbers = numbers.iter().map(|at| 3 * self.width(&hand.arcs[*at]));
        self.means.remove(first..first + numbers.sum::<usize>());
        self.places.push(place);
        self.means.extend(3 * self.width(woven));
        let columns = self.columns(hand);
        self.until_nodes = columns - woven.moved.len();
        self.used = self.until_nodes;
        self.numbers.resize(3 * columns, 0.0);
        self.white.restart(columns)
    }

    /// Adds a sample of the last flight.
    fn add(&mut self, of: &WovenTaken, observed: &Observed, gain: &Gain, hand: &WovenHand) {
        let woven = &hand.arcs[of.place];
        let (kind, shown) = (self.kind, shown(woven, self.kind));
        let nodes = of.sample.shares().filter(|of| woven.moved.contains(&of.0));
        let nodes = nodes.map(|(node, share)| (self.until_nodes + node - woven.moved.start, share));
        let used = nodes.clone().map(|(column, _)| column + 1);
        self.used = used.fold(self.used, usize::max);
        self.white.use_first(self.used);
        let numbers = &mut self.numbers[..3 * self.used];
        numbers.fill(0.0);
        let mut set = |column: usize, six: &[f64; 6], share: f64| {
            let three = numbers[3 * column..].iter_mut().zip(&six[3 * kind..][..3]);
            for (number, of) in three {
                *number += share * of;
            }
        };
        set(0, &observed.residual, 1.0);
        for (acting, by) in woven.acting.iter().zip(&observed.by_acting) {
            let place = hand.parameters.binary_search(&acting.parameter);
            set(1 + place.expect("it acts on the hand"), by, 1.0);
        }
        let state = self.until_nodes - shown.len();
        for (at, entry) in shown.iter().enumerate() {
            set(state + at, &observed.by_state[*entry], 1.0);
        }
        for (column, share) in nodes {
            set(column, &observed.by_time, share);
        }
        self.means.whiten(gain, numbers);
        self.white.push(numbers);
    }

    /// The unknowns of its columns after the residual.
    fn unknowns(&self, hand: &WovenHand, layout: &Layout) -> Vec<usize> {
        let parameters = hand.parameters.iter().map(|at| layout.parameters[*at]);
        let own = self.places.iter().flat_map(|at| {
            let of = &hand.arcs[*at];
            let shown = shown(of, self.kind);
            let is_own = |at: usize| at >= state::DIMENSION || shown.contains(&at);
            let all = layout.woven(of).enumerate();
            all.filter(move |(at, _)| is_own(*at)).map(|(_, of)| of)
        });
        parameters.chain(own).collect()
    }
}

const PLACE: [usize; 6] = three_and_three([part::POSITION, part::VELOCITY]);
const TURN: [usize; 6] = three_and_three([part::ORIENTATION, part::ANGULAR_VELOCITY]);
const WHOLE: [usize; state::DIMENSION] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11];

const fn three_and_three([a, b]: [usize; 2]) -> [usize; 6] {
    [a, a + 1, a + 2, b, b + 1, b + 2]
}

/// Entries of a flight's state on which what samples show of a kind depends.
fn shown(of: &WovenArc, kind: usize) -> &'static [usize] {
    match kind {
        _ if of.is_carried => &WHOLE,
        0 if of.is_levered => &WHOLE,
        0 => &PLACE,
        _ => &TURN,
    }
}

impl Objective<'_> {
    /// Adds the residuals of all samples; infinitely many where no body has such moments.
    pub(in crate::estimate) fn add_woven(&mut self, weave: &Weave) {
        let (context, point) = (self.context, self.point);
        let mut memory = Vec::new();
        for hand in &weave.hands {
            let mut strands = [0, 1].map(|kind| WovenStrand::new(hand, kind));
            let mut place = None;
            let is_body = each(context, point, hand, &mut |of, observer| {
                let at = of.place;
                if place.replace(at) != Some(at) {
                    for strand in &mut strands {
                        let unknowns = strand.unknowns(hand, context.layout);
                        let gram = strand.begin(at, hand);
                        self.add_products(&gram, &unknowns);
                    }
                }
                let times_s = &point.node_times_s;
                let kept = std::mem::take(&mut memory);
                let observed = observer.observed_in(of.woven.sample, times_s, kept);
                for (strand, gain) in strands.iter_mut().zip(&of.woven.gains) {
                    if let Some(gain) = gain {
                        strand.add(of, &observed, gain, hand);
                    }
                }
                memory = observed.by_acting;
            });
            if !is_body {
                self.add_cost(f64::INFINITY);
                return;
            }
            for strand in &mut strands {
                let unknowns = strand.unknowns(hand, context.layout);
                self.add_products(&strand.white.restart(0), &unknowns);
            }
        }
    }

    /// Adds the cost of all samples and nothing else.
    pub(in crate::estimate) fn add_woven_cost(&mut self, weave: &Weave) {
        let point = self.point;
        for hand in &weave.hands {
            let mut means = [Means::new(3), Means::new(3)];
            let mut sum = 0.0;
            let is_body = each(self.context, point, hand, &mut |of, observer| {
                let mut six = observer.residual(of.woven.sample, &point.node_times_s);
                let kinds = of.woven.gains.iter().zip(six.chunks_exact_mut(3));
                for (means, (gain, three)) in means.iter_mut().zip(kinds) {
                    if let Some(gain) = gain {
                        means.whiten(gain, three);
                        sum += three.iter().map(|number| number * number).sum::<f64>();
                    }
                }
            });
            self.add_cost(if is_body { 0.5 * sum } else { f64::INFINITY });
        }
    }

    /// Adds products of the residual with itself and with the columns of unknowns.
    fn add_products(&mut self, gram: &DMatrix<f64>, unknowns: &[usize]) {
        self.add_cost(0.5 * gram[(0, 0)]);
        for (column, one) in unknowns.iter().enumerate() {
            self.gradient[*one] += gram[(1 + column, 0)];
            for (row, other) in unknowns.iter().enumerate().skip(column) {
                self.add_pair(*other, *one, gram[(1 + row, 1 + column)]);
            }
        }
    }
}

/// Calls for every sample of a hand, in order of time, with what observes it. Whether the parameters make a body at all.
fn each(
    context: &SolveContext,
    point: &Point,
    hand: &WovenHand,
    call: &mut dyn FnMut(&WovenTaken, &mut SampleObserver),
) -> bool {
    let problem: &Problem = context.problem;
    let gravity_m_s2 = problem.gravity(&point.parameters);
    for (place, woven) in hand.arcs.iter().enumerate() {
        let arc = &problem.arcs[woven.arc];
        let Some(body) = problem.body_at(woven.arc, &point.parameters) else {
            return false;
        };
        let epoch_s = context.epochs_s[woven.arc];
        let observers = arc.views.iter().map(|view| {
            let of = (woven.arc, view);
            SampleObserver::new(problem, of, (&body, &gravity_m_s2), epoch_s, point)
                .in_body_axes(&woven.acting)
        });
        let mut observers: Vec<SampleObserver> = observers.collect();
        for of in &woven.samples {
            let taken = WovenTaken {
                place,
                woven: of,
                sample: &arc.views[of.view].samples[of.sample],
            };
            call(&taken, &mut observers[of.view]);
        }
    }
    true
}

/// Residuals of samples at least so far apart and their derivatives along directions of the unknowns, a column each; the residuals
/// are the last column. `None` where the parameters make no body.
pub(in crate::estimate) fn rows(
    context: &SolveContext,
    point: &Point,
    weave: &Weave,
    directions: &DMatrix<f64>,
    apart_s: f64,
) -> Option<(Vec<Series>, DMatrix<f64>)> {
    let layout = context.layout;
    let count = directions.ncols() + 1;
    let by_unknown = directions.transpose();
    let mut all: Vec<Series> = Vec::new();
    // Row by row.
    let mut numbers: Vec<f64> = Vec::new();
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
        let is_body = each(context, point, hand, &mut |of, observer| {
            let series = &mut all[of_kind..];
            let is_next = |kind: usize| {
                let last = series[kind].taken.last();
                of.woven.gains[kind].is_some()
                    && last.is_none_or(|last| of.woven.acted_s >= last.time_s + apart_s)
            };
            let kinds = [0, 1].map(is_next);
            if kinds == [false; 2] {
                return;
            }
            let observed = observer.observed(of.woven.sample, &point.node_times_s);
            let woven = &hand.arcs[of.place];
            let states = layout.state(woven.arc).zip(&observed.by_state);
            let acting = woven.acting.iter();
            let acting = acting.map(|of| layout.parameters[of.parameter]);
            let nodes = of.sample.shares().filter_map(|(node, share)| {
                let at = layout.nodes[node]?;
                Some((at, observed.by_time.map(|by| by * share)))
            });
            let own = states.chain(acting.zip(&observed.by_acting));
            let own = own.map(|(at, by)| (at, *by));
            let by: Vec<(usize, [f64; 6])> = own.chain(nodes).collect();
            for kind in (0..2).filter(|kind| kinds[*kind]) {
                series[kind].taken.push(of.woven.instant(kind));
                series[kind].rows.push(numbers.len() / count);
                for axis in 3 * kind..3 * kind + 3 {
                    let first = numbers.len();
                    numbers.resize(first + count, 0.0);
                    let row = &mut numbers[first..];
                    row[count - 1] = observed.residual[axis];
                    for (unknown, six) in by.iter().filter(|(_, six)| six[axis] != 0.0) {
                        let along = by_unknown.column(*unknown);
                        for (to, along) in row.iter_mut().zip(along.iter()) {
                            *to += six[axis] * along;
                        }
                    }
                }
            }
        });
        if !is_body {
            return None;
        }
    }
    all.retain(|of| !of.rows.is_empty());
    let columns = DMatrix::from_row_slice(numbers.len() / count, count, &numbers);
    Some((all, columns))
}

/// Places that samples show, in units, as they are of bodies that rest: a column for each axis of each track's place, then where
/// it is seen. `None` where the parameters make no body.
pub(in crate::estimate) fn places(
    context: &SolveContext,
    point: &Point,
    weave: &Weave,
) -> Option<(Vec<Series>, DMatrix<f64>)> {
    let mut all: Vec<Series> = Vec::new();
    let mut seen: Vec<(TrackIndex, Vector3<f64>)> = Vec::new();
    for hand in &weave.hands {
        let mut series = Series {
            track: hand.track,
            kind: 0,
            taken: Vec::new(),
            rows: Vec::new(),
            unit: hand.units[0],
        };
        let is_body = each(context, point, hand, &mut |of, _| {
            if of.woven.gains[0].is_some() {
                let view = &context.problem.arcs[hand.arcs[of.place].arc].views[of.woven.view];
                series.taken.push(of.woven.instant(0));
                series.rows.push(3 * seen.len());
                seen.push((view.track, of.sample.position_m / hand.units[0]));
            }
        });
        if !is_body {
            return None;
        }
        all.push(series);
    }
    all.retain(|of| !of.rows.is_empty());
    let tracks: BTreeSet<TrackIndex> = seen.iter().map(|of| of.0).collect();
    let tracks: Vec<TrackIndex> = tracks.into_iter().collect();
    let mut columns = DMatrix::zeros(3 * seen.len(), 3 * tracks.len() + 1);
    for (at, (track, place)) in seen.iter().enumerate() {
        let of = tracks.binary_search(track).expect("it was collected");
        for axis in 0..3 {
            columns[(3 * at + axis, 3 * of + axis)] = 1.0;
            columns[(3 * at + axis, 3 * tracks.len())] = place[axis];
        }
    }
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
        let mut gains: [Vec<Gain>; 2] = Default::default();
        let mut residuals: [Vec<[f64; 3]>; 2] = Default::default();
        let is_body = each(context, point, hand, &mut |of, observer| {
            let six = observer.residual(of.woven.sample, &point.node_times_s);
            for (kind, three) in six.chunks_exact(3).enumerate() {
                if let Some(gain) = of.woven.gains[kind] {
                    gains[kind].push(gain);
                    residuals[kind].push([three[0], three[1], three[2]]);
                }
            }
        });
        if !is_body {
            return None;
        }
        for kind in 0..2 {
            let mut weighed = weighed(&gains[kind], &residuals[kind]).into_iter();
            for arc in &hand.arcs {
                let first = problem.views_of(arc.arc).start;
                for of in arc.samples.iter().filter(|of| of.gains[kind].is_some()) {
                    let pull = weighed.next().expect("one for each");
                    pulls[first + of.view][of.sample][3 * kind..][..3].copy_from_slice(&pull);
                }
            }
        }
    }
    Some(pulls)
}
