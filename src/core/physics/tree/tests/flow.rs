//! The flow's derivatives are those of its steps.

use nalgebra::{DMatrix, DVector};

use super::examples::{GRAVITY, PIN, chain, off, rods, some_state, trees};
use crate::math::random::Random;
use crate::physics::tree::tableau::DORMAND_PRINCE;
use crate::physics::tree::{Flow, Snapshot, Tree, TreeState};

/// How far derivatives of a flow in such steps are off differences, by the state at its start and by its time, of the greatest
/// entry.
pub fn derivatives_off(tree: &Tree, state: &TreeState, elapsed_s: f64, step_s: f64) -> f64 {
    let size = 2 * tree.freedoms();
    let mut flow = Flow::new(tree, &GRAVITY, DORMAND_PRINCE);
    let mut exact = DMatrix::zeros(size, size);
    flow.begin(state, true);
    flow.reach(elapsed_s, step_s);
    let end = flow.state();
    flow.jacobian(&mut exact);
    let rate = flow.rate();
    let exact = DMatrix::from_fn(size, size + 1, |row, column| match column < size {
        true => exact[(row, column)],
        false => rate[row],
    });
    off(&exact, |delta| {
        let mut flow = Flow::new(tree, &GRAVITY, DORMAND_PRINCE);
        flow.begin(&tree.retract(state, &delta[..size]), false);
        flow.reach(elapsed_s + delta[size], step_s);
        tree.minus(&flow.state(), &end)
    })
}

/// Coarse steps, so that the discrete map is not the continuous one, to their ends and to times within them, forwards
/// and backwards: 5e-9 of the greatest entry, which differences give.
#[test]
fn derivatives_of_the_flow_are_those_of_its_steps() {
    let mut random = Random::default();
    for (name, tree) in trees() {
        let state = some_state(&tree, &mut random, 1.0, 3.0);
        for (elapsed_s, step_s) in [(0.08, 0.04), (0.097, 0.04), (0.011, 0.04), (-0.07, 0.03)] {
            let off = derivatives_off(&tree, &state, elapsed_s, step_s);
            assert!(off < 5e-9, "{name} {elapsed_s}: {off:e}");
        }
    }
}

/// Times in any order, on and back over the start, give what each gives by itself; equal steps to their ends give
/// the same.
#[test]
fn a_time_is_reached_whatever_came_before() {
    let mut random = Random::default();
    for (name, tree) in trees() {
        let state = some_state(&tree, &mut random, 1.0, 3.0);
        let size = 2 * tree.freedoms();
        let reached = |flow: &mut Flow, elapsed_s: f64| {
            flow.reach(elapsed_s, 0.03);
            let mut jacobian = DMatrix::zeros(size, size);
            flow.jacobian(&mut jacobian);
            (flow.state(), jacobian, flow.rate())
        };
        let begun = || {
            let mut flow = Flow::new(&tree, &GRAVITY, DORMAND_PRINCE);
            flow.begin(&state, true);
            flow
        };
        let mut flow = begun();
        for elapsed_s in [
            0.01,
            0.02,
            0.1,
            0.05,
            0.0,
            -0.04,
            -0.01,
            0.025,
            0.09,
            f64::NAN,
            0.07,
        ] {
            let by_itself = reached(&mut begun(), elapsed_s);
            let after_others = reached(&mut flow, elapsed_s);
            if elapsed_s.is_nan() {
                assert!(after_others.0.rates.iter().all(|rate| rate.is_nan()));
            } else {
                assert_eq!(after_others, by_itself, "{name} {elapsed_s}");
            }
        }
        flow.reach(1e300, 0.03);
        assert!(flow.state().rates[0].is_nan());
        let mut ends = begun();
        ends.advance(0.06, 2);
        let off = tree.minus(&ends.state(), &reached(&mut flow, 0.06).0);
        assert!(off.iter().all(|off| off.abs() < 1e-14), "{name} {off:?}");
        assert_eq!(
            reached(&mut ends, 0.09),
            reached(&mut begun(), 0.09),
            "{name}"
        );
    }
}

/// Halved steps divide the error by two to the order: eight at their ends, of which what is within inherits all but its own step's.
#[test]
fn methods_have_their_order() {
    let tree = Tree::new(&rods(3, PIN, PIN)).unwrap();
    let state = some_state(&tree, &mut Random::default(), 0.7, 5.0);
    let after = |step_s: f64| {
        let mut flow = Flow::new(&tree, &GRAVITY, DORMAND_PRINCE);
        flow.begin(&state, false);
        // To the end of steps, and to the middle of one.
        [0.3, 0.295].map(|elapsed_s| {
            flow.reach(elapsed_s, step_s);
            flow.state()
        })
    };
    let exact = after(0.3e-3);
    let [coarse, fine] = [0.01, 0.005].map(|step_s| {
        let states = after(step_s);
        [0, 1].map(|of| {
            let off = tree.minus(&states[of], &exact[of]);
            off.iter().map(|x| x * x).sum::<f64>().sqrt()
        })
    });
    for (of, wanted) in [8.0, 7.0].into_iter().enumerate() {
        let order = (coarse[of] / fine[of]).log2();
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
    flow.reach(0.0, 0.01);
    let mut jacobian = DMatrix::zeros(2 * freedoms, 2 * freedoms);
    flow.jacobian(&mut jacobian);
    let unit = jacobian - DMatrix::identity(2 * freedoms, 2 * freedoms);
    assert!(unit.amax() < 1e-15, "{unit}");
    let mut rate = state.rates.clone();
    rate.resize(2 * freedoms, 0.0);
    let mut snapshot = Snapshot::new(&tree, &GRAVITY);
    snapshot.set(&state);
    snapshot.accelerations(&mut rate[freedoms..]);
    let off = flow.rate() - DVector::from_vec(rate);
    assert!(off.amax() < 1e-11, "{off}");
}
