//! What no performance of a scene can tell: quantities alone, and free ones that count only
//! together.

use thiserror::Error;

use super::condition::{Condition, Moment};
use super::event::{Collision, EventKind, Partner};
use super::goal::GoalTarget;
use super::quantity::Quantity;
use super::whole::{Scene, Timing};
use crate::motion::index::{ContactLawIndex, LinkIndex};
use crate::physics::body::Symmetry;

/// Why no performance of a scene can tell a quantity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum Untold {
    /// A contact law without a collision.
    #[error("no collision has this restitution and friction")]
    UnusedLaw,
    /// The mass of a link that meets no other.
    #[error("the mass of a body that meets no other moving body cancels out of its motion")]
    MassCancels,
    /// Three equal moments of a link that never collides.
    #[error("only ratios of moments show in flight, and all moments of this body are equal")]
    MomentCancels,
    /// The tangential restitution of what has no friction.
    #[error("without friction nothing sticks: give the friction beside it, or free it before")]
    NoFriction,
    /// The lift of a body of which moments differ.
    #[error("only a ball is lifted, a body whose three moments are equal")]
    NotRound,
    /// The turn of a tracker on a link with three equal moments that never collides.
    #[error(
        "a body with three equal moments that never collides turns alike whichever way its tracker is mounted"
    )]
    TurnCancels,
    /// A clock where stamps are no physical times from one zero.
    #[error("clocks are told only where stamps are physical times: timing.stamps = \"physical\"")]
    NoClock,
    /// The offset of the only track.
    #[error("the only tracker's clock is the time itself: there is no other to tell its offset")]
    OnlyClock,
    /// Mass, moments, centre, force or drag of a body in the hand.
    #[error(
        "a held body moves as it was tracked: neither its inertia nor what pulls at it changes that"
    )]
    Held,
    /// Of what is estimated by itself.
    #[error("it moves by itself, and the rest of the scene tells nothing of it")]
    Apart,
    /// The tracker of a body in the hand that nothing hits.
    #[error("nothing hits this held body, so that nothing tells of its tracker")]
    HeldApart,
    /// The duration of a contact after which something else begins at once.
    #[error("a phase or a goal begins right after this collision: its contact is one moment")]
    OneMoment,
    /// What phases hold fixed.
    #[error("phases are on surfaces and of bodies as the scene gives them")]
    InPhase,
    /// A surface without a collision.
    #[error("nothing touches this surface")]
    Untouched,
    /// A surface of a solid of which others are touched too.
    #[error("another surface of the same obstacle may be touched too, and both would move as one")]
    OneSolid,
}

/// Free parameters of which only a combination is told.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Combination {
    /// Indices into `Scene::parameters`, in order; none has a prior.
    pub parameters: Vec<usize>,
    /// Why.
    pub why: Together,
}

/// Why quantities count only together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum Together {
    /// All moments of a link that never collides.
    #[error("a body that never collides shows only the ratios of its moments")]
    Moments,
    /// The masses of all links that meet, one another or by way of others.
    #[error("masses of bodies that meet count only relative to one another")]
    Masses,
    /// Gravity along an axis and the forces on all links.
    #[error("a force on every body and gravity along the same axis are one pull")]
    Pull,
    /// Offsets of all clocks.
    #[error("offsets of clocks count only relative to one another")]
    Offsets,
    /// Rates of all clocks, with all of gravity.
    #[error("with no known acceleration nothing tells how fast time runs")]
    Rates,
    /// Centre of mass and tracker of a link that touches nothing.
    #[error(
        "for a body that never collides and has no goal, its centre of mass and its tracker have only one offset between them"
    )]
    Mount,
}

