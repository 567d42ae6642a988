//! The clearances that overlaps of a motion of trees ask for.

use super::clearance::{MotionPiece, TreeClearance};
use super::optimum::Solved;
use crate::estimate::posing::clearance::met::{
    OverlapMeeting, given_state, keeping_out, kept_from,
};
use crate::estimate::problem::clearance::KeptFrom;
use crate::motion::{Against, Estimate, LinkIndex, Penetration, Scene};
use crate::physics::State;
use crate::physics::tree::{Forest, ForestSnapshot};

/// A motion whose solids overlap.
pub(super) struct OverlappingTrees<'a> {
    /// The scene as estimated.
    scene: &'a Scene,
    /// The motion,
    estimate: &'a Estimate,
    /// and the solution of which that tells.
    solved: &'a Solved,
    /// The equations of motion.
    forest: Forest,
}

impl<'a> OverlappingTrees<'a> {
    pub(super) fn new(scene: &'a Scene, estimate: &'a Estimate, solved: &'a Solved) -> Self {
        Self {
            scene,
            estimate,
            solved,
            forest: scene.forest_with(&estimate.held),
        }
    }

    /// What keeps the two solids of an overlap out of each other about its moment; `None` where no features tell.
    pub(super) fn clearance(&self, found: &Penetration) -> Option<TreeClearance> {
        let (problem, point) = (&self.solved.problem, &self.solved.solution.point);
        let (link, against) = keeping_out(self.scene, found);
        let time_s = found.time_s;
        let from = kept_from(self.scene, self.estimate, against);
        let place = self.place(link)?;
        let other = match (&from, against) {
            (KeptFrom::Flying, Against::Link(other)) => self.place(other)?,
            _ => place,
        };
        let line = &point.time_line(problem);
        let (about_s, _) = line.acted_s(time_s);
        let states = |at_s: f64| self.states([place, other], &from, at_s);
        let meeting = OverlapMeeting::new(self.scene, link, against, from.clone(), &states)?;
        let events_s = point.event_times_s.iter();
        let piece = MotionPiece {
            node: problem.node_of(about_s),
            events_before: events_s.filter(|event_s| **event_s < time_s).count(),
        };
        let ends_s = piece.ends(problem, line, point).map(|end| end.time_s);
        Some(TreeClearance {
            solids: meeting.solids(time_s, found.depth_m, ends_s)?,
            places: [place, other],
            piece,
            about_s,
        })
    }

    /// The place of a link in the forest.
    fn place(&self, link: LinkIndex) -> Option<usize> {
        self.scene.forest_links().position(|of| of == link)
    }

    /// States of what is at the first place, and of what that must stay out of.
    fn states(&self, places: [usize; 2], from: &KeptFrom, time_s: f64) -> Option<[State; 2]> {
        let state = self
            .scene
            .forest_state(self.estimate, &self.forest, time_s)?;
        let mut snapshot = ForestSnapshot::new(&self.forest, &self.estimate.gravity_m_s2);
        snapshot.set(&state);
        let [own, other] = places.map(|place| snapshot.link_state(place));
        let met = match from {
            KeptFrom::Flying => other,
            KeptFrom::Still(_) | KeptFrom::Held(_) => given_state(from, time_s)?,
        };
        Some([own, met])
    }
}
