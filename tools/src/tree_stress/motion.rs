//! True motions: drawn, told to rounding where that can be, and how errors grow along them.

use enact::motion::Scene;
use enact::physics::tree::{Flow, Tree, TreeState, tableau};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::{Draw, Hard, Performance};
use crate::trees::RATE_HZ;

/// Steps between samples of a motion that is not told to rounding.
const STEPS: usize = 8;
/// Steps at most of one that is, and the difference that halved steps may make.
const MOST_STEPS: usize = 256;
const EXACT: f64 = 1e-9;
/// Change of the start of which growth is told.
const NUDGE: f64 = 1e-8;

impl Hard {
    /// States at the samples; none where a draw is not of the kind.
    pub(super) fn motion(
        &self,
        scene: &Scene,
        tree: &Tree,
        random: &mut ChaCha8Rng,
    ) -> Option<Vec<TreeState>> {
        let start = self.drawn(tree, random);
        let states = match self.is_exact {
            true => self.told(scene, tree, &start)?,
            false => self.flown(scene, tree, &start, STEPS),
        };
        let numbers = |state: &TreeState| {
            let all = state.coordinates.iter().chain(&state.rates);
            all.copied().all(f64::is_finite)
        };
        let is_finite = states.iter().all(numbers);
        (is_finite && self.is_of_kind(tree, &states)).then_some(states)
    }

    /// The motion to rounding, by steps that are halved until they change nothing; none where that takes too many.
    fn told(&self, scene: &Scene, tree: &Tree, start: &TreeState) -> Option<Vec<TreeState>> {
        let mut steps = STEPS;
        let mut states = self.flown(scene, tree, start, steps);
        while steps < MOST_STEPS {
            steps *= 2;
            let finer = self.flown(scene, tree, start, steps);
            let off = tree.minus(&states[states.len() - 1], &finer[finer.len() - 1]);
            if off.iter().all(|off| off.abs() < EXACT) {
                return Some(finer);
            }
            states = finer;
        }
        None
    }

    fn flown(&self, scene: &Scene, tree: &Tree, start: &TreeState, steps: usize) -> Vec<TreeState> {
        let count = (self.duration_s * RATE_HZ).round() as usize;
        flown(scene, tree, start, (count, steps))
    }

    fn is_of_kind(&self, tree: &Tree, states: &[TreeState]) -> bool {
        let Draw::Through(_) = self.draw else {
            return true;
        };
        let angles = tree.angles_of(self.rods.len() - 1);
        let [_, own] = angles.expect("a universal joint");
        let along = |state: &TreeState| state.coordinates[own.end - 1].cos();
        let signs = states.iter().map(|state| along(state) > 0.0);
        signs.clone().any(|sign| sign) && signs.clone().any(|sign| !sign)
    }

    fn drawn(&self, tree: &Tree, random: &mut ChaCha8Rng) -> TreeState {
        let mut signed = |most: f64| most * (2.0 * random.random::<f64>() - 1.0);
        let (count, flight) = (tree.freedoms(), tree.translations());
        let (Draw::Within(most)
        | Draw::Through(most)
        | Draw::Swung(_, most)
        | Draw::FromAbove(most)) = self.draw;
        let mut delta = vec![0.0; 2 * count];
        for at in flight..count {
            delta[at] = signed(most[0]);
            delta[count + at] = signed(most[1]);
        }
        match self.draw {
            Draw::Swung(rate_rad_s, _) => delta[count + flight] = signed(1.0).signum() * rate_rad_s,
            Draw::FromAbove(_) => delta[flight] += std::f64::consts::PI,
            Draw::Within(_) | Draw::Through(_) => {}
        }
        if flight > 0 {
            delta[2] = 1.0;
            let up_m_s = 0.5 * 9.80665 * self.duration_s;
            (delta[count], delta[count + 1], delta[count + 2]) = (signed(1.0), signed(1.0), up_m_s);
        }
        tree.retract(&tree.at_rest(), &delta)
    }
}

/// States at the start and after each of some samples, with so many steps between two.
pub(super) fn flown(
    scene: &Scene,
    tree: &Tree,
    start: &TreeState,
    (count, steps): (usize, usize),
) -> Vec<TreeState> {
    let mut flow = Flow::new(tree, &scene.gravity_m_s2, tableau::DORMAND_PRINCE);
    flow.begin(start, false);
    let mut states = vec![flow.state()];
    for _ in 0..count {
        flow.advance(1.0 / RATE_HZ, steps);
        states.push(flow.state());
    }
    states
}

impl Performance {
    /// By how much errors at the start of the true motion grow to its end, at most along any coordinate or rate: by
    /// differences, which say how large errors become, and no more.
    pub fn growth(&self) -> f64 {
        let scene = &self.strike.scene;
        let forest = scene.forest();
        let (tree, states) = (&forest.trees()[0], &self.strike.states);
        let count = states.len() - 1;
        let size = 2 * tree.freedoms();
        let plain = flown(scene, tree, &states[0], (count, STEPS));
        let changes = (0..size).map(|at| {
            let mut delta = vec![0.0; size];
            delta[at] = NUDGE;
            let nudged = tree.retract(&states[0], &delta);
            let end = flown(scene, tree, &nudged, (count, STEPS));
            let off = tree.minus(&end[count], &plain[count]);
            off.iter().fold(0.0, |most: f64, off| most.max(off.abs())) / NUDGE
        });
        changes.fold(0.0, f64::max)
    }
}
