//! The flow's derivatives are those of its steps.

use nalgebra::{DMatrix, DVector};

use super::examples::{GRAVITY, PIN, chain, off, rods, some_state, trees};
use crate::math::random::Random;
use crate::physics::tree::tableau::{BUTCHER, DORMAND_PRINCE, Tableau};
use crate::physics::tree::{Flow, Snapshot, Tree, TreeState};

/// Coarse steps, so that the discrete map is not the continuous one: 5e-9 of the greatest entry,
/// which differences give.
#[test]
fn derivatives_of_the_flow_are_those_of_its_steps() {
    let mut random = Random::default();
    for (name, tree) in trees() {
        for tableau in [BUTCHER, DORMAND_PRINCE] {
            let state = some_state(&tree, &mut random, 1.0, 3.0);
            let size = 2 * tree.freedoms();
            let mut flow = Flow::new(&tree, &GRAVITY, tableau);
            let mut exact = DMatrix::zeros(size, size + 1);
            flow.begin(&state, true);
            flow.advance(0.05, 2, -1.0);
            flow.advance(0.03, 1, 0.5);
            let end = flow.state();
            flow.jacobian(&mut exact);
            let off = off(&exact, |delta| {
                let mut flow = Flow::new(&tree, &GRAVITY, tableau);
                flow.begin(&tree.retract(&state, &delta[..size]), false);
                let time = delta[size];
                flow.advance(0.05 - time, 2, 0.0);
                flow.advance(0.03 + 0.5 * time, 1, 0.0);
                tree.minus(&flow.state(), &end)
            });
            assert!(off < 5e-9, "{name} {}: {off:e}", tableau.b.len());
        }
    }
}

/// Halved steps divide the error by two to the order.
#[test]
fn methods_have_their_order() {
    let tree = Tree::new(&rods(3, PIN, PIN)).unwrap();
    let state = some_state(&tree, &mut Random::default(), 0.7, 5.0);
    let after = |tableau: Tableau, steps: usize| {
        let mut flow = Flow::new(&tree, &GRAVITY, tableau);
        flow.begin(&state, false);
        flow.advance(0.3, steps, 0.0);
        flow.state()
    };
    let exact = after(DORMAND_PRINCE, 1000);
    for (tableau, steps) in [(BUTCHER, 100), (DORMAND_PRINCE, 30)] {
        let [coarse, fine] = [steps, 2 * steps].map(|steps| {
            let off = tree.minus(&after(tableau, steps), &exact);
            off.iter().map(|x| x * x).sum::<f64>().sqrt()
        });
        let order = (coarse / fine).log2();
        let wanted = f64::from(tableau.order);
        assert!(
            order > wanted - 0.5 && order < wanted + 2.5,
            "{wanted}: {order}"
        );
    }
}

/// A duration of zero changes nothing and has the state's rate as its derivative.
#[test]
fn no_time_is_no_motion() {
    let tree = chain();
    let state = some_state(&tree, &mut Random::default(), 1.0, 3.0);
    let freedoms = tree.freedoms();
    let mut flow = Flow::new(&tree, &GRAVITY, DORMAND_PRINCE);
    flow.begin(&state, true);
    flow.advance(0.0, 1, 1.0);
    let mut jacobian = DMatrix::zeros(2 * freedoms, 2 * freedoms + 1);
    flow.jacobian(&mut jacobian);
    let unit = jacobian.columns(0, 2 * freedoms) - DMatrix::identity(2 * freedoms, 2 * freedoms);
    assert!(unit.amax() < 1e-15, "{unit}");
    let mut rate = state.rates.clone();
    rate.resize(2 * freedoms, 0.0);
    let mut snapshot = Snapshot::new(&tree, &GRAVITY);
    snapshot.set(&state);
    snapshot.accelerations(&mut rate[freedoms..]);
    let off = jacobian.column(2 * freedoms) - DVector::from_vec(rate);
    assert!(off.amax() < 1e-11, "{off}");
}

/// Steps chosen for a tolerance keep it, and one doubling fewer would not.
#[test]
fn chosen_steps_keep_the_tolerance() {
    let mut random = Random::default();
    for (name, tree) in trees() {
        let state = some_state(&tree, &mut random, 1.0, 6.0);
        let mut flow = Flow::new(&tree, &GRAVITY, DORMAND_PRINCE);
        let mut after = |steps: usize| {
            flow.begin(&state, false);
            flow.advance(0.1, steps, 0.0);
            flow.state()
        };
        let exact = after(200);
        for tolerance in [1e-4, 1e-8] {
            let mut other = Flow::new(&tree, &GRAVITY, DORMAND_PRINCE);
            other.begin(&state, false);
            let steps = other.steps(0.1, tolerance).unwrap();
            let worst = |steps: usize| {
                tree.minus(&after(steps), &exact)
                    .iter()
                    .fold(0.0_f64, |most, x| most.max(x.abs()))
            };
            let mut worst = worst;
            assert!(worst(steps) < tolerance, "{name}: {steps}");
            assert!(
                steps == 1 || worst(steps / 2) > 0.01 * tolerance,
                "{name}: {steps}"
            );
            assert_eq!(other.state(), state_of(&tree, &state), "{name}");
        }
    }
}

fn state_of(tree: &Tree, state: &TreeState) -> TreeState {
    let mut flow = Flow::new(tree, &GRAVITY, DORMAND_PRINCE);
    flow.begin(state, false);
    flow.state()
}
