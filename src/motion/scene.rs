//! The scene: bodies, static world, expected events, goals, free parameters, weights.
//!
//! Plain validated data in SI units. `config` makes it from TOML; the stages do not check it again.

use nalgebra::Vector3;
use thiserror::Error;
use typed_index_collections::TiVec;

use super::index::{LinkIndex, MechanismIndex, TrackIndex};
use crate::math::Pose;
use crate::physics::contact::{self, Contact, ContactError};
use crate::physics::impact::{ContactSet, ContactSetError};
use crate::physics::{Body, Dynamics, Shape};

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
    /// What happens, in order of time.
    pub events: Vec<Event>,
    /// Goals: hard conditions at events (paper §3.1).
    pub goals: Vec<Goal>,
    /// Free parameters `u` of the estimation.
    pub parameters: Vec<FreeParameter>,
    /// Pairs of parameters whose norm is bounded: tilts of a normal within a cone.
    pub cones: Vec<Cone>,
    /// Whether velocities after collisions may differ from those by the impact law.
    pub velocity_gaps: VelocityGaps,
    /// Units of residuals.
    pub weights: Weights,
    /// Longest simulation after the motion's end until it rests \[s\] (paper §6.2.3); `None`: the
    /// motion ends with the performance.
    pub settle_s: Option<f64>,
}

/// Something with which a body may collide.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Against {
    /// A plane that stands for itself (index into `Scene::surfaces`).
    Surface(usize),
    /// A solid part of the static world (index into `Scene::obstacles`).
    Obstacle(usize),
    /// Another link.
    Link(LinkIndex),
}

impl Scene {
    /// The name of something with which a body may collide.
    pub fn name_of(&self, against: Against) -> &str {
        match against {
            Against::Surface(surface) => &self.surfaces[surface].name,
            Against::Obstacle(obstacle) => &self.obstacles[obstacle].name,
            Against::Link(link) => &self.links[link].name,
        }
    }
}

impl Scene {
    /// The contacts of a collision; `None` where the scene leaves a feature open, or where the
    /// event is no collision.
    ///
    /// Fails where two features are no supported pair, or their impact is not supported.
    pub fn contact_set(&self, event: usize) -> Result<Option<ContactSet>, CollisionError> {
        match self.events[event].kind.collision() {
            Some(collision) => self.contact_set_of(event, &collision.contacts),
            None => Ok(None),
        }
    }

    /// [`Scene::contact_set`] with the given contacts in place of the collision's.
    pub fn contact_set_of(
        &self,
        event: usize,
        touchings: &[Touching],
    ) -> Result<Option<ContactSet>, CollisionError> {
        let Some(collision) = self.events[event].kind.collision() else {
            return Ok(None);
        };
        let mut contacts = Vec::new();
        for touching in touchings {
            let (Some(feature), Some(other)) = (touching.feature, touching.other) else {
                return Ok(None);
            };
            let feature = self.links[collision.link].features[feature].geometry;
            let other = match collision.partner {
                Partner::World => self.surfaces[other].geometry,
                Partner::Link(link) => self.links[link].features[other].geometry,
            };
            contacts.push(Contact::new(feature, other)?);
        }
        let frees = |quantity: fn(usize) -> Quantity| {
            let quantity = quantity(event);
            self.parameters.iter().any(|free| free.quantity == quantity)
        };
        let is_tilted = frees(|event| Quantity::Tilt { event, tangent: 0 })
            || frees(|event| Quantity::Tilt { event, tangent: 1 });
        let has_friction = collision.friction > 0.0 || frees(|event| Quantity::Friction { event });
        let set = if has_friction {
            ContactSet::with_friction(&contacts)?
        } else {
            ContactSet::frictionless(&contacts)?
        };
        if is_tilted {
            set.check_tilt()?;
        }
        Ok(Some(set))
    }

    /// Adds a body that flies freely.
    pub fn add(&mut self, body: FreeBody) -> LinkIndex {
        let mechanism = self.mechanisms.next_key();
        let link = self.links.push_and_get_key(Link {
            name: body.name,
            body: body.body,
            shape: body.shape,
            features: body.features,
            mechanism,
        });
        self.mechanisms.push(Mechanism::Free(link));
        self.tracks.push(Track {
            topic: body.topic,
            link,
            link_from_tracker: body.body_from_tracker,
        });
        link
    }

