//! Energy of joined bodies between impacts: what nothing damps or drives keeps it.

use crate::motion::{Estimate, Scene, TreeEstimate};
use crate::physics::tree::Snapshot;

/// Height \[m\] by which a tree that hardly moves may be lifted: rounding changes the energy of one that hangs still by more than
/// it moves with.
const LIFTED_M: f64 = 1e-6;

/// Largest change of the energy of a tree between two impacts of any, relative to its largest kinetic energy there, or to what
/// lifts it by [`LIFTED_M`] if that is more; of trees that [keep](crate::physics::tree::Tree::keeps_energy) it.
pub(super) fn largest_change(scene: &Scene, estimate: &Estimate) -> f64 {
    let changes = estimate.trees.iter().map(|of| change(scene, estimate, of));
    changes.flatten().fold(0.0, f64::max)
}

fn change(scene: &Scene, estimate: &Estimate, motion: &TreeEstimate) -> Option<f64> {
    let tree = scene.tree_model_with(scene.joint_tree(motion.mechanism)?, &estimate.held);
    if !tree.keeps_energy() {
        return None;
    }
    let mut snapshot = Snapshot::new(&tree, &estimate.gravity_m_s2);
    let mut energies_j = |knot: &crate::motion::TreeKnot| {
        snapshot.set(&knot.state);
        [snapshot.energy(0.0), snapshot.kinetic_energy()]
    };
    let lifted_j = tree.mass_kg() * estimate.gravity_m_s2.norm() * LIFTED_M;
    // Two states at one time are those on either side of an impact.
    let flights = motion
        .knots
        .chunk_by(|before, after| before.time_s != after.time_s);
    let changes = flights.map(|flight| {
        let energies: Vec<[f64; 2]> = flight.iter().map(&mut energies_j).collect();
        let greatest_j = energies
            .iter()
            .map(|[_, kinetic_j]| *kinetic_j)
            .fold(lifted_j, f64::max);
        let off_j = energies
            .iter()
            .map(|[energy_j, _]| (energy_j - energies[0][0]).abs());
        let most_j = off_j.fold(0.0, f64::max);
        if greatest_j > 0.0 {
            most_j / greatest_j
        } else {
            0.0
        }
    });
    changes.reduce(f64::max)
}
