//! How far peers and the program are apart, in natural units of the mechanism.

use enact::physics::tree::{Flow, TreeState, tableau};
use nalgebra::{DMatrix, SymmetricEigen};
use serde::{Deserialize, Serialize};

use super::draw::{GRAVITY_M_S2, Mechanism};

/// Steps of a flight, and of one with derivatives, which need not be as exact.
const STEPS: usize = 16384;
const DERIVED: usize = 1024;

/// What a peer says of a mechanism, in the file's coordinates.
#[derive(Clone, Debug, Deserialize)]
pub struct Answer {
    /// Who.
    pub peer: String,
    accelerations: Vec<f64>,
    by_coordinates: Vec<Vec<f64>>,
    by_rates: Vec<Vec<f64>>,
    energy_j: f64,
    end: Option<End>,
}

#[derive(Clone, Debug, Deserialize)]
struct End {
    coordinates: Vec<f64>,
    rates: Vec<f64>,
}

impl End {
    fn state(&self) -> TreeState {
        TreeState {
            coordinates: self.coordinates.clone(),
            rates: self.rates.clone(),
            time_s: 0.0,
        }
    }
}

/// What the program says, in natural units.
pub struct Ours<'m> {
    mechanism: &'m Mechanism,
    accelerations: Vec<f64>,
    derivatives: DMatrix<f64>,
    energy_j: f64,
    energy_unit_j: f64,
    end: Option<TreeState>,
    /// Greatest over least eigenvalue of the mass matrix.
    pub condition: f64,
    /// How far a flight in half as many steps ends from it, in units.
    pub end_in_half: Option<f64>,
    /// What half a rounding of every number of the start makes of the end.
    pub end_by_rounding: Option<f64>,
}

/// Differences, relative to the greatest number of their kind.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Apart {
    /// `u̇`.
    pub accelerations: f64,
    /// `∂u̇/∂q`.
    pub by_coordinates: f64,
    /// `∂u̇/∂u`.
    pub by_rates: f64,
    /// Energy, over the kinetic one.
    pub energy: f64,
    /// State at the end of a flight, in units: no relative one.
    pub end: Option<f64>,
}

impl<'m> Ours<'m> {
    /// All of it.
    pub fn of(mechanism: &'m Mechanism) -> Self {
        let tree = &mechanism.tree;
        let freedoms = tree.freedoms();
        let mut snapshot = mechanism.snapshot();
        let mut accelerations = vec![0.0; freedoms];
        snapshot.accelerations(&mut accelerations);
        let mut derivatives = DMatrix::zeros(freedoms, 2 * freedoms);
        snapshot.acceleration_derivatives(&mut derivatives);
        let mut mass = DMatrix::zeros(freedoms, freedoms);
        snapshot.mass_matrix(&mut mass);
        let rates = nalgebra::DVector::from_vec(mechanism.state.rates.clone());
        let kinetic_j = 0.5 * rates.dot(&(&mass * &rates));
        let [units, _] = mechanism.units();
        for (row, column) in (0..freedoms).flat_map(|i| (0..freedoms).map(move |j| (i, j))) {
            mass[(row, column)] *= units[row] * units[column];
        }
        let eigenvalues = SymmetricEigen::new(mass).eigenvalues;
        let mut ours = Self {
            mechanism,
            accelerations,
            derivatives,
            energy_j: snapshot.energy(0.0),
            energy_unit_j: kinetic_j,
            end: None,
            condition: eigenvalues.max() / eigenvalues.min(),
            end_in_half: None,
            end_by_rounding: None,
        };
        if let Some(flight_s) = mechanism.flight_s {
            ours.fly(flight_s);
        }
        ours
    }

    fn fly(&mut self, flight_s: f64) {
        let (tree, state) = (&self.mechanism.tree, &self.mechanism.state);
        let mut flow = Flow::new(tree, &GRAVITY_M_S2, tableau::DORMAND_PRINCE);
        let mut end = |steps: usize| {
            flow.begin(state, false);
            flow.advance(flight_s, steps);
            flow.state()
        };
        let (whole, half) = (end(STEPS), end(STEPS / 2));
        self.end_in_half = Some(self.ends_differ(&whole, &half));
        self.end = Some(whole);
        flow.begin(state, true);
        flow.advance(flight_s, DERIVED);
        let size = 2 * tree.freedoms();
        let mut by_start = DMatrix::zeros(size, size);
        flow.jacobian(&mut by_start);
        let units = self.mechanism.units().concat();
        let moved = |row: usize| {
            let parts = (0..size).map(|column| {
                let by = by_start[(row, column)] * units[column] / units[row];
                (0.5 * f64::EPSILON * by).powi(2)
            });
            parts.sum::<f64>().sqrt()
        };
        self.end_by_rounding = Some((0..size).map(moved).fold(0.0, f64::max));
    }

    /// How far a peer's answer is off; what is no number is infinitely far.
    pub fn apart(&self, answer: &Answer) -> Apart {
        let freedoms = self.mechanism.tree.freedoms();
        let [coordinates, rates] = self.mechanism.units();
        let greatest = |pairs: &mut dyn Iterator<Item = (f64, f64)>| {
            let (mut off, mut size) = (0.0_f64, 0.0_f64);
            for (ours, theirs) in pairs {
                let apart = (ours - theirs).abs();
                off = off.max(if apart.is_nan() { f64::INFINITY } else { apart });
                size = size.max(ours.abs());
            }
            off / size
        };
        let accelerations = (0..freedoms).map(|row| {
            let pair = (self.accelerations[row], answer.accelerations[row]);
            (pair.0 / coordinates[row], pair.1 / coordinates[row])
        });
        let table = |theirs: &[Vec<f64>], from: usize, units: &[f64]| {
            let entry = |row: usize, column: usize| {
                let unit = units[column] / coordinates[row];
                let ours = self.derivatives[(row, from + column)];
                (ours * unit, theirs[row][column] * unit)
            };
            greatest(&mut (0..freedoms).flat_map(|i| (0..freedoms).map(move |j| entry(i, j))))
        };
        let end = self.end.as_ref().zip(answer.end.as_ref());
        Apart {
            accelerations: greatest(&mut accelerations.into_iter()),
            by_coordinates: table(&answer.by_coordinates, 0, &coordinates),
            by_rates: table(&answer.by_rates, freedoms, &rates),
            energy: (self.energy_j - answer.energy_j).abs() / self.energy_unit_j,
            end: end.map(|(ours, theirs)| self.ends_differ(ours, &theirs.state())),
        }
    }

    fn ends_differ(&self, ours: &TreeState, theirs: &TreeState) -> f64 {
        let units = self.mechanism.units().concat();
        let delta = self.mechanism.tree.minus(theirs, ours);
        let parts = delta
            .iter()
            .zip(&units)
            .map(|(part, unit)| (part / unit).abs());
        parts.fold(
            0.0,
            |a, b| if b.is_nan() { f64::INFINITY } else { a.max(b) },
        )
    }
}
