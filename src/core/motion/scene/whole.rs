//! A whole scene, and what its lists say of each other.

use nalgebra::Vector3;
use typed_index_collections::TiVec;

use super::contact_law::ContactLaw;
use super::event::{Collision, Event, EventKind};
use super::goal::{Goal, GoalTarget};
use super::link::{FreeBody, Link, Mechanism, Sees, Track};
use super::parameter::{Cone, FreeParameter};
use super::phase::SupportPhase;
use super::rest::RestGoal;
use super::weights::{Performer, Weighing, Weights};
use super::world::{Against, Obstacle, Surface};
use crate::math::Pose;
use crate::motion::index::{ContactLawIndex, LinkIndex, MechanismIndex, TrackIndex};
use crate::physics::Body;
use crate::physics::impact::Law;

/// Everything that is known about a performance before it is seen.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// Name, for reports.
    pub name: String,
    /// Gravity in world axes [m/s²].
    pub gravity_m_s2: Vector3<f64>,
    /// Whether sample stamps are physical times or only an order with a tempo.
    pub timing: Timing,
    /// Standard deviation of the performer's marks, in acted time \[s\]; `None`: that of people who
    /// press a button while they act, or of annotators where stamps are physical times.
    pub mark_sd_s: Option<f64>,
    /// Topic that carries the marks.
    pub marks_topic: String,
    /// The rigid bodies that move.
    pub links: TiVec<LinkIndex, Link>,
    /// How they move: alone, or tied to each other.
    pub mechanisms: TiVec<MechanismIndex, Mechanism>,
    /// What trackers see of them.
    pub tracks: TiVec<TrackIndex, Track>,
    /// Planes that bodies collide with.
    pub surfaces: Vec<Surface>,
    /// Solid parts of the static world, for drawing and for verification.
    pub obstacles: Vec<Obstacle>,
    /// Restitution and friction of collisions.
    pub contact_laws: TiVec<ContactLawIndex, ContactLaw>,
    /// What happens, in order of time.
    pub events: Vec<Event>,
    /// Phases in which bodies stay on surfaces.
    pub phases: Vec<SupportPhase>,
    /// Goals: hard conditions at events (paper §3.1).
    pub goals: Vec<Goal>,
    /// Goals at rest: what must hold once the motion has gone on until it rests.
    pub rest_goals: Vec<RestGoal>,
    /// Free parameters `u` of the estimation.
    pub parameters: Vec<FreeParameter>,
    /// Pairs of parameters whose norm is bounded: tilts of a normal within a cone.
    pub cones: Vec<Cone>,
    /// Whether velocities after collisions may differ from those by the impact law.
    pub velocity_gaps: VelocityGaps,
    /// Units of residuals.
    pub weights: Weights,
    /// Whether a hand acted the performance.
    pub performer: Performer,
    /// How exactly shapes and places are known \[m\]: overlaps up to it, and parts that are nearer by no more than it to
    /// what they hit, are the scene's inaccuracy.
    pub tolerance_m: f64,
    /// Longest simulation after the motion's end until it rests \[s\] (paper §6.2.3); `None`: the
    /// motion ends with the performance.
    pub settle_s: Option<f64>,
}

/// What the stamps of the samples mean.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Timing {
    /// Stamps are physical times.
    Known,
    /// An edited sketch: every segment has a stream and physical times of its own, and need not
    /// begin where another ends. Collisions are at the joints of segments: marks are not read.
    Edited,
    /// Timing unknown (paper §4.3): the performer's tempo is smooth; the logarithm of its rate is
    /// Brownian motion of this strength [1/√s of acted time].
    Unknown {
        /// Standard deviation of the log-rate's change after one second.
        tempo_sd_per_sqrt_s: f64,
    },
}

/// Whether velocity continuity may be relaxed where goals cannot be met otherwise (paper §6.2,
/// overconstrained sketches). Poses stay continuous and goals are met nevertheless.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VelocityGaps {
    /// Only where there is no motion without gaps.
    WhenNeeded,
    /// From the start: the scene is known to be overconstrained.
    Always,
    /// Never: an overconstrained scene then has no motion.
    Never,
}

impl Scene {
    /// How exactly shapes and places are known where the scene does not say, least and most \[m\]: as a tracker sees them, and as a
    /// tape measures them,
    const TOLERANCES_M: [f64; 2] = [5e-4, 5e-3];
    /// as a share of the radius of the smallest body,
    const TOLERANCE_SHARE: f64 = 0.01;
    /// and of what has no size.
    pub const TOLERANCE_M: f64 = 1e-3;

