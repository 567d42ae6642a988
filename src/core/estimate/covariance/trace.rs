//! Change `y = J x` of the residuals by a step `x` of the unknowns, summed over bins.

use nalgebra::{DVector, Matrix3, Vector3};

use super::bins::{Bins, Six};
use crate::estimate::problem::View;
use crate::estimate::terms::context::SolveContext;
use crate::estimate::terms::observed::SampleObserver;
use crate::estimate::unknowns::point::Point;
use crate::physics::flow::{self, Spin};
use crate::physics::state::part;

/// The change of the residuals by one step.
#[derive(Clone, Debug)]
pub struct Trace {
    /// Sum over the samples of each bin.
    pub sums: Vec<Six>,
    /// Sum of the squares over all samples, of positions and of orientations.
    pub squares: [f64; 2],
}

/// The residuals' derivative at a point: the flow is evaluated once, for any number of steps.
pub struct Design<'a> {
    context: &'a SolveContext<'a>,
    bins: usize,
    views: Vec<ViewDesign>,
}

/// The derivative of one view's residuals.
struct ViewDesign {
    /// Index into the problem's arcs.
    arc: usize,
    /// Inverse of the unit of its positions, zero where none are seen [1/m].
    per_m: f64,
    samples: Vec<SampleDesign>,
    /// Its bins, with the sums over their samples.
    pieces: Vec<(usize, Piece)>,
}

/// Derivative of one sample's residual.
struct SampleDesign {
    bin: usize,
    /// Time since the arc's epoch \[s\].
    since_s: f64,
    /// Derivatives by the state's orientation and by its angular velocity, in units.
    turn: [Matrix3<f64>; 2],
    /// Derivative by the sample's time, in units per second.
    rate: Six,
    /// The node before it, and its share of the interval to the next.
    time: (usize, f64),
    /// Derivatives by the arc's state and by the parameters that act on it, where it is not plain;
    /// they replace those of `turn` and of the time since the epoch.
    general: Vec<Six>,
}

/// Sums over the samples of one bin in one view.
#[derive(Default)]
struct Piece {
    /// Sums of powers of the time since the epoch, from the zeroth to the second.
    powers: [f64; 3],
    turn: [Matrix3<f64>; 2],
    rate: Six,
    general: Vec<Six>,
}

/// A step in terms of one arc: position, velocity and half the acceleration in units of positions,
/// orientation and angular velocity.
type ArcStep = [Vector3<f64>; 5];

impl<'a> Design<'a> {
    /// The derivative at `point`.
    pub fn new(context: &'a SolveContext, point: &Point, bins: &Bins) -> Self {
        let all: Vec<usize> = (0..context.problem.arcs.len()).collect();
        Self::of(context, point, bins, &all)
    }

    /// The derivative of the residuals of those arcs to which the bins belong.
    pub fn of(context: &'a SolveContext, point: &Point, bins: &Bins, arcs: &[usize]) -> Self {
        let problem = context.problem;
        let gravity_m_s2 = problem.gravity(&point.parameters);
        let bodies = problem.bodies_at(&point.parameters);
        let bodies = bodies.expect("moments that the solution has");
        let mut bin_of_sample = bins.of_samples.iter();
        let views = arcs.iter().flat_map(|arc| {
            let views = problem.arcs[*arc].views.iter();
            views.map(move |view| (*arc, view))
        });
        let views = views.map(|(index, view)| {
            let arc = &problem.arcs[index];
            let state = &point.arcs[index];
            let omega = &state.angular_velocity_rad_s;
            let body = &bodies[arc.mechanism];
            let own = view.samples.iter().zip(&mut bin_of_sample);
            if !view.is_plain {
                let flight = (state, context.epochs_s[index]);
                let (of, at) = ((index, view), (body, &gravity_m_s2));
                let observer = SampleObserver::new(problem, of, at, flight, &point.parameters);
                let bins = own.map(|(_, bin)| *bin);
                return ViewDesign::general(index, view, observer, bins, &point.node_times_s);
            }
            let [per_m, per_rad] = view.units.map(f64::recip);
            let mut spin = Spin::new(body, omega);
            let samples: Vec<SampleDesign> = own
                .map(|(sample, bin)| {
                    let since_s = sample.time_s(&point.node_times_s) - context.epochs_s[index];
                    let (turn, k) = spin.turn_and_derivative(since_s);
                    let to_body = turn.inverse().to_rotation_matrix().into_inner() * per_rad;
                    let by_spin = to_body * k;
                    let velocity = flow::velocity(body, &gravity_m_s2, state, since_s) * per_m;
                    let spinning = by_spin * omega;
                    SampleDesign {
                        bin: *bin,
                        since_s,
                        turn: [to_body, by_spin * since_s],
                        rate: six(&velocity, &spinning),
                        time: (sample.node, sample.share),
                        general: Vec::new(),
                    }
                })
                .collect();
            ViewDesign::new(index, per_m, samples)
        });
        Self {
            context,
            bins: bins.count(),
            views: views.collect(),
        }
    }