    /// What moves with that link.
    pub fn mechanism_of(&self, link: LinkIndex) -> MechanismIndex {
        self.links[link].mechanism
    }

    /// A mechanism's name: that of its link.
    pub fn name_of_mechanism(&self, mechanism: MechanismIndex) -> &str {
        let Mechanism::Free(link) = self.mechanisms[mechanism];
        &self.links[link].name
    }

    /// The link that the tracker is mounted on.
    pub fn link_seen_by(&self, track: TrackIndex) -> &Link {
        &self.links[self.tracks[track].link]
    }

    /// The mechanism that the tracker is mounted on.
    pub fn mechanism_seen_by(&self, track: TrackIndex) -> MechanismIndex {
        self.mechanism_of(self.tracks[track].link)
    }

    /// Whether a link of the mechanism touches in the collision.
    pub fn takes_part(&self, mechanism: MechanismIndex, collision: &Collision) -> bool {
        let mut links = collision.links();
        links.any(|link| self.mechanism_of(link) == mechanism)
    }

    /// Whether the event begins or ends a flight of the mechanism: its own collisions do, and the
    /// performance's start and end.
    pub fn concerns(&self, event: usize, mechanism: MechanismIndex) -> bool {
        let collision = self.events[event].kind.collision();
        collision.is_none_or(|collision| self.takes_part(mechanism, collision))
    }

    /// The tracks that see what takes part in a collision, those of what hits first.
    pub fn tracks_in(&self, collision: &Collision) -> impl Iterator<Item = TrackIndex> + use<'_> {
        let mechanisms = collision.links().map(|link| self.mechanism_of(link));
        mechanisms.flat_map(move |mechanism| {
            let is_its = move |track: &TrackIndex| self.mechanism_seen_by(*track) == mechanism;
            self.tracks.keys().filter(is_its)
        })
    }

    /// The equations of motion of a mechanism.
    pub fn dynamics(&self, mechanism: MechanismIndex) -> Dynamics {
        let Mechanism::Free(link) = self.mechanisms[mechanism];
        Dynamics::Free(self.links[link].body)
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
}

/// Why the collision of a scene is refused.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum CollisionError {
    /// Two features are no supported pair.
    #[error(transparent)]
    Contact(#[from] ContactError),
    /// The contacts together are not supported.
    #[error(transparent)]
    ContactSet(#[from] ContactSetError),
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

/// A rigid body.
#[derive(Clone, Debug, PartialEq)]
pub struct Link {
    /// Unique name.
    pub name: String,
    /// Mass and principal moments; the link's axes are principal axes at its centre of mass.
    pub body: Body,
    /// Shape in the link's axes.
    pub shape: Shape,
    /// What of it may touch something.
    pub features: Vec<Feature>,
    /// What it moves with.
    pub mechanism: MechanismIndex,
}

/// What moves as one system of ordinary differential equations between its collisions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mechanism {
    /// One rigid body in free flight.
    Free(LinkIndex),
}

impl Mechanism {
    /// Its links.
    pub fn links(&self) -> impl Iterator<Item = LinkIndex> + use<> {
        let Mechanism::Free(link) = *self;
        std::iter::once(link)
    }
}

/// What one tracker sees.
#[derive(Clone, Debug, PartialEq)]
pub struct Track {
    /// Topic that carries the tracker's poses; see [`Scene::stream_topic`].
    pub topic: String,
    /// The link that it is mounted on.
    pub link: LinkIndex,
    /// Pose of the tracker's frame in the link's axes.
    pub link_from_tracker: Pose,
}

/// A rigid body that flies freely with a tracker on it: a link, a mechanism and a track in one.
#[derive(Clone, Debug, PartialEq)]
pub struct FreeBody {
    /// Unique name.
    pub name: String,
    /// Topic that carries its tracker's poses.
    pub topic: String,
    /// Mass and principal moments; its axes are principal axes at the centre of mass.
    pub body: Body,
    /// Shape in its axes.
    pub shape: Shape,
    /// Pose of the tracker's frame in its axes.
    pub body_from_tracker: Pose,
    /// Its features that may touch something.
    pub features: Vec<Feature>,
}

/// A named part of a link's surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Feature {
    /// Name, unique within the link.
    pub name: String,
    /// Geometry in link axes.
    pub geometry: contact::Feature,
}

