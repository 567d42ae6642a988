//! How certain the states are in which a motion ends.

use nalgebra::{DMatrix, DVector};

use super::{Solved, covariance};
use crate::estimate::covariance::{Covariance, Moment};
use crate::motion::MechanismIndex;
use crate::physics::State;
use crate::physics::state::{DIMENSION, StateTangent};

/// The distribution of a mechanism's state at the epoch of its last flight.
#[derive(Clone, Debug)]
pub struct LastState {
    /// What flies.
    pub mechanism: MechanismIndex,
    mean: State,
    /// `L` with the covariance `L Lᵀ` of the state's tangent.
    root: DMatrix<f64>,
}

impl Solved {
    /// The states at the epochs of the last flights with their covariances ([`Covariance`]); `None` where
    /// a part of one is not determined.
    pub fn last_states(&self) -> Option<Vec<LastState>> {
        let (problem, point) = (&self.posed.problem, &self.solution.point);
        let context = self.posed.context(self.epochs_s.clone(), point);
        let covariance = covariance(&context, &self.solution, self.in_time(&context))?;
        let arcs = problem.arcs.iter().enumerate();
        let is_last = |arc: usize, mechanism: MechanismIndex| {
            let mut later = problem.arcs[arc + 1..].iter();
            later.all(|other| other.mechanism != mechanism)
        };
        let last = arcs.filter(|(arc, of)| is_last(*arc, of.mechanism));
        last.map(|(arc, of)| {
            let unknowns: Vec<usize> = context.layout.state(arc).collect();
            Some(LastState {
                mechanism: of.mechanism,
                mean: point.arcs[arc],
                root: root(&covariance, &unknowns)?,
            })
        })
        .collect()
    }
}

impl LastState {
    /// Number of standard normal numbers that a draw takes.
    pub const NUMBERS: usize = DIMENSION;

    /// The state that standard normal numbers stand for.
    pub fn draw(&self, numbers: &DVector<f64>) -> State {
        let delta = &self.root * numbers;
        self.mean
            .retract(&StateTangent::from_fn(|row, _| delta[row]))
    }
}

/// A root of the covariance of a state's unknowns. Correlations are told by the deviations of sums.
fn root(covariance: &Covariance, unknowns: &[usize]) -> Option<DMatrix<f64>> {
    let count = unknowns.len();
    let own: Vec<Moment> = unknowns.iter().map(|at| vec![(*at, 1.0)]).collect();
    let sds: Option<Vec<f64>> = covariance.sds(&own).into_iter().collect();
    let sds = sds.filter(|sds| count == DIMENSION && sds.iter().all(|sd| *sd > 0.0))?;
    let mut correlation = DMatrix::identity(count, count);
    for row in 0..count {
        let sums = (0..row).map(|column| {
            let of = |at: usize| (unknowns[at], 1.0 / sds[at]);
            vec![of(row), of(column)]
        });
        let sums: Vec<Moment> = sums.collect();
        for (column, sd) in covariance.sds(&sums).into_iter().enumerate() {
            // A sum that is not told is one whose parts cancel.
            let both = sd.map_or(-1.0, |sd| 0.5 * sd * sd - 1.0).clamp(-1.0, 1.0);
            correlation[(row, column)] = both;
            correlation[(column, row)] = both;
        }
    }
    let eigen = correlation.symmetric_eigen();
    let roots = eigen.eigenvalues.map(|value| value.max(0.0).sqrt());
    let sds = DMatrix::from_diagonal(&DVector::from_vec(sds));
    Some(sds * eigen.eigenvectors * DMatrix::from_diagonal(&roots))
}
