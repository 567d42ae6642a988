//! The angular state of a tree as one list of numbers, coordinates before rates, and its derivative by time:
//! what methods other than the program's are given.
//!
//! Of a free tree position and velocity are left out, as the program's flow leaves them out.

use std::ops::Range;

use enact::physics::tree::{Snapshot, Tree, TreeState};
use nalgebra::{Quaternion, Vector3};

use super::cases::Case;

/// What holds the coordinates of a joint.
#[derive(Clone, Debug)]
pub enum Part {
    /// Angles: places among the coordinates, first place among the rates.
    Angles(Range<usize>, usize),
    /// A quaternion `(i, j, k, w)`: first places among both.
    Turn(usize, usize),
}

/// Where everything is in the list.
#[derive(Clone, Debug)]
pub struct Layout {
    /// Joint by joint.
    pub parts: Vec<Part>,
    /// Number of coordinates and of rates.
    pub coordinates: usize,
    pub rates: usize,
    /// How many coordinates and rates of a free base come before.
    pub shift: usize,
}

impl Layout {
    fn of(tree: &Tree) -> Self {
        let shift = tree.translations();
        let (mut parts, mut at) = (Vec::new(), 0);
        for link in 0..tree.link_count() {
            let columns = tree.columns_of(link);
            if columns.is_empty() {
                continue;
            }
            let rate = columns.start - shift;
            let count = match tree.angles_of(link) {
                Some(_) => {
                    parts.push(Part::Angles(at..at + columns.len(), rate));
                    columns.len()
                }
                None => {
                    parts.push(Part::Turn(at, rate));
                    4
                }
            };
            at += count;
        }
        Self {
            parts,
            coordinates: at,
            rates: tree.freedoms() - shift,
            shift,
        }
    }

    /// Makes the quaternions unit.
    pub fn normalise(&self, y: &mut [f64]) {
        for part in &self.parts {
            if let Part::Turn(at, _) = part {
                let q = &mut y[*at..at + 4];
                let norm = q.iter().map(|x| x * x).sum::<f64>().sqrt();
                q.iter_mut().for_each(|x| *x /= norm);
            }
        }
    }
}

/// `Q ω` for quaternions `(i, j, k, w)`.
pub fn times_rate(q: &[f64], omega: &[f64]) -> [f64; 4] {
    let q = Quaternion::new(q[3], q[0], q[1], q[2]);
    let product = q * Quaternion::from_imag(Vector3::from_column_slice(&omega[..3]));
    product.coords.into()
}

/// The vector field, which counts how often it is asked.
pub struct System<'c> {
    /// Where everything is.
    pub layout: Layout,
    /// Number of evaluations.
    pub count: usize,
    snapshot: Snapshot<'c>,
    state: TreeState,
    accelerations: Vec<f64>,
}

impl<'c> System<'c> {
    /// That of a case.
    pub fn new(case: &'c Case) -> Self {
        Self {
            layout: Layout::of(&case.tree),
            count: 0,
            snapshot: Snapshot::new(&case.tree, &case.gravity_m_s2),
            state: case.tree.at_rest(),
            accelerations: vec![0.0; case.tree.freedoms()],
        }
    }

    /// The list of a state.
    pub fn list(&self, state: &TreeState) -> Vec<f64> {
        let shift = self.layout.shift;
        [&state.coordinates[shift..], &state.rates[shift..]].concat()
    }

    /// The state of a list, a free base's position and velocity zero.
    pub fn state(&self, y: &[f64]) -> TreeState {
        let mut state = self.state.clone();
        let (coordinates, rates) = y.split_at(self.layout.coordinates);
        state.coordinates[self.layout.shift..].copy_from_slice(coordinates);
        state.rates[self.layout.shift..].copy_from_slice(rates);
        state
    }

    /// Derivatives of the rates.
    pub fn accelerate(&mut self, y: &[f64], slope: &mut [f64]) {
        self.count += 1;
        let (shift, split) = (self.layout.shift, self.layout.coordinates);
        self.state.coordinates[shift..].copy_from_slice(&y[..split]);
        self.state.rates[shift..].copy_from_slice(&y[split..]);
        self.snapshot.set(&self.state);
        self.snapshot.accelerations(&mut self.accelerations);
        slope.copy_from_slice(&self.accelerations[shift..]);
    }

    /// Derivatives of everything, quaternions as points of four numbers.
    pub fn slope(&mut self, y: &[f64], slope: &mut [f64]) {
        let split = self.layout.coordinates;
        let (by_coordinates, by_rates) = slope.split_at_mut(split);
        let rates = &y[split..];
        for part in &self.layout.parts {
            match part {
                Part::Angles(places, rate) => by_coordinates[places.clone()]
                    .copy_from_slice(&rates[*rate..rate + places.len()]),
                Part::Turn(at, rate) => {
                    let product = times_rate(&y[*at..at + 4], &rates[*rate..]);
                    for (to, from) in by_coordinates[*at..at + 4].iter_mut().zip(product) {
                        *to = 0.5 * from;
                    }
                }
            }
        }
        self.accelerate(y, by_rates);
    }
}