    /// Changes of the residuals by a step, summed over the samples of each bin.
    pub fn sums(&self, step: &DVector<f64>) -> Vec<Six> {
        let mut sums = vec![[0.0; 6]; self.bins];
        let times_are_unknown = self.context.problem.times_are_unknown();
        for view in &self.views {
            let [x, v, half_pull, r, w] = self.arc_step(view, step);
            for (bin, piece) in &view.pieces {
                let [count, first, second] = piece.powers;
                let shift = x * count + v * first + half_pull * second;
                let turn = piece.turn[0] * r + piece.turn[1] * w;
                if piece.general.is_empty() {
                    add(&mut sums[*bin], &six(&shift, &turn), 1.0);
                }
                for (by, at) in piece.general.iter().zip(self.unknowns(view.arc)) {
                    add(&mut sums[*bin], by, step[at]);
                }
            }
            if times_are_unknown {
                for sample in &view.samples {
                    add(
                        &mut sums[sample.bin],
                        &sample.rate,
                        self.later_s(sample, step),
                    );
                }
            }
        }
        sums
    }

    /// Derivatives of the residuals by a common shift of all sample times, summed over each bin.
    pub fn rates(&self) -> Vec<Six> {
        let mut sums = vec![[0.0; 6]; self.bins];
        for (bin, piece) in self.views.iter().flat_map(|view| &view.pieces) {
            add(&mut sums[*bin], &piece.rate, 1.0);
        }
        sums
    }

    /// The change of the residuals by a step, with sums of squares.
    pub fn trace(&self, step: &DVector<f64>) -> Trace {
        let mut squares = [0.0; 2];
        self.each_change(step, |change| {
            for (axis, change) in change.iter().enumerate() {
                squares[axis / 3] += change * change;
            }
        });
        Trace {
            sums: self.sums(step),
            squares,
        }
    }

    /// Changes of every sample's residual by a step, in order.
    pub fn each_change(&self, step: &DVector<f64>, mut each: impl FnMut(&Six)) {
        for view in &self.views {
            let [x, v, half_pull, r, w] = self.arc_step(view, step);
            let moved = self.unknowns(view.arc).map(|at| step[at]).enumerate();
            let moved: Vec<(usize, f64)> = moved.filter(|(_, by)| *by != 0.0).collect();
            for sample in &view.samples {
                let shift = x + (v + half_pull * sample.since_s) * sample.since_s;
                let turn = sample.turn[0] * r + sample.turn[1] * w;
                let mut change = six(&shift, &turn);
                if !sample.general.is_empty() {
                    change = [0.0; 6];
                    for (at, by) in &moved {
                        add(&mut change, &sample.general[*at], *by);
                    }
                }
                add(&mut change, &sample.rate, self.later_s(sample, step));
                each(&change);
            }
        }
    }

