//! Mechanisms at random, and the file in which they go to peers (`tools/peers/README.md`).

use enact::math::Pose;
use enact::physics::Body;
use enact::physics::tree::{Joint, JointKind, Link, Snapshot, Tree, TreeState};
use enact_tools::mechanism_file;
use nalgebra::{UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::{Value, json};

/// Which joints.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Joints {
    /// Pins in a row.
    Pin,
    /// Universal joints in a row.
    Universal,
    /// Balls in a row.
    Ball,
    /// All of these by chance, on links by chance: branches.
    Mixed,
}

/// All of them.
pub const JOINTS: [Joints; 4] = [Joints::Pin, Joints::Universal, Joints::Ball, Joints::Mixed];

/// What is drawn.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// Whether the first link flies.
    pub is_free: bool,
    /// Joints of the others, and of the first where it is clamped.
    pub joints: Joints,
    /// Number of links.
    pub links: usize,
    /// Length of a link \[m\].
    pub size_m: f64,
}

/// A mechanism in a state.
pub struct Mechanism {
    /// As it was drawn.
    pub row: Row,
    /// Its links.
    pub links: Vec<Link>,
    /// The same as the program's tree.
    pub tree: Tree,
    /// Where it is.
    pub state: TreeState,
    /// How long it is to go on; none: not at all \[s\].
    pub flight_s: Option<f64>,
}

/// Gravity [m/s²], along no axis.
pub const GRAVITY_M_S2: Vector3<f64> = Vector3::new(0.3, -0.2, -9.81);
/// Rods of this length fly for a second, others as long by their own measure of time \[m\].
const USUAL_M: f64 = 0.2;

struct Chance(ChaCha8Rng);

impl Chance {
    fn signed(&mut self, most: f64) -> f64 {
        most * (2.0 * self.0.random::<f64>() - 1.0)
    }

    fn vector(&mut self, most: f64) -> Vector3<f64> {
        Vector3::from_fn(|_, _| self.signed(most))
    }

    /// At a place, turned by up to some two radians.
    fn pose(&mut self, at_m: Vector3<f64>) -> Pose {
        let turn = UnitQuaternion::from_scaled_axis(self.vector(1.2));
        Pose::from_parts(at_m.into(), turn)
    }

    fn kind(&mut self, joints: Joints) -> JointKind {
        let joints = match joints {
            Joints::Mixed => JOINTS[self.0.random_range(0..3)],
            same => same,
        };
        match joints {
            Joints::Pin => JointKind::Pin {
                axis: self.vector(1.0),
            },
            Joints::Universal => JointKind::Universal {
                axes: [self.vector(1.0), self.vector(1.0)],
            },
            _ => JointKind::Ball,
        }
    }

    /// Bricks: half extents a tenth to one half of the length, masses as their volumes.
    fn body(&mut self, size_m: f64) -> Body {
        let thick = [self.signed(0.1), self.signed(0.1)].map(|part| 0.2 + part);
        let [a, b, c] = [0.5, thick[0], thick[1]].map(|half| (half * size_m).powi(2));
        let mass_kg = 800.0 * 8.0 * (a * b * c).sqrt();
        let moments_kg_m2 = Vector3::new(b + a, a + c, b + c) * (mass_kg / 3.0);
        Body::new(mass_kg, moments_kg_m2).expect("a brick is a body")
    }
}

impl Mechanism {
    /// Draws it; a seed and a number of a row give the same one everywhere.
    pub fn draw(row: Row, seed: u64, number: u64) -> Self {
        let mut chance = ChaCha8Rng::seed_from_u64(seed);
        chance.set_stream(number);
        let mut chance = Chance(chance);
        let half_m = Vector3::z() * (0.5 * row.size_m);
        let links: Vec<Link> = (0..row.links)
            .map(|index| {
                let parent = match row.joints {
                    Joints::Mixed if index > 1 => Some(chance.0.random_range(0..index)),
                    _ => index.checked_sub(1),
                };
                let kind = match index {
                    0 if row.is_free => JointKind::Free,
                    _ => chance.kind(row.joints),
                };
                let off_m = chance.vector(0.1 * row.size_m);
                let hung = chance.pose(off_m - half_m);
                let joint = Joint::new(kind, hung, chance.pose(half_m));
                let body = chance.body(row.size_m);
                Link {
                    parent,
                    joint,
                    body,
                }
            })
            .collect();
        let tree = Tree::new(&links).expect("a tree");
        let [coordinate_units, rate_units] = units(&row, &tree);
        let mut delta: Vec<f64> = coordinate_units
            .iter()
            .map(|u| u * chance.signed(1.5))
            .collect();
        delta.extend(rate_units.iter().map(|u| u * chance.signed(1.0)));
        let state = tree.retract(&tree.at_rest(), &delta);
        Self {
            row,
            links,
            tree,
            state,
            flight_s: None,
        }
    }

    /// One that flies, for a second or as long by its own measure.
    pub fn flying(self) -> Self {
        Self {
            flight_s: Some((self.row.size_m / USUAL_M).sqrt()),
            ..self
        }
    }

    /// At its state.
    pub fn snapshot(&self) -> Snapshot<'_> {
        let mut snapshot = Snapshot::new(&self.tree, &GRAVITY_M_S2);
        snapshot.set(&self.state);
        snapshot
    }

    /// Natural units of the coordinates' tangent and of the rates: lengths of links, radians, and both over the
    /// time in which a link falls its length.
    pub fn units(&self) -> [Vec<f64>; 2] {
        units(&self.row, &self.tree)
    }

    /// The file.
    pub fn file(&self) -> Value {
        let [tangent_units, rate_units] = self.units();
        let coordinates = self.tree.coordinate_count();
        let shift = if self.row.is_free { 3 } else { 0 };
        let unit = |at: usize| if at < shift { self.row.size_m } else { 1.0 };
        json!({
            "format": "enact mechanism 1",
            "gravity_m_s2": GRAVITY_M_S2.as_slice(),
            "links": mechanism_file::links(&self.links),
            "state": {"coordinates": self.state.coordinates, "rates": self.state.rates},
            "flight_s": self.flight_s,
            "coordinate_units": (0..coordinates).map(unit).collect::<Vec<_>>(),
            "tangent_units": tangent_units,
            "rate_units": rate_units,
        })
    }
}

fn units(row: &Row, tree: &Tree) -> [Vec<f64>; 2] {
    let per_s = (GRAVITY_M_S2.norm() / row.size_m).sqrt();
    let shift = tree.translations();
    let unit = |at: usize| if at < shift { row.size_m } else { 1.0 };
    let coordinates: Vec<f64> = (0..tree.freedoms()).map(unit).collect();
    let rates = coordinates.iter().map(|unit| unit * per_s).collect();
    [coordinates, rates]
}