impl Scene {
    /// Why no performance of the scene can tell the quantity, where that is known beforehand.
    pub fn untold(&self, quantity: Quantity) -> Option<Untold> {
        let unless = |is_told: bool, why| (!is_told).then_some(why);
        if let Some(why) = self.held_untold(quantity) {
            return Some(why);
        }
        if let Quantity::ContactDuration { event } = quantity
            && self.goes_on_at(event)
        {
            return Some(Untold::OneMoment);
        }
        if self.is_in_phase(quantity) {
            return Some(Untold::InPhase);
        }
        match quantity {
            Quantity::Restitution { law } => unless(self.uses(law), Untold::UnusedLaw),
            Quantity::Friction { law } => {
                unless(self.uses(law) || self.has_phase_of(law), Untold::UnusedLaw)
            }
            Quantity::TangentialRestitution { law } if !self.has_friction(law) => {
                Some(Untold::NoFriction)
            }
            Quantity::TangentialRestitution { law } => unless(self.uses(law), Untold::UnusedLaw),
            Quantity::Lift { link } => unless(self.is_round(link), Untold::NotRound),
            Quantity::Mass { link } => unless(self.met_by(link).len() > 1, Untold::MassCancels),
            Quantity::Moment { link, .. } => unless(
                self.collides(link) || !self.is_round(link) || self.is_joined(link),
                Untold::MomentCancels,
            ),
            Quantity::TrackerOrientation { track, .. } => {
                let link = self.tracks[track].link;
                unless(
                    self.has_own_axes(link) || !self.is_round(link),
                    Untold::TurnCancels,
                )
            }
            Quantity::ClockRate { .. }
            | Quantity::ClockOffset { .. }
            | Quantity::ContactDuration { .. }
                if self.timing != Timing::Known =>
            {
                Some(Untold::NoClock)
            }
            Quantity::ClockOffset { .. } => {
                let own = self.tracks.keys().filter(|track| !self.sees_apart(*track));
                unless(own.count() > 1, Untold::OnlyClock)
            }
            Quantity::SurfaceHeight { surface } | Quantity::SurfaceTilt { surface, .. } => {
                self.surface_untold(surface)
            }
            Quantity::Gravity { .. }
            | Quantity::Tilt { .. }
            | Quantity::Force { .. }
            | Quantity::LinearDrag { .. }
            | Quantity::QuadraticDrag { .. }
            | Quantity::Centre { .. }
            | Quantity::TrackerPosition { .. }
            | Quantity::FlightClock { .. }
            | Quantity::SampleTime { .. }
            | Quantity::ContactDuration { .. }
            | Quantity::ClockRate { .. }
            | Quantity::JointPlace { .. }
            | Quantity::JointTurn { .. } => None,
        }
    }

    /// Whether a phase, or a goal of what is after it, begins at an event.
    fn goes_on_at(&self, event: usize) -> bool {
        let mut phases = self.phases.iter();
        let mut goals = self.goals.iter().filter(|goal| goal.event == event);
        let is_after = |condition: &Condition| condition.moment == Moment::After;
        phases.any(|phase| phase.events.contains(&event))
            || goals.any(|goal| goal.target.conditions().iter().any(is_after))
    }

    /// Why no performance can tell a quantity of a body that is held or apart.
    fn held_untold(&self, quantity: Quantity) -> Option<Untold> {
        let link = match quantity {
            Quantity::Force { link, .. }
            | Quantity::LinearDrag { link }
            | Quantity::QuadraticDrag { link }
            | Quantity::Lift { link }
            | Quantity::Moment { link, .. }
            | Quantity::Mass { link }
            | Quantity::Centre { link, .. } => Some(link),
            Quantity::TrackerPosition { track, .. }
            | Quantity::TrackerOrientation { track, .. }
            | Quantity::ClockRate { track }
            | Quantity::ClockOffset { track } => Some(self.tracks[track].link),
            _ => None,
        };
        if link.is_some_and(|link| self.is_apart(self.mechanism_of(link))) {
            return Some(Untold::Apart);
        }
        match quantity {
            Quantity::Force { link, .. }
            | Quantity::LinearDrag { link }
            | Quantity::QuadraticDrag { link }
            | Quantity::Lift { link }
            | Quantity::Moment { link, .. }
            | Quantity::Mass { link }
            | Quantity::Centre { link, .. } => self.is_held(link).then_some(Untold::Held),
            Quantity::TrackerPosition { track, .. }
            | Quantity::TrackerOrientation { track, .. }
            | Quantity::ClockRate { track }
            | Quantity::ClockOffset { track } => {
                let link = self.tracks[track].link;
                (self.is_held(link) && !self.collides(link)).then_some(Untold::HeldApart)
            }
            _ => None,
        }
    }

