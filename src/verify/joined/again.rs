//! The motion of joined bodies once more from its first state alone, with steps of half the length: through impacts
//! by their law, at the times that were estimated.

use super::larger;
use crate::motion::{Estimate, JointTree, Scene, TreeEstimate, TreeTouch};
use crate::physics::tree::{Flow, Snapshot, Tree, TreeState, tableau};

/// How far off the motion is, at most.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Off {
    /// A link's centre, at any state of the estimate, from where this one has it \[m\].
    pub(super) position_m: f64,
    /// The contact of an impact from touching \[m\].
    pub(super) gap_m: f64,
    /// How fast the contact of an impact recedes before it [m/s].
    pub(super) receding_m_s: f64,
    /// What an impact gains of kinetic energy, of that before.
    pub(super) energy: f64,
}

/// Distances of the estimate from the motion done again. What is not finite is infinitely far.
pub(super) fn off(
    (scene, joined, tree): (&Scene, &JointTree, &Tree),
    estimate: &Estimate,
    motion: &TreeEstimate,
) -> Off {
    let mut off = Off::default();
    let [first, rest @ ..] = motion.knots.as_slice() else {
        return off;
    };
    let gravity_m_s2 = &estimate.gravity_m_s2;
    let mut flow = Flow::new(tree, gravity_m_s2, tableau::DORMAND_PRINCE);
    flow.begin(&first.state, false);
    let mut snapshot = Snapshot::new(tree, gravity_m_s2);
    let mut touches = touches(scene, joined, estimate).into_iter().peekable();
    let mut now_s = first.time_s;
    for knot in rest {
        if let Some((_, touch)) = touches.next_if(|(time_s, _)| {
            // The second state at the time of an impact is that after it.
            *time_s == now_s && knot.time_s == now_s
        }) {
            let state = flow.state();
            snapshot.set(&state);
            let at = (touch.place, &touch.contact);
            let Ok(impact) = snapshot.impact(&state, at, &touch.law) else {
                off.gap_m = f64::INFINITY;
                return off;
            };
            let after = TreeState {
                rates: impact.rates,
                ..state
            };
            let before_j = snapshot.kinetic_energy();
            snapshot.set(&after);
            let gained_j = snapshot.kinetic_energy() - before_j;
            off.gap_m = larger(off.gap_m, impact.gap_m.abs());
            off.receding_m_s = larger(off.receding_m_s, impact.speed_m_s);
            off.energy = larger(off.energy, gained_j / before_j);
            flow.begin(&after, false);
        }
        let interval_s = knot.time_s - now_s;
        if interval_s != 0.0 {
            let steps = (interval_s / motion.step_s).ceil().max(1.0) as usize;
            flow.advance(interval_s, 2 * steps);
        }
        now_s = knot.time_s;
        let places = |snapshot: &Snapshot| -> Vec<_> {
            let links = 0..tree.link_count();
            links.map(|of| snapshot.link_state(of).position_m).collect()
        };
        snapshot.set(&knot.state);
        let here = places(&snapshot);
        snapshot.set(&flow.state());
        for (a, b) in here.iter().zip(places(&snapshot)) {
            off.position_m = larger(off.position_m, (a - b).norm());
        }
    }
    if touches.peek().is_some() {
        // An impact that the states of the estimate do not have.
        off.gap_m = f64::INFINITY;
    }
    off
}

/// Impacts by their times, in order.
fn touches(scene: &Scene, joined: &JointTree, estimate: &Estimate) -> Vec<(f64, TreeTouch)> {
    let events = estimate.events.iter();
    let touch = |event: usize| scene.tree_touch(joined, event);
    let touches = events.filter_map(|of| Some((of.time_s, touch(of.event)?)));
    let mut touches: Vec<_> = touches.collect();
    touches.sort_by(|a, b| a.0.total_cmp(&b.0));
    touches
}
