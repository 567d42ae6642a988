//! The motions.

use enact::physics::tree::tableau::Tableau;
use enact::physics::tree::{Flow, Snapshot, Tree, TreeState};
use enact_tools::trees::{Jointed, Kind, ROD_M, TreeActing, perform};
use nalgebra::Vector3;

/// Greatest rate of the usual starts and of the fast ones [rad/s].
const USUAL_RAD_S: f64 = 4.0;
const FAST_RAD_S: f64 = 30.0;

/// What moves.
#[derive(Clone, Copy)]
pub struct Kinds {
    /// In files.
    pub name: &'static str,
    /// In words.
    pub title: &'static str,
    kind: Kind,
    is_fast: bool,
}

/// All of them.
pub fn all() -> Vec<Kinds> {
    use Jointed::{Ball, Pin, Universal};
    let usual = |name, title, kind| Kinds {
        name,
        title,
        kind,
        is_fast: false,
    };
    let pendulum = Kind::pendulum;
    let mut all = vec![
        usual("chain", "the chain", Kind::CHAIN),
        usual("pin_2", "pendulum of 2, pins", pendulum(2, Pin)),
        usual("pin_3", "pendulum of 3, pins", pendulum(3, Pin)),
        usual("pin_5", "pendulum of 5, pins", pendulum(5, Pin)),
        usual("pin_8", "pendulum of 8, pins", pendulum(8, Pin)),
        usual(
            "universal_2",
            "pendulum of 2, universal",
            pendulum(2, Universal),
        ),
        usual(
            "universal_3",
            "pendulum of 3, universal",
            pendulum(3, Universal),
        ),
        usual(
            "universal_5",
            "pendulum of 5, universal",
            pendulum(5, Universal),
        ),
        usual(
            "universal_8",
            "pendulum of 8, universal",
            pendulum(8, Universal),
        ),
        usual("ball_2", "pendulum of 2, balls", pendulum(2, Ball)),
        usual("ball_3", "pendulum of 3, balls", pendulum(3, Ball)),
        usual("ball_5", "pendulum of 5, balls", pendulum(5, Ball)),
        usual("ball_8", "pendulum of 8, balls", pendulum(8, Ball)),
    ];
    let fast = |name, title, kind| Kinds {
        name,
        title,
        kind,
        is_fast: true,
    };
    all.push(fast("chain_fast", "the chain, fast", Kind::CHAIN));
    all.push(fast(
        "ball_3_fast",
        "pendulum of 3, balls, fast",
        pendulum(3, Ball),
    ));
    all
}

/// A motion from its start.
pub struct Case {
    /// The tree.
    pub tree: Tree,
    /// [m/s²]
    pub gravity_m_s2: Vector3<f64>,
    /// Where it begins.
    pub start: TreeState,
    /// How long it lasts \[s\].
    pub duration_s: f64,
}

impl Kinds {
    /// The motion of a seed: the one that is performed, or with faster rates.
    pub fn case(&self, seed: u64) -> Case {
        let performance = perform(&self.kind, &TreeActing::of(1.0), seed);
        let tree = performance.tree();
        let mut start = performance.truth.clone();
        if self.is_fast {
            let shift = tree.translations();
            for rate in &mut start.rates[shift..] {
                *rate *= FAST_RAD_S / USUAL_RAD_S;
            }
        }
        Case {
            tree,
            gravity_m_s2: performance.scene.gravity_m_s2,
            start,
            duration_s: self.kind.duration_s,
        }
    }
}

impl Case {
    /// The end by the program's flow.
    pub fn flown(&self, tableau: Tableau, steps: usize) -> TreeState {
        let mut flow = Flow::new(&self.tree, &self.gravity_m_s2, tableau);
        flow.begin(&self.start, false);
        flow.advance(self.duration_s, steps);
        flow.state()
    }

    /// Energy that the motion keeps, gravity's included, and the kinetic one now \[J\]: of a free tree about its centre of
    /// mass, where both are one.
    pub fn energy_j(&self, state: &TreeState) -> [f64; 2] {
        let with = |gravity_m_s2: &Vector3<f64>| {
            let mut snapshot = Snapshot::new(&self.tree, gravity_m_s2);
            snapshot.set(state);
            (snapshot.energy(0.0), snapshot.momentum().1)
        };
        let (kinetic_j, momentum) = with(&Vector3::zeros());
        if self.tree.translations() > 0 {
            let about_j = kinetic_j - 0.5 * momentum.norm_squared() / self.tree.mass_kg();
            return [about_j; 2];
        }
        [with(&self.gravity_m_s2).0, kinetic_j]
    }

    /// How far a list is from another: the greatest difference of an angle \[rad\], or of a rate in units of the rate at
    /// which a rod falls its length.
    pub fn apart(&self, state: &TreeState, other: &TreeState) -> f64 {
        let freedoms = self.tree.freedoms();
        let shift = self.tree.translations();
        let per_s = (self.gravity_m_s2.norm() / ROD_M).sqrt();
        let delta = self.tree.minus(state, other);
        let (coordinates, rates) = delta.split_at(freedoms);
        let angles = coordinates[shift..].iter().map(|part| part.abs());
        let rates = rates[shift..].iter().map(|part| part.abs() / per_s);
        let worst = |a: f64, b: f64| if b.is_nan() { f64::INFINITY } else { a.max(b) };
        angles.chain(rates).fold(0.0, worst)
    }
}