    /// How exactly shapes and places are known where nobody says \[m\]: a hundredth of the radius of the smallest body, to one digit.
    pub fn usual_tolerance_m(&self) -> f64 {
        let radii_m = self.links.iter().map(Link::radius_m);
        let smallest_m = radii_m.filter(|radius_m| *radius_m > 0.0).reduce(f64::min);
        smallest_m.map_or(Self::TOLERANCE_M, |radius_m| {
            let [least_m, most_m] = Self::TOLERANCES_M;
            let tolerance_m = (Self::TOLERANCE_SHARE * radius_m).clamp(least_m, most_m);
            let digit_m = 10_f64.powf(tolerance_m.log10().floor());
            ((tolerance_m / digit_m).round() * digit_m).clamp(least_m, most_m)
        })
    }

    /// Adds a body.
    pub fn add(&mut self, body: FreeBody) -> LinkIndex {
        let mechanism = self.mechanisms.next_key();
        let link = self.links.push_and_get_key(Link {
            name: body.name,
            body: body.body,
            shape: body.shape,
            shape_at_m: Vector3::zeros(),
            link_from_given: Pose::identity(),
            features: body.features,
            mechanism,
            held: None,
        });
        self.mechanisms.push(Mechanism::Free(link));
        self.tracks.push(Track {
            name: self.links[link].name.clone(),
            topic: body.topic,
            link,
            link_from_tracker: body.body_from_tracker,
            sees: Sees::Pose,
            weighing: Weighing::Scene,
        });
        link
    }

    /// Adds a contact law.
    pub fn add_law(&mut self, law: ContactLaw) -> ContactLawIndex {
        self.contact_laws.push_and_get_key(law)
    }

    /// The law of a collision.
    pub fn law_of(&self, collision: &Collision) -> &ContactLaw {
        &self.contact_laws[collision.law]
    }

    /// What the impact of a collision obeys, where nothing of it is free.
    pub fn impact_law(&self, collision: &Collision) -> Law {
        let of = self.law_of(collision);
        Law {
            restitution: of.restitution,
            friction: of.friction,
            tangential_restitution: of.tangential_restitution,
            tilt_rad: collision.tilt_rad,
        }
    }

    /// Whether a goal fixes the pose of a link at an event.
    pub fn fixes_pose(&self, event: usize, link: LinkIndex) -> bool {
        self.goals.iter().any(|goal| {
            let is_pose = matches!(goal.target, GoalTarget::Pose { .. });
            is_pose && goal.event == event && goal.link == link
        })
    }

    /// What moves with that link.
    pub fn mechanism_of(&self, link: LinkIndex) -> MechanismIndex {
        self.links[link].mechanism
    }

    /// A mechanism's name: that of its first link.
    pub fn name_of_mechanism(&self, mechanism: MechanismIndex) -> &str {
        let first = self.mechanisms[mechanism].links().next();
        &self.links[first.expect("a mechanism has links")].name
    }

    /// The link that moves by itself as a mechanism.
    ///
    /// # Panics
    /// Of a tree: what asks is about bodies by themselves.
    pub fn free_link(&self, mechanism: MechanismIndex) -> LinkIndex {
        let link = self.mechanisms[mechanism].free();
        link.expect("a body by itself")
    }

    /// The link that the tracker is mounted on.
    pub fn link_seen_by(&self, track: TrackIndex) -> &Link {
        &self.links[self.tracks[track].link]
    }

    /// Whether a link is in the hand ([`Link::held`]).
    pub fn is_held(&self, link: LinkIndex) -> bool {
        self.links[link].held.is_some()
    }

    /// Whether a mechanism is a link in the hand.
    pub fn is_held_mechanism(&self, mechanism: MechanismIndex) -> bool {
        let mut links = self.mechanisms[mechanism].links();
        links.any(|link| self.is_held(link))
    }

    /// Whether the motion of a mechanism is unknown and estimated here: it is neither held nor apart.
    pub fn moves(&self, mechanism: MechanismIndex) -> bool {
        !self.is_apart(mechanism) && !self.is_held_mechanism(mechanism)
    }

    /// Whether the tracker is mounted on what [moves](Self::moves).
    pub fn sees_moving(&self, track: TrackIndex) -> bool {
        self.moves(self.mechanism_seen_by(track))
    }

    /// Whether a mechanism is estimated by itself ([`Mechanism::Apart`]).
    pub fn is_apart(&self, mechanism: MechanismIndex) -> bool {
        matches!(self.mechanisms[mechanism], Mechanism::Apart(_))
    }

    /// Whether the tracker is mounted on what is apart.
    pub fn sees_apart(&self, track: TrackIndex) -> bool {
        self.is_apart(self.mechanism_seen_by(track))
    }