    /// Whether a phase has the law, and the law counts in it.
    fn has_phase_of(&self, law: ContactLawIndex) -> bool {
        let mut phases = self.phases.iter();
        phases.any(|phase| phase.friction_law() == Some(law))
    }

    /// Whether phases take the quantity for what the scene says.
    fn is_in_phase(&self, quantity: Quantity) -> bool {
        let mut phases = self.phases.iter();
        match quantity {
            // Nothing of a body counts while a hand moves it, but where its centre of mass is.
            Quantity::LinearDrag { link }
            | Quantity::QuadraticDrag { link }
            | Quantity::Lift { link }
            | Quantity::Mass { link }
            | Quantity::Moment { link, .. } => {
                phases.any(|phase| phase.link == link && phase.in_hand().is_none())
            }
            Quantity::Centre { link, .. } => phases.any(|phase| phase.link == link),
            Quantity::Force { link, .. } => {
                phases.any(|phase| phase.link == link && phase.stuck_to().is_some())
            }
            Quantity::SurfaceHeight { surface } | Quantity::SurfaceTilt { surface, .. } => {
                phases.any(|phase| phase.on_surface().is_some_and(|on| on.surface == surface))
            }
            Quantity::Tilt { event, .. } => phases.any(|phase| phase.events[0] == event),
            Quantity::Restitution { law } | Quantity::TangentialRestitution { law } => {
                phases.any(|phase| {
                    let begins = self.events[phase.events[0]].kind.collision();
                    begins.is_some_and(|collision| collision.law == law)
                })
            }
            _ => false,
        }
    }

    fn surface_untold(&self, surface: usize) -> Option<Untold> {
        let is_touched = |surface: usize| {
            let mut hits = self.collisions().filter(|c| c.partner == Partner::World);
            hits.any(|collision| {
                let mut others = collision.contacts.iter().map(|touching| touching.other);
                others.any(|other| other.is_none_or(|other| other == surface))
            })
        };
        if !is_touched(surface) {
            return Some(Untold::Untouched);
        }
        let solid = self.surfaces[surface].obstacle;
        let mut others = (0..self.surfaces.len()).filter(|other| *other != surface);
        let shares = |other: usize| {
            solid.is_some() && self.surfaces[other].obstacle == solid && is_touched(other)
        };
        others.any(shares).then_some(Untold::OneSolid)
    }

    /// Free parameters without priors of which only a combination is told, where that is known
    /// beforehand: the first such set.
    pub fn told_together(&self) -> Option<Combination> {
        let links = self.links.keys();
        let moments = links
            .clone()
            .filter(|link| !self.collides(*link) && !self.is_joined(*link))
            .map(|link| {
                let axes = self.links[link].moment_axes();
                let all = axes.map(|axis| Quantity::Moment { link, axis });
                (all.collect(), Together::Moments)
            });
        let masses = links.clone().map(|link| {
            let met = self.met_by(link).into_iter();
            let all = met.map(|link| Quantity::Mass { link });
            (all.collect(), Together::Masses)
        });
        let pulls = (0..3).map(|axis| {
            let flying = self.links.keys().filter(|link| !self.is_held(*link));
            let forces = flying.map(|link| Quantity::Force { link, axis });
            let all = [Quantity::Gravity { axis }].into_iter().chain(forces);
            (all.collect(), Together::Pull)
        });
        let tracks = || self.tracks.keys();
        let offsets = tracks().map(|track| Quantity::ClockOffset { track });
        let offsets = (offsets.collect(), Together::Offsets);
        let rates = tracks().map(|track| Quantity::ClockRate { track });
        let rates = (rates.chain(self.accelerations()).collect(), Together::Rates);
        let mounts = tracks().flat_map(|track| (0..3).map(move |axis| (track, axis)));
        let mounts = mounts.filter(|(track, _)| !self.has_own_axes(self.tracks[*track].link));
        let mounts = mounts.map(|(track, axis)| {
            let link = self.tracks[track].link;
            let centre = Quantity::Centre { link, axis };
            let all = vec![centre, Quantity::TrackerPosition { track, axis }];
            (all, Together::Mount)
        });
        let all = moments.chain(masses).chain(pulls);
        let mut all = all.chain([offsets, rates]).chain(mounts);
        all.find_map(|(quantities, why)| self.all_free(&quantities, why))
    }