    /// Unknowns of an arc's state and of the parameters that act on it.
    fn unknowns(&self, arc: usize) -> impl Iterator<Item = usize> + '_ {
        let (problem, layout) = (self.context.problem, self.context.layout);
        let acting = problem.arcs[arc].acting.iter();
        let acting = acting.map(|acting| layout.parameters[acting.parameter]);
        layout.state(arc).chain(acting)
    }

    fn arc_step(&self, view: &ViewDesign, step: &DVector<f64>) -> ArcStep {
        let (problem, layout) = (self.context.problem, self.context.layout);
        let per_m = view.per_m;
        let first = layout.arcs[view.arc];
        let three = |part: usize| -> Vector3<f64> { step.fixed_rows::<3>(first + part).into() };
        let of_axis = |axis: usize| {
            let parameter = problem.gravity_parameters[axis]?;
            Some(step[layout.parameters[parameter]])
        };
        let pull = Vector3::from_fn(|axis, _| of_axis(axis).unwrap_or(0.0));
        [
            three(part::POSITION) * per_m,
            three(part::VELOCITY) * per_m,
            pull * (0.5 * per_m),
            three(part::ORIENTATION),
            three(part::ANGULAR_VELOCITY),
        ]
    }

    /// Change of a sample's time by a step \[s\].
    fn later_s(&self, sample: &SampleDesign, step: &DVector<f64>) -> f64 {
        let moved_s = |node: usize| {
            let at = self.context.layout.nodes.get(node).copied().flatten();
            at.map_or(0.0, |at| step[at])
        };
        let (node, share) = sample.time;
        (1.0 - share) * moved_s(node) + share * moved_s(node + 1)
    }
}

impl ViewDesign {
    /// The derivative of a view that is not plain. Orientations are turned from the frame of its
    /// arc's epoch to the body's, unless they are whitened.
    fn general(
        arc: usize,
        view: &View,
        mut observer: SampleObserver,
        bins: impl Iterator<Item = usize>,
        node_times_s: &[f64],
    ) -> Self {
        let samples = view.samples.iter().zip(bins).enumerate();
        let samples = samples.map(|(index, (sample, bin))| {
            let observed = observer.observed(index, node_times_s);
            let back = observed.turn.inverse();
            let turned = |by: &Six| -> Six {
                if !view.whitenings.is_empty() {
                    return *by;
                }
                let turn = back * Vector3::new(by[3], by[4], by[5]);
                [by[0], by[1], by[2], turn.x, turn.y, turn.z]
            };
            let all = observed.by_state.iter().chain(&observed.by_acting);
            SampleDesign {
                bin,
                since_s: 0.0,
                turn: [Matrix3::zeros(); 2],
                rate: turned(&observed.by_time),
                time: (sample.node, sample.share),
                general: all.map(turned).collect(),
            }
        });
        Self::new(arc, 0.0, samples.collect())
    }

    fn new(arc: usize, per_m: f64, samples: Vec<SampleDesign>) -> Self {
        let mut pieces: Vec<(usize, Piece)> = Vec::new();
        for sample in &samples {
            if pieces.last().is_none_or(|(bin, _)| *bin != sample.bin) {
                pieces.push((sample.bin, Piece::default()));
            }
            let (_, piece) = pieces.last_mut().expect("one was begun");
            piece.powers[0] += 1.0;
            piece.powers[1] += sample.since_s;
            piece.powers[2] += sample.since_s * sample.since_s;
            piece.turn[0] += sample.turn[0];
            piece.turn[1] += sample.turn[1];
            add(&mut piece.rate, &sample.rate, 1.0);
            piece.general.resize(sample.general.len(), [0.0; 6]);
            for (sum, by) in piece.general.iter_mut().zip(&sample.general) {
                add(sum, by, 1.0);
            }
        }
        Self {
            arc,
            per_m,
            samples,
            pieces,
        }
    }
}

fn six(shift: &Vector3<f64>, turn: &Vector3<f64>) -> Six {
    [shift.x, shift.y, shift.z, turn.x, turn.y, turn.z]
}

fn add(sum: &mut Six, other: &Six, factor: f64) {
    for (sum, other) in sum.iter_mut().zip(other) {
        *sum += factor * other;
    }
}