    /// Whether the tracker is mounted on a link in the hand.
    pub fn sees_held(&self, track: TrackIndex) -> bool {
        self.is_held(self.tracks[track].link)
    }

    /// The mechanism that the tracker is mounted on.
    pub fn mechanism_seen_by(&self, track: TrackIndex) -> MechanismIndex {
        self.mechanism_of(self.tracks[track].link)
    }

    /// The tracks that see a mechanism.
    pub fn tracks_of(&self, mechanism: MechanismIndex) -> impl Iterator<Item = TrackIndex> + '_ {
        let tracks = self.tracks.keys();
        tracks.filter(move |track| self.mechanism_seen_by(*track) == mechanism)
    }

    /// Whether a link of the mechanism touches in the collision.
    pub fn takes_part(&self, mechanism: MechanismIndex, collision: &Collision) -> bool {
        let mut links = collision.links();
        links.any(|link| self.mechanism_of(link) == mechanism)
    }

    /// Whether the event begins or ends a flight of the mechanism: its own collisions do, and the
    /// performance's start and end, and changes of its phase. A waypoint is within one.
    pub fn concerns(&self, event: usize, mechanism: MechanismIndex) -> bool {
        let kind = &self.events[event].kind;
        let collision = kind.collision();
        let is_of_it = |link: LinkIndex| self.mechanism_of(link) == mechanism;
        kind.waypoint().is_none()
            && (kind.change().is_none_or(is_of_it) || self.sticks(event, mechanism))
            && collision.is_none_or(|collision| self.takes_part(mechanism, collision))
    }

    /// The tracks that see what takes part in a collision and flies, those of what hits first.
    pub fn tracks_in(&self, collision: &Collision) -> impl Iterator<Item = TrackIndex> + use<'_> {
        self.tracks_of_links(collision.links())
    }

    /// The tracks that see some links and what moves with them, where that flies.
    pub(in crate::motion) fn tracks_of_links(
        &self,
        links: impl Iterator<Item = LinkIndex>,
    ) -> impl Iterator<Item = TrackIndex> {
        let mechanisms = links.map(|link| self.mechanism_of(link));
        mechanisms.flat_map(move |mechanism| {
            let is_its = move |track: &TrackIndex| {
                self.mechanism_seen_by(*track) == mechanism && self.moves(mechanism)
            };
            self.tracks.keys().filter(is_its)
        })
    }

    /// Whether the time of an event is estimated, unless it stays at its mark. Where the event does
    /// not say, that of a collision or a waypoint is; that of an end where a goal holds there and the tempo is
    /// unknown; that of a start is not.
    pub fn time_is_free(&self, event: usize) -> bool {
        let of = &self.events[event];
        let has_goal = || self.goals.iter().any(|goal| goal.event == event);
        of.time.is_free.unwrap_or_else(|| match of.kind {
            EventKind::Collision(_)
            | EventKind::Collisions { .. }
            | EventKind::Change(_)
            | EventKind::Waypoint(_) => true,
            EventKind::Start => false,
            EventKind::End => matches!(self.timing, Timing::Unknown { .. }) && has_goal(),
        })
    }

    /// The body that moves by itself as a mechanism.
    ///
    /// # Panics
    /// Of a tree; see [`Scene::tree_model`].
    pub fn body_of(&self, mechanism: MechanismIndex) -> &Body {
        &self.links[self.free_link(mechanism)].body
    }

    /// Streams of poses that a track has: one; in an edited sketch one per segment, and the
    /// collisions of the tracked mechanism part its segments.
    pub fn streams(&self, track: TrackIndex) -> usize {
        let mechanism = self.mechanism_seen_by(track);
        let is_cut = |event: &&Event| {
            let collision = event.kind.collision();
            collision.is_some_and(|collision| self.takes_part(mechanism, collision))
        };
        match self.timing {
            Timing::Edited => 1 + self.events.iter().filter(is_cut).count(),
            Timing::Known | Timing::Unknown { .. } => 1,
        }
    }

    /// Topic of one of a track's streams: the track's own; in an edited sketch that with `/1`,
    /// `/2`, … after it.
    pub fn stream_topic(&self, track: TrackIndex, stream: usize) -> String {
        let topic = &self.tracks[track].topic;
        match self.timing {
            Timing::Edited => format!("{topic}/{}", stream + 1),
            Timing::Known | Timing::Unknown { .. } => topic.clone(),
        }
    }

    /// The name of something with which a body may collide.
    pub fn name_of(&self, against: Against) -> &str {
        match against {
            Against::Surface(surface) => &self.surfaces[surface].name,
            Against::Obstacle(obstacle) => &self.obstacles[obstacle].name,
            Against::Link(link) => &self.links[link].name,
        }
    }
}