/// A named part of the static world's surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    /// Unique name.
    pub name: String,
    /// Geometry in world axes.
    pub geometry: contact::Feature,
    /// The obstacle to which it belongs (index into `Scene::obstacles`); `None` for a plane by
    /// itself.
    pub obstacle: Option<usize>,
}

impl Surface {
    /// A point and the unit normal of a plane that belongs to no obstacle; `None` for other
    /// surfaces.
    pub fn plane(&self) -> Option<(Vector3<f64>, Vector3<f64>)> {
        match (self.geometry, self.obstacle) {
            (contact::Feature::Face { point_m, normal }, None) => Some((point_m, normal)),
            _ => None,
        }
    }
}

/// A solid part of the static world.
#[derive(Clone, Debug, PartialEq)]
pub struct Obstacle {
    /// Unique name.
    pub name: String,
    /// Its shape.
    pub shape: Shape,
    /// Its pose.
    pub world_from_shape: Pose,
}

/// Something that happens at one instant and is marked by the performer.
#[derive(Clone, Debug, PartialEq)]
pub struct Event {
    /// Unique name; marks may refer to it.
    pub name: String,
    /// What happens.
    pub kind: EventKind,
}

/// The kinds of event.
#[derive(Clone, Debug, PartialEq)]
pub enum EventKind {
    /// The performance begins; samples before it are not used. Only as the first event.
    Start,
    /// A body hits something.
    Collision(Collision),
    /// A collision that repeats as often as there are marks; each becomes an event of its own
    /// before a take is read ([`Scene::with_marks`]).
    Collisions {
        /// Each of the collisions.
        each: Collision,
        /// Least number, one or more.
        least: usize,
        /// Greatest number.
        most: usize,
    },
    /// The performance ends; samples after it are not used. Only as the last event. Its time
    /// is estimated when a goal holds there, otherwise it stays at the mark.
    End,
}

impl EventKind {
    /// Its name in files and reports.
    pub fn as_str(&self) -> &'static str {
        match self {
            EventKind::Start => "start",
            EventKind::Collision(_) | EventKind::Collisions { .. } => "collision",
            EventKind::End => "end",
        }
    }

    /// The collision, if it is one.
    pub fn collision(&self) -> Option<&Collision> {
        match self {
            EventKind::Collision(collision) => Some(collision),
            EventKind::Start | EventKind::Collisions { .. } | EventKind::End => None,
        }
    }
}

/// A link hits the static world or a link of another mechanism.
#[derive(Clone, Debug, PartialEq)]
pub struct Collision {
    /// What hits something.
    pub link: LinkIndex,
    /// What it hits.
    pub partner: Partner,
    /// Their contacts, one to three at once.
    pub contacts: Vec<Touching>,
    /// Coefficient of restitution, 0 to 1.
    pub restitution: f64,
    /// Coefficient of Coulomb friction.
    pub friction: f64,
}

impl Collision {
    /// A bounce of one feature off one surface, without friction.
    pub fn bounce(link: LinkIndex, feature: usize, surface: usize, restitution: f64) -> Self {
        Self {
            link,
            partner: Partner::World,
            contacts: vec![Touching {
                feature: Some(feature),
                other: Some(surface),
            }],
            restitution,
            friction: 0.0,
        }
    }

    /// The links that touch in it.
    pub fn links(&self) -> impl Iterator<Item = LinkIndex> + use<> {
        let other = match self.partner {
            Partner::World => None,
            Partner::Link(other) => Some(other),
        };
        [self.link].into_iter().chain(other)
    }
}

/// What a link hits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Partner {
    /// The static world.
    World,
    /// Another link.
    Link(LinkIndex),
}