    /// The parameters that free all of the quantities; `None` where one is held, by the scene or by
    /// a prior.
    fn all_free(&self, quantities: &[Quantity], why: Together) -> Option<Combination> {
        let freed = |quantity: &Quantity| {
            let mut parameters = self.parameters.iter();
            parameters.position(|free| free.quantity == *quantity && free.prior_sd.is_none())
        };
        let mut parameters: Vec<usize> = quantities.iter().map(freed).collect::<Option<_>>()?;
        parameters.sort_unstable();
        Some(Combination { parameters, why })
    }

    /// What has seconds in its unit and is not zero: accelerations, and drags that grow with speed.
    fn accelerations(&self) -> impl Iterator<Item = Quantity> + '_ {
        let gravity = (0..3).map(|axis| Quantity::Gravity { axis });
        let of_links = self.links.keys().flat_map(|link| {
            let forces = (0..3).map(move |axis| Quantity::Force { link, axis });
            forces.chain([Quantity::LinearDrag { link }])
        });
        let all = gravity.chain(of_links);
        all.filter(|quantity| self.value_of(*quantity) != 0.0)
    }

    fn collisions(&self) -> impl Iterator<Item = &Collision> {
        self.events.iter().filter_map(|event| match &event.kind {
            EventKind::Collision(collision) => Some(collision),
            EventKind::Collisions { each, .. } => Some(each),
            EventKind::Start | EventKind::Change(_) | EventKind::Waypoint(_) | EventKind::End => {
                None
            }
        })
    }

    /// Whether a collision has the law.
    pub fn uses(&self, law: ContactLawIndex) -> bool {
        self.collisions().any(|collision| collision.law == law)
    }

    fn collides(&self, link: LinkIndex) -> bool {
        self.collisions()
            .any(|c| c.links().any(|other| other == link))
    }

    /// Whether something fixes the link's own axes: what it touches, a goal of its pose, or a joint.
    fn has_own_axes(&self, link: LinkIndex) -> bool {
        let mut goals = self.goals.iter();
        let has_goal =
            goals.any(|goal| goal.link == link && matches!(goal.target, GoalTarget::Pose { .. }));
        has_goal || self.collides(link) || self.is_joined(link)
    }

    fn is_round(&self, link: LinkIndex) -> bool {
        self.links[link].body.symmetry() == Symmetry::Spherical
    }

    /// Whether joints tie the link to anything.
    fn is_joined(&self, link: LinkIndex) -> bool {
        self.joint_tree(self.mechanism_of(link)).is_some()
    }

    /// The links that a link meets or is joined to, directly or by way of others, and itself.
    fn met_by(&self, link: LinkIndex) -> Vec<LinkIndex> {
        let mut met = vec![link];
        let mut next = 0;
        while next < met.len() {
            if let Some(tree) = self.joint_tree(self.mechanism_of(met[next])) {
                let new = tree.links().filter(|other| !met.contains(other));
                met.extend(new.collect::<Vec<_>>());
            }
            for collision in self.collisions() {
                let links = collision.links().filter(|link| !self.is_held(*link));
                let links: Vec<LinkIndex> = links.collect();
                if links.contains(&met[next]) {
                    let new = links.into_iter().filter(|other| !met.contains(other));
                    met.extend(new.collect::<Vec<_>>());
                }
            }
            next += 1;
        }
        met
    }
}
