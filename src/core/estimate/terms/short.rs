//! The terms of samples of a parabola on which at most gravity acts, where of what the tracker sees
//! nothing is free but times: those of nodes, of single samples, and the clock's rate `r` and offset `o`.
//!
//! A sample's time is linear in each of them,
//!
//! ```text
//! t = t̂ + r (t̂ − t₀) + o,   t̂ = (1 − share) t_node + share t_next + added
//! ```
//!
//! so that terms by its time are multiplied by `∂t/∂u` of an unknown `u`. Nodes follow one another and
//! rate and offset are those of all samples: what they have in common is summed before it goes to its
//! places.

use nalgebra::Vector3;

use super::lever_rows::{Lever, Weighed, are_apart};
use super::levered::{Along, Four};
use super::modelled::Mount;
use super::objective::Objective;
use super::samples::{self, Between, TimeTerms};
use crate::estimate::problem::influence::Influence;
use crate::estimate::problem::{ArcSample, Problem, Shows, View};
use crate::estimate::unknowns::point::Point;
use crate::physics::Body;

impl Problem {
    /// Whether the short forms serve for a view: its arc is a parabola on which at most gravity acts,
    /// and of what it shows nothing else is free but times.
    pub(in crate::estimate) fn is_short(&self, index: usize, view: &View) -> bool {
        let arc = &self.arcs[index];
        let body = self.body_of(index);
        // The sums of levers and of covariances know no free gravity.
        let knows_gravity = self.has_no_lever(view) && view.whitenings.is_empty();
        let mut acting = arc.acting.iter().filter(|acting| acting.is_on(view.track));
        let is_direction = matches!(view.shows, Shows::Direction(_));
        body.is_ballistic()
            && (!is_direction || view.whitenings.is_empty())
            && (knows_gravity || self.free_gravity().next().is_none())
            && acting.all(|acting| match acting.influence {
                Influence::ClockRate | Influence::ClockOffset | Influence::SampleTime => true,
                Influence::Pull(_) => self.gravity_parameters.contains(&Some(acting.parameter)),
                _ => false,
            })
    }

    /// Whether a view shows the centre of mass, the orientation, or both.
    fn has_no_lever(&self, view: &View) -> bool {
        match view.shows {
            Shows::Pose | Shows::Orientation => true,
            Shows::Point => self.mounts[view.track].translation.vector == Vector3::zeros(),
            Shows::Direction(_) => false,
        }
    }
}

/// Upon which unknowns the times of a view's samples depend.
struct Stamped<'a> {
    problem: &'a Problem,
    arc: usize,
    view: &'a View,
    point: &'a Point,
    mount: Mount,
    /// Whether the clock's rate or offset is free.
    has_clock: bool,
    /// Whether any time is free.
    depends: bool,
}

impl<'a> Stamped<'a> {
    fn new(problem: &'a Problem, arc: usize, view: &'a View, point: &'a Point) -> Self {
        let mut stamped = Self {
            problem,
            arc,
            view,
            point,
            mount: problem.mount_at(arc, view.track, &point.parameters),
            has_clock: false,
            depends: problem.times_are_unknown(),
        };
        let has_clock = stamped.clocks().next().is_some();
        stamped.has_clock = has_clock;
        let mut samples = view.samples.iter();
        stamped.depends |= has_clock || samples.any(|sample| sample.open.is_some());
        stamped
    }

    fn zero_s(&self) -> f64 {
        self.point.node_times_s.first().copied().unwrap_or(0.0)
    }

    fn stamped_s(&self, sample: &ArcSample) -> f64 {
        sample.stamped_s(&self.point.node_times_s, &self.point.parameters)
    }

    /// A sample's physical time \[s\].
    fn time_s(&self, sample: &ArcSample) -> f64 {
        self.mount.time_s(self.stamped_s(sample), self.zero_s())
    }

    /// Free parameters of the clock, and whether each is a rate.
    fn clocks(&self) -> impl Iterator<Item = (usize, bool)> {
        let acting = self.problem.arcs[self.arc].acting.iter();
        let acting = acting.filter(|acting| acting.is_on(self.view.track));
        acting.filter_map(|acting| match acting.influence {
            Influence::ClockRate => Some((acting.parameter, true)),
            Influence::ClockOffset => Some((acting.parameter, false)),
            _ => None,
        })
    }
}

/// Terms by times while they are being summed.
struct ByTimes<'a> {
    stamped: &'a Stamped<'a>,
    between: Between,
    /// By the offset, and by the rate.
    clock: [TimeTerms; 2],
    /// By the offset and the rate.
    both: f64,
}

impl<'a> ByTimes<'a> {
    fn new(stamped: &'a Stamped, stride: usize) -> Self {
        let first = stamped.view.samples.get(stride / 2);
        Self {
            stamped,
            between: Between::new(first.map_or(0, |sample| sample.node)),
            clock: Default::default(),
            both: 0.0,
        }
    }

    /// Adds a sample's terms by its time.
    #[inline]
    fn add(&mut self, objective: &mut Objective, sample: &ArcSample, terms: &TimeTerms) {
        let stamped = self.stamped;
        let mut by_stamp = *terms;
        let rate = stamped.mount.rate;
        if rate != 0.0 {
            by_stamp = TimeTerms::default();
            by_stamp.add(terms, 1.0 + rate);
        }
        if stamped.problem.times_are_unknown() {
            let arc = stamped.arc;
            self.between.add(sample, &by_stamp, |node, terms| {
                objective.add_node(arc, node, terms);
            });
        }
        if stamped.has_clock || sample.open.is_some() {
            self.add_parameters(objective, sample, [terms, &by_stamp]);
        }
    }

