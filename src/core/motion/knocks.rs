//! What happens at collisions of an estimated motion: by the law of impact, from the motion before them.

use super::estimate::{Estimate, EventEstimate};
use super::index::LinkIndex;
use super::scene::{Collision, Partner, Scene};
use super::verdict::Verdict;
use crate::physics::impact::{Knock, Side};
use crate::physics::support::PivotAxes;
use crate::physics::tree::ForestSnapshot;
use crate::physics::{State, Support};

/// Speed of a place of a body below which nothing has to catch it [m/s].
const STILL_M_S: f64 = 1e-9;

impl Estimate {
    /// What happens at each contact of a collision that the scene names, in its order, as one where a face lands flat; or
    /// where a place catches a body. `scene` is as estimated. On the event's first link, against what it hits.
    ///
    /// Empty at other events, where contacts are left open or touch in no regular way, and of a motion that failed.
    pub fn knocks(&self, scene: &Scene, event: &EventEstimate) -> Vec<Knock> {
        if self.verdict == Verdict::Failed {
            return Vec::new();
        }
        let kind = &scene.events[event.event].kind;
        if let Some(link) = kind.change() {
            let caught = self.caught(scene, link, event.time_s);
            return caught.into_iter().collect();
        }
        let Some(collision) = kind.collision() else {
            return Vec::new();
        };
        let is_joined = |link: LinkIndex| scene.joint_tree(scene.mechanism_of(link)).is_some();
        let knocks = match collision.links().any(is_joined) {
            true => self.joined_knocks(scene, collision, event),
            false => self.free_knocks(scene, collision, event),
        };
        let knocks = knocks.unwrap_or_default();
        // Points that stand for a face are none of the scene's.
        match knocks.len() > collision.contacts.len() {
            true => Knock::whole(&knocks).into_iter().collect(),
            false => knocks,
        }
    }

    fn free_knocks(
        &self,
        scene: &Scene,
        collision: &Collision,
        event: &EventEstimate,
    ) -> Option<Vec<Knock>> {
        let contacts = scene.contact_set(event.event).ok()??;
        let state = self.arriving(scene, collision.link, event.time_s)?;
        let other = match collision.partner {
            Partner::World => None,
            Partner::Link(link) => Some((link, self.arriving(scene, link, event.time_s)?)),
        };
        let side = |link: LinkIndex, state| Side {
            body: &scene.links[link].body,
            state,
        };
        let b = other.as_ref().map(|(link, state)| side(*link, state));
        let (a, law) = (side(collision.link, &state), scene.impact_law(collision));
        // Of a contact that lasts, all that it does meanwhile.
        let pressed = scene.pressed(self, event, collision.link);
        let law = pressed.map_or(law, |pressed| pressed.law(&law));
        contacts.knocks(&a, b.as_ref(), &law).ok()
    }

    fn joined_knocks(
        &self,
        scene: &Scene,
        collision: &Collision,
        event: &EventEstimate,
    ) -> Option<Vec<Knock>> {
        let mut links = collision.links();
        if !links.all(|link| scene.moves(scene.mechanism_of(link))) {
            return None;
        }
        let touch = scene.tree_touch(event.event)?;
        let forest = scene.forest_with(&self.held);
        let state = scene.forest_state_before(self, &forest, event.time_s)?;
        let mut snapshot = ForestSnapshot::new(&forest, &self.gravity_m_s2);
        snapshot.set(&state);
        snapshot.knocks(&touch.at, &touch.law).ok()
    }

    /// What a place does to a body that it catches: the motion there ends.
    fn caught(&self, scene: &Scene, link: LinkIndex, time_s: f64) -> Option<Knock> {
        let mechanism = scene.mechanism_of(link);
        let mut arcs = self.arcs.iter();
        let arc = arcs.find(|arc| arc.mechanism == mechanism && arc.start_s == time_s)?;
        let pivot = match arc.support? {
            // Where what holds it still touches it is not known.
            Support::Pivot(pivot) if pivot.axes != PivotAxes::None => pivot,
            Support::Pivot(_) | Support::Plane(_) | Support::Stuck(_) => return None,
        };
        let before = self.arriving(scene, link, time_s)?;
        let after = scene.flown(arc, &self.gravity_m_s2, time_s);
        let body = &scene.links[link].body;
        let arm_m = before.orientation * pivot.at_m;
        let velocities_m_s = [&before, &after].map(|of| {
            let spin = of.orientation * of.angular_velocity_rad_s;
            of.velocity_m_s + spin.cross(&arm_m)
        });
        let impulse_n_s = (after.velocity_m_s - before.velocity_m_s) * body.mass_kg();
        let spun = after.angular_velocity_rad_s - before.angular_velocity_rad_s;
        let turned_n_m_s = before.orientation * spun.component_mul(&body.moments_kg_m2());
        Some(Knock {
            point_m: before.position_m + arm_m,
            normal: (-velocities_m_s[0]).try_normalize(STILL_M_S)?,
            velocities_m_s,
            impulse_n_s,
            moment_n_m_s: turned_n_m_s - arm_m.cross(&impulse_n_s),
        })
    }

    /// The state in which a body by itself arrives at an event; `None` where it does not.
    pub fn arriving(&self, scene: &Scene, link: LinkIndex, time_s: f64) -> Option<State> {
        if let Some(held) = self.held_motion(link) {
            return Some(held.state(time_s));
        }
        let mechanism = scene.mechanism_of(link);
        let mut arcs = self.arcs.iter();
        let arc = arcs.find(|arc| arc.mechanism == mechanism && arc.end_s == time_s)?;
        Some(scene.flown(arc, &self.gravity_m_s2, time_s))
    }
}