/// Which feature touches which; what a scene leaves open is inferred from the performance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Touching {
    /// Index into the body's features.
    pub feature: Option<usize>,
    /// Index into `Scene::surfaces`, or into the other body's features.
    pub other: Option<usize>,
}

/// A goal (paper §3.1): a hard condition on a link at an event (just before it, if it is a
/// collision).
#[derive(Clone, Debug, PartialEq)]
pub struct Goal {
    /// Index into `Scene::events`.
    pub event: usize,
    /// The link that it is asked of.
    pub link: LinkIndex,
    /// The condition.
    pub target: GoalTarget,
}

/// The condition of a goal.
#[derive(Clone, Debug, PartialEq)]
pub enum GoalTarget {
    /// The link's pose.
    Pose {
        /// Pose of the link's axes, at its centre of mass.
        world_from_body: Pose,
    },
    /// The centre of mass inside an axis-aligned box; equal bounds fix a coordinate, infinite
    /// ones leave it free [m, world].
    PositionWithin {
        /// Lower corner.
        lower_m: Vector3<f64>,
        /// Upper corner.
        upper_m: Vector3<f64>,
    },
}

/// A free parameter `u`: a quantity that the estimation may change, within bounds (paper §6).
#[derive(Clone, Debug, PartialEq)]
pub struct FreeParameter {
    /// Unique name, as in the scene file: `gravity.z`, `bounce.restitution`.
    pub name: String,
    /// The quantity.
    pub quantity: Quantity,
    /// Value to start from, in the quantity's unit.
    pub initial: f64,
    /// Least value allowed (may be −∞).
    pub lower: f64,
    /// Greatest value allowed (may be +∞).
    pub upper: f64,
    /// Standard deviation of a prior about `initial`, if there is one.
    pub prior_sd: Option<f64>,
}

impl FreeParameter {
    /// A typical change of it: its prior's standard deviation or the width of its bounds, whichever
    /// is less; one where it has neither.
    pub fn length(&self) -> f64 {
        let width = self.upper - self.lower;
        let width = if width > 0.0 && width.is_finite() {
            width
        } else {
            1.0
        };
        self.prior_sd.unwrap_or(width).min(width)
    }
}

/// The quantities that may be free.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// A component of gravity [m/s²]: axis 0, 1, 2.
    Gravity {
        /// World axis.
        axis: usize,
    },
    /// Restitution at a collision [–].
    Restitution {
        /// Index into `Scene::events`.
        event: usize,
    },
    /// Friction at a collision [–].
    Friction {
        /// Index into `Scene::events`.
        event: usize,
    },
    /// Tilt of the surface's normal at a collision \[rad\] about one of two tangents.
    Tilt {
        /// Index into `Scene::events`.
        event: usize,
        /// Tangent, 0 or 1.
        tangent: usize,
    },
}

impl Quantity {
    /// The event to which it belongs (index into `Scene::events`); `None` for gravity.
    pub fn event(self) -> Option<usize> {
        match self {
            Quantity::Gravity { .. } => None,
            Quantity::Restitution { event }
            | Quantity::Friction { event }
            | Quantity::Tilt { event, .. } => Some(event),
        }
    }

    /// The quantity at another event; gravity is unchanged.
    pub fn at_event(self, moved: impl Fn(usize) -> usize) -> Self {
        match self {
            Quantity::Gravity { .. } => self,
            Quantity::Restitution { event } => Quantity::Restitution {
                event: moved(event),
            },
            Quantity::Friction { event } => Quantity::Friction {
                event: moved(event),
            },
            Quantity::Tilt { event, tangent } => Quantity::Tilt {
                event: moved(event),
                tangent,
            },
        }
    }
}

/// Two parameters within a circle about zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone {
    /// Indices into `Scene::parameters`.
    pub parameters: [usize; 2],
    /// Radius of the circle, in the parameters' unit.
    pub limit: f64,
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

/// Units of residuals: the objective (paper eq. 1) is the sum of squared residuals in these units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weights {
    /// Position \[m\].
    pub position_m: f64,
    /// Orientation \[rad\].
    pub orientation_rad: f64,
}