    /// Adds a sample's terms by what is added to its own stamp, and by the clock; given those by its time
    /// and by its stamp.
    fn add_parameters(
        &mut self,
        objective: &mut Objective,
        sample: &ArcSample,
        [terms, by_stamp]: [&TimeTerms; 2],
    ) {
        let (stamped, layout) = (self.stamped, objective.context.layout);
        let by_rate = stamped.stamped_s(sample) - stamped.zero_s();
        self.clock[0].add(terms, 1.0);
        self.clock[1].add(terms, by_rate);
        self.both += by_rate * terms.square;
        let own = sample.open.map(|parameter| layout.parameters[parameter]);
        if let Some(own) = own {
            objective.add_time(stamped.arc, own, by_stamp);
        }
        // By the stamp twice, and by it and the time.
        let squares = [by_stamp.square, terms.square * (1.0 + stamped.mount.rate)];
        let nodes = sample.shares();
        let unknown = |(node, share): (usize, f64)| Some((layout.nodes[node]?, share));
        for (at, share) in nodes.filter_map(unknown) {
            if let Some(own) = own {
                objective.add_pair(own, at, share * squares[0]);
            }
            self.add_with_clock(objective, at, share * squares[1], by_rate);
        }
        if let Some(own) = own {
            self.add_with_clock(objective, own, squares[1], by_rate);
        }
    }

    /// Adds the terms by another unknown and by each of the clock's.
    fn add_with_clock(&self, objective: &mut Objective, at: usize, square: f64, by_rate: f64) {
        for (parameter, is_rate) in self.stamped.clocks() {
            let with = objective.context.layout.parameters[parameter];
            objective.add_pair(with, at, if is_rate { square * by_rate } else { square });
        }
    }

    fn end(&self, objective: &mut Objective) {
        let (stamped, layout) = (self.stamped, objective.context.layout);
        if stamped.problem.times_are_unknown() {
            let arc = stamped.arc;
            self.between
                .end(|node, terms| objective.add_node(arc, node, terms));
        }
        for (number, (parameter, is_rate)) in stamped.clocks().enumerate() {
            let at = layout.parameters[parameter];
            objective.add_time(stamped.arc, at, &self.clock[usize::from(is_rate)]);
            for (earlier, of_rate) in stamped.clocks().take(number) {
                let value = match (is_rate, of_rate) {
                    (true, true) => self.clock[1].square,
                    (false, false) => self.clock[0].square,
                    _ => self.both,
                };
                objective.add_pair(at, layout.parameters[earlier], value);
            }
        }
    }
}

impl Objective<'_> {
    /// Adds the residuals of a view for which the short forms serve.
    pub(in crate::estimate) fn add_short(
        &mut self,
        index: usize,
        view: &View,
        body: &Body,
        gravity_m_s2: &Vector3<f64>,
    ) {
        let (problem, point) = (self.context.problem, self.point);
        let (state, epoch_s) = (&point.arcs[index], self.context.epochs_s[index]);
        let at = self.context.layout.arcs[index];
        let stride = self.guidance.stride(view);
        let stamped = Stamped::new(problem, index, view, self.point);
        let time_s = |sample: &ArcSample| stamped.time_s(sample);
        let mut by_times = ByTimes::new(&stamped, stride);
        let each = |sample: &ArcSample, terms: &TimeTerms| by_times.add(self, sample, terms);
        let weights = &view.informations;
        if problem.has_no_lever(view) && weights.is_empty() {
            let (of, flight) = ((view, stride), (state, epoch_s));
            let omega = &state.angular_velocity_rad_s;
            let spin = &mut point.kept.spin(body, omega).spin;
            let terms = samples::unknown_times(body, of, flight, spin, gravity_m_s2, time_s, each);
            self.add_arc(at, &terms);
            by_times.end(self);
            return;
        }
        let along = Along {
            samples: &view.samples,
            stride,
            body,
            gravity_m_s2,
            state,
            epoch_s,
        };
        let each = stamped.depends.then_some(each);
        let mount_m = problem.mounts[view.track].translation.vector;
        // From the place that a sample tells to the place whose covariance is meant.
        let told_m = match view.shows {
            Shows::Pose => mount_m,
            _ => Vector3::zeros(),
        };
        let counts = view.units.map(|unit| 1.0 / (unit * unit));
        let has_lever = view.shows.kinds()[0] && mount_m != Vector3::zeros();
        let terms = match view.shows {
            Shows::Direction(axis) => {
                let rows = |four: &Four| Lever::direction(four, &axis, counts[1]);
                along.terms(time_s, rows, each)
            }
            Shows::Point if weights.is_empty() => {
                let rows = |four: &Four| Lever::point(four, &mount_m, counts[0]);
                along.terms(time_s, rows, each)
            }
            _ if has_lever || !are_apart(weights) => {
                let rows = |four: &Four| Weighed::<true>::new(four, weights, &mount_m, &told_m);
                along.terms(time_s, rows, each)
            }
            _ => {
                let rows = |four: &Four| Weighed::<false>::new(four, weights, &mount_m, &told_m);
                along.terms(time_s, rows, each)
            }
        };
        self.add_state(at, &terms);
        by_times.end(self);
    }
}
