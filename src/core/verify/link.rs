//! The motion of one link of joined bodies, for the checks that bodies by themselves go through.

use crate::motion::{ArcEstimate, Estimate, LinkIndex, MechanismIndex, Scene, TreeEstimate};
use crate::physics::State;
use crate::physics::tree::{Snapshot, Tree};

/// Speeds are told at the states of the estimate, and a share is added for those between.
const BETWEEN: f64 = 1.25;

/// A link of joined bodies with their motion.
pub(in crate::verify) struct JoinedLink<'a> {
    scene: &'a Scene,
    estimate: &'a Estimate,
    motion: &'a TreeEstimate,
    tree: Tree,
    place: usize,
}

impl<'a> JoinedLink<'a> {
    /// The link's; `None` of a body by itself, or of one without an estimate.
    pub(in crate::verify) fn new(
        scene: &'a Scene,
        link: LinkIndex,
        estimate: &'a Estimate,
    ) -> Option<Self> {
        let mechanism = scene.mechanism_of(link);
        let joined = scene.joint_tree(mechanism)?;
        let mut motions = estimate.trees.iter();
        Some(Self {
            scene,
            estimate,
            motion: motions.find(|of| of.mechanism == mechanism)?,
            tree: scene.tree_model_with(joined, &estimate.held),
            place: joined.place_of(link)?,
        })
    }

    /// Its motion from impact to impact of any of the joined bodies.
    pub(in crate::verify) fn arcs(&self) -> Vec<ArcEstimate> {
        let [start_s, end_s] = self.motion.span_s();
        let hits = self.estimate.events.iter().filter(|of| {
            let kind = &self.scene.events[of.event].kind;
            let mut hits = kind.collision().into_iter();
            hits.any(|of| self.scene.takes_part(self.motion.mechanism, of))
        });
        let hits = hits.map(|of| of.time_s);
        let mut ends_s: Vec<f64> = [start_s].into_iter().chain(hits).chain([end_s]).collect();
        ends_s.sort_by(f64::total_cmp);
        let mechanism = self.motion.mechanism;
        let pieces = ends_s.windows(2);
        let pieces = pieces.map(|pair| piece(mechanism, [pair[0], pair[1]], self.at(pair[0])));
        pieces.collect()
    }

    /// The state on one of them.
    pub(in crate::verify) fn state(&self, arc: &ArcEstimate, time_s: f64) -> State {
        self.at(time_s.clamp(arc.start_s, arc.end_s))
    }

    fn at(&self, time_s: f64) -> State {
        let gravity_m_s2 = &self.estimate.gravity_m_s2;
        let mut snapshot = Snapshot::new(&self.tree, gravity_m_s2);
        snapshot.set(&self.motion.state(&self.tree, gravity_m_s2, time_s));
        snapshot.link_state(self.place)
    }

    /// Bound of the speed of all its points [m/s], with this radius \[m\].
    pub(in crate::verify) fn speed_bound_m_s(&self, radius_m: f64) -> f64 {
        let mut snapshot = Snapshot::new(&self.tree, &self.estimate.gravity_m_s2);
        let speeds = self.motion.knots.iter().map(|knot| {
            snapshot.set(&knot.state);
            let state = snapshot.link_state(self.place);
            state.velocity_m_s.norm() + state.angular_velocity_rad_s.norm() * radius_m
        });
        BETWEEN * speeds.fold(0.0, f64::max)
    }
}

/// A piece of a motion that is no flight of its own, with its state at the beginning.
pub(in crate::verify) fn piece(
    mechanism: MechanismIndex,
    [start_s, end_s]: [f64; 2],
    state: State,
) -> ArcEstimate {
    ArcEstimate {
        mechanism,
        epoch_s: start_s,
        state,
        start_s,
        end_s,
        support: None,
        certainty: None,
    }
}
