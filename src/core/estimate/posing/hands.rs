//! What is in a hand where something hits it, or where the hand takes it or lets go.

use crate::estimate::problem::influence::{Acting, Influence, Owner, Role};
use crate::estimate::problem::{EventMark, HeldState};
use crate::estimate::wander::Process;
use crate::math::Pose;
use crate::motion::{HeldMotion, LinkIndex, Performer, Scene, Sketch, Timing, TrackIndex};

/// What of a problem says how hands move.
pub(super) struct PosedHands<'a> {
    pub(super) scene: &'a Scene,
    pub(super) sketch: &'a Sketch,
    pub(super) roles: &'a [Role],
    pub(super) nodes_acted_s: &'a [f64],
}

impl PosedHands<'_> {
    /// The held body that is hit at an event.
    ///
    /// # Panics
    /// Without its motion: an earlier stage finds it.
    pub(super) fn hit(&self, event: usize) -> Option<HeldState> {
        let collision = self.scene.events[event].kind.collision()?;
        let mut links = collision.links();
        let link = links.find(|link| self.scene.is_held(*link))?;
        let mut tracks = self.scene.tracks.iter_enumerated();
        let (track, of) = tracks.find(|(_, track)| track.link == link)?;
        let motion = self.sketch.tracks[track].held.as_ref();
        let motion = motion.expect("a motion that an earlier stage found");
        Some(self.state(event, link, track, motion, &of.link_from_tracker))
    }

    /// What is in a hand in a phase that begins or ends at an event.
    pub(super) fn gripped(&self, phase: usize, event: usize) -> Option<HeldState> {
        let of = &self.scene.phases[phase];
        let hand = of.in_hand()?;
        let motion = self.sketch.grip(phase)?;
        let mount = &hand.link_from_tracker;
        let mut state = self.state(event, of.link, hand.track, motion, mount);
        // How the hand's tracker is mounted is told in axes of the hand, which strays from nothing.
        if self.scene.seen_in_hand(of).is_none() {
            state
                .acting
                .retain(|of| matches!(of.influence, Influence::ClockRate | Influence::ClockOffset));
            return Some(state);
        }
        state.strays = true;
        if self.scene.performer != Performer::Nobody {
            let weights = &self.scene.weights;
            let units = [weights.position_m, weights.orientation_rad];
            state.stray(&[Process::EXPECTED; 2], units);
        }
        Some(state)
    }

    fn state(
        &self,
        event: usize,
        link: LinkIndex,
        track: TrackIndex,
        motion: &HeldMotion,
        mount: &Pose,
    ) -> HeldState {
        let own = self.roles.iter();
        let own = own.filter(|role| role.owner == Owner::Track(track));
        let acting: Vec<Acting> = own.map(|role| role.acting(None)).collect();
        let nodes = match self.scene.timing {
            Timing::Unknown { .. } => {
                EventMark::nodes_about(self.nodes_acted_s, self.sketch.marks_s[event])
            }
            Timing::Known | Timing::Edited => None,
        };
        let meeting = motion.meeting(event);
        let meeting = meeting.expect("a meeting at each of its events");
        HeldState::new(link, track, motion, mount, meeting, acting, nodes)
    }
}
