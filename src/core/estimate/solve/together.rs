//! How the numbers of a motion vary together.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector};

use super::{Solved, covariance, deviation};
use crate::estimate::covariance::{Moment, timing};
use crate::motion::{AtBound, MotionPart, Scene, Verdict};

/// Covariances of numbers by their names. What is fixed varies by nothing; of what is not determined it is not a number.
#[derive(Clone, Debug, PartialEq)]
pub struct VariedTogether {
    /// Of events, times \[s\]; of parameters, in their units; of the state of each flight at its epoch, such as
    /// `die.flight.2.velocity.z`: of the centre of mass and about the principal axes, SI.
    pub names: Vec<String>,
    /// A row and a column for each of them.
    pub covariance: DMatrix<f64>,
}

/// A number as a linear combination of unknowns.
struct VariedNumber {
    name: String,
    moment: Moment,
    at_bound: Option<AtBound>,
    /// Whether it is told how certain it is.
    is_told: bool,
}

impl Solved {
    /// The covariances of all numbers of which a standard deviation is told, and of the states; `None` where the motion
    /// failed, or their matrix cannot be factorised.
    pub fn varied_together(&self, scene: &Scene) -> Option<VariedTogether> {
        if self.estimate.verdict == Verdict::Failed {
            return None;
        }
        let (point, context) = (&self.solution.point, self.context());
        let known = covariance(&context, &self.solution, self.in_time(&context))?;
        let mut told = self.estimate.clone();
        deviation::fill(&mut told, scene, &context, &self.solution, Some(&known));
        let events = told.events.iter().map(|event| VariedNumber {
            name: scene.events[event.event].name.clone(),
            moment: match event.is_fixed {
                true => Moment::new(),
                false => timing::event_moment(&context, point, event.event),
            },
            at_bound: event.at_bound,
            is_told: event.is_fixed || event.sd_s.is_some(),
        });
        let unknowns = context.layout.parameters.iter();
        let parameters = told.parameters.iter().zip(unknowns);
        let parameters = parameters.map(|(parameter, at)| VariedNumber {
            name: parameter.name.clone(),
            moment: vec![(*at, 1.0)],
            at_bound: parameter.at_bound,
            is_told: parameter.sd.is_some(),
        });
        let arcs = self.posed.problem.arcs.iter().enumerate();
        let mut flights = BTreeMap::new();
        let states = arcs.flat_map(|(index, arc)| {
            let flight = flights.entry(arc.mechanism).or_insert(0);
            *flight += 1;
            let stem = format!("{}.flight.{flight}", scene.name_of_mechanism(arc.mechanism));
            let state = context.layout.state(index).enumerate();
            let state = state.map(move |(at, unknown)| {
                let part = MotionPart::ALL[at / 3].as_str();
                let axis = ["x", "y", "z"][at % 3];
                (format!("{stem}.{part}.{axis}"), vec![(unknown, 1.0)])
            });
            state.collect::<Vec<_>>()
        });
        let states: Vec<(String, Moment)> = states.collect();
        let moments: Vec<Moment> = states.iter().map(|of| of.1.clone()).collect();
        let states = states.into_iter().zip(known.sds(&moments));
        let states = states.map(|((name, moment), sd)| VariedNumber {
            name,
            moment,
            at_bound: None,
            is_told: sd.is_some(),
        });
        let numbers: Vec<VariedNumber> = events.chain(parameters).chain(states).collect();
        let of_all = numbers.iter().flat_map(|of| &of.moment);
        let mut places: BTreeMap<usize, usize> = of_all.map(|(at, _)| (*at, 0)).collect();
        for (place, of) in places.values_mut().enumerate() {
            *of = place;
        }
        let unknowns: Vec<usize> = places.keys().copied().collect();
        let variance = known.jointly(&unknowns);
        let mut sums: DMatrix<f64> = DMatrix::zeros(numbers.len(), unknowns.len());
        let mut beyond: DVector<f64> = DVector::zeros(numbers.len());
        for (row, number) in numbers.iter().enumerate() {
            for (at, factor) in &number.moment {
                sums[(row, places[at])] += factor;
            }
            if number.at_bound.is_some() {
                beyond[row] = known.beyond_bounds(&number.moment);
            }
        }
        let mut all = &sums * (variance.errors + variance.priors) * sums.transpose();
        all += &beyond * beyond.transpose();
        for (at, _) in numbers.iter().enumerate().filter(|(_, of)| !of.is_told) {
            all.row_mut(at).fill(f64::NAN);
            all.column_mut(at).fill(f64::NAN);
        }
        Some(VariedTogether {
            names: numbers.into_iter().map(|of| of.name).collect(),
            covariance: all,
        })
    }
}
